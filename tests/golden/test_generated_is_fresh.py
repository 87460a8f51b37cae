"""``generated/`` is what the present code makes of the bundled examples.

Tables pass through linear programs and LAPACK, whose last digits may differ between processors:
numbers are compared to 1e-9 of a table's largest entry, everything else byte for byte.
"""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from servogen.progress import Silent
from servogen.project.systems import load_any_project
from servogen.steps.prepare import prepare

ROOT = Path(__file__).parents[2]
GENERATED = ROOT / "generated"
SYSTEMS = ("two_stage", "servo_drive", "command_governor", "contour_lq")
NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[+-]?\d+)?f?(?![\w.])")
HASH = re.compile(r"\b(?=[0-9]*[a-f])[0-9a-f]{16,64}\b")
RELATIVE = 1e-9
HELP = "run 'make golden' and look at the diff of generated/"


Files = dict[str, str]


@pytest.fixture(scope="module")
def every() -> dict[str, Files]:
    projects = {name: ROOT / "examples" / name / "servogen.toml" for name in SYSTEMS}
    return {
        name: dict(prepare(load_any_project(file), Silent()).package.files)
        for name, file in projects.items()
    }


@pytest.fixture(scope="module")
def fresh(every: dict[str, Files]) -> Files:
    return every["two_stage"]


def _masked(block: str) -> str:
    head, mark, values = block.rpartition("=")
    return head + mark + NUMBER.sub("#", values)


def _blocks(text: str) -> list[tuple[str, list[float]]]:
    """Per table or line: its text without numbers and hashes, and its numbers."""
    masked = HASH.sub("HASH", text)
    blocks = []
    for block in re.split(r"(?<=;)\n", masked):
        values = re.sub(r"/\*.*?\*/", "", block, flags=re.DOTALL).rpartition("=")[2]
        numbers = [float(token.rstrip("f")) for token in NUMBER.findall(values)]
        blocks.append((re.sub(r"\s+", " ", block if not numbers else _masked(block)), numbers))
    return blocks


@pytest.mark.parametrize("system", SYSTEMS)
def test_same_files(every: dict[str, Files], system: str) -> None:
    folder = GENERATED / system
    committed = [p.relative_to(folder) for p in folder.rglob("*") if p.is_file()]
    assert sorted(path.as_posix() for path in committed) == sorted(every[system]), HELP


def _difference(name: str, committed: str, text: str) -> str | None:
    """What differs by more than the tolerance, or None."""
    old, new = _blocks(committed), _blocks(text)
    if [block for block, _ in old] != [block for block, _ in new]:
        return f"{name}: the text differs"
    for (block, before), (_, after) in zip(old, new, strict=True):
        scale = max((abs(v) for v in before), default=0.0)
        for a, b in zip(before, after, strict=True):
            if not abs(a - b) <= RELATIVE * scale:
                return f"{name}, {block[:60]}: {a} is {b}"
    return None


@pytest.mark.parametrize("system", SYSTEMS)
def test_same_text_and_numbers(every: dict[str, Files], system: str) -> None:
    for name, text in every[system].items():
        committed = (GENERATED / system / name).read_text(encoding="utf-8")
        if committed != text and name != "manifest.json":
            assert _difference(name, committed, text) is None, HELP


@pytest.mark.parametrize("system", SYSTEMS)
def test_same_manifest_but_for_hashes(every: dict[str, Files], system: str) -> None:
    def content(text: str) -> dict[str, object]:
        data: dict[str, object] = json.loads(HASH.sub("HASH", text))
        return data

    committed = (GENERATED / system / "manifest.json").read_text(encoding="utf-8")
    assert content(committed) == content(every[system]["manifest.json"]), HELP


@pytest.mark.parametrize(("factor", "seen"), [(1.0 + 1e-6, True), (1.0 + 1e-12, False)])
def test_the_comparison_sees_a_changed_entry(
    fresh: dict[str, str], factor: float, seen: bool
) -> None:
    name = "two_stage_mpc_tables.h"
    head, mark, table = fresh[name].partition("two_stage_mpc_columns[")
    entries = NUMBER.findall(table)[1:]
    largest = max(entries[:400], key=lambda text: abs(float(text)))
    changed = head + mark + table.replace(largest, repr(float(largest) * factor), 1)
    assert changed != fresh[name]
    assert (_difference(name, fresh[name], changed) is not None) == seen


def test_the_comparison_sees_changed_text(fresh: dict[str, str]) -> None:
    text = fresh["two_stage_mpc.c"]
    assert _difference("two_stage_mpc.c", text, text.replace("if (", "while (", 1)) is not None
