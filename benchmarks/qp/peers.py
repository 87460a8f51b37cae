"""The solvers that are C of their own process: how each is made of a sequence, and counted."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np

from qp.counted import (
    COMPILER,
    FLAGS,
    HERE,
    Measured,
    PeerFailed,
    compile_peer,
    counted_peer,
    run,
)
from qp.libraries import (
    PIQP,
    PROXQP,
    QPOASES,
    QUADPROG,
    TINYMPC,
    WRAPPED,
    piqp,
    proxqp,
    qpoases,
    quadprog,
    tinympc,
)
from qp.sdist import sdist
from qp.sequence import Sequence
from qp.tolerance import TOLERANCE, reaching
from servogen.controllers.qp_solver_design import (
    QpSolverDesign,
    declare_qp_solver,
    design_plant_qp_solver,
    design_qp_solver,
)
from servogen.emit.literals import real_literal
from servogen.emit.package import emit_package
from servogen.precision import PRECISIONS
from servogen.qp.pqp import pqp_tables
from servogen.qp.row_tables import column_rows
from servogen.qp.tolerances import tolerances
from servogen.resources import resource_dir

DOUBLE = PRECISIONS["float64"]
CAP = 500
Peer = Callable[[Sequence, slice, Path], Measured]


def _active_set(design: QpSolverDesign, name: str, sequence: Sequence, part: slice, folder: Path
) -> Measured:  # fmt: skip
    declared = declare_qp_solver(design)
    package = emit_package("sgq", (declared,))
    package.write(folder)
    program = compile_peer(
        folder, [HERE / "servogen_peer.c", *(folder / source for source in package.sources)],
        extra=["-std=c99", f"-DTABLE_BYTES={declared.table_bytes}"],
    )  # fmt: skip
    return counted_peer(name, program, sequence, part)


def stages(sequence: Sequence, part: slice, folder: Path) -> Measured:
    """servogen's active-set method, rows as outputs of a plant."""
    plant = sequence.plant
    if plant is None:
        raise PeerFailed("cannot state it: the sequence has no plant")
    rows = plant.rows(sequence.variables)
    design = design_plant_qp_solver("sgq", DOUBLE, sequence.hessian, rows, CAP, TOLERANCE)
    return _active_set(design, STAGES, sequence, part, folder)


def columns(sequence: Sequence, part: slice, folder: Path) -> Measured:
    """servogen's active-set method, rows as columns; bounds of single variables as such."""
    design, given = column_design(sequence)
    return _active_set(design, COLUMNS, given, part, folder)


def column_design(sequence: Sequence) -> tuple[QpSolverDesign, Sequence]:
    """And the sequence with its bounds first, as the design has them."""
    given, bounds = simple_bounds_first(sequence)
    inputs = sequence.plant.inputs if sequence.plant is not None and bounds else 0
    per_step = sequence.per_step - inputs if given.count > bounds else 0
    staying = min(sequence.staying, given.count - bounds)  # of rows that are no bounds
    design = design_qp_solver(
        "sgq", DOUBLE, given.hessian, given.rows, CAP, TOLERANCE, per_step, staying, bounds, inputs
    )  # fmt: skip
    return design, given


def pqp(sequence: Sequence, part: slice, folder: Path) -> Measured:
    """servogen's PQP, its relative gap the largest that gives the accuracy."""
    return reaching(lambda gap: _pqp(sequence, part, folder, gap), (1e-10, 1e-11, 1e-12))


def _pqp(sequence: Sequence, part: slice, folder: Path, gap: float) -> Measured:
    tol = tolerances(DOUBLE, 1e-9, gap, sequence.hessian, float(np.ptp(sequence.optimum)))
    per_step = sequence.per_step
    steps = (sequence.count - sequence.staying) // per_step if per_step else 0
    made = pqp_tables(
        sequence.hessian, sequence.rows, column_rows(sequence.rows, DOUBLE.dtype), 0.1, 6, CAP, tol,
        DOUBLE.dtype, per_step, steps,
    )  # fmt: skip
    lines_, stride = (4 * -(-size // 4) for size in made.columns.shape)
    room = stride - sequence.count
    arrays = {
        "rows_columns": sequence.rows.T,
        "inverse_columns": np.linalg.solve(sequence.hessian, sequence.rows.T).T,
        "columns": np.pad(made.columns, ((0, lines_ - len(made.columns)), (0, room))),
        "at_floor": np.pad(made.at_floor, (0, room)), "root_diagonal": made.root_diagonal,
        "diagonal": made.diagonal,
        "inverse_diagonal": made.inverse_diagonal, "phi_diagonal": made.phi_diagonal,
        "floor_": made.floor, "vanish": made.vanish, "ceiling": made.ceiling,
        "inverse": np.linalg.inv(sequence.hessian),
    }  # fmt: skip
    scalars = {
        "tolerance": tol.accept, "gap_limit": tol.gap, "clamp": tol.clamp,
        "room": 1.0 - tol.clamp, "weight": tol.weight, "least_step": made.least_step,
        "least_curvature": made.least_curvature, "longest": made.longest, "margin": tol.margin,
    }  # fmt: skip
    sizes_ = {
        "ROWS": sequence.count, "PLAN": sequence.variables, "PERIOD": 6, "CAP": CAP,
        "PER_STEP": sequence.per_step, "STAYING": sequence.staying,
        "LINES": lines_, "STRIDE": stride, "BLOCKS": made.blocks,
    }  # fmt: skip
    lines = [f"enum {{ {', '.join(f'{k} = {v}' for k, v in sizes_.items())} }};"]
    lines += [
        f"static const sg_real {name} = {real_literal(float(value), DOUBLE)};"
        for name, value in scalars.items()
    ]
    lines += [
        f"static const sg_real {name}[{values.size}] = "
        f"{{ {', '.join(real_literal(float(v), DOUBLE) for v in values.ravel())} }};"
        for name, values in arrays.items()
    ]
    (folder / "pqp_tables.h").write_text("\n".join(lines) + "\n")
    program = compile_peer(folder, [HERE / "pqp_peer.c"], [resource_dir("c_runtime")], ["-std=c99"])
    return counted_peer(PQP, program, sequence, part, static=True)


def simple_bounds_first(sequence: Sequence) -> tuple[Sequence, int]:
    """The first row of every variable that is it alone, in their order, if every one has such a
    row: they are bounds to DAQP and get scaled to be."""
    alone = np.flatnonzero(np.count_nonzero(sequence.rows, axis=1) == 1)
    n = sequence.variables
    which, first = np.unique(np.argmax(np.abs(sequence.rows[alone]), axis=1), return_index=True)
    if len(which) != n:
        return sequence, 0
    order = np.concatenate([alone[first], np.delete(np.arange(sequence.count), alone[first])])
    unit = np.ones(sequence.count)
    unit[:n] = sequence.rows[order[:n], np.arange(n)]
    kept = {name: getattr(sequence, name) for name in sequence.__dataclass_fields__}
    kept["rows"] = sequence.rows[order] / unit[:, None]
    kept["low"], kept["high"] = sequence.low[:, order] / unit, sequence.high[:, order] / unit
    return Sequence(**kept), n


def _library(source: Path) -> Path:
    """DAQP's objects, compiled once."""
    whole = source / "daqp.o"
    if not whole.is_file():
        objects = []
        for place in sorted((source / "src").glob("*.c")):
            objects.append(place.with_suffix(".o"))
            run(
                [COMPILER, *FLAGS, f"-I{source / 'include'}", "-c", place, "-o", objects[-1]],
                source,
            )
        run(["ld", "-r", *objects, "-o", whole], source)
    return whole


def daqp(sequence: Sequence, part: slice, folder: Path) -> Measured:
    """DAQP, compiled from the C of its sdist."""
    source = sdist("daqp", folder.parent) / "csrc"
    given, simple = simple_bounds_first(sequence)
    program = compile_peer(
        folder, [HERE / "daqp_peer.c", HERE / "asked.c", _library(source)], [source / "include"],
        [f"-DSIMPLE={simple}", f"-DTOLERANCE={TOLERANCE}", *WRAPPED],
    )  # fmt: skip
    note = f"{simple} simple bounds" if simple else ""
    return counted_peer(DAQP, program, given, part, note=note)


def osqp(sequence: Sequence, part: slice, folder: Path) -> Measured:
    """OSQP's generated code, matrices may change: only then may it adapt its step."""
    return reaching(lambda eps: _osqp(sequence, part, folder, eps), (TOLERANCE, 1e-10, 1e-11))


def _osqp(sequence: Sequence, part: slice, folder: Path, eps: float) -> Measured:
    try:
        import osqp as library
        import scipy.sparse as sparse
    except ImportError as missing:
        raise PeerFailed(f"not installed: {missing}") from missing
    model = library.OSQP(algebra="builtin")
    model.setup(
        sparse.csc_matrix(np.triu(sequence.hessian)), sequence.linear[part][0],
        sparse.csc_matrix(sequence.rows), sequence.low[part][0], sequence.high[part][0],
        eps_abs=eps, eps_rel=eps, max_iter=4000, check_termination=25, verbose=False,
    )  # fmt: skip
    out = folder / "gen"
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir()
    model.codegen(
        str(out), parameters="matrices", prefix="gen_", force_rewrite=True,
        include_codegen_src=True,
    )  # fmt: skip
    sources = [out / "gen_workspace.c", *sorted((out / "src").glob("*.c"))]
    program = compile_peer(
        folder, [HERE / "osqp_peer.c", *sources],
        [out, out / "inc" / "public", out / "inc" / "private"],
    )  # fmt: skip
    return counted_peer(OSQP, program, sequence, part, static=True)


def casadi(sequence: Sequence, part: slice, folder: Path) -> Measured:
    """C generated by CasADi, its active-set method qrqp, from the last answer on."""
    import casadi as ca

    n, m = sequence.variables, sequence.count
    solver = ca.conic(
        "solver", "qrqp", {"h": ca.Sparsity.dense(n, n), "a": ca.DM(sequence.rows).sparsity()},
        {"print_iter": False, "print_header": False, "print_info": False,
         "constr_viol_tol": TOLERANCE, "dual_inf_tol": TOLERANCE, "max_iter": CAP,
         "error_on_fail": False},
    )  # fmt: skip
    names = [ca.MX.sym("f", n), ca.MX.sym("low", m), ca.MX.sym("high", m), ca.MX.sym("start", n)]
    hessian, rows = ca.MX.sym("hessian", n, n), ca.MX.sym("rows", m, n)
    out = solver(
        h=hessian, g=names[0], a=ca.project(rows, ca.DM(sequence.rows).sparsity()), lba=names[1],
        uba=names[2], x0=names[3],
    )  # fmt: skip
    function = ca.Function("solve_qp", [*names, hessian, rows], [out["x"]])
    generator = ca.CodeGenerator("generated.c", {"with_header": True})
    generator.add(function)
    generator.generate(f"{folder}/")
    program = compile_peer(folder, [HERE / "casadi_peer.c", folder / "generated.c"])
    return counted_peer(CASADI, program, sequence, part)


STAGES = "servogen, stage rows"
COLUMNS = "servogen, column rows"
PQP = "servogen, PQP"
DAQP = "DAQP"
OSQP = "OSQP, generated C"
CASADI = "CasADi, generated C"

# In the order of the table; how many programs each is given where the count would take long.
COUNTED: tuple[tuple[str, Peer, int | None], ...] = (
    (DAQP, daqp, None),
    (STAGES, stages, None),
    (COLUMNS, columns, None),
    (PQP, pqp, 60),
    (OSQP, osqp, 60),
    (CASADI, casadi, 5),
    (QPOASES, qpoases, 200),
    (QUADPROG, quadprog, 200),
    (PIQP, piqp, 60),
    (PROXQP, proxqp, 60),
    (TINYMPC, tinympc, 10),
)
