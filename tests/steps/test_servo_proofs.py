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

from servogen.controllers.design import Status
from servogen.controllers.lookup import Lookup
from servogen.controllers.lookup_design import LookupDesign, declare_lookup, design_lookup
from servogen.emit.package import CPackage, emit_package
from servogen.emit.read_back import read_back
from servogen.errors import CheckFailed
from servogen.explicit.choose import Choice, choose
from servogen.explicit.clips import RecursiveClips
from servogen.explicit.feasible import feasible_set
from servogen.explicit.image import Canonical
from servogen.explicit.lookup import TreeLookup
from servogen.explicit.solution import ExplicitSolution
from servogen.explicit.tree import Tree
from servogen.precision import FLOAT32, FLOAT64, PRECISIONS, Precision
from servogen.progress import Silent
from servogen.qp.parametric import ParametricQP
from servogen.systems import servo_moves, servo_proofs
from servogen.systems.claims import Claim
from servogen.systems.servo_moves import move_claims
from servogen.systems.servo_proofs import region_claims, solutions, tree_claims
from servogen.systems.servo_tables import Emitted, edge_claims, table_claims

sys.path.insert(0, str(Path(__file__).parents[1] / "explicit"))

from explicit_problems import double_integrator, servo_drive, transport

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
    claims += tree_claims(choice(name), program(name), Silent())
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
        changed = with_solution(given, solution, less)
        found = broken(region_claims(changed, problem, Silent()))
        assert any(claim.startswith(name) and "pattern" in claim for claim in found)
        assert any(claim.startswith(name) and "every facet" in claim for claim in found)


def with_solution(given: Choice, old: ExplicitSolution, new: ExplicitSolution) -> Choice:
    """The choice with another solution in every form that has the old one."""
    forms = tuple(
        replace(form, solution=new) if form.solution is old else form for form in given.forms
    )
    chosen, own = given.chosen, given.own
    return replace(
        given,
        forms=forms,
        chosen=replace(chosen, solution=new) if chosen.solution is old else chosen,
        own=new if own is old else own,
    )


def said_of(name: str, other: ExplicitSolution) -> list[str]:
    """What is refused where the first solution of a choice is another."""
    given = choice(name)
    changed = with_solution(given, solutions(given)[0][1], other)
    return broken(region_claims(changed, program(name), Silent()))


def test_laws_in_another_order_are_noticed() -> None:
    own = solutions(choice("double"))[0][1]
    rolled = replace(own, law_of=np.roll(own.law_of, 1))
    found = said_of("double", rolled)
    assert len(found) == 1
    assert "each law is the optimum's first move" in found[0]


def test_a_region_that_reaches_too_far_is_noticed() -> None:
    """A facet pushed out by less than what counts as a gap, into where another law is optimal."""
    own = solutions(choice("double"))[0][1]
    k = own.regions[0].k.copy()
    k[0] += 1e-6
    wide = replace(own, regions=(replace(own.regions[0], k=k), *own.regions[1:]))
    found = said_of("double", wide)
    assert any("optimal all over" in claim for claim in found)


def test_coordinates_that_hide_a_parameter_are_noticed() -> None:
    own = solutions(choice("double"))[0][1]
    matrix = own.image.matrix.copy()
    matrix[1] = 0.0
    program = replace(own.program, image=replace(own.image, matrix=matrix))
    assert any("show what matters" in claim for claim in said_of("double", own_with(own, program)))


def test_a_domain_that_is_cut_short_is_noticed() -> None:
    own = solutions(choice("double"))[0][1]
    program = replace(own.program, domain_bounds=own.program.domain_bounds * 0.9)
    assert any("show what matters" in claim for claim in said_of("double", own_with(own, program)))


def own_with(own: ExplicitSolution, program: Canonical) -> ExplicitSolution:
    return replace(own, program=program)


def test_a_gap_beyond_what_may_be_open_is_noticed() -> None:
    """Two planes that count as one, turned against each other."""
    own = solutions(choice("double"))[0][1]
    for region in own.regions[:3]:
        regions = list(own.regions)
        h = region.h + 8e-9 * np.column_stack([-region.h[:, 1], region.h[:, 0]])
        regions[own.regions.index(region)] = replace(region, h=h)
        found = said_of("double", replace(own, regions=tuple(regions)))
        assert any("no larger ball" in claim for claim in found)


def test_laws_of_more_regions_than_are_covered_are_proved(monkeypatch: pytest.MonkeyPatch) -> None:
    """Boxes with so many regions: their laws as ever, and a look beyond every facet."""
    monkeypatch.setattr(servo_proofs, "MOST", 10)
    given, problem = example().choice, example().parts.mpc.problem.qp
    own = next(s for _, s in solutions(given) if len(s.regions) == 27)
    claims = region_claims(given, problem, Silent())
    assert broken(claims) == []
    assert any("27 regions: beyond every facet" in claim.name for claim in claims)
    assert not any("27 regions: every facet" in claim.name for claim in claims)
    rolled = with_solution(given, own, replace(own, law_of=np.roll(own.law_of, 1)))
    found = broken(region_claims(rolled, problem, Silent()))
    assert len(found) == 1
    assert "each law is the optimum's first move" in found[0]
    k = own.regions[0].k + 1e-3
    wide = replace(own, regions=(replace(own.regions[0], k=k), *own.regions[1:]))
    found = broken(region_claims(with_solution(given, own, wide), problem, Silent()))
    assert len(found) == 1
    assert "optimal all over" in found[0]
    # drawn in: the law and the count stay right
    narrow = replace(own.regions[0], k=own.regions[0].k - 1e-3)
    less = with_solution(given, own, replace(own, regions=(narrow, *own.regions[1:])))
    found = broken(region_claims(less, problem, Silent()))
    assert len(found) == 1
    assert "beyond every facet lies another" in found[0]


@cache
def clips_choice() -> tuple[ParametricQP, Choice]:
    """Too many regions to enumerate: clips win, and no form has a tree."""
    problem = servo_drive(3)
    return problem, choose(problem, 5, 20)


def test_a_lookup_without_a_tree_is_proved() -> None:
    problem, given = clips_choice()
    assert given.chosen.tree is None
    assert region_claims(given, problem, Silent()) == []
    claims = tree_claims(given, problem, Silent())
    assert [(claim.holds, claim.cases, claim.kind) for claim in claims] == [(True, 27, "proof")]
    clips = given.chosen.lookup
    assert isinstance(clips, RecursiveClips)
    for place in np.argwhere(clips.coefficients):
        coefficients = clips.coefficients.copy()
        coefficients[*place] *= 1.0 + 1e-5
        chosen = replace(given.chosen, lookup=replace(clips, coefficients=coefficients))
        other = replace(given, chosen=chosen)
        assert len(broken(tree_claims(other, problem, Silent()))) == 1


@pytest.mark.parametrize(("precision", "width"), [(FLOAT64, 1e-9), (FLOAT32, 1e-5)])
def test_the_edge_is_no_wider_than_rounding(precision: Precision, width: float) -> None:
    """A third of the width beyond a row a parameter is taken, at three times it is not."""
    own = feasible_set(solutions(choice("double"))[-1][1])
    lookup = Lookup(design("double", precision))
    for angle in np.linspace(0.1, 6.2, 24):
        way = np.array([np.cos(angle), np.sin(angle)])
        speed = own.rows @ way
        times = np.where(speed > 0.0, own.bounds / np.where(speed > 0.0, speed, 1.0), np.inf)
        row = int(np.argmin(times))
        for share, status in ((0.3, Status.OK), (3.0, Status.INFEASIBLE)):
            bound = own.bounds[row] + share * width * (1.0 + abs(own.bounds[row]))
            theta = (bound / speed[row] * way).astype(precision.dtype)
            assert lookup.call("find", {"theta": theta})[0] is status


def test_half_the_regions_of_a_program_with_rows_is_noticed() -> None:
    """What the search says of itself is not asked."""
    for name, solution in solutions(choice("double")):
        half = replace(solution, regions=solution.regions[::2], law_of=solution.law_of[::2])
        given = with_solution(choice("double"), solution, half)
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
        found = broken(tree_claims(other, system.parts.mpc.problem.qp, Silent()))
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


@pytest.mark.parametrize(("precision", "by"), [(FLOAT64, 1e-7), (FLOAT32, 1e-2)])
def test_a_wrong_law_gives_other_first_moves(precision: Precision, by: float) -> None:
    """Every law is asked, so that any one of them is found out."""
    problem, given = program("double"), choice("double")
    right = design("double", precision)
    form = right.form
    assert isinstance(form, TreeLookup)
    for law in range(0, len(form.gains), 3):
        gains, offsets = form.gains.copy(), form.offsets.copy()
        gains[law] += by
        offsets[law] += by
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
