"""A small project in a temporary folder, and the command line run in this process."""

from __future__ import annotations

import sys
import types
from collections.abc import Callable
from pathlib import Path

import pytest
from small_project import SMALL_TOML, Outcome, dxf, line

import servogen
from servogen.cli import main


@pytest.fixture
def small(tmp_path: Path) -> Path:
    """The project file of a small machine with a straight line to draw."""
    folder = tmp_path / "small"
    folder.mkdir()
    (folder / "line.dxf").write_text(dxf(line(0, 0, 20, 10)))
    toml = folder / "servogen.toml"
    toml.write_text(SMALL_TOML)
    return toml


@pytest.fixture
def servogen_command(capsys: pytest.CaptureFixture[str]) -> Callable[..., Outcome]:
    """Run ``servogen`` with these arguments."""

    def run(*arguments: object) -> Outcome:
        capsys.readouterr()
        status = main([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        return Outcome(status, captured.out, captured.err)

    return run


@pytest.fixture
def fake_pipeline(monkeypatch: pytest.MonkeyPatch) -> types.SimpleNamespace:
    """A pipeline whose build is the real one; the other steps are set by the tests."""
    from servogen.steps.build import build
    from servogen.steps.prepare import prepare

    fake = types.SimpleNamespace(
        build=lambda project, out, progress: build(prepare(project, progress), out)
    )
    monkeypatch.setattr(servogen, "pipeline", fake, raising=False)
    monkeypatch.setitem(sys.modules, "servogen.pipeline", fake)  # type: ignore[arg-type]
    return fake
