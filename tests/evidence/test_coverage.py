"""Every branch of the small cascades is reached or listed, and what is neither is named."""

from __future__ import annotations

import subprocess
from collections import Counter
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest
from contour_bench import covered as on_contour
from core_designs import Variant, design, package
from governor_bench import covered as on_governor
from servo_bench import AXES
from servo_bench import covered as on_servo
from small_bench import SEED, bench, changed, subject

from servogen.controllers.tracking_mpc import TrackingMpc
from servogen.emit.package import emit_package
from servogen.errors import CheckFailed, InputError
from servogen.evidence import coverage, coverage_build
from servogen.evidence.coverage import Covered, cover
from servogen.evidence.coverage_decisions import probe
from servogen.evidence.coverage_list import Branch, reviewed
from servogen.sil.edges import edge_calls
from servogen.sil.player import Play
from servogen.sil.random_calls import random_calls
from servogen.steps import equivalence

# One worker: what the variants reach is found out once.
pytestmark = pytest.mark.xdist_group("coverage")
# Between them they make every line of every template, in both precisions.
VARIANTS = {
    "cascade": Variant("cov64", horizon=5, cap=12),
    "float32, fourth order, axes differ": Variant(
        "cov32", horizon=3, cap=7, precision="float32", order=4, differing=True, period=0, ramp=0
    ),
    "governor alone": Variant("cov0", horizon=0, precision="float32"),
}
STEPS = 120


@cache
def covered(name: str) -> Covered:
    one = subject(VARIANTS[name])
    return cover(one, [*one.suite(STEPS), *one.closed_loops(None)], reviewed())


@cache
def by_active_set(precision: str) -> Covered:
    """The MPC of that method alone; many calls, for a row that makes room for another is rare."""
    v = Variant("covas", horizon=9, cap=30, precision=precision, method="active_set")
    mpc = TrackingMpc(design(v).mpc[0])
    one = subject(v, emit_package(v.prefix, (mpc.declaration,)))
    calls = [*edge_calls(mpc.declaration), *random_calls(mpc.design, SEED + 1, 500)]
    return cover(one, [Play("calls", mpc.declaration.prefix, tuple(calls))], reviewed())


@pytest.mark.parametrize("name", VARIANTS)
def test_every_branch_is_reached_or_listed(name):
    result = covered(name)
    assert result.faults == []
    assert result.calls > 1000
    assert result.reached + len(result.compared.justified) == result.total > 150
    assert f"{VARIANTS[name].prefix}_governor.c" in result.files
    assert 0 < result.measured.gcov_taken <= result.measured.gcov_branches


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_every_branch_of_the_active_set_method_is_reached_or_listed(precision):
    file = "covas_mpc.c"  # without the cascade, the shared headers have branches of others
    result = by_active_set(precision)
    assert [fault for fault in result.faults if fault.startswith(file)] == []
    assert file in result.files


@pytest.mark.tools
def test_every_branch_of_a_command_governor_is_reached_or_listed():
    result = on_governor()
    assert result.faults == []
    assert {"small_etcher.c", "small_etcher_axis.c"} <= set(result.files)
    listed = [str(entry.branch) for _, entry in result.compared.justified]
    assert "where: i < ROWS is never false" in listed


@pytest.mark.tools
def test_every_entry_of_the_list_is_needed_somewhere():
    every = [
        *(by_active_set(precision) for precision in ("float32", "float64")),
        *(covered(name) for name in VARIANTS),
        *(on_servo(name) for name in AXES),
        on_governor(),
        on_contour("table at the end"),
    ]
    needed = {entry.branch for one in every for _, entry in one.compared.justified}
    stale = [str(entry.branch) for entry in reviewed() if entry.branch not in needed]
    assert stale == []


def test_curvature_that_is_lost_in_rounding_is_reached_in_float32():
    """What the list has for float64 and low caps is no dead code."""
    v = Variant("cov", horizon=5, cap=60, precision="float32")
    (solver,) = (d for d in package(v).declarations if d.kind == "mpc")
    one = subject(v, emit_package("cov", (solver,)))
    plays = [p for p in one.suite(STEPS) if p.prefix == solver.prefix]
    guard = "sg_pqp_extrapolate: curvature > zero is never false"
    assert guard in [str(e.branch) for e in cover(one, plays, reviewed()).compared.unneeded]
    assert guard in [str(e.branch) for e in reviewed()]


def test_the_calls_are_those_of_the_equivalence_suite():
    assert coverage.STEPS == equivalence.RANDOM_CALLS


def test_a_branch_that_nothing_reaches_is_named():
    v = VARIANTS["governor alone"]
    old = "    self->waiting = 0;\n"
    new = old + "    if (self->done > 30000) {\n        self->waiting = 1;\n    }\n"
    made = changed(package(v), "cov0_follower.c", old, new)
    one = subject(v, made)
    result = cover(one, one.suite(20), reviewed())
    assert any("init: self->done > 30000 is never true" in fault for fault in result.faults)


def test_calls_that_leave_an_operation_out_do_not_pass():
    one = subject(VARIANTS["governor alone"])
    plays = [
        Play(p.name, p.prefix, tuple(c for c in p.calls if c.operation != "predict"))
        for p in one.suite(10)
    ]
    result = cover(one, plays, reviewed())
    assert any("predict: status == SG_OK is never true" in fault for fault in result.faults)
    assert "no branch or no call to look at" in replace(result, calls=0).faults
    assert "no branch or no call to look at" in replace(result, files={}).faults


def test_the_finding_says_what_was_measured(monkeypatch):
    from servogen.progress import Silent

    monkeypatch.setattr(coverage, "STEPS", 60)
    finding = coverage.run(bench(VARIANTS["governor alone"]), Silent())
    assert finding.passed, finding.faults
    assert set(finding.figures) == {"float32", "float64"} == set(finding.subjects)
    figures = finding.figures["float32"]
    assert figures["branches"] == figures["reached"] + figures["justified"]
    assert figures["mcdc"] is True
    assert figures["files"]["cov0.c"]["branches"] > 20
    assert "gcov" in finding.tools
    assert any("PRIMING is zero" in line for line in finding.details)


WAYS = """\
int f(int a, double x);
int f(int a, double x)
{
    int total = (a == 0) ? 0 : (a - 1);
    for (int i = 0; i < 3; i++) {
        if (!(x >= 1.0)) {
            total += i;
        } else if (x > 2.0) {
            break;
        }
    }
    total = (x < 1.5) ? total : 7;
    return total;
}
"""


def test_the_ways_are_told_apart(tmp_path):
    """gcc turns the first and the last condition round or does without a branch."""
    (tmp_path / "f.c").write_text(WAYS)
    unit = probe(tmp_path / "f.c", 0, package(VARIANTS["cascade"]).declarations)
    main = """
#include <stdio.h>
int main(void)
{
    f(0, 0.0); f(5, 0.5); f(6, 1.25); f(7, 3.0);
    for (unsigned long i = 0; i < sg_probes_0_rows; i++) {
        printf("%lu %lu\\n", sg_probes_0[i][0], sg_probes_0[i][1]);
    }
    return 0;
}
"""
    (tmp_path / "all.c").write_text(unit.text + main)
    subprocess.run(["gcc", "-std=c99", "-w", "-o", "all", "all.c"], cwd=tmp_path, check=True)
    told = subprocess.run(["./all"], cwd=tmp_path, capture_output=True, text=True, check=True)
    counts = [tuple(map(int, line.split())) for line in told.stdout.splitlines()]
    found = {s.decision.condition: c for s, c in zip(unit.sites, counts, strict=True)}
    assert found == {
        "a == 0": (3, 1),
        "i < 3": (3, 10),
        "!(x >= 1.0)": (4, 6),
        "x > 2.0": (3, 1),
        "x < 1.5": (1, 3),
    }
    assert unit.faults == ()


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("return ((a > 0) && (a < 9)) ? 1 : 0;", "&& joins two conditions"),
        ("if (a || b) { a = 1; } return a;", "|| joins two conditions"),
        ("int c = a < b; return c;", "a comparison decides nothing"),
        ("return ((a < b) == 1) ? 1 : 0;", "a comparison decides nothing"),
        ("return ((a = b) == 1) ? 1 : 0;", "more than a comparison"),
    ],
)
def test_what_would_not_be_mcdc_is_a_fault(tmp_path, text, fault):
    (tmp_path / "f.c").write_text(f"int f(int a, int b) {{ {text} }}\n")
    faults = probe(tmp_path / "f.c", 0, ()).faults
    assert any(fault in f and "f.c:1 (f)" in f for f in faults), faults


def test_a_switch_is_refused(tmp_path):
    (tmp_path / "f.c").write_text("int f(int a) { switch (a) { case 1: return 2; } return 0; }\n")
    with pytest.raises(CheckFailed, match="Switch"):
        probe(tmp_path / "f.c", 0, ())


def test_gcov_has_a_say():
    """A count that gcov has and the probes do not is a fault."""
    tallies = covered("governor alone").measured.tallies
    place = tallies[0].site.file, tallies[0].site.function
    own = Counter({(min(t.true, t.false), max(t.true, t.false)): 1 for t in tallies[:1]})
    assert coverage_build._disagreements("unit", {place: own}, tallies) == []
    other = {place: Counter({(10**9, 10**9): 1})}
    assert coverage_build._disagreements("unit", other, tallies) == [
        f"unit: gcov and the probes count {place[1]} of {place[0]} differently"
    ]


ENTRY = 'where = "mpc"\nfunction = ["a", "b"]\ncondition = "x < 0"\nway = "both"\n'
REASON = 'reason = "It is an argument of some length, as wanted here."\n'


def test_the_list_is_read_and_judged(tmp_path):
    path = tmp_path / "list.toml"
    path.write_text(f"[[branch]]\n{ENTRY}{REASON}")
    entries = reviewed(path)
    assert len({e.branch for e in entries}) == 4
    assert {e.branch.decision.function for e in entries} == {"a", "b"}
    assert isinstance(entries[0].branch, Branch)
    bad = {
        "the keys": ENTRY,
        "an argument": ENTRY + 'reason = "no"\n',
        "true, false or both": ENTRY.replace("both", "never") + REASON,
        "every branch once": f"{ENTRY}{REASON}[[branch]]\n{ENTRY}{REASON}",
        "a readable TOML file": "way =",
    }
    for expected, text in bad.items():
        path.write_text(f"[[branch]]\n{text}")
        with pytest.raises(InputError, match=expected):
            reviewed(path)
    with pytest.raises(InputError, match="readable"):
        reviewed(Path("/nonexistent.toml"))
    one, other = (f'{ENTRY}only_with = "{kind}"\n{REASON}' for kind in ("fast", "mpc"))
    path.write_text(f"[[branch]]\n{one}[[branch]]\n{other}")
    assert [e.only_with for e in reviewed(path)] == [("fast",)] * 4 + [("mpc",)] * 4
    path.write_text(f"[[branch]]\n{one}[[branch]]\n{ENTRY}{REASON}")
    with pytest.raises(InputError, match="once for each kind"):
        reviewed(path)


WORDS = {"servo": ("queue", "horizon", "fast stage", "cascade"), "cascade": ("servo axis", "tree")}


def test_the_reasons_are_about_the_package_that_they_are_given_for():
    """No reason of a servo axis speaks of a cascade's parts, nor the other way round."""
    for kind, names, cover_one in (("cascade", VARIANTS, covered), ("servo", AXES, on_servo)):
        for name in names:
            for place, entry in cover_one(name).compared.justified:
                wrong = [word for word in WORDS[kind] if word in entry.reason]
                assert wrong == [], (name, str(place))
