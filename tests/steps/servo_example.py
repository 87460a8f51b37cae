"""The bundled servo drive, prepared, run and compared once, and variations of its file."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from servogen.progress import Silent
from servogen.project.servo_load import load_servo_project
from servogen.resources import resource_dir
from servogen.steps.servo_drive import ServoSystem, prepare_servo
from servogen.steps.servo_run import ServoSimulation, simulate
from servogen.steps.servo_study import ServoStudy

EXAMPLE = resource_dir("examples") / "servo_drive" / "servogen.toml"
TEXT = EXAMPLE.read_text(encoding="utf-8")


@cache
def example() -> ServoSystem:
    return prepare_servo(load_servo_project(EXAMPLE), Silent())


@cache
def simulated() -> ServoSimulation:
    own = example()
    return simulate(own.servo, own.parts, None, Silent())


@cache
def compared() -> ServoStudy:
    return example().study(Silent())


def changed(folder: Path, *pairs: tuple[str, str]) -> Path:
    """The example's file with places changed."""
    text = TEXT
    for old, new in pairs:
        assert old in text, old
        text = text.replace(old, new, 1)
    path = folder / "servogen.toml"
    path.write_text(text, encoding="utf-8")
    return path


def system(folder: Path, *pairs: tuple[str, str]) -> ServoSystem:
    return prepare_servo(load_servo_project(changed(folder, *pairs)), Silent())
