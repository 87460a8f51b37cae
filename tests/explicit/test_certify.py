"""Explicit solutions are proved from their programs alone, and broken ones are refuted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import product

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
from scipy.optimize import linprog

from servogen.explicit import covering
from servogen.explicit.certify import Certified, certify
from servogen.explicit.clips import without_first_bounds
from servogen.explicit.cover import Facet, facet_of, generic_point
from servogen.explicit.explore import solve
from servogen.explicit.facet_parts import facet_on, gap_behind, same_rows, without
from servogen.explicit.feasible import feasible_set
from servogen.explicit.optimality import prove_optimal
from servogen.explicit.regions import Region
from servogen.explicit.restated import restate
from servogen.explicit.rim import prove_rim
from servogen.explicit.solution import ExplicitSolution, Laws
from servogen.explicit.tolerances import FAR, FLAT, HOLE, PROVED, PROVED_LAW
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


def is_elsewhere(solution: ExplicitSolution, index: int, row: int, inside: float = 5e-4) -> bool:
    """Whether a point just inside a facet is in another region too."""
    region = solution.regions[index]
    point, _ = generic_point(facet_of(region, solution.program, row)) or (region.centre, 0.0)
    point = point - inside * region.h[row]
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


@pytest.mark.parametrize("by", [1e-10, 1e-9, 8e-9])
def test_what_is_left_open_is_measured(by: float) -> None:
    """A facet drawn in, on what counts as one plane with its neighbour's, leaves a gap as wide as
    that, which is told and bounded."""
    solution = solve(double_integrator(3), 100)
    before = proved(solution).cover.hole
    told = 0
    for index, region in list(enumerate(solution.regions))[::3]:
        for row in range(region.k.size):
            if is_elsewhere(solution, index, row, 0.3 * by):
                continue
            cover = proved(with_region(solution, index, k=moved(region, row, -by))).cover
            assert cover.hole >= 0.5 * by
            told += np.isfinite(cover.hole) and cover.hole > before + 0.5 * by
    assert told > 0


@pytest.mark.parametrize("angle", [9.5e-9, 3e-9, 9e-10, 1e-12])
def test_planes_that_are_turned_against_each_other_leave_a_wedge(angle: float) -> None:
    """Hairs near the origin, far out it is wide: a ball of it, within a million bounds, is as large
    as a linear program finds it, and is told."""
    solution = solve(regulator_2002(), 100)
    far, missed = np.vstack([np.eye(2), -np.eye(2)]), 0
    for index, region in enumerate(solution.regions):
        for row, side in product(range(region.k.size), (-1.0, 1.0)):
            h = region.h.copy()
            h[row] += side * angle * np.array([-h[row, 1], h[row, 0]])
            h[row] /= np.linalg.norm(h[row])
            gap = np.vstack([region.h, -h[row], far])
            bounds = np.concatenate([region.k, [-region.k[row]], np.full(4, FAR / np.sqrt(2.0))])
            wide = linprog(
                [0.0, 0.0, -1.0], np.column_stack([gap, np.ones(len(gap))]), bounds,
                bounds=[(None, None)] * 2 + [(0.0, None)], method="highs",
            )  # fmt: skip
            radius = -wide.fun if wide.status == 0 else 0.0
            found = proved(with_region(solution, index, h=h))
            assert found.cover.hole >= radius
            assert found.covers or angle > 1e-11
            missed += radius > HOLE
            if radius > HOLE:
                assert not found.holds
    assert missed > 0 or angle < 3e-9


def test_a_facet_beside_the_end_of_the_feasible_set_is_measured() -> None:
    """A plane turned against where the set ends leaves a wedge of feasible parameters beyond."""
    solution = solve(double_integrator(3), 100)
    proof = proof_of(solution)
    ends = 0
    for region in solution.regions:
        for row in range(region.k.size):
            facet = facet_on(region, proof.own, row)
            if proof._is_end(facet):
                turned = facet.normal + 1e-9 * facet.basis[:, 0]
                proof.ends[covering._key(facet)].meet(replace(facet, normal=turned))
                ends += 1
    assert ends > 0
    assert proof.result().hole >= 1e-9 * FAR


def test_largest_missed_is_what_strips_and_slabs_can_hide() -> None:
    """By known figures: of a line all of them; of a plane a strip covers its width of a disc."""
    assert covering.largest_missed(0, 1.0, 2.0, 4.0) == 7.0
    narrower = 2.0 / np.sqrt(3.0)
    assert covering.largest_missed(1, 0.0, 1.0, 0.0) == pytest.approx(narrower * 0.5)
    # of a disc of radius one, area pi, a strip of width w covers at most 2 w
    assert covering.largest_missed(2, 0.0, 1.0, 0.0) == pytest.approx(narrower * 2.0 / np.pi)
    # the triangle of height three has a ball of radius one, and 2 sqrt(d + 2) is no less than that
    flat = covering.largest_missed(2, 1.0, 0.0, 0.0)
    assert flat == pytest.approx(covering.largest_missed(2, 0.0, 4.0, 0.0))
    assert covering.largest_missed(2, 0.0, 0.0, 1.0) == pytest.approx(narrower**2)


def proof_of(solution: ExplicitSolution) -> covering._Proof:
    program = solution.program
    own = restate(solution.problem, solution.image, program.domain_rows, program.domain_bounds)
    return covering._Proof(own, solution.regions)


def test_slivers_are_measured() -> None:
    """What is left of a facet counts up to a millionth of a bound, and is open beyond."""
    solution = solve(double_integrator(3), 100)
    rows = np.array([[1.0], [-1.0]])
    for radius, narrow in ((0.99e-6, True), (1.01e-6, False)):
        proof = proof_of(solution)
        facet = facet_on(solution.regions[0], proof.own, 0)
        proof._tell([replace(facet, rows=rows, bounds=np.array([0.5 + radius, radius - 0.5]))])
        found = proof.result()
        assert (len(found.slivers), len(found.open)) == ((1, 0) if narrow else (0, 1))
        wanted = covering.largest_missed(1, radius, 0.0, 0.0) if narrow else np.inf
        assert found.hole == pytest.approx(wanted, rel=1e-6)


def test_what_a_neighbour_leaves_flat_is_measured() -> None:
    """A facet from -1 to 1, and a region behind it from -1 to a hair less than 1."""
    rows, hair = np.array([[1.0], [-1.0]]), 1e-8
    facet = Facet(np.array([1.0, 0.0]), np.zeros(2), np.array([[0.0], [1.0]]), rows, np.ones(2))
    behind = replace(
        solve(double_integrator(3), 100).regions[0],
        h=np.array([[-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]]), k=np.array([0.0, 1.0 - hair, 1.0]),
    )  # fmt: skip
    left, flat = without(facet, behind)
    assert not left
    assert flat == pytest.approx(0.5 * hair, rel=1e-3)
    same, wide = same_rows(facet, rows[:1], np.array([1.0 - 1e-10]))
    assert same.all()
    assert wide == pytest.approx(1e-10, rel=1e-3)
    slab, sides = gap_behind(facet, [replace(behind, k=np.array([-hair, 1.0, 1.0]))])
    assert slab == pytest.approx(hair)
    assert sides == pytest.approx(2.0 * hair)
    proof = proof_of(solve(double_integrator(3), 100))
    proof._add_gap(facet, [replace(behind, k=np.array([-hair, 1.0, 1.0]))])
    found = covering.largest_missed(1, 0.0, 2.0 * hair, hair)
    assert proof.result().hole == pytest.approx(found)


def test_rows_that_are_turned_within_a_facet_are_measured() -> None:
    """What counts as one row of a facet and of the region behind it, apart far out."""
    rows = np.vstack([np.eye(2), -np.eye(2)])
    facet = Facet(np.eye(3)[0], np.zeros(3), np.eye(3)[:, 1:], rows, np.ones(4))
    other = np.array([[1.0, 9e-10]])
    same, wide = same_rows(facet, other, np.array([1.0]))
    assert same.all()
    assert wide == pytest.approx(9e-10 * FAR)


def test_flat_facets_are_counted() -> None:
    """A row that touches its region in less than a facet is passed over, and told."""
    solution = solve(double_integrator(3), 100)
    region = solution.regions[0]
    vertex = next(
        point for pair in product(range(region.k.size), repeat=2)
        if abs(np.linalg.det(region.h[list(pair)])) > 1e-3
        for point in [np.linalg.solve(region.h[list(pair)], region.k[list(pair)])]
        if np.all(region.h @ point <= region.k + 1e-12)
    )  # fmt: skip
    on_it = np.flatnonzero(np.abs(region.h @ vertex - region.k) < 1e-12)
    row = np.sum(region.h[on_it], axis=0) / np.linalg.norm(np.sum(region.h[on_it], axis=0))
    more = with_region(
        solution, 0, h=np.vstack([region.h, row]), k=np.append(region.k, row @ vertex)
    )
    before, after = proved(solution).cover.hole, proved(more).cover.hole
    assert after - before > 0.5 * covering.largest_missed(1, FLAT, 0.0, 0.0)
    assert proved(more).covers


def test_the_hole_decides() -> None:
    found = proved(solve(double_integrator(3), 100))
    assert found.holds
    assert not replace(found, cover=replace(found.cover, hole=1.01e-3)).holds
    assert replace(found, cover=replace(found.cover, hole=0.99e-3)).holds


@pytest.mark.parametrize(
    ("finding", "least"), [("unseen", 1e-9), ("domain", 1e-9), ("reach", 5e-8), ("law_error", 2e-9)]
)
def test_each_finding_decides(finding: str, least: float) -> None:
    """At the width that is documented: a little more is refused, a little less is not."""
    found = proved(solve(double_integrator(3), 100))
    for share, holds in ((1.01, True), (0.99, False)):
        value = least / share
        if finding in ("unseen", "domain"):
            other = replace(found, **{finding: value})
        else:
            other = replace(found, optimal=replace(found.optimal, **{finding: value}))
        assert other.holds == holds


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
