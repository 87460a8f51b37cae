"""Sequences of the bundled two-stage machine: its closed loop, and the plant behind ``qp_mpc20b``
with limits so tight that working sets reach the number of variables."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from qp.counted import PeerFailed
from qp.published import HORIZON, PER_STEP, STATES, TERMINAL, responses, unpack
from qp.sequence import Array, Sequence, StagePlant, solve_reference
from servogen.controllers.cascade import Cascade
from servogen.controllers.tracking_mpc import TrackingMpc
from servogen.progress import Silent
from servogen.project import load_project
from servogen.steps.two_stage import TwoStage, prepare_two_stage
from servogen.systems.closed_loop import run_closed_loop
from servogen.systems.two_stage import design_cascade

EXAMPLES = Path(__file__).parents[2] / "examples" / "two_stage"
CAP = 200
# A reference that changes this often, in steps, and a row that is none.
HOLD, NO_LIMIT = 60, 1e3


def prepared(file: str) -> TwoStage:
    return prepare_two_stage(load_project(EXAMPLES / file), Silent())


def closed_loops(file: str, horizon: int, periods: int | None) -> tuple[Sequence, Sequence]:
    """The programs of both axes while the reference cascade runs the example's path."""
    two = prepared(file)
    if two.tuning.horizon == 0:
        raise PeerFailed("has no quadratic program: its governor is alone, without an MPC")
    solver = replace(two.tuning.solver, method="active_set", cap=CAP)
    cascade = Cascade(
        design_cascade(two.machine, replace(two.tuning, horizon=horizon, solver=solver))
    )
    assert cascade.mpc is not None
    recorders = tuple(_Recorder(mpc) for mpc in cascade.mpc)
    run_closed_loop(two.machine, cascade, periods)
    name = file.removesuffix(".toml").replace("servogen", "two_stage")
    x, y = (
        recorder.sequence(f"{name}_{axis}_{horizon}")
        for axis, recorder in zip("xy", recorders, strict=True)
    )
    return x, y


class _Recorder:
    """Listens to one axis's program: f and the bounds of every step."""

    def __init__(self, mpc: TrackingMpc) -> None:
        self.design, self.programs = mpc.design, []
        inner, bounds = mpc.step, mpc._bounds

        def step(state: Array, reference: Array, low: Array, high: Array):
            qp, relative = self.design.qp, reference - state[0]
            below, above = bounds(state[0], relative, low, high)
            free = qp.rows_state @ state[1:]
            linear = qp.gradient_state @ state[1:] + qp.gradient_reference @ relative
            self.programs.append((linear, below - free, above - free))
            return inner(state, reference, low, high)

        mpc.step = step  # type: ignore[method-assign]

    def sequence(self, name: str) -> Sequence:
        qp = self.design.qp
        linear, low, high = (np.array(part) for part in zip(*self.programs, strict=True))
        return Sequence(
            name=name,
            source=f"closed loop of the bundled two-stage example, horizon {self.design.horizon}",
            hessian=qp.hessian,
            rows=qp.rows_command,
            linear=linear,
            low=low,
            high=high,
            per_step=qp.rows_per_step,
            staying=qp.terminal_rows,
            plant=StagePlant(qp.stage, qp.stage_terminal, STATES),
        )


def tight_loop(velocity: float, steps: int) -> Sequence:
    """The machine of ``qp_mpc20b`` made to jump between set points, its velocity limited to this
    share of the machine's: the whole horizon is then spent at the limit."""
    base = unpack()
    three = responses(base.rows)[:STATES]
    assert base.plant is not None
    phi, b = base.plant.stage[:STATES, :STATES], base.plant.stage[:STATES, STATES]
    ratio = base.rows[3, 0] / base.rows[0, 0]
    free = np.empty((base.count, STATES))
    power = np.eye(STATES)
    for k in range(HORIZON):
        power = phi @ power
        free[PER_STEP * k : PER_STEP * k + STATES] = power
        free[PER_STEP * k + STATES] = ratio * power[0]
    free[PER_STEP * HORIZON :] = base.plant.terminal @ power
    limit = np.append(np.tile([1.0, velocity, 1.0, NO_LIMIT], HORIZON), [1.5, 9.0, 9.0])
    largest = 0.9 / three[0].sum()  # moves the position to 0.9 of its limit
    rng, x, r, programs = np.random.default_rng(1), np.zeros(STATES), 0.0, []
    for t in range(steps):
        if t % HOLD == 0:
            r = rng.uniform(-1.0, 1.0) * largest
        linear, away = -base.hessian @ np.full(HORIZON, r), free @ x
        programs.append((linear, -limit - away, limit - away))
        z, _ = solve_reference(base.hessian, base.rows, *programs[-1])
        x = phi @ x + b * z[0]
    linear, low, high = (np.array(part) for part in zip(*programs, strict=True))
    return Sequence(
        name=f"tight_{velocity:g}",
        source=f"plant of qp_mpc20b between set points, velocity limit {velocity:g} of its own",
        hessian=base.hessian,
        rows=base.rows,
        linear=linear,
        low=low,
        high=high,
        per_step=PER_STEP,
        staying=TERMINAL,
        plant=base.plant,
    )
