"""The extended command governor, which no bundled system has yet: MISRA, Eva, and its bounds."""

from __future__ import annotations

import shutil
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from governor_designs import Shape, alike, governor, package

from servogen.emit.package import CPackage
from servogen.evidence.bench import Subject
from servogen.evidence.misra import judge
from servogen.evidence.misra_deviations import load
from servogen.evidence.misra_run import examine
from servogen.evidence.misra_tool import find_cppchecks
from servogen.evidence.prove_bounds import binding, bound_places
from servogen.evidence.prove_parts import Job
from servogen.evidence.prove_run import INPUTS, prove
from servogen.sil.command_governor_calls import axis_governor_calls, command_governor_calls
from servogen.sil.edges import edge_calls
from servogen.sil.player import Play
from servogen.steps.counted import count_emitted

needs_framac = pytest.mark.skipif(
    shutil.which("frama-c") is None, reason="no frama-c here; make prove needs it"
)
SMALL = Shape("small", "float32", horizon=3, points=2, cap=6, sub_samples=1)


@cache
def small(precision: str) -> CPackage:
    return package(
        alike(governor(replace(SMALL, prefix=f"s{precision[-2:]}", precision=precision)))
    )


def test_no_misra_rule_is_broken_but_those_that_are_declared() -> None:
    made = small("float32")
    tool = next(t for t in find_cppchecks() if t.origin == "PyPI")
    report = examine(made, tool)
    assert set(report.files) == set(made.code)
    faults, _ = judge(report, made, tool.version, load())
    # a deviation that this small package has no use for is one of the others'
    assert [fault for fault in faults if "covers nothing" not in fault] == []


@needs_framac
@pytest.mark.parametrize("inputs", INPUTS)
@pytest.mark.parametrize(("which", "precision"), [(0, "float64"), (1, "float32")])
def test_eva_sees_no_error_whatever_comes_in(
    which: int, precision: str, inputs: str, tmp_path: Path
) -> None:
    """Of the axis, and of what calls it."""
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
        Play("both", own.prefix, tuple(command_governor_calls(own, rng, 800))),
        Play("axis", own.axes[0].prefix, tuple(axis_governor_calls(own.axes[0], rng, 400))),
        Play("edges", own.prefix, tuple(edge_calls(made.declarations[-1]))),
    ]
    subject = Subject(made, own.precision, count_emitted(made), lambda _: plays, lambda _: plays)
    assert bound_places(made) > 10
    assert binding(subject, plays, tmp_path) == {}
