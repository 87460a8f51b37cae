"""A start that interrupts plan must find no plan, so plan says it has one only when it is done."""

from __future__ import annotations

import re

import pytest
from core_designs import Variant, package


@pytest.mark.parametrize("horizon", [0, 3], ids=["sprg", "mpc"])
def test_planned_is_cleared_before_and_set_after_the_work(horizon: int) -> None:
    made = package(Variant(horizon=horizon))
    source = made.files["core.c"]
    body = source[source.index("sg_status core_plan(") :]
    body = body[: body.index("\n}\n")]
    marks = re.findall(r"self->planned = \w+|core_period\(", body)
    assert marks == ["self->planned = 0", "core_period(", "self->planned = complete"]
