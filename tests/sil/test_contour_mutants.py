"""Mutants of the contour controller's C, each found by calls that the reference answers once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from answered import Answered, answered
from contour_designs import small
from governor_designs import swap
from shared_builds import compiled_once

from servogen.controllers.contour_lq import ContourLq
from servogen.controllers.contour_lq_declaration import declare_contour_lq
from servogen.controllers.contour_lq_design import ContourLqDesign
from servogen.emit.package import emit_package
from servogen.sil.compiled import CompiledController
from servogen.sil.contour_calls import contour_calls
from servogen.sil.edges import edge_calls
from servogen.sil.scenarios import Scenario

# One worker: the mutants of a form are one module.
pytestmark = pytest.mark.xdist_group("contour mutants")
Change = Callable[[str], str]
STILL: Change = str

SLIDING: dict[str, Change] = {
    "unchanged": STILL,
    "an innovation that forgets": swap(
        "(here - self->last[0]) - self->ahead[0]", "here - self->last[0]"
    ),
    "hidden states are not corrected": swap("core_hidden_gain_y[i] * innovation", "(sg_real)0"),
    "hidden states without end": swap(
        "core_hidden_gain_x[i] * innovation), -core_hidden_bound, core_hidden_bound)",
        "core_hidden_gain_x[i] * innovation), -SG_REAL_MAX, SG_REAL_MAX)",
    ),
    "what drifts": swap("core_drift_y * position", "core_drift_x * position"),
    "hidden states stand": swap("sg_clamp(moved[i] + driven", "sg_clamp(hidden[i] + driven"),
    "the filter is told another axis' command": swap(
        "core_predict_y(self, out->command[1])", "core_predict_y(self, out->command[0])"
    ),
    "the filter is told what was wished": swap(
        "out->command[0] = sg_clamp(",
        "out->command[0] = (status == SG_OK) ? command[0] : sg_clamp(",
    ),
    "any point is apart": swap("(farthest > core_apart)", "(farthest > (sg_real)0)"),
    "the largest way is negative": swap("sg_max(way[i], -way[i])", "way[i]"),
    "the point stays": swap("            point[i] = here[i];\n", ""),
    "the course does not begin": swap(
        "    (void)core_go_on(points, self->point, self->direction);\n", ""
    ),
    "the course begins anew": swap("if (self->begun == 0) {", "if (self->begun >= 0) {"),
    "the end is not mirrored": swap(
        "(end->direction[i] * share) - before->direction[i]", "end->direction[i]"
    ),
    "mirrored at none": swap("(other->square > (sg_real)0) ? other : end", "other"),
    "no direction but one's own": swap(
        "(reached->square > (sg_real)0) ? reached : left", "reached"
    ),
    "no way back": swap("(cosine >= (sg_real)0) ?", "(cosine >= (sg_real)-9) ?"),
    "corners are curves": swap("lost = turned * turned;", "lost = turned;"),
    "a price without phi": swap("(core_share * lost) * ((sg_real)1 + phi)", "(sg_real)0"),
    "half a price": swap("* ((sg_real)1 + phi)", "* (sg_real)1"),
    "a price of contour alone": swap("dear = core_least_price +", "dear ="),
    "every point leaves": swap(
        "if (reached[j].fresh == 1) {\n            left",
        "if (reached[j].fresh >= 0) {\n            left",
    ),
    "a right side of one axis": swap("right[i] = right[i] + (y[i]", "right[i] = (y[i]"),
    "the pivot of another": swap(
        "sg_max(own[k], core_least_price)", "sg_max(matrix[0], core_least_price)"
    ),
    "the right side is not solved": swap("            s[i] -= own[i] * s[k];\n", ""),
    "nothing is taken off": swap("rest[i] -= own[i] * column[j];", "rest[i] -= (sg_real)0;"),
    "a slide is not put in": swap("k >= 0; k--", "k >= 2; k--"),
    "one slide too few": swap(
        "for (int32_t i = 1; i < CORE_SLIDES; i++) {\n        sum",
        "for (int32_t i = 1; i < (CORE_SLIDES - 1); i++) {\n        sum",
    ),
    "slides along the other axis": swap("core_slide_y, &along[4]", "core_slide_y, &along[0]"),
    "the point before": swap(
        "points[((j + 1) * CORE_AXES) + axis]", "points[(j * CORE_AXES) + axis]"
    ),
    "hidden states of the other axis": swap("&hidden[2], &given", "&hidden[0], &given"),
    "never limited": swap("out->limited += 1;", "out->limited += 0;"),
    "always known": swap("(out->known > 0) ? SG_OK : SG_PRIMING", "SG_OK"),
    "a command that goes on": swap("    sg_fill(CORE_AXES, (sg_real)0, out->command);\n", ""),
    "ready all the same": swap(
        "if (status == SG_OK) {\n        self->ready = 1;", "{\n        self->ready = 1;"
    ),
    "no status from the measurement": swap(
        "sg_status status = seen;", "sg_status status = (seen == SG_OK) ? SG_OK : SG_OK;"
    ),
}
STANDING: dict[str, Change] = {
    "unchanged": STILL,
    "the end slides": swap("*left = &reached[CORE_PREVIEW];", "*left = &reached[CORE_SLIDES];"),
}
TABULATED: dict[str, Change] = {
    "unchanged": STILL,
    "left by the last point": swap(
        "if (reached[j].fresh == 1) {\n            left",
        "if (reached[j].fresh == 2) {\n            left",
    ),
    "left by any point": swap(
        "if (reached[j].fresh == 1) {\n            left",
        "if (reached[j].fresh >= 0) {\n            left",
    ),
    "another point's direction": swap("&reached[CORE_AT]", "&reached[CORE_AT - 1]"),
    "half of the directions": swap(
        "(middle[0] >= (sg_real)0) ? middle[1] : -middle[1]", "middle[1]"
    ),
    "one entry on": swap("entry * (CORE_GIVEN", "(entry + 1) * (CORE_GIVEN"),
    "no entry after the last": swap(
        "(whole < CORE_ANGLES) ? whole : (CORE_ANGLES - 1)", "whole - 1"
    ),
    "nothing between entries": swap("rest * (high[i] - low[i])", "(sg_real)0"),
    "not less where it turns": swap("(phi * phi) *", "phi *"),
}
FORMS: dict[str, tuple[ContourLqDesign, dict[str, Change]]] = {
    form: (small(form), changes)
    for form, changes in (
        ("sliding", SLIDING),
        ("standing", STANDING),
        ("tabulated", TABULATED),
    )
}


def renamed(form: str, number: int) -> ContourLqDesign:
    return replace(FORMS[form][0], prefix=f"{form}{number}")


@cache
def mutants(form: str) -> Any:
    """One package with a controller for each."""
    changes = FORMS[form][1]
    own = [declare_contour_lq(renamed(form, number)) for number in range(len(changes))]
    made = emit_package(f"{form}mutants", tuple(own))
    files = dict(made.files)
    for declaration, change in zip(own, changes.values(), strict=True):
        p = declaration.prefix
        text = files[f"{p}.c"].replace(f"{p}_", "core_").replace(f"{p.upper()}_", "CORE_")
        text = change(text).replace("CORE_", f"{p.upper()}_")
        files[f"{p}.c"] = text.replace("core_", f"{p}_")
    return compiled_once([replace(made, files=files)], ["-O0", "-Wno-error", "-w"])


@cache
def told(form: str) -> list[Answered]:
    own = renamed(form, 0)
    calls = {
        "random": list(contour_calls(own, np.random.default_rng(8), 500)),
        "disturbed": list(contour_calls(own, np.random.default_rng(9), 200, bad=0.4)),
        "edges": list(edge_calls(declare_contour_lq(own))),
    }
    return answered(Scenario(name, lambda: ContourLq(own), some) for name, some in calls.items())


def found(form: str, number: int) -> str:
    """The first thing that these calls say of the C of a mutant; empty for nothing."""
    declaration = declare_contour_lq(renamed(form, number))
    for scenario in told(form):
        agreement = scenario.held_against(CompiledController(mutants(form), declaration))
        if not agreement.passed:
            return str(agreement.difference)
    return ""


@pytest.mark.parametrize(
    ("form", "name"), [(form, name) for form, (_, changes) in FORMS.items() for name in changes]
)
def test_every_mutant_is_found_and_nothing_else(form: str, name: str) -> None:
    said = found(form, list(FORMS[form][1]).index(name))
    assert bool(said) is (name != "unchanged"), said or f"nothing noticed the mutant {name!r}"
