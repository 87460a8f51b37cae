"""What a parametric program accepts, refuses and recognises, and the coordinates it is seen in."""

import numpy as np
import pytest
from explicit_problems import random_program, servo_drive, transport

from servogen.explicit.errors import ExplicitError
from servogen.explicit.image import canonical
from servogen.explicit.problem import parameter_box, parametric_qp

EYE = np.eye(2)


@pytest.mark.parametrize(
    ("hessian", "text"),
    [
        ([[1.0, 1.0], [1.0, 1.0]], "positive definite"),
        ([[1.0, 0.0], [0.0, -1.0]], "positive"),
        ([[1.0, 0.5], [0.0, 1.0]], "symmetric"),
        ([[1.0, 0.0], [0.0, np.nan]], "finite"),
        ([[1.0]], "shape"),
    ],
)
def test_hessian_that_is_no_use(hessian: list[list[float]], text: str) -> None:
    with pytest.raises(ExplicitError, match=text):
        parametric_qp(hessian, EYE)


def test_units_are_no_lack_of_convexity() -> None:
    """A variable in microamperes beside one in kiloamperes."""
    parametric_qp(np.diag([1e-12, 1e12]), EYE)


def test_other_refusals() -> None:
    with pytest.raises(ExplicitError, match="less than"):
        parametric_qp(EYE, EYE, lower=[0.0, 1.0], upper=[1.0, 1.0])
    with pytest.raises(ExplicitError, match="first_move"):
        parametric_qp(EYE, EYE, first_move=3)
    with pytest.raises(ExplicitError, match="matrix"):
        parametric_qp(EYE, [1.0, 2.0])
    with pytest.raises(ExplicitError, match="row of zeros"):
        parametric_qp(EYE, EYE, rows=[[0.0, 0.0]], bounds=[-1.0])
    with pytest.raises(ExplicitError, match="parameter that matters"):
        canonical(parametric_qp(EYE, np.zeros((2, 1)), upper=[1.0, 1.0]))
    box = parameter_box([1.0, 0.0], [0.0, 1.0])
    with pytest.raises(ExplicitError, match="lower limits below"):
        canonical(parametric_qp(EYE, [[1.0, 1.0]] * 2, lower=[-1.0, -1.0], upper=[1.0, 1.0],
                                domain_rows=box[0], domain_bounds=box[1]))  # fmt: skip


def test_bounds_are_recognised_as_rows() -> None:
    """Single-entry rows become bounds, the tightest wins; rows of zeros limit the parameters."""
    qp = parametric_qp(
        EYE,
        EYE,
        rows=[[2.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -4.0], [0.0, 1.0], [0.0, 0.0]],
        bounds=[2.0, 3.0, 5.0, 8.0, 1.0, 7.0],
        bounds_parameter=[[0.0, 0.0]] * 5 + [[0.0, -1.0]],
    )
    assert qp.is_box
    np.testing.assert_array_equal(qp.upper, [1.0, 1.0])
    np.testing.assert_array_equal(qp.lower, [-3.0, -2.0])
    np.testing.assert_array_equal(qp.domain_rows, [[0.0, 1.0]])
    np.testing.assert_array_equal(qp.domain_bounds, [7.0])
    assert not random_program(1, 2, 2, 3).is_box
    assert not parametric_qp(EYE, EYE, lower=[-1.0, -np.inf]).is_box


def test_bounds_that_move_with_parameters_are_rows() -> None:
    qp = parametric_qp(EYE, EYE, rows=[[1.0, 0.0]], bounds=[1.0], bounds_parameter=[[0.0, 0.5]])
    assert qp.rows.shape == (1, 2)
    assert not qp.is_box


def test_servo_is_seen_in_shares_of_the_bounds() -> None:
    """Eight parameters of four units, three coordinates; +-1 where the optimum meets a bound."""
    qp = servo_drive(3)
    image = canonical(qp).image
    assert qp.parameters == 8
    assert image.size == 3
    slope, offset = qp.unconstrained()
    theta = np.linspace(-1.0, 1.0, 8)
    np.testing.assert_allclose(image.of(theta), (slope @ theta + offset) / 1000.0, rtol=1e-12)


def test_parameters_that_do_nothing_are_dropped() -> None:
    """Five parameters that act through two combinations."""
    generator = np.random.default_rng(3)
    mix = generator.normal(size=(2, 5))
    qp = parametric_qp(
        np.diag([1.0, 2.0, 3.0]), generator.normal(size=(3, 2)) @ mix,
        rows=generator.normal(size=(4, 3)), bounds=np.ones(4),
        bounds_parameter=generator.normal(size=(4, 2)) @ mix,
    )  # fmt: skip
    assert canonical(qp).image.size == 2


def test_a_box_of_parameters_is_projected() -> None:
    """Every image of the box satisfies the projected rows, and each row is met by some corner."""
    program = canonical(servo_drive(3, inside_box=True))
    qp = servo_drive(3, inside_box=True)
    half = qp.domain_bounds[: qp.parameters]
    corners = np.array(np.meshgrid(*[[-1.0, 1.0]] * qp.parameters)).reshape(qp.parameters, -1).T
    heights = program.image.of(corners * half) @ program.domain_rows.T
    np.testing.assert_allclose(np.max(heights, axis=0), program.domain_bounds, rtol=1e-9)


def test_canonical_form_is_the_same_program() -> None:
    """The slacks of the projection are those of the program, at random z and theta."""
    qp = transport()
    program = canonical(qp)
    g, w, s, _ = qp.all_rows()
    generator = np.random.default_rng(8)
    slope, offset = qp.unconstrained()
    lengths = np.linalg.norm(np.linalg.solve(np.linalg.cholesky(qp.hessian), g.T), axis=0)
    ratios = []
    for _ in range(5):
        theta, z = generator.uniform(0.0, 900.0, 2), generator.normal(size=4) * 100.0
        slack = (w + s @ theta - g @ z) / lengths
        own = np.linalg.solve(program.unscale, z - slope @ theta - offset)
        found = program.w + program.e @ program.image.of(theta) - program.g @ own
        ratios.append(slack / found)
    np.testing.assert_allclose(ratios, np.full_like(ratios, ratios[0][0]), rtol=1e-9)
