"""Instructions of one PQP iteration: pairing and low rank against the dense form of (20).

Both are compiled with the same flags and counted by valgrind's callgrind, which counts and does
not time. The dense form holds Q_d+ and Q_d- of all one-sided rows and multiplies both with the
duals, as (20) is printed. Data: the MPC of the bundled example.

    python benchmarks/pqp_iteration.py [float64|float32]
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from servogen.emit.literals import real_literal
from servogen.precision import PRECISIONS, Precision
from servogen.progress import Silent
from servogen.project import load_project
from servogen.resources import resource_dir
from servogen.steps.two_stage import prepare_two_stage

EXAMPLE = Path(__file__).parents[1] / "examples" / "two_stage" / "servogen.toml"
FLAGS = ["-std=c99", "-O3", "-ffp-contract=off"]
FEW, MANY = 100, 1100

PROGRAM = """
#include <stdio.h>
#include <stdlib.h>
typedef {type} sg_real;
#define SG_REAL_MAX {largest}
#include "sg_kernels.h"
#include "sg_pqp.h"
enum {{ ROWS = {rows}, PLAN = {plan}, ALL = 2 * ROWS }};
{tables}
static sg_real upper[ROWS], lower[ROWS], scratch[ROWS], correction[PLAN], change[ROWS];
static sg_real absolute_sum[ROWS], last_upper[ROWS], last_lower[ROWS], last_change[ROWS];
static sg_real y[ALL], q_plus_y[ALL], q_minus_y[ALL], f[ALL];

static void paired(void)
{{
    sg_pqp_state seen;
    sg_pqp_evaluate(ROWS, PLAN, inverse_columns, rows_columns, upper, lower, slack_upper,
                    slack_lower, scratch, correction, change, &seen);
    sg_pqp_multiply(ROWS, absolute, phi_diagonal, vanish, ceiling, slack_upper, slack_lower,
                    change, scratch, absolute_sum, upper, lower, last_upper, last_lower,
                    last_change);
}}

static void dense(void)
{{
    sg_matvec(ALL, ALL, q_plus, y, q_plus_y);
    sg_matvec(ALL, ALL, q_minus, y, q_minus_y);
    sg_real worst = (sg_real)0;
    sg_real gap = (sg_real)0;
    for (int i = 0; i < ALL; i++) {{
        const sg_real r = f[i] + (q_plus_y[i] - q_minus_y[i]);
        const sg_real keep = phi_diagonal[i % ROWS] * y[i];
        worst = sg_min(worst, r);
        gap += y[i] * r;
        y[i] = (y[i] * ((q_minus_y[i] + keep) + sg_max(-f[i], (sg_real)0))) /
               ((q_plus_y[i] + keep) + sg_max(f[i], (sg_real)0));
    }}
    scratch[0] = worst + gap;
}}

int main(int count, char **words)
{{
    const int turns = (count > 2) ? atoi(words[2]) : 1;
    for (int i = 0; i < ROWS; i++) {{
        upper[i] = y[i] = floor_[i];
        lower[i] = y[ROWS + i] = floor_[i];
        f[i] = slack_upper[i];
        f[ROWS + i] = slack_lower[i];
    }}
    for (int k = 0; k < turns; k++) {{
        if (words[1][0] == 'p') {{ paired(); }} else {{ dense(); }}
    }}
    printf("%a %a\\n", (double)upper[3], (double)y[3]);
    return 0;
}}
"""


def table(name: str, values: np.ndarray, precision: Precision) -> str:
    text = ", ".join(real_literal(float(v), precision) for v in np.ravel(values))
    return f"static const sg_real {name}[{np.size(values)}] = {{ {text} }};"


def write_program(folder: Path, precision: Precision) -> None:
    prepared = prepare_two_stage(load_project(EXAMPLE), Silent())
    mpc = prepared.in_precision(precision).mpc
    assert mpc is not None
    pqp, rng = mpc[0].pqp, np.random.default_rng(1)
    m = pqp.diagonal.size
    dual = pqp.rows_columns.T.astype(float) @ pqp.inverse_columns.T.astype(float)
    whole = np.block([[dual, -dual], [-dual, dual]])
    slack = 1.0 + rng.random((2, m))
    slack[0, 3::9] = -0.2
    tables = {
        "rows_columns": pqp.rows_columns,
        "inverse_columns": pqp.inverse_columns,
        "absolute": pqp.absolute,
        "phi_diagonal": pqp.phi_diagonal,
        "vanish": pqp.vanish,
        "ceiling": pqp.ceiling,
        "floor_": pqp.floor,
        "slack_upper": slack[0],
        "slack_lower": slack[1],
        "q_plus": np.maximum(whole, 0.0),
        "q_minus": np.maximum(-whole, 0.0),
    }
    (folder / "iteration.c").write_text(
        PROGRAM.format(
            type=precision.c_type,
            largest=precision.c_max,
            rows=m,
            plan=pqp.rows_columns.shape[0],
            tables="\n".join(table(name, values, precision) for name, values in tables.items()),
        )
    )


def instructions(folder: Path, form: str, turns: int) -> int:
    """Instructions of the whole process."""
    done = subprocess.run(
        ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", "./iteration", form,
         str(turns)],
        cwd=folder, capture_output=True, text=True, check=True,
    )  # fmt: skip
    found = re.search(r"Collected : (\d+)", done.stderr)
    if found is None:
        raise SystemExit(f"valgrind did not say how many instructions:\n{done.stderr}")
    return int(found[1])


def main() -> None:
    if shutil.which("valgrind") is None:
        raise SystemExit("this benchmark needs valgrind: apt-get install valgrind")
    names = sys.argv[1:] or ["float64", "float32"]
    print("instructions per PQP iteration (callgrind, gcc -O3), one axis of the bundled example")
    for name in names:
        with tempfile.TemporaryDirectory() as text:
            folder = Path(text)
            write_program(folder, PRECISIONS[name])
            subprocess.run(
                ["gcc", *FLAGS, f"-I{resource_dir('c_runtime')}", "iteration.c", "-o", "iteration"],
                cwd=folder, check=True,
            )  # fmt: skip
            each = {
                form: (instructions(folder, form, MANY) - instructions(folder, form, FEW))
                / (MANY - FEW)
                for form in ("paired", "dense")
            }
        ratio = each["paired"] / each["dense"]
        print(f"{name}: dense {each['dense']:.0f}, pairing and low rank {each['paired']:.0f}, "
              f"ratio {ratio:.3f}")  # fmt: skip


if __name__ == "__main__":
    main()
