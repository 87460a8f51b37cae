"""What is left of a facet when the regions behind it are taken away, and what lies beyond."""

import numpy as np
import pytest
from explicit_problems import double_integrator, transport

from servogen.explicit import cover
from servogen.explicit.cover import (
    Facet,
    across,
    bounds_feasible_set,
    facet_of,
    generic_point,
    optimal_set,
    subtract,
)
from servogen.explicit.errors import ExplicitError
from servogen.explicit.explore import solve
from servogen.explicit.regions import Region
from servogen.explicit.solution import ExplicitSolution
from servogen.qp.errors import NotSolved

EYE = np.eye(3)


def square() -> Facet:
    """x = 0, |y| <= 1, |z| <= 1, seen from x < 0."""
    rows = np.vstack([np.eye(2), -np.eye(2)])
    return Facet(EYE[0], np.zeros(3), EYE[:, 1:], rows, np.ones(4))


def block(h: np.ndarray, k: np.ndarray) -> Region:
    """A region that is nothing but its polyhedron."""
    empty = np.zeros((1, 3))
    return Region((), h, k, empty, np.zeros(1), np.zeros(3), 1.0, 0, ())


def area(pieces: list[Facet]) -> float:
    """Of pieces in the plane, by a grid that no edge of the test falls on."""
    steps = (np.arange(200) + 0.5) / 100.0 - 1.0
    y, z = (a.ravel() for a in np.meshgrid(steps, steps))
    points = np.column_stack([np.zeros_like(y), y, z])
    total = np.zeros(len(points), dtype=int)
    for piece in pieces:
        total += np.all((points - piece.foot) @ piece.basis @ piece.rows.T <= piece.bounds, axis=1)
    assert np.max(total, initial=0) <= 1  # the pieces do not overlap
    return float(np.sum(total)) / 1e4


def test_pieces_are_what_a_region_leaves() -> None:
    """A quarter of the square behind a region leaves three quarters, then nothing."""
    whole = square()
    assert area([whole]) == pytest.approx(4.0)
    behind = np.vstack([-EYE[0], EYE[1], EYE[2]])
    rest = list(subtract(whole, block(behind, np.zeros(3))))
    assert area(rest) == pytest.approx(3.0)
    upper = block(np.vstack([-EYE[0], -EYE[1]]), np.zeros(2))
    rest = [part for piece in rest for part in subtract(piece, upper)]
    assert area(rest) == pytest.approx(1.0)
    corner = block(np.vstack([-EYE[0], -EYE[2], EYE[1]]), np.zeros(3))
    assert not [part for piece in rest for part in subtract(piece, corner)]


def test_generic_point_is_inside_and_flat_pieces_have_none() -> None:
    found = generic_point(square())
    assert found is not None
    point, radius = found
    assert radius == pytest.approx(1.0)
    assert point[0] == 0.0
    assert 0.0 < np.linalg.norm(point[1:]) < 0.5
    thin = Facet(EYE[0], np.zeros(3), EYE[:, 1:], np.vstack([np.eye(2), -np.eye(2)]),
                 np.array([1.0, 1.0, -1.0, 1.0]))  # fmt: skip
    assert generic_point(thin) is None


@pytest.fixture(scope="module")
def solution() -> ExplicitSolution:
    return solve(double_integrator(4), 500)


def test_every_facet_is_shared_or_an_end(solution: ExplicitSolution) -> None:
    """The proof of coverage on its own: each facet taken apart by the regions behind it."""
    program = solution.program
    places = {int(number): i for i, number in enumerate(program.numbers)}
    known = {tuple(sorted(places[n] for n in r.active)): r for r in solution.regions}
    ends = 0
    for region in solution.regions:
        for row in range(region.k.size):
            if bounds_feasible_set(program, region.h[row], float(region.k[row])):
                ends += 1
                continue
            pieces, taken = [facet_of(region, program, row)], 0
            while pieces:
                piece = pieces.pop()
                if generic_point(piece) is None:
                    continue
                behind = across(program, piece, known.get)
                assert behind.region is not None, behind.note
                taken += 1
                pieces.extend(subtract(piece, behind.region))
            assert taken >= 1
    assert ends == solution.findings.boundary_facets


def test_a_missing_region_is_noticed(solution: ExplicitSolution) -> None:
    """Across the facets of its neighbours, nothing else covers the hole."""
    program = solution.program
    places = {int(number): i for i, number in enumerate(program.numbers)}
    known = {tuple(sorted(places[n] for n in r.active)): r for r in solution.regions}
    assert known.pop(()) is not None
    holes = 0
    for region in known.values():
        for row in range(region.k.size):
            behind = across(program, facet_of(region, program, row), known.get)
            holes += bool(behind.note)
    assert holes == 4  # the region without active rows has so many neighbours


def test_end_of_what_is_feasible() -> None:
    """Demand within what the plants make: theta_0 + theta_1 <= 950."""
    program = solve(transport(), 100).program
    normal = np.linalg.solve(program.image.matrix.T, np.array([1.0, 1.0]))
    size = float(np.linalg.norm(normal))
    assert bounds_feasible_set(program, normal / size, 950.0 / size)
    assert not bounds_feasible_set(program, normal / size, 940.0 / size)


def test_beyond_what_is_feasible_there_is_no_optimal_set(solution: ExplicitSolution) -> None:
    """Across every outer facet: a step inside has a set, one outside has none, though rows are
    active there too when the method finds that no s keeps them all."""
    program, ends = solution.program, 0
    for region in solution.regions:
        for normal, height in zip(region.h, region.k, strict=True):
            if not bounds_feasible_set(program, normal, float(height)):
                continue
            point = region.centre + normal * (height - normal @ region.centre)
            domain = program.domain_rows @ point - program.domain_bounds
            if np.max(domain) > -1e-6:  # an end of the domain: the program has a solution beyond
                continue
            ends += 1
            assert optimal_set(program, region.centre) is not None
            assert optimal_set(program, point + 1e-3 * normal) is None
    assert ends >= 1


def test_a_program_that_does_not_end_is_told(
    solution: ExplicitSolution, monkeypatch: pytest.MonkeyPatch
) -> None:
    def endless(*_: object) -> None:
        raise NotSolved("it did not end")

    monkeypatch.setattr(cover, "nearest", endless)
    with pytest.raises(ExplicitError, match=r"^active set is not found, expected rows that"):
        optimal_set(solution.program, np.zeros(2))
