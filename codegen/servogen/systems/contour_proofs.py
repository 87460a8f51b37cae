"""What the contour controller's stability rests on, held against the numbers that are emitted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.linalg

from servogen.controllers.contour_lq_design import ContourAxis, ContourLqDesign
from servogen.controllers.contour_recursion import Machine
from servogen.controllers.contour_stability import (
    FrozenSpectrum,
    frozen_spectrum,
    theorem_conditions,
)
from servogen.controllers.contour_table_design import direction_gains, state_gains
from servogen.controllers.contour_weights import Terminal
from servogen.precision import Precision
from servogen.systems.claims import Claim

# Directions over half a turn, or half a sphere, of every spectrum.
DIRECTIONS = 72
# Between the closed loop of the recursion and that of the emitted tables: float64 rounds what the
# tables' factorisations leave, float32 every gain besides.
MODULUS_TOLERANCE = {"float64": 1e-7, "float32": 1e-4}


def contour_claims(design: ContourLqDesign) -> list[Claim]:
    """Theorem 1's hypotheses where it is called upon; the spectrum on straight contours; and that
    of the gains as they are emitted."""
    plants = [axis.model.plant for axis in design.axes]
    stationary = design.terminal is Terminal.STATIONARY
    claims = [
        Claim(f"Theorem 1: {found.name}", found.holds, 0.0 if found.holds else 1.0, 0.0, 1)
        for found in theorem_conditions(plants, design.weights, design.terminal)
        if stationary or not found.name.startswith("H at the end")
    ]
    spectrum = design_spectrum(design)
    worst, _, _ = spectrum.worst(design.preview)
    claims.append(_inside(f"straight contours, {DIRECTIONS} directions: stable", worst))
    emitted = emitted_modulus(design, spectrum)
    claims.append(_inside("the same by the emitted numbers", float(np.max(emitted))))
    if design.table is None:
        off = float(np.max(np.abs(emitted - spectrum.modulus[design.preview - 1])))
        bound = MODULUS_TOLERANCE[design.precision.name]
        name = "emitted numbers have the recursion's largest modulus"
        claims.append(Claim(name, off <= bound, off, bound, len(emitted), "sample"))
    return claims


def design_spectrum(design: ContourLqDesign, previews: int | None = None) -> FrozenSpectrum:
    """For previews of one point to the design's own, or to as many as asked."""
    plants = [axis.model.plant for axis in design.axes]
    count = previews or design.preview
    return frozen_spectrum(plants, design.weights, design.terminal, count, DIRECTIONS)


def emitted_modulus(design: ContourLqDesign, spectrum: FrozenSpectrum) -> np.ndarray:
    """(M,) largest modulus on a straight contour by the tables, and the slides solved for, in the
    emitted precision."""
    rounded = in_precision(design, design.precision)
    models = [axis.model for axis in design.axes]
    machine = Machine(
        np.asarray(scipy.linalg.block_diag(*(m.a for m in models))),
        np.asarray(scipy.linalg.block_diag(*(m.b[:, None] for m in models))),
        np.asarray(scipy.linalg.block_diag(*(np.eye(m.order)[:1] for m in models))),
    )
    found = []
    for way in spectrum.directions:
        gains = _gains(rounded, way)
        closed = machine.a + machine.b @ state_gains(design, gains)
        found.append(float(np.max(np.abs(np.linalg.eigvals(closed)))))
    return np.array(found)


def in_precision(design: ContourLqDesign, precision: Precision) -> ContourLqDesign:
    """The design with its law's tables rounded as they are emitted."""

    def rounded(values: np.ndarray) -> np.ndarray:
        return values.astype(precision.dtype).astype(np.float64)

    def axis(own: ContourAxis) -> ContourAxis:
        tables = own.tables
        return replace(
            own,
            tables=replace(
                tables,
                first=rounded(tables.first),
                error=rounded(tables.error),
                slide=rounded(tables.slide),
                stiffness=rounded(tables.stiffness),
            ),
        )

    table = design.table
    return replace(
        design,
        axes=tuple(axis(own) for own in design.axes),
        table=None if table is None else replace(table, gains=rounded(table.gains)),
    )


def _gains(design: ContourLqDesign, way: np.ndarray) -> np.ndarray:
    if design.table is None:
        return direction_gains(design, way, design.precision.dtype.type)
    c, s = (way[0], way[1]) if way[0] >= 0.0 else (-way[0], -way[1])
    isotropic = direction_gains(design, np.zeros(2))
    return isotropic + design.table.gains_at(float(s / (c + abs(s))))


def _inside(name: str, modulus: float) -> Claim:
    return Claim(name, modulus < 1.0, modulus - 1.0, 0.0, DIRECTIONS, "sample")
