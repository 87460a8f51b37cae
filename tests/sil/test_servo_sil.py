"""The MPC of a servo axis and its PID in C against their references, bit for bit."""

from __future__ import annotations

import pytest
from servo_designs import Axis, compiled, package, parts

from servogen.sil.compiled import CompiledController
from servogen.sil.harness import compare
from servogen.sil.servo_scenarios import servo_suite

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


def in_c(prefix: str, index: int) -> CompiledController:
    axis = BY_NAME[prefix]
    return CompiledController(compiled(*AXES), package(axis).declarations[index])


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
