"""The certified worst case of the active-set method against the method, in C and in Python."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest
from core_designs import temporary_folder

from servogen.controllers.design import Status
from servogen.controllers.qp_solver_design import (
    QpSolverDesign,
    declare_qp_solver,
    design_qp_solver,
)
from servogen.emit.package import emit_package
from servogen.explicit.errors import ExplicitError
from servogen.explicit.iteration_certificate import (
    IterationCertificate,
    Piece,
    certify_iterations,
)
from servogen.explicit.iteration_paths import Paths
from servogen.explicit.iteration_program import IterationProgram, iteration_program
from servogen.precision import FLOAT64
from servogen.qp.active_set_factor import empty_set
from servogen.qp.parametric import parameter_box, parametric_qp
from servogen.sil.build import Module, compile_package
from servogen.sil.compiled import CompiledController

BUDGET = 100_000
# Parameters nearer than this to the edge of a piece may round to the other side of it.
EDGE = 1e-7
COLD = ("limits_2", "limits_3", "limits_4", "limits_5", "feasible_3", "twice_3", "random_4")
WARM = ("limits_3", "twice_2")


@dataclass(frozen=True)
class Case:
    """A program as a controller of its own, its data on (theta, 1)."""

    design: QpSolverDesign
    program: IterationProgram

    def inputs(self, theta: np.ndarray) -> dict[str, np.ndarray]:
        given = np.append(theta, 1.0)
        scale, inverse = self.design.scale, self.design.tables.inverse
        return {
            "linear": -np.linalg.solve(inverse, self.program.free @ given),
            "low": (self.program.low @ given) / scale,
            "high": (self.program.high @ given) / scale,
        }


@cache
def case(name: str, cap: int = 200) -> Case:
    """One of the programs below, by kind and number of variables."""
    kind, size = name.split("_")
    return _random(name, int(size), cap) if kind == "random" else _integrator(name, cap)


def _random(name: str, n: int, cap: int) -> Case:
    """Rows in every direction: several multipliers fall at once."""
    rng = np.random.default_rng(11)
    square = rng.normal(size=(n, n))
    hessian = square @ square.T + 0.1 * np.eye(n)
    design = design_qp_solver(name, FLOAT64, hessian, rng.normal(size=(3 * n, n)), cap, 1e-6)
    box, bounds = parameter_box(-np.ones(2), np.ones(2))
    high = np.column_stack([0.3 * rng.normal(size=(3 * n, 2)), rng.uniform(0.2, 0.6, 3 * n)])
    return Case(
        design,
        IterationProgram(
            tables=design.tables,
            free=np.column_stack([2.0 * rng.normal(size=(n, 2)), rng.normal(size=n)]),
            low=high - np.array([0.0, 0.0, 1.0]),
            high=high,
            domain_rows=box,
            domain_bounds=bounds,
        ),
    )


def _integrator(name: str, cap: int) -> Case:
    """A double integrator, input, position and velocity limited, over N samples from any state.

    ``limits``: some of whose states cannot be kept; ``feasible``: all can; ``twice``: every second
    row again, turned round and scaled.
    """
    kind, horizon = name.split("_")
    n = int(horizon)
    a, b = np.array([[1.0, 0.3], [0.0, 1.0]]), np.array([0.045, 0.3])
    on_input, on_state = np.zeros((n + 1, 2, n)), np.zeros((n + 1, 2, 2))
    on_state[0] = np.eye(2)
    for k in range(n):
        on_input[k + 1], on_state[k + 1] = a @ on_input[k], a @ on_state[k]
        on_input[k + 1, :, k] += b
    hessian, gradient = 0.1 * np.eye(n), np.zeros((n, 2))
    for k in range(1, n + 1):
        weight = np.diag([1.0, 0.1]) * (5.0 if k == n else 1.0)
        hessian += on_input[k].T @ weight @ on_input[k]
        gradient += on_input[k].T @ weight @ on_state[k]
    rows = np.concatenate([[np.eye(n)[k], *on_input[k + 1]] for k in range(n)])
    state = np.concatenate([[np.zeros(2), *on_state[k + 1]] for k in range(n)])
    limit = np.tile([1.0, 1.0, 0.5], n)
    if kind == "twice":
        again = np.array([-2.0])
        rows = np.vstack([rows, again * rows[::2]])
        state = np.vstack([state, again * state[::2]])
        limit = np.append(limit, 2.0 * limit[::2])
    design = design_qp_solver(
        name, FLOAT64, hessian, rows, cap, 1e-6, per_step=0 if kind == "twice" else 3
    )
    most = np.array([0.5, 0.2]) if kind == "feasible" else np.array([1.0, 0.5])
    scale = design.scale.astype(np.float64)[:, None]
    box, bounds = parameter_box(-most, most)
    free = np.column_stack([-np.linalg.solve(hessian, gradient), np.zeros(n)])
    return Case(
        design,
        IterationProgram(
            tables=design.tables,
            free=free,
            low=np.column_stack([-state, -limit]) * scale,
            high=np.column_stack([-state, limit]) * scale,
            domain_rows=box,
            domain_bounds=bounds,
        ),
    )


@cache
def certified(name: str, warm: bool) -> tuple[IterationCertificate, list[Piece]]:
    pieces: list[Piece] = []
    found = certify_iterations(case(name).program, BUDGET, warm=warm, keep=pieces.append)
    return found, pieces


@cache
def compiled(name: str, cap: int) -> Module:
    own = replace(case(name, cap).design, prefix="own")
    package = emit_package("capped", (declare_qp_solver(own),))
    return compile_package([package], temporary_folder(f"capped_{name}_{cap}"), ["-O0"])


def in_c(name: str, cap: int) -> CompiledController:
    own = replace(case(name, cap).design, prefix="own")
    return CompiledController(compiled(name, cap), declare_qp_solver(own))


def drawn(name: str, count: int, seed: int) -> np.ndarray:
    low, high = case(name).program.box()
    return np.random.default_rng(seed).uniform(low, high, (count, low.size))


@pytest.mark.parametrize("name", COLD)
def test_every_parameter_takes_its_pieces_iterations_from_a_cold_start(name: str) -> None:
    found, pieces = certified(name, warm=False)
    assert found.exact
    assert found.bound_inside == found.bound
    assert (found.infeasible > 0) == (not name.startswith("feasible"))
    controller, paths = in_c(name, found.bound), Paths(case(name).program)
    thetas = np.vstack([drawn(name, 12_000, 4), [p.theta for p in pieces if p.radius > EDGE]])
    taken = np.zeros(len(thetas), dtype=int)
    told = np.zeros(len(thetas), dtype=bool)
    for i, theta in enumerate(thetas):
        controller.call("reset")
        status, out = controller.call("step", case(name).inputs(theta))
        assert status is not Status.BACKUP  # the cap is the certified bound
        taken[i], told[i] = int(out["iterations"]), status is Status.INFEASIBLE
    own, ending = of(pieces, (thetas - paths.middle) / paths.half)
    inside = own >= 0
    assert np.mean(inside) > 0.99
    np.testing.assert_array_equal(taken[inside], own[inside])
    np.testing.assert_array_equal(told[inside], ending[inside])
    assert taken.max() == found.bound


def of(pieces: list[Piece], t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Iterations of the piece that each parameter (samples, p) is inside of, -1 at an edge; and
    whether it says infeasible. No two pieces share a parameter."""
    own, ending = np.full(len(t), -1), np.zeros(len(t), dtype=bool)
    for piece in pieces:
        inside = np.all(t @ piece.rows.T < piece.bounds - EDGE, axis=1)
        assert not np.any(inside & (own >= 0)), "two pieces share a parameter"
        own[inside], ending[inside] = piece.iterations, piece.ending == "infeasible"
    return own, ending


@pytest.mark.parametrize("name", WARM)
def test_every_call_takes_its_pieces_iterations_after_any_other(name: str) -> None:
    found, pieces = certified(name, warm=True)
    assert found.exact
    program = case(name).program
    paths, work = Paths(program), empty_set(program.tables)
    by_start: dict[object, list[Piece]] = {}
    for piece in pieces:
        by_start.setdefault(piece.start, []).append(piece)
    seen = 0
    for theta in drawn(name, 1500, 5):
        sides = tuple(
            2 * row + (side < 0)
            for row, side in zip(work.row[: work.size], work.side[: work.size], strict=True)
        )
        start = paths.next_start(sides)
        assert start in by_start
        taken = program.solve(theta, work, 1000).iterations
        t = (theta - paths.middle) / paths.half
        at = [
            p
            for p in by_start[start]
            if np.all(p.rows @ t < p.bounds - EDGE)
            and (p.iterations == 0 or not _kept_without(paths, t, start.kept, p))
        ]
        if at:
            assert [p.iterations for p in at] == [taken]
            seen += 1
    assert seen > 1450


def _kept_without(paths: Paths, t: np.ndarray, kept: bool, piece: Piece) -> bool:
    """Whether ``piece`` is a way that the call does not go: the optimum without rows was taken."""
    excess = paths.excess[paths.sides] @ np.append(t, 1.0)
    none_violated = bool(np.all(excess <= float(paths.tables.accept)))
    return none_violated and not kept and piece.iterations > 0


@pytest.mark.parametrize("name", WARM)
def test_emitted_with_the_bound_as_cap_it_is_never_met_and_with_one_less_it_is(name: str) -> None:
    found, _ = certified(name, warm=True)
    assert found.attained == found.bound
    enough, short = in_c(name, found.bound), in_c(name, found.bound - 1)
    statuses, taken = _played(name, enough, np.array(found.witness))
    assert Status.BACKUP not in statuses
    assert taken[-1] == found.bound
    statuses, _ = _played(name, short, np.array(found.witness))
    assert statuses[-1] is Status.BACKUP
    statuses, taken = _played(name, enough, drawn(name, 20_000, 6))
    assert Status.BACKUP not in statuses
    assert max(taken) <= found.bound


def _played(
    name: str, controller: CompiledController, thetas: np.ndarray
) -> tuple[list[Status], list[int]]:
    controller.call("reset")
    results = [controller.call("step", case(name).inputs(theta)) for theta in thetas]
    return [status for status, _ in results], [int(out["iterations"]) for _, out in results]


def test_a_budget_that_does_not_suffice_is_told() -> None:
    found = certify_iterations(case("limits_5").program, 200)
    whole, _ = certified("limits_5", warm=False)
    assert not found.finished
    assert not found.exact
    assert found.left > 0
    assert found.attained <= found.bound
    assert found.bound <= 13
    assert whole.finished


def test_bounds_that_have_changed_places_end_where_the_second_side_is_met() -> None:
    """z_1 from 0 up to theta, which may be -1."""
    hessian = np.array([[2.0, 0.5], [0.5, 1.0]])
    design = design_qp_solver("crossing", FLOAT64, hessian, np.eye(2), 50, 1e-6)
    scale = design.scale.astype(np.float64)[:, None]
    box, bounds = parameter_box([-1.0], [1.0])
    program = IterationProgram(
        tables=design.tables,
        free=np.array([[0.0, -0.5], [0.0, 0.2]]),
        low=np.array([[0.0, 0.0], [0.0, -1.0]]) * scale,
        high=np.array([[1.0, 0.0], [0.0, 1.0]]) * scale,
        domain_rows=box,
        domain_bounds=bounds,
    )
    found = certify_iterations(program, BUDGET, warm=False)
    assert found.exact
    assert found.infeasible
    result = program.solve(np.array([-0.5]), empty_set(design.tables), 50)
    assert result.infeasible
    assert result.iterations == found.bound


def test_a_parametric_program_has_its_rows_one_sided_and_its_bounds_paired() -> None:
    qp = parametric_qp(
        [[2.0, 0.5], [0.5, 1.0]], [[1.0], [1.5]], rows=[[1.0, 1.0]], bounds=[0.5],
        bounds_parameter=[[0.2]], lower=[-1.0, -1.0], upper=[1.0, np.inf],
        domain_rows=[[1.0], [-1.0]], domain_bounds=[3.0, 3.0],
    )  # fmt: skip
    program = iteration_program(qp, FLOAT64, 50, 1e-6)
    lowest = program.solve(np.array([3.0]), empty_set(program.tables), 50)
    assert lowest.optimal
    np.testing.assert_allclose(lowest.z, [-1.0, -1.0], atol=1e-6)  # no lower side of the row
    found = certify_iterations(program, BUDGET)
    assert found.exact
    assert found.infeasible == 0
    taken = {
        program.solve(np.array([theta]), empty_set(program.tables), 50).iterations
        for theta in np.linspace(-3.0, 3.0, 2001)
    }
    cold = certify_iterations(program, BUDGET, warm=False)
    assert cold.exact
    assert taken == {i for i, pieces in enumerate(cold.by_iterations) if pieces}


def test_parameters_without_bounds_are_refused() -> None:
    qp = parametric_qp([[1.0]], [[1.0]], lower=[-1.0], upper=[1.0])
    with pytest.raises(ExplicitError, match="bounded set"):
        certify_iterations(iteration_program(qp, FLOAT64, 50, 1e-6), BUDGET)
