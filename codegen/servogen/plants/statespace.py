"""Continuous and discrete state spaces with one input, and the exact way from one to the other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy.linalg
import scipy.optimize

from servogen.plants.errors import PlantError

FloatArray = npt.NDArray[np.float64]

# A pole closer to the imaginary axis than this share of the largest pole counts as not stable: a
# double integrator's poles come out of the eigenvalue solver at about sqrt(2.2e-16) = 1.5e-8.
STABILITY_MARGIN = 1e-7


def read_only(values: npt.ArrayLike) -> FloatArray:
    """A float64 copy of ``values`` that nobody can write to."""
    array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array


def _check_shapes(a: FloatArray, b: FloatArray, c: FloatArray) -> None:
    if a.ndim != 2 or a.shape[0] != a.shape[1] or a.shape[0] == 0:
        raise PlantError("a", f"of shape {a.shape}", "a square matrix")
    n = a.shape[0]
    for name, vector in (("b", b), ("c", c)):
        if vector.shape != (n,):
            raise PlantError(name, f"of shape {vector.shape}", f"{n} numbers, one per state")
    for name, array in (("a", a), ("b", b), ("c", c)):
        if not np.all(np.isfinite(array)):
            raise PlantError(name, "not finite", "finite numbers")


@dataclass(frozen=True)
class StateSpace:
    """Continuous time: dx/dt = a x + b u, y = c x; u is the position command and y the position, m.

    Args:
        a: (n, n), b: (n,), c: (n,). Copied, float64, read-only.

    Raises:
        PlantError: shapes that do not fit, or numbers that are not finite.
    """

    a: FloatArray
    b: FloatArray
    c: FloatArray

    def __post_init__(self) -> None:
        for name in ("a", "b", "c"):
            object.__setattr__(self, name, read_only(getattr(self, name)))
        _check_shapes(self.a, self.b, self.c)

    @property
    def order(self) -> int:
        """Number of states."""
        return int(self.a.shape[0])

    @property
    def poles(self) -> npt.NDArray[np.complex128]:
        """(n,) eigenvalues of a, rad/s, sorted by real part, then imaginary part."""
        return np.sort_complex(np.linalg.eigvals(self.a)).astype(np.complex128)

    @property
    def is_stable(self) -> bool:
        """Whether every pole lies to the left of the imaginary axis (Hurwitz), with a margin."""
        poles = self.poles
        return bool(np.max(poles.real) < -STABILITY_MARGIN * np.max(np.abs(poles)))

    @property
    def dc_gain(self) -> float:
        """-c a^-1 b: the position reached per metre of constant command; inf for an integrator."""
        try:
            return float(-self.c @ np.linalg.solve(self.a, self.b))
        except np.linalg.LinAlgError:
            return float("inf")

    @property
    def bandwidth_3db(self) -> float:
        """Lowest frequency at which the gain is 1/sqrt(2) of the dc gain, rad/s; inf if none is."""
        poles = np.abs(self.poles)
        level = abs(self.dc_gain) / float(np.sqrt(2.0))

        def excess(log_frequency: float) -> float:
            return float(abs(self.response(float(np.exp(log_frequency)))) - level)

        grid = np.linspace(np.log(1e-3 * poles.min()), np.log(1e3 * poles.max()), 2000)
        values = np.array([excess(point) for point in grid])
        below = np.flatnonzero(values < 0.0)
        if below.size == 0 or below[0] == 0:
            return float("inf") if below.size == 0 else 0.0
        i = int(below[0])
        return float(np.exp(scipy.optimize.brentq(excess, grid[i - 1], grid[i], xtol=1e-14)))

    def response(self, frequency_rad_per_s: float) -> complex:
        """Frequency response c (j w I - a)^-1 b."""
        shifted = 1j * frequency_rad_per_s * np.eye(self.order) - self.a
        return complex(self.c @ np.linalg.solve(shifted, self.b))


@dataclass(frozen=True)
class Discrete:
    """Sampled: x(t + T) = a x(t) + b u(t), y = c x, u held over T = ``sample_time_s``.

    Shapes as for ``StateSpace``. Raises ``PlantError`` likewise.
    """

    a: FloatArray
    b: FloatArray
    c: FloatArray
    sample_time_s: float

    def __post_init__(self) -> None:
        for name in ("a", "b", "c"):
            object.__setattr__(self, name, read_only(getattr(self, name)))
        _check_shapes(self.a, self.b, self.c)
        if not (np.isfinite(self.sample_time_s) and self.sample_time_s > 0.0):
            raise PlantError("sample_time_s", self.sample_time_s, "a positive number of seconds")

    @property
    def order(self) -> int:
        """Number of states."""
        return int(self.a.shape[0])


def discretise(sys: StateSpace, sample_time_s: float) -> Discrete:
    """Exact zero-order hold: exp([[a, b], [0, 0]] T) holds both matrices of the sampled model.

    Position, velocity and acceleration of a fast stage differ by seven powers of ten; the states
    and the input are first scaled by powers of two (which rounds nothing) so that the squarings
    inside ``expm`` lose no digits to that.
    """
    if not (np.isfinite(sample_time_s) and sample_time_s > 0.0):
        raise PlantError("sample_time_s", sample_time_s, "a positive number of seconds")
    n = sys.order
    balanced, (scale, _) = scipy.linalg.matrix_balance(sys.a, permute=False, separate=True)
    b = sys.b / scale
    largest_b, largest_a = float(np.max(np.abs(b))), float(np.max(np.abs(balanced)))
    ratio = largest_a / largest_b if largest_a > 0.0 and largest_b > 0.0 else 1.0
    input_scale = 2.0 ** round(float(np.log2(ratio)))
    augmented = np.zeros((n + 1, n + 1))
    augmented[:n, :n] = balanced
    augmented[:n, n] = b * input_scale
    held = scipy.linalg.expm(augmented * sample_time_s)
    a_d = held[:n, :n] * scale[:, None] / scale[None, :]
    b_d = held[:n, n] * scale / input_scale
    return Discrete(a_d, b_d, sys.c, float(sample_time_s))
