"""What the certificate claims of a lookup holds, and is refused for one that was tampered with."""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from servo_example import example

from servogen.controllers.lookup_design import LookupDesign, declare_lookup, design_lookup
from servogen.emit.package import CPackage, emit_package
from servogen.emit.read_back import read_back
from servogen.errors import CheckFailed
from servogen.explicit.choose import Choice, choose
from servogen.explicit.lookup import TreeLookup
from servogen.explicit.tree import Tree
from servogen.precision import FLOAT32, FLOAT64, PRECISIONS, Precision
from servogen.progress import Silent
from servogen.qp.parametric import ParametricQP
from servogen.systems import servo_moves
from servogen.systems.claims import Claim
from servogen.systems.servo_moves import move_claims
from servogen.systems.servo_proofs import region_claims, solutions, tree_claims
from servogen.systems.servo_tables import Emitted, edge_claims, table_claims

sys.path.insert(0, str(Path(__file__).parents[1] / "explicit"))

from explicit_problems import double_integrator, transport

pytestmark = pytest.mark.xdist_group("servo_drive")  # the example is prepared once
PREFIX = "headstock_mpc_lookup"
PROGRAMS = {
    "double": lambda: double_integrator(3),
    "transport": transport,
}


def broken(claims: Sequence[Claim]) -> list[str]:
    return [claim.name for claim in claims if not claim.holds]


@cache
def packages() -> list[CPackage]:
    return [
        emit_package("headstock", example().declarations(precision))
        for precision in PRECISIONS.values()
    ]


@cache
def program(name: str) -> ParametricQP:
    return PROGRAMS[name]()


@cache
def choice(name: str) -> Choice:
    return choose(program(name), 500, 20)


@cache
def design(name: str, precision: Precision) -> LookupDesign:
    return design_lookup(name, precision, program(name), choice(name), 1e-3, 500)


@cache
def small_packages(name: str) -> list[CPackage]:
    return [
        emit_package(f"p{p.name}", (declare_lookup(design(name, p)),)) for p in (FLOAT64, FLOAT32)
    ]


def emitted(some: Sequence[CPackage], prefix: str) -> list[Emitted]:
    texts = [read_back(package, prefix) for package in some]
    return [Emitted(own.precision, own.tables, own.dimensions) for own in texts]


def changed(package: CPackage, file: str, old: str, new: str) -> CPackage:
    assert package.files[file].count(old) >= 1, old
    return replace(package, files={**package.files, file: package.files[file].replace(old, new, 1)})


def with_number(package: CPackage, prefix: str, table: str, index: int, new: str) -> CPackage:
    """One number of a table in the text replaced."""
    file = f"{prefix}_tables.h"
    found = re.search(rf"{prefix}_{table}\[\d+\] = \{{([^}}]*)\}}", package.files[file])
    assert found is not None
    items = found[1].split(",")
    assert items[index].strip() != new
    items[index] = f" {new}"
    return changed(package, file, found[1], ",".join(items))


def with_tree(given: Choice, tree: Tree) -> Choice:
    """The choice with another tree in the form that was chosen."""
    chosen = replace(given.chosen, tree=tree)
    forms = tuple(chosen if form is given.chosen else form for form in given.forms)
    return replace(given, chosen=chosen, forms=forms)


def own_claims(some: Sequence[CPackage]) -> list[Claim]:
    """Of the example's tables."""
    system, claims = example(), []
    for own in emitted(some, PREFIX):
        claims += table_claims(system.choice.chosen, system.parts.mpc.problem.qp, own)
    return claims + edge_claims(system.parts.mpc.problem.qp, emitted(some, PREFIX))


def test_the_example_is_proved() -> None:
    for proof in example().proofs:
        claims = proof.prove(packages(), Silent())
        assert broken(claims) == []
        assert all(claim.cases > 0 for claim in claims)
    problem = example().parts.mpc.problem.qp
    regions = [claim.name for claim in region_claims(example().choice, problem, Silent())]
    assert any("27 regions" in name for name in regions)
    assert any("9 regions" in name for name in regions)


@pytest.mark.parametrize("name", PROGRAMS)
def test_programs_with_rows_and_a_domain_are_proved(name: str) -> None:
    own = emitted(small_packages(name), name)
    claims = region_claims(choice(name), program(name), Silent())
    claims += tree_claims(choice(name), Silent())
    for one in own:
        claims += table_claims(choice(name).chosen, program(name), one)
    claims += edge_claims(program(name), own)
    for precision in PRECISIONS.values():
        claims += move_claims(program(name), choice(name), design(name, precision), Silent())
    assert broken(claims) == []
    assert any("rows of the feasible set, float32" in claim.name for claim in claims)
    assert any("every law was asked" in claim.name for claim in claims)


def test_a_region_less_is_noticed() -> None:
    given, problem = example().choice, example().parts.mpc.problem.qp
    for name, solution in solutions(given):
        less = replace(solution, regions=solution.regions[1:], law_of=solution.law_of[1:])
        forms = tuple(
            replace(form, solution=less) if form.solution is solution else form
            for form in given.forms
        )
        found = broken(region_claims(replace(given, forms=forms), problem, Silent()))
        assert any(claim.startswith(name) and "pattern" in claim for claim in found)
        assert any(claim.startswith(name) and "every facet" in claim for claim in found)


def test_half_the_regions_of_a_program_with_rows_is_noticed() -> None:
    """What the search says of itself is not asked."""
    for name, solution in solutions(choice("double")):
        half = replace(solution, regions=solution.regions[::2], law_of=solution.law_of[::2])
        forms = tuple(
            replace(form, solution=half) if form.solution is solution else form
            for form in choice("double").forms
        )
        given = replace(choice("double"), forms=forms)
        found = broken(region_claims(given, program("double"), Silent()))
        assert any(claim.startswith(name) and "every facet" in claim for claim in found)


def test_regions_of_another_program_are_noticed() -> None:
    other = double_integrator(3, position=4.0)
    found = broken(region_claims(choice("double"), other, Silent()))
    assert len(found) == len(solutions(choice("double")))
    assert all("of the program itself" in claim for claim in found)


def test_a_leaf_with_another_law_is_noticed() -> None:
    system = example()
    tree = system.choice.chosen.tree
    assert tree is not None
    for row, side in np.argwhere(tree.children < 0)[:4]:
        children = tree.children.copy()
        law = -1 - children[row, side]
        children[row, side] = -1 - ((law + 1) % 9)
        other = with_tree(system.choice, replace(tree, children=children))
        found = broken(tree_claims(other, Silent()))
        assert any("reaches a leaf" in claim for claim in found)


@pytest.mark.parametrize("precision", [FLOAT32, FLOAT64])
@pytest.mark.parametrize(
    "table", ["gains", "constants", "normals", "offsets", "matrix", "low", "high", "safe"]
)
def test_a_number_of_the_c_is_noticed(table: str, precision: Precision) -> None:
    """The next number of its type is told from the right one."""
    some = list(packages())
    at = list(PRECISIONS.values()).index(precision)
    values = read_back(some[at], PREFIX).tables[table]
    index = int(np.argmax(np.abs(values)))
    # in float64 by more than the roundings of another computation
    other = np.nextafter(values[index], precision.dtype.type(np.inf))
    if values[index] == 0.0:
        other = precision.dtype.type(1e-11)
    elif not precision.is_float32:
        other = values[index] * (1.0 + 1e-11)
    text = repr(float(other)) if precision is FLOAT64 else f"{other:.9g}".replace("e+", "e") + "f"
    some[at] = with_number(some[at], PREFIX, table, index, text)
    assert broken(own_claims(packages())) == []
    found = broken(own_claims(some))
    assert len(found) == 1
    assert precision.name in found[0]


@pytest.mark.parametrize("table", ["below", "above"])
def test_a_child_of_the_c_is_noticed(table: str) -> None:
    for index in range(4):
        some = list(packages())
        child = int(read_back(some[0], PREFIX).tables[table][index])
        other = str(child + 1) if child != -1 else "-2"
        some[0] = with_number(some[0], PREFIX, table, index, other)
        assert any("emitted tables" in claim for claim in broken(own_claims(some)))


def test_a_way_that_is_too_long_is_noticed() -> None:
    """A leaf becomes a way back to the root: no bound on the walk holds; nor does one too small."""
    some = list(packages())
    leaf = int(np.argmax(read_back(some[0], PREFIX).tables["below"] < 0))
    looped = [with_number(some[0], PREFIX, "below", leaf, "0"), some[1]]
    assert any("longer" in claim for claim in broken(own_claims(looped)))
    short = [changed(some[0], f"{PREFIX}.h", "TREE_DEPTH = 3", "TREE_DEPTH = 2"), some[1]]
    assert any("longer" in claim for claim in broken(own_claims(short)))


@pytest.mark.parametrize("name", PROGRAMS)
@pytest.mark.parametrize("by", [1e-6, -1e-6])
def test_a_bound_of_the_feasible_set_is_noticed(name: str, by: float) -> None:
    exact, single = small_packages(name)
    assert broken(edge_claims(program(name), emitted([exact, single], name))) == []
    bounds = read_back(exact, name).tables["edge_bounds"]
    for index in range(0, bounds.size, 3):
        new = repr(float(bounds[index] + by * (1.0 + abs(bounds[index]))))
        moved = with_number(exact, name, "edge_bounds", index, new)
        found = broken(edge_claims(program(name), emitted([moved, single], name)))
        assert len(found) == 1
        assert "float64" in found[0]


def test_a_row_of_the_feasible_set_less_is_noticed() -> None:
    """Left out of both precisions alike, so that they agree with each other."""
    own = emitted(small_packages("double"), "double")
    count = own[0].dimensions["EDGES"]
    for gone in (0, count - 1):
        less = []
        for one in own:
            rows = one.tables["edge_rows"].reshape(count, -1)
            tables = {
                **one.tables,
                "edge_rows": np.delete(rows, gone, axis=0).ravel(),
                "edge_bounds": np.delete(one.tables["edge_bounds"], gone),
            }
            less.append(
                replace(one, tables=tables, dimensions={**one.dimensions, "EDGES": count - 1})
            )
        found = broken(edge_claims(program("double"), less))
        assert any("wherever they hold" in claim for claim in found)


def test_text_that_is_no_table_is_refused() -> None:
    package = packages()[0]
    file = f"{PREFIX}_tables.h"
    size = re.search(r"_normals(\[\d+\])", package.files[file])
    assert size is not None
    for old, new in (("_safe[1] = {", "_safe[2] = {"), ("0.0f", "ZERO"), (size[1], "[N]")):
        with pytest.raises(CheckFailed):
            read_back(changed(package, file, old, new), PREFIX)
    with pytest.raises(CheckFailed):
        read_back(package, "nobody")


def test_a_wrong_law_gives_other_first_moves() -> None:
    """Every law is asked, so that any one of them is found out."""
    problem, given = program("double"), choice("double")
    right = design("double", FLOAT64)
    form = right.form
    assert isinstance(form, TreeLookup)
    for law in range(0, len(form.gains), 3):
        gains, offsets = form.gains.copy(), form.offsets.copy()
        gains[law] += 1e-3
        offsets[law] += 1e-3
        other = replace(right, form=replace(form, gains=gains, offsets=offsets))
        found = broken(move_claims(problem, given, other, Silent()))
        assert any("the first move" in claim for claim in found)


def test_a_parameter_that_is_refused_is_noticed() -> None:
    right = design("double", FLOAT64)
    assert right.feasible is not None
    bounds = right.feasible.bounds - 1e-3
    other = replace(right, feasible=replace(right.feasible, bounds=bounds))
    found = broken(move_claims(program("double"), choice("double"), other, Silent()))
    assert any("nowhere else" in claim for claim in found)
    everything = replace(right, feasible=None)
    found = broken(move_claims(program("double"), choice("double"), everything, Silent()))
    assert any("nowhere else" in claim for claim in found)


def test_a_law_that_is_never_asked_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """A single parameter, without the points inside the regions and beside the rows."""
    inside = servo_moves._inside
    given = (program("double"), choice("double"), design("double", FLOAT64), Silent())
    assert broken(move_claims(*given)) == []
    monkeypatch.setattr(servo_moves, "_inside", lambda *own: (np.zeros((0, 2)), inside(*own)[1]))
    monkeypatch.setattr(servo_moves, "_beside", lambda *_: np.zeros((0, 2)))
    monkeypatch.setattr(servo_moves, "MOVES", 1)
    assert any("every law" in claim for claim in broken(move_claims(*given)))
