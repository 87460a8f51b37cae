"""A finding is tied to everything that it came from, not to the C alone."""

from __future__ import annotations

from pathlib import Path

import pytest

from servogen.project import load_project
from servogen.steps.check import origin_of
from servogen.wcet.targets import target_file


def digest(toml: Path) -> str:
    return origin_of(load_project(toml)).digest


def test_the_same_input_elsewhere_has_the_same_digest(small: Path, tmp_path: Path) -> None:
    other = tmp_path / "elsewhere"
    other.mkdir()
    for file in small.parent.iterdir():
        (other / file.name).write_bytes(file.read_bytes())
    assert digest(other / small.name) == digest(small)


@pytest.mark.parametrize("change", ["share", "target", "drawing"])
def test_what_the_c_may_not_show_is_seen(small: Path, change: str) -> None:
    own = small.parent / "own.toml"
    own.write_bytes(target_file("generic").read_bytes())
    small.write_text(small.read_text() + '[target]\nname = "own.toml"\nshare = 0.2\n')
    before = digest(small)
    match change:
        case "share":
            small.write_text(small.read_text().replace("share = 0.2", "share = 0.1"))
        case "target":
            own.write_text(own.read_text() + "# slower\n")
        case "drawing":
            drawing = small.parent / "line.dxf"
            drawing.write_text(drawing.read_text().replace("20", "21", 1))
    assert digest(small) != before


def test_the_date_is_what_the_builder_says(small: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    assert origin_of(load_project(small)).modified == "1970-01-02"
