"""The bundled machining centre, two turns of its circle; and a part program of a corner."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import pytest

from servogen.progress import Silent
from servogen.project.contour_load import ContourProject, load_contour_project
from servogen.resources import resource_dir
from servogen.steps.contour import ContourSystem, prepare_contour
from servogen.steps.contour_run import ContourSimulation
from servogen.steps.contour_study import ContourStudyResult
from servogen.systems import contour_study

EXAMPLE = resource_dir("examples") / "contour_lq" / "servogen.toml"
PROGRAM = "G21 G90 G17\nG0 X0 Y0\nG1 X1 Y0 F2400\nG1 X1 Y0.5\nG3 X0.5 Y1 I-0.5 J0\nM2\n"
CURVE = 'kind = "circle"                         # or "butterfly"; or a drawing, in [path]\n'
CIRCLE = f"[contour]\n{CURVE}radius_m = 0.001\nfeed_m_per_s = 0.05                     # 3 m/min\n"
CIRCLE += "repetitions = 4\n"
DRAWN = '[path]\nfile = "corner.ngc"\n'
OUTPUT = ('terminal = "stationary"                 #', 'terminal = "output"                 #')
TABLE = ('form = "on_line"  ', 'form = "tabulated"')
SPACE = ("[sampling]", '[machine.z]\nsame_as = "x"\n\n[sampling]')


def contour_project(folder: Path, *changes: tuple[str, str]) -> ContourProject:
    """The example with two turns, and changed further."""
    text = EXAMPLE.read_text(encoding="utf-8")
    for old, new in (*changes, ("repetitions = 4", "repetitions = 2")):
        assert old in text or "repetitions" in old, old
        text = text.replace(old, new, 1)
    (folder / "corner.ngc").write_text(PROGRAM, encoding="utf-8")
    (folder / "servogen.toml").write_text(text, encoding="utf-8")
    return load_contour_project(folder / "servogen.toml")


def contour_system(*changes: tuple[str, str]) -> ContourSystem:
    return prepare_contour(contour_project(Path(mkdtemp(prefix="contour-")), *changes), Silent())


@cache
def small_system() -> ContourSystem:
    return contour_system()


@cache
def simulated() -> ContourSimulation:
    return small_system().simulate(None, Silent())


def shortened(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sweeps of three values each."""
    monkeypatch.setattr(contour_study, "PREVIEWS", (1, 4, 10))
    monkeypatch.setattr(contour_study, "CONTOUR_WEIGHTS", (0.0, 5.0, 20.0))


@cache
def compared() -> ContourStudyResult:
    with pytest.MonkeyPatch.context() as patch:
        shortened(patch)
        return small_system().study(Silent())
