"""One change in the emitted C of a servo axis or a lookup each, which its suite must report."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import pytest
from answered import Answered, answered
from core_designs import temporary_folder
from servo_designs import Axis, package, parts
from test_mutants import nudge, swap

from servogen.emit.package import CPackage
from servogen.sil.build import compile_package
from servogen.sil.compiled import CompiledController
from servogen.sil.servo_scenarios import servo_suite

pytestmark = pytest.mark.xdist_group("servo mutants")
AXIS = {
    "t": Axis("mt64", moves=3),
    "s": Axis("ms64", "slide"),
    "p": Axis("mp64", "pair"),
}
# name: (axis, file without the prefix, change)
MUTANTS: dict[str, tuple[str, str, Any]] = {
    "hyperplane": ("t", "_mpc_lookup_tables.h", nudge("_offsets", 1, 1e-12)),
    "sides": ("t", "_mpc_lookup.c", swap("_above[at] : ", "_below[at] : ")),
    "law": ("t", "_mpc_lookup_tables.h", nudge("_gains", 0)),
    "odd": ("t", "_mpc_lookup.c", swap("move[j] = -move[j];", "move[j] = move[j];")),
    "edge": ("s", "_mpc_lookup_tables.h", nudge("_edge_bounds", 5, 1e-9)),
    "nothing found": ("s", "_mpc_lookup.c", swap("out->law = -1;", "out->law = 0;")),
    "clip": ("p", "_mpc_lookup.c", swap("kept - self->eta[i]", "kept")),
    "coefficient": ("p", "_mpc_lookup_tables.h", nudge("_coefficients", 3, 1e-9)),
    "last turn": ("t", "sg_angle.h", swap("(second <= -half)", "(second < -half)")),
    "nearest turn": ("t", "sg_angle.h", swap("(first > half)", "(first > turn)")),
    "gain": ("t", "_mpc_tables.h", nudge("_gain_state", 0, 1e-9)),
    "measured": ("t", "_mpc.c", swap("self->last[i] = in->position;", "")),
    "each from the one before": ("t", "_mpc.c", swap("before = here;", "(void)here;")),
    "change of the current": ("s", "_mpc.c", swap("self->previous[i] + ms64_mpc_c", "ms64_mpc_c")),
    "signal": ("s", "_mpc.c", swap("= self->last[j] + self->drift[j];", "= self->last[j];")),
    "windup": ("t", "_pid.c", swap("integral = self->integral;", "")),
    "emptied": ("t", "_pid.c", swap("self->integral = (sg_real)0;", "")),
    "notch": ("t", "_pid.c", swap("+ self->memory_2;", "- self->memory_2;")),
    "unready": ("t", "_pid.c", swap("if (self->ready == 1) {", "if (self->ready <= 1) {")),
}  # fmt: skip


def mutant(name: str) -> tuple[CPackage, str]:
    """The package with a prefix of its own, so that all are one module."""
    key, file, change = MUTANTS[name]
    axis = AXIS[key]
    made, own = package(axis), f"m{list(MUTANTS).index(name)}"
    files = dict(made.files)
    target = file if file.startswith("sg_") else f"{axis.prefix}{file}"
    files[target] = change(files[target])

    def called(text: str) -> str:
        text = text.replace(axis.prefix, own).replace(axis.prefix.upper(), own.upper())
        return text.replace("sg_angle.h", f"{own}_angle.h").replace("SG_ANGLE_H", f"{own}_ANGLE_H")

    declarations = tuple(
        replace(d, prefix=called(d.prefix), uses=tuple(called(u) for u in d.uses))
        for d in made.declarations
    )
    files = {called(n): called(text) for n, text in files.items()}
    return replace(made, name=own, hash=own, declarations=declarations, files=files), axis.prefix


@cache
def everything() -> Any:
    return compile_package(
        [mutant(name)[0] for name in MUTANTS], temporary_folder("mutants"), ["-O0", "-Wno-error"]
    )


@cache
def reference_answers(axis: Axis) -> list[Answered]:
    return answered(servo_suite(parts(axis), 5, 400))


@pytest.mark.parametrize("name", MUTANTS)
def test_the_suite_reports_it(name: str) -> None:
    made, prefix = mutant(name)
    axis = AXIS[MUTANTS[name][0]]
    found = []
    for case in reference_answers(axis):
        own = case.declaration.prefix.replace(prefix, made.name)
        declaration = next(d for d in made.declarations if d.prefix == own)
        found.append(case.held_against(CompiledController(everything(), declaration)).passed)
    assert not all(found)
