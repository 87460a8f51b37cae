"""Rows as outputs of a plant and as columns: every way to ask for them says the same."""

from __future__ import annotations

import numpy as np
import pytest

from servogen.qp.row_tables import ColumnRows, StageRows, column_rows, stage_rows

Array = np.ndarray


def plant(steps: int = 4) -> tuple[StageRows, Array]:
    """Two inputs, three states, rows of all kinds; and A, from the plant's matrices alone."""
    rng = np.random.default_rng(3)
    a, b = 0.5 * rng.normal(size=(3, 3)), rng.normal(size=(3, 2))
    inner, outer = rng.normal(size=(1, 5)), rng.normal(size=(2, 5))
    terminal, bounds = rng.normal(size=(2, 3)), np.array([3.0, -0.5])
    rows = stage_rows(
        np.vstack([np.hstack([a, b]), inner]), terminal, steps, 2, np.dtype(float), 2, outer, bounds
    )
    written, x = [], np.zeros((3, 2 * steps))
    for k in range(steps):
        u = np.eye(2 * steps)[2 * k : 2 * k + 2]
        before, x = x, a @ x + b @ u
        written += [bounds[:, None] * u, x[:2], inner @ np.vstack([before, u])]
        written += [outer @ np.vstack([x, u])]
    return rows, np.vstack([*written, terminal @ x])


def columns() -> tuple[ColumnRows, Array]:
    rng = np.random.default_rng(4)
    dense = rng.normal(size=(9, 5)) * (np.arange(5) <= np.arange(9)[:, None] // 2)
    written = np.vstack([np.diag([2.0, -1.0, 0.5, 1.0, 3.0]), dense])
    return column_rows(written, np.dtype(float), 2, 1, bounds=5, inputs=1), written


@pytest.mark.parametrize("make", [plant, columns])
def test_all_say_the_same(make) -> None:
    rows, written = make()
    assert (rows.count, rows.variables) == written.shape
    v = np.random.default_rng(5).normal(size=rows.variables)
    np.testing.assert_allclose(rows.product(v), written @ v, atol=1e-12)
    y = np.random.default_rng(6).normal(size=rows.count)
    np.testing.assert_allclose(rows.adjoint(y), written.T @ y, atol=1e-12)
    for i in range(rows.count):
        own = np.zeros(rows.variables)
        own[: rows.row(i).size] = rows.row(i)
        np.testing.assert_allclose(own, written[i], atol=1e-13)
        assert not np.any(own[: rows.begin(i)])
        assert rows.dot(i, v) == pytest.approx(written[i] @ v, abs=1e-12)


def test_a_row_moves_with_the_horizon() -> None:
    """A row one sample later is the same output one step nearer: its coefficients move too."""
    rows, written = plant()
    for i in range(rows.stages):
        moved = rows.shifted(i)
        assert (moved < 0) == (i < rows.per_step)
        if moved >= 0:
            np.testing.assert_allclose(written[moved, :-2], written[i, 2:], atol=1e-12)
    assert [rows.shifted(i) for i in (rows.stages, rows.stages + 1)] == [
        rows.stages,
        rows.count - 1,
    ]
    other, _ = columns()
    assert [other.shifted(i) for i in (0, 1, 4)] == [-1, 0, 3]
    assert [other.shifted(i) for i in (5, 6, 7, 12, 13)] == [-1, -1, 5, 10, 13]


def test_a_bound_that_holds_another_variable_is_refused() -> None:
    for wrong in (np.array([[1.0, 0.0], [0.5, 1.0]]), np.array([[1.0, 0.5]])):
        with pytest.raises(ValueError, match="one variable"):
            column_rows(wrong, np.dtype(float), bounds=len(wrong))
    with pytest.raises(ValueError, match="one variable"):
        column_rows(np.eye(2), np.dtype(float), bounds=3)
