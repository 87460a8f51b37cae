"""The extended command governor under Eva, and the bounds that are in its C for the proof."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from governor_designs import Shape, alike, governor, package
from heavy_tools import needs_framac

from servogen.emit.package import CPackage
from servogen.evidence.bench import Subject
from servogen.evidence.prove_bounds import binding, bound_places
from servogen.evidence.prove_parts import Job
from servogen.evidence.prove_run import prove
from servogen.sil.command_governor_calls import axis_governor_calls, command_governor_calls
from servogen.sil.edges import edge_calls
from servogen.sil.player import Play
from servogen.steps.counted import count_emitted

SMALL = Shape("small", "float32", horizon=3, points=2, cap=6, sub_samples=1)


@cache
def small(precision: str) -> CPackage:
    return package(
        alike(governor(replace(SMALL, prefix=f"s{precision[-2:]}", precision=precision)))
    )


@needs_framac
@pytest.mark.parametrize(
    ("which", "precision", "inputs"),
    [(0, "float64", "finite"), (0, "float32", "any"), (1, "float64", "any")],
)
def test_eva_sees_no_error_whatever_comes_in(
    which: int, precision: str, inputs: str, tmp_path: Path
) -> None:
    """Of the axis, and of what calls it: any double may be promised to it as a state ahead."""
    made = small(precision)
    made.write(tmp_path)
    proof = prove(Job(made, made.declarations[which], inputs), tmp_path)
    assert proof.faults == ()
    assert proof.alarms == {}
    assert proof.proven >= 10


def test_what_is_there_for_the_proof_changes_nothing(tmp_path: Path) -> None:
    own = alike(governor(replace(SMALL, prefix="s64", precision="float64")))
    made, rng = small("float64"), np.random.default_rng(0)
    plays = [
        Play("both", own.prefix, tuple(command_governor_calls(own, rng, 500))),
        Play("axis", own.axes[0].prefix, tuple(axis_governor_calls(own.axes[0], rng, 250))),
        Play("edges", own.prefix, tuple(edge_calls(made.declarations[-1]))),
    ]
    subject = Subject(made, own.precision, count_emitted(made), lambda _: plays, lambda _: plays)
    assert bound_places(made) > 10
    assert binding(subject, plays, tmp_path) == {}
