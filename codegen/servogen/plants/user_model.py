"""A user's own model: a Python file with a function that returns a ``SymbolicModel``."""

from __future__ import annotations

import sys
import types
from collections.abc import Mapping
from pathlib import Path

from servogen.plants.errors import PlantError
from servogen.plants.motion import to_motion_states
from servogen.plants.statespace import StateSpace
from servogen.plants.symbolic import SymbolicModel, linearise, parameter_vector

_MODULE = "servogen_user_model"


def load_user_model(file: Path, function: str, parameters: Mapping[str, float]) -> SymbolicModel:
    """Run ``file`` and call its ``function`` (no arguments); check the ``parameters`` it is given.

    The file is trusted: it runs with the user's rights, as any script of theirs does. Nothing is
    written beside it.

    Raises:
        PlantError: file missing or failing, function missing or failing, a result of another
            type, or parameters that do not match.
    """
    try:
        source = Path(file).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise PlantError("file", file, "a Python file that can be read") from error
    module = types.ModuleType(_MODULE)
    sys.modules[_MODULE] = module  # a dataclass of theirs looks itself up there
    try:
        exec(compile(source, str(file), "exec", dont_inherit=True), module.__dict__)
    except (Exception, SystemExit) as error:
        raise PlantError("file", file, f"a Python file that runs ({_first_line(error)})") from error
    finally:
        del sys.modules[_MODULE]
    call = getattr(module, function, None)
    if not callable(call):
        raise PlantError("function", function, f"a function of {Path(file).name}")
    try:
        model = call()
    except (Exception, SystemExit) as error:
        expected = f"a function without arguments that returns a model ({_first_line(error)})"
        raise PlantError("function", function, expected) from error
    if not isinstance(model, SymbolicModel):
        kind = type(model).__name__
        raise PlantError("function", f"{function}, returning {kind}", "a SymbolicModel returned")
    parameter_vector(model, parameters)
    return model


def user_plant(file: Path, function: str, parameters: Mapping[str, float]) -> StateSpace:
    """The user's model linearised about rest at zero, in motion states.

    Raises:
        PlantError: as ``load_user_model``, ``linearise`` and ``to_motion_states``.
    """
    model = load_user_model(file, function, parameters)
    return to_motion_states(linearise(model, parameters))


def _first_line(error: BaseException) -> str:
    lines = str(error).splitlines()
    return f"{type(error).__name__}: {lines[0]}" if lines else type(error).__name__
