"""Processor in the loop: what is compared, and that planted differences are found and named.

The tests that run an emulated processor are skipped where it is not installed; ``make pil`` is not.
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from core_designs import Variant, design, package, temporary_folder

from servogen.errors import CheckFailed
from servogen.evidence.bench import Bench, Subject
from servogen.evidence.pil import examine, finding_of
from servogen.evidence.pil_build import CORES, Core, build_plugin, build_target, tool_versions
from servogen.evidence.pil_counts import compare_all, compare_counts
from servogen.evidence.pil_levels import play_levels, unequal_counts
from servogen.evidence.pil_map import ARITHMETIC, COLUMNS, address_map, operations_of
from servogen.evidence.pil_run import play_board
from servogen.evidence.pil_stand import Stand, calls_in, cut_plays, make_stand, within
from servogen.evidence.same_bits import first_difference
from servogen.evidence.tools import ToolMissing
from servogen.precision import PRECISIONS
from servogen.sil.harness import Call
from servogen.sil.player import Play, encode
from servogen.sil.scenarios import suite
from servogen.wcet.operations import CLASSES, OperationCounts
from servogen.wcet.package import count_package

M4, M7 = CORES


@pytest.fixture(scope="session")
def board() -> None:
    """The tools that an emulated processor wants."""
    try:
        tool_versions()
    except ToolMissing as error:
        pytest.skip(str(error))


def on_board(test: Callable[..., None]) -> Callable[..., None]:
    """Wants the tools; all such tests on one worker, which builds what they share once."""
    grouped = pytest.mark.xdist_group("pil")(test)
    return pytest.mark.tools(pytest.mark.usefixtures("board")(grouped))


MARKS = "00000010 T sg_player_begin\n00000014 T sg_player_end\n"


# -- what an instruction is ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("mnemonic", "columns"),
    [
        ("vmul", ("mul",)),
        ("vmls", ("mul", "add")),
        ("vmlseq", ("mul", "add")),
        ("vmulgt", ("mul",)),
        ("vcmple", ("cmp",)),
        ("vnmla", ("mul", "add", "neg")),
        ("vfma", ("fused",)),
        ("vselgt", ("move",)),
        ("vqadd", None),
    ],
)
def test_mnemonics(mnemonic: str, columns: tuple[str, ...] | None) -> None:
    assert operations_of(mnemonic) == columns


def test_a_listing_becomes_addresses_and_data_in_it_do_not() -> None:
    listing = (
        "00000020 <f>:\n"
        "      20:\tvmul.f32\ts0, s0, s1\n"
        "      24:\tbx\tlr\n"
        "      26:\tvnmul.f64\td0, d1, d2\n"
        "      2c:\t3f 80 00 00 76 6d 75 6c                             ?...vmul\n"
        "      30:\tvmrs\tAPSR_nzcv, fpscr\n"
    )
    found = address_map(listing, MARKS)
    assert found.entries == ((0x20, "mul"), (0x26, "mul"), (0x26, "neg"), (0x30, "move"))
    assert (found.begin, found.end) == (0x10, 0x14)
    assert found.text().splitlines()[0] == f"20 {COLUMNS.index('mul'):x}"
    assert not found.software


def test_software_arithmetic_is_known_by_its_functions() -> None:
    symbols = MARKS + "00000100 T __aeabi_dsub\n00000104 T __aeabi_dadd\n00000200 T __aeabi_dmul\n"
    found = address_map("", symbols)
    assert found.entries == ((0x104, "add"), (0x200, "mul"))
    assert found.software == {"add", "mul"}
    with pytest.raises(CheckFailed, match="does not fall into"):
        address_map("", symbols.replace("00000100", "00000300"))


def test_an_unknown_instruction_and_a_program_without_marks_are_refused() -> None:
    with pytest.raises(CheckFailed, match=r"vqadd at 20 stands in no class"):
        address_map("  20:\tvqadd.s8\td0, d1, d2\n", MARKS)
    with pytest.raises(CheckFailed, match="no sg_player_end"):
        address_map("", MARKS.splitlines()[0])


# -- counts -------------------------------------------------------------------------------------


def counted(calls: int = 3, **operations: int) -> np.ndarray:
    rows = np.zeros((calls, len(CLASSES)), np.uint64)
    for name, number in operations.items():
        rows[:, CLASSES.index(name)] = number
    return rows


def executed(calls: int = 3, **instructions: int) -> np.ndarray:
    rows = np.zeros((calls, len(COLUMNS)), np.uint64)
    for name, number in instructions.items():
        rows[:, COLUMNS.index(name)] = number
    return rows


STATIC = OperationCounts(add=4, mul=5, load=10)


def test_equal_counts_pass_and_are_told() -> None:
    point, faults = compare_counts(
        "f", counted(add=4, mul=5, load=9), executed(add=4, mul=5, total=56), STATIC, 2.5
    )
    assert not faults
    assert point.straight
    assert (point.calls, point.instructions, point.operations, point.factor) == (3, 56, 19, 2.0)
    assert point.to_json()["executed"] == {"add": 4, "mul": 5}


@pytest.mark.parametrize(
    ("ours", "theirs", "said"),
    [
        (
            {"add": 4, "mul": 5},
            {"add": 4, "mul": 6},
            "6 div + mul executed in one call, the C has 5",
        ),
        (
            {"add": 4, "mul": 5},
            {"add": 4, "mul": 4},
            "8 div + mul + add executed in one call of straight",
        ),
        ({"add": 4, "mul": 6}, {"add": 4, "mul": 6}, "counted 6 mul, the static count is 5"),
        (
            {"add": 3, "mul": 5},
            {"add": 4, "mul": 5},
            "9 div + mul + add executed in one call, the C has 8",
        ),
        ({"add": 4, "mul": 5}, {"add": 4, "mul": 5, "fused": 1}, "1 fused"),
        ({"add": 4, "mul": 5}, {"add": 4, "mul": 5, "cmp": 1}, "1 cmp executed"),
        ({"add": 4, "mul": 5}, {"add": 4, "mul": 5, "total": 48}, "3.11 instructions for each"),
    ],
)
def test_what_is_wrong_with_counts_is_said(
    ours: dict[str, int], theirs: dict[str, int], said: str
) -> None:
    _, faults = compare_counts("f", counted(**ours), executed(**theirs), STATIC, 3.0)
    assert any(said in fault for fault in faults), faults


def test_a_product_with_two_may_be_an_addition_but_not_in_a_kernel() -> None:
    ours, theirs = counted(add=4, mul=5), executed(add=6, mul=3)
    assert compare_counts("f", ours, theirs, STATIC, 3.0)[1] == []
    _, faults = compare_counts("f", ours, theirs, STATIC, 3.0, each=True)
    assert faults[0] == "f: 6 add executed in one call, the C has 4"
    assert "3 mul executed in one call of straight-line code" in faults[1]
    _, faults = compare_counts("f", ours, executed(add=3, mul=6), STATIC, 3.0)
    assert faults == ["f: 6 div + mul executed in one call, the C has 5"]


def test_where_the_data_decide_fewer_instructions_are_no_fault() -> None:
    ours, theirs = counted(add=4, mul=5), executed(add=4, mul=3)
    ours[0, CLASSES.index("mul")] = 3
    point, faults = compare_counts("f", ours, theirs, STATIC, 3.0)
    assert not faults
    assert not point.straight


def test_nothing_played_or_nothing_exact_is_a_fault() -> None:
    which, static = np.zeros(3, int), {"f": STATIC, "g": STATIC}
    whole = counted(add=4, mul=5), executed(add=4, mul=5)
    _, faults = compare_all(["f", "g"], which, *whole, static, 3.0)
    assert faults == ["g was never called"]
    _, faults = compare_all(["f"], which, whole[0], whole[1][:2], static, 3.0)
    assert "2 on the board" in faults[0]
    _, faults = compare_all(["f"], which, counted(add=3), executed(add=3), static, 3.0)
    assert faults == ["no straight-line entry point with arithmetic: nothing was held to equality"]


def test_a_budget_keeps_short_plays_whole_and_cuts_the_long_ones() -> None:
    def play(name: str, repeats: tuple[int, ...]) -> Play:
        return Play(name, "p", tuple(Call("f", {}) for _ in repeats), repeats)

    plays = [play("long", (10, 10, 10, 10)), play("short", (2,)), play("other", (30,))]
    costs = [np.full(40, 5), np.full(2, 5), np.full(30, 5)]
    kept = cut_plays(plays, costs, 200)
    assert [calls_in(p) for p in kept] == [30, 2, 0]  # the only call of "other" is 30 times
    assert cut_plays(plays, costs, 360) == plays


# -- bits ---------------------------------------------------------------------------------------

SMALL = {
    name: Variant(prefix="pil", precision=name, horizon=2, points=4, ramp=1, cap=12)
    for name in PRECISIONS
}


@cache
def subject(precision: str) -> Subject:
    variant, folder = SMALL[precision], temporary_folder("pil")
    made = package(variant)
    made.write(folder)
    names = [f"{d.prefix}_{op.name}" for d in made.declarations for op in d.operations]
    counts = count_package([folder / s for s in made.sources], [folder], names)

    def plays(count: int) -> list[Play]:
        return [
            Play(c.name, c.reference().declaration.prefix, tuple(c.calls))
            for c in suite(design(variant), 7, count)
        ]

    return Subject(made, PRECISIONS[precision], counts, plays, lambda _: plays(3)[-1:])


def test_the_first_differing_bit_is_named_with_both_values() -> None:
    declarations = package(SMALL["float64"]).declarations
    last = declarations[-1]
    zeros = {port.name: 0.0 for port in last.operation("predict").inputs}
    plays = [Play("dry", "pil", (Call("predict", zeros), Call("fast_step", {})), (1, 3))]
    assert len(encode(declarations, plays)) == 3 * 8 + 8 * len(zeros)
    size = {op.name: sum(8 * (p.size or 1) for p in op.outputs) for op in last.operations}
    told = bytes(4 + size["predict"] + 3 * (4 + size["fast_step"]))
    assert first_difference(declarations, plays, told, told) is None
    other = bytearray(told)
    place = 4 + size["predict"] + (4 + size["fast_step"]) + 4
    other[place + 7] = 0x80  # the sign of the first output of the third call: -0 for 0
    item = last.operation("fast_step").outputs[0].name
    said = first_difference(declarations, plays, told, bytes(other))
    assert said == f"dry, call 2, pil_fast_step: {item} is -0x0.0p+0 instead of 0x0.0p+0"
    other[0] = 6
    said = first_difference(declarations, plays, told, bytes(other))
    assert said == "dry, call 0, pil_predict: status SG_NOT_FINITE instead of SG_OK"
    short = first_difference(declarations, plays, told, told[:-1])
    assert short is not None
    assert "not as many answers" in short


def test_without_the_tools_one_sentence_names_all_packages(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("PATH", "")
    with pytest.raises(ToolMissing) as caught:
        tool_versions()
    for name in ("gcc-arm-none-eabi", "picolibc-arm-none-eabi", "qemu-system-arm"):
        assert name in str(caught.value)


# -- emulated processors ------------------------------------------------------------------------


@cache
def plugin() -> Path:
    return build_plugin(temporary_folder("plugin"))


@cache
def stand(precision: str) -> Stand:
    return make_stand(
        subject(precision), subject(precision).suite(5), temporary_folder("stand") / "c"
    )


def changed(precision: str, file: str, pattern: str, by: str) -> Stand:
    """The stand with one change in the C that the board gets, and not the host."""
    copy = temporary_folder("changed") / "c"
    shutil.copytree(stand(precision).folder, copy, ignore=shutil.ignore_patterns("cortex-*"))
    text, number = re.subn(pattern, by, (copy / file).read_text(), count=1)
    assert number == 1
    (copy / file).write_text(text)
    return replace(stand(precision), folder=copy)


@on_board
def test_float_in_hardware_and_double_in_software_give_the_hosts_bits() -> None:
    outcomes = [
        examine(stand(precision), None, PRECISIONS[precision], core, plugin())
        for precision, core in (("float64", M4), ("float32", M7))
    ]
    bench = Bench("small", (subject("float64"), subject("float32")))
    finding = finding_of(bench, outcomes, {})
    assert finding.passed, finding.faults
    assert "all bits the host's in 2 of 2 runs" in finding.summary
    for precision, core in (("float64", M4), ("float32", M7)):
        outcome = finding.figures[precision][core.name]
        assert outcome["calls_played"] == outcome["calls_of"] > 1000
        # at least these and the kernels are held to equality
        assert {"pil_predict", "pil_mpc_candidate"} <= set(outcome["straight_line"])
        kernels = outcome["kernels"]
        assert kernels["entry_points"] > 5
        assert kernels["executed"] == kernels["static"]
        assert kernels["executed"]["mul"] > 100


@on_board
def test_too_many_operations_in_software_are_left_out_and_told(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("servogen.evidence.pil.SOFTWARE_BUDGET", 200_000)
    copy = changed("float64", "sg_player.c", "^", "")
    outcome = examine(copy, None, PRECISIONS["float64"], M4, plugin())
    assert outcome.difference is None
    assert 100 < outcome.played < outcome.of
    told = finding_of(Bench("small", (subject("float64"),)), [outcome], {}).details[0]
    assert f"{outcome.played} of {outcome.of}" in told


@on_board
def test_a_changed_table_entry_is_found_and_named() -> None:
    other = changed(
        "float32", "pil_mpc_tables.h", r"(pil_mpc_b\[\d+\] = \{\s*0\.\d*?)(\d)f", r"\g<1>f"
    )
    outcome = examine(other, None, PRECISIONS["float32"], M7, plugin())
    assert outcome.difference is not None
    assert re.search(r"^\S.*, call \d+, pil\w*: \w+.* is \S+ instead of", outcome.difference)
    assert any(" instead of " in fault for fault in outcome.all_faults())


@on_board
def test_one_more_multiplication_breaks_the_equality() -> None:
    other = changed(
        "float32", "sg_kernels.h", r"y\[i\] \+= column\[i\] \* factor;",
        "const volatile sg_real one = 1; y[i] += (column[i] * factor) * one;",
    )  # fmt: skip
    outcome = examine(other, None, PRECISIONS["float32"], M4, plugin())
    assert outcome.difference is None
    assert any(re.search(r"kernels.*: \d+ mul executed in one call", f) for f in outcome.faults)
    assert any(re.search(r"pil_predict: \d+ div \+ mul executed", f) for f in outcome.faults)


@on_board
def test_without_optimisation_executed_is_counted_in_every_call() -> None:
    kept = within(stand("float32"), "short", 400_000)
    levels = play_levels(kept, M7, plugin())
    assert [level.level for level in levels] == ["-O0", "-Os", "-O3"]
    for level in levels:
        assert level.calls == len(kept.which) > 500
        assert level.all_faults() == []
    less = replace(kept, counted=kept.counted + (kept.counted > 0))
    rows = np.zeros((len(kept.which), len(COLUMNS)), np.uint64)
    for name in ARITHMETIC:
        rows[:, COLUMNS.index(name)] = kept.counted[:, CLASSES.index(name)]
    assert unequal_counts(kept, rows, software=False) == []
    told = unequal_counts(less, rows, software=False)
    assert "pil_predict: 24 add executed, the C has 25" in told
    assert any(" neg executed" in line for line in told)
    assert not any(" neg executed" in line for line in unequal_counts(less, rows, software=True))
    assert unequal_counts(kept, rows[:-1], software=False) != []


BY_HAND = """\
#include <stdio.h>
#include <stdlib.h>
void sg_player_begin(int which);
void sg_player_end(void);
int main(void)
{
    FILE *told = fopen("results.bin", "wb");
    fclose(told);
    for (int i = 1; i <= 2; i++) {
        sg_player_begin(i);
        BODY
        sg_player_end();
    }
    return 0;
}
"""


def by_hand(body: str, core: Core, folder: Path) -> np.ndarray:
    """(2, columns) counters of a body that runs twice between the marks."""
    (folder / "sg_player.c").write_text(BY_HAND.replace("BODY", body))
    (folder / "calls").write_bytes(b"")
    program = build_target(core, folder, [])
    return play_board(core, program, folder / "calls", folder / "run", plugin()).rows


@on_board
def test_a_loop_in_assembly_is_counted_exactly(tmp_path: Path) -> None:
    body = """__asm__ volatile("mov r3, %0\\n 1: vmul.f32 s0, s1, s2\\n vmul.f32 s3, s1, s2\\n"
        "vmla.f32 s0, s1, s2\\n vadd.f32 s0, s1, s2\\n vcmpe.f32 s0, s1\\n vneg.f32 s4, s4\\n"
        "vdiv.f32 s5, s1, s2\\n vcvt.f32.s32 s6, s6\\n vsqrt.f32 s7, s1\\n vfma.f32 s8, s1, s2\\n"
        "subs r3, #1\\n bne 1b\\n" : : "r"(10 * i) : "r3", "s0", "s3", "s4", "s5", "s6", "s7",
        "s8", "cc");"""
    rows = by_hand(body, M4, tmp_path)
    once = {"mul": 3, "add": 2, "cmp": 1, "neg": 1, "div": 1, "convert": 1, "sqrt": 1, "fused": 1}
    for call, turns in enumerate((10, 20)):
        for name in COLUMNS[1:]:
            assert rows[call, COLUMNS.index(name)] == turns * once.get(name, 0), name
        around = rows[call, 0] - 12 * turns
        assert 1 <= around <= 12  # the calls of the marks and what prepares them
    assert rows[1, 0] - rows[0, 0] == 120


@on_board
def test_software_arithmetic_is_counted_exactly(tmp_path: Path) -> None:
    body = """{ volatile double a = 1.5, b = 2.5, c; volatile int n = 0;
        for (int k = 0; k < 7 * i; k++) { c = a + b; c = a - b; c = 1.0 - a; c = a * b; c = a * c;
        c = a / b; if (a < b) { n++; } if (a >= b) { n++; } if (a == b) { n++; }
        c = (double)n; n = (int)c; } }"""
    rows = by_hand(body, M4, tmp_path)
    once = {"add": 3, "mul": 2, "div": 1, "cmp": 3, "convert": 2}
    for call, turns in enumerate((7, 14)):
        for name, number in once.items():
            assert rows[call, COLUMNS.index(name)] == turns * number, name


@on_board
def test_a_fault_of_the_processor_ends_the_check(tmp_path: Path) -> None:
    with pytest.raises(CheckFailed, match="the player on the Cortex-M7"):
        by_hand('__asm__ volatile("udf #0");', M7, tmp_path)
