"""The claims about a design hold for the example, and fail for a design that was tampered with."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from servogen.plants.statespace import FloatArray
from servogen.progress import Silent
from servogen.project import load_project
from servogen.resources import resource_dir
from servogen.steps.two_stage import TwoStage, prepare_two_stage
from servogen.systems.claims import Claim
from servogen.systems.design_proofs import set_claims, terminal_claims

EXAMPLES = resource_dir("examples") / "two_stage"


@pytest.fixture(scope="module")
def prepared() -> TwoStage:
    return prepare_two_stage(load_project(EXAMPLES / "unequal_axes.toml"), Silent())


def sets_of(prepared: TwoStage, k: FloatArray | None = None) -> list[Claim]:
    machine = prepared.machine
    target = machine.sets.y
    if k is not None:
        target = replace(target, k=k)
    return set_claims("y", target, machine.slow[1], machine.slow_period_s, machine.limits[1], 0)


def terminal_of(prepared: TwoStage, axis: int = 0, **changes: FloatArray | int) -> list[Claim]:
    machine = prepared.machine
    assert prepared.design.mpc is not None
    mpc = prepared.design.mpc[axis]
    changed = replace(mpc, qp=replace(mpc.qp, **changes))
    target = (machine.sets.x, machine.sets.y)[axis]
    return terminal_claims("a", changed, target, prepared.tuning.weights, machine.limits[axis])


def broken(claims: list[Claim]) -> list[str]:
    assert all(claim.cases > 0 for claim in claims)
    return [claim.name.split(": ")[1].split(" (")[0] for claim in claims if not claim.holds]


def test_the_example_s_design_is_proved(prepared: TwoStage) -> None:
    assert broken(sets_of(prepared)) == []
    assert broken(terminal_of(prepared, 0)) == []
    assert broken(terminal_of(prepared, 1)) == []


def test_a_set_with_a_facet_too_far_out_is_refused(prepared: TwoStage) -> None:
    k = prepared.machine.sets.y.k.copy()
    half = k.size // 2
    found = set()
    for facet in range(half):
        wider = k.copy()
        wider[[facet, facet + half]] *= 1.01
        found |= set(broken(sets_of(prepared, wider)))
    assert "O-infinity keeps every limit" in found


def test_a_set_with_a_facet_too_far_in_is_refused(prepared: TwoStage) -> None:
    k = prepared.machine.sets.y.k.copy()
    k[[1, 1 + k.size // 2]] *= 0.99
    assert broken(sets_of(prepared, k))


def test_a_terminal_row_less_is_noticed(prepared: TwoStage) -> None:
    assert prepared.design.mpc is not None
    qp = prepared.design.mpc[0].qp
    assert qp.terminal_rows > 0
    bound = qp.terminal_bound.copy()
    bound[0] *= 1.01
    assert broken(terminal_of(prepared, terminal_bound=bound)) == [
        "the terminal rows imply O-infinity"
    ]
    dropped = terminal_of(
        prepared,
        terminal_rows=qp.terminal_rows - 1,
        terminal_reference=qp.terminal_reference[1:],
        terminal_position=qp.terminal_position[1:],
        terminal_bound=qp.terminal_bound[1:],
    )
    assert broken(dropped) == ["the terminal rows imply O-infinity"]


def test_a_row_of_the_program_that_is_not_the_set_s_is_noticed(prepared: TwoStage) -> None:
    assert prepared.design.mpc is not None
    rows = prepared.design.mpc[0].qp.rows_command.copy()
    rows[-1] *= 0.98
    assert broken(terminal_of(prepared, rows_command=rows))


def test_a_terminal_cost_too_small_is_noticed(prepared: TwoStage) -> None:
    assert prepared.design.mpc is not None
    cost = 0.99 * prepared.design.mpc[0].qp.terminal_cost
    assert np.all(np.linalg.eigvalsh(cost) > 0)
    assert broken(terminal_of(prepared, terminal_cost=cost)) == [
        "the terminal cost falls by the stage cost"
    ]
