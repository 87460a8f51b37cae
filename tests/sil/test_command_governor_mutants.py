"""Mutants of the extended command governor's C, each found by the same calls."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from core_designs import temporary_folder
from governor_designs import Shape, alike, governor, standing_calls, swap

from servogen.controllers.command_governor import CommandGovernor
from servogen.controllers.command_governor_declaration import (
    declare_axis_governor,
    declare_command_governor,
)
from servogen.controllers.command_governor_design import CommandGovernorDesign
from servogen.emit.package import emit_package
from servogen.sil.build import compile_package
from servogen.sil.command_governor_calls import command_governor_calls
from servogen.sil.compiled import CompiledController
from servogen.sil.edges import edge_calls
from servogen.sil.harness import Call, compare

# One worker: the mutants are one module.
pytestmark = pytest.mark.xdist_group("governor mutants")
MUTANTS: dict[str, Callable[[str], str]] = {
    "the next sample of the other axis": swap("= told_y.velocity;", "= told_x.velocity;"),
    "the first point": swap(
        "(at == 0) ? last : points[at - 1]", "points[(at == 0) ? 0 : (at - 1)]"
    ),
    "beyond n_points it is read": swap("if (i >= count) {", "if (i >= CORE_WINDOW) {"),
    "one point is not looked at": swap("if (i >= count) {", "if (i >= (count - 1)) {"),
    "infinite is out of range": swap("if (here == SG_NOT_FINITE) {", "if (here == SG_OK) {"),
    "slow points are not looked at": swap(
        "core_check(in->n_points, in->slow_x, core_limit_x)", "SG_OK"
    ),
    "the first interval's points": swap(
        "const int32_t begin = core_index(self, i);\n        const",
        "const int32_t begin = core_index(self, next);\n        const",
    ),
    "greatest of the others alone": swap("ask->low[i] = greatest", "ask->low[i] = least"),
    "the point after those machined": swap(
        "const int32_t ahead = end;", "const int32_t ahead = begin;"
    ),
    "the end of the path": swap("(ahead < seen->count) ? (ahead + 1) : ahead", "ahead"),
    "taken where it waits": swap("taken = 0; /*", "/*"),
    "a plan that failed is kept": swap("core_forget(self);\n        self->lost", "self->lost"),
    "the tool waits for ever": swap("self->lost = 1;", ""),
    "it waits although they are back": swap("1 - core_back(self, in)", "1"),
    "back at once": swap("1 - core_back(self, in)", "0"),
    "back in y is enough": swap("box.least_x = self->least_x[i];", "box.least_x = self->last_x;"),
    "back in the first interval": swap("back = 0;", "back = (i == 0) ? 0 : back;"),
    "the stroke holds on the way back": swap("sg_fill(CORE_INTERVALS, -far, ask->low);", ""),
    "the way back leads to the next point": swap(
        "sg_fill(CORE_VARIABLES, self->home_x, ask->reference);", ""
    ),
    "the way back leads to another axis": swap("in->slow_y, taken)", "in->slow_x, taken)"),
    "the way back is no plan": swap("status = sg_worse(status, SG_INFEASIBLE);", ""),
    "the way back leads to the tool": swap(
        "core_at(self->home_x, in->slow_x", "core_at(self->home_x, in->points_x"
    ),
    "back in the last interval is enough": swap(
        "back = 0;", "back = (i < (CORE_INTERVALS - 1)) ? back : 0;"
    ),
    "lost outlives a reset": swap(
        "self->lost = 0;\n    self->ready = (status", "self->ready = (status"
    ),
    "points that are no use": swap("(status == SG_OK) ? sg_bound_count", "1 ? sg_bound_count"),
    "the model goes before the measurement": swap(
        "(status == SG_OK) ? in->y_velocity", "(status != SG_OK) ? in->y_velocity"
    ),
    "one axis' model": swap(": self->y.predicted[0]", ": self->x.predicted[0]"),
    "what is no use is told of one axis": swap("out->status_y = (int32_t)status;\n        }", "}"),
    "standing in x is enough": swap(
        "*standing = 0;\n    }\n    return status;", "*standing = 1;\n    }\n    return status;"
    ),
    "nobody ever stands": swap("int32_t standing = 1;", "int32_t standing = 0;"),
    "never finished": swap("told = SG_FINISHED;", "told = SG_OK;"),
    "always finished": swap("(count == 0)", "(count >= 0)"),
    "at rest for good is no answer": swap("(status < SG_BACKUP)", "(status == SG_OK)"),
    "y decides nothing": swap(
        "status = sg_worse(status, core_govern_y(self, in, seen, out, &standing));",
        "(void)core_govern_y(self, in, seen, out, &standing);",
    ),
    "the tool's place": swap("in->points_y, taken);", "in->points_x, taken);"),
    "one axis is ready": swap("status = sg_worse(status, status_x);", ""),
    "planned beyond the window": swap(
        "? self->planned[i] : seen->count;", "? self->planned[i] : self->planned[i];"
    ),
}


# A small cap and weights with which stages at rest stay at it
BASE = Shape("whole", cap=3, reference=100.0)


def renamed(number: int) -> CommandGovernorDesign:
    """All on the same axis."""
    return replace(alike(governor(BASE)), prefix=f"mutant{number}")


@cache
def mutants() -> Any:
    """One package with a governor for each."""
    own = [renamed(number) for number in range(len(MUTANTS) + 1)]
    axis = declare_axis_governor(own[0].axes[0])
    made = emit_package("mutants", (axis, *(declare_command_governor(design) for design in own)))
    files = dict(made.files)
    for design, change in zip(own, MUTANTS.values(), strict=False):
        p = design.prefix
        text = files[f"{p}.c"].replace(f"{p}_", "core_").replace(f"{p.upper()}_", "CORE_")
        text = change(text).replace("CORE_", f"{p.upper()}_")
        files[f"{p}.c"] = text.replace("core_", f"{p}_")
    folder = temporary_folder("governor-mutants")
    return compile_package([replace(made, files=files)], folder, ["-O0", "-Wno-error", "-w"])


@cache
def calls() -> list[Call]:
    design = renamed(0)
    some = list(command_governor_calls(design, np.random.default_rng(8), 600))
    # measurements that fail in the middle of a motion
    some += command_governor_calls(design, np.random.default_rng(9), 400, bad=0.3)
    some += standing_calls(design)
    # lost, and pushed away once more at the first step after a reset
    begun, step = standing_calls(design)[:2]
    lost = Call("step", {**step.inputs, "x_position": 0.22})
    some += [begun, lost, begun, lost, step]
    return [*edge_calls(CommandGovernor(design).declaration), *some]


def found(number: int) -> str:
    """The first thing that these calls say of the C of a mutant; empty for nothing."""
    reference = CommandGovernor(renamed(number))
    agreement = compare(reference, CompiledController(mutants(), reference.declaration), calls())
    return "" if agreement.passed else str(agreement.difference)


def test_the_unchanged_package_agrees() -> None:
    assert found(len(MUTANTS)) == ""


@pytest.mark.parametrize("name", MUTANTS)
def test_every_mutant_is_found(name: str) -> None:
    told = found(list(MUTANTS).index(name))
    assert told, f"nothing noticed the mutant {name!r}"
