"""The player gives back what the reference says, call by call, and garbage streams are refused."""

from __future__ import annotations

import subprocess
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from core_designs import Variant, compiled, design, package, temporary_folder

from servogen.controllers.cascade import Cascade
from servogen.controllers.design import Status
from servogen.sil.compiled import CompiledController
from servogen.sil.player import Answer, Play, decode, differing, encode, player_source
from servogen.sil.recorder import Recorder
from servogen.sil.scenarios import suite

VARIANTS = {
    "float64": Variant(prefix="play", horizon=3, cap=30, points=30, ramp=10),
    "float32": Variant(prefix="playf", horizon=3, cap=30, points=30, ramp=10, precision="float32"),
}


@cache
def program(name: str) -> Path:
    made = package(VARIANTS[name])
    folder = temporary_folder("player")
    made.write(folder)
    (folder / "player.c").write_text(player_source(made.declarations))
    flags = ["-std=c99", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror", "-O1"]
    command = ["gcc", *flags, "player.c", *made.sources, "-o", "player"]
    subprocess.run(command, cwd=folder, check=True)
    return folder / "player"


def played(name: str, plays: list[Play]) -> list[Answer]:
    declarations = package(VARIANTS[name]).declarations
    done = subprocess.run(
        [program(name)], input=encode(declarations, plays), capture_output=True, check=True
    )
    return list(decode(declarations, plays, done.stdout))


@pytest.mark.parametrize("name", VARIANTS)
def test_answers_are_the_reference_s(name: str) -> None:
    cases = list(suite(design(VARIANTS[name]), 3, 8))
    plays = [Play(c.name, c.reference().declaration.prefix, tuple(c.calls)) for c in cases]
    answers = iter(played(name, plays))
    compared = 0
    for case in cases:
        reference = case.reference()
        for call in case.calls:
            status, outputs = reference.call(call.operation, call.inputs)
            answer = next(answers)
            assert (answer.play, answer.operation) == (case.name, call.operation)
            assert answer.status == status
            for port, value in outputs.items():
                assert answer.outputs is not None
                assert np.array_equal(answer.outputs[port], value), (case.name, answer.index, port)
                compared += 1
    assert compared > 100
    assert next(answers, None) is None


def test_a_recorded_controller_is_played_again_with_its_repeats() -> None:
    v = VARIANTS["float64"]
    recorder = Recorder(CompiledController(compiled(v, quick=True), Cascade(design(v)).declaration))
    window = np.zeros(30)
    recorder.call("reset", {"position_x": 0.01, "position_y": 0.0})
    recorder.repeat("fast_step", 4)
    inputs = {f"{a}_{n}": 0.0 for a in "xy" for n in ("position", "velocity", "acceleration")}
    points = {"points_x": window, "points_y": window, "n_points": 30}
    first = recorder.call("step", {**inputs, **points})
    window[:] = np.nan  # the caller may reuse her arrays
    answers = played("float64", [recorder.play("loop")])
    assert [a.operation for a in answers] == ["reset", *["fast_step"] * 4, "step"]
    assert answers[-1].status == first[0]


def test_every_play_starts_from_fresh_instances() -> None:
    v = VARIANTS["float64"]
    reset = next(c for c in suite(design(v), 3, 1) if c.name.endswith("edges"))
    prefix = reset.reference().declaration.prefix
    plays = [Play("a", prefix, tuple(reset.calls)), Play("b", prefix, tuple(reset.calls))]
    answers = played("float64", plays)
    half = len(answers) // 2
    assert half > 3
    for a, b in zip(answers[:half], answers[half:], strict=True):
        assert differing(a, b) is None


def test_differing_names_the_item_to_the_last_bit() -> None:
    kind = np.dtype([("x", float), ("n", np.int32)], align=True)
    first = Answer("p", 0, "c", "step", Status.OK, np.array((1.0, 2), kind)[()])

    def other(x: float, n: int, status: int = 0) -> Answer:
        return Answer("p", 0, "c", "step", status, np.array((x, n), kind)[()])

    assert differing(first, other(1.0, 2)) is None
    assert differing(first, other(np.nextafter(1.0, 2.0), 2)) == "x"
    assert differing(first, other(1.0, 3)) == "n"
    assert differing(first, other(1.0, 2, 1)) == "status"
    zero, minus = other(0.0, 2), other(-0.0, 2)
    assert differing(zero, minus) == "x"


def test_answers_too_few_or_too_many_are_refused() -> None:
    declarations = package(VARIANTS["float64"]).declarations
    case = next(iter(suite(design(VARIANTS["float64"]), 3, 1)))
    play = Play(case.name, case.reference().declaration.prefix, tuple(case.calls))
    told = subprocess.run(
        [program("float64")], input=encode(declarations, [play]), capture_output=True, check=True
    ).stdout
    with pytest.raises(ValueError, match="the answers end"):
        list(decode(declarations, [play], told[:-1]))
    with pytest.raises(ValueError, match="1 bytes more"):
        list(decode(declarations, [play], told + b"x"))
