"""A small project in a temporary folder, and the command line run in this process."""

from __future__ import annotations

import sys
import types
from collections.abc import Callable
from pathlib import Path

import pytest
from small_project import SMALL_TOML, FakeResult, Outcome, dxf, line

import servogen
from servogen.cli import main
from servogen.outputs import write_tree


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
    """A pipeline whose build judges the whole input and writes one file; other steps are set."""
    from servogen.project.physics import check_project

    def build(project: object, out: Path, progress: object) -> FakeResult:
        check_project(project)  # type: ignore[arg-type]
        write_tree(
            out, {"manifest.json": '{"schema": "servogen.manifest/1"}', "small.c": "int x;\n"}
        )
        return FakeResult()

    fake = types.SimpleNamespace(build=build)
    monkeypatch.setattr(servogen, "pipeline", fake, raising=False)
    monkeypatch.setitem(sys.modules, "servogen.pipeline", fake)  # type: ignore[arg-type]
    return fake
