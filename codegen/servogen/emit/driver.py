"""The Frama-C Eva driver of a controller, made from its declaration: ``verify/<prefix>_eva.c``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import jinja2

from servogen.controllers.design import Declaration, Port

FOLDER = "verify"


def driver_file(prefix: str) -> str:
    """Name in the package."""
    return f"{FOLDER}/{prefix}_eva.c"


def is_driver(file: str) -> bool:
    """Drivers are no sources of the package: nothing compiles them."""
    return file.startswith(f"{FOLDER}/")


def driver_text(
    environment: jinja2.Environment,
    declaration: Declaration,
    declarations: Sequence[Declaration],
    common: dict[str, Any],
) -> str:
    """Render the driver of one of the package's ``declarations``; ``common`` is what all templates
    of the package are given."""
    real = environment.filters["real"]
    local = environment.overlay()
    local.filters = environment.filters | {"drawn": _drawn(real), "held": _held}
    return local.get_template("eva.c.jinja").render(
        common
        | {
            "d": declaration,
            "p": declaration.prefix,
            "hints": widening_hints(with_parts(declaration, declarations)),
        }
    )


def with_parts(
    declaration: Declaration, declarations: Sequence[Declaration]
) -> tuple[Declaration, ...]:
    """A controller after everything it calls, directly or not."""
    by_prefix = {d.prefix: d for d in declarations}
    found: dict[str, Declaration] = {}
    for prefix in declaration.uses:
        found |= {d.prefix: d for d in with_parts(by_prefix[prefix], declarations)}
    return (*found.values(), declaration)


def widening_hints(declarations: Sequence[Declaration]) -> list[int]:
    """Where a counter may stop: Eva tries these before it gives a bound up."""
    return sorted(
        {v for d in declarations for dim in d.dimensions for v in (dim.value - 1, dim.value)} - {-1}
    )


def _drawn(real: Callable[[float], str]) -> Callable[[Port], str]:
    def drawn(port: Port) -> str:
        low, high = -1.0 if port.low is None else port.low, 1.0 if port.high is None else port.high
        if port.integer:
            call = f"sg_draw_count({int(low)}, {int(high)})"
        else:
            call = f"sg_draw({real(low)}, {real(high)})"
        if not port.size:
            return f"in.{port.name} = {call};"
        return _loop(port, f"in.{port.name}[i] = {call};")

    return drawn


def _held(port: Port) -> str:
    """An output that has been written; a real one is finite."""
    element = f"out.{port.name}[i]" if port.size else f"out.{port.name}"
    fact = f"\\initialized(&{element})" if port.integer else f"\\is_finite({element})"
    claim = f"/*@ assert {fact}; */"
    return _loop(port, f"{claim} ;") if port.size else claim


def _loop(port: Port, body: str) -> str:
    return f"for (int i = 0; i < {port.size}; i++) {{\n        {body}\n    }}"
