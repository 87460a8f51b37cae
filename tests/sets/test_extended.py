"""P-tilde of paper 4: its known sizes, its proofs, and corners driven by a stage from outside."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
import scipy.signal
from extended_sets import CENTRE, LIMITS, T_S, paper_set, stage

from servogen.plants.transfer import transfer_function
from servogen.sets.auxiliary import laguerre, no_auxiliary, shift_register
from servogen.sets.constraints import AxisLimits
from servogen.sets.errors import SetError
from servogen.sets.extended import ExtendedSet, centred_limits, extended_set
from servogen.sets.extended_proofs import prove_extended_admissibility, prove_extended_invariance
from servogen.sets.polyhedron import maximise

ALL = np.array([LIMITS.position_m, LIMITS.velocity_m_per_s, LIMITS.acceleration_m_per_s2])


@pytest.fixture(scope="module")
def paper() -> ExtendedSet:
    return paper_set(20.0, shift_register(40))


def test_sizes_of_the_paper(paper: ExtendedSet) -> None:
    """Half of each count: a row is two inequalities."""
    assert (paper.inequalities, paper.finite_step) == (824, 17)
    assert 2 * len(paper.h_x) == 544
    kinds = Counter(kind for kind, _ in paper.sources)
    assert 2 * (kinds["position"] + kinds["steady state"]) == 276
    assert (2 * kinds["velocity"], 2 * kinds["acceleration"]) == (266, 2)
    free = ~np.any(np.column_stack([paper.h_aux, paper.h_rho]), axis=1)
    assert 2 * np.count_nonzero(free) == 6


def test_paper_set_is_invariant_and_admissible(paper: ExtendedSet) -> None:
    invariance = prove_extended_invariance(paper, stage(20.0))
    assert len(invariance.rows) == 272
    assert invariance.holds, invariance.worst
    admissibility = prove_extended_admissibility(paper, stage(20.0))
    assert len(admissibility.rows) == 10
    assert admissibility.holds, admissibility.worst


SMALL = {
    "register": (shift_register(8), 3),
    "register, one instant": (shift_register(8), 1),
    "Laguerre": (laguerre(3, 0.6), 2),
    "none": (no_auxiliary(), 4),
}


@pytest.fixture(scope="module", params=SMALL)
def small(request: pytest.FixtureRequest) -> ExtendedSet:
    auxiliary, sub_samples = SMALL[request.param]
    return paper_set(20.0, auxiliary, sub_samples, 0.02)


def test_small_sets_are_invariant_and_admissible(small: ExtendedSet) -> None:
    invariance = prove_extended_invariance(small, stage(20.0))
    assert invariance.holds, invariance.worst
    admissibility = prove_extended_admissibility(small, stage(20.0))
    assert admissibility.holds, admissibility.worst


def driven(target: ExtendedSet, point: np.ndarray, periods: int) -> np.ndarray:
    """Shares of the limits at every instant, the stage sampled by scipy in other coordinates.

    (periods N, 3): position about the middle, velocity, acceleration, from (x', x_aux, rho')."""
    pole, n_aux = 20.0, target.auxiliary.order
    a = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-(pole**3), -3 * pole**2, -3 * pole]])
    system = (a, np.array([[0.0], [0.0], [pole**3]]), np.eye(3), np.zeros((3, 1)))
    a_d, b_d, *_ = scipy.signal.cont2discrete(system, T_S / target.sub_samples)
    state, auxiliary, rho = point[:3].copy(), point[3 : 3 + n_aux].copy(), point[-1]
    seen = []
    for _ in range(periods):
        command = float(target.auxiliary.c @ auxiliary) + rho
        for _ in range(target.sub_samples):
            seen.append(np.abs(state) / ALL)
            state = a_d @ state + b_d[:, 0] * command
        auxiliary = target.auxiliary.a @ auxiliary
    return np.array(seen)


def test_corners_keep_the_limits_and_points_beyond_do_not(small: ExtendedSet) -> None:
    """Admissible and, but for V', the largest set: a corner moved out by a millionth is not."""
    generator = np.random.default_rng(5)
    rows = small.rows
    both, ones = np.vstack([rows, -rows]), np.ones(2 * len(rows))
    for _ in range(15):
        corner = maximise(both, ones, generator.normal(size=len(rows)) @ rows).point
        assert corner is not None
        assert driven(small, corner, 120).max() <= 1.0 + 1e-8
        steady = abs(corner[-1]) / (0.98 * LIMITS.position_m)
        beyond = max(driven(small, corner * (1.0 + 1e-6), 120).max(), steady * (1.0 + 1e-6))
        assert beyond > 1.0 + 5e-7


def test_membership_is_what_driving_says(small: ExtendedSet) -> None:
    """Random points around the boundary, absolute positions."""
    generator = np.random.default_rng(8)
    centre = np.array([CENTRE, 0.0, 0.0])
    inside = 0
    for _ in range(40):
        # rho inside V', the rest of any size: what happens later decides
        direction = generator.normal(size=small.rows.shape[1]) * 0.01
        direction[-1] = generator.uniform(-0.9, 0.9) * LIMITS.position_m
        direction[0] += direction[-1]
        point = direction * [generator.uniform(0.2, 1.8) / np.max(np.abs(small.rows @ direction))]
        if abs(point[-1]) > 0.98 * LIMITS.position_m:
            continue
        found = small.contains(point[:3] + centre, point[3:-1], float(point[-1]) + CENTRE)
        assert found == bool(driven(small, point, 120).max() <= 1.0)
        inside += found
    assert 5 <= inside <= 35


def test_interval_is_the_set_cut_along_rho(small: ExtendedSet) -> None:
    state, auxiliary = np.array([0.2, 0.03, 0.1]), np.zeros(small.auxiliary.order)
    least, most = small.interval(state, auxiliary)
    assert least < most
    for rho in (least, most):
        assert abs(small.excess(state, auxiliary, rho)) < 1e-9
    assert small.excess(state, auxiliary, 0.5 * (least + most)) < -1e-6
    least, most = small.interval(np.array([0.2, 0.2, 0.1]), auxiliary)
    assert not small.contains(np.array([0.2, 0.2, 0.1]), auxiliary, 0.5 * (least + most))


def test_one_quiet_instant_is_not_enough_where_the_stage_rings_within_a_period() -> None:
    """Each period sends it off anew: an instant that adds nothing has ones after it that do."""
    ringing = transfer_function([3200.0 * 20.0], np.polymul([1.0, 160.0], [1.0, 12.0, 400.0]))
    limits = AxisLimits(0.125, 1.0, 1e6, 0.025)
    target = extended_set(ringing, 0.67, laguerre(2, 0.8), 4, limits, 0.0, 0.3)
    added = {instant for _, instant in target.sources if instant > 2 * 4}
    quiet = sorted(set(range(2 * 4 + 1, target.last_instant)) - added)
    invariance = prove_extended_invariance(target, ringing)
    assert invariance.holds, invariance.worst
    assert quiet, "no instant between adds nothing: the case says nothing"


def test_more_auxiliary_freedom_only_adds_states() -> None:
    """What the command governor's set holds, the register's holds with an empty register."""
    governor = paper_set(20.0, no_auxiliary(), 3, 0.02)
    register = paper_set(20.0, shift_register(4), 3, 0.02)
    generator = np.random.default_rng(2)
    for _ in range(200):
        state = generator.uniform(-1.0, 1.0, 3) * ALL + [CENTRE, 0.0, 0.0]
        least, most = governor.interval(state, np.zeros(0))
        wide_least, wide_most = register.interval(state, np.zeros(4))
        if least <= most:
            np.testing.assert_allclose([wide_least, wide_most], [least, most], atol=1e-9)


def test_proofs_can_fail() -> None:
    """Loosened: not admissible. Without its latest rows: not invariant. Another stage: neither."""
    target = paper_set(20.0, shift_register(3), 2, 0.02)
    loose = replace(
        target, h_x=target.h_x * 0.999, h_aux=target.h_aux * 0.999, h_rho=target.h_rho * 0.999
    )
    assert not prove_extended_admissibility(loose, stage(20.0)).holds
    keep = [i for i, (_, instant) in enumerate(target.sources) if instant < 6]
    early = replace(
        target,
        h_x=target.h_x[keep],
        h_aux=target.h_aux[keep],
        h_rho=target.h_rho[keep],
        sources=tuple(target.sources[i] for i in keep),
    )
    assert prove_extended_admissibility(early, stage(20.0)).holds
    assert not prove_extended_invariance(early, stage(20.0)).holds
    assert not prove_extended_invariance(target, stage(30.0)).holds


def test_centre_and_symmetry() -> None:
    target = paper_set(20.0, shift_register(3), 2, 0.02)
    assert target.centre_m == 0.125
    state, auxiliary = np.array([0.05, 0.02, -0.1]), np.array([0.01, -0.02, 0.0])
    mirrored = np.array([0.25, 0.0, 0.0]) - state
    assert target.excess(state, auxiliary, 0.06) == pytest.approx(
        target.excess(mirrored, -auxiliary, 0.19), abs=1e-12
    )


def test_bad_settings() -> None:
    for tightening in (0.0, 1.0, float("nan")):
        with pytest.raises(SetError, match="tightening"):
            paper_set(20.0, no_auxiliary(), 1, tightening)
    with pytest.raises(SetError, match="at least one instant"):
        paper_set(20.0, no_auxiliary(), 0)
    with pytest.raises(SetError, match="4 instants determine"):
        extended_set(stage(20.0), T_S, no_auxiliary(), 3, LIMITS, CENTRE, 1e-4, max_steps=4)
    with pytest.raises(SetError, match="position range"):
        centred_limits(0.25, 0.0, LIMITS)
