"""docs/project-file.md says what the schema says, and the schema says enough."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from servogen.project.fields import UNITS
from servogen.project.reference import SYSTEMS, reference, updated
from servogen.project.walk import all_keys, tables_of

PAGE = Path(__file__).parents[2] / "docs" / "project-file.md"
KEYS = [
    (keys, field)
    for root in SYSTEMS.values()
    for keys, _, field in all_keys(root)
    if not tables_of(field)
]


def test_the_page_is_up_to_date() -> None:
    page = PAGE.read_text(encoding="utf-8")
    assert page == updated(page), "run python -m servogen.project.reference docs/project-file.md"


def test_every_key_is_on_it_with_words() -> None:
    told = reference()
    for keys, field in KEYS:
        assert f"| `{keys[-1]}` |" in told
        assert field.description, f"{keys} has no description"


@pytest.mark.parametrize("keys", [keys for keys, _ in KEYS], ids=".".join)
def test_a_key_of_a_physical_quantity_has_its_unit(keys: tuple[str, ...]) -> None:
    quantity = re.search(
        r"time|limit|range|bandwidth|feed(?!_ramp|_scale)|acceler|cutoff", keys[-1]
    )
    names = {"range_check", "acceleration_period", "weight_acceleration", "command_limit"}
    if quantity and keys[-1] not in names:
        assert keys[-1].endswith(tuple(f"_{unit}" for unit in UNITS))
