"""The checks on small servo packages, and faults planted in their C that they must find."""

from __future__ import annotations

from dataclasses import replace

import pytest
from core_designs import temporary_folder
from heavy_tools import needs_framac
from servo_bench import AXES, bench, covered, subject
from servo_designs import Axis, package
from small_bench import changed

from servogen.emit.package import CPackage
from servogen.evidence import counts, misra, sanitizers
from servogen.evidence.preemption import examine_preemption, shared_lines
from servogen.evidence.prove_bounds import judge_bounds
from servogen.evidence.prove_run import INPUTS, Job, prove
from servogen.progress import Silent

pytestmark = pytest.mark.xdist_group("coverage")
HEAD = AXES["headstock"]


@pytest.mark.parametrize("name", ["headstock", "slide"])
def test_a_pid_and_its_filter_share_the_current_asked_for_alone(name: str) -> None:
    faults, figures = examine_preemption(subject(AXES[name]))
    assert faults == []
    assert figures["shared"] == {"step": ["wanted"]}
    (line,) = shared_lines(figures)
    assert line.startswith("shared by step and filter_step, wanted: step writes it once")


def test_what_else_a_pid_shares_with_its_filter_is_found() -> None:
    axis, anchor = AXES["headstock"], "    out->wanted = self->wanted;\n"
    line = "    self->memory_1 = (sg_real)0;\n"
    made = changed(package(axis), "ev64_pid.c", anchor, f"{line}{anchor}")
    assert examine_preemption(subject(axis, made))[0] == [
        "ev64_pid_filter_step may interrupt ev64_pid_step, and both touch memory_1"
    ]
    assert examine_preemption(subject(AXES["pair"])) == ([], {})  # no PID, no rule


@pytest.mark.parametrize("name", AXES)
def test_every_branch_is_reached_or_listed(name: str) -> None:
    result = covered(name)
    assert result.faults == []
    assert result.reached + len(result.compared.justified) == result.total > 60


def test_runs_never_exceed_their_count(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(counts, "RANDOM_CALLS", 1500)
    one = subject(HEAD)
    plays = counts.played(one)
    runs = counts.count_runs(one, plays)
    assert counts.judge(one, plays, runs) == []
    assert runs.entries["ev64_mpc_step"].turns == {"EV64_MPC_LOOKUP_TREE_DEPTH": 1}


def test_a_turn_that_is_not_counted_is_seen() -> None:
    made = package(HEAD)
    prefix = "ev64_mpc_lookup"
    end = "    return law;\n"
    turn = "    for (int i = 0; i < 3; i++) {\n        move[0] = move[0] + eta[0];\n    }\n"
    more = changed(made, f"{prefix}.c", end, turn + end)
    one = subject(HEAD, more)
    plays = [play for play in one.suite(30) if play.prefix == prefix]
    runs = counts.count_runs(one, plays)
    assert any(f"{prefix}_find: " in fault for fault in counts.judge(one, plays, runs))


@pytest.mark.tools
def test_kept_sequences_run_clean_under_sanitizers() -> None:
    finding = sanitizers.run(bench(Axis("ez32", "pair", "float32")), Silent())
    assert finding.passed, finding.faults


@pytest.mark.tools
def test_misra_holds() -> None:
    try:
        misra.find_cppchecks()
    except Exception as error:  # as in the other tests of tools: make misra is where it must be
        pytest.skip(str(error))
    whole = bench(AXES["slide"])
    finding = misra.run(replace(whole, subjects=whole.subjects[:1]), Silent())
    assert finding.passed, finding.faults


def proof(made: CPackage, index: int, inputs: str):
    folder = temporary_folder("eva")
    made.write(folder)
    return prove(Job(made, made.declarations[index], inputs), folder)


@needs_framac
@pytest.mark.parametrize("inputs", INPUTS)
@pytest.mark.parametrize("index", [0, 1, 2])
def test_nothing_can_go_wrong_at_run_time(index: int, inputs: str) -> None:
    found = proof(package(HEAD), index, inputs)
    assert found.faults == ()
    assert found.proven > 4


FAULTS = {
    "a memory without bound": (2, "pid.c", "-ev64_pid_most_1, ev64_pid_most_1)", "first, first)"),
    "increments without bound": (1, "mpc.c", "sg_bound(moved[i] + driven[i],", "sg_max(moved[i],"),
    "a law that is none": (0, "mpc_lookup.c", "(-1 - at, 0,", "(4 - at, 0, 4 +"),
}


@needs_framac
@pytest.mark.parametrize("name", FAULTS)
def test_a_planted_fault_is_not_proven(name: str) -> None:
    index, file, old, new = FAULTS[name]
    made = package(HEAD)
    text = made.files[f"ev64_{file}"]
    before, _, after = text.partition(old)
    if new.startswith("sg_max"):  # the upper bound goes with it
        after = after.replace(", ev64_mpc_bound[i])", ")", 1)
    wrong = replace(made, files=made.files | {f"ev64_{file}": before + new + after})
    assert proof(wrong, index, "finite").faults


@pytest.mark.parametrize("name", ["headstock", "slide"])
def test_bounds_for_the_proof_do_not_bind_in_the_loop(name: str) -> None:
    figures, faults = judge_bounds(subject(AXES[name]), temporary_folder("bounds"))
    assert faults == []
    assert figures["closed_loop"] == {}
