"""The benchmark of QP back ends: its own pieces, without valgrind and without the peers."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))

from qp.chosen import UnknownName, chosen
from qp.counted import Measured, instructions
from qp.literature import all_loops
from qp.machine import tight_loop
from qp.peers import COLUMNS, DAQP, STAGES, column_design, simple_bounds_first
from qp.promises import HOWS, promises, status
from qp.published import HORIZON, unpack
from qp.sequence import Sequence, with_optima
from qp.suite import FULL, suite
from qp.unreached import Unreached


def measured(cost: list[float], error: float = 0.0, size: int = 10) -> Measured:
    count = len(cost)
    return Measured(
        "any", "instructions", slice(0, count), np.array(cost), np.full(count, error),
        np.zeros(count), np.ones(count, dtype=bool), np.zeros(count, dtype=int), 1, size, size,
    )  # fmt: skip


def test_a_dump_of_callgrind_is_read() -> None:
    dump = "version: 1\nevents: Ir\nfn=(1) solve_one\n12 34\n\ntotals: 25096\n"
    assert instructions(dump) == 25096
    assert instructions(dump.replace("totals", "summary")) == 25096
    assert instructions("version: 1\nevents: Ir\n") is None


@pytest.mark.parametrize("make", [lambda: tight_loop(0.02, 70), lambda: all_loops(50)[-1]])
def test_a_sequence_is_the_same_every_time(make) -> None:
    first, again = make(), make()
    for name in ("hessian", "rows", "linear", "low", "high"):
        assert getattr(first, name).tobytes() == getattr(again, name).tobytes()


def test_the_reference_keeps_the_rows_and_no_direction_falls() -> None:
    whole = tight_loop(0.02, 240)
    solved = with_optima(whole)
    assert solved.active.max() >= 19
    at = solved.optimum @ solved.rows.T
    assert np.max(np.maximum(at - solved.high, solved.low - at)) <= 1e-10
    rng = np.random.default_rng(2)
    for t in range(0, 240, 20):
        z, slope = solved.optimum[t], solved.hessian @ solved.optimum[t] + solved.linear[t]
        inside = with_optima(_moved(whole, t, rng)).optimum[0]  # any point that keeps the rows
        assert slope @ (inside - z) >= -1e-9 * np.linalg.norm(slope)


def _moved(sequence: Sequence, t: int, rng: np.random.Generator) -> Sequence:
    """Program ``t`` with another f."""
    kept = {name: getattr(sequence, name) for name in sequence.__dataclass_fields__}
    kept["linear"] = rng.normal(size=(1, sequence.variables)) * 10.0
    kept["low"], kept["high"] = sequence.low[t : t + 1], sequence.high[t : t + 1]
    return Sequence(**kept)


def test_the_kept_sequence_has_the_plant_it_is_given() -> None:
    sequence = unpack()
    assert (sequence.length, sequence.variables, sequence.count) == (1698, 20, 83)
    plant = sequence.plant
    assert plant is not None
    rows = plant.rows(HORIZON)
    z = np.random.default_rng(3).normal(size=HORIZON)
    assert np.allclose(rows.product(z), sequence.rows @ z, rtol=0.0, atol=1e-11)


def test_bounds_given_to_daqp_are_the_same_program() -> None:
    sequence = all_loops(50)[-1]
    given, simple = simple_bounds_first(sequence)
    assert simple == sequence.variables
    assert np.array_equal(given.rows[:simple], np.eye(simple))
    assert np.allclose(with_optima(given).optimum, with_optima(sequence).optimum, atol=1e-10)


def results() -> dict[str, dict[str, Measured]]:
    """A sequence of every kind, everything kept."""
    own = {STAGES: measured([1.0, 2.0]), COLUMNS: measured([2.0, 3.0])}
    easy = {name: own | {DAQP: measured([10.0, 20.0], size=20)} for name in ("qp_mpc20b", "tight")}
    bounds = {COLUMNS: measured([9.0, 9.0]), DAQP: measured([9.0, 9.0], size=20)}
    return easy | {"other": dict(easy["tight"]), "bounds": bounds}


def broken(found: dict[str, dict[str, Measured]]) -> list[str]:
    return [p.told for p in promises(found, ("tight",), {}) if p.promised and not p.kept]


def test_promised_is_what_the_issue_asks_of_the_form_that_fits() -> None:
    made = promises(results(), ("tight",), {})
    assert broken(results()) == []
    assert status(made) == 0
    promised = {(p.sequence, p.solver, p.how) for p in made if p.promised and p.sequence}
    assert promised == {
        *((name, STAGES, how) for name in ("qp_mpc20b", "tight") for how in HOWS),
        ("other", STAGES, "bytes"),
        ("bounds", COLUMNS, "bytes"),
    }
    limits = {(p.sequence, p.how): p.limit for p in made if p.solver == STAGES}
    assert [limits["qp_mpc20b", how] for how in HOWS] == [0.20, 0.40, 0.5]
    assert [limits["tight", how] for how in HOWS] == [0.25, 1.0, 0.5]


def test_a_promise_not_measured_is_broken() -> None:
    found = results()
    del found["tight"][DAQP]
    assert len([told for told in broken(found) if told.startswith("tight, stage")]) == 3
    del found["tight"]
    assert len([told for told in broken(found) if told.startswith("tight, stage")]) == 3
    found = results()
    found["other"][STAGES] = replace(found["other"][STAGES], written=-1)
    assert broken(found) == ["other, stage rows: bytes by DAQP's"]
    none = {name: {DAQP: own[DAQP]} for name, own in results().items()}
    assert "servogen, column rows: programs not solved" in broken(none)


def test_what_is_slow_large_or_wrong_breaks_its_promise_alone() -> None:
    found = results()
    found["qp_mpc20b"][STAGES] = measured([1.0, 9.0], error=1e-7)
    assert broken(found) == [
        "qp_mpc20b, stage rows: median of the instructions by DAQP's",
        "qp_mpc20b, stage rows: maximum of the instructions by DAQP's",
        f"{STAGES}: largest error of all sequences",
    ]
    found = results()
    for name in ("other", "bounds"):  # reported: told, and no promise
        found[name][COLUMNS] = measured([50.0, 50.0])
    assert broken(found) == []
    reported = [p.told for p in promises(found, ("tight",), {}) if not p.kept]
    assert "bounds, column rows: median of the instructions by DAQP's" in reported
    assert "other, column rows: maximum of the instructions by DAQP's" in reported


@pytest.mark.parametrize(("size", "expected"), [(10, 0), (11, 3), (12, 1)])
def test_a_promise_broken_as_admitted_has_a_status_of_its_own(size: int, expected: int) -> None:
    found = results()
    found["bounds"][COLUMNS] = measured([1.0], size=size)
    admits = {("bounds", "bytes"): Unreached(0.55, "for a reason")}
    assert status(promises(found, ("tight",), admits)) == expected
    found["other"][STAGES] = measured([1.0], size=20)
    assert status(promises(found, ("tight",), admits)) == 1


def test_the_sequences_of_large_sets_are_in_the_suite(tmp_path: Path) -> None:
    """And their sets reach 19 of 20 variables, as is said of them."""
    for sequence in suite(tmp_path, quick=True, only=FULL):
        assert isinstance(sequence, Sequence)
        assert sequence.variables == 20
        assert sequence.active.max() >= 19, sequence.name


def test_a_whole_name_is_that_sequence_alone() -> None:
    names = ["two_stage_x_5", "two_stage_x_50", "two_stage_y_20", "tight_0.02", "tight_0.1"]
    assert chosen(names, ("two_stage_x_5",)) == {"two_stage_x_5"}
    assert chosen(names, ("two_stage_x", "tight_0.1")) == {
        "two_stage_x_5", "two_stage_x_50", "tight_0.1",
    }  # fmt: skip
    assert chosen(names, ("two_stage_",)) == chosen(names, ("two_stage",)) == set(names[:3])
    assert chosen(names, ("two",)) == set(names[:3])
    assert chosen(names, ()) == set(names)
    for word in ("tight_0", "two_stage_z", "none"):
        with pytest.raises(UnknownName, match="there are two_stage_x_5, "):
            chosen(names, ("two", word))


def test_one_sequence_is_made_where_one_is_asked_for(tmp_path: Path) -> None:
    made = [one.name for one in suite(tmp_path, quick=True, only=("servo_drive_1",))]
    assert made == ["servo_drive_1"]


def test_every_servo_sequence_is_a_program(tmp_path: Path) -> None:
    """A program of bounds alone has no other rows that move."""
    for sequence in suite(tmp_path, quick=True, only=("servo_drive",)):
        assert isinstance(sequence, Sequence)
        assert column_design(sequence)[0].tables.rows.count == sequence.count


@pytest.mark.parametrize("script", ["qp_solvers", "pqp_iteration", "near_rows"])
def test_help_is_told(script: str) -> None:
    place = Path(__file__).resolve().parents[2] / "benchmarks" / f"{script}.py"
    told = subprocess.run(
        [sys.executable, place, "--help"], capture_output=True, text=True, check=False
    )
    assert told.returncode == 0, told.stderr
    assert told.stdout.startswith("usage:")


def test_an_unknown_precision_is_a_sentence() -> None:
    place = Path(__file__).resolve().parents[2] / "benchmarks" / "pqp_iteration.py"
    told = subprocess.run(
        [sys.executable, place, "float16"], capture_output=True, text=True, check=False
    )
    assert told.returncode == 2
    assert "no precision is called float16" in told.stderr
