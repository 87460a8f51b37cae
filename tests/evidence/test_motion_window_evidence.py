"""The streamed minimal motion, which no bundled system has yet: MISRA, Eva, and its bounds."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from heavy_tools import needs_framac

from servogen.controllers.motion_window_design import MotionWindowDesign, declare_motion_window
from servogen.emit.package import CPackage, emit_package
from servogen.evidence.bench import Subject
from servogen.evidence.misra import judge
from servogen.evidence.misra_deviations import load
from servogen.evidence.misra_run import examine
from servogen.evidence.misra_tool import find_cppchecks
from servogen.evidence.prove_bounds import binding, bound_places
from servogen.evidence.prove_parts import Job
from servogen.evidence.prove_run import INPUTS, prove
from servogen.precision import PRECISIONS
from servogen.sil.edges import edge_calls
from servogen.sil.motion_calls import motion_window_calls
from servogen.sil.player import Play
from servogen.steps.counted import count_emitted


def design(precision: str, free_end: bool) -> MotionWindowDesign:
    window, block = (7, 3) if free_end else (3, 8)
    return MotionWindowDesign(
        "motion", PRECISIONS[precision], window, block, 0.02, 0.1, 0.01, free_end=free_end
    )


def package(precision: str, free_end: bool) -> CPackage:
    return emit_package("moved", (declare_motion_window(design(precision, free_end)),))


@pytest.mark.tools
@pytest.mark.parametrize("free_end", [False, True])
def test_no_misra_rule_is_broken_but_those_that_are_declared(free_end: bool) -> None:
    made = package("float32", free_end)
    tool = next(t for t in find_cppchecks() if t.origin == "PyPI")
    report = examine(made, tool)
    assert set(report.files) == set(made.code)
    faults, _ = judge(report, made, tool.version, load())
    # a deviation that this small package has no use for is one of the others'
    assert [fault for fault in faults if "covers nothing" not in fault] == []


@needs_framac
@pytest.mark.parametrize("inputs", INPUTS)
@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_eva_sees_no_error_whatever_comes_in(precision: str, inputs: str, tmp_path: Path) -> None:
    made = package(precision, precision == "float32")
    made.write(tmp_path)
    proof = prove(Job(made, made.declarations[0], inputs), tmp_path)
    assert proof.faults == ()
    assert proof.alarms == {}
    assert proof.proven >= 10


@pytest.mark.parametrize("free_end", [False, True])
def test_what_is_there_for_the_proof_changes_nothing(free_end: bool, tmp_path: Path) -> None:
    own = design("float64", free_end)
    made = package("float64", free_end)
    declaration = made.declarations[0]
    calls = [*edge_calls(declaration),
             *motion_window_calls(own, np.random.default_rng(0), 2000)]  # fmt: skip
    plays = [Play("random", "motion", tuple(calls))]
    subject = Subject(made, own.precision, count_emitted(made), lambda _: plays, lambda _: plays)
    assert bound_places(made) > 5
    assert binding(subject, plays, tmp_path) == {}
