"""A certified number of iterations and rounding: when it is taken back, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from servogen.explicit.errors import ExplicitError
from servogen.explicit.iteration_certificate import certify_iterations
from servogen.explicit.iteration_program import IterationProgram, iteration_program
from servogen.explicit.iteration_trials import iterations_taken, points_inside
from servogen.precision import FLOAT32, FLOAT64
from servogen.qp.active_set_factor import WorkingSet, empty_set
from servogen.qp.dual_active_set import ActiveSetResult
from servogen.qp.parametric import ParametricQP, parameter_box, parametric_qp

BUDGET = 100_000


def drawn_program(seed: int) -> ParametricQP:
    """Three variables, six rows, two parameters in a unit box."""
    rng = np.random.default_rng(seed)
    square = rng.normal(size=(3, 3))
    box, bounds = parameter_box(-np.ones(2), np.ones(2))
    return parametric_qp(
        square @ square.T + 0.05 * np.eye(3),
        3.0 * rng.normal(size=(3, 2)),
        rows=rng.normal(size=(6, 3)),
        bounds=rng.uniform(0.2, 1.0, 6),
        bounds_parameter=0.2 * rng.normal(size=(6, 2)),
        domain_rows=box,
        domain_bounds=bounds,
    )


@pytest.mark.parametrize(
    ("seed", "accept", "warm", "bound"),
    [
        (0, 1e-6, False, 6),  # the witness itself takes more
        (1, 1e-6, False, 4),  # three calls in a thousand do
        (1, 1e-6, True, 6),
    ],
)
def test_a_bound_that_rounding_breaks_stays_what_it_was_and_is_not_exact(
    seed: int, accept: float, warm: bool, bound: int
) -> None:
    program = iteration_program(drawn_program(seed), FLOAT32, 200, accept)
    found = certify_iterations(program, BUDGET, warm=warm)
    assert found.finished
    assert found.bound == bound == len(found.by_iterations) - 1
    assert found.refuted > bound
    assert not found.exact


@pytest.mark.parametrize("warm", [False, True])
def test_one_call_that_takes_more_than_the_bound_takes_it_back(
    warm: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A method that takes 40 where the first parameter lies in a slice of the set, and, warm, only
    after the tenth call of a sequence: no witness goes there."""
    program = iteration_program(drawn_program(0), FLOAT64, 200, 1e-6)
    exact = certify_iterations(program, BUDGET, warm=warm)
    assert exact.exact
    honest, calls = IterationProgram.solve, dict[int, int]()

    def solve(
        self: IterationProgram, theta: np.ndarray, work: WorkingSet, cap: int
    ) -> ActiveSetResult:
        calls[id(work.dual)] = calls.get(id(work.dual), 0) + 1 if work.size else 1
        result = honest(self, theta, work, cap)
        late = not warm or calls[id(work.dual)] > 10
        return replace(result, iterations=40) if late and 0.7 < theta[0] < 0.72 else result

    monkeypatch.setattr(IterationProgram, "solve", solve)
    found = certify_iterations(program, BUDGET, warm=warm)
    assert (found.bound, found.attained, found.refuted) == (exact.bound, exact.bound, 40)
    assert not found.exact


@pytest.mark.parametrize("seed", [0, 1])
def test_an_accept_that_rounding_leaves_alone_is_exact_in_either_precision(seed: int) -> None:
    for precision, accept in ((FLOAT32, 2e-4), (FLOAT64, 1e-6)):
        program = iteration_program(drawn_program(seed), precision, 200, accept)
        found = certify_iterations(program, BUDGET, warm=False)
        assert found.exact
        assert found.refuted == 0


# Hessian's product of the two variables, f, rows and bounds; and two calls of which the second
# takes an iteration more than any piece. One call in 700 to 4,000 does: no trial met it.
REFINED = (
    (
        -0.4443555, [[-0.87093054, 1.79838603], [1.14993178, 0.02891352]],
        [[0.31847204, 1.2799632]], [0.2665707],
        [[0.64050535, 2.27280615], [2.40355667, -3.0]],
    ),
    (
        -0.30478605, [[0.81502914, -1.03333967], [0.43175396, -0.85030921]],
        [[0.99900484, 0.2611788], [0.12541739, -2.19345537]], [0.82473077, 0.34516585],
        [[1.08662889, -1.59279377], [-2.78162596, 2.82151866]],
    ),
)  # fmt: skip


@pytest.mark.parametrize(("product", "linear", "rows", "reach", "calls"), REFINED)
def test_an_accept_that_rows_may_round_to_is_not_exact_though_every_trial_holds(
    product: float,
    linear: list[list[float]],
    rows: list[list[float]],
    reach: list[float],
    calls: list[list[float]],
) -> None:
    box, bounds = parameter_box(-3.0 * np.ones(2), 3.0 * np.ones(2))
    qp = parametric_qp(
        [[1.0, product], [product, 1.0]], linear, rows=rows, bounds=reach, lower=-np.ones(2),
        upper=np.ones(2), domain_rows=box, domain_bounds=bounds,
    )  # fmt: skip
    for precision, accept, exact in (
        (FLOAT32, 1e-6, False), (FLOAT32, 1e-4, True), (FLOAT64, 1e-6, True)
    ):  # fmt: skip
        program = iteration_program(qp, precision, 50, accept)
        found = certify_iterations(program, 2500)
        assert (found.finished, found.attained, found.refuted) == (True, found.bound, 0)
        assert found.exact == exact == (not found.rounds)
        taken = iterations_taken(program, np.array(calls), 50)[-1]
        assert taken == found.bound + (0 if exact else 1)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_what_rows_of_the_set_miss_is_below_what_they_are_said_to_round_to(seed: int) -> None:
    program = iteration_program(drawn_program(seed), FLOAT32, 200, 1e-3)
    found, rng = certify_iterations(program, BUDGET, warm=False), np.random.default_rng(seed)
    rows, missed = program.tables.rows, [0.0]
    for _ in range(300):
        theta = rng.uniform(-1.0, 1.0, 2)
        result = program.solve(theta, empty_set(program.tables), 200)
        if result.optimal and result.iterations:
            at, given = rows.product(result.z), np.append(theta, 1.0)
            sides = np.minimum(np.abs(at - program.high @ given), np.abs(at - program.low @ given))
            missed += [float(sides[i]) for i in result.active]
    assert 0.0 < max(missed) < found.rounding < 1e-3


def test_an_accept_that_the_pieces_cannot_tell_from_nothing_is_refused() -> None:
    for seed, accept in ((0, 1e-8), (0, 1e-9), (3, 1e-9)):
        program = iteration_program(drawn_program(seed), FLOAT64, 200, accept)
        with pytest.raises(ExplicitError, match=f"accept is {accept}, expected at least") as told:
            certify_iterations(program, BUDGET, warm=False)
        least = float(str(told.value).partition("at least ")[2].partition(",")[0])
        enough = iteration_program(drawn_program(seed), FLOAT64, 200, least)
        assert certify_iterations(enough, BUDGET, warm=False).exact


def test_the_parameters_of_the_trials_are_all_over_the_set() -> None:
    rows = np.array([[-1.0, 0.0], [0.0, -1.0], [1.0, 1.0]]) / np.array([[1], [1], [np.sqrt(2.0)]])
    bounds = np.array([0.0, 0.0, np.sqrt(0.5)])
    points = points_inside(rows, bounds, np.array([0.3, 0.3]))
    assert np.all(points @ rows.T <= bounds + 1e-12)
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    for corner in corners:
        assert np.min(np.linalg.norm(points - corner, axis=1)) < 0.15
    assert np.min(np.linalg.norm(points - 0.3, axis=1)) < 0.01


@pytest.mark.parametrize(
    "turned",
    [
        1e-3,  # the first row is violated everywhere, by the same amount
        8e-6,  # and the second one depends on it so nearly that it is appended last of all
    ],
)
def test_a_row_that_is_always_violated_and_one_nearly_against_it(turned: float) -> None:
    box, bounds = parameter_box([-1.0], [1.0])
    qp = parametric_qp(
        np.eye(2), np.zeros((2, 1)), rows=[[1.0, 0.0], [-1.0, turned]], bounds=[-0.5, 0.4],
        bounds_parameter=[[0.0], [0.2]], domain_rows=box, domain_bounds=bounds,
    )  # fmt: skip
    program = iteration_program(qp, FLOAT64, 200, 1e-4)
    found = certify_iterations(program, BUDGET, warm=False)
    results = [
        program.solve(np.array([theta]), empty_set(program.tables), 200)
        for theta in np.linspace(-1.0, 1.0, 201)
    ]
    assert all(result.optimal for result in results)
    assert {r.iterations for r in results} == {i for i, n in enumerate(found.by_iterations) if n}
    assert found.exact
    assert found.infeasible == 0
