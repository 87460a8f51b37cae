"""``check iterations``: what is proved is told as proved, what is measured as measured."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from servogen.controllers.design import Status
from servogen.controllers.mpc_design import MpcDesign
from servogen.controllers.mpc_iterations import mpc_program
from servogen.controllers.tracking_mpc import TrackingMpc
from servogen.evidence.bench import Bench
from servogen.explicit.iteration_certificate import IterationCertificate, certify_iterations
from servogen.progress import Silent
from servogen.project import load_project
from servogen.qp.active_set_tables import ActiveSetTables
from servogen.qp.pqp import pqp_tables
from servogen.steps import two_stage_iterations as own
from servogen.steps.check import bench_of
from servogen.steps.findings import step_finding
from servogen.steps.prepare import Prepared, prepare
from servogen.steps.two_stage import TwoStage

TOML = """\
schema = 1
name = "corner"
system = "two_stage"

[machine.x.slow]
model = "servo"
bandwidth_rad_per_s = 45.0
damping = 0.7
position_limit_m = 0.4
velocity_limit_m_per_s = 0.7
acceleration_limit_m_per_s2 = 14.71

[machine.x.fast]
model = "servo"
bandwidth_rad_per_s = 2250.0
damping = 0.7
range_m = 0.01
velocity_limit_m_per_s = 0.6
acceleration_limit_m_per_s2 = 49.05

[sampling]
fast_sample_time_s = 0.001
slow_sample_time_s = 0.03

[controller.mpc]
horizon = 1

[controller.solver]
method = "active_set"
iteration_cap = 20

[path]
file = "corner.dxf"
feed_m_per_s = 0.5
corner_time_s = 0.001
"""
DXF = """\
0 SECTION 2 HEADER 9 $ACADVER 1 AC1015 9 $INSUNITS 70 4 0 ENDSEC 0 SECTION 2 ENTITIES
0 LINE 8 0 10 0.0 20 0.0 11 300.0 21 0.0
0 LINE 8 0 10 300.0 20 0.0 11 300.0 21 100.0
0 ENDSEC 0 EOF
"""
BENCH = cast(Bench, SimpleNamespace(own_digest={"float64": "a"}, subjects=()))
LOOP = own.Taken(np.array([0, 0, 3, 5]), np.array([Status.OK, Status.OK, Status.OK, Status.BACKUP]))


@pytest.fixture(scope="module")
def prepared(tmp_path_factory: pytest.TempPathFactory) -> Prepared:
    folder: Path = tmp_path_factory.mktemp("corner")
    (folder / "corner.dxf").write_text("\n".join(DXF.split()) + "\n", encoding="utf-8")
    (folder / "servogen.toml").write_text(TOML, encoding="utf-8")
    return prepare(load_project(folder / "servogen.toml"), Silent())


@pytest.fixture(scope="module")
def design(prepared: Prepared) -> MpcDesign:
    system = prepared.system
    assert isinstance(system, TwoStage)
    assert system.design.mpc is not None
    return system.design.mpc[0]


def capped(design: MpcDesign, cap: int) -> MpcDesign:
    return replace(design, solver=replace(design.solver, cap=cap))


def test_the_controllers_program_is_certified_over_all_that_it_may_be_given(
    design: MpcDesign,
) -> None:
    program = mpc_program(design)
    assert program is not None
    found = certify_iterations(program, 30_000)
    assert found.exact
    controller = TrackingMpc(design)
    controller.reset(0.0)
    taken = []
    for theta in found.witness:
        state, references, low, high = np.split(theta, [3, 5, 6])
        taken.append(controller.step(state, references, low, high)[2])
    assert taken[-1] == found.bound
    assert max(taken) == found.bound
    rng = np.random.default_rng(3)
    least, most = program.box()
    for _ in range(3000):
        theta = rng.uniform(least, most) * rng.choice([0.1, 1.0])
        state, references, low, high = np.split(theta, [3, 5, 6])
        assert controller.step(state, references, low, high)[2] <= found.bound


def test_a_proof_counts_as_one_and_stands_beside_what_the_c_took(
    prepared: Prepared, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(own, "RANDOM_STEPS", 300)
    monkeypatch.setattr(own, "BEGINNINGS", 3)
    found = step_finding(prepared, "iterations", bench_of(prepared), Silent())
    assert found.passed
    assert not found.measured
    assert found.summary.startswith("certified: at most ")
    assert set(found.subjects) == {"float64"}
    bound = found.figures["programs"]["corner_mpc"]["certified"]
    measured = found.figures["measured"]
    assert measured["closed loop"]["steps"] > 50
    assert measured["closed loop"]["most"] <= bound
    search = measured["corner_mpc: search"]
    assert 0 < search["most_solved"] <= bound
    assert search["most_solved"] >= measured["corner_mpc: random states"]["most_solved"] - 1
    for one in measured.values():
        assert sum(one["histogram"].values()) == one["steps"]


def test_a_cap_below_the_certified_worst_case_is_told_and_is_no_proof(design: MpcDesign) -> None:
    program = mpc_program(design)
    assert program is not None
    found = certify_iterations(program, 30_000)
    enough = own.Program(capped(design, found.bound), found, found)
    short = own.Program(capped(design, found.bound - 1), found, found)
    assert not own._finding([enough], {"closed loop": LOOP}, BENCH).measured
    told = own._finding([short], {"closed loop": LOOP}, BENCH)
    assert told.measured
    assert f"the cap of {found.bound - 1} is BELOW it" in told.summary


def forged(iterations: int, status: Status = Status.OK) -> own.Taken:
    return own.Taken(np.array([0, iterations]), np.array([Status.OK, status]))


def certificate(bound: int) -> IterationCertificate:
    """One that was exact before anything was measured."""
    return IterationCertificate(
        True, bound, bound, (), 10, 0, bound, 1, 0, 0, 0, (1,) * (bound + 1)
    )  # fmt: skip


@pytest.mark.parametrize("run", ["closed loop", "corner_mpc: random states", "corner_mpc: search"])
@pytest.mark.parametrize("status", [Status.OK, Status.INFEASIBLE, Status.BACKUP])
def test_a_step_of_the_c_above_the_certified_number_is_a_fault(
    design: MpcDesign, run: str, status: Status
) -> None:
    program = own.Program(capped(design, 20), certificate(6), certificate(7))
    runs = {"closed loop": forged(5), "corner_mpc: random states": forged(7)}
    runs["corner_mpc: search"] = forged(6)
    held = own._finding([program], runs, BENCH)
    assert held.passed
    assert not held.faults
    assert not held.measured
    broken = own._finding([program], {**runs, run: forged(9, status)}, BENCH)
    assert not broken.passed
    assert f"{run}: a step took 9 iterations; certified: 7" in broken.faults
    assert broken.figures["programs"]["corner_mpc"]["certified"] is None
    warm = broken.figures["programs"]["corner_mpc"]["warm"]
    assert (warm["exact"], warm["bound"], warm["refuted"]) == (False, 7, 9)
    assert broken.summary.startswith("not certified: ")
    assert "7 after any other call by 10 pieces, but 9 were taken" in broken.summary


def test_a_search_above_the_number_from_a_cold_start_alone_is_a_fault(design: MpcDesign) -> None:
    cold = own.Program(capped(design, 20), certificate(6))
    runs = {"closed loop": forged(9), "corner_mpc: random states": forged(9)}
    assert own._finding([cold], {**runs, "corner_mpc: search": forged(6)}, BENCH).passed
    broken = own._finding([cold], {**runs, "corner_mpc: search": forged(7)}, BENCH)
    assert broken.faults == (
        "corner_mpc: search: a step took 7 iterations; certified from a cold start: 6",
    )
    assert not broken.passed


def test_the_closed_loop_of_two_programs_is_held_against_the_larger_number(
    design: MpcDesign,
) -> None:
    small = own.Program(capped(design, 20), certificate(4), certificate(4))
    other = replace(capped(design, 20), prefix="other")
    large = own.Program(other, certificate(8), certificate(8))
    open_ended = own.Program(other, why="a horizon too long")
    assert own._finding([small, large], {"closed loop": forged(8)}, BENCH).passed
    assert not own._finding([small, large], {"closed loop": forged(9)}, BENCH).passed
    assert own._finding([small, open_ended], {"closed loop": forged(9)}, BENCH).passed


def test_what_rows_may_round_to_is_told_where_accept_is_not_above_it(design: MpcDesign) -> None:
    rounds = replace(certificate(7), rounding=2e-5, accept=1e-6)
    told = own._finding([own.Program(design, certificate(6), rounds)], {"closed loop": LOOP}, BENCH)
    assert told.measured
    assert told.summary.startswith("not certified: ")
    said = "7 after any other call by 10 pieces, but accept 1.0e-06 is not above the 2.0e-05 that"
    assert said in told.summary
    warm = told.figures["programs"]["corner_mpc"]["warm"]
    assert (warm["exact"], warm["rounding"], warm["accept"]) == (False, 2e-5, 1e-6)


def test_a_solved_program_is_told_apart_from_the_hardest_of_all(design: MpcDesign) -> None:
    taken = own.Taken(np.array([26, 35]), np.array([Status.OK, Status.INFEASIBLE]))
    told = own._finding([own.Program(design, why="so")], {"closed loop": taken}, BENCH)
    assert "26 in the hardest solved program found" in told.summary


def test_an_accept_that_is_too_small_is_told_and_not_raised(design: MpcDesign) -> None:
    assert isinstance(design.solver, ActiveSetTables)
    small = replace(design.solver, accept=np.float64(1e-9))
    found = own._certified(replace(design, solver=small), Silent())
    assert found.proved is None
    assert found.sentence().startswith("not certified: accept is 1e-09, expected at least ")


def test_what_is_not_finished_or_not_tried_is_measured_and_says_so(design: MpcDesign) -> None:
    program = mpc_program(design)
    assert program is not None
    part = certify_iterations(program, 50)
    told = own._finding([own.Program(design, part, part)], {"closed loop": LOOP}, BENCH)
    assert told.measured
    assert told.summary.startswith("not certified: from a cold start not finished")
    qp = design.qp
    tables = pqp_tables(
        qp.hessian, qp.rows_command, design.solver.rows, 0.1, 6, 20, design.tol, np.dtype(float),
        qp.rows_per_step, design.horizon,
    )  # fmt: skip
    pqp = own._certified(replace(design, solver=tables), Silent())
    told = own._finding([pqp], {"closed loop": LOOP}, BENCH)
    assert told.measured
    assert told.summary == (
        "not certified: PQP has no bound but its cap; measured: at most 5 in the closed loop, "
        "backup on 1 of 4 axis steps; 3 in the hardest solved program found; cap 20"
    )
    long = own._certified(replace(design, horizon=own.LONGEST_HORIZON + 1), Silent())
    assert long.proved is None
    assert "too many pieces" in long.sentence()
