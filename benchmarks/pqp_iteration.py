"""Instructions of one PQP iteration of the bundled example, against the dense form of (20).

Counted by valgrind's callgrind, which counts and does not time; everything is compiled with the
same flags. An iteration is an evaluation and a turn of (20), the dearest of the turns.

  dense    Q_d+ and Q_d- of all one-sided rows, both multiplied with the duals, as (20) is printed
  paired   the same with two-sided rows: |D| s and A (H^-1 A' d) as three dense products
  emitted  two_stage_mpc.c: at worst (every pair above its floor), and on the iterates of the
           example's closed loop, the median of them and the dearest

The promise: at worst a quarter of the dense form. Exit code 1 where it is broken.

    python benchmarks/pqp_iteration.py [float64|float32]
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from servogen.controllers.cascade import Cascade
from servogen.controllers.cascade_design import CascadeDesign, declare_parts
from servogen.controllers.mpc_design import MpcDesign
from servogen.emit.literals import real_literal
from servogen.emit.package import emit_package
from servogen.precision import PRECISIONS, Precision
from servogen.progress import Silent
from servogen.project import load_project
from servogen.qp import pqp
from servogen.steps.two_stage import TwoStage, prepare_two_stage
from servogen.systems.closed_loop import run_closed_loop

EXAMPLE = Path(__file__).parents[1] / "examples" / "two_stage" / "servogen.toml"
FLAGS = ["-std=c99", "-O3", "-ffp-contract=off"]
PERIODS, MOST = 400, 400
PROMISE = 0.25
TOTAL = re.compile(r"^(?:totals|summary): (\d+)", re.MULTILINE)

PROGRAM = """
#include <stdio.h>
#include "two_stage_mpc.c"
#include "dense.h"
enum {{ ROWS = TWO_STAGE_MPC_ROWS, PLAN = TWO_STAGE_MPC_HORIZON, ALL = 2 * ROWS }};
static two_stage_mpc_t mpc;
static sg_pqp_state seen;
static sg_real y[ALL], q_plus_y[ALL], q_minus_y[ALL], f[ALL], told;

__attribute__((noinline, noclone)) void count_emitted(void)
{{
    two_stage_mpc_correct(&mpc);
    sg_pqp_evaluate(ROWS, mpc.upper, mpc.lower, mpc.slack_upper, mpc.slack_lower, mpc.change,
                    &seen);
    two_stage_mpc_multiply(&mpc);
}}

__attribute__((noinline, noclone)) void count_paired(void)
{{
    for (int i = 0; i < ROWS; i++) {{
        mpc.scratch[i] = mpc.upper[i] - mpc.lower[i];
    }}
    sg_matvec(PLAN, ROWS, inverse_columns, mpc.scratch, mpc.correction);
    sg_matvec(ROWS, PLAN, rows_columns, mpc.correction, mpc.change);
    sg_pqp_evaluate(ROWS, mpc.upper, mpc.lower, mpc.slack_upper, mpc.slack_lower, mpc.change,
                    &seen);
    for (int i = 0; i < ROWS; i++) {{
        mpc.scratch[i] = mpc.upper[i] + mpc.lower[i];
    }}
    sg_matvec(ROWS, ROWS, absolute, mpc.scratch, mpc.absolute_sum);
    sg_pqp_multiply(ROWS, mpc.absolute_sum, two_stage_mpc_phi_diagonal, two_stage_mpc_vanish,
                    two_stage_mpc_ceiling, mpc.slack_upper, mpc.slack_lower, mpc.change, mpc.upper,
                    mpc.lower, mpc.last_upper, mpc.last_lower, mpc.last_change);
}}

__attribute__((noinline, noclone)) void count_dense(void)
{{
    sg_matvec(ALL, ALL, q_plus, y, q_plus_y);
    sg_matvec(ALL, ALL, q_minus, y, q_minus_y);
    sg_real worst = (sg_real)0;
    sg_real gap = (sg_real)0;
    for (int i = 0; i < ALL; i++) {{
        const sg_real r = f[i] + (q_plus_y[i] - q_minus_y[i]);
        const sg_real keep = two_stage_mpc_phi_diagonal[i % ROWS] * y[i];
        worst = sg_min(worst, r);
        gap += y[i] * r;
        y[i] = (y[i] * ((q_minus_y[i] + keep) + sg_max(-f[i], (sg_real)0))) /
               ((q_plus_y[i] + keep) + sg_max(f[i], (sg_real)0));
    }}
    told = worst + gap;
}}

/* upper, lower, slack_upper, slack_lower of every iterate on the standard input */
int main(int count, char **words)
{{
    sg_real in[4 * ROWS];
    (void)count;
    two_stage_mpc_init(&mpc);
    while (fread(in, sizeof in, 1, stdin) == 1) {{
        for (int i = 0; i < ROWS; i++) {{
            mpc.upper[i] = y[i] = in[i];
            mpc.lower[i] = y[ROWS + i] = in[ROWS + i];
            mpc.slack_upper[i] = f[i] = in[(2 * ROWS) + i];
            mpc.slack_lower[i] = f[ROWS + i] = in[(3 * ROWS) + i];
        }}
        switch (words[1][0]) {{
        case 'e': count_emitted(); break;
        case 'p': count_paired(); break;
        default: count_dense(); break;
        }}
    }}
    printf("%a %a %a %a\\n", (double)mpc.upper[3], (double)y[3], (double)told, (double)seen.gap);
    return 0;
}}
"""


def table(name: str, values: np.ndarray, precision: Precision) -> str:
    text = ", ".join(real_literal(float(v), precision) for v in np.ravel(values))
    return f"static const sg_real {name}[{np.size(values)}] = {{ {text} }};"


def mpc_of(design: CascadeDesign) -> MpcDesign:
    assert design.mpc is not None
    return design.mpc[0]


def write_program(folder: Path, cascade: CascadeDesign) -> None:
    """The emitted package, and the program around the MPC of axis x."""
    emit_package(cascade.prefix, declare_parts(cascade)).write(folder)
    design = mpc_of(cascade)
    matrix = design.qp.rows_command
    inverse_columns = np.linalg.solve(design.qp.hessian, matrix.T).T
    dual = matrix @ inverse_columns.T
    whole = np.block([[dual, -dual], [-dual, dual]])
    tables = {
        "rows_columns": matrix.T,
        "inverse_columns": inverse_columns,
        "absolute": np.abs(dual),
        "q_plus": np.maximum(whole, 0.0),
        "q_minus": np.maximum(-whole, 0.0),
    }
    (folder / "dense.h").write_text(
        "\n".join(table(name, values, design.precision) for name, values in tables.items())
    )
    (folder / "iteration.c").write_text(PROGRAM.format())
    subprocess.run(["gcc", *FLAGS, "iteration.c", "-o", "iteration"], cwd=folder, check=True)


def iterates(two: TwoStage, cascade: CascadeDesign) -> np.ndarray:
    """(k, 4, m) duals and slacks of turns of (20), evenly over the example's closed loop."""
    found: list[np.ndarray] = []
    solve, majorant = pqp.solve, pqp._majorant
    slacks: list[np.ndarray] = []

    def solve_watched(tables, tol, upper_slack, lower_slack, upper, lower):  # type: ignore[no-untyped-def]
        slacks[:] = upper_slack, lower_slack
        return solve(tables, tol, upper_slack, lower_slack, upper, lower)

    def turn_watched(tables, upper, lower):  # type: ignore[no-untyped-def]
        found.append(np.stack([upper, lower, *slacks]))
        return majorant(tables, upper, lower)

    pqp.solve, pqp._majorant = solve_watched, turn_watched
    try:
        run_closed_loop(two.machine, Cascade(cascade), PERIODS)
    finally:
        pqp.solve, pqp._majorant = solve, majorant
    return np.array(found[:: -(-len(found) // MOST)])


def instructions(folder: Path, form: str, given: np.ndarray) -> np.ndarray:
    """(k,) instructions of each iteration."""
    for old in folder.glob("dump*"):
        old.unlink()
    (folder / "given").write_bytes(np.ascontiguousarray(given).tobytes())
    with (folder / "given").open("rb") as file:
        subprocess.run(
            ["valgrind", "--tool=callgrind", "--callgrind-out-file=dump", "--collect-atstart=no",
             f"--toggle-collect=count_{form}", f"--dump-after=count_{form}", "./iteration", form],
            cwd=folder, stdin=file, capture_output=True, check=True,
        )  # fmt: skip
    each = [
        int(told[1]) for dump in folder.glob("dump.*") if (told := TOTAL.search(dump.read_text()))
    ]
    counts = np.array([count for count in each if count])
    if len(counts) != len(given):
        raise SystemExit(f"callgrind counted {len(counts)} of {len(given)} iterations")
    return counts


def measured(name: str) -> bool:
    """Print what one precision takes; whether the promise is kept."""
    two = prepare_two_stage(load_project(EXAMPLE), Silent())
    cascade = two.in_precision(PRECISIONS[name])
    loop = iterates(two, cascade)
    at_worst, tables = np.array(loop[:1]), mpc_of(cascade).solver
    assert isinstance(tables, pqp.PqpTables)
    at_worst[:, :2] = 10.0 * tables.floor
    with tempfile.TemporaryDirectory() as text:
        folder = Path(text)
        write_program(folder, cascade)
        dense, paired, worst = (
            int(instructions(folder, form, at_worst)[0]) for form in ("dense", "paired", "emitted")
        )
        each = instructions(folder, "emitted", loop)
    median = float(np.median(each))
    print(f"{name}: dense {dense}, paired {paired} ({paired / dense:.3f}), "
          f"emitted at worst {worst} ({worst / dense:.3f}), "
          f"in the closed loop median {median:.0f} ({median / dense:.3f}), "
          f"maximum {max(each)}, of {len(each)}")  # fmt: skip
    return worst <= PROMISE * dense and max(each) <= worst


def main() -> int:
    reader = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    reader.add_argument("precisions", nargs="*", metavar="precision", help=" or ".join(PRECISIONS))
    given = reader.parse_args().precisions or ["float64", "float32"]
    if unknown := [name for name in given if name not in PRECISIONS]:
        reader.error(f"no precision is called {unknown[0]}: {' or '.join(PRECISIONS)}")
    if shutil.which("valgrind") is None:
        raise SystemExit("this benchmark needs valgrind: apt-get install valgrind")
    print("instructions per PQP iteration (callgrind, gcc -O3), one axis of the bundled example")
    kept = [measured(name) for name in given]
    print(f"at worst {PROMISE} of the dense form: {'kept' if all(kept) else 'BROKEN'}")
    return 0 if all(kept) else 1


if __name__ == "__main__":
    sys.exit(main())
