"""Extended command governor (6) with any auxiliary dynamics, command and reference governor."""

from functools import cache

import numpy as np
import pytest
from governed_machine import CENTRE, LIMITS, T_S, admissible, stage
from scipy.optimize import minimize_scalar

from servogen.controllers.design import Status
from servogen.controllers.errors import DesignError
from servogen.controllers.plain_governors import (
    CommandGovernorLaw,
    ExtendedGovernor,
    ReferenceGovernor,
)
from servogen.plants.statespace import discretise
from servogen.sets.auxiliary import AuxiliaryDynamics, laguerre, no_auxiliary, shift_register
from servogen.sets.extended import ExtendedSet, extended_set

PLANT = discretise(stage(), T_S)
AUXILIARY = {"register": shift_register(12), "Laguerre": laguerre(3, 0.7)}


@cache
def target(name: str) -> ExtendedSet:
    if name == "register":
        return admissible(12)
    auxiliary = AUXILIARY.get(name, no_auxiliary())
    return extended_set(stage(), T_S, auxiliary, 3, LIMITS, CENTRE)


def on(state: np.ndarray, command: float) -> np.ndarray:
    return PLANT.a @ state + PLANT.b * command


def governor(name: str, cap: int = 200) -> ExtendedGovernor:
    made = ExtendedGovernor(target(name), np.eye(AUXILIARY[name].order), 0.01, cap)
    made.reset(0.1)
    return made


@pytest.mark.parametrize("name", AUXILIARY)
@pytest.mark.parametrize("cap", [200, 1])
def test_limits_feasibility_and_convergence(name: str, cap: int) -> None:
    """(a), (b), (c) for a reference that jumps and stays: across the range and beyond its end."""
    made, state = governor(name, cap), np.array([0.1, 0.0, 0.0])
    for wished, end in ((0.2, 0.2), (0.4, CENTRE + 0.995 * 0.125), (0.03, 0.03)):
        for period in range(160):
            status, command = made.step(state, np.array([wished]))
            assert status in (Status.OK, Status.BACKUP)
            assert target(name).contains(state, made.auxiliary, made.rho, 1e-8)
            state = on(state, command)
            assert abs(state[1]) <= 0.1 + 1e-9
            if cap == 200 and period == 159:
                assert command == pytest.approx(end, abs=1e-6)


def test_more_freedom_is_faster() -> None:
    """The distance left, summed over a step of 100 mm: more with nothing but a command that is held
    for ever than with auxiliary states, by a little: velocity is what bounds it."""
    left = []
    for name in ("register", "Laguerre", "none"):
        law = CommandGovernorLaw(target("none"))
        law.reset(0.1)
        made = governor(name) if name != "none" else None
        state, total = np.array([0.1, 0.0, 0.0]), 0.0
        for _ in range(80):
            command = made.step(state, np.array([0.2]))[1] if made else law.step(state, 0.2)[1]
            state = on(state, command)
            total += abs(state[0] - 0.2)
        assert state[0] == pytest.approx(0.2, abs=1e-3)
        left.append(total)
    assert max(left[:2]) < left[2] < 1.01 * min(left[:2])


def test_known_references_are_followed_by_the_register() -> None:
    """A slow ramp is admissible: the command is the reference, with Laguerre nearly so."""
    ramp = 0.1 + 0.002 * np.arange(13.0)
    for name, off in (("register", 1e-12), ("Laguerre", 2e-3)):
        made = governor(name)
        status, command = made.step(np.array([0.1, 0.0, 0.0]), ramp)
        assert (status, made.iterations) == (Status.OK, 0)
        assert command == pytest.approx(0.1, abs=off)
        commands = made.rho + AUXILIARY[name].outputs(12) @ made.auxiliary
        np.testing.assert_allclose(commands, ramp[:-1], atol=max(off, 6e-3 * (name != "register")))


def test_command_governor_is_the_nearest_command_in_the_set() -> None:
    law, generator = CommandGovernorLaw(target("none")), np.random.default_rng(4)
    answers = []
    for _ in range(60):
        state = np.array([generator.uniform(0.05, 0.2), *generator.uniform(-0.06, 0.06, 2)])
        wished = generator.uniform(0.0, 0.25)
        status, command = law.step(state, wished)
        answers.append(status)
        if status is not Status.OK:
            continue
        assert target("none").contains(state, np.zeros(0), command, 1e-9)

        def cost(rho: float, state: np.ndarray = state, wished: float = wished) -> float:
            outside = max(target("none").excess(state, np.zeros(0), rho), 0.0)
            return abs(rho - wished) + 1e4 * outside

        best = minimize_scalar(cost, bounds=(0.0, 0.25), method="bounded", options={"xatol": 1e-9})
        assert abs(command - wished) <= abs(best.x - wished) + 1e-6
    assert answers.count(Status.OK) > 40


def test_reference_governor_keeps_to_the_line() -> None:
    """One share for both axes; the slower axis decides, and alone it does as a command governor."""
    both = ReferenceGovernor([target("none")] * 2)
    alone = ReferenceGovernor([target("none")])
    law = CommandGovernorLaw(target("none"))
    both.reset(np.array([0.1, 0.1]))
    alone.reset(np.array([0.1]))
    law.reset(0.1)
    wished = np.array([0.2, 0.12])
    states, own = [np.array([0.1, 0.0, 0.0])] * 2, np.array([0.1, 0.0, 0.0])
    for _ in range(60):
        before = both.command
        status, command = both.step(states, wished)
        assert status is Status.OK
        np.testing.assert_allclose((command - before)[1] * 5.0, (command - before)[0], atol=1e-12)
        states = [on(state, float(c)) for state, c in zip(states, command, strict=True)]
        assert all(abs(state[1]) <= 0.1 + 1e-9 for state in states)
        single = alone.step([own], wished[:1])[1][0]
        assert single == pytest.approx(law.step(own, 0.2)[1], abs=1e-12)
        own = on(own, single)
    np.testing.assert_allclose(both.command, wished, atol=1e-9)
    assert both.step([np.array([0.1, 0.3, 0.0])] * 2, wished)[0] is Status.INFEASIBLE
    np.testing.assert_allclose(both.command, wished, atol=1e-9)


def test_governors_that_cannot_be_made() -> None:
    with pytest.raises(DesignError, match="without"):
        ExtendedGovernor(target("none"), np.zeros((0, 0)), 0.01)
    with pytest.raises(DesignError, match="never growing"):
        ExtendedGovernor(target("Laguerre"), np.diag([9.0, 1.0, 1.0]), 0.01)
    with pytest.raises(DesignError, match="above zero"):
        ExtendedGovernor(target("Laguerre"), np.eye(3), 0.0)
    decay = AuxiliaryDynamics(np.array([[0.5]]), np.ones(1), "a decay")
    own = extended_set(stage(), T_S, decay, 1, LIMITS, CENTRE, 0.02)
    for made in (CommandGovernorLaw, lambda t: ReferenceGovernor([t])):
        with pytest.raises(DesignError, match="none"):
            made(own)
