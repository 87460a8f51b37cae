"""What Frama-C Eva is given of each controller, made from its declaration.

``verify/<prefix>_eva.c`` calls the controller in every way and claims what it promises,
``verify/<prefix>_contract.c`` and ``.h`` stand for it in the proof of a controller that uses it.
All are laid out from the same ports and members, so that what is claimed is what is relied on.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import jinja2

from servogen.controllers.design import Declaration, Operation, Port, StateField
from servogen.emit.environment import field_text

FOLDER = "verify"
LEAST, GREATEST = "-2147483647 - 1", "2147483647"


def driver_file(prefix: str) -> str:
    """Name in the package."""
    return f"{FOLDER}/{prefix}_eva.c"


def contract_file(prefix: str) -> str:
    """Name in the package."""
    return f"{FOLDER}/{prefix}_contract.c"


def contract_header(prefix: str) -> str:
    """Name in the package."""
    return f"{FOLDER}/{prefix}_contract.h"


def is_driver(file: str) -> bool:
    """Drivers are no sources of the package: nothing compiles them."""
    return file.startswith(f"{FOLDER}/")


def driver_files(
    environment: jinja2.Environment,
    declarations: Sequence[Declaration],
    common: dict[str, Any],
    signature: Callable[[Declaration, Operation], str],
) -> dict[str, str]:
    """The header, a driver for every controller, a contract for every one that is used.

    Args:
        declarations: the package's.
        common: what all templates of the package are given.
    """
    local = environment.overlay()
    local.filters = environment.filters | _filters(environment.filters["real"])
    package = str(common["package"])
    files = {f"{FOLDER}/{package}_eva.h": local.get_template("eva.h.jinja").render(common)}
    used = {prefix for d in declarations for prefix in d.uses}
    for d in declarations:
        context = common | {
            "d": d,
            "p": d.prefix,
            "dims": {dim.name: dim.value for dim in d.dimensions},
            "hints": widening_hints(d),
            "signature": lambda operation, d=d: signature(d, operation),
        }
        files[driver_file(d.prefix)] = local.get_template("eva.c.jinja").render(context)
        if d.prefix in used:
            files[contract_file(d.prefix)] = local.get_template("contract.c.jinja").render(context)
            files[contract_header(d.prefix)] = _header(local, d, context)
    return files


def widening_hints(declaration: Declaration) -> list[int]:
    """Where a counter may stop: Eva tries these before it gives a bound up."""
    values = {v for dim in declaration.dimensions for v in (dim.value - 1, dim.value)}
    return sorted(values - {-1})


def _header(
    environment: jinja2.Environment, declaration: Declaration, context: dict[str, Any]
) -> str:
    """The public header, guard and all, with as much of the state as callers may know: whoever
    touches another member does not compile. With SG_GIVEN ``const``, neither does who writes."""
    begun = StateField("begun", "SG_BEGUN after init", type="int32_t")
    given = tuple(f for f in declaration.state if f.bound)
    shown = replace(declaration, state=(begun, *given), uses=())
    local = environment.overlay()

    def field(member: StateField, owner: Declaration, real_type: str) -> str:
        return f"SG_GIVEN {field_text(member, owner, real_type)}"

    local.filters = environment.filters | {"field": field}
    return local.get_template("controller.h.jinja").render(
        context | {"d": shown, "P": declaration.prefix.upper()}
    )


def _filters(real: Callable[[float], str]) -> dict[str, Callable[[Port], str]]:
    def ends(port: Port) -> tuple[str, str]:
        """As C writes them; where none are declared, of what any finite value may be."""
        if port.low is None or port.high is None:
            return (LEAST, GREATEST) if port.integer else ("-SG_REAL_MAX", "SG_REAL_MAX")
        if port.integer:
            return str(int(port.low)), str(int(port.high))
        return real(port.low), real(port.high)

    def exact(literal: str) -> str:
        """In ACSL a literal without a suffix is the real number, not the double next to it."""
        return literal if literal.endswith("f") else f"{literal}d"

    def drawn(port: Port) -> str:
        """An input of the driver's calls."""
        call = "sg_draw_count" if port.integer else "sg_draw"
        low, high = ends(port)
        return _each(port, lambda e: f"in.{e} = {call}({low}, {high});")

    def claimed(port: Port) -> str:
        """An output: written, finite, and in its range."""
        low, high = (exact(end) if "." in end else end for end in ends(port))
        # of any finite value no more is claimed: in ACSL the macro is the real number, and as a
        # literal a little less than the greatest double
        any_double = low == "-SG_REAL_MAX" and not real(1.0).endswith("f")
        within = "" if any_double else f" && {low} <= out.{{0}} <= {high}"

        def claim(e: str) -> str:
            if port.integer:
                return f"/*@ assert {low} <= out.{e} <= {high}; */ ;"
            return f"/*@ assert \\is_finite(out.{e}){within.format(e)}; */ ;"

        return _each(port, claim)

    def promised(port: Port) -> str:
        """An output of a contract."""
        call = "sg_promise_count" if port.integer else "sg_promise"
        low, high = ends(port)
        return _each(port, lambda e: f"out->{e} = {call}({low}, {high});")

    def needed(port: Port) -> str:
        """An input of a contract: written, and finite where the part's proof draws such."""
        finite = "" if port.integer else " && (SG_EVA_INPUTS == 2 || \\is_finite(in->{}))"
        return _each(port, lambda e: f"/*@ assert \\initialized(&in->{e}){finite.format(e)}; */ ;")

    def bounded(port: Port) -> str:
        """An input that the caller has bounded, as the driver gives it."""
        low, high = ends(port)
        return _each(port, lambda e: f"in.{e} = sg_promise({low}, {high});")

    def owed(port: Port) -> str:
        """The same in a contract: the caller's proof has to show it."""
        low, high = (exact(end) for end in ends(port))
        claim = "\\initialized(&in->{0}) && \\is_finite(in->{0}) && {1} <= in->{0} <= {2}"
        return _each(port, lambda e: f"/*@ assert {claim.format(e, low, high)}; */ ;")

    return {"drawn": drawn, "claimed": claimed, "promised": promised, "needed": needed,
            "bounded": bounded, "owed": owed}  # fmt: skip


def _each(port: Port, statement: Callable[[str], str]) -> str:
    """Once, or for every element."""
    if not port.size:
        return statement(port.name)
    body = statement(f"{port.name}[i]")
    return f"for (int i = 0; i < {port.size}; i++) {{\n        {body}\n    }}"
