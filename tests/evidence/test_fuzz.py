"""The kept corpus finds what is planted, and libFuzzer's check says what it did."""

from __future__ import annotations

import re

import pytest
from core_designs import Variant, design, package
from heavy_tools import needs_clang
from small_bench import changed, subject

from servogen.controllers.cascade_design import declare_parts
from servogen.errors import InputError
from servogen.evidence import fuzz, fuzz_corpus
from servogen.evidence.bench import Bench
from servogen.evidence.fuzz_corpus import corpus_dir, kept_files
from servogen.evidence.fuzz_target import target_source
from servogen.evidence.sanitizers import replay
from servogen.progress import Silent

BASE = Variant("fuzzed", horizon=0, precision="float32")
KERNELS = "sg_kernels.h"
# name: (file, old, new, complaint)
PLANTED = {
    "one too far": (
        "fuzzed_follower.c",
        "    for (int i = 0; i < (FUZZED_FOLLOWER_INTERVALS - 1); i++) {",
        "    for (int i = 0; i < FUZZED_FOLLOWER_INTERVALS; i++) {",
        "out of bounds",
    ),
    "unguarded NaN": (KERNELS, "if (!(x == x)) {", "if (x > x) {", "not finite"),
    "not reset": ("fuzzed_follower.c", "    self->along = (sg_real)0;\n", "", "differs"),
    "hidden state": (
        "fuzzed_follower.c",
        "    sg_real point = path[self->head];",
        "    static sg_real kept; kept += 1.0e-6f; sg_real point = path[self->head] + kept;",
        "differs between two instances",
    ),
    "input written": (
        "fuzzed_follower.c",
        "    self->head = fuzzed_follower_wrap(self->head + self->current);",
        "    self->head = fuzzed_follower_wrap(self->head + self->current);"
        " ((fuzzed_follower_begin_in *)(uintptr_t)in)->x_velocity += 1.0f;",
        "was written to",
    ),
    "wrong status": (
        "fuzzed_follower.c",
        "status = (status == SG_OK) ? SG_OVERFLOW : status;",
        "status = (sg_status)(SG_UNREACHABLE + 1);",
        "none of the enumeration",
    ),
}


@pytest.mark.parametrize("name", PLANTED)
def test_the_kept_corpus_finds_what_is_planted(name, tmp_path):
    file, old, new, complaint = PLANTED[name]
    made = changed(package(BASE), file, old, new)
    played = "fuzzed_governor" if name == "unguarded NaN" else "fuzzed_follower"
    _, faults = replay(subject(BASE, made), tmp_path, corpus_dir(), [played])
    assert faults, f"nothing noticed {name!r}"
    assert complaint in " ".join(faults)
    assert all(str(tmp_path) not in fault for fault in faults)


def test_the_corpus_is_small_and_named_by_content():
    import hashlib

    kinds = sorted(folder.name for folder in corpus_dir().iterdir())
    assert kinds == [
        *("cascade", "cascade_sprg", "command_governor", "command_governor_axis", "contour_lq"),
        *("fast", "governor", "lookup_clips", "lookup_tree", "mpc", "servo_mpc", "servo_pid"),
    ]
    total = 0
    for kind in kinds:
        for file in kept_files(corpus_dir() / kind):
            content = file.read_bytes()
            assert file.name == hashlib.sha1(content).hexdigest()
            assert len(content) <= fuzz.LONGEST
            total += len(content)
    assert 1000 < total < 300_000


def test_the_target_knows_every_port():
    for d in declare_parts(design(Variant("all", horizon=3))):
        text = target_source(d)
        ports = [port for op in d.operations for port in (*op.inputs, *op.outputs)]
        assert len(re.findall(r'^    \{ "\w+", offsetof', text, re.M)) == len(ports)
        for op in d.operations:
            assert f"{d.prefix}_{op.name}(" in text
    assert fuzz_corpus.first_sequences(d)[0].startswith(bytes((0, 0)))


def test_seconds_are_seconds(monkeypatch):
    monkeypatch.setenv("FUZZ_SECONDS", "12")
    assert fuzz.seconds() == 12
    for bad in ("0", "-1", "soon"):
        monkeypatch.setenv("FUZZ_SECONDS", bad)
        with pytest.raises(InputError, match="FUZZ_SECONDS"):
            fuzz.seconds()


def test_an_absurd_number_of_points_is_no_overflow(tmp_path):
    """``plan`` keeps n_points even where it refuses it, and ``start`` asks whether any are left."""
    v = Variant("absurd", horizon=2, cap=5, points=30, ramp=10)
    d = package(v).declarations[-1]
    number = {op.name: i for i, op in enumerate(d.operations)}
    port = [p.name for p in d.operation("plan").inputs].index("n_points")
    changes = {"as they are": (), "INT32_MAX": (port, 3, 1), "INT32_MIN": (port, 3, 0)}
    corpus = tmp_path / "corpus" / d.kind
    corpus.mkdir(parents=True)
    for name, change in changes.items():
        calls = [(number["reset"], 0), *[(number["step"], 0)] * 8]
        calls += [(number["plan"], 1 if change else 0, *change), (number["start"], 0)]
        (corpus / name).write_bytes(b"".join(map(bytes, calls)))
    counts, faults = replay(subject(v), tmp_path / "replay", corpus.parent, [d.prefix])
    assert counts == {d.prefix: 3}
    assert faults == []


@needs_clang
def test_libfuzzer_runs_every_target_and_keeps_what_is_new(monkeypatch, tmp_path):
    fuzz.require_libfuzzer()
    monkeypatch.setenv("FUZZ_SECONDS", "1")
    monkeypatch.setattr(fuzz, "corpus_dir", lambda: tmp_path / "corpus")
    (tmp_path / "corpus").mkdir()
    finding = fuzz.run(Bench("fuzzed", (subject(BASE),)), Silent())
    assert finding.passed, finding.faults
    by_prefix = finding.figures["float32"]
    assert set(by_prefix) == {"fuzzed_governor", "fuzzed_follower", "fuzzed"}
    assert all(figures["executions"] > 0 < figures["edges"] for figures in by_prefix.values())
    assert len(kept_files(tmp_path / "corpus" / "fast")) >= 5
