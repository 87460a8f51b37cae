"""Lookups of every form on small programs, and their compiled packages, each made once."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from shared_builds import compiled_once

from servogen.controllers.lookup_design import LookupDesign, declare_lookup, design_lookup
from servogen.emit.package import CPackage, emit_package
from servogen.explicit.choose import Choice, Form, choose
from servogen.explicit.clips import recursive_clips, without_first_bounds
from servogen.explicit.explore import solve
from servogen.explicit.grow import grow_tree
from servogen.explicit.lookup import count_clips, tree_lookup
from servogen.explicit.pieces import arrange
from servogen.explicit.turned import turned
from servogen.precision import PRECISIONS
from servogen.qp.parametric import ParametricQP, parametric_qp

sys.path.insert(0, str(Path(__file__).parents[1] / "explicit"))

from explicit_problems import (
    double_integrator,
    regulator_2002,
    servo_drive,
    toolbox_double_integrator,
    transport,
)

PERIOD = 500e-6


@dataclass(frozen=True)
class Case:
    """A program and the form of its lookup, by the beginning of the form's name."""

    prefix: str
    program: str
    form: str


CASES = {
    case.prefix: case
    for case in (
        Case("chosen", "drive", "chosen"),
        Case("clips", "drive", "recursive clips"),
        Case("cliptree", "drive", "clip tree"),
        Case("mirrored", "drive", "clip tree, odd in eta_2"),
        Case("turned", "drive", "clip tree, odd across hyperplane 4"),
        Case("lawtree", "drive", "law tree"),
        Case("oddlaws", "drive", "law tree, odd in eta_1"),
        Case("leaf", "one move", "clip tree"),
        Case("double", "double integrator", "clip tree"),
        Case("doublelaws", "double integrator", "law tree"),
        Case("two", "two moves", "law tree"),
        Case("lopsided", "lopsided", "recursive clips"),
        Case("onesided", "one-sided", "law tree"),
        Case("paper", "example of 2002", "clip tree"),
        Case("transport", "transport", "law tree"),
        Case("toolbox", "toolbox", "law tree"),
    )
}


@cache
def program(name: str) -> ParametricQP:
    eye = np.eye(2)
    match name:
        case "drive":
            return servo_drive(3)
        case "one move":
            return servo_drive(1, 1)
        case "double integrator":
            return double_integrator(5)
        case "example of 2002":
            return regulator_2002()
        case "transport":
            return transport()
        case "toolbox":
            return toolbox_double_integrator()
        case "two moves":
            qp = regulator_2002()
            return parametric_qp(
                qp.hessian, qp.linear, lower=qp.lower, upper=qp.upper, first_move=2
            )
        case "lopsided":  # bounds whose middle no float32 holds
            return parametric_qp(
                [[2.0, 0.3], [0.3, 1.0]], eye, constant=[0.1, -0.2], lower=[-0.1, -0.7],
                upper=[1.3, 0.9],
            )  # fmt: skip
        case "one-sided":  # no bound below: no range of the move is known
            return parametric_qp([[2.0, 0.3], [0.3, 1.0]], eye, upper=[1.0, 0.5])
    raise KeyError(name)


@cache
def choice(name: str) -> Choice:
    return choose(program(name), 500, 20)


def form_of(name: str, wanted: str) -> Form:
    """The form, even where ``choose`` saw that it could not win and left it out."""
    if wanted == "chosen":
        return choice(name).chosen
    problem, clip = program(name), None
    if wanted == "recursive clips":
        clips = recursive_clips(problem)
        return Form(wanted, clips, count_clips(clips), "")
    if wanted.startswith("clip"):
        problem, clip = without_first_bounds(problem)
    solution = solve(problem, 500)
    mirror = int(wanted.partition("eta_")[2] or -1)
    if across := wanted.partition("hyperplane ")[2]:
        normal = arrange(solution).planes[int(across), :-1]
        solution, mirror = turned(solution, normal / np.linalg.norm(normal))
    lookup = tree_lookup(solution, grow_tree(solution, 20, mirror), clip)
    return Form(wanted, lookup, lookup.count, "", solution)


@cache
def design(prefix: str, precision: str = "float64") -> LookupDesign:
    case = CASES[prefix]
    short = "d" if precision == "float64" else "f"
    return design_lookup(
        f"{prefix}_{short}", PRECISIONS[precision], program(case.program), choice(case.program),
        PERIOD, 500, form=form_of(case.program, case.form),
    )  # fmt: skip


@cache
def package(precision: str) -> CPackage:
    declarations = tuple(declare_lookup(design(prefix, precision)) for prefix in CASES)
    return emit_package(f"looks{'d' if precision == 'float64' else 'f'}", declarations)


@cache
def compiled() -> Any:
    return compiled_once([package("float64"), package("float32")], ["-O1"])
