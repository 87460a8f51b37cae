"""Auxiliary dynamics (2) of paper 4: sequences by which a command may differ from where it ends.

v(k) = c A^k x + rho. With a shift register any n values may come before rho; with Laguerre
sequences the n orthonormal ones of a pole, which decay for ever and look further ahead with fewer
variables; with no auxiliary state v is rho at once, and the scheme is the command governor.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.plants.statespace import FloatArray, read_only
from servogen.sets.errors import SetError

# An eigenvalue of P - A'PA that rounding has pushed below zero, as a share of P's largest one.
LYAPUNOV_TOLERANCE = 1e-12


@dataclass(frozen=True)
class AuxiliaryDynamics:
    """x(k+1) = a x(k), v(k) = c x(k) + rho, once in a slow period (2).

    Args:
        a: (n, n), every eigenvalue inside the unit circle. c: (n,). Copied, read-only. n may be 0.
        name: for people.
        settled: periods after which c A^k is zero to the last bit; None: it never is.

    Raises:
        SetError: shapes that do not fit, or an eigenvalue on or outside the unit circle.
    """

    a: FloatArray
    c: FloatArray
    name: str
    settled: int | None = None

    def __post_init__(self) -> None:
        for name in ("a", "c"):
            object.__setattr__(self, name, read_only(getattr(self, name)))
        n = self.c.size
        if self.a.shape != (n, n) or self.c.ndim != 1:
            raise SetError("auxiliary dynamics", f"of shape {self.a.shape}", f"({n}, {n})")
        if n and not np.max(np.abs(np.linalg.eigvals(self.a))) < 1.0:
            raise SetError("auxiliary dynamics", "not stable", "eigenvalues inside the unit circle")

    @property
    def order(self) -> int:
        """n, auxiliary states."""
        return int(self.c.size)

    def outputs(self, periods: int) -> FloatArray:
        """(periods, n): c A^k, what the state adds to the command of period k."""
        rows = np.zeros((periods, self.order))
        row = self.c.copy()
        for k in range(periods):
            rows[k] = row
            row = row @ self.a
        return rows

    def never_grows(self, weight: FloatArray) -> bool:
        """Whether x'Px, P = ``weight`` (n, n), is positive definite and falls or stays with every
        period: what the convergence (c) of an extended governor with this weight rests on."""
        if self.order == 0:
            return True
        values = np.linalg.eigvalsh(0.5 * (weight + weight.T))
        fall = np.linalg.eigvalsh(weight - self.a.T @ weight @ self.a)
        return bool(values[0] > 0.0 and fall[0] >= -LYAPUNOV_TOLERANCE * values[-1])


def shift_register(periods: int) -> AuxiliaryDynamics:
    """Any command in each of the next ``periods`` slow periods, rho after them (13).

    Raises:
        SetError: less than one period.
    """
    if periods < 1:
        raise SetError("periods", periods, "at least one; none is the command governor")
    return AuxiliaryDynamics(
        np.eye(periods, k=1), np.eye(periods)[0], f"shift register of {periods}", periods
    )


def laguerre(order: int, pole: float) -> AuxiliaryDynamics:
    """The first ``order`` Laguerre sequences of a pole, orthonormal: sum v(k)^2 = x'x.

    a holds the pole on its diagonal and beta (-pole)^(j-i-1) above it, beta = 1 - pole^2;
    c = sqrt(beta) (1, -pole, pole^2, ...). Pole 0 is the shift register.

    Raises:
        SetError: no sequence, or a pole outside 0 <= pole < 1.
    """
    if order < 1:
        raise SetError("order", order, "at least one sequence")
    if not 0.0 <= pole < 1.0:
        raise SetError("pole", pole, "at least 0 and below 1")
    beta = 1.0 - pole**2
    powers = (-pole) ** np.arange(order)
    a = pole * np.eye(order)
    for d in range(1, order):
        a += beta * powers[d - 1] * np.eye(order, k=d)
    name = f"{order} Laguerre sequences of pole {pole:g}"
    return AuxiliaryDynamics(a, np.sqrt(beta) * powers, name, order if pole == 0.0 else None)


def no_auxiliary() -> AuxiliaryDynamics:
    """v = rho at once and for ever: the command governor."""
    return AuxiliaryDynamics(np.zeros((0, 0)), np.zeros(0), "no auxiliary state", 0)
