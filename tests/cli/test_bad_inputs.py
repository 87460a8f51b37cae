"""Every kind of bad input: one sentence, status 2, nothing damaged."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from bad_inputs import ALL, Bad
from small_project import Outcome

Command = Callable[..., Outcome]


def contents(folder: Path) -> dict[str, bytes | None]:
    """Everything below a folder."""
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None
        for path in folder.rglob("*")
    }


def test_the_small_project_is_a_good_one(
    small: Path, servogen_command: Command, fake_pipeline: object
) -> None:
    outcome = servogen_command("build", small)
    assert (outcome.status, outcome.err) == (0, "")
    assert (small.parent / "build" / "small.c").is_file()
    before = contents(small.parent)
    again = servogen_command("build", small, "-o", small.parent / "build")
    assert again.status == 0
    assert contents(small.parent) == before  # replaced by the same bytes


def test_there_are_at_least_45_kinds() -> None:
    assert len({bad.name for bad in ALL}) == len(ALL) >= 45


@pytest.mark.parametrize("bad", ALL, ids=[bad.name for bad in ALL])
def test_bad_input_is_one_sentence_and_damages_nothing(
    bad: Bad, small: Path, servogen_command: Command, fake_pipeline: object
) -> None:
    out = small.parent / "out"
    out.mkdir()
    (out / "manifest.json").write_text('{"schema": "servogen.manifest/1"}')
    (out / "small.c").write_text("int old;\n")
    bad.change(small)
    before = contents(small.parent)

    outcome = servogen_command("build", small, "-o", out)

    assert outcome.status == 2, outcome
    assert outcome.out == ""
    assert outcome.err.count("\n") == 1
    assert outcome.err.endswith("\n")
    where = outcome.err.removeprefix("servogen: ").split(": ")[0]
    assert where == str(small.parent / bad.file)
    for fragment in bad.says:
        assert fragment in outcome.err
    counted = any("more wrong" in fragment for fragment in bad.says)
    assert ("more wrong" in outcome.err) == counted  # one mistake is told as one
    for junk in ("Traceback", "pydantic", "PosixPath", "\x1b"):
        assert junk not in outcome.err
    assert contents(small.parent) == before
