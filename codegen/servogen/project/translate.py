"""Pydantic's findings as one sentence: the first in the order of the file, and how many more."""

from __future__ import annotations

import difflib
import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, get_args, get_origin

from pydantic import ValidationError
from pydantic.fields import FieldInfo

from servogen.errors import InputError
from servogen.project.fields import expected_text, one_of, unit_of
from servogen.project.machine import Axis, AxisLikeX
from servogen.project.schema import ProjectFile
from servogen.project.walk import (
    Model,
    Place,
    all_keys,
    discriminator,
    fields_by_key,
    locate,
    tables_of,
)

_UNIT_END = re.compile(
    r"_(ma_s_per_deg|a_per_rpm|rpm_per_deg|deg_per_s2|rad_per_s2|rpm|kg_m2|kg_cm2|g_cm2"
    r"|n_m_s_per_rad|n_m_per_rad|n_m_per_deg|n_m_per_a|n_m_per_ma|n_m|per_s|ma|ua|a|counts"
    r"|rad_per_s|deg_per_s|m_per_s2|mm_per_s2|m_per_s|mm_per_s|m_per_min|mm_per_min|in_per_min"
    r"|km_per_h|khz|hz|mhz|km|cm|mm|um|nm|m|in|inch|ft|ns|us|ms|s|sec|min|g|rad|deg|pct|percent)$",
    re.IGNORECASE,
)
_LONGEST_VALUE = 60
Keys = tuple[str | int, ...]


def to_input_error(
    file: Path, raw: Mapping[str, Any], error: ValidationError, root: Model = ProjectFile
) -> InputError:
    """The first finding in file order as an InputError; the others are counted."""
    found: dict[Keys, tuple[str, str]] = {}
    mistaken: dict[Keys, Keys] = {}
    for item in error.errors(include_url=False, include_context=True):
        place = _as_written(raw, locate(item["loc"], root))
        keys, sentence = _finding(raw, item, place, root)
        found.setdefault(keys, sentence)
        if item["type"] == "extra_forbidden" and _of_another_kind(place):
            mistaken.setdefault(keys[:-1], keys)
    # all that is wrong with a table of the wrong kind is one mistake
    found = {k: t for k, t in found.items() if mistaken.get(k[:-1], k) == k}
    renamed = _renamed(found)
    kept = {keys: text for keys, text in found.items() if keys not in renamed}
    order = _file_order(raw)
    # Another version of the format explains everything else that is wrong.
    first = ("schema",) if ("schema",) in kept else min(kept, key=lambda k: _position(order, k))
    value, expected = kept[first]
    more = len({_without_indices(keys) for keys in kept}) - 1  # ten entries of a list: one key
    suffix = f" (and {more} more wrong {'key' if more == 1 else 'keys'})" if more else ""
    return InputError(file, dotted(first), value, expected + suffix)


def dotted(keys: Sequence[str | int]) -> str:
    """``machine.x.slow.a[0][1]``; names that TOML would quote are quoted."""
    text = ""
    for key in keys:
        if isinstance(key, int):
            text += f"[{key}]"
        else:
            bare = re.fullmatch(r"[A-Za-z0-9_-]+", key) is not None
            text += ("." if text else "") + (key if bare else json.dumps(key))
    return text


def value_text(value: object) -> str:
    """A value about as it stands in the file, on one line and not long."""
    if isinstance(value, Mapping):
        return "a table"
    if isinstance(value, bool):
        return "true" if value else "false"
    text = json.dumps(value) if isinstance(value, str) else _plain(value)
    return text if len(text) <= _LONGEST_VALUE else text[: _LONGEST_VALUE - 3] + "..."


def _plain(value: object) -> str:
    if isinstance(value, list) and value and isinstance(value[0], Mapping):
        return "an array of tables"
    if isinstance(value, list):
        # Enough items to pass the limit; a list of a million need not be written out for this.
        return "[" + ", ".join(value_text(item) for item in value[:_LONGEST_VALUE]) + "]"
    if isinstance(value, int) and abs(value) > 10**_LONGEST_VALUE:
        return "an enormous whole number"
    return str(value)


def _finding(
    raw: Mapping[str, Any], item: Any, place: Place, root: Model
) -> tuple[Keys, tuple[str, str]]:
    kind = item["type"]
    if kind in ("union_tag_invalid", "union_tag_not_found") and place.field is not None:
        tag = Place((*place.keys, discriminator(place.field)), place.table, None)
        tags = one_of(list(tables_of(place.field)))
        return tag.keys, (_value_at(raw, tag.keys), tags)
    if kind == "extra_forbidden":
        return place.keys, _unknown(raw, place, root)
    expected = _expected(place)
    return place.keys, (_value_at(raw, place.keys), expected)


def _without_indices(keys: Keys) -> Keys:
    return tuple(key for key in keys if isinstance(key, str))


def _as_written(raw: Any, place: Place) -> Place:
    """A number that stands for a list of one is no entry of a list in the file."""
    for depth, key in enumerate(place.keys):
        if isinstance(key, int) and not isinstance(raw, list):
            return Place(place.keys[:depth], place.table, place.field)
        try:
            raw = raw[key]
        except (KeyError, IndexError, TypeError):
            break
    return place


def _expected(place: Place) -> str:
    field = place.field
    if field is None:
        return "a table"
    text = expected_text(place.key, field)
    depth = sum(isinstance(key, int) for key in place.keys)
    if depth:
        rows = get_origin(get_args(field.annotation)[0]) is not None
        return "a row of numbers" if rows and depth == 1 else "a finite number"
    if get_origin(field.annotation) is dict and place.key not in fields_by_key(place.table):
        return text if text != "a table of names and numbers" else "a number"
    finite = "number" in text and "finite" not in text and "whole" not in text
    return text.replace("a number", "a finite number", 1) if finite else text


def _value_at(raw: Any, keys: Sequence[str | int]) -> str:
    for key in keys:
        try:
            raw = raw[key]
        except (KeyError, IndexError, TypeError):
            return "missing"
    return value_text(raw)


def _unknown(raw: Mapping[str, Any], place: Place, root: Model) -> tuple[str, str]:
    value = _value_at(raw, place.keys)
    if place.table is AxisLikeX and place.key in fields_by_key(Axis):
        return value, 'either same_as = "x" or the tables slow and fast, not both'
    known = fields_by_key(place.table)
    other_kind = _of_another_kind(place)
    if other_kind:
        own = _value_at(raw, (*place.keys[:-1], place.kind))
        told = f'a key of {place.kind} = "{other_kind}" ({value})'
        return told, f"the keys of {place.kind} = {own}: {', '.join(known)}"
    other_unit = _same_quantity(place.key, known)
    if other_unit is not None:
        unit = unit_of(other_unit)
        told = f"the key {other_unit}" + (f", in {unit}" if unit else ", a number without unit")
        return f"a key with another unit ({value})", told
    return f"an unknown key ({value})", _nearest(place.key, known, root)


def _of_another_kind(place: Place) -> str:
    """Of several tables that might stand here, another one that has this key."""
    if not place.kind or place.key in fields_by_key(place.table):
        return ""
    return next((tag for tag, other in place.others if place.key in fields_by_key(other)), "")


def _nearest(key: str, known: Mapping[str, FieldInfo], root: Model) -> str:
    close = difflib.get_close_matches(key, list(known), n=1, cutoff=0.6)
    if close:
        return f"{close[0]} (the closest known key)"
    elsewhere = [dotted(keys) for keys, _, _ in all_keys(root) if keys[-1] == key]
    if elsewhere:
        return f"it at {elsewhere[0]}"
    return f"one of the keys {', '.join(known)}"


def _same_quantity(key: str, known: Mapping[str, FieldInfo]) -> str | None:
    """The known key that names the same quantity with the unit servogen uses, if there is one."""
    stem = _UNIT_END.sub("", key)
    return next((name for name in known if _UNIT_END.sub("", name) == stem), None)


def _renamed(found: Mapping[Keys, tuple[str, str]]) -> set[Keys]:
    """Missing keys that an unknown one beside them stands for: one mistake, told once."""
    twins: set[Keys] = set()
    for keys, (value, expected) in found.items():
        for other, (state, _) in found.items():
            if state != "missing" or other[:-1] != keys[:-1] or other == keys:
                continue
            names = (f"the key {other[-1]}", f"{other[-1]} (the closest known key)")
            if value != "missing" and expected.startswith(names):
                twins.add(other)
    return twins


def _file_order(raw: Mapping[str, Any]) -> dict[Keys, int]:
    order: dict[Keys, int] = {}

    def visit(keys: Keys, value: Any) -> None:
        order[keys] = len(order)
        if isinstance(value, Mapping):
            for key, inner in value.items():
                visit((*keys, key), inner)

    visit((), raw)
    return order


def _position(order: Mapping[Keys, int], keys: Keys) -> tuple[int, int]:
    """Where a key stands; what is missing comes after the last key of the table it belongs to."""
    for length in range(len(keys), -1, -1):
        parent = keys[:length]
        if parent in order:
            inside = [at for other, at in order.items() if other[:length] == parent]
            return (order[parent], 0) if length == len(keys) else (max(inside), 1)
    return (len(order), 1)
