"""From the settings of a stage to its state space in position, velocity and acceleration."""

from __future__ import annotations

import numpy as np

from servogen.plants.errors import PlantError
from servogen.plants.motion import to_motion_states
from servogen.plants.servo import servo
from servogen.plants.settings import (
    PythonSettings,
    ServoSettings,
    StageSettings,
    StateSpaceSettings,
    TransferFunctionSettings,
)
from servogen.plants.statespace import StateSpace
from servogen.plants.transfer import transfer_function

# The commanded position is where the stage comes to rest. A gain off by this much is 0.4 um at the
# end of a 0.4 m axis, below every tolerance of a path; anything more is a mistake in the model.
DC_GAIN_TOLERANCE = 1e-6


def build_stage(settings: StageSettings) -> StateSpace:
    """The model of one stage with states p, v, a (and further); stable and of unit dc gain.

    A gain within ``DC_GAIN_TOLERANCE`` of one (coefficients typed with few digits) is made one.

    Raises:
        PlantError: whatever is wrong with the model; see its parts.
    """
    model = _model(settings)
    if not model.is_stable:
        worst = float(np.max(model.poles.real))
        raise PlantError(
            _key(settings),
            f"unstable (a pole at {worst:.6g} rad/s)",
            "a stable stage, every pole left of the imaginary axis",
        )
    gain = model.dc_gain
    if not abs(gain - 1.0) <= DC_GAIN_TOLERANCE:
        raise PlantError(_key(settings), f"of dc gain {gain:.9g}", "dc gain 1")
    # with (1, 0, 0, ...) at rest a + b = 0 in the first column: unit gain to the last digit
    return StateSpace(model.a, 0.0 - model.a[:, 0], model.c)


def slow_plant(settings: StageSettings) -> StateSpace:
    """The slow stage; see ``build_stage``."""
    return build_stage(settings)


def fast_plant(settings: StageSettings) -> StateSpace:
    """The fast stage; see ``build_stage``."""
    return build_stage(settings)


def _model(settings: StageSettings) -> StateSpace:
    match settings:
        case ServoSettings():
            return servo(settings.bandwidth_rad_per_s, settings.damping)
        case TransferFunctionSettings():
            return transfer_function(settings.numerator, settings.denominator)
        case StateSpaceSettings():
            return to_motion_states(_matrices(settings))
        case PythonSettings():
            # CasADi takes a second to import; only a user's own model pays for it
            from servogen.plants.user_model import user_plant

            return user_plant(settings.file, settings.function, settings.parameters)


def _matrices(settings: StateSpaceSettings) -> StateSpace:
    n = len(settings.a)
    for row in settings.a:
        if len(row) != n:
            raise PlantError("a", f"a row of {len(row)} numbers", f"{n} numbers, one per row")
    return StateSpace(np.array(settings.a), np.array(settings.b), np.array(settings.c))


def _key(settings: StageSettings) -> str:
    match settings:
        case ServoSettings():
            return "damping"
        case TransferFunctionSettings():
            return "denominator"
        case StateSpaceSettings():
            return "a"
        case PythonSettings():
            return "file"
