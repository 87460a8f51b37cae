"""Every key of a servo drive's file, spoilt in every way: one sentence about it, or a design."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from servogen.errors import InputError
from servogen.project.servo_load import load_servo_project
from servogen.project.servo_schema import ServoFile
from servogen.project.walk import all_keys, tables_of
from servogen.resources import resource_dir
from servogen.systems.servo_drive import mpc_design, pid_design, servo_drive, tracking_problem
from servogen.systems.servo_task import reference_task

EXAMPLE = resource_dir("examples") / "servo_drive" / "servogen.toml"
SPOILS = (
    "nan", "inf", "-1", "0", "0.0", '"a"', "true", "[]", "[[]]", "{}", "1e300", "-1e300", "1e-300",
    "1e999", "9" * 400, "[nan]", "[1e300]", "[1, 2]", "[[1, 2], [3, 4]]", "[[-1.5, 0], [0.1, 1]]",
    "[1e300, 0]", "[0, 1e-300]", "[0, 0]", "[1e-300, 1, 1]", "[0, 0, 0]", "[[1e-300, 0], [1, 1]]",
)  # fmt: skip
Keys = tuple[str, ...]


def _two_mass() -> dict[str, Any]:
    """The example, with all keys and little to compute."""
    raw = tomllib.loads(EXAMPLE.read_text(encoding="utf-8"))
    raw["controller"]["mpc"] |= {"control_horizon": 2, "current_step_limit_ma": 500.0}
    raw["controller"]["estimator"]["measurement_noise_deg"] = 1e-4
    raw["controller"]["lookup"] = {"max_regions": 500, "max_nodes": 500, "search_nodes": 10}
    raw["reference"]["start_deg"] = 1.0
    return raw


def _matrices() -> dict[str, Any]:
    """An axis with ends, by its matrices, that is designed on others."""
    raw = _two_mass()
    model = {"a": [[0.9, 0.0], [0.0005, 1.0]], "b": [0.001, 0.0], "c": [0.0, 57.0]}
    raw["drive"] = {"model": "matrices"} | model
    bound = {"position_bound_deg": [-300, 400], "position_bound_samples": [1, 50]}
    raw["controller"]["mpc"] |= {"model": dict(model)} | bound
    raw["axis"]["turn_deg"] = 0
    raw["sampling"]["current_sample_time_s"] = 0.0005
    raw["reference"] = {"shape": "sine", "start_deg": 0, "amplitude_deg": 2, "frequency_hz": 10.0,
                        "cycles": 2}  # fmt: skip
    return raw


FILES = {"two_mass": _two_mass(), "matrices": _matrices()}


def _places(raw: Mapping[str, Any], above: Keys = ()) -> Iterator[Keys]:
    for key, value in raw.items():
        yield (*above, key)
        if isinstance(value, dict):
            yield from _places(value, (*above, key))


def _text(raw: Mapping[str, Any], place: Keys, spoil: str, above: Keys = ()) -> str:
    """TOML with something else at a place."""
    plain, tables = [], []
    for key, value in raw.items():
        if (*above, key) == place:
            plain.append(f"{key} = {spoil}")
        elif isinstance(value, dict):
            tables.append(f"[{'.'.join((*above, key))}]")
            tables.append(_text(value, place, spoil, (*above, key)))
        else:
            plain.append(f"{key} = {json.dumps(value)}")
    return "\n".join([*plain, *tables])


def _design(path: Path) -> None:
    """All that a verb does before it works on regions."""
    servo = servo_drive(load_servo_project(path))
    mpc_design(servo, tracking_problem(servo))
    pid_design(servo)
    reference_task(servo)


CASES = [(kind, place) for kind, raw in FILES.items() for place in _places(raw)]


def test_every_key_of_the_schema_is_spoilt() -> None:
    known = {keys for keys, _, field in all_keys(ServoFile) if not tables_of(field)}
    assert known <= {place for _, place in CASES}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("kind", "place"), CASES, ids=[f"{k}-{'.'.join(p)}" for k, p in CASES])
def test_a_spoilt_key_is_one_sentence_about_it(tmp_path: Path, kind: str, place: Keys) -> None:
    path, key = tmp_path / "servogen.toml", ".".join(place)
    for spoil in SPOILS:
        path.write_text(_text(FILES[kind], place, spoil), encoding="utf-8")
        try:
            _design(path)
        except InputError as error:
            told = str(error)
            assert told.startswith(f"{path}: "), (spoil, told)
            assert key in told.partition(f"{path}: ")[2], (spoil, told)
            assert ", expected " in told, (spoil, told)
            assert "\n" not in told, spoil
            assert len(told) < 500, (spoil, told)
            if spoil not in ("{}", "[[]]"):
                assert "missing" not in told, (spoil, told)
                assert "more wrong" not in told, (spoil, told)


@pytest.mark.parametrize(
    ("kind", "place", "spoil", "told"),
    [
        ("matrices", ("controller", "mpc", "model", "a"), "[[1, 2], [3, 4]]",
         "controller.mpc.model.a is unstable: its mode at z = 5.372 grows by 1e37 over 50 samples"),
        ("matrices", ("drive", "a"), "[[1, 2], [3, 4]]", "drive.a is unstable"),
        ("matrices", ("controller", "mpc", "model", "b"), "[1, -0.005]",
         "model.b is absent from the mode at z = "),
        ("matrices", ("controller", "mpc", "model", "b"), "[0, 0]",
         "model.b is [0.0, 0.0], expected a state that the current moves"),
        ("matrices", ("controller", "mpc", "model", "c"), "[1, 0]",
         "controller.mpc.model.c is blind to the mode at z = 1"),
        ("two_mass", ("controller", "mpc", "weight_error"), "1e300", "weight_error is 1e+300"),
    ],
)  # fmt: skip
def test_a_model_that_will_not_do_is_blamed_itself(
    tmp_path: Path, kind: str, place: Keys, spoil: str, told: str
) -> None:
    path = tmp_path / "servogen.toml"
    path.write_text(_text(FILES[kind], place, spoil), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        _design(path)
    assert told in str(caught.value)
