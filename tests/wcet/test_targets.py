"""Target files: what they hold and what is wrong with them."""

from __future__ import annotations

from pathlib import Path

import pytest

from servogen.errors import InputError
from servogen.wcet.operations import CLASSES, OperationCounts
from servogen.wcet.targets import (
    COMMON_CLASSES,
    REAL_CLASSES,
    Target,
    bundled_targets,
    load_target,
)


def target_text(add: str = "2", float64: bool = True) -> str:
    def table(name: str, classes: tuple[str, ...]) -> str:
        rows = "".join(f'{c} = {{ value = 1, source = "estimate" }}\n' for c in classes)
        return f"[cycles.{name}]\n{rows}"

    text = (
        'name = "mine"\ndescription = "a board"\n'
        'clock_hz = { value = 1e6, source = "crystal" }\n'
        "[memory]\n"
        'data_bytes = { value = 1000, source = "x" }\n'
        'program_bytes = { value = 10, source = "x" }\n'
    ) + table("common", COMMON_CLASSES)
    text += table("float32", REAL_CLASSES).replace("add = { value = 1", f"add = {{ value = {add}")
    return text + (table("float64", REAL_CLASSES) if float64 else "")


@pytest.fixture
def mine(tmp_path: Path) -> Target:
    (tmp_path / "mine.toml").write_text(target_text(), encoding="utf-8")
    return load_target("mine.toml", tmp_path)


def test_bundled_targets_are_complete() -> None:
    assert {"tms320c6678", "tms320vc33", "f28379d", "cortex_m4f", "cortex_m7", "generic"} <= set(
        bundled_targets()
    )
    for name in bundled_targets():
        target = load_target(name)
        assert target.name == name
        for table in target.cycles.values():
            assert set(table) == set(CLASSES)
            assert all(number.source for number in table.values())


def test_a_target_without_the_precision() -> None:
    with pytest.raises(InputError, match=r"output\.precision is float64, expected 'float32'"):
        load_target("tms320vc33").cost(OperationCounts(add=1), "float64")


def test_one_memory_for_data_and_tables() -> None:
    one = load_target("tms320vc33").together_bytes
    assert one is not None
    assert one.value == load_target("tms320vc33").data_bytes.value
    assert load_target("generic").together_bytes is None


def test_cost_is_the_weighted_sum(mine: Target) -> None:
    counts = OperationCounts(add=10, mul=3, branch=4)
    assert mine.cost(counts, "float32") == 2 * 10 + 3 + 4
    assert mine.cost(counts, "float64") == 10 + 3 + 4


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("clock_hz = { value = 1e6", "clock_hz = { value = 0", "clock_hz.value is 0"),
        ("clock_hz = { value = 1e6", "clock_hz = { value = nan", "clock_hz.value is nan"),
        ("[memory]", "int_bits = { value = 0, source = 'x' }\n[memory]", "int_bits.value is 0"),
        ("clock_hz =", "clock =", "clock is unknown, expected one of name"),
        ('source = "crystal"', 'source = ""', "clock_hz.source is missing"),
        ("sqrt = { value = 1", 'sqrt = { value = "1"', "cycles.float32.sqrt.value is 1, expected"),
        ("sqrt = { value = 1", "sqrt = { value = -1", "cycles.float32.sqrt.value is -1"),
        ("sqrt = { value = 1", "sqrt = { value = true", "cycles.float32.sqrt.value is True"),
        ("call = {", "cal = {", "cycles.common.cal is unknown"),
        ("call = {", "#", "cycles.common.call is missing, expected a table"),
        (
            "[memory]",
            '[memory]\ntogether_bytes = { value = 0, source = "x" }',
            "memory.together_bytes.value is 0",
        ),
        ("[memory]", "[memo]", "memo is unknown"),
        ('name = "mine"', "name = 3", "name is 3, expected some text"),
        ("[cycles.float32]", "[cycles.float16]", "cycles.float16 is unknown"),
        ("[memory]", "[memory", "expected TOML"),
    ],
)
def test_wrong_target_files(tmp_path: Path, old: str, new: str, message: str) -> None:
    path = tmp_path / "bad.toml"
    assert old in target_text()
    path.write_text(target_text().replace(old, new), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_target(path)
    assert message in str(caught.value)
    assert str(path) in str(caught.value)


def test_unknown_target(tmp_path: Path) -> None:
    for name in ("pdp11", "none.toml", "../targets/generic"):
        with pytest.raises(InputError, match=r"target\.name is .*, expected one of cortex_m4f"):
            load_target(name, tmp_path)
