"""The contour controllers of tests/sil on the bench that the checks work on."""

from __future__ import annotations

from functools import cache

from contour_designs import AXES, made, package

from servogen.controllers.contour_lq import ContourLq
from servogen.emit.package import CPackage
from servogen.evidence.bench import Bench, Subject
from servogen.evidence.coverage import STEPS, Covered, cover
from servogen.evidence.coverage_list import reviewed
from servogen.plants.machining_centre import SAMPLE_TIME_S
from servogen.sil.contour_scenarios import contour_suite
from servogen.sil.player import Play
from servogen.sil.recorder import Recorder
from servogen.steps.counted import count_emitted
from servogen.systems.contour_loop import run_contour
from servogen.systems.contour_motion import circle

SEED = 11
# Between them they make every line of the templates.
FORMS = ("II 64", "IV 32", "I 64", "table")


def loop(name: str, samples: int) -> list[Play]:
    """The reference on the paper's circle, by the state and by the encoders."""
    motion, plays = circle(1e-3, 0.05, SAMPLE_TIME_S, samples + 20), []
    for encoder_m in (None, 0.8e-6):
        recorder = Recorder(ContourLq(made(name)))
        run_contour(made(name), recorder, AXES, motion, samples, encoder_m)
        plays.append(recorder.play("by the encoders" if encoder_m else "by the state"))
    return plays


def subject(name: str, given: CPackage | None = None) -> Subject:
    """A controller as a subject; ``given`` stands in for its package where a fault is planted."""

    def plays(count: int) -> list[Play]:
        return [
            Play(case.name, case.reference().declaration.prefix, tuple(case.calls))
            for case in contour_suite(made(name), SEED, count)
        ]

    own = package(name)
    return Subject(
        given or own, made(name).precision, count_emitted(own), plays,
        lambda samples: loop(name, samples or 300),
    )  # fmt: skip


@cache
def covered(name: str) -> Covered:
    """What the suite and the closed loop reach of one of ``FORMS``."""
    one = subject(name)
    return cover(one, [*one.suite(STEPS), *one.closed_loops(None)], reviewed())


def on_bench(name: str) -> Bench:
    """One of them alone."""
    return Bench(name, (subject(name),))
