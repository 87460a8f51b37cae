"""A slow stage of your own: a belt axis, as CasADi expressions.

Name this file in servogen.toml in place of ``model = "servo"``:

    [machine.x.slow]
    model = "python"
    file = "my_model_example.py"
    function = "belt_axis"
    parameters = { motor_mass_kg = 20.0, load_mass_kg = 15.0, stiffness_n_per_m = 2.0e6, \
damper_n_s_per_m = 500.0, bandwidth_rad_per_s = 45.0, damping = 0.8 }

servogen linearises it about rest, takes it to position, velocity, acceleration (and one more
state here) and discretises it. It must be stable and come to rest where it is told to.
"""

import casadi as ca

from servogen.plants.symbolic import SymbolicModel


def belt_axis() -> SymbolicModel:
    """A motor in a position loop pulls the load along through a belt."""
    states = {
        name: ca.SX.sym(name)
        for name in ("motor_position", "motor_velocity", "load_position", "load_velocity")
    }
    inputs = {"command": ca.SX.sym("command")}
    parameters = {
        name: ca.SX.sym(name)
        for name in (
            "motor_mass_kg",
            "load_mass_kg",
            "stiffness_n_per_m",
            "damper_n_s_per_m",
            "bandwidth_rad_per_s",
            "damping",
        )
    }
    motor, load, stiffness, damper, w, zeta = parameters.values()
    x1, v1, x2, v2 = states.values()

    drive = (motor + load) * (w**2 * (inputs["command"] - x1) - 2 * zeta * w * v1)
    belt = stiffness * (x1 - x2) + damper * (v1 - v2)
    dynamics = {
        "motor_position": v1,
        "motor_velocity": (drive - belt) / motor,
        "load_position": v2,
        "load_velocity": belt / load,
    }
    return SymbolicModel(states, inputs, parameters, dynamics, output=x2)
