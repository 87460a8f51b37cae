"""The reference of all keys in docs/project-file.md, made from the schema.

``python -m servogen.project.reference docs/project-file.md`` brings the page up to date.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import get_origin

from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from servogen.outputs import write_file
from servogen.project.contour_schema import ContourFile
from servogen.project.fields import expected_text, unit_of
from servogen.project.governor_schema import GovernorFile
from servogen.project.schema import ProjectFile
from servogen.project.servo_schema import ServoFile
from servogen.project.translate import value_text
from servogen.project.walk import Model, discriminator, fields_by_key, tables_of

BEGIN = "<!-- keys: made by python -m servogen.project.reference, not edited by hand -->\n"
END = "<!-- end of keys -->\n"
SYSTEMS: dict[str, Model] = {
    "two_stage": ProjectFile,
    "servo_drive": ServoFile,
    "command_governor": GovernorFile,
    "contour_lq": ContourFile,
}


def reference() -> str:
    """One table of Markdown for every table of every system's project file."""
    parts = [
        f'## All keys of system = "{system}"\n\n' + "\n".join(_sections("", root, ""))
        for system, root in SYSTEMS.items()
    ]
    return "\n\n".join(parts)


def updated(page: str) -> str:
    """A page with its reference brought up to date.

    Raises:
        ValueError: the page lacks one of the marks that the reference stands between.
    """
    head, rest = page.split(BEGIN)
    _, tail = rest.split(END)
    return f"{head}{BEGIN}\n{reference()}\n{END}{tail}"


def _sections(path: str, table: Model, kind: str) -> Iterator[str]:
    fields = fields_by_key(table)
    plain = {key: field for key, field in fields.items() if not tables_of(field)}
    if plain:
        yield _title(path, kind)
        yield "| key | unit | takes | default | |\n|---|---|---|---|---|"
        yield from (_row(key, field) for key, field in plain.items())
        yield ""
    for key, field in fields.items():
        inner = tables_of(field)
        below = f"{path}.{key}" if path else key
        for name, model in inner.items():
            if name != "own":  # y's own tables are as x's
                plain_table = name in ("", "like_x")
                kind = "" if plain_table else f' with `{discriminator(field)} = "{name}"`'
                yield from _sections(below, model, kind)


def _title(path: str, kind: str) -> str:
    return f"### `[{path}]`{kind}\n" if path else "### At the top of the file\n"


def _row(key: str, field: FieldInfo) -> str:
    unit = unit_of(key) or ""
    takes = expected_text(key, field).removesuffix(f" ({unit})")
    if get_origin(field.annotation) is dict:
        takes = f"a table, each value {takes.removeprefix('a table of names and ')}"
    cells = (f"`{key}`", unit, takes, _default(field), field.description or "")
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def _default(field: FieldInfo) -> str:
    if field.default_factory is not None:
        return "none"
    if field.default is PydanticUndefined:
        return "required"
    if field.default is None:
        return "none"
    value = field.default
    if isinstance(value, tuple):  # a list that may be written as its only number
        value = value[0] if len(value) == 1 else list(value)
    return f"`{value_text(value)}`"


if __name__ == "__main__":
    page = Path(sys.argv[1])
    write_file(page, updated(page.read_text(encoding="utf-8")))
