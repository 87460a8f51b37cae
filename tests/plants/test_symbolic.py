"""CasADi models: linearisation, resting points, users' files, and what goes wrong with them."""

from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from servogen.plants.build import build_stage
from servogen.plants.errors import PlantError
from servogen.plants.models import servo_model, two_mass_servo_model
from servogen.plants.motion import to_motion_states
from servogen.plants.servo import servo
from servogen.plants.settings import PythonSettings
from servogen.plants.symbolic import SymbolicModel, equilibrium, linearise
from servogen.plants.user_model import load_user_model

DATA = Path(__file__).parent / "data_servo_model.py"
EXAMPLE = Path(__file__).parents[2] / "examples" / "two_stage" / "my_model_example.py"
TWO_MASS = {
    "motor_mass_kg": 20.0,
    "load_mass_kg": 15.0,
    "stiffness_n_per_m": 2.0e6,
    "damper_n_s_per_m": 500.0,
    "bandwidth_rad_per_s": 45.0,
    "damping": 0.8,
}


def pendulum() -> SymbolicModel:
    """Not linear: q'' = -k sin(q) - d q' + c u, so sin(q) = c u / k at rest."""
    q, v, u, k, d = (ca.SX.sym(name) for name in ("q", "v", "u", "k", "d"))
    slopes = {"q": v, "v": -k * ca.sin(q) - d * v + 2 * u}
    return SymbolicModel({"q": q, "v": v}, {"u": u}, {"k": k, "d": d}, slopes, q)


@pytest.mark.parametrize("w", [45.0, 2250.0])
def test_servo_as_expressions_equals_the_transfer_function(w: float) -> None:
    symbolic = linearise(servo_model(), {"bandwidth_rad_per_s": w, "damping": 0.7})
    ours = servo(w, 0.7)
    np.testing.assert_allclose(symbolic.a, ours.a, rtol=1e-12)
    np.testing.assert_allclose(symbolic.b, ours.b, rtol=1e-12)
    np.testing.assert_array_equal(symbolic.c, ours.c)


def test_two_mass_servo_is_a_stage() -> None:
    linear = linearise(two_mass_servo_model(), TWO_MASS)
    plant = to_motion_states(linear)
    assert plant.is_stable
    assert plant.dc_gain == pytest.approx(1.0, rel=1e-12)
    np.testing.assert_allclose(plant.poles, linear.poles, rtol=1e-8)
    for w in (1.0, 45.0, 480.0):
        assert abs(plant.response(w) - linear.response(w)) < 1e-9


def test_stiff_two_mass_servo_moves_like_one_mass() -> None:
    stiff = {**TWO_MASS, "stiffness_n_per_m": 2e9, "damper_n_s_per_m": 1e5}
    plant = linearise(two_mass_servo_model(), stiff)
    for w in (1.0, 20.0, 45.0):
        s = 1j * w
        assert abs(plant.response(w) - 45.0**2 / (s**2 + 72.0 * s + 45.0**2)) < 1e-3


def test_resting_point_and_slope_of_a_model_that_is_not_linear() -> None:
    values = {"k": 4.0, "d": 1.0}
    point = equilibrium(pendulum(), values, 0.5)
    np.testing.assert_allclose(point, [np.arcsin(0.25), 0.0], atol=1e-12)
    linear = linearise(pendulum(), values, 0.5)
    np.testing.assert_allclose(linear.a, [[0, 1], [-4 * np.cos(point[0]), -1]], rtol=1e-12)
    np.testing.assert_allclose(linear.b, [0, 2])


def test_model_that_cannot_rest() -> None:
    with pytest.raises(PlantError, match="resting point"):
        equilibrium(pendulum(), {"k": 0.5, "d": 1.0}, 0.5)
    q, u = ca.SX.sym("q"), ca.SX.sym("u")
    drifts = SymbolicModel({"q": q}, {"u": u}, {}, {"q": u + 1.0}, q)
    with pytest.raises(PlantError, match="resting point"):
        linearise(drifts, {})


@pytest.mark.parametrize(
    ("values", "key"),
    [
        ({"k": 1.0}, "parameters.d"),
        ({"k": 1.0, "d": 1.0, "mass": 2.0}, "parameters.mass"),
        ({"k": 1.0, "d": float("nan")}, "parameters.d"),
        ({"k": 1.0, "d": "2"}, "parameters.d"),
        ({"k": 1.0, "d": True}, "parameters.d"),
    ],
)
def test_parameters_that_do_not_match(values: dict[str, float], key: str) -> None:
    with pytest.raises(PlantError) as caught:
        linearise(pendulum(), values)
    assert caught.value.key == key


def test_models_that_contradict_themselves() -> None:
    q, u, stray = ca.SX.sym("q"), ca.SX.sym("u"), ca.SX.sym("stray")
    good = {"states": {"q": q}, "inputs": {"u": u}, "parameters": {}, "dynamics": {"q": u - q}}
    SymbolicModel(**good, output=q)
    bad = (
        ({"states": {}}, q, "states"),
        ({"inputs": {}}, q, "inputs"),
        ({"inputs": {"u": u, "w": stray}}, q, "inputs"),
        ({"dynamics": {"p": u - q}}, q, "dynamics"),
        ({"dynamics": {"q": u - q + stray}}, q, "q"),
        ({"dynamics": {"q": ca.vertcat(u, q)}}, q, "q"),
        ({"parameters": {"two": ca.SX.sym("two", 2)}}, q, "two"),
        ({"parameters": {"text": "x"}}, q, "text"),
        ({}, stray, "output"),
        ({}, "q", "output"),
    )
    for change, output, key in bad:
        with pytest.raises(PlantError) as caught:
            SymbolicModel(**{**good, **change}, output=output)
        assert caught.value.key == key


def test_output_must_not_contain_the_command() -> None:
    q, u = ca.SX.sym("q"), ca.SX.sym("u")
    model = SymbolicModel({"q": q}, {"u": u}, {}, {"q": u - q}, q + u)
    with pytest.raises(PlantError, match="output"):
        linearise(model, {})


def test_users_file_writes_nothing_beside_it(tmp_path: Path) -> None:
    copy = tmp_path / "model.py"
    copy.write_bytes(DATA.read_bytes())
    model = load_user_model(copy, "servo", {"w": 45.0, "zeta": 0.7})
    assert list(model.states) == ["p", "v", "a"]
    assert [entry.name for entry in tmp_path.iterdir()] == ["model.py"]


@pytest.mark.parametrize(
    ("function", "key", "says"),
    [
        ("nothing", "function", "a function of data_servo_model.py"),
        ("__doc__", "function", "a function of"),
        ("raises", "function", "RuntimeError: no motor today"),
        ("leaves", "function", "SystemExit: 3"),
        ("CALLABLE_BUT_WRONG", "function", "returning dict"),
    ],
)
def test_functions_that_do_not_serve(function: str, key: str, says: str) -> None:
    with pytest.raises(PlantError) as caught:
        load_user_model(DATA, function, {})
    assert caught.value.key == key
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "content", ["this is not python", "import not_a_module_of_anybody", "raise SystemExit", "1/0"]
)
def test_files_that_do_not_run(tmp_path: Path, content: str) -> None:
    file = tmp_path / "model.py"
    file.write_text(content, encoding="utf-8")
    with pytest.raises(PlantError, match="a Python file that runs") as caught:
        load_user_model(file, "servo", {})
    assert caught.value.key == "file"


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    (tmp_path / "latin.py").write_bytes(b"x = '\xe9'")
    for name in ("missing.py", "latin.py", "."):
        with pytest.raises(PlantError, match="can be read"):
            load_user_model(tmp_path / name, "servo", {})


def test_a_dataclass_in_the_users_file_works(tmp_path: Path) -> None:
    file = tmp_path / "model.py"
    head = (
        "from __future__ import annotations\nfrom dataclasses import dataclass\n"
        "@dataclass\nclass Gains:\n    w: float = 1.0\n"
    )
    file.write_text(head + DATA.read_text(encoding="utf-8").split('"""', 2)[2], encoding="utf-8")
    assert load_user_model(file, "servo", {"w": 1.0, "zeta": 0.7}).output is not None


def test_the_shipped_example_is_a_stage() -> None:
    plant = build_stage(PythonSettings(EXAMPLE, "belt_axis", TWO_MASS))
    ours = to_motion_states(linearise(two_mass_servo_model(), TWO_MASS))
    assert plant.order == 4
    np.testing.assert_allclose(plant.a, ours.a, rtol=1e-9, atol=1e-3)
