"""What PQP's numbers are kept within, met: duals at their ceilings, and a slope out of range."""

from __future__ import annotations

import ctypes
import subprocess
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from core_designs import Variant, design, package, temporary_folder

from servogen.controllers.design import Status
from servogen.controllers.mpc_design import MpcDesign, declare_mpc
from servogen.controllers.mpc_solver import PqpSolver
from servogen.controllers.tracking_mpc import TrackingMpc
from servogen.emit.package import emit_package
from servogen.precision import PRECISIONS
from servogen.qp.pqp import PqpTables, _extrapolate
from servogen.qp.tolerances import QpTolerances
from servogen.sil.build import compile_package
from servogen.sil.compiled import CompiledController
from servogen.sil.harness import Agreement, Call, compare_outputs

Array = np.ndarray
HORIZON = 5
BOTH = pytest.mark.parametrize("precision", ["float64", "float32"])


def low_ceilings(precision: str) -> MpcDesign:
    """Within the bounds that ports take, duals come to a thousandth of their ceilings: these are a
    hundred thousandth of what the design says."""
    v = Variant(prefix=f"low{precision[5:]}", horizon=HORIZON, cap=40, letter="L",
                precision=precision)  # fmt: skip
    given = design(v).mpc
    assert given is not None
    tables = given[0].solver
    assert isinstance(tables, PqpTables)
    ceiling = tables.ceiling * tables.ceiling.dtype.type(1e-5)
    return replace(given[0], solver=replace(tables, ceiling=ceiling))


def step(names: list[str], low: float, high: float) -> Call:
    """From rest, with references that rise."""
    rising = np.linspace(0.0, 0.02, HORIZON + 1)
    bounds = {"low": np.full(HORIZON, low), "high": np.full(HORIZON, high)}
    return Call("step", {**dict.fromkeys(names, 0.0), "reference": rising, **bounds})


@BOTH
def test_duals_at_their_ceilings_come_to_lower_ones(precision: str) -> None:
    """No plan keeps the first three programs, whose bounds have changed places; the next ones have
    a solution, from the duals that these leave. Those of the C are found in its memory."""
    own = low_ceilings(precision)
    reference = TrackingMpc(own)
    solver = reference.solver
    assert isinstance(solver, PqpSolver)
    made = emit_package(own.prefix, (declare_mpc(own),))
    module = compile_package([made], temporary_folder(own.prefix), ["-O0"])
    compiled, agreement = CompiledController(module, declare_mpc(own)), Agreement()
    ceiling, per_step = solver.tables.ceiling, own.qp.rows_per_step
    stage = own.rows - own.qp.terminal_rows
    calls = [Call("reset", {"position": 0.0})]
    calls += [step(reference._names, 0.3, -0.3)] * 3 + [step(reference._names, -0.03, 0.001)] * 3
    lowered, statuses = 0, []
    for call in calls:
        shifted = np.concatenate([solver.upper[per_step:stage], solver.lower[per_step:stage]])
        lowered += np.sum(shifted > np.tile(ceiling[: stage - per_step], 2))
        first = reference.call(call.operation, call.inputs)
        compare_outputs(agreement, call, first, compiled.call(call.operation, call.inputs), 0.0)
        assert agreement.passed, agreement.difference
        statuses.append(first[0])
        assert np.all(solver.upper <= ceiling)
        assert np.all(solver.lower <= ceiling)
        memory = bytes(compiled._ffi.buffer(compiled.memory))
        assert solver.upper.tobytes() in memory, len(statuses)
        assert solver.lower.tobytes() in memory, len(statuses)
    assert lowered >= 3
    assert statuses[1:4] == [Status.INFEASIBLE] * 3
    assert Status.OK in statuses[4:]


EXTRAPOLATE = """
#include "{name}_scalar.h"
#include "sg_pqp.h"

void extrapolate(int m, const sg_real *d, const sg_real *vanish, const sg_real *ceiling,
                 const sg_real *told, const sg_real *slack_upper, const sg_real *slack_lower,
                 const sg_real *change, sg_real *upper, sg_real *lower, const sg_real *last_upper,
                 const sg_real *last_lower, const sg_real *last_change)
{{
    sg_pqp_extrapolate(m, d, vanish, ceiling, told[0], told[1], told[2], told[3], told[4], told[5],
                       slack_upper, slack_lower, change, upper, lower, last_upper, last_lower,
                       last_change);
}}
"""


def extrapolated_in_c(precision: str, arrays: list[Array]) -> tuple[Array, Array]:
    """The function of the runtime, compiled with a package's scalar type."""
    v = Variant(prefix=f"slope{precision[5:]}", horizon=2, precision=precision)
    folder, made = temporary_folder(v.prefix), package(v)
    made.write(folder)
    text = EXTRAPOLATE.format(name=made.name)
    (folder / "slope.c").write_text(text, encoding="utf-8")
    library = folder / "slope.so"
    command = ["gcc", "-std=c99", "-O1", "-ffp-contract=off", "-shared", "-fPIC"]
    subprocess.run([*command, "-o", library, folder / "slope.c"], check=True)
    given = [np.array(each, dtype=PRECISIONS[precision].dtype) for each in arrays]
    places: list[Any] = [each.ctypes.data_as(ctypes.c_void_p) for each in given]
    ctypes.CDLL(str(library)).extrapolate(given[0].size, *places)
    return given[7], given[8]


@BOTH
def test_a_slope_beyond_the_range_is_bounded_alike(precision: str) -> None:
    """At the function: ceilings keep a loop's slope far from the bound, which is the root of the
    largest number. One dual rises by 1e6 against a slack that makes the slope a thousand times the
    bound, the others hardly."""
    real = PRECISIONS[precision].dtype.type
    given = design(Variant(precision=precision, horizon=2)).mpc
    assert given is not None
    own, tol = given[0].solver, QpTolerances(margin=1e-6, accept=9e-7, gap=1e-5)
    assert isinstance(own, PqpTables)
    m, longest = 3, float(own.longest)
    one, rise = np.ones(m, dtype=real), np.array([1e6, 1.0, 0.5], dtype=real)
    tables = replace(own, diagonal=one, vanish=real(1e-14) * one,
                     ceiling=real(longest) * one)  # fmt: skip
    # the curvature is the rise times what it changes
    last, change = one.copy(), np.array([longest * 1e-9, 0.0, 0.0], dtype=real)
    slack = np.array([-1e-3 * longest, 0.0, 0.0], dtype=real)
    upper, zero = last + rise, np.zeros(m, dtype=real)
    r_upper, r_lower = slack + change, -change
    found = _extrapolate(tables, tol, upper, last, last, last, change, r_upper, r_lower)
    slope = float(np.sum(rise.astype(float) * r_upper))
    assert slope < -500.0 * longest
    # unbounded, the step would be a thousand times as long
    curvature = float(rise[0]) * float(change[0])
    np.testing.assert_allclose(
        found[0], upper + longest / curvature * rise.astype(float), rtol=1e-3
    )
    told = [tol.clamp, 1.0 - tol.clamp, tol.weight, own.least_step, own.least_curvature, longest]
    in_c = extrapolated_in_c(
        precision,
        [tables.diagonal, tables.vanish, tables.ceiling, np.array(told), slack, zero, change,
         upper, last, last, last, zero],
    )  # fmt: skip
    assert in_c[0].tobytes() == found[0].tobytes()
    assert in_c[1].tobytes() == found[1].tobytes()
