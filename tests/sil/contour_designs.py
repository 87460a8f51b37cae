"""Contour controllers of every form and their compiled packages, each made once."""

from __future__ import annotations

import sys
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from shared_builds import compiled_once

from servogen.controllers.contour_lq_declaration import declare_contour_lq
from servogen.controllers.contour_lq_design import ContourLqDesign
from servogen.controllers.contour_table_design import tabulate
from servogen.emit.package import CPackage, emit_package
from servogen.plants.machining_centre import machining_centre
from servogen.plants.statespace import Discrete
from servogen.precision import FLOAT32, PRECISIONS, Precision
from servogen.sil.compiled import CompiledController

sys.path.insert(0, str(Path(__file__).parents[1] / "controllers"))

import numpy as np
from contour_machine import CASES, OUTPUT, STATIONARY, design, of_case

PLAIN = Discrete(np.array([[1.0]]), np.array([1.1e-5]), np.array([1.0]), 0.0005)
AXES = machining_centre()
X, Y = AXES


def _case(name: str) -> tuple[str, Precision]:
    """Case and precision: ``II 32``."""
    case, _, bits = name.partition(" ")
    return case, PRECISIONS[f"float{bits}"]


@cache
def made(name: str) -> ContourLqDesign:
    """One of the designs under test by its name."""
    if name.partition(" ")[0] in CASES:
        found: ContourLqDesign = of_case(*_case(name))
    else:
        found = _others()[name]
    prefix = "".join(c for c in name.lower() if c.isalnum())
    return replace(found, prefix=f"c{prefix}")


@cache
def _others() -> dict[str, ContourLqDesign]:
    return {
        "space": design(1.2, 20.0, OUTPUT, axes=(X, Y, PLAIN)),
        "space of one order, float32": design(
            0.25, 15.0, STATIONARY, preview=4, precision=FLOAT32, axes=(PLAIN, PLAIN, PLAIN)
        ),
        "one slide": design(1.2, 20.0, OUTPUT, preview=1, axes=(PLAIN, X)),
        "one slide before the end": design(0.25, 15.0, STATIONARY, preview=2),
        "forty slides": design(1.2, 20.0, OUTPUT, preview=40),
        "forty points": design(0.25, 15.0, STATIONARY, preview=40),
        "hardly any tracking, float32": design(3e-4, 50.0, OUTPUT, precision=FLOAT32),
        "table": tabulate(of_case("II"), 64, 4),
        "table, float32": tabulate(of_case("IV", FLOAT32), 16, 3),
        "table at the end": tabulate(of_case("IV"), 4, 10),
    }


NAMES = (*(f"{case} {bits}" for case in CASES for bits in (64, 32)), *_others())


@cache
def small(form: str) -> ContourLqDesign:
    """Four points ahead, in a form."""
    sliding: ContourLqDesign = design(1.2, 20.0, OUTPUT, preview=4)
    forms = {
        "sliding": sliding,
        "standing": design(0.25, 15.0, STATIONARY, preview=4),
        "tabulated": tabulate(sliding, 8, 2),
    }
    return forms[form]


def package(name: str) -> CPackage:
    own = made(name)
    return emit_package(own.prefix, (declare_contour_lq(own),))


@cache
def module() -> Any:
    return compiled_once([package(name) for name in NAMES], ["-O0"])


def in_c(name: str) -> CompiledController:
    return CompiledController(module(), declare_contour_lq(made(name)))
