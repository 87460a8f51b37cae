"""Small cascades for the tests of the core, and their compiled packages, each made once."""

from __future__ import annotations

import atexit
import shutil
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from shared_builds import compiled_once

from servogen.controllers.cascade_design import CascadeDesign, declare_parts
from servogen.controllers.fast_design import FastDesign, compensation
from servogen.controllers.governor_design import GovernorDesign, axis_section
from servogen.controllers.mpc_design import MpcDesign, SolverSettings, design_mpc
from servogen.emit.package import CPackage, emit_package
from servogen.plants.motion import to_motion_states
from servogen.plants.servo import servo
from servogen.plants.statespace import StateSpace, discretise
from servogen.precision import PRECISIONS
from servogen.qp.condense import TrackingWeights
from servogen.qp.tolerances import MINIMUM_MARGIN
from servogen.sets.admissible import AdmissibleSet, maximal_admissible_set
from servogen.sets.constraints import AxisLimits

LIMITS = AxisLimits(0.4, 0.7, 14.71, 0.035)
OTHER_LIMITS = AxisLimits(0.3, 0.6, 12.0, 0.03)
CALIBRATIONS = {
    "B": TrackingWeights(0.003, 0.1, 1.0, 0.001),
    "H": TrackingWeights(0.3, 0.3, 1.0, 0.01),
    "L": TrackingWeights(0.001, 2.0, 1.0, 0.01),
}
FAST = servo(2250.0, 0.7)


@dataclass(frozen=True)
class Variant:
    """What may differ between the cascades under test; every field has the example's value."""

    prefix: str = "core"
    horizon: int = 20
    precision: str = "float64"
    cap: int = 500
    period: int = 6
    gap: float = 1e-4
    letter: str = "B"
    points: int = 150
    ramp: int = 50
    both_ends: bool = True
    matching: bool = True
    inter: int = 0
    order: int = 3
    differing: bool = False
    bandwidth: float = 45.0
    method: str = "pqp"


# One of every shape that the templates can take.
VARIANTS = {
    "example": Variant(),
    "float32": Variant(precision="float32", horizon=5),
    "governor alone": Variant(horizon=0),
    "governor alone, float32": Variant(horizon=0, precision="float32", order=4),
    "N = 1": Variant(horizon=1, cap=1),
    "N = 3, as printed": Variant(horizon=3, both_ends=False, ramp=0, inter=1),
    "axes differ": Variant(horizon=3, differing=True, precision="float32"),
    "fourth order": Variant(horizon=3, order=4),
    "plain PQP": Variant(horizon=3, period=0),
    "no extrapolation": Variant(horizon=3, period=2),
    "M = 2": Variant(horizon=2, points=2, ramp=0),
    "no terminal rows": Variant(horizon=2, bandwidth=200.0),
    "no matching": Variant(horizon=2, matching=False),
}


def slow_stage(order: int = 3, bandwidth: float = 45.0) -> StateSpace:
    """The servo; above order 3 with further lags of unit gain behind it."""
    stage = servo(bandwidth, 0.7)
    if order == 3:
        return stage
    a, b, c = stage.a, stage.b, stage.c
    for i in range(order - 3):
        pole = bandwidth * (6.0 + i)
        n = b.size
        # the lag filters the command: w / (s + w) in front of the stage
        a = np.block([[a, b[:, None]], [np.zeros((1, n)), np.array([[-pole]])]])
        b = np.append(np.zeros(n), pole)
        c = np.append(c, 0.0)
    return to_motion_states(StateSpace(a, b, c))


@cache
def admissible(order: int, bandwidth: float, limits: AxisLimits, inter: int) -> AdmissibleSet:
    return maximal_admissible_set(slow_stage(order, bandwidth), 0.03, limits, 0.01, inter)


def _axes(v: Variant) -> list[tuple[float, AxisLimits]]:
    return [(v.bandwidth, LIMITS), (38.0, OTHER_LIMITS) if v.differing else (v.bandwidth, LIMITS)]


@cache
def design(v: Variant) -> CascadeDesign:
    """The cascade of a variant; T_s = 30 ms, T_f = T_s / M."""
    precision = PRECISIONS[v.precision]
    axes = _axes(v)
    slow = [slow_stage(v.order, bandwidth) for bandwidth, _ in axes]
    sets = [admissible(v.order, bandwidth, limits, v.inter) for bandwidth, limits in axes]
    limits = (axes[0][1], axes[1][1])
    margin = max(1e-6, MINIMUM_MARGIN[v.precision])
    settings = SolverSettings(v.cap, 0.1, v.period, v.gap, 1e-6, v.method)
    mpcs: list[MpcDesign] = []
    for i, name in enumerate(("mpc_x", "mpc_y") if v.differing else ("mpc",)):
        mpcs.append(
            design_mpc(
                f"{v.prefix}_{name}", precision, slow[i], 0.03, max(v.horizon, 1),
                CALIBRATIONS[v.letter], limits[i], sets[i], settings, v.inter,
            )
        )  # fmt: skip
    fast_period = 0.03 / v.points
    plants = [discretise(s, 0.03) for s in slow]
    return CascadeDesign(
        prefix=v.prefix,
        governor=GovernorDesign(
            f"{v.prefix}_governor", precision, v.points, v.order, v.both_ends, 2.0 * margin, 0.03,
            limits, (axis_section(sets[0], plants[0]), axis_section(sets[1], plants[1])),
        ),
        mpc=(mpcs[0], mpcs[-1]) if v.horizon else None,
        fast=FastDesign(
            f"{v.prefix}_follower", precision, v.points, max(v.horizon, 1), v.ramp, v.order,
            fast_period, limits,
            (
                compensation(slow[0], FAST, fast_period, v.matching),
                compensation(slow[1], FAST, fast_period, v.matching),
            ),
        ),
        plants=(plants[0], plants[1]),
    )  # fmt: skip


@cache
def package(v: Variant) -> CPackage:
    return emit_package(v.prefix, declare_parts(design(v)))


def temporary_folder(name: str) -> Path:
    """A folder that lives as long as the tests do."""
    folder = Path(tempfile.mkdtemp(prefix=f"servogen-test-{name}-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


@cache
def compiled(*variants: Variant, quick: bool = False) -> Any:
    """The extension module with the packages of all variants; prefixes must differ.

    ``quick`` compiles with -O0, in a third of the time: the bits are the same by construction.
    """
    return compiled_once([package(v) for v in variants], ["-O0"] if quick else [])
