"""Stability of the contour controller: what Theorem 1 asks for, and the spectrum of (17) itself.

On a straight contour the law is time-invariant. Theorem 1 says that H_s(Q_max) at the end makes it
stable for every direction and preview; nothing says so of C'QC, whose spectrum has to be looked at.
On a curve the spectrum is that of the time frozen, which proves nothing: the paper's conjecture.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg

from servogen.controllers.contour_recursion import Machine, end_weight
from servogen.controllers.contour_weights import ContourWeights, Terminal
from servogen.plants.statespace import Discrete
from servogen.precision import FloatArray

# A largest modulus from which on a terminal choice without guarantee is told of: what is off the
# contour takes a thousand samples to come down by e there.
NEAR_THE_CIRCLE = 0.999
# Smallest singular value of [z I - A; c] in balanced coordinates with rows and columns of unit size
# at which the mode at z counts as seen: see ``kalman.SEEN``.
SEEN = 1e-10


@dataclass(frozen=True)
class Condition:
    """One hypothesis of Theorem 1, whether it holds, and what was looked at."""

    name: str
    holds: bool
    found: str


def theorem_conditions(
    axes: Sequence[Discrete], weights: ContourWeights, terminal: Terminal
) -> tuple[Condition, ...]:
    """The four hypotheses. With alpha above zero Q^(1/2) has full rank at every angle: [A, C] is
    what has to be detectable, axis by axis; and Q_max is never less than Q."""
    reach = [_blind(axis.a.T, axis.b) for axis in axes]
    sight = [_blind(axis.a, axis.c) for axis in axes]
    stationary = terminal is Terminal.STATIONARY
    return (
        Condition("[A, B] is stabilisable", not any(reach), _shown(reach)),
        Condition("[A, Q^(1/2) C] is detectable at every angle", not any(sight), _shown(sight)),
        Condition(
            "R > 0, Q >= 0",
            weights.control > 0.0 and weights.tracking > 0.0,
            f"rho = {weights.control:g}, least eigenvalue of Q = {weights.tracking:g}",
        ),
        Condition(
            "H at the end is H_s(Q_max), Q_max >= Q at every angle",
            stationary,
            f"Q_max = {weights.largest:g} I" if stationary else "C'QC: nothing is proven",
        ),
    )


def theorem_holds(axes: Sequence[Discrete], weights: ContourWeights, terminal: Terminal) -> bool:
    """Whether Theorem 1 applies."""
    return all(condition.holds for condition in theorem_conditions(axes, weights, terminal))


def _blind(a: FloatArray, c: FloatArray) -> tuple[complex, ...]:
    """Modes that do not decay and that c does not show (Hautus)."""
    balanced, (scale, _) = scipy.linalg.matrix_balance(a, permute=False, separate=True)
    seen = c * scale
    size = float(np.linalg.norm(seen))
    seen = seen / size if size > 0.0 else seen
    blind = []
    for mode in np.sort_complex(np.linalg.eigvals(a)):
        if abs(mode) < 1.0:
            continue
        columns = np.vstack([mode * np.eye(len(a)) - balanced, seen[None, :]])
        columns = columns / np.maximum(np.linalg.norm(columns, axis=0), np.finfo(float).tiny)
        if not np.min(np.linalg.svd(columns, compute_uv=False)) > SEEN:
            blind.append(complex(mode))
    return tuple(blind)


def _shown(blind: Sequence[tuple[complex, ...]]) -> str:
    told = [f"axis {i}: not at z = {mode:.6g}" for i, modes in enumerate(blind) for mode in modes]
    return "; ".join(told) or "every mode that does not decay"


def directions(axes: int, count: int) -> FloatArray:
    """(count, p) of length one over half a turn, or over half a sphere: r and -r are one line."""
    if axes == 2:
        angle = np.arange(count) * (np.pi / count)
        return np.column_stack([np.cos(angle), np.sin(angle)])
    height = (np.arange(count) + 0.5) / count
    angle = np.arange(count) * np.pi * (3.0 - np.sqrt(5.0))
    flat = np.sqrt(1.0 - height**2)
    return np.column_stack([flat * np.cos(angle), flat * np.sin(angle), height])


@dataclass(frozen=True)
class FrozenSpectrum:
    """Largest modulus of the eigenvalues of (17), on straight contours.

    directions: (M, p). modulus: (K, M) for previews of 1 to K points.
    """

    terminal: Terminal
    directions: FloatArray
    modulus: FloatArray

    def worst(self, preview: int | None = None) -> tuple[float, int, int]:
        """The largest modulus, its preview and the index of its direction; of one preview if
        given."""
        rows = self.modulus if preview is None else self.modulus[preview - 1 : preview]
        row, at = np.unravel_index(int(np.argmax(rows)), rows.shape)
        return float(rows[row, at]), int(row) + 1 if preview is None else preview, int(at)

    def warning(self, preview: int) -> str:
        """One sentence that names the direction where the choice of this preview comes near the
        unit circle without Theorem 1 to keep it inside, or outside whatever the theorem says;
        empty where it does not."""
        modulus, _, at = self.worst(preview)
        guaranteed = self.terminal is Terminal.STATIONARY
        if modulus < (1.0 if guaranteed else NEAR_THE_CIRCLE):
            return ""
        beyond = "outside" if modulus >= 1.0 else "near"
        told = (
            f"the closed loop is {beyond} the unit circle on a straight contour at "
            f"{direction_text(self.directions[at])}: modulus {modulus:.6f} with {preview} points "
            "of preview"
        )
        if guaranteed:
            return f"{told}, though H_s(Q_max) is at the end: weights that rounding does not carry"
        return f"without a guarantee, {told}; H_s(Q_max) at the end is stable at every angle"

    def unstable(self, preview: int) -> bool:
        """Whether a mode on some straight contour grows."""
        return self.worst(preview)[0] >= 1.0


def direction_text(direction: FloatArray) -> str:
    """An angle in the plane, a vector in space."""
    if direction.size == 2:
        return f"{np.degrees(np.arctan2(direction[1], direction[0])):.4g} degrees"
    return "(" + ", ".join(f"{value:.3f}" for value in direction) + ")"


def frozen_spectrum(
    axes: Sequence[Discrete],
    weights: ContourWeights,
    terminal: Terminal,
    previews: int,
    count: int = 36,
) -> FrozenSpectrum:
    """For previews of 1 to ``previews`` points and ``count`` directions.

    On a straight contour H depends only on how far the end is: one pass backwards gives all
    previews, all directions at a time.

    Raises:
        DesignError: an axis without H_s, if that is the choice.
    """
    machine, ways = Machine.of(axes), directions(len(axes), count)
    q = np.array([weights.output_weight(way) for way in ways])
    seen = np.einsum("ai,mab,bj->mij", machine.c, q, machine.c)
    h = np.array([end_weight(axes, weights, terminal, one) for one in q[:1]])
    h = np.repeat(h, count, axis=0) if terminal is Terminal.STATIONARY else seen.copy()
    price = weights.control * np.eye(len(axes))
    moduli = []
    for _ in range(previews):
        driven = np.swapaxes(h @ machine.b, 1, 2)
        k = np.linalg.solve(driven @ machine.b + price, driven @ machine.a)
        closed = machine.a - machine.b @ k
        moduli.append(np.max(np.abs(np.linalg.eigvals(closed)), axis=1))
        h = machine.a.T @ h @ closed + seen
        h = 0.5 * (h + np.swapaxes(h, 1, 2))
    return FrozenSpectrum(terminal, ways, np.array(moduli))
