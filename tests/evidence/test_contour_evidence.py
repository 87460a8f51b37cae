"""The checks on the contour controller's C, and faults planted in it that they must find."""

from __future__ import annotations

import pytest
from contour_bench import FORMS, covered, on_bench, subject
from contour_designs import made, package
from core_designs import temporary_folder
from heavy_tools import needs_framac
from small_bench import changed

from servogen.emit.package import CPackage
from servogen.evidence import counts, misra, sanitizers
from servogen.evidence.prove_bounds import judge_bounds
from servogen.evidence.prove_parts import Job
from servogen.evidence.prove_run import prove
from servogen.progress import Silent

pytestmark = pytest.mark.xdist_group("coverage")


@pytest.mark.parametrize("name", FORMS)
def test_every_branch_is_reached(name: str) -> None:
    result = covered(name)
    assert result.faults == []
    assert result.reached == result.total > 70


def test_runs_never_exceed_their_count(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(counts, "RANDOM_CALLS", 600)
    for name in ("II 64", "table"):
        one = subject(name)
        plays = counts.played(one)
        assert counts.judge(one, plays, counts.count_runs(one, plays)) == []


@pytest.mark.tools
def test_sanitizers_have_nothing_to_say() -> None:
    finding = sanitizers.run(on_bench("table, float32"), Silent())
    assert finding.passed, finding.faults


@pytest.mark.tools
def test_misra_holds() -> None:
    """The other forms are those of the example."""
    try:
        misra.find_cppchecks()
    except Exception as error:  # as in the other tests of tools: make misra is where it must be
        pytest.skip(str(error))
    finding = misra.run(on_bench("table"), Silent())
    assert finding.passed, finding.faults


def proof(name: str, given: CPackage, inputs: str):
    folder = temporary_folder("eva")
    given.write(folder)
    return prove(Job(given, given.declarations[0], inputs), folder)


@needs_framac
@pytest.mark.parametrize(
    ("name", "inputs"),
    [("II 64", "finite"), ("IV 32", "any"), ("space", "any"), ("table, float32", "finite")],
)
def test_nothing_can_go_wrong_at_run_time(name: str, inputs: str) -> None:
    found = proof(name, package(name), inputs)
    assert found.faults == ()
    assert found.proven > 10


FAULTS = {
    "a pivot without bound": ("sg_max(own[k], cii64_least_price)", "own[k]"),
    "points that are not apart": ("(farthest > cii64_apart)", "(farthest >= (sg_real)0)"),
    "a matrix without bound": ("sg_bound(own[i], -cii64_stiffest, cii64_stiffest)", "own[i]"),
}


@needs_framac
@pytest.mark.parametrize("name", FAULTS)
def test_a_planted_fault_is_not_proven(name: str) -> None:
    wrong = changed(package("II 64"), f"{made('II 64').prefix}.c", *FAULTS[name])
    assert proof("II 64", wrong, "finite").faults


@pytest.mark.parametrize("name", ["II 64", "IV 32", "table"])
def test_bounds_for_the_proof_bind_nowhere(name: str) -> None:
    figures, faults = judge_bounds(subject(name), temporary_folder("bounds"))
    assert faults == []
    assert figures["closed_loop"] == figures["suite"] == {}
