"""Explicit solutions are proved from their programs alone, and broken ones are refuted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from explicit_problems import (
    double_integrator,
    random_program,
    regulator_2002,
    servo_drive,
    toolbox_double_integrator,
    transport,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from servogen.explicit.certify import Certified, certify
from servogen.explicit.clips import without_first_bounds
from servogen.explicit.cover import facet_of, generic_point
from servogen.explicit.explore import solve
from servogen.explicit.feasible import feasible_set
from servogen.explicit.optimality import prove_optimal
from servogen.explicit.regions import Region
from servogen.explicit.restated import restate
from servogen.explicit.rim import prove_rim
from servogen.explicit.solution import ExplicitSolution, Laws
from servogen.explicit.tolerances import HOLE, PROVED, PROVED_LAW
from servogen.progress import Silent
from servogen.qp.parametric import ParametricQP, parametric_qp


def degenerate() -> ParametricQP:
    """Rows that depend on each other wherever they are active: several active sets are optimal."""
    plain = double_integrator(3)
    return replace(
        plain,
        rows=np.vstack([plain.rows, plain.rows[0], plain.rows[0] + plain.rows[1]]),
        bounds=np.concatenate([plain.bounds, [plain.bounds[0], plain.bounds[0] + plain.bounds[1]]]),
        bounds_parameter=np.vstack([
            plain.bounds_parameter, plain.bounds_parameter[0],
            plain.bounds_parameter[0] + plain.bounds_parameter[1],
        ]),
    )  # fmt: skip


def steps(moves: int) -> ParametricQP:
    """The servo drive with limits on the current's steps as well: moves + 1 coordinates, no domain,
    rows that depend on each other."""
    plain = servo_drive(moves)
    rows = np.eye(moves) - np.eye(moves, k=-1)
    previous = np.zeros((moves, plain.parameters))
    previous[0, 4] = 1.0
    return parametric_qp(
        plain.hessian, plain.linear, rows=np.vstack([rows, -rows]),
        bounds=np.full(2 * moves, 300.0), bounds_parameter=np.vstack([previous, -previous]),
        lower=plain.lower, upper=plain.upper,
    )  # fmt: skip


PROGRAMS: dict[str, Callable[[], ParametricQP]] = {
    "servo": lambda: servo_drive(3),
    "servo, a third of the regions": lambda: without_first_bounds(servo_drive(3))[0],
    "servo, 243 regions": lambda: servo_drive(5, 5),
    "servo in a box": lambda: servo_drive(3, inside_box=True),
    "steps": lambda: steps(2),
    "position and velocity": lambda: double_integrator(5),
    "dependent rows": degenerate,
    "three steps": lambda: steps(3),
    "2002": regulator_2002,
    "toolbox": toolbox_double_integrator,
    "transport": transport,
    "two first moves": lambda: random_program(3, 4, 3, 6, 2),
    "nothing bounds it": lambda: parametric_qp(np.eye(2), np.eye(2)),
}


def proved(solution: ExplicitSolution) -> Certified:
    return certify(solution, Silent())


def with_region(solution: ExplicitSolution, index: int, **changes: object) -> ExplicitSolution:
    regions = list(solution.regions)
    regions[index] = replace(regions[index], **changes)
    return replace(solution, regions=tuple(regions))


def moved(region: Region, row: int, by: float) -> np.ndarray:
    k = region.k.copy()
    k[row] += by
    return k


@pytest.mark.parametrize("name", PROGRAMS)
def test_true_solutions_are_proved(name: str) -> None:
    solution = solve(PROGRAMS[name](), 2000)
    found = proved(solution)
    assert found.holds, found
    assert found.cover.facets > 0 or len(solution.regions) == 1
    assert found.optimal.rows >= len(solution.regions) - 1


@settings(max_examples=25, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 2**32 - 1), n=st.integers(1, 4), p=st.integers(1, 3), m=st.integers(0, 6)
)
def test_random_programs_are_proved_and_a_region_less_is_not(
    seed: int, n: int, p: int, m: int
) -> None:
    solution = solve(random_program(seed, n, p, m, first_move=min(n, 2)), 3000)
    assert proved(solution).holds
    if len(solution.regions) > 1:
        largest = max(range(len(solution.regions)), key=lambda i: solution.regions[i].radius)
        kept = [i for i in range(len(solution.regions)) if i != largest]
        less = replace(
            solution,
            regions=tuple(solution.regions[i] for i in kept),
            law_of=solution.law_of[kept],
        )
        assert not proved(less).holds


@pytest.mark.parametrize("name", ["servo", "steps", "position and velocity", "servo in a box"])
def test_half_of_the_regions_is_not_enough(name: str) -> None:
    solution = solve(PROGRAMS[name](), 2000)
    half = replace(solution, regions=solution.regions[::2], law_of=solution.law_of[::2])
    found = proved(half)
    assert not found.covers
    assert found.cover.open
    assert found.optimal.reach <= PROVED  # what is left is right


def test_no_region_covers_nothing() -> None:
    solution = solve(double_integrator(3), 100)
    assert not proved(replace(solution, regions=(), law_of=solution.law_of[:0])).holds


@pytest.mark.parametrize("name", ["servo", "steps", "position and velocity"])
def test_a_law_that_is_another_is_refuted(name: str) -> None:
    solution = solve(PROGRAMS[name](), 2000)
    laws = solution.laws
    assert law_error(solution) <= PROVED_LAW
    for index in range(0, laws.count, 2):
        gains, offsets = laws.gains.copy(), laws.offsets.copy()
        gains[index] += 1e-6 * np.max(np.abs(gains))
        offsets[index] += 1e-6 * np.max(np.abs(offsets))
        assert law_error(replace(solution, laws=Laws(gains, laws.offsets))) > PROVED_LAW
        assert law_error(replace(solution, laws=Laws(laws.gains, offsets))) > PROVED_LAW
    swapped = solution.law_of.copy()
    swapped[0] = (swapped[0] + 1) % laws.count
    assert law_error(replace(solution, law_of=swapped)) > PROVED_LAW


def law_error(solution: ExplicitSolution) -> float:
    program = solution.program
    own = restate(solution.problem, solution.image, program.domain_rows, program.domain_bounds)
    task = Silent().task("")
    with task as told:
        found = prove_optimal(own, solution.regions, solution.law_of, solution.laws, told)
    return found.law_error


@pytest.mark.parametrize("name", ["servo", "steps", "position and velocity", "dependent rows"])
def test_a_facet_moved_is_refuted(name: str) -> None:
    """Outward its active set is no longer optimal; inward a gap is left, unless another region
    lies there as well."""
    solution = solve(PROGRAMS[name](), 2000)
    gaps = 0
    for index in range(0, len(solution.regions), max(1, len(solution.regions) // 5)):
        region = solution.regions[index]
        row = index % region.k.size
        outward = proved(with_region(solution, index, k=moved(region, row, 1e-3)))
        assert outward.optimal.reach > 1e-4
        if not is_elsewhere(solution, index, row):
            inward = proved(with_region(solution, index, k=moved(region, row, -1e-3)))
            assert not inward.covers
            gaps += 1
    assert gaps > 0


def is_elsewhere(solution: ExplicitSolution, index: int, row: int) -> bool:
    """Whether a point just inside a facet is in another region too."""
    region = solution.regions[index]
    point, _ = generic_point(facet_of(region, solution.program, row)) or (region.centre, 0.0)
    point = point - 5e-4 * region.h[row]
    return any(
        np.all(other.h @ point <= other.k) for other in solution.regions if other is not region
    )


def test_another_active_set_is_refuted() -> None:
    solution = solve(double_integrator(5), 500)
    other = solution.regions[1].active
    assert not proved(with_region(solution, 0, active=other)).holds
    twice = with_region(solution, 1, active=(*other, other[0]))
    assert not proved(twice).holds


def test_coordinates_that_hide_a_parameter_are_refuted() -> None:
    solution = solve(servo_drive(3), 100)
    image = solution.image
    matrix = image.matrix.copy()
    matrix[:, 0] = 0.0
    program = replace(solution.program, image=replace(image, matrix=matrix))
    assert not proved(replace(solution, program=program)).holds


def test_a_domain_that_is_cut_short_is_refuted() -> None:
    solution = solve(double_integrator(3), 100)
    program = replace(solution.program, domain_bounds=solution.program.domain_bounds * 0.9)
    assert proved(replace(solution, program=program)).domain > 1e-3


def test_slivers_are_measured() -> None:
    """A facet drawn in by less than a sliver leaves a gap that is told, and bounded."""
    solution = solve(double_integrator(3), 100)
    row = 0
    region = solution.regions[0]
    found = proved(with_region(solution, 0, k=moved(region, row, -1e-9)))
    assert found.cover.hole <= HOLE
    assert found.holds


ROWS = {
    "position and velocity": lambda: double_integrator(5),
    "transport": transport,
    "random": lambda: random_program(2, 2, 3, 4),
    "steps": lambda: steps(2),
}


@pytest.mark.parametrize("name", ROWS)
def test_rows_of_the_feasible_set(name: str) -> None:
    """Proved with all of them, refuted without any one, and their bounds are those of the set."""
    problem = ROWS[name]()
    own = feasible_set(solve(problem, 2000))
    found = prove_rim(problem, own.rows)
    assert found.missing <= PROVED
    np.testing.assert_allclose(found.tops, own.bounds, rtol=1e-9, atol=1e-9)
    for i in range(len(own.rows)):
        less = prove_rim(problem, np.delete(own.rows, i, axis=0))
        assert less.missing > 1e-4


def test_no_rows_where_every_parameter_is_feasible() -> None:
    problem = servo_drive(3)
    assert prove_rim(problem, np.zeros((0, problem.parameters))).missing == 0.0
    limited = steps(2)
    assert prove_rim(limited, np.zeros((0, limited.parameters))).missing > 1e-3
