"""Maximal output-admissible sets: sizes known beforehand, symmetry, determinism, and the proofs."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from servogen.plants.models import two_mass_servo_model
from servogen.plants.motion import to_motion_states
from servogen.plants.servo import servo
from servogen.plants.statespace import StateSpace, discretise
from servogen.plants.symbolic import linearise
from servogen.plants.transfer import transfer_function
from servogen.sets.admissible import AdmissibleSet, maximal_admissible_set
from servogen.sets.constraints import AxisLimits, constraint_rows
from servogen.sets.errors import SetError
from servogen.sets.proofs import check_maximality, prove_admissibility, prove_invariance

LIMITS = AxisLimits(0.4, 0.7, 14.71, 0.035)
T_S = 0.03
SERVO = servo(45.0, 0.7)


def belt() -> StateSpace:
    return to_motion_states(
        linearise(
            two_mass_servo_model(),
            {
                "motor_mass_kg": 20.0,
                "load_mass_kg": 15.0,
                "stiffness_n_per_m": 2.0e6,
                "damper_n_s_per_m": 500.0,
                "bandwidth_rad_per_s": 45.0,
                "damping": 0.8,
            },
        )
    )


def prove(
    target: AdmissibleSet,
    slow: StateSpace,
    limits: AxisLimits = LIMITS,
    time: float = T_S,
    inter: int = 0,
    samples: int = 8,
) -> None:
    """Invariant, admissible and maximal, or the test fails."""
    held = discretise(slow, time)
    invariance = prove_invariance(target, held.a, held.b)
    assert len(invariance.rows) == target.k.size
    assert invariance.holds, invariance.worst
    admissibility = prove_admissibility(target, slow, time, limits, inter)
    assert admissibility.holds, admissibility.worst
    outside = check_maximality(target, slow, time, limits, inter, samples=samples)
    assert outside.points == samples * (target.k.size // 2)
    assert outside.innocent == 0
    assert outside.least_violation > 5e-7
    assert outside.latest_step <= target.finite_step


@pytest.mark.parametrize(
    ("tightening", "rows", "index"), [(0.01, 16, 2), (0.001, 22, 5), (0.0001, 24, 6)]
)
def test_sizes_of_the_machine(tightening: float, rows: int, index: int) -> None:
    target = maximal_admissible_set(SERVO, T_S, LIMITS, tightening)
    assert (target.k.size, target.finite_step) == (rows, index)
    assert 20 <= target.lp_count <= 45
    assert len(target.sources) == rows // 2


@pytest.mark.parametrize(("tightening", "inter"), [(0.05, 0), (0.0001, 0), (0.01, 1), (0.001, 2)])
@pytest.mark.parametrize("slow", [SERVO, servo(20.0, 0.4), belt()], ids=["servo", "soft", "belt"])
def test_proved_for_plants_tightenings_and_instants(
    slow: StateSpace, tightening: float, inter: int
) -> None:
    target = maximal_admissible_set(slow, T_S, LIMITS, tightening, inter)
    prove(target, slow, inter=inter, samples=3)


@settings(max_examples=10, deadline=None, derandomize=True)
@given(
    poles=st.lists(st.floats(5.0, 120.0), min_size=3, max_size=4),
    tightening=st.sampled_from([0.02, 0.002]),
    reach=st.floats(0.005, 0.3),
    pull=st.floats(1.0, 60.0),
)
def test_proved_for_random_plants(
    poles: list[float], tightening: float, reach: float, pull: float
) -> None:
    denominator = np.poly(-np.array(poles))
    slow = transfer_function([float(denominator[-1])], denominator)
    limits = AxisLimits(0.4, 0.7, pull, reach)
    target = maximal_admissible_set(slow, T_S, limits, tightening)
    prove(target, slow, limits, samples=2)


@pytest.mark.parametrize("slow", [SERVO, belt()], ids=["servo", "belt"])
def test_symmetry_and_shift_are_exact(slow: StateSpace) -> None:
    target = maximal_admissible_set(slow, T_S, LIMITS, 0.001, 1)
    half = target.k.size // 2
    np.testing.assert_array_equal(target.h_x[half:], -target.h_x[:half])
    np.testing.assert_array_equal(target.h_r[half:], -target.h_r[:half])
    np.testing.assert_array_equal(target.k, 1.0)
    h_x, h_r, k = target.pairs()
    np.testing.assert_array_equal(h_x, target.h_x[:half])
    assert h_r.shape == k.shape == (half,)
    for i, source in enumerate(target.sources):
        moved = h_x[i, 0] + h_r[i]
        if source.startswith("position"):
            assert moved == pytest.approx(1.0 / 0.4, rel=1e-13)
        elif source.startswith("steady"):
            assert moved == pytest.approx(1.0 / (0.999 * 0.4), rel=1e-13)
        else:
            assert moved == 0.0


def test_inter_sample_rows_only_cut() -> None:
    """More instants, smaller set: an inside point of the finer set is inside the coarser one."""
    coarse = maximal_admissible_set(SERVO, T_S, LIMITS, 0.01)
    fine = maximal_admissible_set(SERVO, T_S, LIMITS, 0.01, 2)
    for row in range(coarse.k.size):
        proof = prove_invariance(
            replace(
                fine,
                h_x=np.vstack([fine.h_x, coarse.h_x[row]]),
                h_r=np.append(fine.h_r, coarse.h_r[row]),
                k=np.append(fine.k, 10.0),
            ),
            np.eye(3),
            np.zeros(3),
        )
        assert proof.rows[-1].excess + 10.0 <= 1.0 + 1e-8


@pytest.mark.parametrize("inter", [0, 1, 2, 4])
def test_constraint_rows_at_the_sub_instants(inter: int) -> None:
    """Against the stage stepped in sixtieths of T_s: the rows say what happens in between."""
    rows = constraint_rows(SERVO, T_S, LIMITS, inter)
    fine = discretise(SERVO, T_S / 60)
    x, command = np.array([0.1, 0.2, -3.0]), 0.11
    state, wanted, names = x, [], []
    for tick in range(60):
        if tick % (60 // (inter + 1)) == 0:
            wanted += [x[0] / 0.4, x[1] / 0.7, x[2] / 14.71, (x[0] - command) / 0.035]
            j = tick * (inter + 1) // 60
            names.append(f"acceleration at {j}/{inter + 1}" if j else "acceleration")
        x = fine.a @ x + fine.b * command
    np.testing.assert_allclose(rows.x_rows @ state + rows.r_rows * command, wanted, rtol=1e-9)
    assert list(rows.names[2::4]) == names


def test_membership() -> None:
    target = maximal_admissible_set(SERVO, T_S, LIMITS, 0.01)
    rest = np.array([0.3, 0.0, 0.0])
    assert target.contains(rest, 0.3)
    assert target.excess(rest, 0.3) < -0.01
    assert target.contains(np.array([0.396, 0.0, 0.0]), 0.396, 1e-12)
    assert not target.contains(np.array([0.397, 0.0, 0.0]), 0.397)
    assert not target.contains(rest, 0.34)
    assert not target.contains(np.array([0.3, 0.71, 0.0]), 0.3)


def test_proofs_see_a_set_too_large_and_one_too_small() -> None:
    """The proofs can fail: loosened is not admissible, shrunk is not maximal, cut not invariant."""
    target = maximal_admissible_set(SERVO, T_S, LIMITS, 0.01)
    held = discretise(SERVO, T_S)
    loose = replace(target, k=target.k * 1.001)
    assert not prove_admissibility(loose, SERVO, T_S, LIMITS).holds
    small = replace(target, k=target.k * 0.999)
    assert check_maximality(small, SERVO, T_S, LIMITS).innocent > 0
    cut = replace(target, h_x=target.h_x * [1.0, 1.3, 1.0])
    assert not prove_invariance(cut, held.a, held.b).holds
    first = [i for i, name in enumerate(target.sources) if "sample 0" in name or "steady" in name]
    kept = [*first, *(i + target.k.size // 2 for i in first)]
    early = replace(target, h_x=target.h_x[kept], h_r=target.h_r[kept], k=target.k[kept])
    assert prove_admissibility(early, SERVO, T_S, LIMITS).holds
    assert not prove_invariance(early, held.a, held.b).holds


def test_same_bits_every_time() -> None:
    """Also in another process with another hash seed."""
    program = (
        "from servogen.plants.servo import servo\n"
        "from servogen.sets.admissible import maximal_admissible_set\n"
        "from servogen.sets.constraints import AxisLimits\n"
        "t = maximal_admissible_set(servo(45.0, 0.7), 0.03,"
        " AxisLimits(0.4, 0.7, 14.71, 0.035), 0.001, 1)\n"
        "print(t.h_x.tobytes().hex(), t.h_r.tobytes().hex(), t.sources)"
    )
    texts = {
        subprocess.run(
            [sys.executable, "-c", program],
            env={"PYTHONHASHSEED": seed},
            check=True,
            capture_output=True,
            text=True,
        ).stdout
        for seed in ("1", "2")
    }
    assert len(texts) == 1
    target = maximal_admissible_set(SERVO, T_S, LIMITS, 0.001, 1)
    assert target.h_x.tobytes().hex() in texts.pop()


def test_arrays_cannot_be_written() -> None:
    target = maximal_admissible_set(SERVO, T_S, LIMITS, 0.01)
    for array in (target.h_x, target.h_r, target.k):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0


@pytest.mark.parametrize("tightening", [0.0, 1.0, -0.1, float("nan")])
def test_bad_tightening(tightening: float) -> None:
    with pytest.raises(SetError, match="steady_state_tightening"):
        maximal_admissible_set(SERVO, T_S, LIMITS, tightening)


@pytest.mark.parametrize("field", range(4))
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf")])
def test_bad_limits(field: int, value: float) -> None:
    numbers = [0.4, 0.7, 14.71, 0.035]
    numbers[field] = value
    with pytest.raises(SetError, match="positive finite limit"):
        AxisLimits(*numbers)


def test_bad_stages_and_counts() -> None:
    unstable = StateSpace(np.eye(3, k=1), np.eye(3)[2], np.eye(3)[0])
    with pytest.raises(SetError, match="stable"):
        maximal_admissible_set(unstable, T_S, LIMITS, 0.01)
    half = StateSpace(SERVO.a, SERVO.b * 0.5, SERVO.c)
    with pytest.raises(SetError, match="dc gain"):
        maximal_admissible_set(half, T_S, LIMITS, 0.01)
    short = StateSpace(-np.eye(2), np.ones(2), np.eye(2)[0])
    with pytest.raises(SetError, match="at least 3"):
        maximal_admissible_set(short, T_S, LIMITS, 0.01)
    with pytest.raises(SetError, match="inter_sample_rows"):
        maximal_admissible_set(SERVO, T_S, LIMITS, 0.01, -1)
    with pytest.raises(SetError, match="determined within 3 samples"):
        maximal_admissible_set(SERVO, T_S, LIMITS, 0.0001, max_steps=3)


def test_hopeless_setting_is_given_up_soon() -> None:
    """A soft stage sampled far too fast: thousands of rows, refused at a few hundred."""
    with pytest.raises(SetError, match="600 rows"):
        maximal_admissible_set(servo(5.0, 0.1), 0.001, LIMITS, 1e-5, 2, max_steps=10_000)
