"""Spatial reference governor (14)-(15), step by step; see ``governor_design`` for its argument."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from servogen.controllers.arithmetic import cast, check_port
from servogen.controllers.design import Status, Value
from servogen.controllers.governor_design import AXES, GovernorDesign, declare_governor
from servogen.precision import FloatArray
from servogen.qp.ordered import matvec


class Governor:
    """Reference of the emitted governor, bit for bit."""

    def __init__(self, design: GovernorDesign) -> None:
        self.design = design
        self.declaration = declare_governor(design)
        p = design.precision
        self._real = p.dtype.type
        self._rows = [cast(s.rows.T, p) for s in design.sections]
        self._shift = [cast(s.shift, p) for s in design.sections]
        self._bound = [cast(s.bound, p) for s in design.sections]
        self._ahead = [cast(s.ahead[:, None], p) for s in design.sections]
        self._ahead_r = [p.dtype.type(s.ahead_reference) for s in design.sections]
        self._range = [p.dtype.type(lim.fast_range_m) for lim in design.limits]

    def call(
        self, operation: str, inputs: Mapping[str, Value] | None = None
    ) -> tuple[Status, dict[str, Value]]:
        given = inputs or {}
        n = self.design.order
        declared = self.declaration.operation(operation).inputs
        n_points = int(np.asarray(given["n_points"]))
        precision = self.design.precision
        status = max(check_port(port, given[port.name], precision) for port in declared)
        dtype = precision.dtype
        states = [
            np.array([given[port.name] for port in declared[i * n : (i + 1) * n]], dtype=dtype)
            for i in range(2)
        ]
        last = [dtype.type(given[f"last_{axis}"]) for axis in AXES]
        if status is not Status.OK:
            last = [self._bounded(i, value) for i, value in enumerate(last)]
            return status, self._outputs(0, last, last, last)
        points = [np.asarray(given[f"points_{axis}"], dtype=dtype) for axis in AXES]
        return self.step(states, last, points, n_points)

    def _bounded(self, i: int, value: np.floating) -> np.floating:
        """Within the position limit, whatever it is; a NaN becomes the lower limit, as in the C."""
        limit = self._real(self.design.limits[i].position_m)
        bounded: np.floating = min(value if value > -limit else -limit, limit)
        return bounded

    @staticmethod
    def _outputs(
        taken: int, reference: list[np.floating], low: list[np.floating], high: list[np.floating]
    ) -> dict[str, Value]:
        outputs: dict[str, Value] = {"points_taken": taken}
        for i, axis in enumerate(AXES):
            outputs[f"reference_{axis}"] = reference[i]
            outputs[f"low_{axis}"] = low[i]
            outputs[f"high_{axis}"] = high[i]
        return outputs

    def step(
        self,
        states: list[FloatArray],
        last: list[np.floating],
        points: list[FloatArray],
        n_points: int,
    ) -> tuple[Status, dict[str, Value]]:
        """States (n,) and points (M,) per axis, absolute; decremental search over eta."""
        paths = [np.append(last[i], points[i][:n_points]).astype(self._real) for i in range(2)]
        low = [np.minimum.accumulate(path) for path in paths]
        high = [np.maximum.accumulate(path) for path in paths]
        keep = self._real(1.0 - self.design.margin)
        allowed = self._allowed(states, paths, low, high, keep)
        taken = int(np.flatnonzero(allowed)[-1]) if np.any(allowed) else 0
        status = Status.OK
        if not np.any(allowed):
            whole = self._real(1.0)
            if not self._allowed(states, paths, low, high, whole)[0]:
                status = Status.INFEASIBLE
        return status, self._outputs(
            taken,
            [path[taken] for path in paths],
            [values[taken] for values in low],
            [values[taken] for values in high],
        )

    def _allowed(
        self,
        states: list[FloatArray],
        paths: list[FloatArray],
        low: list[FloatArray],
        high: list[FloatArray],
        keep: np.floating,
    ) -> np.ndarray:
        """(n_points + 1,) whether each eta keeps (14b)-(14d) on both axes."""
        allowed = np.ones(paths[0].size, dtype=bool)
        for i in range(2):
            origin, rest = states[i][0], states[i][1:]
            centre = matvec(self._rows[i], rest) + self._shift[i] * origin
            bound = self._bound[i] * keep
            least = np.max(-bound - centre)
            greatest = np.min(bound - centre)
            relative = paths[i] - origin
            reach = self._range[i] * keep
            highest, lowest = high[i] - origin, low[i] - origin
            allowed &= (relative >= least) & (relative <= greatest)
            allowed &= (highest <= reach) & (lowest >= -reach)
            if self.design.both_ends:
                ahead = matvec(self._ahead[i], rest)[0] + self._ahead_r[i] * relative
                allowed &= (highest - ahead <= reach) & (lowest - ahead >= -reach)
        return allowed
