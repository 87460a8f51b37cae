"""Templates are parsed once, and again when their file is another."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from servogen.emit import environment
from servogen.emit.environment import make_environment
from servogen.precision import FLOAT32, FLOAT64


def test_each_precision_has_its_own_numbers() -> None:
    text = "{{ 0.1 | real }}"
    single, double = (make_environment(p).from_string(text).render() for p in (FLOAT32, FLOAT64))
    assert single.endswith("f")
    assert not double.endswith("f")


def test_a_template_is_parsed_once_and_again_when_it_changes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(environment, "resource_dir", lambda name: tmp_path / name)
    (tmp_path / "templates").mkdir()
    file = tmp_path / "templates" / "a.jinja"
    file.write_text("one\n")
    first = make_environment(FLOAT64).get_template("a.jinja")
    assert first.render() == "one\n"
    assert make_environment(FLOAT64).get_template("a.jinja") is first
    file.write_text("two\n")
    os.utime(file, (0, 0))
    assert make_environment(FLOAT64).get_template("a.jinja").render() == "two\n"
