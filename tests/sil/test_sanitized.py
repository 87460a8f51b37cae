"""The C under the address and undefined-behaviour sanitizers, given anything at all: a status, a
bounded output, nothing undefined."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import c_driver
import numpy as np
import pytest
from c_driver import build, driver_source, entry_points, layout, play
from core_designs import Variant, design, package

from servogen.controllers.design import Declaration, Operation, Port, Status
from servogen.controllers.tracking_mpc import POSITION_FACTOR
from servogen.sil.edges import edge_calls
from servogen.sil.random_calls import random_calls

VARIANTS = {
    "float64": Variant("sane64", horizon=5, cap=12),
    "float32, fourth order, axes differ": Variant(
        "sane32", horizon=3, cap=7, precision="float32", order=4, differing=True
    ),
    "governor alone": Variant("sane0", horizon=0, ramp=0),
    "float32, governor alone, M = 2": Variant(
        "sane2", horizon=0, points=2, ramp=0, precision="float32"
    ),
}


@cache
def program(name: str) -> Path:
    return build(VARIANTS[name])


def pack(d: Declaration, op: Operation, inputs) -> bytes:
    if not op.inputs:
        return b""
    values = np.zeros((), layout(op.inputs, d))
    with np.errstate(over="ignore"):
        for port in op.inputs:
            values[port.name] = inputs[port.name]
    return values.tobytes()


def output_limit(port: Port, v: Variant, kind: str) -> float:
    """Largest magnitude that an output may have, whatever came in."""
    made = design(v)
    limits = made.governor.limits[1 if port.name.endswith("_y") else 0]
    widest = max(lim.position_m for lim in made.governor.limits)
    if port.name.startswith("command"):
        return 1.2 * limits.fast_range_m if kind == "fast" else POSITION_FACTOR * widest
    if port.name == "along":
        return float(v.points)
    if port.name.startswith(("reference", "low", "high")):
        return widest
    return float("inf")  # predicted states: finite, no more is declared


def check_outputs(found, entries, calls, v: Variant) -> None:
    for (number, _), (status, values) in zip(calls, found, strict=True):
        d, op = entries[number]
        assert status in Status.__members__.values()
        for port in op.outputs:
            value = float(values[port.name])
            assert np.isfinite(value), f"{d.prefix}_{op.name}: {port.name} is {value}"
            if port.integer:
                assert 0 <= value <= 10**6
                continue
            fast = d.kind == "fast" or op.name == "fast_step"
            limit = output_limit(port, v, "fast" if fast else d.kind)
            assert abs(value) <= limit * (1 + 1e-6), f"{d.prefix}_{op.name}: {port.name} = {value}"


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


@pytest.mark.parametrize("name", VARIANTS)
def test_edges_have_the_status_they_deserve(name):
    """Every edge of every input: the status is the worst that its inputs ask for, or worse still
    where the state has a say; commands stay bounded."""
    v = VARIANTS[name]
    made = package(v)
    entries = entry_points(made.declarations)
    seen = set()
    for d in made.declarations:
        numbers = {op.name: i for i, (own, op) in enumerate(entries) if own is d}
        calls, expected = [], []
        for call in edge_calls(d):
            op = d.operation(call.operation)
            calls.append((numbers[op.name], pack(d, op, call.inputs)))
            n_points = int(call.inputs.get("n_points", 0))
            asked = [status_of_one(p, call.inputs[p.name], d, n_points) for p in op.inputs]
            expected.append(max(asked, default=Status.OK) if op.returns_status else Status.OK)
        found = play(program(name), v, calls)
        check_outputs(found, entries, calls, v)
        for (status, _), least in zip(found, expected, strict=True):
            seen.add(Status(status))
            assert status >= least
            if least is Status.OK:  # what is in range is never called a bad input
                assert status not in (Status.NOT_FINITE, Status.OUT_OF_RANGE) or d.kind.startswith(
                    "cascade"
                )
    assert {Status.OK, Status.NOT_FINITE, Status.OUT_OF_RANGE, Status.NOT_READY} <= seen


@pytest.mark.parametrize("name", VARIANTS)
def test_garbage_in_every_entry_point(name):
    """Random bits, random numbers of any size, now and then a good reset; any order of calls."""
    v = VARIANTS[name]
    entries = entry_points(package(v).declarations)
    rng = np.random.default_rng(8)
    calls = []
    for _ in range(4000):
        number = int(rng.integers(len(entries)))
        d, op = entries[number]
        if not op.inputs:
            calls.append((number, b""))
            continue
        kind = layout(op.inputs, d)
        if rng.random() < 0.3:
            calls.append((number, rng.bytes(kind.itemsize)))
            continue
        values = np.zeros((), kind)
        size = 1.0 if op.name == "reset" else 10.0 ** rng.uniform(-3, 3)
        for port in op.inputs:
            if port.integer:
                values[port.name] = rng.integers(-2, v.points + 3)
                continue
            reach = min(float(port.high) * size, 1e30)
            values[port.name] = rng.uniform(-reach, reach, port.size or None)
        calls.append((number, values.tobytes()))
    found = play(program(name), v, calls)
    check_outputs(found, entries, calls, v)
    assert len({status for status, _ in found}) >= 5


@pytest.mark.parametrize("name", VARIANTS)
def test_random_work_is_clean_and_bounded(name):
    v = VARIANTS[name]
    made, whole = package(v), design(v)
    entries = entry_points(made.declarations)
    parts = [whole.governor, *(whole.mpc or ())[: 2 if v.differing else 1], whole.fast, whole]
    for part in parts:
        d = next(x for x in made.declarations if x.prefix == part.prefix)
        numbers = {op.name: i for i, (own, op) in enumerate(entries) if own is d}
        calls = [
            (numbers[c.operation], pack(d, d.operation(c.operation), c.inputs))
            for c in random_calls(part, 4, 25)
        ]
        check_outputs(play(program(name), v, calls), entries, calls, v)


def test_the_driver_and_the_sanitizers_work():
    """A seeded overflow and a seeded signed overflow are both reported."""
    v = VARIANTS["governor alone"]
    made = package(v)
    source = driver_source(made.declarations)
    assert all(f"{d.prefix}_{op.name}(" in source for d, op in entry_points(made.declarations))
    changes = {
        "out of bounds": ("in->points_x[i];", "in->points_x[i + 70000];"),
        "signed integer overflow": (
            "self->done = self->done + 1;",
            "self->done = self->done + 1; self->waiting = self->waiting + 2147483647;",
        ),
    }
    for report, (old, new) in changes.items():
        text = made.files["sane0_follower.c"]
        assert old in text
        folder = c_driver.temporary_folder("seeded")
        for file, content in made.files.items():
            (folder / file).write_text(content)
        (folder / "sane0_follower.c").write_text(text.replace(old, new))
        (folder / "main.c").write_text(source)
        c_driver.subprocess.run(
            ["gcc", "-std=c99", *c_driver.SANITIZERS, "main.c", *made.sources, "-o", "driver"],
            cwd=folder,
            check=True,
        )
        d = next(x for x in made.declarations if x.kind == "fast")
        entries = entry_points(made.declarations)
        numbers = {op.name: i for i, (own, op) in enumerate(entries) if own is d}
        calls = [
            (numbers[c.operation], pack(d, d.operation(c.operation), c.inputs))
            for c in random_calls(design(v).fast, 4, 5)
        ]
        with pytest.raises(AssertionError, match=report):
            play(folder / "driver", v, calls)
