"""What the certificate claims of a lookup holds, and is refused for one that was tampered with."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from servo_example import example

from servogen.controllers.servo_parts import ServoParts
from servogen.explicit.choose import Choice
from servogen.explicit.lookup import TreeLookup
from servogen.explicit.tree import Tree
from servogen.progress import Silent
from servogen.systems.claims import Claim
from servogen.systems.servo_proofs import (
    move_claims,
    region_claims,
    solutions,
    tree_claims,
)

pytestmark = pytest.mark.xdist_group("servo_drive")  # the example is prepared once


def broken(claims: list[Claim]) -> list[str]:
    return [claim.name for claim in claims if not claim.holds]


def with_lookup(parts: ServoParts, **changes: object) -> ServoParts:
    form = replace(parts.lookup.form, **changes)
    return replace(parts, lookup=replace(parts.lookup, form=form))


def with_tree(choice: Choice, tree: Tree) -> Choice:
    """The choice with another tree in the form that was chosen."""
    chosen = replace(choice.chosen, tree=tree)
    forms = tuple(chosen if form is choice.chosen else form for form in choice.forms)
    return replace(choice, chosen=chosen, forms=forms)


def test_the_example_is_proved() -> None:
    for proof in example().proofs:
        claims = proof.prove(Silent())
        assert broken(list(claims)) == []
        assert all(claim.cases > 0 for claim in claims)
    regions = [claim.name for claim in region_claims(example().choice)]
    assert any("27 regions" in name for name in regions)
    assert any("9 regions" in name for name in regions)


def test_a_region_less_is_noticed() -> None:
    choice = example().choice
    for name, solution in solutions(choice):
        forms = tuple(
            replace(form, solution=replace(solution, regions=solution.regions[1:]))
            if form.solution is solution
            else form
            for form in choice.forms
        )
        # the copies are no longer one object; any of them has to be found out
        found = broken(region_claims(replace(choice, forms=forms)))
        assert any(claim.startswith(name) and "pattern" in claim for claim in found)
        assert any(claim.startswith(name) and "beyond" in claim for claim in found)


def test_a_leaf_with_another_law_is_noticed() -> None:
    system = example()
    tree = system.choice.chosen.tree
    assert tree is not None
    for row, side in np.argwhere(tree.children < 0)[:4]:
        children = tree.children.copy()
        law = -1 - children[row, side]
        children[row, side] = -1 - ((law + 1) % 9)
        other = with_tree(system.choice, replace(tree, children=children))
        found = broken(tree_claims(other, system.parts, Silent()))
        assert any("reaches a leaf" in claim for claim in found)
        assert any("emitted tables" in claim for claim in found)


@pytest.mark.parametrize("table", ["gains", "matrix", "offsets"])
def test_a_number_of_the_emitted_tables_is_noticed(table: str) -> None:
    system = example()
    form = system.parts.lookup.form
    assert isinstance(form, TreeLookup)
    values = getattr(form, table).copy()
    values.flat[np.argmax(np.abs(values))] += 1e-6 * (1.0 + np.max(np.abs(values)))
    other = with_lookup(system.parts, **{table: values})
    found = broken(tree_claims(system.choice, other, Silent()))
    assert [claim for claim in found if "emitted tables" in claim]


def test_a_way_that_is_too_long_is_noticed() -> None:
    """A leaf becomes a way back to the root: no bound on the walk holds."""
    system = example()
    form = system.parts.lookup.form
    assert isinstance(form, TreeLookup)
    children = form.tree.children.copy()
    row, side = np.argwhere(children < 0)[0]
    children[row, side] = 0
    looped = Tree(form.tree.normals, form.tree.offsets, children, form.tree.root)
    other = with_lookup(system.parts, tree=looped)
    found = broken(tree_claims(system.choice, other, Silent()))
    assert any("longer" in claim for claim in found)


def test_a_wrong_law_gives_other_first_moves() -> None:
    parts = example().parts
    form = parts.lookup.form
    assert isinstance(form, TreeLookup)
    other = with_lookup(parts, gains=form.gains * 1.01)
    assert broken(move_claims(parts)) == []
    assert len(broken(move_claims(other))) == 1
