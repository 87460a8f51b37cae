"""The feasible set of a parametric program against linear programs, parameter by parameter."""

import numpy as np
import pytest
from explicit_problems import (
    double_integrator,
    random_program,
    servo_drive,
    toolbox_double_integrator,
    transport,
)
from scipy.optimize import linprog

from servogen.explicit.explore import solve
from servogen.explicit.feasible import FeasibleSet, always_feasible, feasible_set
from servogen.qp.parametric import ParametricQP, parametric_qp

PROGRAMS = {
    "double integrator": double_integrator(5),
    "transport": transport(),
    "one": random_program(1, 3, 2, 6),
    "two": random_program(2, 2, 3, 5),
    "three": random_program(3, 4, 2, 8),
    # seen in fewer coordinates than there are parameters
    "toolbox": toolbox_double_integrator(),
    "servo": servo_drive(2, inside_box=True),
}


def has_solution(problem: ParametricQP, theta: np.ndarray) -> bool:
    """HiGHS, on the program as it was stated."""
    g, w, s, _ = problem.all_rows()
    if np.any(problem.domain_rows @ theta > problem.domain_bounds):
        return False
    free = [(None, None)] * problem.variables
    found = linprog(np.zeros(problem.variables), g, w + s @ theta, bounds=free, method="highs")
    return found.status == 0


def excess(own: FeasibleSet, theta: np.ndarray) -> float:
    return float(np.max(own.rows @ theta - own.bounds))


@pytest.mark.parametrize("name", PROGRAMS)
def test_it_is_feasible_where_a_linear_program_says_so(name: str) -> None:
    problem = PROGRAMS[name]
    solution = solve(problem, 400)
    own = feasible_set(solution)
    generator = np.random.default_rng(4)
    centre = np.linalg.pinv(solution.image.matrix) @ (
        solution.regions[0].centre - solution.image.offset
    )
    wide = min(1.0, 2.0 / np.sqrt(problem.parameters))  # that some are inside on every side
    seen = {True: 0, False: 0}
    for i in range(300):
        theta = centre + wide * generator.normal(size=problem.parameters) * np.abs(
            problem.domain_bounds[: problem.parameters]
        )
        if i % 2:  # on a facet, and a little to either side
            row = int(generator.integers(own.bounds.size))
            away = own.rows[row] @ (theta - centre)
            if abs(away) < 1e-9:
                continue
            share = (own.bounds[row] - own.rows[row] @ centre) / away
            theta = centre + (theta - centre) * share * (1.0 + generator.choice([1e-5, -1e-5]))
        margin = excess(own, theta)
        if abs(margin) < 1e-8:
            continue
        assert has_solution(problem, theta) == (margin < 0.0)
        seen[margin < 0.0] += 1
    assert min(seen.values()) > 25


@pytest.mark.parametrize("name", PROGRAMS)
def test_no_row_is_redundant(name: str) -> None:
    """Without it, some parameter counts as feasible that is not."""
    own = feasible_set(solve(PROGRAMS[name], 400))
    for i in range(own.bounds.size):
        others = np.delete(np.arange(own.bounds.size), i)
        found = linprog(
            -own.rows[i], own.rows[others], own.bounds[others],
            bounds=[(None, None)] * own.rows.shape[1], method="highs",
        )  # fmt: skip
        assert found.status == 3 or -found.fun > own.bounds[i] + 1e-9


def test_bounds_alone_leave_every_parameter_feasible() -> None:
    assert always_feasible(servo_drive(2))
    assert not always_feasible(servo_drive(2, inside_box=True))
    assert not always_feasible(double_integrator(3))
    one_sided = parametric_qp(np.eye(2), np.eye(2), upper=[1.0, 1.0])
    assert always_feasible(one_sided)
    assert not feasible_set(solve(one_sided, 10)).bounds.size
