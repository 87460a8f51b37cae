"""What a run is judged by: constraint margins, contour error, the columns of Table I."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.controllers.design import Status
from servogen.precision import FloatArray
from servogen.systems.closed_loop import Run
from servogen.systems.two_stage import Machine

# Beyond its limit by this much counts as a violation at slow samples: a nanometre.
VIOLATION_TOLERANCE = 1e-9
# Points behind and ahead of the reference among which the tool's nearest path point is sought: the
# fast stage lags by about 1.6 ms, eight points at full feed.
_BEHIND, _AHEAD = 40, 12
_CHUNK = 20_000


@dataclass(frozen=True)
class Bound:
    """One constraint over a run, the worse of both axes: ``worst`` against ``limit``, which it may
    not exceed or, with ``below``, not fall below; ``key``: of the project file, where one sets the
    limit."""

    name: str
    unit: str
    worst: float
    limit: float
    where: str
    enforced: bool
    below: bool = False
    key: str = ""

    @property
    def violation(self) -> float:
        over = self.limit - self.worst if self.below else self.worst - self.limit
        return max(over, 0.0)

    @property
    def passed(self) -> bool:
        return not self.enforced or self.violation <= VIOLATION_TOLERANCE

    @property
    def share(self) -> float:
        """Of the way from zero to the limit; NaN where zero lies beyond it."""
        if self.limit == 0.0 or (self.limit < 0.0) != self.below:
            return float("nan")
        return max(self.worst / self.limit, 0.0)

    @property
    def fault(self) -> str:
        """What is said where it is broken."""
        key = f" ({self.key})" if self.key else ""
        return (
            f"{self.name} at {self.where} reached {self.worst:.6g} of {self.limit:.6g} "
            f"{self.unit}{key}"
        )


@dataclass(frozen=True)
class Performance:
    """The columns of Table I, (x, y) where the table has two.

    ``max_acceleration`` at slow samples, m/s^2; means over the run at T_f: acceleration m/s^2,
    velocity m/s, fast stage motion m; work J/kg, the integral of |v a|.
    """

    time_s: float
    ratio: float
    max_acceleration: tuple[float, float]
    mean_acceleration: tuple[float, float]
    mean_velocity: tuple[float, float]
    mean_fast: tuple[float, float]
    work: tuple[float, float]


def _pair(values: FloatArray) -> tuple[float, float]:
    return float(values[0]), float(values[1])


def performance(run: Run) -> Performance:
    """Columns of Table I."""
    velocity, acceleration = run.slow_fine[:, :, 1], run.slow_fine[:, :, 2]
    return Performance(
        time_s=run.time_s,
        ratio=run.ratio,
        max_acceleration=_pair(np.max(np.abs(run.slow[:, :, 2]), axis=0)),
        mean_acceleration=_pair(np.mean(np.abs(acceleration), axis=0)),
        mean_velocity=_pair(np.mean(np.abs(velocity), axis=0)),
        mean_fast=_pair(np.mean(np.abs(run.fast_position), axis=0)),
        work=_pair(np.sum(np.abs(velocity * acceleration), axis=0) * run.machine.fast_period_s),
    )


def bounds(run: Run) -> tuple[Bound, ...]:
    """Every constraint (3)-(5), (8) at slow samples, and at T_f.

    Velocity and acceleration between slow samples are reported, not enforced: the design holds
    them at the slow samples and at the inter-sample instants it was asked for.
    """
    found: list[Bound] = []
    scalars = (
        ("position", "m", "position_m"),
        ("velocity", "m/s", "velocity_m_per_s"),
        ("acceleration", "m/s^2", "acceleration_m_per_s2"),
    )
    for where, states, enforced in (
        ("slow samples", run.slow, True),
        ("fast samples", run.slow_fine, False),
    ):
        for column, (name, unit, key) in enumerate(scalars):
            peaks = np.max(np.abs(states[:, :, column]), axis=0)
            found.append(
                _worst(name, unit, peaks, run.machine, key, where, enforced or column == 0)
            )
    error = np.abs(run.reference - run.slow_fine[:, :, 0])
    slow_error = error[:: run.machine.ratio]
    for where, values in (("slow samples", slow_error), ("fast samples", error)):
        found.append(
            _worst(
                "reference less slow stage",
                "m",
                np.max(values, axis=0),
                run.machine,
                "fast_range_m",
                where,
                True,
            )
        )
    peaks = np.max(np.abs(run.fast_position), axis=0)
    found.append(
        _worst(
            "fast stage position", "m", peaks, run.machine, "fast_range_m", "fast samples", False
        )
    )
    return tuple(found)


def _worst(
    name: str,
    unit: str,
    peaks: FloatArray,
    machine: Machine,
    key: str,
    where: str,
    enforced: bool,
) -> Bound:
    limits = [float(getattr(limit, key)) for limit in machine.limits]
    i = int(np.argmax([peaks[0] / limits[0], peaks[1] / limits[1]]))
    return Bound(name, unit, float(peaks[i]), limits[i], where, enforced)


def contour_error(run: Run) -> FloatArray:
    """(K M,) distance of the tool from the path, m: to the nearest piece near its reference."""
    path, tool = run.machine.timed.points, run.tool
    pieces = np.arange(-_BEHIND, _AHEAD)
    errors = np.empty(len(tool))
    centre = np.floor(run.along).astype(np.int64)
    for start in range(0, len(tool), _CHUNK):
        rows = slice(start, min(start + _CHUNK, len(tool)))
        index = np.clip(centre[rows, None] + pieces[None, :], 0, len(path) - 2)
        errors[rows] = _distance(tool[rows], path[index], path[index + 1])
    return errors


def _distance(points: FloatArray, begin: FloatArray, end: FloatArray) -> FloatArray:
    """(k,) distance of points (k, 2) to the nearest of segments (k, s, 2)."""
    along = end - begin
    offset = points[:, None, :] - begin
    length = np.einsum("ksd,ksd->ks", along, along)
    share = np.einsum("ksd,ksd->ks", offset, along) / np.where(length > 0.0, length, 1.0)
    nearest = offset - np.clip(share, 0.0, 1.0)[..., None] * along
    result: FloatArray = np.sqrt(np.min(np.einsum("ksd,ksd->ks", nearest, nearest), axis=1))
    return result


def tool_acceleration(run: Run) -> FloatArray:
    """(K M - 2, 2) second difference of the reference r_f: what the fast stage is asked for."""
    result: FloatArray = np.diff(run.reference, n=2, axis=0) / run.machine.fast_period_s**2
    return result


def follows_path(run: Run) -> bool:
    """Whether the reference passed every point of the path, in order, at no more than one a sample.

    Judged from the points themselves, not from what the controller counts: ``along`` never steps
    back or by more than one, and the reference lies where ``along`` says, to the last digits.
    """
    path, along = run.machine.timed.points, run.along
    steps = np.diff(along)
    slack = 1e-3 if run.machine.precision.is_float32 else 1e-9  # of a point
    if np.any(steps < -slack) or np.any(steps > 1.0 + slack) or abs(along[0]) > slack:
        return False
    if run.complete and along[-1] < len(path) - 2.0:
        return False
    index = np.clip(np.floor(along).astype(np.int64), 0, len(path) - 2)
    share = (along - index)[:, None]
    expected = path[index] + share * (path[index + 1] - path[index])
    return bool(np.max(np.abs(run.reference - expected)) <= 1e-6)


def status_counts(run: Run) -> dict[str, int]:
    """How often each status was met, per axis and period."""
    values, counts = np.unique(run.status_axis, return_counts=True)
    return {Status(v).name: int(c) for v, c in zip(values.tolist(), counts.tolist(), strict=True)}
