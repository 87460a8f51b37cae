"""Plays a stream of calls on the host, in the counting twin and on an emulated board."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from servogen.errors import CheckFailed
from servogen.evidence.pil_build import QEMU, REMEDY, Core, Program
from servogen.evidence.pil_map import COLUMNS
from servogen.evidence.tools import demand, find_tool
from servogen.wcet.operations import CLASSES

Rows = NDArray[np.unsignedinteger[Any]]
CALLS, RESULTS = "calls.bin", "results.bin"  # as the player names them


@dataclass(frozen=True)
class Played:
    """What came back: ``told``, the answers as bytes; ``rows`` (calls, columns) of counters."""

    told: bytes
    rows: Rows


def play_host(program: Path, stream: Path, folder: Path) -> bytes:
    """Answers of the host's build; ``folder`` is made for it.

    Raises:
        CheckFailed: it stopped with an error.
    """
    _prepare(folder, stream)
    demand([program], "the player on the host", folder)
    return (folder / RESULTS).read_bytes()


def play_counted(program: Path, stream: Path, folder: Path) -> Played:
    """Answers of the counting twin; a column for each class of ``wcet.operations``.

    Raises:
        CheckFailed: it stopped with an error.
    """
    told = play_host(program, stream, folder)
    return Played(told, _rows(folder / "counts.bin", len(CLASSES)))


def play_board(
    core: Core, program: Program, stream: Path, folder: Path, plugin: Path | None
) -> Played:
    """Answers of the emulated processor; a column for each of ``pil_map.COLUMNS``.

    Args:
        folder: where it runs; made for it.
        plugin: None to play without counting; ``rows`` is then empty.

    Raises:
        ToolMissing: no QEMU.
        CheckFailed: the program stopped with an error or a fault.
    """
    qemu = find_tool(QEMU, REMEDY)
    _prepare(folder, stream)
    command: list[str | Path] = [
        qemu, "-M", core.machine, "-cpu", core.name, "-display", "none", "-serial", "none",
        "-monitor", "none", "-chardev", "stdio,id=c0",
        "-semihosting-config", "enable=on,target=native,chardev=c0", "-kernel", program.file,
    ]  # fmt: skip
    if plugin is not None:
        (folder / "map.txt").write_text(program.map.text(), encoding="utf-8")
        command += ["-plugin", ",".join((
            f"file={plugin}", "map=map.txt", f"columns={len(COLUMNS):x}",
            f"begin={program.map.begin:x}", f"end={program.map.end:x}", "rows=rows.bin",
        ))]  # fmt: skip
    demand(command, f"the player on the {core.title}", folder)
    told = (folder / RESULTS).read_bytes()
    rows = np.zeros((0, len(COLUMNS)), np.uint64)
    return Played(told, rows if plugin is None else _rows(folder / "rows.bin", len(COLUMNS)))


def _prepare(folder: Path, stream: Path) -> None:
    folder.mkdir()
    (folder / CALLS).symlink_to(stream.resolve())


def _rows(file: Path, width: int) -> Rows:
    values = np.fromfile(file, np.uint64)
    if values.size % width:
        raise CheckFailed(f"{file.name} ends within a row")
    return values.reshape(-1, width)
