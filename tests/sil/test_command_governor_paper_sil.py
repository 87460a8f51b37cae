"""The extended command governor at the sizes of paper 4, in C around its machine: n = 40, N = 3,
M = 500. The set behind it takes seconds, hence a file, and a worker, of its own."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from core_designs import temporary_folder
from governor_designs import alike, package

from servogen.controllers.command_governor import CommandGovernor
from servogen.controllers.command_governor_design import CommandGovernorDesign
from servogen.controllers.design import Status
from servogen.emit.package import CPackage
from servogen.precision import PRECISIONS
from servogen.sil.build import compile_package
from servogen.sil.compiled import CompiledController
from servogen.sil.harness import Twin
from servogen.steps.counted import count_emitted
from servogen.systems.command_governor_loop import excess, run_governed

from governed_machine import figures, least_motion, machine, stage  # isort: skip

pytestmark = pytest.mark.xdist_group("governor of the paper")
HORIZON, M = 40, 500
PATH = figures(3, 3, 2000)
MOTION = least_motion(PATH)


@cache
def emitted(name: str) -> tuple[CommandGovernorDesign, CPackage]:
    own = alike(machine(HORIZON, None, M, 3, PRECISIONS[name]))
    own = replace(own, prefix=f"paper{name[-2:]}")
    return own, package(own)


@pytest.mark.parametrize("name", ["float64", "float32"])
def test_a_path_is_machined_by_the_c_as_by_the_reference(name: str) -> None:
    own, made = emitted(name)
    compiled = compile_package([made], temporary_folder(f"paper-{name}"), ["-O0"])
    controller = CompiledController(compiled, made.declarations[-1])
    twin = Twin(CommandGovernor(own), controller)
    run = run_governed(own, (stage(), stage()), PATH, MOTION, twin)
    assert twin.agreement.passed, twin.agreement.difference
    assert twin.agreement.worst == 0.0
    assert run.complete
    # in single precision the rows of so long a horizon are now and then too alike for the solver
    allowed = {Status.OK} if name == "float64" else {Status.OK, Status.BACKUP}
    assert set(run.status.tolist()) <= allowed
    assert 20 < run.status.size < 80
    assert 5 < np.max(run.iterations) <= own.axes[0].solver.cap
    worst = excess(own, run, M)
    bound = 1e-6 if name == "float64" else 1e-4
    assert max(worst.position, worst.velocity, worst.acceleration, worst.stroke) < bound


def test_both_programs_are_most_of_the_work() -> None:
    """Windows are looked at once, points planned at most four times."""
    own, made = emitted("float64")
    assert sum(d.table_bytes for d in made.declarations) < 40_000
    names = [f"{own.prefix}_step", f"{own.axes[0].prefix}_step"]
    counts = count_emitted(made, names).entry_points
    whole, axis = (counts[name].total().cmp for name in names)
    assert made.declarations[-1].operation("step").inputs[-1].high == own.window == 20_501
    assert 20 * own.window < whole - 2 * axis < 50 * own.window
    assert whole < 3 * axis
