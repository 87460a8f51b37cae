"""Every planted fault is caught by what gcc alone can say, and nothing is caught in sound C."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from functools import cache

import pytest
from core_designs import Variant
from small_bench import bench

from servogen.emit.package import RUNTIME_FILES
from servogen.errors import CheckFailed
from servogen.evidence.bench import Bench
from servogen.evidence.seeded import Column, remembered, run_seeded, with_fault
from servogen.evidence.seeded_faults import FAULTS, KINDS, Fault, plant
from servogen.evidence.seeded_kept import Kept
from servogen.evidence.seeded_quick import Equivalence, StaticCount, warnings
from servogen.evidence.seeded_table import Row, page_text, table_text
from servogen.progress import Silent

# One worker: what the sound C answers is recorded once.
pytestmark = pytest.mark.xdist_group("seeded")
BASE = Variant("seed", horizon=5, cap=40, letter="L")
BY_NAME = {fault.name: fault for fault in FAULTS}
SILENT = [fault for fault in FAULTS if fault.silent]


@cache
def sound() -> Bench:
    return remembered(bench(BASE))


@cache
def equivalence() -> Equivalence:
    (own,) = sound().subjects
    check = Equivalence({own.precision.name: [*own.suite(60), *own.closed_loops(60)]})
    check.learn(sound())
    return check


def test_ten_kinds_each_in_the_runtime_or_a_template_twice_at_least():
    assert len(BY_NAME) == len(FAULTS)
    count = Counter(fault.kind for fault in FAULTS)
    assert tuple(dict.fromkeys(fault.kind for fault in FAULTS)) == KINDS
    assert min(count.values()) >= 2
    for kind in KINDS:
        files = [fault.file for fault in FAULTS if fault.kind == kind]
        assert any(file in RUNTIME_FILES for file in files), kind
        assert any(file not in RUNTIME_FILES for file in files), kind


def test_nothing_is_caught_in_sound_c():
    assert equivalence()(sound()) == []
    assert warnings(sound()) == []


@pytest.mark.parametrize("name", [fault.name for fault in FAULTS if not fault.silent])
def test_every_fault_changes_the_answers(name):
    """Which shows, too, that none is another way of writing the same."""
    assert equivalence()(with_fault(sound(), BY_NAME[name])) != []


def test_faults_that_change_no_answer_change_the_count():
    count = StaticCount()
    count.learn(sound())
    assert count(sound()) == []
    assert SILENT
    for fault in SILENT:
        mutant = with_fault(sound(), fault)
        assert count(mutant) != [], fault.name


def test_gcc_sees_the_uninitialised():
    for fault in FAULTS:
        if fault.kind == "uninitialised":
            assert any("uninitialized" in x for x in warnings(with_fault(sound(), fault)))


def test_text_that_is_gone_is_told():
    (own,) = sound().subjects
    gone = Fault("gone", "index", "@p_mpc.c", "there is no such text", "", "")
    with pytest.raises(CheckFailed, match="is 0 times in seed_mpc"):
        plant(gone, own.package)
    with pytest.raises(CheckFailed, match="not once"):
        plant(replace(gone, old="sg_status"), own.package)
    with pytest.raises(CheckFailed, match="0 times in another"):
        plant(replace(gone, file="another.c"), own.package)


def test_what_was_not_run_is_never_shown_as_missed():
    def refuse(mutant: Bench) -> list[str]:
        raise CheckFailed("it does not compile")

    columns = [
        Column("blind", lambda mutant: []),
        Column("absent", lambda mutant: ["never asked"], "tool missing"),
        Column("strict", refuse),
    ]
    rows = run_seeded(sound(), columns, Silent())
    assert [row.fault for row in rows] == list(FAULTS)
    assert all(
        row.said == {"blind": "missed", "absent": "tool missing", "strict": "caught"}
        for row in rows
    )
    text = table_text(sound(), rows)
    assert text == table_text(sound(), [Row(r.fault, dict(r.said)) for r in rows])
    assert text.count("| missed | tool missing | **caught** |") == len(FAULTS)
    assert f"Caught, of {len(FAULTS)}: blind 0, strict {len(FAULTS)}." in text
    # a page has a section of every project, made anew where it stands
    other = text.replace("seeded:seed ", "seeded:other ")
    page = page_text(page_text("of long ago", text), other)
    assert page.endswith(f"{text}\n{other}")
    assert "of long ago" not in page
    anew = text.replace("| missed |", "| caught |")
    assert page_text(page, anew) == page_text(page_text("", anew), other) != page


def test_what_was_said_is_kept_for_the_same_c_only(tmp_path):
    asked = []

    def judge(mutant: Bench) -> list[str]:
        asked.append(mutant)
        return ["found"] if len(asked) % 2 else []

    place = tmp_path / "out" / "seeded.json"
    first = run_seeded(sound(), [Column("odd", judge)], Silent(), Kept(place))
    assert len(asked) == len(FAULTS)
    again = run_seeded(sound(), [Column("odd", judge, "not chosen")], Silent(), Kept(place))
    assert [row.said for row in again] == [row.said for row in first]
    assert len(asked) == len(FAULTS)
    assert Kept(place).find("odd", sound()) is None
    assert Kept(place).find("even", with_fault(sound(), FAULTS[0])) is None
    place.write_text("no json")
    assert Kept(place).find("odd", with_fault(sound(), FAULTS[0])) is None
