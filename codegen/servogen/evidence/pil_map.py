"""Which operation each instruction of an ARM program is: the one place where the two are matched.

The disassembler of binutils names the instructions; QEMU's plugin counts by address what is
executed. An instruction that does two operations counts in both columns. The columns ``add`` to
``other_fp`` mean what they mean in ``wcet.operations``:

- ``vmla``, ``vmls`` are a multiplication that is rounded and then an addition that is rounded
  (chained, not fused: the bits of the C), ``vnmls`` likewise (a * b - d);
- ``vnmul`` is a multiplication and a sign change, ``vnmla`` a multiplication, an addition and a
  sign change (-d - a * b);
- ``vfma`` and its like round once. The C must not contain them: they have a column of their own,
  which has to stay zero;
- ``vmov``, ``vsel``, ``vmrs`` move values or flags and are no operation on scalars; ``vldr``,
  ``vstr`` and the multiple forms are one instruction for one or more elements, so these columns
  are told but compared with nothing.

Where the processor has no arithmetic for a type, the compiler calls the functions of the ARM run
time ABI: their first instructions stand for the operation. A sign change is then an exclusive-or
on an integer, which cannot be told from others.

An instruction with a condition (``vmulgt``) counts as executed also where the condition fails:
the columns may count too many of those, never too few.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from servogen.errors import CheckFailed

COLUMNS = (
    "total", "add", "mul", "div", "cmp", "neg", "sqrt", "convert", "other_fp",
    "fused", "move", "load", "store",
)  # fmt: skip
# Operations on scalars that are compared with the counts of the C.
ARITHMETIC = ("add", "mul", "div", "cmp", "neg", "sqrt", "convert", "other_fp")

_INSTRUCTIONS: dict[str, tuple[str, ...]] = {
    "vadd": ("add",),
    "vsub": ("add",),
    "vmul": ("mul",),
    "vnmul": ("mul", "neg"),
    "vmla": ("mul", "add"),
    "vmls": ("mul", "add"),
    "vnmla": ("mul", "add", "neg"),
    "vnmls": ("mul", "add"),
    "vdiv": ("div",),
    "vcmp": ("cmp",),
    "vcmpe": ("cmp",),
    "vmaxnm": ("cmp",),
    "vminnm": ("cmp",),
    "vneg": ("neg",),
    "vabs": ("neg",),
    "vsqrt": ("sqrt",),
    **dict.fromkeys(("vcvt", "vcvtr", "vcvta", "vcvtm", "vcvtn", "vcvtp"), ("convert",)),
    **dict.fromkeys(
        ("vrinta", "vrintm", "vrintn", "vrintp", "vrintr", "vrintx", "vrintz"), ("other_fp",)
    ),
    **dict.fromkeys(("vfma", "vfms", "vfnma", "vfnms"), ("fused",)),
    **dict.fromkeys(
        ("vmov", "vmrs", "vmsr", "vseleq", "vselge", "vselgt", "vselvs"), ("move",)
    ),
    **dict.fromkeys(("vldr", "vldm", "vldmia", "vldmdb", "vpop"), ("load",)),
    **dict.fromkeys(("vstr", "vstm", "vstmia", "vstmdb", "vpush"), ("store",)),
}  # fmt: skip
_CONDITIONS = (
    "eq", "ne", "cs", "hs", "cc", "lo", "mi", "pl", "vs", "vc", "hi", "ls", "ge", "lt", "gt", "le",
)  # fmt: skip

# First instructions of the run time ABI's functions. In libgcc a subtraction turns the sign of its
# second operand and falls into the addition, which therefore stands for both.
_SOFTWARE: dict[str, str] = {
    "__aeabi_dadd": "add",
    "__aeabi_dmul": "mul",
    "__aeabi_ddiv": "div",
    **dict.fromkeys(
        (f"__aeabi_dcmp{c}" for c in ("eq", "lt", "le", "ge", "gt", "un")), "cmp"
    ),
    **dict.fromkeys(
        ("__aeabi_i2d", "__aeabi_ui2d", "__aeabi_d2iz", "__aeabi_d2uiz", "__aeabi_f2d",
         "__aeabi_d2f"),
        "convert",
    ),
}  # fmt: skip
_FALLS_INTO_ADDITION = ("__aeabi_dsub", "__aeabi_drsub")
_LONGEST_FALL = 16

_LINE = re.compile(r"^\s*([0-9a-f]+):\s+(v[a-z]+)(?:\.[a-z0-9.]+)?(?:\s|$)")


@dataclass(frozen=True)
class AddressMap:
    """What the plugin is told.

    Attributes:
        entries: (address, column) pairs.
        begin, end: addresses of the marks.
        software: the operations that are functions of the run time ABI in this program.
    """

    entries: tuple[tuple[int, str], ...]
    begin: int
    end: int
    software: frozenset[str]

    def text(self) -> str:
        return "".join(f"{address:x} {COLUMNS.index(name):x}\n" for address, name in self.entries)


def operations_of(mnemonic: str) -> tuple[str, ...] | None:
    """Columns of a floating-point mnemonic without its types; None if it is not known."""
    if mnemonic in _INSTRUCTIONS:
        return _INSTRUCTIONS[mnemonic]
    if mnemonic[-2:] in _CONDITIONS:
        return _INSTRUCTIONS.get(mnemonic[:-2])
    return None


def address_map(listing: str, symbols: str) -> AddressMap:
    """From ``objdump -d --no-show-raw-insn`` and ``nm`` of the linked program.

    Raises:
        CheckFailed: an instruction that stands in no table here, or no marks.
    """
    names = _symbols(symbols)
    for mark in ("sg_player_begin", "sg_player_end"):
        if mark not in names:
            raise CheckFailed(f"the program for the processor has no {mark}")
    software = {n: column for n, column in _SOFTWARE.items() if n in names}
    _check_fall(names)
    entries = [*_instructions(listing), *((names[n], column) for n, column in software.items())]
    return AddressMap(
        tuple(sorted(entries)),
        names["sg_player_begin"],
        names["sg_player_end"],
        frozenset(software.values()),
    )


def _instructions(listing: str) -> Iterator[tuple[int, str]]:
    for line in listing.splitlines():
        found = _LINE.match(line)
        if found is None:
            continue
        columns = operations_of(found[2])
        if columns is None:
            raise CheckFailed(f"the instruction {found[2]} at {found[1]} stands in no class")
        for column in columns:
            yield int(found[1], 16), column


def _symbols(symbols: str) -> Mapping[str, int]:
    names = {}
    for line in symbols.splitlines():
        parts = line.split()
        if len(parts) == 3 and parts[1] in "tTwW":
            names[parts[2]] = int(parts[0], 16) & ~1
    return names


def _check_fall(names: Mapping[str, int]) -> None:
    """Subtractions are counted at the addition only as long as they end up there.

    Raises:
        CheckFailed: this libgcc is laid out differently.
    """
    addition = names.get("__aeabi_dadd", 0)
    for name in _FALLS_INTO_ADDITION:
        if name in names and not 0 < addition - names[name] <= _LONGEST_FALL:
            raise CheckFailed(f"{name} of this libgcc does not fall into __aeabi_dadd")
