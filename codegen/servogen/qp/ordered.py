"""Linear algebra in the order in which the emitted C computes it.

The reference steps must take the same decisions as the C (iterations, points, status), so they
must compute the same bits. IEEE arithmetic is exact operation by operation; only the order of the
sums is free, and ``numpy.dot`` leaves it to a BLAS. These helpers sum strictly from the first term
to the last, which is what ``sg_matvec`` in ``c_runtime/sg_kernels.h`` does (without fused
multiply-add: ``-ffp-contract=off``).
"""

from __future__ import annotations

import numpy as np

from servogen.precision import FloatArray


def matvec(columns: FloatArray, x: FloatArray) -> FloatArray:
    """Product M x from the transposed table ``columns`` = M' of shape (cols, rows).

    ``add.accumulate`` is sequential by definition, unlike ``add.reduce``, which may sum pairwise.
    """
    result: FloatArray = np.add.accumulate(columns * x[:, None], axis=0)[-1]
    return result


def dot(x: FloatArray, y: FloatArray) -> np.floating:
    """Scalar product, summed from the first element to the last."""
    result: np.floating = np.add.accumulate(x * y)[-1]
    return result


def total(terms: FloatArray) -> np.floating:
    """Sum from the first element to the last."""
    result: np.floating = np.add.accumulate(terms)[-1]
    return result
