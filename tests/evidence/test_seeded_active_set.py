"""The planted faults of the active-set method are caught by what gcc alone can say, too."""

from __future__ import annotations

from functools import cache

import pytest
from core_designs import Variant
from small_bench import bench

from servogen.evidence.bench import Bench
from servogen.evidence.seeded import faults_for, remembered, with_fault
from servogen.evidence.seeded_active_set import ACTIVE_SET_FAULTS
from servogen.evidence.seeded_faults import FAULTS, KINDS
from servogen.evidence.seeded_quick import Equivalence, StaticCount, warnings

# One worker: what the sound C answers is recorded once. By default test_seeded.py is enough.
pytestmark = [pytest.mark.xdist_group("seeded_active_set"), pytest.mark.tools]
BASE = Variant("seed", horizon=5, cap=40, letter="L", method="active_set")
BY_NAME = {fault.name: fault for fault in ACTIVE_SET_FAULTS}
SILENT = [fault for fault in ACTIVE_SET_FAULTS if fault.silent]


@cache
def sound() -> Bench:
    return remembered(bench(BASE))


@cache
def equivalence() -> Equivalence:
    (own,) = sound().subjects
    check = Equivalence({own.precision.name: [*own.suite(60), *own.closed_loops(60)]})
    check.learn(sound())
    return check


def test_the_method_says_which_faults_are_planted() -> None:
    assert faults_for(sound()) == ACTIVE_SET_FAULTS
    assert faults_for(bench(Variant("seed", horizon=1))) == FAULTS
    assert len(BY_NAME) == len(ACTIVE_SET_FAULTS)
    assert {fault.kind for fault in ACTIVE_SET_FAULTS} <= set(KINDS)


def test_nothing_is_caught_in_sound_c() -> None:
    assert equivalence()(sound()) == []
    assert warnings(sound()) == []


@pytest.mark.parametrize("name", [name for name, fault in BY_NAME.items() if not fault.silent])
def test_every_fault_changes_the_answers(name: str) -> None:
    assert equivalence()(with_fault(sound(), BY_NAME[name])) != []


def test_faults_that_change_no_answer_change_the_count() -> None:
    count = StaticCount()
    count.learn(sound())
    assert count(sound()) == []
    assert SILENT
    for fault in SILENT:
        assert count(with_fault(sound(), fault)) != [], fault.name


def test_gcc_sees_the_uninitialised() -> None:
    (fault,) = (fault for fault in ACTIVE_SET_FAULTS if fault.kind == "uninitialised")
    assert any("uninitialized" in said for said in warnings(with_fault(sound(), fault)))
