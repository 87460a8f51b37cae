"""The same C and the same player, built for the host, for its counting twin and for ARM boards."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from servogen.emit.package import CPackage
from servogen.evidence.flags import IEEE, WARNINGS
from servogen.evidence.pil_map import AddressMap, address_map
from servogen.evidence.tools import ToolMissing, demand, find_tool, run_tool, version_of
from servogen.resources import resource_dir
from servogen.sil.player import player_source
from servogen.wcet.dynamic import COUNTING_FLAGS, counting_dir, write_counted_sources
from servogen.wcet.operations import CLASSES

ARM, QEMU, SPECS = "arm-none-eabi-", "qemu-system-arm", "picolibc.specs"
REMEDY = "apt-get install gcc-arm-none-eabi picolibc-arm-none-eabi qemu-system-arm"
# A loop that fills or copies stays a loop: the instructions counted are then those of the emitted C
# and not of picolibc's memset and memmove, which take four for each byte.
LOOPS = "-fno-tree-loop-distribute-patterns"
PLAYER = "sg_player.c"
LEVEL = "-O2"


@dataclass(frozen=True)
class Core:
    """A processor and the board that QEMU puts it on.

    ``float64_in_hardware``: whether its FPU has arithmetic for double.
    """

    name: str
    title: str
    machine: str
    fpu: str
    float64_in_hardware: bool

    @property
    def flags(self) -> tuple[str, ...]:
        return (f"-mcpu={self.name}", "-mthumb", f"-mfpu={self.fpu}", "-mfloat-abi=hard")


CORES = (
    Core("cortex-m4", "Cortex-M4F", "mps2-an386", "fpv4-sp-d16", False),
    Core("cortex-m7", "Cortex-M7", "mps2-an500", "fpv5-d16", True),
)


@dataclass(frozen=True)
class Program:
    """A linked program for a board."""

    file: Path
    map: AddressMap


def write_package(package: CPackage, folder: Path) -> list[str]:
    """The package's files and the player into ``folder``; names of the package's sources."""
    folder.mkdir(parents=True, exist_ok=True)
    package.write(folder)
    (folder / PLAYER).write_text(player_source(package.declarations), encoding="utf-8")
    return package.sources


def build_host(folder: Path, sources: Sequence[str]) -> Path:
    """The player as the host runs it.

    Raises:
        ToolMissing: no gcc.
        CheckFailed: the C does not compile.
    """
    gcc = find_tool("gcc", "apt-get install gcc")
    target = folder / "host_player"
    demand(
        [gcc, *IEEE, "-O2", "-w", "-DSG_PLAYER_FILES", "-o", target, PLAYER, *sources],
        "the host's build", folder,
    )  # fmt: skip
    return target


def build_counted(folder: Path, sources: Sequence[str]) -> Path:
    """The player with the counting twin of the package: leaves ``counts.bin`` where it runs.

    Raises:
        ToolMissing: no gcc.
        CheckFailed: the C cannot be counted or does not compile.
    """
    gcc = find_tool("gcc", "apt-get install gcc")
    runtime = resource_dir("c_runtime")
    twins = write_counted_sources([folder / s for s in sources], [folder], folder / "counted").files
    target = folder / "counted_player"
    demand(
        [gcc, *COUNTING_FLAGS, "-DSG_PLAYER_FILES", "-DSG_PLAYER_MARKS",
         f"-DSG_N_CLASSES={len(CLASSES)}", "-I", folder, "-c", PLAYER,
         runtime / "pil" / "sg_pil_tally.c"],
        "the counting player", folder,
    )  # fmt: skip
    demand(
        [gcc, *COUNTING_FLAGS, "-I", counting_dir(), "-o", target, *twins, "sg_player.o",
         "sg_pil_tally.o"],
        "the counting twin", folder,
    )  # fmt: skip
    return target


def build_target(core: Core, folder: Path, sources: Sequence[str], level: str = LEVEL) -> Program:
    """The player for a board, with files by semihosting and with marks.

    The package compiles with all warnings as errors; the player is no product and does without.

    Raises:
        ToolMissing: no cross compiler.
        CheckFailed: the C does not compile, or an instruction cannot be classified.
    """
    gcc = find_tool(f"{ARM}gcc", REMEDY)
    pil = resource_dir("c_runtime") / "pil"
    common: list[str | Path] = [gcc, f"--specs={SPECS}", *core.flags, *IEEE, LOOPS, level]
    objects: list[Path] = []
    made = folder / f"{core.name}{level}"
    made.mkdir()
    for source in sources:
        objects.append(made / f"{Path(source).stem}.o")
        command = [*common, *WARNINGS, "-c", source, "-o", objects[-1]]
        demand(command, f"{source} for the {core.title}", folder)
    target = made / "player.elf"
    demand(
        [*common, "-DSG_PLAYER_FILES", "-DSG_PLAYER_MARKS", "--oslib=semihost", "--crt0=hosted",
         "-I", folder, PLAYER, pil / "sg_pil_marks.c", *objects,
         f"-T{pil / 'sg_pil_mps2.ld'}", "-o", target],
        f"the player for the {core.title}", folder,
    )  # fmt: skip
    listing = demand([f"{ARM}objdump", "-d", "--no-show-raw-insn", target], "its listing")
    return Program(target, address_map(listing, demand([f"{ARM}nm", target], "its symbols")))


def build_plugin(folder: Path) -> Path:
    """QEMU's counting plugin, for the host.

    Raises:
        ToolMissing: no gcc.
        CheckFailed: it does not compile.
    """
    gcc = find_tool("gcc", "apt-get install gcc")
    target = folder / "sg_pil_plugin.so"
    source = resource_dir("c_runtime") / "pil" / "sg_pil_plugin.c"
    demand([gcc, "-std=c99", "-O2", "-fPIC", "-shared", source, "-o", target], "the plugin")
    return target


def tool_versions() -> dict[str, str]:
    """Of the compilers, QEMU and picolibc.

    Raises:
        ToolMissing: one of them is not here.
    """
    compiler = find_tool(f"{ARM}gcc", REMEDY)
    emulator = find_tool(QEMU, REMEDY)
    specs = run_tool([compiler, f"-print-file-name={SPECS}"]).stdout.strip()
    if not Path(specs).is_file():  # gcc gives the bare name back when it has no such file
        raise ToolMissing(SPECS, REMEDY)
    return {
        f"{ARM}gcc": version_of([compiler, "--version"]),
        QEMU: version_of([emulator, "--version"]),
        "picolibc": _package_version("picolibc-arm-none-eabi"),
        "gcc": version_of([find_tool("gcc", "apt-get install gcc"), "--version"]),
    }


def _package_version(package: str) -> str:
    """Debian's; picolibc itself says none."""
    if shutil.which("dpkg-query") is None:
        return "unknown"
    asked = run_tool(["dpkg-query", "-W", "-f=${Version}", package])
    return asked.stdout.strip() if asked.returncode == 0 else "unknown"
