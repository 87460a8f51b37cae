"""What rounding leaves of the rows of a working set is taken away by ever smaller steps."""

from __future__ import annotations

import numpy as np
import pytest

from servogen.precision import PRECISIONS
from servogen.qp.active_set_factor import empty_set
from servogen.qp.active_set_tables import ActiveSetTables, active_set_tables
from servogen.qp.dual_active_set import solve
from servogen.qp.row_tables import column_rows

N, ROWS, ACCEPT = 8, 8, 2e-6


def program(seed: int) -> tuple[ActiveSetTables, np.ndarray, np.ndarray]:
    """Rows that a far optimum breaks by hundreds of their bounds, in float32."""
    rng = np.random.default_rng(seed)
    rows = np.linalg.qr(rng.normal(size=(N, N)))[0][:ROWS] + 0.1 * rng.normal(size=(ROWS, N))
    root = np.eye(N) + 0.3 * rng.normal(size=(N, N))
    float32 = PRECISIONS["float32"]
    hessian = root @ root.T
    tables = active_set_tables(hessian, rows, column_rows(rows, float32.dtype), ACCEPT, 40, float32)
    return tables, (300.0 * rng.normal(size=N)).astype(np.float32), rows


@pytest.mark.parametrize("seed", range(20))
def test_a_far_optimum_ends_within_what_is_accepted(seed: int) -> None:
    """Products of the size of z_unc are known to 2e-5 in float32, ten times what is accepted."""
    tables, free, rows = program(seed)
    bound = np.full(ROWS, 1.0, dtype=np.float32)
    result = solve(tables, empty_set(tables), free, -bound, bound)
    assert result.optimal, result.iterations
    assert len(result.active) >= 4
    at = rows @ result.z.astype(np.float64)
    assert np.max(np.abs(at)) <= 1.0 + 2.0 * ACCEPT
