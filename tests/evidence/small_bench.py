"""The small cascades of tests/sil on the bench that the checks work on."""

from __future__ import annotations

from dataclasses import replace

from core_designs import Variant, design, package
from core_loop import run, zigzag

from servogen.controllers.cascade import Cascade
from servogen.emit.package import CPackage
from servogen.evidence.bench import Bench, Subject
from servogen.precision import PRECISIONS
from servogen.sil.player import Play
from servogen.sil.recorder import Recorder
from servogen.sil.scenarios import suite

SEED = 11


def subject(v: Variant, made: CPackage | None = None) -> Subject:
    """A variant as a subject; ``made`` stands in for its package where a fault is planted."""

    def plays(count: int) -> list[Play]:
        return [
            Play(case.name, case.reference().declaration.prefix, tuple(case.calls))
            for case in suite(design(v), SEED, count)
        ]

    def loops(periods: int | None) -> list[Play]:
        recorder = Recorder(Cascade(design(v)))
        run(recorder, v, zigzag(seconds=0.6), periods or 60)
        return [recorder.play("closed loop")]

    return Subject(made or package(v), PRECISIONS[v.precision], None, plays, loops)


def bench(v: Variant) -> Bench:
    """The variant in both precisions, its own first."""
    other = "float32" if v.precision == "float64" else "float64"
    both = (v, replace(v, precision=other))
    return Bench(v.prefix, tuple(subject(each) for each in both))


def changed(made: CPackage, file: str, old: str, new: str) -> CPackage:
    """The package with one place of one file changed."""
    text = made.files[file]
    assert old in text, f"{old!r} is not in {file}"
    return replace(made, files={**made.files, file: text.replace(old, new, 1)})
