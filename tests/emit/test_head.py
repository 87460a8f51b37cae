"""The head of an emitted file states the counts of that very file."""

from __future__ import annotations

import re
from functools import cache

import pytest
from core_designs import Variant, design

from servogen.controllers.cascade_design import declare_parts
from servogen.emit.package import CPackage, emit_package
from servogen.steps.counted import count_emitted, emit_counted
from servogen.wcet.operations import OperationCounts
from servogen.wcet.package import Count, PackageCount

SMALL = Variant(prefix="small", horizon=3, cap=12, points=10, ramp=3, differing=True)


@cache
def stamped() -> tuple[CPackage, PackageCount]:
    return emit_counted("small", declare_parts(design(SMALL)))


def head(text: str) -> str:
    return text[: text.index("#include")]


def row(text: str, label: str) -> list[int]:
    """The numbers behind a label at the start of a line of the head."""
    (found,) = re.findall(rf"^ \* {re.escape(label)}((?: +\d+)+)$", head(text), re.MULTILINE)
    return [int(number) for number in found.split()]


def arithmetic(counts: OperationCounts) -> list[int]:
    other = counts.neg + counts.sqrt + counts.convert + counts.other_fp
    return [counts.add, counts.mul, counts.div, counts.cmp, other, counts.load, counts.store]


def test_the_shipped_file_counts_what_its_head_says() -> None:
    package, _ = stamped()
    again = count_emitted(package)
    rows = 0
    for d in package.declarations:
        text = package.files[f"{d.prefix}.c"]
        for name in ("init", *(op.name for op in d.operations)):
            count: Count = again.entry_points[f"{d.prefix}_{name}"]
            shown = row(text, f"{d.prefix}_{name}")
            assert shown == [*arithmetic(count.total()), count.stack_bytes]
            rows += 1
            for cap, part in count.per_iteration.items():
                assert f"  each of {count.caps[cap]} {cap} " in head(text)
                assert arithmetic(part) in [
                    [int(n) for n in found.split()]
                    for found in re.findall(rf"{cap}((?: +\d+)+)$", head(text), re.MULTILINE)
                ]
        assert f"tables of this file: {again.source_table_bytes[f'{d.prefix}.c']} bytes" in text
        assert again.source_table_bytes[f"{d.prefix}.c"] == d.table_bytes
    assert rows == len(again.entry_points)


def test_the_counts_are_those_that_servogen_tells() -> None:
    package, counts = stamped()
    assert count_emitted(package) == counts


def test_only_heads_and_hashes_differ_from_an_uncounted_package() -> None:
    package, _ = stamped()
    plain = emit_package("small", declare_parts(design(SMALL)))
    assert plain.hash == package.hash
    assert list(plain.files) == list(package.files)
    for name, text in package.files.items():
        if name in package.sources:
            assert "worst case of one call" in head(text)
            assert "worst case of one call" not in plain.files[name]
            assert plain.files[name].partition("#include")[2] == text.partition("#include")[2]
        elif name != "manifest.json":
            assert plain.files[name] == text


def test_no_line_of_a_head_is_wide() -> None:
    package, _ = stamped()
    for name in package.sources:
        assert max(len(line) for line in head(package.files[name]).splitlines()) <= 120


def test_an_entry_point_that_was_not_counted() -> None:
    package, counts = stamped()
    less = {n: c for n, c in counts.entry_points.items() if n != "small_plan"}
    wrong = PackageCount(counts.precision, less, counts.table_bytes, counts.source_table_bytes)
    with pytest.raises(KeyError):
        emit_package("small", package.declarations, wrong)
