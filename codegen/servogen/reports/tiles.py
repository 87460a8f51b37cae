"""Tiles: the key figures at the head of a page."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from servogen.reports.data import Found
from servogen.reports.numbers import NOTHING, percent


@dataclass(frozen=True)
class KeyFigure:
    """A tile: ``value`` large, ``label`` above, ``note`` below."""

    label: str
    value: str
    note: str


def cycles_tile(data: Found) -> KeyFigure:
    """The first budget, which is the longest window's."""
    name = "Worst-case cycles"
    if data.wcet is None:
        return KeyFigure(name, "not run", "servogen wcet")
    budgets = data.wcet.get("budgets")
    own = next(iter(budgets.values()), None) if isinstance(budgets, Mapping) else None
    if not isinstance(own, Mapping):
        return KeyFigure(name, NOTHING, "no budget given")
    return KeyFigure(name, _share(own.get("utilisation")), f"of the budget on {own.get('target')}")


def _share(value: Any) -> str:
    return percent(value) if isinstance(value, int | float) else NOTHING
