"""One axis of the extended command governor: the program, its optimum, properties (b) and (c)."""

from ctypes import c_int
from dataclasses import replace

import daqp
import numpy as np
import pytest
import scipy.signal
from governed_machine import CENTRE, STROKE, T_S, admissible, machine, stage
from hypothesis import given, settings
from hypothesis import strategies as st

from servogen.controllers.command_governor_axis import AxisGovernor
from servogen.controllers.command_governor_declaration import declare_axis_governor
from servogen.controllers.command_governor_design import (
    AxisGovernorDesign,
    GovernorSettings,
    design_axis_governor,
)
from servogen.controllers.command_governor_program import GovernorWeights, governor_program
from servogen.controllers.design import Status
from servogen.precision import FLOAT32, FLOAT64, Precision
from servogen.sets.extended import ExtendedSet

HORIZON = 12
WIDE = np.full(HORIZON + 2, 9.0)


def axis_design(cap: int = 150, sub_step: bool = False, margin: float = 0.0) -> AxisGovernorDesign:
    chosen = GovernorSettings(cap=cap, sub_step_stroke=sub_step, stroke_margin_m=margin)
    return machine(HORIZON, chosen).axes[0]


def to_register(plan: np.ndarray) -> tuple[np.ndarray, float]:
    """Entries of the shift register and rho."""
    return plan[:-1] - plan[-1], float(plan[-1])


def chain(target: ExtendedSet, seed: int, count: int) -> np.ndarray:
    """(count, n + aux + 1) points of the set by hit and run, positions about the middle."""
    generator = np.random.default_rng(seed)
    rows, points = target.rows, []
    scale = 1.0 / np.max(np.abs(rows), axis=0)
    point = np.zeros(rows.shape[1])
    for _ in range(count):
        for _ in range(4):
            direction = generator.normal(size=point.size) * scale
            along, at = rows @ direction, rows @ point
            ends = np.sort((np.sign(along) * [[1.0], [-1.0]] - at) / along, axis=0)
            # seldom in the middle: what may go wrong is at the ends
            share = generator.beta(0.4, 0.4)
            point = point + direction * ((1 - share) * np.max(ends[0]) + share * np.min(ends[1]))
        point = point * (1.0 - 1e-9)
        points.append(point)
    return np.array(points)


def begun(axis: AxisGovernor, point: np.ndarray) -> np.ndarray:
    """The state one period after ``point``, whose register and rho are the axis's plan then."""
    n = axis.design.plant.order
    state = point[:n] + np.eye(n)[0] * CENTRE
    plan = np.append(point[n:-1], 0.0) + point[-1] + CENTRE
    axis.reset(float(np.clip(state[0], 0.0, 0.25)))
    axis.plan = plan.copy()
    return axis.design.plant.a @ state + axis.design.plant.b * plan[0]


def test_rows_are_those_of_the_set() -> None:
    """Each row of P-tilde that holds a decision, in other variables, and positions to hold by."""
    target, program = admissible(HORIZON), axis_design().program
    change = np.eye(HORIZON + 1)
    change[:-1, -1] = -1.0
    wanted = np.column_stack([target.h_aux, target.h_rho]) @ change
    found = program.written / program.limit[:, None]
    used = set()
    for source, row in zip(target.sources, wanted, strict=True):
        if np.any(row):
            distance = np.linalg.norm(found - row, axis=1)
            assert np.min(distance) < 1e-10 * np.linalg.norm(row), source
            used.add(int(np.argmin(distance)))
    others = [i for i in range(program.rows.count) if i not in used]
    assert 4 <= len(others) <= 20
    assert np.all(program.first[others] == HORIZON + 1)


@pytest.mark.parametrize("sub_step", [False, True])
def test_declared_layout_is_that_of_all_rows(sub_step: bool) -> None:
    """The tables of one period, written out for all of them."""
    design = axis_design(sub_step=sub_step)
    program, declared = design.program, declare_axis_governor(design)
    table = {t.name: t.values for t in declared.tables}
    limit, moves, first, second = [], [], [], []
    for i in range(HORIZON + 1):
        limit += list(table["step_limit"])
        moves += list(table["step_moves"])
        first += [i if kind else -1 for kind in table["step_stroke"]]
        second += [i + (kind == 2) if kind else -1 for kind in table["step_stroke"]]
    limit += list(table["end_limit"])
    moves += list(table["end_moves"])
    held = [HORIZON + 1 if kind else -1 for kind in table["end_stroke"]]
    np.testing.assert_array_equal(limit, program.limit)
    np.testing.assert_array_equal(moves, program.position)
    np.testing.assert_array_equal(first + held, program.first)
    np.testing.assert_array_equal(second + held, program.second)
    constant = {c.name: c.value for c in declared.constants}
    assert list(np.flatnonzero(program.settle)) == [program.rows.count - 1]
    assert constant["settle"] == program.settle[-1]
    own = [values.size for name, values in table.items() if name.startswith(("step_", "end_"))]
    assert sum(own) == 3 * (6 + program.rows.count - program.rows.stages)
    assert declared.fingerprint()["prefix"] == "governor_x"


def test_the_stroke_holds_where_the_set_has_no_position_row() -> None:
    """Implied rows are left out of a set, but not of what the stroke bounds."""
    whole = admissible(HORIZON)
    end = 3 * (HORIZON + 1)
    gone = {("position", t) for t in (1, 2, 3, 14, end + 3)}
    gone |= {("position", t) for t in range(2, end, 3)}
    keep = [i for i, source in enumerate(whole.sources) if source not in gone]
    less = replace(
        whole,
        h_x=whole.h_x[keep],
        h_aux=whole.h_aux[keep],
        h_rho=whole.h_rho[keep],
        sources=tuple(whole.sources[i] for i in keep),
    )
    for sub_step, most in ((True, 3), (False, 1)):
        wanted, found = (
            governor_program(
                stage(), target, GovernorWeights(), sub_step, 0.0, np.dtype(np.float64)
            )
            for target in (whole, less)
        )
        bounded = [p.rows.count - np.count_nonzero(p.first < 0) for p in (wanted, found)]
        assert bounded[0] == bounded[1] > most * (HORIZON + 1) + 4


def daqp_plan(
    target: ExtendedSet, state: np.ndarray, reference: np.ndarray, low: np.ndarray, high: np.ndarray
) -> np.ndarray | None:
    """(17) in the register's entries, as the paper has it; responses by scipy, not by servogen."""
    pole = 20.0
    a = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-(pole**3), -3 * pole**2, -3 * pole]])
    system = (a, np.array([[0.0], [0.0], [pole**3]]), np.eye(3), np.zeros((3, 1)))
    a_d, b_d, *_ = scipy.signal.cont2discrete(system, T_S)
    n = HORIZON + 1
    moved = state - [CENTRE, 0.0, 0.0]
    free = target.h_x @ moved
    rows = [np.column_stack([target.h_aux, target.h_rho])]
    least, most = [-1.0 - free], [1.0 - free]
    response, own = np.zeros((3, n)), state.copy()
    for k in range(n):
        command = np.zeros(n)
        command[-1] = 1.0
        if k < HORIZON:
            command[k] = 1.0
        response = a_d @ response + np.outer(b_d[:, 0], command)
        own = a_d @ own
        rows.append(response[:1] / STROKE)
        offset = own[0] + response[0, -1] * 0.0
        least.append(np.array([(max(low[k], low[k + 1]) - offset) / STROKE]))
        most.append(np.array([(min(high[k], high[k + 1]) - offset) / STROKE]))
    # rho is counted from the middle in the set's rows, from zero in the others
    shift = target.h_rho * CENTRE
    least[0], most[0] = least[0] + shift, most[0] + shift
    cost = np.diag([*([3.0] * HORIZON), 0.01])
    wished = np.append(reference[:-1] - reference[-1], reference[-1])
    matrix = np.vstack(rows)
    z, _, flag, _ = daqp.solve(
        2.0 * cost, -2.0 * cost @ wished, matrix, np.concatenate(most), np.concatenate(least),
        np.zeros(len(matrix), dtype=c_int), primal_tol=1e-10, dual_tol=1e-12,
    )  # fmt: skip
    return z if flag == 1 else None


@pytest.mark.parametrize("stroke", [False, True])
def test_optimum_is_daqps(stroke: bool) -> None:
    """From states of the set, for references that jump about; with stroke bounds around the plan
    that is there and, to keep the two programs alike, no point to hold at the end."""
    axis, target = AxisGovernor(axis_design()), admissible(HORIZON)
    generator = np.random.default_rng(3)
    active = 0
    for point in chain(target, 7, 40):
        state = begun(axis, point)
        reference = generator.uniform(0.01, 0.24, HORIZON + 1)
        low, high = -WIDE, WIDE
        if stroke:
            reach = axis.foresee(state)
            room = generator.uniform(0.0, 0.01, HORIZON + 2)
            # around the positions of the moved plan: least = highest - stroke
            low, high = reach.greatest - STROKE - room, reach.least + STROKE + room
            low, high = np.minimum(low, high - 2e-6), np.maximum(high, low + 2e-6)
            low[-1], high[-1] = -9.0, 9.0
        moved = axis.moved()
        status, iterations = axis.step(state, reference, low, high)
        wanted = daqp_plan(target, state, reference, low, high)
        if status is not Status.OK or wanted is None:
            # the margin may leave no point where the plan before was at a corner of the set
            assert status is Status.BACKUP
            np.testing.assert_array_equal(axis.plan, moved)
            continue
        active += iterations > 0
        entries, rho = to_register(axis.plan)
        np.testing.assert_allclose([*entries, rho], wanted, atol=3e-6)
    assert active > 25


@pytest.mark.parametrize("cap", [150, 1])
def test_recursive_feasibility_from_states_of_the_set(cap: int) -> None:
    """(b): whatever is asked and however few iterations there are, the next point is in the set;
    so every limit holds at the next instants too, seen by driving the stage."""
    axis, target = AxisGovernor(axis_design(cap)), admissible(HORIZON)
    generator = np.random.default_rng(11)
    statuses = []
    for point in chain(target, 5, 600):
        state = begun(axis, point)
        reference = generator.uniform(-0.1, 0.35, HORIZON + 1)
        status, iterations = axis.step(state, reference, -WIDE, WIDE)
        statuses.append(status)
        assert iterations <= cap
        entries, rho = to_register(axis.plan)
        assert target.contains(state, entries, rho, 1e-8)
        ahead = axis.design.plant.a @ state + axis.design.plant.b * axis.plan[0]
        assert target.contains(ahead, np.append(entries[1:], 0.0), rho, 1e-8)
    backups = statuses.count(Status.BACKUP)
    assert set(statuses) <= {Status.OK, Status.BACKUP}
    assert backups > 400 if cap == 1 else backups < 60


@pytest.mark.parametrize("wished", [0.1, 0.3, -0.2])
def test_finite_convergence_to_the_nearest_steady_command(wished: float) -> None:
    """(c): after finitely many periods the command is the nearest one in V', and stays it."""
    axis = AxisGovernor(axis_design())
    axis.reset(0.2)
    state = np.array([0.2, 0.0, 0.0])
    end = float(np.clip(wished, CENTRE - 0.995 * 0.125, CENTRE + 0.995 * 0.125))
    commands = []
    for _ in range(150):
        status, _ = axis.step(state, np.full(HORIZON + 1, wished), -WIDE, WIDE)
        assert status is Status.OK
        commands.append(axis.plan[0])
        state = axis.design.plant.a @ state + axis.design.plant.b * axis.plan[0]
    reached = np.flatnonzero(np.abs(np.array(commands) - end) > 1e-7)[-1] + 1
    assert 5 < reached < 130
    np.testing.assert_allclose(commands[reached:], end, atol=1e-7)


def test_free_optimum_is_the_reference_itself() -> None:
    axis = AxisGovernor(axis_design())
    axis.reset(0.1)
    reference = 0.1 + 1e-4 * np.arange(HORIZON + 1)
    status, iterations = axis.step(np.array([0.1, 0.0, 0.0]), reference, -WIDE, WIDE)
    assert (status, iterations) == (Status.OK, 0)
    np.testing.assert_allclose(axis.plan, reference, rtol=1e-14)


@settings(max_examples=30, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**16), sub_step=st.booleans())
def test_foreseen_points_are_those_within_the_stroke(seed: int, sub_step: bool) -> None:
    """The moved plan driven by hand at the instants; at the ends alone without the option."""
    axis = AxisGovernor(axis_design(sub_step=sub_step, margin=0.002))
    target = admissible(HORIZON)
    state = begun(axis, chain(target, seed, 1)[0])
    reach = axis.foresee(state)
    a, b = _sub_step()
    plan, instants = axis.moved(), [state[0]]
    own = state.copy()
    for k in range(HORIZON + 1):
        for _ in range(3):
            own = a @ own + b * plan[k]
            instants.append(own[0])
    stroke = 0.023 - 1e-6 * STROKE
    for i in range(HORIZON + 1):
        seen = instants[3 * i : 3 * i + 4] if sub_step else [instants[3 * i], instants[3 * i + 3]]
        assert reach.least[i] == pytest.approx(max(seen) - stroke, abs=1e-12)
        assert reach.greatest[i] == pytest.approx(min(seen) + stroke, abs=1e-12)
    # what follows: the end, all that comes, and rho
    for _ in range(200):
        own = a @ own + b * plan[-1]
        instants.append(own[0])
    after = instants[3 * (HORIZON + 1) :: 1 if sub_step else 3]
    settle = axis.design.program.settle_m
    assert 0.0 < settle <= 0.001 * STROKE
    bounded = max(max(after), plan[-1] + settle), min(min(after), plan[-1] - settle)
    assert reach.least[-1] == pytest.approx(bounded[0] - stroke, abs=1e-12)
    assert reach.greatest[-1] == pytest.approx(bounded[1] + stroke, abs=1e-12)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_rho_keeps_away_from_the_end_of_the_stroke_by_what_is_left_then(side: float) -> None:
    axis = AxisGovernor(axis_design())
    axis.reset(0.1)
    low, high = np.full(HORIZON + 2, 0.09), np.full(HORIZON + 2, 0.11)
    reference = np.full(HORIZON + 1, 0.1 + side * 0.03)
    assert axis.step(np.array([0.1, 0.0, 0.0]), reference, low, high)[0] is Status.OK
    settle = axis.design.program.settle_m
    end = 0.1 + side * (0.01 - settle - 1e-6 * STROKE)
    assert axis.plan[-1] == pytest.approx(end, abs=2e-6 * STROKE)
    assert abs(axis.plan[-1] - 0.1) <= 0.01 - settle


def _sub_step() -> tuple[np.ndarray, np.ndarray]:
    pole = 20.0
    a = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-(pole**3), -3 * pole**2, -3 * pole]])
    system = (a, np.array([[0.0], [0.0], [pole**3]]), np.eye(3), np.zeros((3, 1)))
    a_d, b_d, *_ = scipy.signal.cont2discrete(system, T_S / 3)
    return a_d, b_d[:, 0]


def test_prediction_is_the_stage_under_the_command() -> None:
    axis = AxisGovernor(axis_design())
    names = ("position", "velocity", "acceleration")
    point = chain(admissible(HORIZON), 2, 1)[0]
    state = begun(axis, point)
    axis.step(state, np.full(HORIZON + 1, 0.12), -WIDE, WIDE)
    status, out = axis.call("predict", dict(zip(names, state, strict=True)))
    a, b = _sub_step()
    own = state
    for _ in range(3):
        own = a @ own + b * axis.plan[0]
    assert status is Status.OK
    np.testing.assert_allclose([out[name] for name in names], own, rtol=1e-9, atol=1e-12)
    bad = {"position": float("nan"), "velocity": 0.0, "acceleration": 0.0}
    status, out = axis.call("predict", bad)
    assert status is Status.NOT_FINITE
    np.testing.assert_array_equal([out[name] for name in names], axis.predicted)


def test_single_precision_follows() -> None:
    """The same closed loop to a tenth of a millimetre, and inside the set to what it resolves."""
    target = admissible(HORIZON)
    axes = [
        AxisGovernor(design_axis_governor("a", p, stage(), target, GovernorSettings()))
        for p in (FLOAT64, FLOAT32)
    ]
    states = [np.array([0.05, 0.0, 0.0]) for _ in axes]
    for axis in axes:
        axis.reset(0.05)
    for k in range(60):
        reference = 0.05 + 0.1 * np.clip((np.arange(HORIZON + 1) + k - 10) / 40.0, 0.0, 1.0)
        for i, axis in enumerate(axes):
            dtype = axis.design.precision.dtype
            state = states[i].astype(dtype)
            bounds = (-WIDE.astype(dtype), WIDE.astype(dtype))
            status, _ = axis.step(state, reference.astype(dtype), *bounds)
            assert status in (Status.OK, Status.BACKUP)
            entries, rho = to_register(axis.plan.astype(float))
            assert target.contains(states[i], entries, rho, 1e-9 if i == 0 else 2e-5)
            plant = axis.design.plant
            states[i] = plant.a @ states[i] + plant.b * float(axis.plan[0])
        np.testing.assert_allclose(states[1][0], states[0][0], atol=1e-4)


@pytest.mark.parametrize("cap", [1, 3, 5, 12])
@pytest.mark.parametrize("precision", [FLOAT64, FLOAT32])
def test_at_rest_calls_at_the_cap_are_one_call_in_pieces(precision: Precision, cap: int) -> None:
    """As many iterations as without a cap, and the same plan to the last bit; in float32 many of
    these programs take refinements."""
    own = machine(8, precision=precision).axes[0]
    pieces, whole = (replace(own, solver=replace(own.solver, cap=c)) for c in (cap, 2000))
    rng, several = np.random.default_rng(5), 0
    n, stroke = own.program.variables, own.program.stroke_m
    state = np.zeros(3, dtype=precision.dtype)
    state[0] = centre = own.program.centre_m
    for index in range(24):
        room = stroke * rng.choice([[0.02, 0.2, 0.9], [0.0005, 0.003, 0.02]][index % 2])
        jumps = rng.choice([-1.0, 1.0], n) * rng.choice([0.1, 1.0, 10.0], n) * rng.random(n)
        reference = np.clip(centre + stroke * jumps, 0.0, 0.25).astype(precision.dtype)
        low = (centre - room * (1.0 - 0.9 * rng.random(own.intervals))).astype(precision.dtype)
        high = (centre + room * (1.0 - 0.9 * rng.random(own.intervals))).astype(precision.dtype)
        at_once, capped = AxisGovernor(whole), AxisGovernor(pieces)
        for one in (at_once, capped):
            one.reset(centre)
        status, most = at_once.step(state, reference, low, high)
        if status is not Status.OK or most <= cap:
            continue
        taken, told = 0, Status.BACKUP
        while told is Status.BACKUP:
            told, iterations = capped.step(state, reference, low, high)
            taken += iterations
        assert (told, taken) == (Status.OK, most)
        assert np.array_equal(capped.plan, at_once.plan)
        several += 1
    assert several >= 5
