"""The MPC of a servo axis and its PID in C against their references, bit for bit."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from servo_designs import Axis, compiled, parts
from shared_builds import compiled_once

from servogen.controllers.errors import DesignError
from servogen.controllers.lookup import Lookup
from servogen.controllers.pid import Pid
from servogen.controllers.servo_parts import ServoParts
from servogen.emit.package import emit_package
from servogen.explicit.choose import Choice
from servogen.precision import PRECISIONS
from servogen.project.servo_load import load_servo_project
from servogen.sil.compiled import CompiledController
from servogen.sil.harness import Call, Twin, compare
from servogen.sil.servo_scenarios import servo_suite
from servogen.systems.servo_drive import ServoDrive, lookup_choice, servo_drive, servo_parts
from servogen.systems.servo_loop import MpcLoop, PidLoop, run_drive

EXAMPLE = Path(__file__).parents[2] / "examples" / "servo_drive" / "servogen.toml"
SAMPLES = 3000
AXES = (
    Axis("sh64", moves=3),
    Axis("sh32", moves=3, precision="float32"),
    Axis("sn64", moves=1, turn=0.0, notch=False),
    Axis("ss64", "slide", notch=False),
    Axis("ss32", "slide", "float32"),
    Axis("sp64", "pair"),
    Axis("sp32", "pair", "float32", turn=0.0),
)
BY_NAME = {axis.prefix: axis for axis in AXES}


@pytest.mark.parametrize("prefix", BY_NAME)
def test_edges_half_turns_and_random_calls(prefix: str) -> None:
    axis = BY_NAME[prefix]
    statuses: dict[str, set[str]] = {}
    for name, reference, calls in servo_suite(parts(axis), 11, 400):
        declaration = reference().declaration
        c = CompiledController(compiled(*AXES), declaration)
        agreement = compare(reference(), c, calls)
        assert agreement.passed, f"{name}: {agreement.difference}"
        assert agreement.calls == len(calls) > 0
        assert agreement.worst == 0.0
        statuses.setdefault(name.split(":")[0], set()).update(agreement.statuses)
    assert len(statuses) == (2 if axis.kind == "pair" else 3)
    for name, seen in statuses.items():
        assert {"OK", "NOT_FINITE", "OUT_OF_RANGE"} <= seen
        assert ("NOT_READY" in seen) == (not name.endswith("lookup"))
    if axis.kind == "slide":
        assert "INFEASIBLE" in statuses[f"{prefix}_mpc"]


@pytest.mark.parametrize("prefix", ["sh32", "ss32", "sp32"])
def test_a_step_looks_at_its_inputs_once(prefix: str) -> None:
    """The lookup it asks takes the parameter as it is; so it has to reach as far as that can go."""
    own = parts(BY_NAME[prefix])
    made = emit_package(f"once_{prefix}", own.declarations())
    text = made.files[f"{prefix}_mpc.c"]
    assert f"{prefix}_mpc_lookup_solve(" in text
    assert f"{prefix}_mpc_lookup_find(" not in text
    contract = made.files[f"verify/{prefix}_mpc_lookup_contract.c"]
    assert "\\is_finite(in->theta[i]) && " in contract
    reached = replace(own.lookup, reach=own.mpc.parameter_bound)
    assert replace(own, lookup=reached).lookup.reach > 100.0
    with pytest.raises(DesignError, match="one for parameters up to"):
        replace(own, lookup=replace(reached, reach=0.9 * reached.reach))


@cache
def example(precision: str) -> tuple[ServoDrive, ServoParts, object]:
    servo = servo_drive(load_servo_project(EXAMPLE))
    own = servo_parts(servo, _choice(), precision=PRECISIONS[precision])
    made = emit_package("headstock", own.declarations())
    return servo, own, compiled_once([made], ["-O1"])


@cache
def _choice() -> Choice:
    return lookup_choice(servo_drive(load_servo_project(EXAMPLE)))


def swinging(time: np.ndarray) -> np.ndarray:
    """Through turn after turn, with swings that the current limit cuts."""
    return 350.0 + 40.0 * time + 5.0 * np.sin(2.0 * np.pi * 8.0 * time) * (time > 0.05)


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_thousands_of_samples_around_the_machine(precision: str) -> None:
    """The example's axis through its encoder: the MPC, and the law of every sample."""
    servo, own, module = example(precision)
    lookup, mpc = own.declarations()[:2]
    reference = own.controller()
    twin = Twin(reference, CompiledController(module, mpc))
    thetas: list[np.ndarray] = []
    run = run_drive(
        servo,
        MpcLoop(twin, own.mpc.problem.horizons.trajectory),
        swinging,
        SAMPLES,
        watch=lambda: thetas.append(reference.theta.astype(float)),
    )
    assert twin.agreement.passed, twin.agreement.difference
    assert twin.agreement.worst == 0.0
    assert twin.agreement.calls == SAMPLES + 1
    assert not np.any(run.status)
    assert np.max(run.output) - np.min(run.output) > 50.0
    assert 1.0 < np.max(np.abs(run.error[500:])) < 15.0  # the swings ask for more than there is
    calls = [Call("find", {"theta": theta}) for theta in thetas]
    looked = Lookup(own.lookup)
    agreement = compare(looked, CompiledController(module, lookup), calls)
    assert agreement.passed, agreement.difference
    laws = {looked.call("find", call.inputs)[1].get("law", 0) for call in calls}
    assert len(laws) > 3


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_the_pid_around_the_machine(precision: str) -> None:
    servo, own, module = example(precision)
    assert own.pid is not None
    twin = Twin(Pid(own.pid), CompiledController(module, own.declarations()[2]))
    run = run_drive(servo, PidLoop(twin), swinging, 1000)
    assert twin.agreement.passed, twin.agreement.difference
    assert twin.agreement.calls == 1000 * (1 + servo.ratio) + 1
    assert np.max(np.abs(run.current)) == servo.project.controller.mpc.current_limit_ma[1]
