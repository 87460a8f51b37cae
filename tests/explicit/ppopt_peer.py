"""PPOPT on a program of ours, in scaled parameters and variables so that both see good numbers."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from servogen.qp.parametric import ParametricQP


def ppopt_active_sets(
    problem: ParametricQP, algorithm: str, process: bool = False
) -> list[tuple[int, ...]]:
    """Active sets of PPOPT's regions, in our numbers of the constraints.

    Args:
        problem: with a domain; PPOPT knows bounded parameters only.
        algorithm: ``combinatorial``, ``graph`` or ``geometric``.
        process: let PPOPT process its constraints first, as its manual recommends; it may drop
            redundant ones, so the numbers are ours only if there are none.
    """
    solution, numbers, _, _ = ppopt_solution(problem, algorithm, process)
    found = solution.critical_regions
    return sorted(tuple(sorted(numbers[i] for i in region.active_set)) for region in found)


def ppopt_solution(
    problem: ParametricQP, algorithm: str, process: bool = False
) -> tuple[Any, list[int], np.ndarray, np.ndarray]:
    """PPOPT's solution, the numbers of its constraints, and the units of its variables (n,) and
    parameters (p,): ours are these times its own."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from ppopt.mp_solvers.solve_mpqp import mpqp_algorithm, solve_mpqp
        from ppopt.mpqp_program import MPQP_Program

        g, w, s, numbers = problem.all_rows()
        sizes = 1.0 / np.sqrt(np.diag(problem.hessian))  # of the variables
        extent = _extent(problem)
        rows = g * sizes
        length = np.linalg.norm(rows, axis=1)
        program = MPQP_Program(
            rows / length[:, None],
            (w / length)[:, None],
            (problem.constant * sizes)[:, None],
            problem.linear * np.outer(sizes, extent),
            problem.hessian * np.outer(sizes, sizes),
            problem.domain_rows * extent,
            problem.domain_bounds[:, None].copy(),
            s * extent / length[:, None],
            post_process=process,
        )
        solution = solve_mpqp(program, getattr(mpqp_algorithm, algorithm))
    return solution, numbers.tolist(), sizes, extent


def _extent(problem: ParametricQP) -> np.ndarray:
    """Size of each parameter, from the single-parameter rows of the domain."""
    extent = np.ones(problem.parameters)
    for row, bound in zip(problem.domain_rows, problem.domain_bounds, strict=True):
        entries = np.flatnonzero(row)
        if entries.size == 1 and bound != 0.0:
            extent[entries[0]] = abs(bound / row[entries[0]])
    return extent
