"""The C under the address and undefined-behaviour sanitizers, given anything at all: a status, a
bounded output, nothing undefined."""

from __future__ import annotations

import struct
import subprocess
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from core_designs import Variant, package, temporary_folder
from small_bench import changed, subject

from servogen.controllers.design import Declaration, Port, Status
from servogen.emit.package import emit_package
from servogen.evidence import sanitizers
from servogen.evidence.answers import Answers, answers, misjudged
from servogen.evidence.bench import Bench
from servogen.evidence.fuzz_build import CHECKS, LANGUAGE
from servogen.evidence.sanitizers import play_sanitized, replay
from servogen.evidence.tools import demand, run_tool
from servogen.progress import Silent
from servogen.sil.edges import edge_calls
from servogen.sil.player import Play, encode, entry_points, player_source, struct_layout

VARIANTS = {
    "float64": Variant("sane64", horizon=3, cap=12, points=30, ramp=10),
    "float32, fourth order, axes differ": Variant(
        "sane32", horizon=2, points=5, ramp=1, cap=7, precision="float32", order=4, differing=True
    ),
    "governor alone, M = 2": Variant("sane2", horizon=0, points=2, ramp=0, precision="float32"),
}

of_each_variant = pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.tools) if VARIANTS[name].order == 4 else name
        for name in VARIANTS
    ],
)


@cache
def program(name: str) -> Path:
    """The sanitized player of one package."""
    folder = temporary_folder("sane")
    one = subject(VARIANTS[name])
    sources = one.write(folder)
    (folder / "player.c").write_text(player_source(one.package.declarations))
    demand(["gcc", *LANGUAGE, *CHECKS, "-o", "player", "player.c", *sources], "gcc", folder)
    return folder / "player"


def told(name: str, stream: bytes) -> bytes:
    done = subprocess.run([program(name)], input=stream, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode()[:3000]
    assert done.stderr == b""
    return done.stdout


def status_of_one(port: Port, value, d: Declaration, n_points: int) -> Status:
    """What one input alone asks for, by its declaration."""
    if port.low is None:
        return Status.OK
    array = np.atleast_1d(np.asarray(value))
    if port.integer:
        return Status.OK if port.low <= array[0] <= port.high else Status.OUT_OF_RANGE
    if port.name.startswith("points_"):
        array = array[: max(n_points, 0)]
    with np.errstate(over="ignore"):
        array = array.astype(d.precision.dtype)
    if not np.all(np.isfinite(array)):
        return Status.NOT_FINITE
    low, high = (d.precision.dtype.type(bound) for bound in (port.low, port.high))
    inside = np.all((array >= low) & (array <= high))
    return Status.OK if inside else Status.OUT_OF_RANGE


def expected(d: Declaration, calls) -> dict[str, list[Status]]:
    """By operation: the worst status that the inputs of each call ask for."""
    asked: dict[str, list[Status]] = {}
    for call in calls:
        op = d.operation(call.operation)
        n_points = int(call.inputs.get("n_points", 0))
        each = [status_of_one(p, call.inputs[p.name], d, n_points) for p in op.inputs]
        worst = max(each, default=Status.OK) if op.returns_status else Status.OK
        asked.setdefault(op.name, []).append(worst)
    return asked


@of_each_variant
def test_edges_have_the_status_they_deserve(name):
    """Every edge of every input: the status is the worst that its inputs ask for, or worse still
    where the state has a say; outputs stay in their ranges."""
    declarations = package(VARIANTS[name]).declarations
    seen = set()
    for d in declarations:
        play = Play("edges", d.prefix, tuple(edge_calls(d)))
        asked = expected(d, play.calls)
        with np.errstate(over="ignore"):
            every = answers(declarations, [play], told(name, encode(declarations, [play])))
        assert misjudged(every) == []
        for a in every:
            for status, least in zip(a.statuses, asked[a.operation.name], strict=True):
                seen.add(Status(status))
                assert status >= least
                if least is Status.OK:  # what is in range is never called a bad input
                    bad = status in (Status.NOT_FINITE, Status.OUT_OF_RANGE)
                    assert not bad or d.kind.startswith("cascade")
    assert {Status.OK, Status.NOT_FINITE, Status.OUT_OF_RANGE, Status.NOT_READY} <= seen


def garbage(name: str, count: int) -> tuple[bytes, list[int]]:
    """Random bits, random numbers of any size, now and then a good reset; any order of calls."""
    v = VARIANTS[name]
    entries = entry_points(package(v).declarations)
    rng = np.random.default_rng(8)
    parts, numbers = [], []
    for _ in range(count):
        number = int(rng.integers(len(entries)))
        d, op = entries[number]
        numbers.append(number)
        parts.append(struct.pack("<ii", number, 1))
        values = np.zeros((), struct_layout(op.inputs, d))
        if op.inputs and rng.random() < 0.3:
            parts.append(rng.bytes(values.itemsize))
            continue
        size = 1.0 if op.name == "reset" else 10.0 ** rng.uniform(-3, 3)
        for port in op.inputs:
            if port.integer:
                values[port.name] = rng.integers(-2, v.points + 3)
                continue
            reach = min(float(port.high) * size, 1e30)
            values[port.name] = rng.uniform(-reach, reach, port.size or None)
        parts.append(values.tobytes() if op.inputs else b"")
    return b"".join(parts), numbers


@of_each_variant
def test_garbage_in_every_entry_point(name):
    stream, numbers = garbage(name, 4000)
    entries, data, offset = (
        entry_points(package(VARIANTS[name]).declarations),
        told(name, stream),
        0,
    )
    every = [Answers(d, op) for d, op in entries]
    for number in numbers:
        d, op = entries[number]
        size = struct_layout(op.outputs, d).itemsize
        every[number].statuses += struct.unpack_from("<i", data, offset)
        every[number].outputs.append(data[offset + 4 : offset + 4 + size])
        offset += 4 + size
    assert offset == len(data)
    assert misjudged(every) == []
    assert len({status for a in every for status in a.statuses}) >= 5


def test_the_check_passes_and_says_what_it_played(monkeypatch):
    monkeypatch.setattr(sanitizers, "STEPS", 10)
    monkeypatch.setattr(sanitizers, "PERIODS", 5)
    one = subject(VARIANTS["governor alone, M = 2"])
    finding = sanitizers.run(Bench("sane2", (one,)), Silent())
    assert finding.passed, finding.faults
    assert "own division" not in finding.summary  # this package does not divide
    for figures in finding.figures.values():
        assert figures["calls"] > 500
        assert set(figures["sequences"]) == {"sane2_governor", "sane2_follower", "sane2"}
        assert min(figures["sequences"].values()) >= 10


BASE = Variant("sown", horizon=0, precision="float32")


@pytest.mark.parametrize(
    ("file", "old", "new", "complaint"),
    [
        ("sown_follower.c", "in->points_x[i];", "in->points_x[i + 70000];", "out of bounds"),
        (
            "sown_follower.c",
            "self->done = self->done + 1;",
            "self->done = self->done + 1; self->waiting = self->waiting + 2147483647;",
            "signed integer overflow",
        ),
        ("sown_governor.c", "out->points_taken = taken;", "", "points_taken goes"),
    ],
)
def test_the_player_reports_what_is_planted(tmp_path, file, old, new, complaint):
    one = subject(BASE, changed(package(BASE), file, old, new))
    prefix = file.removesuffix(".c")
    plays = [p for p in one.suite(5) if p.prefix == prefix]
    faults = play_sanitized(one, plays, tmp_path / "player")
    assert faults
    assert complaint in " ".join(faults)


DIVIDES = Variant("sdiv", horizon=2, points=5, ramp=1, cap=12, precision="float32")


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("", "", ""),
        pytest.param(
            "image += half & lost;", "", "own division: sdiv_mpc", marks=pytest.mark.tools
        ),
        ("field << SG_SHIFT", "field << (SG_SHIFT + 41u)", "shift exponent"),
    ],
)
def test_the_own_division_is_played_too(tmp_path, old, new, complaint):
    (solver,) = (d for d in package(DIVIDES).declarations if d.kind == "mpc")
    made = changed(emit_package("sdiv", (solver,)), "sg_division.h", old, new)
    one = subject(DIVIDES, made)
    plays = [p for p in one.suite(100) if p.prefix == "sdiv_mpc"]
    told = " ".join(play_sanitized(one, plays, tmp_path / "player"))
    assert complaint in told
    assert bool(told) == bool(complaint)


def test_outputs_are_judged(tmp_path):
    d = package(BASE).declarations[0]
    op = d.operation("step")
    record = np.zeros((), struct_layout(op.outputs, d))
    good = Answers(d, op, [0], [record.tobytes()])
    assert misjudged([good]) == []
    assert "status 77" in misjudged([replace(good, statuses=[77])])[0]
    for value, complaint in ((np.nan, "not finite"), (0.41, "declared")):
        record["low_x"] = value
        assert complaint in misjudged([replace(good, outputs=[record.tobytes()])])[0]
    with pytest.raises(ValueError, match="fewer"):
        answers([d], [Play("edges", d.prefix, tuple(edge_calls(d)))], b"")
    assert play_sanitized(subject(BASE), [], tmp_path / "player") == ["no call to play"]


def test_a_controller_without_kept_sequences_fails(tmp_path):
    counts, faults = replay(subject(BASE), tmp_path / "replay", tmp_path, ["sown_governor"])
    assert counts == {"sown_governor": 0}
    assert len(faults) == 1
    assert "run make fuzz" in faults[0]
    missing = [tmp_path / "replay" / "fuzz_sown_governor", tmp_path / "missing"]
    assert run_tool(missing).returncode == 2
