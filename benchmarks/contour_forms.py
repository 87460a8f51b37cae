"""Forms of the contour law in float32: what each changes of the errors on the paper's circle.

    python benchmarks/contour_forms.py [--away 0.045]

The same law four ways, the whole state known: the recursion (11)-(13) in identified coordinates,
the same on positions relative to the tool's, a square-root form of that (one orthogonal
factorisation a point), and the sliding references that are emitted. Each is run in float64 and
float32, at the origin and ``--away`` metres from it on both axes; told is how far float32 changes
the RMS errors, um, or that the run left the contour. Tangents are the same for all. On relative
positions the recursions take the axes for exact integrators.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import scipy.linalg

from servogen.controllers.contour_estimate import wanted_state
from servogen.controllers.contour_lq import ContourLq
from servogen.controllers.contour_lq_design import AxisData, ContourLqDesign, design_contour_lq
from servogen.controllers.contour_recursion import end_weight
from servogen.controllers.contour_tangent import Course, TangentSweep
from servogen.controllers.contour_weights import ContourWeights, Terminal
from servogen.controllers.design import Status, Value
from servogen.plants.machining_centre import SAMPLE_TIME_S, machining_centre
from servogen.precision import FLOAT32, FLOAT64, FloatArray, Precision
from servogen.systems.contour_loop import run_contour
from servogen.systems.contour_motion import ContourMotion, circle

CASES = {
    "II": (Terminal.OUTPUT, ContourWeights(1.2, 20.0, 2e-9)),
    "IV": (Terminal.STATIONARY, ContourWeights(0.25, 15.0, 2e-9)),
    "10,000 : 1": (Terminal.STATIONARY, ContourWeights(2e-3, 20.0, 2e-9)),
}
SETTLED, TURN, PREVIEW = 60, 251, 10
# Beyond this RMS a run has left the contour.
LOST_M = 1e-3


@dataclass
class Recursion:
    """(11)-(13) in one precision; ``own``: in the coordinates of the design, positions relative to
    the tool's; ``root``: by factors of H, the references as a column more."""

    design: ContourLqDesign
    precision: Precision
    own: bool
    root: bool

    def __post_init__(self) -> None:
        design, self.dtype = self.design, self.precision.dtype
        models = [axis.model for axis in design.axes]
        plants = [model.plant for model in models]
        turn = scipy.linalg.block_diag(*(m.to_state for m in models)) if self.own else None
        a = scipy.linalg.block_diag(*(m.a if self.own else m.plant.a for m in models))
        b = [m.b if self.own else m.plant.b for m in models]
        c = [np.eye(m.order)[0] if self.own else m.plant.c for m in models]
        self.a = a.astype(self.dtype)
        self.b = scipy.linalg.block_diag(*(v[:, None] for v in b)).astype(self.dtype)
        self.c = scipy.linalg.block_diag(*(v[None, :] for v in c)).astype(self.dtype)
        heaviest = design.weights.largest * np.eye(len(plants))
        end = end_weight(plants, design.weights, design.terminal, heaviest)
        end = end if turn is None else turn.T @ end @ turn
        values, vectors = np.linalg.eigh(end)
        factor = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T
        self.end, self.factor = end.astype(self.dtype), factor.astype(self.dtype)
        inverse = np.eye(len(a)) if turn is None else np.linalg.inv(turn)
        known = [wanted_state(plant) for plant in plants]
        self.on = [
            (inverse @ scipy.linalg.block_diag(*(getattr(k, part)[:, None] for k in known))).astype(
                self.dtype
            )
            for part in ("on_position", "on_advance")
        ]
        price = (design.weights.tracking / design.weights.largest, design.share)
        self.sweep = TangentSweep(2, PREVIEW, price, design.apart, self.precision)
        zeros = np.zeros(2, dtype=self.dtype)
        self.course = Course(zeros, zeros)

    def call(
        self, operation: str, inputs: Mapping[str, Value] | None = None
    ) -> tuple[Status, dict[str, Value]]:
        given = {key: np.asarray(value).astype(self.dtype) for key, value in (inputs or {}).items()}
        if operation == "reset":
            return Status.OK, {}
        points = given["reference"].reshape(-1, 2)
        if not np.any(self.course.point):
            self.course = Course(points[0].copy(), np.zeros_like(points[0]))
        slide, self.course = self.sweep(points, self.course)
        q = [self._weight(slide.middle[j], slide.kept[j]) for j in range(PREVIEW)]
        wanted, state = points[1:], self._state(given)
        if self.own:
            wanted = wanted - given["position"]
            state = state - self.on_place(given["position"])
        u = (self._factors if self.root else self._matrices)(q, wanted, state)
        return Status.OK, {"command": np.clip(u, -20.0, 20.0), "limited": 0, "known": PREVIEW}

    def on_place(self, position: FloatArray) -> FloatArray:
        place: FloatArray = self.c.T @ position
        return place

    def _weight(self, middle: FloatArray, kept: np.floating) -> FloatArray:
        way = middle * (kept / np.sqrt(middle @ middle))
        return self.design.weights.output_weight(way).astype(self.dtype)

    def _state(self, given: Mapping[str, FloatArray]) -> FloatArray:
        """In the coordinates of the recursion, from what the loop knows."""
        parts, start = [], 0
        for axis, y in zip(self.design.axes, given["position"], strict=True):
            own = np.concatenate([[y], given["hidden"][start : start + axis.model.hidden]])
            parts.append(own if self.own else axis.model.to_state @ own)
            start += axis.model.hidden
        return np.concatenate(parts).astype(self.dtype)

    def _end(self, wanted: FloatArray) -> FloatArray:
        found: FloatArray = self.on[0] @ wanted[-1] + self.on[1] @ (wanted[-1] - wanted[-2])
        return found

    def _matrices(self, q: list[FloatArray], wanted: FloatArray, x: FloatArray) -> FloatArray:
        a, b, c = self.a, self.b, self.c
        price = (self.design.weights.control * np.eye(2)).astype(self.dtype)
        if self.design.terminal is Terminal.OUTPUT:
            h, g = c.T @ q[-1] @ c, -(c.T @ (q[-1] @ wanted[-1]))
        else:
            h, g = self.end, -(self.end @ self._end(wanted))
        for j in range(PREVIEW - 1, 0, -1):
            closed = a - b @ np.linalg.solve(b.T @ h @ b + price, b.T @ h @ a)
            g = closed.T @ g - c.T @ (q[j - 1] @ wanted[j - 1])
            h = a.T @ h @ closed + c.T @ q[j - 1] @ c
        found: FloatArray = -np.linalg.solve(b.T @ h @ b + price, b.T @ (h @ (a @ x) + g))
        return found

    def _factors(self, q: list[FloatArray], wanted: FloatArray, x: FloatArray) -> FloatArray:
        """Least squares in (u, x, 1), point after point from the end."""
        n = len(self.a)
        root = (np.sqrt(self.design.weights.control) * np.eye(2)).astype(self.dtype)
        seen = [np.linalg.cholesky(one).T.astype(self.dtype) for one in q]
        if self.design.terminal is Terminal.OUTPUT:
            f, t = seen[-1] @ self.c, -(seen[-1] @ wanted[-1])
        else:
            f, t = self.factor, -(self.factor @ self._end(wanted))
        for j in range(PREVIEW - 1, -1, -1):
            rows = np.block(
                [
                    [root, np.zeros((2, n + 1), dtype=self.dtype)],
                    [f @ self.b, f @ self.a, t[:, None]],
                ]
            )
            r = np.linalg.qr(rows, mode="r")
            if j == 0:
                break
            f = np.vstack([r[2:, 2:-1], seen[j - 1] @ self.c])
            t = np.concatenate([r[2:, -1], -(seen[j - 1] @ wanted[j - 1])])
        found: FloatArray = -np.linalg.solve(r[:2, :2], r[:2, 2:-1] @ x + r[:2, -1])
        return found


FORMS = {
    "recursion, identified coordinates": (False, False),
    "recursion, relative positions": (True, False),
    "square roots, relative positions": (True, True),
    "sliding references (emitted)": None,
}


def errors(design: ContourLqDesign, form: tuple[bool, bool] | None, away: float) -> FloatArray:
    """(2,) contour and tracking, m RMS."""
    motion = circle(1e-3, 0.05, SAMPLE_TIME_S, SETTLED + TURN + 20)
    moved = ContourMotion(motion.points + away, lambda p, k: motion.distance(p - away, k))
    inside = ContourLq(design) if form is None else Recursion(design, design.precision, *form)
    with np.errstate(all="ignore"):
        run = run_contour(design, inside, machining_centre(), moved, SETTLED + TURN)
    return np.array([run.contour_rms_m(TURN), run.tracking_rms_m(TURN)])


def designed(case: str, precision: Precision) -> ContourLqDesign:
    terminal, weights = CASES[case]
    axes = [AxisData(axis, 20.0, 0.05, 0.01, 0.8e-6) for axis in machining_centre()]
    return design_contour_lq("forms", precision, axes, weights, terminal, PREVIEW)


def told(case: str, form: tuple[bool, bool] | None, away: float) -> str:
    """By how much float32 changes the errors, um."""
    wide, narrow = (errors(designed(case, p), form, away) for p in (FLOAT64, FLOAT32))
    if not np.all(narrow < LOST_M):
        return "lost"
    off = 1e6 * np.abs(narrow - wide)
    return f"{off[0]:.1g}, {off[1]:.1g}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--away", type=float, default=0.045, help="metres from the origin")
    away = parser.parse_args().away
    print("float32 less float64 on the circle, um RMS of the contour and of tracking\n")
    print("| form |" + "".join(f" {c}, origin | {1e3 * away:g} mm off |" for c in CASES))
    print("|---|" + "---|---|" * len(CASES))
    for name, form in FORMS.items():
        cells = [told(case, form, place) for case in CASES for place in (0.0, away)]
        print(f"| {name} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
