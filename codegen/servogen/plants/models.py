"""Ready-made models as CasADi expressions: a servo loop, and a servo that drives a spring."""

from __future__ import annotations

import casadi as ca

from servogen.plants.symbolic import Expression, SymbolicModel


def _symbols(*names: str) -> dict[str, Expression]:
    return {name: ca.SX.sym(name) for name in names}


def servo_model() -> SymbolicModel:
    """The third-order servo loop of ``plants.servo``, as expressions.

    Parameters: ``bandwidth_rad_per_s``, ``damping``.
    """
    states = _symbols("position", "velocity", "acceleration")
    inputs = _symbols("command")
    parameters = _symbols("bandwidth_rad_per_s", "damping")
    w, zeta = parameters["bandwidth_rad_per_s"], parameters["damping"]
    p, v, a = states.values()
    jerk = w**3 * (inputs["command"] - p) - (1 + 2 * zeta) * (w**2 * v + w * a)
    dynamics = {"position": v, "velocity": a, "acceleration": jerk}
    return SymbolicModel(states, inputs, parameters, dynamics, p)


def two_mass_servo_model() -> SymbolicModel:
    """A motor in a position loop that moves the load through a spring and a damper: order four.

    The motor's loop is proportional with velocity feedback and sized for the whole mass; the
    output is the load's position. Unit dc gain, relative degree three.

    Parameters: ``motor_mass_kg``, ``load_mass_kg``, ``stiffness_n_per_m``,
    ``damper_n_s_per_m``, ``bandwidth_rad_per_s``, ``damping``.
    """
    states = _symbols("motor_position", "motor_velocity", "load_position", "load_velocity")
    inputs = _symbols("command")
    parameters = _symbols(
        "motor_mass_kg",
        "load_mass_kg",
        "stiffness_n_per_m",
        "damper_n_s_per_m",
        "bandwidth_rad_per_s",
        "damping",
    )
    motor, load, stiffness, damper, w, zeta = parameters.values()
    x1, v1, x2, v2 = states.values()
    drive = (motor + load) * (w**2 * (inputs["command"] - x1) - 2 * zeta * w * v1)
    spring = stiffness * (x1 - x2) + damper * (v1 - v2)
    dynamics = {
        "motor_position": v1,
        "motor_velocity": (drive - spring) / motor,
        "load_position": v2,
        "load_velocity": spring / load,
    }
    return SymbolicModel(states, inputs, parameters, dynamics, x2)
