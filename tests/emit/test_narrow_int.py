"""An int may have 16 bits: what may be beyond that is computed in int32_t.

int32_t is given a type of its own here, wider than int, so that the syntax tree tells them apart.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from core_designs import VARIANTS, Variant, package
from pycparser import c_ast

from servogen.emit.package import CPackage
from servogen.evidence.flags import OWN_DIVISION
from servogen.wcet.ctype import INT, Scalar
from servogen.wcet.headers import HEADERS
from servogen.wcet.program import Program

# Products of two ints that stay below a dimension: an index of `above`, which has ROWS elements;
# the kernel's own test leaves the place of a column, which is an int32_t.
SMALL = {"k * MPC_ROWS_PER_STEP"}
# PQP's rows of whole groups of four steps, at most ROWS of them.
GROUPED = {
    "per_step * blocks",
    "per_step * block",
    "2 * per_step",
    "3 * per_step",
    "4 * per_step",
    "(BinaryOp) * block",
    "3 * grouped",
    "4 * grouped",
}


@pytest.fixture(autouse=True)
def _int32_is_not_int(monkeypatch: pytest.MonkeyPatch) -> None:
    text = HEADERS["stdint.h"].replace("typedef int int32_t", "typedef long long int32_t")
    assert text != HEADERS["stdint.h"]
    monkeypatch.setitem(HEADERS, "stdint.h", text)


def products(made: CPackage, folder: Path) -> set[str]:
    """Every product and left shift whose type is int and that no compiler folds."""
    made.write(folder)
    program = Program(
        [folder / s for s in made.sources], [folder], [OWN_DIVISION.removeprefix("-D")]
    )
    found = set()

    class Visitor(c_ast.NodeVisitor):
        def visit_ArrayDecl(self, node: c_ast.ArrayDecl) -> None:
            pass  # a size is a constant

        def visit_BinaryOp(self, node: c_ast.BinaryOp) -> None:
            kind = typed.type_of(node)
            whole = isinstance(kind, Scalar) and kind.kind == "int" and kind.bytes <= INT.bytes
            if node.op in ("*", "<<") and whole and not typed.is_literal(node):
                found.add(f"{_text(node.left)} {node.op} {_text(node.right)}")
            self.generic_visit(node)

    for definition in program.definitions.values():
        typed = program.typed(definition)
        Visitor().visit(definition.node)
    return {text.replace(f"{made.name.upper()}_", "") for text in found}


def _text(node: c_ast.Node) -> str:
    if isinstance(node, c_ast.ID):
        return str(node.name)
    return str(node.value) if isinstance(node, c_ast.Constant) else f"({type(node).__name__})"


ACTIVE_SET = replace(VARIANTS["example"], method="active_set")


@pytest.mark.parametrize(
    ("variant", "small"),
    [
        (VARIANTS["example"], SMALL | GROUPED),
        (VARIANTS["axes differ"], SMALL | GROUPED),
        (VARIANTS["plain PQP"], SMALL | GROUPED),
        (VARIANTS["governor alone"], set()),
        (ACTIVE_SET, SMALL),
    ],
    ids=["example", "axes differ", "plain PQP", "governor alone", "active set"],
)
def test_products_of_ints_stay_below_a_dimension(
    variant: Variant, small: set[str], tmp_path: Path
) -> None:
    made = package(variant)
    found = {
        text.replace("MPC_X", "MPC").replace("MPC_Y", "MPC") for text in products(made, tmp_path)
    }
    assert found == small
    for d in made.declarations:
        size = {dim.name: dim.value for dim in d.dimensions}
        if d.kind == "mpc":
            assert size["HORIZON"] * size["ROWS_PER_STEP"] <= size["ROWS"]


def test_a_place_in_a_matrix_computed_in_int_is_seen(tmp_path: Path) -> None:
    made = package(VARIANTS["example"])
    text = made.files["sg_kernels.h"]
    narrow = text.replace("int32_t j = 4 * (int32_t)blocks", "int j = 4 * blocks")
    assert narrow != text
    files = {**made.files, "sg_kernels.h": narrow}
    assert "j * rows" in products(
        CPackage(made.name, made.hash, made.declarations, files), tmp_path
    )
