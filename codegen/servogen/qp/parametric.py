"""Quadratic programs whose linear terms depend on a parameter; explicit solutions start here."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.precision import FloatArray


@dataclass(frozen=True)
class ParametricQp:
    """min over z of 1/2 z'H z + (F theta + f)'z subject to G z <= w + S theta.

    Args:
        H: (n, n) symmetric, positive definite. F: (n, p). f: (n,).
        G: (r, n), w: (r,), S: (r, p); r may be zero.
        lower, upper: (p,) a box of parameters, or None for the whole space; it bounds no z.

    Arrays are copied, float64, read-only.

    Raises:
        ValueError: shapes that do not fit, numbers that are not finite, H not positive definite.
    """

    H: FloatArray
    F: FloatArray
    f: FloatArray
    G: FloatArray
    w: FloatArray
    S: FloatArray
    lower: FloatArray | None = None
    upper: FloatArray | None = None

    def __post_init__(self) -> None:
        for name in ("H", "F", "f", "G", "w", "S", "lower", "upper"):
            value = getattr(self, name)
            if value is not None:
                array = np.array(value, dtype=np.float64)
                array.flags.writeable = False
                object.__setattr__(self, name, array)
        self._check()

    def _check(self) -> None:
        n, p, r = self.F.shape[0], self.F.shape[-1], self.w.shape[0]
        shapes = {"H": (n, n), "F": (n, p), "f": (n,), "G": (r, n), "w": (r,), "S": (r, p)}
        shapes |= {"lower": (p,), "upper": (p,)}
        for name, shape in shapes.items():
            value = getattr(self, name)
            if value is None:
                continue
            if value.shape != shape:
                raise ValueError(f"{name} is of shape {value.shape}, expected {shape}")
            if not np.all(np.isfinite(value)):
                raise ValueError(f"{name} is not finite")
        if not np.array_equal(self.H, self.H.T):
            raise ValueError("H is not symmetric")
        try:
            np.linalg.cholesky(self.H)
        except np.linalg.LinAlgError:
            raise ValueError("H is not positive definite") from None

    @property
    def variables(self) -> int:
        """n, length of z."""
        return int(self.H.shape[0])

    @property
    def parameters(self) -> int:
        """p, length of theta."""
        return int(self.F.shape[1])

    @property
    def rows(self) -> int:
        """r, number of constraints."""
        return int(self.w.size)
