"""The harness finds what is wrong: one change in the emitted C each, and it must be reported."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from answered import Answered, Listener, answered
from core_designs import Variant, design, package, temporary_folder
from core_loop import run, zigzag

from servogen.controllers.cascade import Cascade
from servogen.controllers.design import Port, Status
from servogen.emit.package import CPackage
from servogen.sil.build import BuildError, compile_package
from servogen.sil.compiled import CompiledController
from servogen.sil.harness import Agreement, Call, Twin, compare, compare_outputs
from servogen.sil.scenarios import suite

# One worker: all mutants are one module.
pytestmark = pytest.mark.xdist_group("mutants")
BASE = Variant("etalon", horizon=5, cap=40, letter="L")


def nudge(table: str, entry: int, relative: float = 0.0):
    """Change one number of a constant table by ``relative``, or by one unit in its last place."""

    def change(text: str) -> str:
        offset = re.search(rf"{table}(\[\d+\])? =", text).end()
        found = list(re.finditer(r"-?\d+\.\d+(?:e[+-]?\d+)?", text[offset:]))[entry]
        value = float(found.group())
        other = value * (1.0 + relative) if relative else np.nextafter(value, np.inf)
        return text[: offset + found.start()] + repr(float(other)) + text[offset + found.end() :]

    return change


def swap(old: str, new: str):
    def change(text: str) -> str:
        assert text.count(old) >= 1, old
        return text.replace(old, new, 1)

    return change


# name: (file, without the prefix; change)
MUTANTS: dict[str, tuple[str, Any]] = {
    "plant matrix": ("_mpc_tables.h", nudge("_a_columns", 0)),
    "free plan on the references": ("_mpc_tables.h", nudge("_plan_reference", 0, 1e-9)),
    "primal correction": ("_mpc_tables.h", nudge("_inverse", 0)),
    "bound on |D|": ("_mpc_tables.h", nudge("_mpc_columns", 0)),
    "its floor": ("_mpc_tables.h", nudge("_at_floor", 0, 0.1)),
    "plant backwards": ("_mpc.c", swap("= x0 + own[0]", "= own[0]")),
    "slow model": ("_follower_tables.h", nudge("_model_x", 3)),
    "range of the governor": ("_governor_tables.h", nudge("_range_x", 0, -0.4)),
    "far end of the interval": (
        "_governor.c",
        swap("if ((highest - ahead) >", "if (2 * (highest - ahead) >"),
    ),
    "iterations": ("_mpc.c", swap("*iterations = k + 1;", "*iterations = k;")),
    "shift of the duals": ("_mpc.c", swap("y[i] = y[i + ", "y[i] = y[i + 0 * ")),
    "feasible or not": ("_mpc.c", swap("(seen.worst >= -", "(seen.worst >= 0.1 * -")),
    "gap": ("_mpc.c", swap("(seen.gap <= ", "(seen.gap <= 0.1 * ")),
    "backup judged": ("_mpc.c", swap("status = SG_INFEASIBLE;", "status = SG_BACKUP;")),
    "slack of a lower bound": ("_mpc.c", swap("if (self->slack_lower[i] < (sg_real)0)", "if (0)")),
    "turns of a cycle": ("_mpc.c", swap("(turn == (CORE_MPC_PERIOD - 1)) ? 2 : kind", "kind")),
    "interpolation": ("_follower.c", swap("share * (there - here)", "share * (here - there)")),
    "ring of points": ("_follower.c", swap("(index - CORE_FOLLOWER_BUFFER)", "0")),
    "window": (".c", swap("low = sg_max(low, self->high", "low = sg_min(low, self->high")),
    "pending": (".c", swap("self->pending - told", "self->pending + told")),
    "status": (".c", swap("status = sg_worse(status, measured);", "(void)measured;")),
}
RUNTIME: dict[str, tuple[str, Any]] = {
    "order of a sum": (
        "sg_kernels.h",
        swap("+ (c1[i] * x1)) + (c2[i] * x2)) +", "+ (c2[i] * x2)) + (c1[i] * x1)) +"),
    ),
    "rows that share a column": ("sg_pqp.h", swap("four[per_step + i]", "four[i]")),
    "columns that are skipped": ("sg_pqp.h", swap("sg_max(x2, x3)) > zero", "x2) > zero")),
    "extrapolation": ("sg_pqp.h", swap("clamp * upper[i])", "zero)")),
}


def renamed(made: CPackage, new: str) -> CPackage:
    """The package with another prefix: emitted once, and yet many of it fit into one module."""
    old = made.name

    def called(text: str) -> str:
        return text.replace(old, new).replace(old.upper(), new.upper())

    declarations = tuple(
        replace(d, prefix=called(d.prefix), uses=tuple(called(u) for u in d.uses))
        for d in made.declarations
    )
    files = {called(name): called(text) for name, text in made.files.items()}
    return replace(made, name=new, hash=new, declarations=declarations, files=files)


def mutated(made: CPackage, suffix: str, change: Any) -> CPackage:
    file = f"{made.name}{suffix}" if suffix.startswith(("_", ".")) else suffix
    text = made.files[file]
    changed = change(text.replace(made.name.upper(), "CORE"))
    changed = changed.replace("CORE", made.name.upper())
    assert changed != text
    return replace(made, files={**made.files, file: changed}, hash=made.hash[::-1])


@cache
def mutants() -> dict[str, CPackage]:
    """The package as it is, by its own name, and every mutant."""
    packages = {BASE.prefix: package(BASE)}
    for number, (name, (file, change)) in enumerate(MUTANTS.items()):
        packages[name] = mutated(renamed(package(BASE), f"mutant{number}"), file, change)
    return packages


@cache
def module_of_mutants() -> Any:
    flags = ["-O0", "-Wno-error"]
    return compile_package(list(mutants().values()), temporary_folder("mutants"), flags)


@cache
def reference_answers() -> list[Answered]:
    """The suite, then the closed loop that the C would have to follow call by call."""
    listener = Listener(Cascade(design(BASE)))
    run(listener, BASE, zigzag(), 80)
    return [*answered(suite(design(BASE), 3, 60)), listener.answered("closed loop")]


def differences(made: CPackage, module: Any) -> list[str]:
    """The first thing the suite says of the C in the module; the closed loop if it says nothing."""
    own = dict(zip((d.prefix for d in package(BASE).declarations), made.declarations, strict=True))
    for each in reference_answers():
        agreement = each.held_against(CompiledController(module, own[each.declaration.prefix]))
        if not agreement.passed:
            return [f"{each.name}: {agreement.difference}"]
    return []


def test_the_unchanged_package_agrees():
    assert differences(package(BASE), module_of_mutants()) == []


@pytest.mark.parametrize("name", MUTANTS)
def test_every_mutant_is_found(name):
    found = differences(mutants()[name], module_of_mutants())
    assert found, f"nothing noticed the mutant {name!r}"
    assert all("is" in text and "in the C" in text for text in found)


@pytest.mark.parametrize("name", RUNTIME)
def test_mutants_of_the_runtime_are_found(name):
    file, change = RUNTIME[name]
    made = mutated(package(BASE), file, change)
    module = compile_package([made], temporary_folder("runtime"), ["-O0", "-Wno-error"])
    assert differences(made, module)


def test_c_that_does_not_compile_is_told():
    made = package(replace(BASE, prefix="broken"))
    broken = replace(made, files={**made.files, "broken.c": made.files["broken.c"] + "int x = ;"})
    with pytest.raises(BuildError, match="does not compile"):
        compile_package([broken], temporary_folder("broken"), ["-O0"])


def outcome(first: Any, second: Any, bound: float = 0.0) -> Agreement:
    agreement = Agreement()
    compare_outputs(agreement, Call("step"), (Status.OK, first), (Status.OK, second), bound)
    return agreement


def test_comparison_is_not_fooled():
    """NaN is no agreement, nor is a missing output; integers are compared exactly."""
    assert outcome({"a": 1.0}, {"a": 1.0}).passed
    assert not outcome({"a": np.nan}, {"a": np.nan}).passed
    assert not outcome({"a": 1.0}, {"a": np.nan}, bound=1.0).passed
    assert not outcome({}, {"a": 1.0}).passed
    assert not outcome({"a": 3}, {"a": 4}, bound=10.0).passed
    assert outcome({"a": 3.0}, {"a": 4.0}, bound=1.0).passed
    assert not outcome({"a": 3.0}, {"a": 4.0}, bound=0.9).passed
    assert not outcome({"a": np.array([1.0, 2.0])}, {"a": np.array([1.0, 2.5])}).passed
    found = outcome({"a": 3.0}, {"a": 3.5})
    assert found.worst == 0.5
    assert "a is 3.0 in the reference and 3.5 in the C" in str(found.difference)
    assert not compare(Silent(), Silent(), []).passed  # no call is no proof


class Silent:
    """A controller that answers zero; its ``repeat`` can be told to lie."""

    declaration = replace(package(BASE).declarations[-1])

    def __init__(self, lie: float = 0.0) -> None:
        self.lie = lie

    def call(self, operation: str, inputs: Any = None) -> tuple[Status, dict[str, Any]]:
        return Status.OK, {"value": 0.0}

    def repeat(self, operation: str, count: int) -> np.ndarray:
        ports: tuple[Port, ...] = self.declaration.operation(operation).outputs
        values = np.zeros((count, len(ports)))
        values[-1, 1] = self.lie
        return values


@pytest.mark.parametrize("lie", [1e-300, np.nan, 1.0])
def test_a_twin_notices_a_lie_in_a_repeated_operation(lie):
    honest = Twin(Silent(), Silent())
    honest.repeat("fast_step", 5)
    assert honest.agreement.passed
    twin = Twin(Silent(), Silent(lie))
    twin.call("step")
    twin.repeat("fast_step", 5)
    assert not twin.agreement.passed
    assert twin.agreement.difference.index == 5
    assert twin.agreement.difference.item == "command_y"
