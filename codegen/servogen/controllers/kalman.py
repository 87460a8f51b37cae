"""The steady-state Kalman filter of the velocity form, for what the encoder does not show.

Its states are increments dx_p and the output: a constant load on the drive appears in no increment
and so needs no state of its own. The output is kept relative to the last measurement, so that no
number of the filter grows with the angle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy.linalg

from servogen.controllers.errors import DesignError
from servogen.controllers.velocity_form import VelocityForm, velocity_form
from servogen.plants.sampled import Sampled
from servogen.plants.statespace import read_only
from servogen.precision import FloatArray

# A mode this close to the unit circle decays by less than a thousandth in a million samples.
ON_THE_CIRCLE = 1e-9
# Smallest singular value, with rows and columns of unit size, at which a mode counts as seen or
# reached: 1e-4 of the sixth digit that a model's numbers are ever known to.
SEEN = 1e-10
# A solution of the Riccati equation is right to this share of itself; scipy's is to 1e-12 here.
RICCATI_RESIDUAL = 1e-6


@dataclass(frozen=True)
class Noise:
    """Standard deviations: ``disturbance`` (l,) by how much a load at the input, in its unit,
    changes from one sample to the next; ``state`` (n,) of what else moves the increments;
    ``measurement`` (m,) of the outputs, positive."""

    disturbance: FloatArray
    state: FloatArray
    measurement: FloatArray


@dataclass(frozen=True)
class FilterDesign:
    """Measurement update of the estimate by the innovation v (m,): dx += on_increment v, and the
    output's estimate, relative to the measurement, becomes (on_output - I) v.

    on_increment: (n, m); on_output: (m, m); decay: the largest magnitude of the filter's poles;
    increment_bound: (n,) the estimate exceeds it for no sequence of measurements that differ by at
    most ``step`` from one to the next and inputs that change by at most ``change``.
    """

    plant: Sampled
    on_increment: FloatArray
    on_output: FloatArray
    decay: float
    increment_bound: FloatArray


def design_filter(
    plant: Sampled, noise: Noise, step: npt.ArrayLike, change: npt.ArrayLike
) -> FilterDesign:
    """The stationary gain from scipy's Riccati solver.

    Args:
        step: (m,) largest change of a measurement in one sample; change: (l,) of an input.

    Raises:
        DesignError: a mode that does not decay and does not show in the outputs (the drive must be
            detectable), one that no noise reaches, noise that is none, or no solution.
    """
    _check_noise(plant, noise)
    form = velocity_form(plant)
    _require_detectable(plant)
    reach = np.hstack([plant.b * noise.disturbance, np.diag(noise.state)])
    reach = np.vstack([reach, plant.c @ reach])
    _require_reached(form, reach)
    gain = _gain(form, reach, noise.measurement)
    n = plant.order
    on_increment, on_output = gain[:n], gain[n:]
    closed, drive = _error_dynamics(plant, on_increment, on_output)
    decay = float(np.max(np.abs(np.linalg.eigvals(closed))))
    if not decay < 1.0 - ON_THE_CIRCLE:
        raise DesignError("measurement_noise", None, "noise for which the filter settles")
    inputs = np.concatenate([np.atleast_1d(step), np.atleast_1d(change)])
    bound = _peak(closed, drive * inputs)[:n]
    return FilterDesign(
        plant, read_only(on_increment), read_only(on_output), decay, read_only(bound)
    )


def _check_noise(plant: Sampled, noise: Noise) -> None:
    sizes = {"disturbance": plant.inputs, "state": plant.order, "measurement": plant.outputs}
    for key, size in sizes.items():
        values = getattr(noise, key)
        if values.shape != (size,) or not np.all(np.isfinite(values) & (values >= 0.0)):
            raise DesignError(f"{key}_noise", list(values), f"{size} numbers of zero or more")
    if not np.all(noise.measurement > 0.0):
        raise DesignError("measurement_noise", list(noise.measurement), "numbers above zero")


def _gain(form: VelocityForm, reach: FloatArray, measurement: FloatArray) -> FloatArray:
    """(n+m, m). Outputs are scaled to unit noise: only the ratio of the noises matters, and numbers
    near one are what the solver's own balancing expects."""
    c = form.c / measurement[:, None]
    noise = reach @ reach.T
    unit = np.eye(c.shape[0])
    try:
        with np.errstate(all="ignore"):  # its balancing of what cannot be balanced: told below
            p = scipy.linalg.solve_discrete_are(form.a.T, c.T, noise, unit)
    except (np.linalg.LinAlgError, ValueError):  # the latter where the pencil is not told apart
        raise DesignError("plant", None, "one whose Riccati equation has a solution") from None
    seen = c @ p @ c.T + unit
    gain = np.linalg.solve(seen, c @ p).T
    residual = form.a @ (p - gain @ c @ p) @ form.a.T + noise - p
    if not np.max(np.abs(residual)) <= RICCATI_RESIDUAL * np.max(np.abs(p)):
        raise DesignError("plant", None, "one whose Riccati equation can be solved accurately")
    result: FloatArray = gain / measurement
    return result


def _error_dynamics(
    plant: Sampled, on_increment: FloatArray, on_output: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The filter as it is run, (dx, y estimated less y measured) after each measurement, driven by
    the change of the measurement and the change of the input."""
    n, m = plant.order, plant.outputs
    correction = np.vstack([on_increment, on_output - np.eye(m)])
    predicted = np.hstack([plant.a, np.zeros((n, m))])
    closed = np.vstack([predicted, np.zeros((m, n + m))])
    closed -= correction @ np.hstack([plant.c @ plant.a, np.eye(m)])
    on_change = np.vstack([plant.b, np.zeros((m, plant.inputs))])
    on_change -= correction @ plant.c @ plant.b
    return closed, np.hstack([correction, on_change])


def _peak(closed: FloatArray, drive: FloatArray) -> FloatArray:
    """Sum over time of the magnitudes of the impulse responses: what bounded inputs can reach."""
    total, response = np.zeros(closed.shape[0]), drive
    scale = np.max(np.abs(drive), axis=1)
    while np.any(np.max(np.abs(response), axis=1) > 1e-12 * np.maximum(total, scale)):
        total += np.sum(np.abs(response), axis=1)
        response = closed @ response
    return total


def _require_detectable(plant: Sampled) -> None:
    for mode in _slow_modes(plant.a):
        if not _independent(plant.a, plant.c, mode):
            raise DesignError(
                "c",
                f"blind to the mode at z = {_shown(mode)}",
                "outputs that show every mode that does not decay (detectability)",
            )


def _require_reached(form: VelocityForm, reach: FloatArray) -> None:
    for mode in _slow_modes(form.a):
        if not _independent(form.a.T, reach.T, mode):
            raise DesignError(
                "disturbance_noise",
                f"absent from the mode at z = {_shown(mode)}",
                "noise that reaches every mode that does not decay",
            )


def _shown(mode: complex) -> str:
    return f"{mode:.6g}" if mode.imag else f"{mode.real:.6g}"


def _slow_modes(a: FloatArray) -> list[complex]:
    modes = np.linalg.eigvals(a)
    slow = modes[np.abs(modes) >= 1.0 - ON_THE_CIRCLE]
    return [complex(mode) for mode in np.sort_complex(slow)]


def _independent(a: FloatArray, c: FloatArray, mode: complex) -> bool:
    """Hautus: whether [mode I - a; c] has full column rank, in balanced coordinates."""
    with np.errstate(all="ignore"):  # what cannot be balanced is not, and counts as not seen
        balanced, (scale, _) = scipy.linalg.matrix_balance(a, permute=False, separate=True)
    seen = c * scale
    size = np.linalg.norm(seen, axis=1)
    seen = seen / np.where(size > 0.0, size, 1.0)[:, None]
    columns = np.vstack([mode * np.eye(a.shape[0]) - balanced, seen])
    columns = columns / np.maximum(np.linalg.norm(columns, axis=0), np.finfo(float).tiny)
    return bool(np.min(np.linalg.svd(columns, compute_uv=False)) > SEEN)
