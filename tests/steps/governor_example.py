"""A small machine under a command governor: a short register, few points, two figures."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import mkdtemp

from servogen.progress import Silent
from servogen.project.governor_load import GovernorProject, load_governor_project
from servogen.resources import resource_dir
from servogen.steps.governor import GovernorSystem, prepare_governor
from servogen.steps.governor_run import GovernorSimulation
from servogen.steps.governor_study import GovernorStudyResult

EXAMPLE = resource_dir("examples") / "command_governor" / "servogen.toml"
SVG = """\
<svg xmlns="http://www.w3.org/2000/svg" width="250mm" height="250mm" viewBox="0 -250 250 250">
<ellipse id="one" cx="40" cy="-60" rx="20" ry="14"/>
<circle id="two" cx="110" cy="-100" r="18"/>
</svg>
"""
SMALL = (
    ("figures.svg", "two.svg"),
    ("fast_sample_time_s = 0.0000712", "fast_sample_time_s = 0.000712"),
    ("horizon = 40", "horizon = 8"),
    ("points_ahead = 8000 ", "points_ahead = 300  "),
    ('iteration_cap = "target"', "iteration_cap = 150    "),
    ("feed_m_per_s = 0.8\n", "feed_m_per_s = 0.3\n"),
    ("tolerance_m = 1e-5", "tolerance_m = 1e-4"),
)


def small_project(folder: Path, *changes: tuple[str, str], drawing: str = SVG) -> GovernorProject:
    """The example made small, and changed further."""
    text = EXAMPLE.read_text(encoding="utf-8")
    for old, new in (*SMALL, *changes):
        assert old in text, old
        text = text.replace(old, new, 1)
    (folder / "two.svg").write_text(drawing, encoding="utf-8")
    (folder / "servogen.toml").write_text(text, encoding="utf-8")
    return load_governor_project(folder / "servogen.toml")


@cache
def small_system() -> GovernorSystem:
    return prepare_governor(small_project(Path(mkdtemp(prefix="governor-"))), Silent())


@cache
def simulated() -> GovernorSimulation:
    return small_system().simulate(None, Silent())


@cache
def compared() -> GovernorStudyResult:
    return small_system().study(Silent())
