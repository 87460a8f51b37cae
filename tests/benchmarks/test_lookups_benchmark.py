"""The benchmark of lookups: everyone's answers, its promises; gcc, but no valgrind."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))

import lookups
from lookup import contenders
from lookup.contenders import CHOSEN, PPOPT_CODE, SEQUENTIAL, Explicit
from lookup.programs import programs
from qp.counted import Measured, PeerFailed, judged, run
from qp.document import lookup_parts
from qp.peers import columns
from qp.sequence import Sequence, with_optima

from qp import peers


@pytest.fixture(scope="module")
def given() -> Explicit:
    (program,) = programs(only=("servo_drive_2",))
    return Explicit(program)


@pytest.fixture(autouse=True)
def _no_valgrind(monkeypatch: pytest.MonkeyPatch) -> None:
    def answered(
        name: str, program: Path, sequence: Sequence, part: slice, static: bool = False,
        note: str = "", sized: bool = True,
    ) -> Measured:  # fmt: skip
        sequence.write(program.parent / "programs", part)
        run([program, "programs", "answers"], program.parent)
        answers = np.fromfile(program.parent / "answers").reshape(-1, sequence.variables + 2)
        cost = np.ones(len(answers))
        return judged(name, "instructions", sequence, part, cost, answers, 1, 2, 3, note)

    for module in (contenders, peers):
        monkeypatch.setattr(module, "counted_peer", answered)


@pytest.mark.parametrize(
    "contender",
    [
        contenders.chosen,
        contenders.checked,
        contenders.law_tree,
        contenders.clips,
        contenders.sequential,
        contenders.ppopt,
        contenders.ppopt_sequential,
    ],
)
def test_everyone_finds_the_same_moves(
    given: Explicit, contender: contenders.Contender, tmp_path: Path
) -> None:
    found = contender(given, tmp_path)
    assert np.all(found.solved)
    assert np.max(found.error) <= 1e-8
    span = np.ptp(given.program.moves)
    assert span == pytest.approx(2000.0)  # the whole range of the current is met


def test_the_program_on_line_is_the_same(given: Explicit) -> None:
    sequence = given.program.online()
    first = with_optima(sequence).optimum[:, 0]
    assert np.allclose(1000.0 * first, given.program.moves[:, 0], rtol=0.0, atol=1e-6)


def test_the_program_on_line_is_solved_by_us(given: Explicit, tmp_path: Path) -> None:
    """Bounds alone, and rows that stay."""
    for program in (given.program, *programs(quick=True, only=("double_integrator",))):
        sequence = with_optima(program.online())
        found = columns(sequence, slice(0, sequence.length), tmp_path)
        assert np.all(found.solved)
        assert np.max(found.error) <= 1e-8


def test_a_generator_that_does_not_run_says_why(given: Explicit, tmp_path: Path) -> None:
    with pytest.raises(PeerFailed, match="generator"):
        contenders.ppopt_code(given, tmp_path)


def measured(cost: float, error: float = 0.0) -> Measured:
    one = np.ones(2)
    return Measured(
        "any", "instructions", slice(0, 2), cost * one, error * one, 0.0 * one, one > 0.0,
        np.zeros(2, dtype=int), seconds=1e-6 * one,
    )  # fmt: skip


def test_a_slower_wrong_or_unmeasured_form_breaks_a_promise() -> None:
    def verdicts(chosen: Measured | None) -> list[bool]:
        found = {SEQUENTIAL: measured(10.0)} | ({CHOSEN: chosen} if chosen else {})
        return [promise.kept for promise in lookups.promises({"one": found})]

    assert verdicts(measured(10.0)) == [True, True, True]
    assert verdicts(measured(11.0)) == [False, True, True]
    assert verdicts(measured(9.0, error=1e-7)) == [True, False, True]
    assert verdicts(None) == [False, False, False]


def test_the_tables_have_their_places(given: Explicit) -> None:
    found = {name: measured(3.0) for name, _ in contenders.CONTENDERS if name != PPOPT_CODE}
    program = lookups.as_json(given, found, {PPOPT_CODE: "does not run"})
    parts = lookup_parts({"programs": [program], "promises": []})
    assert "| 3, 3, 3 |" in parts["lookup-costs"]
    assert f"| {PPOPT_CODE} | does not run | servo_drive_2 |" in parts["lookup-missing"]
    page = (Path(__file__).resolve().parents[2] / "docs" / "benchmarks.md").read_text()
    for name in parts:
        assert page.count(f"<!-- bench:{name} -->") == 1
