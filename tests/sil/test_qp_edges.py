"""The active-set method in C at the edge of its inputs: the cap, bounds met, no number, too far."""

from __future__ import annotations

import numpy as np
import pytest
from qp_programs import CAP, CAPPED, as_calls, designs, in_c, random_inputs, run_all, step

from servogen.controllers.design import Status
from servogen.controllers.qp_solver import QpSolver
from servogen.controllers.qp_solver_design import design_qp_solver
from servogen.precision import PRECISIONS


def test_the_cap_is_the_last_iteration_that_counts() -> None:
    """min |z - a|^2 / 2 in a box: an iteration for every bound that holds, one that says so."""
    outside = {1: [-2.0, 0.0, 0.0], 2: [-2.0, -3.0, 0.0], 3: [-2.0, -3.0, -4.0]}
    wide = np.array([-1.0, -1.0, -1.0, -9.0])
    for name, cap in CAPPED.items():
        for bounds, linear in outside.items():
            controller = in_c(name)
            controller.call("reset")
            assert step(controller, [0.5, 0.0, 0.0], wide, -wide)[0] is Status.OK
            status, z, iterations = step(controller, linear, wide, -wide)
            reached = bounds + 1 <= cap
            assert status is (Status.OK if reached else Status.BACKUP)
            assert iterations == min(bounds + 1, cap)
            held = np.clip(-np.array(linear), -1.0, 1.0) if reached else [-0.5, 0.0, 0.0]
            np.testing.assert_allclose(z, held, atol=1e-15)
            # what the cap left of rows that hold is no worse a beginning than any other
            status, z, _ = step(controller, [0.25, 0.0, 0.0], wide, -wide)
            assert status is Status.OK
            np.testing.assert_allclose(z, [-0.25, 0.0, 0.0], atol=1e-15)


def test_a_point_on_its_bound_is_inside_and_one_beyond_what_is_accepted_is_not() -> None:
    controller = in_c("cap_3")
    controller.call("reset")
    for beyond, iterations in ((0.0, 0), (0.5e-9, 0), (2e-9, 2)):
        given = [-1.0 - beyond, 0.0, 0.0]
        status, z, spent = step(controller, given, np.full(4, -9.0), [1.0, 9.0, 9.0, 9.0])
        assert (status, spent) == (Status.OK, iterations)
        assert z[0] <= 1.0 + 1e-9
    # both bounds the same: an equality
    status, z, _ = step(controller, [0.0, 0.0, 0.0], [0.5, -9.0, -9.0, -9.0], [0.5, 9.0, 9.0, 9.0])
    assert status is Status.OK
    np.testing.assert_allclose(z, [0.5, 0.0, 0.0], atol=1e-15)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1.1e90, -1.1e90])
@pytest.mark.parametrize("port", ["linear", "low", "high"])
def test_an_input_that_is_none_leaves_the_last_answer(port: str, value: float) -> None:
    for precision, far in (("float64", 1.0), ("float32", 1e-81)):
        name = "two_inputs"
        reference, controller = QpSolver(designs(precision)[name]), in_c(name, precision)
        given = next(as_calls(random_inputs(name, precision, 2, 9))).inputs
        good = {key: np.array(array) for key, array in given.items()}
        bad = {key: array.copy() for key, array in good.items()}
        bad[port][-1] = value * far
        for solver in (reference, controller):
            assert solver.call("step", good)[0] is Status.NOT_READY
            solver.call("reset")
            assert np.all(solver.call("step", bad)[1]["z"] == 0.0)
            before = solver.call("step", good)
            status, out = solver.call("step", bad)
            infinite = not np.isfinite(value)
            assert status is (Status.NOT_FINITE if infinite else Status.OUT_OF_RANGE)
            np.testing.assert_array_equal(out["z"], before[1]["z"])
            assert out["iterations"] == 0
            after = solver.call("step", good)
            assert before[0] is after[0] is Status.OK
            np.testing.assert_allclose(after[1]["z"], before[1]["z"], rtol=1e-5, atol=1e-5)


def test_the_largest_inputs_are_taken() -> None:
    """The quick question says no, the exact one says yes."""
    controller = in_c("cap_3")
    controller.call("reset")
    far = np.full(4, 1e90)
    assert step(controller, [0.5, 0.0, 0.0], -far, far)[0] is Status.OK
    beyond = np.nextafter(far, np.inf)
    assert step(controller, [0.5, 0.0, 0.0], -far, beyond)[0] is Status.OUT_OF_RANGE


def test_bounds_that_have_changed_places_are_infeasible() -> None:
    for name in ("box_7", "random_20", "two_inputs"):
        given = random_inputs(name, "float64", 8, 11)[:4]
        for i in range(len(given)):
            row = i % given["low"].shape[1]
            middle = 0.5 * (given["low"][i, row] + given["high"][i, row])
            given["low"][i, row], given["high"][i, row] = middle + 1e-3, middle - 1e-3
        reference = QpSolver(designs("float64")[name])
        reference.call("reset")
        out, status = run_all(name, given)
        assert np.all(status == Status.INFEASIBLE), (name, status, out["iterations"])
        for one, expected in zip(as_calls(given), out["iterations"], strict=True):
            assert reference.call("step", one.inputs)[1]["iterations"] == expected
    # by less than what is accepted: any point between them will do
    controller = in_c("cap_3")
    controller.call("reset")
    low, high = np.full(4, -9.0), np.full(4, 9.0)
    low[0], high[0] = 1.0 + 0.4e-9, 1.0 - 0.4e-9
    status, z, _ = step(controller, [0.0, 0.0, 0.0], low, high)
    assert status is Status.OK
    assert abs(z[0] - 1.0) <= 1e-9


def test_a_hessian_that_is_barely_definite() -> None:
    """Eigenvalues 2 and 1e-9: the optimum in a box is on its boundary, and known."""
    controller = in_c("weak")
    controller.call("reset")
    for slope, corner in ((1e-6, -1.0), (-1e-6, 1.0)):
        status, z, _ = step(controller, [slope, -slope], [-1.0, -1.0], [1.0, 1.0])
        assert status is Status.OK
        # rows are accepted to 1e-9 of their length in the metric of H^-1, which is 2e4 here
        np.testing.assert_allclose(z, [corner, -corner], atol=3e-5)
    flat = np.array([[1.0, 1.0], [1.0, 1.0]])
    for refused in (flat, np.diag([1.0, 0.0]), np.diag([1.0, -1.0])):
        with pytest.raises(ValueError, match="hessian"):
            design_qp_solver("no", PRECISIONS["float64"], refused, np.eye(2), CAP, 1e-9)
