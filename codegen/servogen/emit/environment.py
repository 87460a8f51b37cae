"""The one Jinja environment, and the few filters its templates use."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import jinja2

from servogen.controllers.design import Declaration, Port, StateField
from servogen.emit.literals import real_literal
from servogen.precision import Precision
from servogen.resources import resource_dir

COLUMNS = 96


def make_environment(precision: Precision) -> jinja2.Environment:
    """Strict about names, silent about white space; templates only lay out what is decided.

    One for each precision, and with it its templates: to parse them takes ten times what it takes
    to render them. One whose file was changed meanwhile is read again.
    """
    return _environment(precision, str(resource_dir("templates")))


@cache
def _environment(precision: Precision, folder: str) -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(folder),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,
    )

    def real(value: float) -> str:
        return real_literal(float(value), precision)

    def numbers(values: Sequence[float]) -> str:
        return wrap([real(v) for v in values])

    environment.filters["real"] = real
    environment.filters["chomp"] = lambda text: str(text).rstrip("\n")
    environment.filters["numbers"] = numbers
    environment.filters["integers"] = lambda values: wrap([str(int(v)) for v in values])
    environment.filters["field"] = field_text
    environment.filters["port"] = port_text
    environment.globals["trips"] = trips_text
    return environment


def wrap(items: Sequence[str]) -> str:
    """Comma-separated, broken into lines of at most ``COLUMNS``, indented by four."""
    lines, line = [], "   "
    for i, item in enumerate(items):
        piece = f" {item}," if i < len(items) - 1 else f" {item}"
        if len(line) + len(piece) > COLUMNS:
            lines.append(line)
            line = "   "
        line += piece
    return "\n".join([*lines, line])


def trips_text(least: int, greatest: int | None = -1) -> str:
    """The line before a loop that tells TI's compiler how often it turns.

    ``greatest`` is ``least`` unless it is given, None for no promise. A loop that is never entered
    gets a remark instead: no compiler likes to hear of zero turns.
    """
    most = least if greatest == -1 else greatest
    if most is not None and most < 1:
        return "/* never entered */"
    return f'SG_PRAGMA("MUST_ITERATE({least}{"" if most is None else f", {most}"})")'


def port_text(port: Port, real_type: str) -> str:
    """A member of an in or out struct."""
    kind = "int32_t" if port.integer else real_type
    size = f"[{port.size}]" if port.size else ""
    bounds = ""
    if port.low is not None and port.high is not None:
        bounds = f" [{port.low!r} .. {port.high!r}]"
    return f"{kind} {port.name}{size}; /* {port.unit}{bounds}: {port.doc} */"


def field_text(field: StateField, declaration: Declaration, real_type: str) -> str:
    """A member of the state struct."""
    kind = real_type
    if field.type:
        kind = field.type if field.type == "int32_t" else f"{field.type}_t"
    size = f"[{declaration.prefix.upper()}_{field.size}]" if field.size else ""
    return f"{kind} {field.name}{size}; /* {field.doc} */"
