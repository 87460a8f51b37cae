"""Walking the schema: from a place in pydantic's report, or from the root, to keys and fields."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal, get_args, get_origin

from pydantic import BaseModel, Tag
from pydantic.fields import FieldInfo

from servogen.project.schema import ProjectFile

Model = type[BaseModel]


@dataclass(frozen=True)
class Place:
    """A key of the project file.

    Attributes:
        keys: names of tables and key, and list indices, from the root.
        table: schema of the table that holds the key.
        field: the key's own field, None where the schema has no such key.
        kind: where ``table`` is one of several, the key that says which; empty elsewhere.
        others: then, what the key would say of the others, and these.
    """

    keys: tuple[str | int, ...]
    table: Model
    field: FieldInfo | None
    kind: str = ""
    others: tuple[tuple[str, Model], ...] = ()

    @property
    def key(self) -> str:
        """Name of the innermost key, without list indices."""
        return str(next((key for key in reversed(self.keys) if isinstance(key, str)), ""))


def fields_by_key(table: Model) -> dict[str, FieldInfo]:
    """Fields of a table by their keys in the file."""
    return {field.alias or name: field for name, field in table.model_fields.items()}


def tables_of(field: FieldInfo) -> dict[str, Model]:
    """Tables that a field may hold, by the tag that pydantic reports; empty for a plain value."""
    found: dict[str, Model] = {}
    for member in get_args(field.annotation) or (field.annotation,):
        model, *rest = get_args(member) if get_origin(member) is Annotated else (member,)
        tag = next((entry.tag for entry in rest if isinstance(entry, Tag)), None)
        if isinstance(model, type) and issubclass(model, BaseModel):
            found[tag or _literal_tag(model, discriminator(field))] = model
    return found


def discriminator(field: FieldInfo) -> str:
    """The key that says which of several tables a field holds."""
    return field.discriminator if isinstance(field.discriminator, str) else "model"


def locate(location: Sequence[str | int], root: Model = ProjectFile) -> Place:
    """The key that a pydantic location means: union tags are dropped from it."""
    table: Model = root
    place = Place((), table, None)
    rest = list(location)
    kind, others = "", tuple[tuple[str, Model], ...]()
    while rest:
        key = rest.pop(0)
        field = fields_by_key(table).get(str(key))
        place = Place((*place.keys, key), table, field, kind, others)
        if field is None:
            return place
        inner = tables_of(field)
        if not inner:
            return Place(place.keys + _inside(field, rest), table, field)
        if len(inner) > 1:
            if not rest or str(rest[0]) not in inner:
                return place
            tag = str(rest.pop(0))
            table = inner[tag]
            kind = field.discriminator if isinstance(field.discriminator, str) else ""
            others = tuple((name, model) for name, model in inner.items() if name != tag)
        else:
            table, kind, others = next(iter(inner.values())), "", ()
    return place


def all_keys(root: Model = ProjectFile) -> Iterator[tuple[tuple[str, ...], Model, FieldInfo]]:
    """Every table and key of the schema in order: (keys, table that holds it, field)."""
    yield from _below((), root)


def _below(
    keys: tuple[str, ...], table: Model
) -> Iterator[tuple[tuple[str, ...], Model, FieldInfo]]:
    for key, field in fields_by_key(table).items():
        yield (*keys, key), table, field
        for inner in tables_of(field).values():
            yield from _below((*keys, key), inner)


def _literal_tag(model: Model, key: str) -> str:
    field: Any = model.model_fields.get(key)
    if field is None or get_origin(field.annotation) is not Literal:
        return ""
    return str(get_args(field.annotation)[0])


def _inside(field: FieldInfo, rest: Sequence[str | int]) -> tuple[str | int, ...]:
    """What of a location lies inside a plain value: list indices, names in a free table."""
    if get_origin(field.annotation) is dict:
        return tuple(rest[:1])
    return tuple(item for item in rest if isinstance(item, int))
