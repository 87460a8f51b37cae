"""Theorem 1: its hypotheses, and that it holds; the choice without guarantee, and its warning."""

import numpy as np
import pytest
from contour_machine import OUTPUT, STATIONARY, design, of_case, weights

from servogen.controllers.contour_stability import (
    FrozenSpectrum,
    directions,
    frozen_spectrum,
    theorem_conditions,
    theorem_holds,
)
from servogen.controllers.contour_table_design import (
    direction_gains,
    state_gains,
    table_quality,
    tabulate,
)
from servogen.controllers.errors import DesignError
from servogen.plants.machining_centre import machining_centre
from servogen.plants.statespace import Discrete
from servogen.precision import FLOAT32
from servogen.systems.contour_proofs import in_precision

ANGLES = 37
# alpha, beta: the facts' five sets are of this kind; none of theirs is told by number.
SETS = [(8.0, 0.0), (1.2, 20.0), (3.0, 0.0), (0.25, 15.0), (4.0, 40.0)]
TRIPLE = (*machining_centre(), Discrete(np.eye(1), np.array([1.1e-5]), np.ones(1), 0.0005))


@pytest.mark.parametrize(("tracking", "contour"), [*SETS, (1e-3, 1e3), (1e3, 1e-3)])
def test_theorem_1_holds_at_every_angle_and_preview(tracking: float, contour: float) -> None:
    axes, asked = machining_centre(), weights(tracking, contour)
    assert theorem_holds(axes, asked, STATIONARY)
    found = frozen_spectrum(axes, asked, STATIONARY, 40, ANGLES)
    assert found.modulus.shape == (40, ANGLES)
    assert found.worst()[0] < 1.0
    if (tracking, contour) in SETS:
        assert found.worst()[0] < 0.9


def test_the_largest_modulus_is_the_one_known() -> None:
    """0.877 over previews of 1 to 15 points, of the weights that weigh least."""
    worst = max(
        frozen_spectrum(machining_centre(), weights(a, b), STATIONARY, 15, ANGLES).worst()[0]
        for a, b in SETS
    )
    assert worst == pytest.approx(0.877, abs=0.01)


def test_it_holds_in_space() -> None:
    found = frozen_spectrum(TRIPLE, weights(1.2, 20.0), STATIONARY, 15, 40)
    assert found.worst()[0] < 1.0


def test_the_other_choice_comes_near_the_circle_and_says_where() -> None:
    found = frozen_spectrum(machining_centre(), weights(0.25, 15.0), OUTPUT, 15, ANGLES)
    modulus, preview, _ = found.worst()
    assert preview == 1
    assert modulus == pytest.approx(0.9996, abs=1e-4)
    assert "near the unit circle" in found.warning(1)
    assert "degrees" in found.warning(1)
    assert found.warning(10) == ""
    off = FrozenSpectrum(OUTPUT, directions(2, 4), np.array([[0.5, 1.01, 0.7, 0.6]]))
    assert "outside the unit circle" in off.warning(1)
    assert "at 45 degrees: modulus 1.010000" in off.warning(1)
    guaranteed = FrozenSpectrum(STATIONARY, off.directions, off.modulus)
    assert "outside the unit circle" in guaranteed.warning(1)  # rounding knows no theorem
    assert "though H_s(Q_max) is at the end" in guaranteed.warning(1)
    assert guaranteed.unstable(1)
    assert FrozenSpectrum(STATIONARY, off.directions, off.modulus - 0.0101).warning(1) == ""


def test_each_hypothesis_can_fail() -> None:
    asked = weights(1.0, 1.0)
    assert not theorem_holds(machining_centre(), asked, OUTPUT)
    stuck = Discrete(np.diag([1.0, 1.0]), np.array([1e-5, 0.0]), np.ones(2), 0.0005)
    blind = Discrete(np.diag([1.0, 1.1]), np.full(2, 1e-5), np.array([1.0, 0.0]), 0.0005)
    first = theorem_conditions((machining_centre()[0], stuck), asked, STATIONARY)
    assert [condition.holds for condition in first] == [False, False, True, True]
    second = theorem_conditions((blind, machining_centre()[1]), asked, STATIONARY)
    assert [condition.holds for condition in second] == [True, False, True, True]
    assert "axis 0: not at z = 1.1" in second[1].found


@pytest.mark.parametrize(("apart", "seen"), [(1e-6, True), (1e-13, False)])
def test_modes_that_their_output_hardly_tells_apart_are_not_seen(apart: float, seen: bool) -> None:
    pair = Discrete(np.diag([1.0, 1.0 + apart]), np.array([1e-5, -1e-5]), np.ones(2), 0.0005)
    axes = (machining_centre()[0], pair)
    assert theorem_conditions(axes, weights(1.0, 1.0), STATIONARY)[1].holds is seen


def test_the_emitted_numbers_are_looked_at_as_they_are_rounded() -> None:
    wide = of_case("II", FLOAT32)
    for axis, own in zip(in_precision(wide, FLOAT32).axes, wide.axes, strict=True):
        for name in ("first", "error", "slide", "stiffness"):
            exact, rounded = getattr(own.tables, name), getattr(axis.tables, name)
            assert np.array_equal(rounded, exact.astype(np.float32))
            assert not np.array_equal(rounded, exact)


def test_the_tables_have_the_spectrum_of_the_recursion() -> None:
    """Gains of the sliding form in a frozen direction are those of (11), (12)."""
    for name, terminal, asked in (("II", OUTPUT, (1.2, 20.0)), ("IV", STATIONARY, (0.25, 15.0))):
        made = of_case(name)
        expected = frozen_spectrum(machining_centre(), weights(*asked), terminal, 10, 8).modulus[-1]
        for way, modulus in zip(directions(2, 8), expected, strict=True):
            gains = state_gains(made, direction_gains(made, way))
            models = [axis.model for axis in made.axes]
            closed = np.zeros((8, 8))
            closed[:3, :3], closed[3:, 3:] = models[0].a, models[1].a
            closed[:3] += np.outer(models[0].b, gains[0])
            closed[3:] += np.outer(models[1].b, gains[1])
            assert np.max(np.abs(np.linalg.eigvals(closed))) == pytest.approx(modulus, abs=1e-8)


def test_a_table_stands_for_the_gains_between_its_angles() -> None:
    made = of_case("IV")
    coarse, fine = (table_quality(tabulate(made, entries, 4)) for entries in (16, 64))
    assert fine.deviation < 0.003
    assert coarse.deviation > 4.0 * fine.deviation  # linear between entries
    assert fine.modulus < 0.9
    with pytest.raises(DesignError, match="two axes"):
        tabulate(design(1.2, 20.0, OUTPUT, axes=TRIPLE), 64, 4)
    for entries, at in ((3, 4), (64, 0), (64, 11)):
        with pytest.raises(DesignError):
            tabulate(made, entries, at)
    with pytest.raises(DesignError):
        tabulate(of_case("I"), 64, 4)
