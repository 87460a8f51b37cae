"""Sequences, tables and files of the benchmark of QP back ends, without valgrind or the index."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))

import lookups
import qp_solvers
from qp.counted import Measured, PeerFailed
from qp.document import DocumentError, qp_parts, rewritten, whole
from qp.libraries import replacements
from qp.literature import all_loops, closed_loop, steady, tanks
from qp.peers import COLUMNS, STAGES
from qp.sequence import Sequence, two_sided, with_optima
from qp.suite import Missing, suite
from qp.told import as_json, write
from qp.tolerance import reaching

from qp import libraries, packages, servo
from servogen.systems.servo_drive import tracking_problem


def test_rows_find_their_opposites() -> None:
    rows = np.array([[0.0, 1.0], [1.0, 0.0], [0.0, -1.0], [1.0, 0.0], [-1.0, 0.0], [-1.0, 0.0]])
    first, second = two_sided(rows)
    assert first.tolist() == [0, 1, 3]
    assert second.tolist() == [2, 4, 5]
    with pytest.raises(ValueError, match="no opposite"):
        two_sided(rows[:-1])


def filled() -> Sequence:
    """Tanks brought to levels that are not those around which their limits lie."""
    tank = tanks()
    rest = steady(tank, np.eye(4)[:2], np.array([2.0, -1.5]))
    return closed_loop(tank, 5, 60, lambda t: rest, np.zeros((60, 1)), rho=1.0)


@pytest.mark.parametrize(
    "make", [filled, lambda: all_loops(60, boxes=True)[0], lambda: all_loops(60, boxes=True)[1]]
)
def test_the_boxes_stated_are_the_condensed_program(make: Callable[[], Sequence]) -> None:
    """Its cost is that of the states that the plant runs through, its rows are the boxes."""
    loop = make()
    own = loop.stated
    assert own is not None
    rng = np.random.default_rng(4)
    n, p = own.b.shape
    both = solve_discrete_are(own.a, own.b, np.diag(own.q + own.rho), np.diag(own.r + own.rho))
    last = both - own.rho * np.eye(n)
    for t in (0, 55):
        told, run, room = [], [], []
        for _ in range(2):
            z = 0.3 * rng.normal(size=loop.variables)
            told.append(0.5 * z @ loop.hessian @ z + loop.linear[t] @ z)
            at = loop.rows @ z
            scale = (own.input_high[t] - own.input_low[t]) / 2.0
            rest = (own.input_high[t] + own.input_low[t]) / -2.0
            x, cost, rows = own.start[t], 0.0, []
            for k, u in enumerate(z.reshape(-1, p) - rest):
                x = own.a @ x + own.b @ u
                weight = last if k == loop.horizon - 1 else np.diag(own.q)
                cost += 0.5 * (x @ weight @ x + u @ np.diag(own.r) @ u)
                limited = own.state_high[t] < 1e9
                size = (own.state_high[t] - own.state_low[t])[limited] / 2.0
                rows += [*((own.input_high[t] - u) / scale)]
                rows += [*((own.state_high[t] - x)[limited] / size)]
            run.append(cost)
            room.append(np.max(np.abs(np.array(rows) - (loop.high[t] - at))))
        assert told[0] - told[1] == pytest.approx(run[0] - run[1], rel=1e-8)
        assert max(room) <= 1e-9


def test_the_servo_drives_programs_are_those_of_its_loop() -> None:
    sequence = with_optima(servo.closed_loop(2))
    assert sequence.active.max() == 2
    assert sequence.active.min() == 0
    problem = tracking_problem(servo.drive(), trajectory=2)
    theta = servo.parameters(servo.drive(), problem)
    recorder = servo.Recorder(problem)
    limit = problem.qp.upper[0]
    for t in range(0, len(theta), 97):
        assert recorder(theta[t])[1][0] == pytest.approx(limit * sequence.optimum[t, 0], abs=1e-6)


def test_a_sequence_that_cannot_be_had_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(steps: int) -> None:
        raise PeerFailed("not installed: qpmpc")

    monkeypatch.setattr(packages, "pendulum", fails)
    (found,) = suite(Path(), True, ("qpmpc_pendulum",))
    assert found == Missing("qpmpc_pendulum_12", "not installed: qpmpc")
    (alone,) = suite(Path(), True, ("sprg_alone",))
    assert isinstance(alone, Missing)
    assert "no quadratic program" in alone.why


def test_headers_that_are_not_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", [])
    with pytest.raises(PeerFailed, match="not installed"):
        libraries.proxsuite_headers()


def test_tinympc_says_what_it_cannot_state(tmp_path: Path) -> None:
    loop = all_loops(50)[0]
    with pytest.raises(PeerFailed, match="cannot state it"):
        libraries.tinympc(loop, slice(0, 1), tmp_path)


def test_packages_that_would_be_replaced() -> None:
    def entry(name: str, version: str) -> dict[str, object]:
        return {"metadata": {"name": name, "version": version}}

    here = np.__version__
    report = json.dumps({"install": [entry("numpy", "1.0"), entry("no-such-package", "1")]})
    assert replacements(report) == [f"numpy {here} by 1.0"]
    assert replacements(json.dumps({"install": [entry("numpy", here)]})) == []


def measured(error: float, solved: bool = True) -> Measured:
    one = np.array([1.0])
    return Measured(
        "any", "instructions", slice(0, 1), 5.0 * one, error * one, 0.0 * one, np.array([solved]),
        np.array([3]), 1, 10, 20, seconds=2e-6 * one,
    )  # fmt: skip


def test_the_first_tolerance_that_gives_the_accuracy() -> None:
    errors = {1e-9: 1e-6, 1e-10: 1e-9, 1e-11: 1e-12}
    found = reaching(lambda asked: measured(errors[asked]), tuple(errors))
    assert found.note == "tolerance 1e-10"
    stopped = reaching(lambda asked: measured(1.0, solved=False), tuple(errors))
    assert stopped.note == "tolerance 1e-09"


def promised(
    name: str, found: float | None, sequence: str = "", how: str = "", of: str = COLUMNS,
    asked: bool = True, fits: bool = True,
) -> dict[str, object]:  # fmt: skip
    kept = found is not None and found <= 0.5
    return {
        "promise": name, "limit": 0.5, "found": found, "kept": kept, "promised": asked,
        "sequence": sequence, "how": how, "solver": of, "fits": fits,
    }  # fmt: skip


def told() -> dict[str, object]:
    sequence = with_optima(all_loops(50)[0])
    found = {"DAQP": measured(0.0), "other": measured(1e-3)}
    rows = [as_json(sequence, found, {"third": "not installed: x"})]
    rows.append({"name": "none", "missing": "has no program"})
    return {
        "whole": True, "seconds": 60, "tinympc_would_replace": "", "sequences": rows,
        "versions": {"gcc": "gcc 12", "machine": "x", "valgrind": "v", "daqp": "0"},
        "promises": [
            promised("right", 0.5),
            promised("never", None),
            promised("small", 0.6, "qpmpc_pendulum_12", "median"),
            promised("slow", 0.3, "servo_drive_10", "median", of=COLUMNS, asked=False),
            promised("beside", 0.7, "none", "median", of=COLUMNS, asked=False, fits=False),
            promised("first", 0.2, "none", "median", of=STAGES),
        ],
    }  # fmt: skip


def test_tables_show_who_missed_who_failed_and_what_is_missing() -> None:
    parts = qp_parts(told())
    assert "1, 1 m" in parts["ratios"]
    assert "| third | not installed: x | all |" in parts["missing"]
    assert "**missing**: has no program" in parts["sequences"]
    assert "| never | 0.5 | not measured | **broken** |" in parts["promises"]
    assert "slow" not in parts["promises"]
    assert "| `servo_drive_10` | - | 0.300 |" in parts["reported"]
    assert "| `none` | 0.200 | **0.700** |" in parts["reported"]
    (line,) = parts["unreached"].splitlines()[2:]
    assert line.startswith(
        "| `qpmpc_pendulum_12` | column rows | median | 0.5 | 0.6 | yes | all 12 "
    )
    assert "2.00 us | 1 |" in parts["times"]


def test_tables_go_into_their_places_alone() -> None:
    page = "before\n<!-- bench:a -->\n\nold\n\n<!-- bench:end -->\nafter\n"
    once = rewritten(page, {"a": "new \\1"})
    assert once == page.replace("old", "new \\1")
    assert rewritten(once, {"a": "old"}) == page
    with pytest.raises(DocumentError, match="one place for b"):
        rewritten(page, {"b": "x"})


def test_the_page_has_a_place_for_every_table() -> None:
    page = (Path(__file__).resolve().parents[2] / "docs" / "benchmarks.md").read_text()
    for name in qp_parts(told()):
        assert page.count(f"<!-- bench:{name} -->") == 1


def test_parts_of_a_run_stay_out_of_the_page() -> None:
    with pytest.raises(DocumentError, match="a part"):
        whole({"whole": False}, Path("qp.json"))


def test_files_are_written_whole(tmp_path: Path) -> None:
    place = tmp_path / "qp.json"
    write("first", place)
    with pytest.raises(TypeError):
        write(None, place)  # type: ignore[arg-type]
    assert place.read_text() == "first"
    write("second", place)
    assert [each.name for each in tmp_path.glob("qp.json")] == ["qp.json"]
    assert place.read_text() == "second"


def test_a_run_that_is_broken_off_writes_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stopped(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(qp_solvers, "suite", stopped)
    monkeypatch.setattr(qp_solvers.shutil, "which", lambda tool: tool)
    monkeypatch.setattr(sys, "argv", ["qp_solvers.py", "-o", str(tmp_path)])
    assert qp_solvers.main() == 130
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("script", [qp_solvers, lookups])
def test_a_name_that_fits_nothing_is_told(
    script: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.setattr(script.shutil, "which", lambda tool: tool)
    words = [f"{script.__name__}.py", "-o", str(tmp_path), "--only", "servo_drive_2", "servo_"]
    monkeypatch.setattr(sys, "argv", [*words, "servo_driv"])
    assert script.main() == 2
    told = capsys.readouterr().err
    assert "nothing here is called servo_driv, nor begins with servo_driv_; there are " in told
    assert "servo_drive_3" in told
    assert not list(tmp_path.iterdir())
