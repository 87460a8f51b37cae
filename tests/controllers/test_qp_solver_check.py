"""Arguments of a quadratic program: what cannot be used is refused in one sentence."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from servogen.controllers.qp_solver import QpSolver
from servogen.controllers.qp_solver_check import LARGEST
from servogen.controllers.qp_solver_design import (
    QpSolverDesign,
    design_plant_qp_solver,
    design_qp_solver,
)
from servogen.precision import FLOAT32, FLOAT64, Precision
from servogen.qp.errors import ProgramError
from servogen.qp.row_tables import StageRows, stage_rows

NAN, INF = float("nan"), float("inf")
SUM = [1.0, 1.0]
PLAIN: dict[str, Any] = {
    "prefix": "plain",
    "precision": FLOAT64,
    "hessian": [[2.0, 0.5], [0.5, 1.0]],
    "rows": [[1.0, 0.0], [0.0, 1.0], SUM],
    "cap": 20,
    "accept": 1e-9,
}
# What is changed, the quantity named, and a word of the sentence.
REFUSED: tuple[tuple[dict[str, Any], str, str], ...] = (
    ({"hessian": [[2.0, 0.5]]}, "hessian", "square"),
    ({"hessian": [2.0, 0.5]}, "hessian", "matrix"),
    ({"hessian": [[2.0, 0.5], [0.5]]}, "hessian", "matrix of numbers"),
    ({"hessian": [["a", 0.5], [0.5, 1.0]]}, "hessian", "matrix of numbers"),
    ({"hessian": np.eye(2) * 1j}, "hessian", "matrix of numbers"),
    ({"hessian": [[10**400, 0], [0, 1]]}, "hessian", "matrix of numbers"),
    ({"hessian": [[1e-320, 1e300], [1e300, 1.0]]}, "hessian", "positive definite"),
    ({"hessian": np.zeros((0, 0))}, "hessian", "row at least"),
    ({"hessian": [[2.0, NAN], [NAN, 1.0]]}, "hessian", "finite"),
    ({"hessian": [[2.0, INF], [INF, 1.0]]}, "hessian", "finite"),
    ({"hessian": [[2.0, 0.5], [0.4, 1.0]]}, "hessian", "symmetric"),
    ({"hessian": [[1e16, 0.5], [0.4, 1e-16]]}, "hessian", "symmetric"),
    ({"hessian": [[2.0, 0.0], [0.0, 0.0]]}, "hessian", "positive definite"),
    ({"hessian": [[1.0, 2.0], [2.0, 1.0]]}, "hessian", "positive definite"),
    ({"hessian": [[1.0, 1.0], [1.0, 1.0 + 1e-13]]}, "hessian", "above 1e-12 in float64"),
    ({"hessian": [[1e-320, 0.0], [0.0, 1.0]]}, "hessian", "scaled nearer to one"),
    ({"hessian": np.eye(2) * 1e307}, "hessian", "scaled nearer to one"),
    ({"rows": np.zeros((0, 2))}, "rows", "row at least"),
    ({"rows": [[1.0], [2.0]]}, "rows", "2, as H"),
    ({"rows": [1.0, 2.0]}, "rows", "row at least"),
    ({"rows": [[1.0, 0.0], [0.0, 0.0]]}, "rows[1]", "zero"),
    ({"rows": [[1.0, 0.0], [0.0, NAN]]}, "rows", "finite"),
    ({"rows": [[1.0, 0.0], [0.0, 1e-250]]}, "rows[1]", "scaled nearer to one"),
    ({"cap": 0}, "cap", "whole number from 1 to 100000"),
    ({"cap": 100_001}, "cap", "whole number"),
    ({"cap": 20.0}, "cap", "whole number"),
    ({"cap": True}, "cap", "whole number"),
    ({"accept": 0.0}, "accept", "above zero"),
    ({"accept": -1e-9}, "accept", "above zero"),
    ({"accept": NAN}, "accept", "above zero"),
    ({"accept": INF}, "accept", "above zero"),
    ({"accept": "1e-9"}, "accept", "above zero"),
    ({"accept": True}, "accept", "above zero"),
    ({"accept": 2.0}, "accept", "to the bound itself"),
    ({"accept": 1e300}, "accept", "to the bound itself"),
    ({"accept": 1e-30}, "accept", "what float64 leaves of a bound"),
    ({"accept": 1e-12, "precision": FLOAT32}, "accept", "what float32 leaves of a bound"),
    ({"accept": 1e-60, "precision": FLOAT32}, "accept", "what float32 leaves of a bound"),
    ({"precision": "float64"}, "precision", "FLOAT64"),
    ({"precision": None}, "precision", "FLOAT64"),
    ({"prefix": "two words"}, "prefix", "identifier"),
    ({"prefix": "while"}, "prefix", "identifier"),
    ({"prefix": "size"}, "prefix", "identifier"),
    ({"prefix": "sg_qp"}, "prefix", "identifier"),
    ({"prefix": ""}, "prefix", "identifier"),
    ({"prefix": "a" * 32}, "prefix", "31 characters"),
    ({"bounds": 3}, "bounds", "from 0 to 2"),
    ({"bounds": -1}, "bounds", "from 0 to 2"),
    ({"bounds": 1, "rows": [SUM, [0.0, 1.0]]}, "rows[0]", "bound of one variable"),
    ({"bounds": 2, "rows": [[0.0, 1.0], [1.0, 0.0]]}, "rows[0]", "bound of one variable"),
    ({"per_step": 4}, "per_step", "from 0 to 3"),
    ({"per_step": 2}, "per_step", "divisor"),
    ({"per_step": 1, "inputs": 1}, "per_step", "2 steps"),
    ({"per_step": -1}, "per_step", "from 0 to 3"),
    ({"staying": 2, "bounds": 2}, "staying", "from 0 to 1"),
    ({"staying": 0.5}, "staying", "whole number"),
    ({"inputs": 3}, "inputs", "from 0 to 2"),
)


@pytest.mark.parametrize(("changed", "key", "said"), REFUSED)
def test_an_argument_is_refused_in_a_sentence(changed: dict[str, Any], key: str, said: str) -> None:
    design_qp_solver(**PLAIN)
    with np.errstate(all="raise"), pytest.raises(ProgramError) as told:
        design_qp_solver(**PLAIN | changed)
    assert told.value.key == key
    assert said in str(told.value)
    assert "\n" not in str(told.value)


def test_inputs_divide_the_variables() -> None:
    rows = np.vstack([np.eye(3), np.ones(3)])
    with pytest.raises(ProgramError, match="divisor of the 3 variables"):
        design_qp_solver("three", FLOAT64, np.eye(3), rows, 9, 1e-9, bounds=3, inputs=2)


def plant(precision: Precision = FLOAT64, gain: float = 0.1) -> StageRows:
    stage = np.array([[1.0, 0.1, 0.005], [0.0, 1.0, gain]])
    return stage_rows(stage, np.zeros((0, 2)), 4, 2, precision.dtype)


@pytest.mark.parametrize(
    ("changed", "key"),
    [
        ({"hessian": np.eye(3)}, "rows"),
        ({"rows": plant(FLOAT32)}, "rows"),
        ({"rows": plant(gain=1e250)}, "hessian"),
        ({"hessian": -np.eye(4)}, "hessian"),
        ({"hessian": np.eye(4) * 1e-220}, "hessian"),
        ({"rows": np.ones((4, 4))}, "rows"),
        ({"precision": "float64"}, "precision"),
        ({"accept": True}, "accept"),
        ({"accept": 2.0}, "accept"),
        ({"accept": 1e-30}, "accept"),
        ({"cap": 0}, "cap"),
        ({"accept": NAN}, "accept"),
        ({"prefix": "int"}, "prefix"),
    ],
)
def test_a_plants_arguments_are_refused_as_well(changed: dict[str, Any], key: str) -> None:
    given: dict[str, Any] = PLAIN | {"hessian": np.eye(4), "rows": plant()}
    design_plant_qp_solver(**given)
    with pytest.raises(ProgramError) as told:
        design_plant_qp_solver(**given | changed)
    assert told.value.key == key


STAGE: dict[str, Any] = {
    "stage": [[1.0, 0.1, 0.005], [0.0, 1.0, 0.1]],
    "terminal": np.zeros((0, 2)),
    "steps": 4,
    "limited": 2,
    "dtype": FLOAT64.dtype,
    "bounds": [1.0],
}


@pytest.mark.parametrize(
    ("changed", "key", "said"),
    [
        ({"stage": np.full((2, 3), NAN)}, "stage", "finite"),
        ({"stage": [1.0, 2.0]}, "stage", "row at least"),
        ({"stage": [[1.0, 0.1, 0.005]]}, "stage", "each of its 2 states"),
        ({"stage": 1e40 * np.array(STAGE["stage"]), "steps": 10}, "stage", "beyond float64"),
        ({"limited": 3}, "limited", "from 0 to 2"),
        ({"limited": -1}, "limited", "from 0 to 2"),
        ({"steps": 0}, "steps", "from 1"),
        ({"steps": "10"}, "steps", "whole number"),
        ({"inputs": 2}, "limited", "from 0 to 1"),
        ({"inputs": 2, "limited": 1}, "terminal", "1, the states"),
        ({"inputs": 3}, "inputs", "from 1 to 2"),
        ({"terminal": np.zeros((0, 3))}, "terminal", "2, the states"),
        ({"outer": [[1.0, 0.0]]}, "outer", "3, as stage"),
        ({"bounds": np.ones(2)}, "bounds", "at most 1"),
        ({"bounds": [0.0]}, "bounds[0]", "factor"),
        ({"bounds": [NAN]}, "bounds", "finite"),
        ({"dtype": np.dtype(np.float16)}, "dtype", "float32 or float64"),
    ],
)  # fmt: skip
def test_a_stage_that_cannot_be_used_is_refused_in_a_sentence(
    changed: dict[str, Any], key: str, said: str
) -> None:
    with np.errstate(all="raise"), pytest.raises(ProgramError) as told:
        stage_rows(**STAGE | changed)
    assert told.value.key == key
    assert said in str(told.value)


def test_lists_names_and_numpy_numbers_do_as_well() -> None:
    rows = stage_rows(**STAGE)
    named = stage_rows(**STAGE | {"dtype": "float64", "stage": np.array(STAGE["stage"])})
    assert np.array_equal(rows.impulse, named.impulse)
    for precision in (FLOAT32, FLOAT64):
        for accept in (np.float32(1e-4), np.float64(1e-4)):
            with np.errstate(all="raise"):
                design = design_qp_solver(**PLAIN | {"precision": precision, "accept": accept})
            assert float(design.tables.accept) == pytest.approx(1e-4)


def near_singular(ratio: float) -> tuple[np.ndarray, np.ndarray]:
    """H with a unit diagonal, eigenvalues 1.. and ``ratio`` of it; and rows."""
    rng = np.random.default_rng(4)
    square = np.linalg.qr(rng.normal(size=(6, 6)))[0]
    hessian = square @ np.diag(np.geomspace(ratio, 1.0, 6)) @ square.T
    unit = 1.0 / np.sqrt(np.diag(hessian))
    return hessian * np.outer(unit, unit), rng.normal(size=(8, 6))


def answer(design: QpSolverDesign, f: np.ndarray, width: np.ndarray) -> np.ndarray:
    solver = QpSolver(design)
    solver.call("reset")
    status, out = solver.call("step", {"linear": f, "low": -width, "high": width})
    assert status.name == "OK"
    return np.asarray(out["z"], dtype=float)


def test_float32_takes_no_hessian_that_costs_more_than_four_digits() -> None:
    rng = np.random.default_rng(5)
    hessian, rows = near_singular(2e-4)
    single = design_qp_solver("single", FLOAT32, hessian, rows, 200, 1e-4)
    double = design_qp_solver("exact", FLOAT64, hessian, rows, 200, 1e-9)
    for _ in range(20):
        z = rng.normal(size=6)
        f, width = -hessian @ z, np.abs(rows @ z) * rng.uniform(0.3, 1.5, 8)
        exact = answer(double, f, width)
        assert np.max(np.abs(answer(single, f, width) - exact)) <= 3e-3 * np.max(np.abs(exact))
    for ratio in (3e-5, 5e-7, 1e-8):
        hessian, rows = near_singular(ratio)
        design_qp_solver("exact", FLOAT64, hessian, rows, 200, 1e-9)
        with pytest.raises(ProgramError, match=r"above 0\.0001 in float32"):
            design_qp_solver("single", FLOAT32, hessian, rows, 200, 1e-4)


@pytest.mark.parametrize("precision", [FLOAT32, FLOAT64])
def test_what_is_accepted_gives_numbers_at_the_largest_inputs(precision: Precision) -> None:
    """From the smallest Hessian that is taken to the largest; beyond, a sentence."""
    far, rng = LARGEST[precision.name], np.random.default_rng(6)
    square = rng.normal(size=(4, 4))
    hessian, rows = square @ square.T + 0.5 * np.eye(4), rng.normal(size=(6, 4))
    taken, sentences = [], []
    exponents = np.linspace(-45, 45, 31) * (1.0 if precision.is_float32 else 6.8)
    for exponent in exponents:
        try:
            design = design_qp_solver(
                "far", precision, hessian * 10.0**exponent, rows, 60, 1e-6 * 10.0 ** (exponent / 2)
            )
        except ProgramError as refused:
            sentences.append(str(refused))
            continue
        taken.append(exponent)
        solver = QpSolver(design)
        with np.errstate(over="raise", invalid="raise", divide="raise"):
            for width in (far, 1e-3 * far, 1.0):
                solver.call("reset")
                given = {"low": np.full(6, -width), "high": np.full(6, width)}
                status, out = solver.call("step", {"linear": far * np.sign(rows[0]), **given})
                assert status.name != "NOT_FINITE"
                assert np.all(np.isfinite(np.asarray(out["z"])))
    assert exponents[0] < min(taken) < 0.0 < max(taken) < exponents[-1]
    assert len(taken) >= 10
    assert all("nearer to one" in said for said in sentences)


def test_a_hessian_as_small_as_1e_28_is_no_number_in_float32() -> None:
    with pytest.raises(ProgramError, match=r"hessian is so small .* scaled nearer to one"):
        design_qp_solver("small", FLOAT32, 1e-28 * np.eye(2), np.eye(2), 20, 1e-4, bounds=2)


@pytest.mark.parametrize("reach", [10.0, 100.0, 1000.0])
def test_an_accept_above_what_rows_round_to_ends_in_no_backup_though_rows_depend(
    reach: float,
) -> None:
    """Float32, exactly dependent rows, an optimum without rows that is so many bounds away: the
    rule of the page. A tenth of it shows that the programs are hard enough to tell."""
    rng, ended = np.random.default_rng(9), {1.0: 0, 0.1: 0}
    for _ in range(6):
        rows = rng.normal(size=(16, 3)) @ rng.normal(size=(3, 8))
        square = np.linalg.qr(rng.normal(size=(8, 8)))[0]
        hessian = square @ np.diag(10.0 ** rng.uniform(-1.0, 0.0, 8)) @ square.T
        hessian = 0.5 * (hessian + hessian.T)
        length = np.sqrt(np.einsum("ij,ij->i", rows, np.linalg.solve(hessian, rows.T).T))
        free = reach * rng.normal(size=8)
        low, high = -length * (0.5 + rng.random(16)), length * (0.5 + rng.random(16))
        far = float(np.max(np.abs(rows @ free) / length))
        for share in ended:
            accept = share * far * float(np.finfo(np.float32).eps)
            solver = QpSolver(design_qp_solver("far", FLOAT32, hessian, rows, 200, accept))
            solver.call("reset")
            status, _ = solver.call("step", {"linear": -hessian @ free, "low": low, "high": high})
            ended[share] += status.name == "BACKUP"
    assert ended[1.0] == 0
    assert ended[0.1] > 0
