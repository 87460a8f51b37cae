"""The small command governor of the examples on the bench that the checks work on."""

from __future__ import annotations

from functools import cache

from servogen.evidence.bench import Bench
from servogen.evidence.coverage import STEPS, Covered, cover
from servogen.evidence.coverage_list import reviewed
from servogen.progress import Silent
from servogen.project.governor_load import load_governor_project
from servogen.resources import resource_dir
from servogen.steps.check import bench_of
from servogen.steps.prepare import prepare


@cache
def bench() -> Bench:
    """In both precisions, as ``servogen check`` has it."""
    place = resource_dir("examples") / "command_governor" / "small.toml"
    return bench_of(prepare(load_governor_project(place), Silent()))


@cache
def covered() -> Covered:
    """In float64, where rounding reaches least."""
    one = bench().subjects[0]
    return cover(one, [*one.suite(STEPS), *one.closed_loops(None)], reviewed())
