"""All critical regions: counts known beforehand, an outside solver, PPOPT, degenerate programs."""

from collections.abc import Iterator
from contextlib import contextmanager

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
from oracle import first_moves
from ppopt_peer import ppopt_active_sets

from servogen.explicit.errors import ExplicitError
from servogen.explicit.explore import solve
from servogen.explicit.problem import ParametricQP, parametric_qp
from servogen.explicit.solution import ExplicitSolution


def sample(problem: ParametricQP, count: int, seed: int = 1) -> np.ndarray:
    """Parameters in the box that the domain's first rows describe."""
    bounds = problem.domain_bounds[: problem.parameters]
    generator = np.random.default_rng(seed)
    return generator.uniform(-1.0, 1.0, (count, problem.parameters)) * bounds


def agree(problem: ParametricQP, solution: ExplicitSolution, thetas: np.ndarray) -> None:
    """Same first move wherever DAQP finds a solution, and a region nowhere else."""
    wanted, found = first_moves(problem, thetas), solution.first_move(thetas)
    np.testing.assert_array_equal(np.isnan(wanted), np.isnan(found))
    np.testing.assert_allclose(found, wanted, atol=1e-9 * np.nanmax(np.abs(wanted)))
    assert not solution.findings.unresolved


@pytest.mark.parametrize("moves", [1, 2, 3, 4, 5, 6])
def test_servo_counts(moves: int) -> None:
    """Every pattern of the currents' bounds is a region, in closed form."""
    solution = solve(servo_drive(moves, max(moves, 2)), 3**moves)
    assert len(solution.regions) == 3**moves
    assert solution.laws.count == 3 ** (moves - 1) + 2
    assert solution.findings.closed_form


def test_servo_inside_the_box() -> None:
    """The two corners that alternate between the bounds lie outside it."""
    everywhere, inside = solve(servo_drive(3), 30), solve(servo_drive(3, inside_box=True), 30)
    assert len(inside.regions) == 25
    assert inside.laws.count == 11
    missing = {r.active for r in everywhere.regions} - {r.active for r in inside.regions}
    assert missing == {(0, 2, 4), (1, 3, 5)}


def test_closed_form_is_what_exploration_finds() -> None:
    """The same program with its box hidden behind a row that never matters."""
    plain = servo_drive(3)
    hidden = parametric_qp(
        plain.hessian, plain.linear, rows=[[1.0, 1.0, 1.0]], bounds=[1e5], lower=plain.lower,
        upper=plain.upper,
    )  # fmt: skip
    found, wanted = solve(hidden, 40), solve(plain, 40)
    assert not found.findings.closed_form
    shifted = {tuple(i - 1 for i in region.active) for region in found.regions}
    assert shifted == {region.active for region in wanted.regions}
    assert found.laws.count == wanted.laws.count


def test_example_of_2002() -> None:
    """Nine regions; the paper prints the gains of three: -5.9220 -6.8883 without constraints."""
    solution = solve(regulator_2002(), 100)
    assert len(solution.regions) == 9
    assert solution.laws.count == 5
    gain, offset = solution.full_law(0)
    np.testing.assert_allclose(gain[0], [-5.9220, -6.8883], atol=1e-3)
    assert offset[0] == pytest.approx(0.0, abs=1e-12)
    partly = next(i for i, region in enumerate(solution.regions) if region.active == (3,))
    gain, offset = solution.full_law(partly)  # the second move at its lower bound
    np.testing.assert_allclose(gain[0], [-6.4159, -4.6953], atol=1e-3)
    assert offset[0] == pytest.approx(0.6423, abs=1e-3)


def test_toolbox_double_integrator() -> None:
    """The toolbox's page counts 19 regions within its range of parameters."""
    assert len(solve(toolbox_double_integrator(), 100).regions) == 19


def test_transport_problem() -> None:
    """PPOPT's own test counts 4 regions."""
    solution = solve(transport(), 100)
    assert len(solution.regions) == 4
    assert solution.findings.boundary_facets == 3  # demand beyond what the plants can make


PEERS = {
    "servo": lambda: servo_drive(3, inside_box=True),
    "position and velocity": lambda: double_integrator(3),
    "transport": transport,
    "random 3 in 2": lambda: random_program(5, 3, 2, 5),
    "random 2 in 3": lambda: random_program(2, 2, 3, 4),
    "random 4 in 2": lambda: random_program(7, 4, 2, 5),
}


@pytest.mark.parametrize("name", PEERS)
def test_active_sets_are_ppopts(name: str) -> None:
    problem = PEERS[name]()
    ours = sorted(region.active for region in solve(problem, 500).regions)
    assert ours == ppopt_active_sets(problem, "combinatorial")


def test_double_integrator_with_limits() -> None:
    """Horizon 5, position and velocity limited; PPOPT finds the same 21 in seven seconds."""
    problem = double_integrator(5)
    solution = solve(problem, 500)
    assert len(solution.regions) == 21
    agree(problem, solution, sample(problem, 3000))


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 2**32 - 1), n=st.integers(1, 4), p=st.integers(1, 3), m=st.integers(0, 6)
)
def test_random_programs(seed: int, n: int, p: int, m: int) -> None:
    problem = random_program(seed, n, p, m, first_move=min(n, 2))
    agree(problem, solve(problem, 3000), sample(problem, 150, seed % 1000))


def test_laws_of_regions_are_optimal_all_over_them() -> None:
    """Stationary, feasible and complementary at points of every region, not only its first move."""
    problem = random_program(11, 3, 2, 5)
    solution = solve(problem, 500)
    g, w, s, numbers = problem.all_rows()
    generator = np.random.default_rng(2)
    for i, region in enumerate(solution.regions):
        gain, offset = solution.full_law(i)
        eta = region.centre + generator.normal(size=(5, 2)) * region.radius / 4.0
        theta = np.linalg.solve(solution.image.matrix, (eta - solution.image.offset).T).T
        for t in theta:
            z = gain @ t + offset
            slack = w + s @ t - g @ z
            active = np.isin(numbers, region.active)
            assert np.min(slack) >= -1e-9
            np.testing.assert_allclose(slack[active], 0.0, atol=1e-9)
            rest = problem.hessian @ z + problem.linear @ t + problem.constant
            duals = np.linalg.lstsq(g[active].T, -rest, rcond=None)[0]
            np.testing.assert_allclose(g[active].T @ duals, -rest, atol=1e-8)
            assert np.all(duals >= -1e-8)


def test_facets_are_all_needed() -> None:
    """Without any one of them the region would be larger."""
    from servogen.explicit.small_lp import greatest

    solution = solve(double_integrator(4), 500)
    program = solution.program
    for region in solution.regions:
        np.testing.assert_allclose(np.linalg.norm(region.h, axis=1), 1.0)
        for row in range(region.k.size):
            others = np.arange(region.k.size) != row
            h = np.vstack([region.h[others], program.domain_rows, region.h[row]])
            k = np.concatenate([region.k[others], program.domain_bounds, [region.k[row] + 1.0]])
            assert greatest(h, k, region.h[row]) > region.k[row] + 1e-8


DEGENERATE = {
    # a third row through the square's corner: two of three are enough there
    "row through a corner": ([[1.0, 1.0]], [2.0], 1.0),
    "the same row twice": ([[1.0, 2.0], [1.0, 2.0]], [1.0, 1.0], 1.0),
    "a row in two scales": ([[1.0, 2.0], [3.0, 6.0]], [1.0, 3.0], 1.0),
    "a row that hides a bound": ([[1.0, 0.0], [1.0, 1e-9]], [1.0, 1.0], 1.0),
}


@pytest.mark.parametrize("name", DEGENERATE)
def test_degenerate_programs_are_covered(name: str) -> None:
    rows, bounds, limit = DEGENERATE[name]
    problem = parametric_qp(
        np.eye(2), -np.eye(2), rows=rows, bounds=bounds, lower=[-limit] * 2, upper=[limit] * 2,
        domain_rows=np.vstack([np.eye(2), -np.eye(2)]), domain_bounds=np.full(4, 3.0),
    )  # fmt: skip
    agree(problem, solve(problem, 100), sample(problem, 500))


def test_pyramid_has_more_faces_than_dimensions_at_its_tip() -> None:
    """Four rows meet in a point of R^3: the cone above the tip has no one active set."""
    rows = np.array([[1.0, 0.2, 1.0], [-1.0, 0.1, 1.0], [0.3, 1.0, 1.0], [0.1, -1.0, 1.0]])
    problem = parametric_qp(
        np.eye(3), -np.eye(3), rows=rows, bounds=np.ones(4),
        domain_rows=np.vstack([np.eye(3), -np.eye(3)]), domain_bounds=np.full(6, 3.0), first_move=3,
    )  # fmt: skip
    solution = solve(problem, 100)
    assert solution.findings.stepped_facets > 0
    agree(problem, solution, sample(problem, 1500))
    tip = [region for region in solution.regions if len(region.active) == 3]
    assert len(tip) >= 2
    laws = {region.law for region in tip}
    assert len(laws) == 1  # the same point, whatever the multipliers


def test_terminal_sets_and_parameters_limited_by_rows() -> None:
    """A row without z limits theta; rows that coincide for some theta only."""
    problem = parametric_qp(
        np.diag([1.0, 2.0]), [[1.0, 0.2], [0.1, 1.0]],
        rows=[[1.0, 1.0], [0.0, 0.0], [1.0, -1.0]], bounds=[1.0, 1.5, 1.0],
        bounds_parameter=[[0.3, 0.0], [-1.0, 0.0], [0.3, 0.0]], lower=[-2.0] * 2, upper=[2.0] * 2,
        domain_rows=np.vstack([np.eye(2), -np.eye(2)]), domain_bounds=np.full(4, 3.0),
    )  # fmt: skip
    solution = solve(problem, 100)
    thetas = sample(problem, 1000)
    inside = thetas[thetas[:, 0] <= 1.5]
    agree(problem, solution, inside)
    assert np.all(np.isnan(solution.first_move(thetas[thetas[:, 0] > 1.5 + 1e-6])))


def test_box_whose_optimum_does_not_reach_everywhere() -> None:
    """Three moves, two parameters: not every pattern is a region."""
    generator = np.random.default_rng(4)
    problem = parametric_qp(
        np.diag([1.0, 2.0, 3.0]) + 0.5, generator.normal(size=(3, 2)), lower=[-1.0] * 3,
        upper=[1.0] * 3, domain_rows=np.vstack([np.eye(2), -np.eye(2)]),
        domain_bounds=np.full(4, 20.0),
    )  # fmt: skip
    solution = solve(problem, 100)
    assert 3 < len(solution.regions) < 27
    agree(problem, solution, sample(problem, 1000))


def test_too_many_regions_are_refused() -> None:
    with pytest.raises(ExplicitError, match=r"number of regions is 243, expected at most 200"):
        solve(servo_drive(5, 5), 200)
    with pytest.raises(ExplicitError, match=r"more than 20, expected at most 20"):
        solve(double_integrator(5), 20)
    with pytest.raises(ExplicitError, match=r"more than 24, expected at most 24"):
        solve(servo_drive(3, inside_box=True), 24)


def test_programs_without_room_are_refused() -> None:
    box = {"domain_rows": np.vstack([np.eye(1), -np.eye(1)]), "domain_bounds": [1.0, 1.0]}
    with pytest.raises(ExplicitError, match="feasible set of the program is empty"):
        solve(
            parametric_qp(np.eye(2), np.ones((2, 1)), rows=[[1.0, 1.0], [-1.0, -1.0]],
                          bounds=[-3.0, 1.0], **box), 10,
        )  # fmt: skip
    with pytest.raises(ExplicitError, match="flat"):
        solve(
            parametric_qp(np.eye(2), np.ones((2, 1)), rows=[[1.0, 1.0], [-1.0, -1.0]],
                          bounds=[1.0, -1.0], **box), 10,
        )  # fmt: skip


def test_same_input_same_regions() -> None:
    first, second = solve(double_integrator(4), 500), solve(double_integrator(4), 500)
    assert [r.active for r in first.regions] == [r.active for r in second.regions]
    for one, two in zip(first.regions, second.regions, strict=True):
        assert one.h.tobytes() == two.h.tobytes()
        assert one.slope.tobytes() == two.slope.tobytes()


class Interrupting:
    """Progress that a user interrupts after a few regions."""

    def __init__(self) -> None:
        self.steps = 0

    @contextmanager
    def task(self, title: str, total: int | None = None) -> Iterator["Interrupting"]:
        yield self

    def advance(self, steps: int = 1) -> None:
        self.steps += steps
        if self.steps >= 5:
            raise KeyboardInterrupt


@pytest.mark.parametrize("problem", [double_integrator(5), servo_drive(3)])
def test_work_can_be_interrupted(problem: ParametricQP) -> None:
    watcher = Interrupting()
    with pytest.raises(KeyboardInterrupt):
        solve(problem, 500, watcher)
    assert watcher.steps >= 5
