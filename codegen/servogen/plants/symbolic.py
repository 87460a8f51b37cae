"""Models as CasADi expressions: named states, inputs and parameters, linearised from there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from servogen.plants.errors import PlantError
from servogen.plants.statespace import FloatArray, StateSpace

# Newton's last step, relative to the size of the point found: an equilibrium known worse than this
# would move the linearisation by more than its own rounding.
EQUILIBRIUM_TOLERANCE = 1e-9

Expression = Any  # casadi.SX; CasADi carries no type information


@dataclass(frozen=True)
class SymbolicModel:
    """d(state)/dt = dynamics, output = position, as expressions of named scalar symbols.

    Args:
        states: name -> symbol, in the order the state vector has.
        inputs: name -> symbol; exactly one, the position command, m.
        parameters: name -> symbol; given values when the model is linearised.
        dynamics: state name -> time derivative.
        output: the position of the tool end, m.

    Raises:
        PlantError: names that do not match, not exactly one input, something that is not a scalar
            expression, or a symbol that was never declared.
    """

    states: Mapping[str, Expression]
    inputs: Mapping[str, Expression]
    parameters: Mapping[str, Expression]
    dynamics: Mapping[str, Expression]
    output: Expression

    def __post_init__(self) -> None:
        if not self.states:
            raise PlantError("states", "empty", "at least one state")
        if len(self.inputs) != 1:
            raise PlantError("inputs", list(self.inputs), "exactly one, the position command")
        if set(self.dynamics) != set(self.states):
            odd = sorted(set(self.dynamics) ^ set(self.states))
            raise PlantError("dynamics", f"at odds with states over {odd}", "one entry per state")
        for table in (self.states, self.inputs, self.parameters):
            for name, symbol in table.items():
                if not (isinstance(symbol, ca.SX) and symbol.is_symbolic() and symbol.is_scalar()):
                    raise PlantError(name, symbol, "a scalar casadi.SX.sym")
        self._check_symbols()

    def _check_symbols(self) -> None:
        declared = {
            symbol.__hash__()
            for table in (self.states, self.inputs, self.parameters)
            for symbol in (leaf for value in table.values() for leaf in ca.symvar(value))
        }
        for name, value in {**self.dynamics, "output": self.output}.items():
            if not (isinstance(value, ca.SX | float | int) and ca.SX(value).is_scalar()):
                raise PlantError(name, value, "a scalar expression")
            for leaf in ca.symvar(ca.SX(value)):
                if leaf.__hash__() not in declared:
                    raise PlantError(name, f"using {leaf}", "only declared symbols")


def _vector(table: Mapping[str, Expression]) -> Expression:
    return ca.vertcat(*table.values()) if table else ca.SX(0, 1)


def parameter_vector(model: SymbolicModel, values: Mapping[str, float]) -> FloatArray:
    """The values in the model's own order.

    Raises:
        PlantError: a parameter missing, unknown, or not a finite number.
    """
    for name in values:
        if name not in model.parameters:
            raise PlantError(f"parameters.{name}", values[name], f"one of {list(model.parameters)}")
    vector = np.zeros(len(model.parameters))
    for i, name in enumerate(model.parameters):
        if name not in values:
            raise PlantError(f"parameters.{name}", "missing", "a number")
        value = values[name]
        if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
            raise PlantError(f"parameters.{name}", value, "a finite number")
        vector[i] = value
    return vector


def equilibrium(
    model: SymbolicModel, values: Mapping[str, float], command_m: float = 0.0
) -> FloatArray:
    """States (n,) at which the model rests under a constant command, by Newton's method from zero.

    Raises:
        PlantError: parameters as in ``parameter_vector``, or no equilibrium found.
    """
    x, u, p = _vector(model.states), _vector(model.inputs), _vector(model.parameters)
    slopes = ca.vertcat(*(model.dynamics[name] for name in model.states))
    parameters = parameter_vector(model, values)
    known = np.append(parameters, command_m)
    residual = ca.Function("residual", [x, ca.vertcat(p, u)], [slopes])
    jacobian = ca.Function("jacobian", [x, ca.vertcat(p, u)], [ca.jacobian(slopes, x)])
    # abstol 0 would never be met and the step test decides: residuals carry units up to m/s^3
    options = {"abstol": 1e-300, "abstolStep": 1e-13, "max_iter": 100, "error_on_fail": False}
    try:  # both the construction (structurally singular) and the call can refuse
        solver = ca.rootfinder("rest", "newton", residual, options)
        point = np.asarray(solver(np.zeros(x.numel()), known), dtype=np.float64).ravel()
        left = np.asarray(residual(point, known), dtype=np.float64).ravel()
        step = np.linalg.solve(np.asarray(jacobian(point, known), dtype=np.float64), left)
    except (RuntimeError, np.linalg.LinAlgError) as error:
        raise _no_rest(command_m) from error
    size = EQUILIBRIUM_TOLERANCE * max(1.0, float(np.max(np.abs(point))))
    if not (np.all(np.isfinite(point)) and np.max(np.abs(step)) <= size):
        raise _no_rest(command_m)
    return np.where(np.abs(point) <= np.finfo(np.float64).tiny, 0.0, point)


def _no_rest(command_m: float) -> PlantError:
    what = f"without a resting point at command {command_m:g} m"
    return PlantError("model", what, "a model that comes to rest under a constant command")


def linearise(
    model: SymbolicModel, values: Mapping[str, float], command_m: float = 0.0
) -> StateSpace:
    """The linear model about the resting point at ``command_m``, in the model's own states.

    Raises:
        PlantError: no resting point, or derivatives that are not finite there.
    """
    point = equilibrium(model, values, command_m)
    x, u, p = _vector(model.states), _vector(model.inputs), _vector(model.parameters)
    slopes = ca.vertcat(*(model.dynamics[name] for name in model.states))
    output = ca.SX(model.output)
    derivatives = ca.Function(
        "derivatives",
        [x, u, p],
        [ca.jacobian(slopes, x), ca.jacobian(slopes, u), ca.jacobian(output, x)],
    )
    if ca.depends_on(output, u):
        raise PlantError("output", model.output, "an output that does not contain the command")
    a, b, c = (
        np.asarray(part, dtype=np.float64)
        for part in derivatives(point, command_m, parameter_vector(model, values))
    )
    return StateSpace(a, b.ravel(), c.ravel())
