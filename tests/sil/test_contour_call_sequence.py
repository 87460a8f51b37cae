"""The calls of a contour controller in docs/on-a-target.md, compiled and run along the contour."""

from __future__ import annotations

import ctypes
import re
import subprocess
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "steps"))

from contour_example import simulated, small_system

from servogen.controllers.design import Status
from servogen.emit.package import emit_package
from servogen.precision import FLOAT32
from servogen.resources import resource_dir

SAMPLES = 150
# What the section leaves to the reader: encoders, drives, and the contour as far as it is known.
STUBS = """
#include "centre.h"
float counted[CENTRE_AXES], commands[CENTRE_AXES], contour[2000][CENTRE_AXES];
int now;
static void read_encoders(centre_real *to)
{ for (int a = 0; a < CENTRE_AXES; a++) { to[a] = counted[a]; } }
static void point_of_contour(int ahead, centre_real *to)
{ for (int a = 0; a < CENTRE_AXES; a++) { to[a] = contour[now + ahead][a]; } }
static void command_drives(const centre_real *of)
{ for (int a = 0; a < CENTRE_AXES; a++) { commands[a] = of[a]; } }
static void contour_advance(void) { now++; }
"""
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-pedantic", "-Werror")


def told() -> str:
    """The section's code."""
    text = (resource_dir("examples").parent / "docs" / "on-a-target.md").read_text(encoding="utf-8")
    section = text.split("## A contour controller\n")[1].split("\n## ")[0]
    (block,) = re.findall(r"```c\n(.*?)```", section, re.DOTALL)
    return str(block)


def test_the_code_runs_as_the_closed_loop_does(tmp_path: Path) -> None:
    system, run = small_system(), simulated().run
    package = emit_package("centre", system.declarations(FLOAT32))
    package.write(tmp_path)
    (tmp_path / "firmware.c").write_text(STUBS + told(), encoding="utf-8")
    sources = [str(tmp_path / name) for name in package.sources]
    library = tmp_path / "firmware.so"
    subprocess.run(
        ["gcc", *STRICT, "-O1", "-ffp-contract=off", "-shared", "-fPIC", f"-I{tmp_path}",
         *sources, str(tmp_path / "firmware.c"), "-o", str(library)],
        check=True,
    )  # fmt: skip
    firmware = ctypes.CDLL(str(library))
    pair = ctypes.c_float * 2
    counted, commands = (pair.in_dll(firmware, name) for name in ("counted", "commands"))
    contour = (ctypes.c_float * 4000).in_dll(firmware, "contour")
    points = system.machine.task.motion.points[:2000].ravel()
    contour[: len(points)] = points.tolist()
    encoder = system.machine.encoder_m

    counted[:] = points[:2].tolist()
    assert firmware.contour_begin() == Status.OK
    for k in range(SAMPLES):
        counted[:] = (np.round(run.output[k] / encoder) * encoder).tolist()
        assert firmware.contour_sample() == run.status[k]
        np.testing.assert_array_equal(np.array(commands, dtype=np.float64), run.command[k])
    assert np.max(np.abs(run.command[:SAMPLES])) > 1.0
