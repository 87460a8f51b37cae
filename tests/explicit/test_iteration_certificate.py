"""A certified number of iterations and rounding: when it is taken back, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from servogen.explicit.errors import ExplicitError
from servogen.explicit.iteration_certificate import certify_iterations
from servogen.explicit.iteration_program import IterationProgram, iteration_program
from servogen.explicit.iteration_trials import points_inside
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
    for precision, accept in ((FLOAT32, 1e-4), (FLOAT64, 1e-6)):
        program = iteration_program(drawn_program(seed), precision, 200, accept)
        found = certify_iterations(program, BUDGET, warm=False)
        assert found.exact
        assert found.refuted == 0


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
