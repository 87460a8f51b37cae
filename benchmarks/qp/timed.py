"""Solvers whose packages ship them compiled for wide vectors too: timed from Python as they come,
beside DAQP timed the same way."""

from __future__ import annotations

import multiprocessing
import os
import time
from collections.abc import Callable
from multiprocessing.connection import Connection

import numpy as np

from qp.counted import Measured, PeerFailed, judged
from qp.sequence import Array, Sequence
from qp.tolerance import TOLERANCE

# What a solver gives for one program: z, and whether it says it is solved.
Solve = Callable[[Array, Array, Array], tuple[Array, bool]]
Start = Callable[[Sequence, slice], Solve]
REPEATS = 3
LIMIT_S = 120.0
# An interior-point method stops at residuals, from which z is a few times further.
INTERIOR = 1e-11
BASE = "DAQP, library"


def daqp(sequence: Sequence, part: slice) -> Solve:
    import daqp as library

    rows = np.ascontiguousarray(sequence.rows)
    model = library.Model()
    model.settings = {"primal_tol": TOLERANCE}
    first = part.start
    model.setup(
        sequence.hessian, sequence.linear[first].copy(), rows, sequence.high[first].copy(),
        sequence.low[first].copy(), np.zeros(len(rows), dtype=np.int32),
    )  # fmt: skip

    def solve(linear: Array, low: Array, high: Array) -> tuple[Array, bool]:
        model.update(f=linear, bupper=high, blower=low)
        z, _, flag, _ = model.solve()
        return z, flag == 1

    return solve


def piqp(sequence: Sequence, part: slice) -> Solve:
    import piqp as library

    solver = library.DenseSolver()
    settings = solver.settings
    settings.eps_abs, settings.eps_rel, settings.verbose = INTERIOR, 0.0, False
    if hasattr(settings, "eps_duality_gap_abs"):
        settings.eps_duality_gap_abs, settings.eps_duality_gap_rel = INTERIOR, 0.0
    first = part.start
    n = sequence.variables
    empty, none = np.zeros((0, n)), np.zeros(0)
    solver.setup(
        sequence.hessian, sequence.linear[first], empty, none, sequence.rows,
        sequence.low[first], sequence.high[first],
    )  # fmt: skip

    def solve(linear: Array, low: Array, high: Array) -> tuple[Array, bool]:
        solver.update(c=linear, h_l=low, h_u=high)
        status = solver.solve()
        return np.array(solver.result.x), status == library.PIQP_SOLVED

    return solve


def proxqp(sequence: Sequence, part: slice) -> Solve:
    import proxsuite

    dense = proxsuite.proxqp.dense
    solver = dense.QP(sequence.variables, 0, sequence.count)
    solver.settings.eps_abs, solver.settings.eps_rel = TOLERANCE, 0.0
    # without it small residuals are enough, and z may be 1e-2 away
    solver.settings.check_duality_gap = True
    solver.settings.eps_duality_gap_abs, solver.settings.eps_duality_gap_rel = TOLERANCE, 0.0
    first = part.start
    solver.init(
        sequence.hessian, sequence.linear[first], None, None, sequence.rows,
        sequence.low[first], sequence.high[first],
    )  # fmt: skip

    solver.solve()
    solver.settings.initial_guess = proxsuite.proxqp.InitialGuess.WARM_START_WITH_PREVIOUS_RESULT

    def solve(linear: Array, low: Array, high: Array) -> tuple[Array, bool]:
        solver.update(g=linear, l=low, u=high)
        solver.solve()
        done = solver.results.info.status == proxsuite.proxqp.QPSolverOutput.PROXQP_SOLVED
        return np.array(solver.results.x), done

    return solve


def timed(name: str, start: Start, sequence: Sequence, part: slice) -> Measured:
    """In a process of its own, so that a peer that crashes is one line of the table.

    Raises:
        PeerFailed: it is not installed, raises, crashes or takes too long.
    """
    context = multiprocessing.get_context("fork")
    ours, theirs = context.Pipe(duplex=False)
    child = context.Process(target=_passes, args=(theirs, start, sequence, part))
    child.start()
    theirs.close()
    try:
        told = ours.recv() if ours.poll(LIMIT_S) else f"stopped after {LIMIT_S:.0f} s"
    except EOFError:
        child.join()
        told = f"its process ended with {child.exitcode}"
    child.kill()
    child.join()
    if isinstance(told, str):
        raise PeerFailed(told)
    return judged(name, "seconds", sequence, part, *told)


def _passes(out: Connection, start: Start, sequence: Sequence, part: slice) -> None:
    """The least of a few passes, per program: what else the machine does only adds."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # what C++ has to say
    try:
        answers = np.zeros((part.stop - part.start, sequence.variables + 2))
        answers[:, -1] = -1
        cost = np.full(len(answers), np.inf)
        for _ in range(REPEATS):
            solve = start(sequence, part)
            for i, t in enumerate(range(part.start, part.stop)):
                linear, low, high = sequence.linear[t], sequence.low[t], sequence.high[t]
                begin = time.perf_counter()
                z, solved = solve(linear, low, high)
                cost[i] = min(cost[i], time.perf_counter() - begin)
                answers[i, :-2], answers[i, -2] = z, 0.0 if solved else 1.0
        out.send((cost, answers))
    except ImportError as missing:
        out.send(f"not installed: {missing}")
    except Exception as fault:
        out.send(f"{type(fault).__name__}: {str(fault).splitlines()[0][:100]}")


TIMED: tuple[tuple[str, Start], ...] = (
    (BASE, daqp),
    ("PIQP, library", piqp),
    ("ProxQP, library", proxqp),
)
