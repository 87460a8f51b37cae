"""The lookups of the servo drive as emitted: right on 100,000 parameters, proven leaf by leaf on
the tables of the C, and as short as they are meant to be."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from core_designs import temporary_folder
from emitted_tree import dimension, longest_walk, tables, tree_of
from lookup_designs import CASES, compiled, design, form_of, package, program
from many_parameters import LIMIT_MA, THIRDS, parameters
from oracle import first_moves

from servogen.controllers.lookup import Lookup
from servogen.explicit.choose import Form
from servogen.explicit.explore import solve
from servogen.explicit.image import scaled_optimum
from servogen.explicit.prove import prove_tree, rounding_slack
from servogen.explicit.solution import ExplicitSolution
from servogen.wcet.package import Count, count_package

ALLOWED_MA = 1e-6
ALLOWED_FLOAT32_MA = 1.0
DRIVES = [prefix for prefix, case in CASES.items() if case.program == "drive"]
TREES = [prefix for prefix in CASES if "clips" not in CASES[prefix].form and prefix != "leaf"]


@cache
def many() -> tuple[np.ndarray, np.ndarray]:
    """Parameters, and what an outside solver makes of them."""
    thetas = parameters(solve(program("drive"), 100))
    return thetas, first_moves(program("drive"), thetas)[:, 0]


def moves_in_c(prefix: str, precision: str, thetas: np.ndarray) -> np.ndarray:
    """Every parameter through the emitted ``find``, which must say OK."""
    module, name = compiled(), design(prefix, precision).prefix
    ffi, lib = module.ffi, module.lib
    memory = ffi.new("double[]", 1 + getattr(lib, f"{name}_bytes")() // 8)
    getattr(lib, f"{name}_init")(memory)
    given, told = ffi.new(f"{name}_find_in *"), ffi.new(f"{name}_find_out *")
    theta = np.frombuffer(ffi.buffer(ffi.addressof(given, "theta")), np.dtype(precision))
    found, find = np.empty(len(thetas)), getattr(lib, f"{name}_find")
    for i, row in enumerate(thetas):
        theta[:] = row
        assert find(memory, given, told) == 0
        found[i] = told.move[0]
    return found


@pytest.mark.parametrize("prefix", DRIVES)
def test_the_first_move_is_an_outside_solver_s_on_100_000_parameters(prefix: str) -> None:
    thetas, wanted = many()
    assert len(thetas) >= 100_000
    found = moves_in_c(prefix, "float64", thetas)
    assert np.max(np.abs(found - wanted)) <= ALLOWED_MA
    free = np.abs(wanted[THIRDS["far"]]) < LIMIT_MA * (1.0 - 1e-9)
    assert np.mean(free) > 0.3  # far outside any box, and yet not at a bound


@pytest.mark.parametrize("prefix", DRIVES)
def test_in_float32_the_first_move_is_off_by_a_milliampere_at_most(prefix: str) -> None:
    """In the facts' box and some way around; far outside, by roundings of terms that large."""
    thetas, wanted = many()
    off = np.abs(moves_in_c(prefix, "float32", thetas) - wanted)
    assert np.max(off[THIRDS["inside"]]) <= ALLOWED_FLOAT32_MA
    assert np.max(off[THIRDS["facets"]]) <= ALLOWED_FLOAT32_MA
    terms = np.max(np.abs(thetas) @ np.abs(scaled_optimum(program("drive")).matrix.T), axis=1)
    assert np.all(off <= 4.0 * np.finfo(np.float32).eps * LIMIT_MA * (1.0 + terms))


def form(prefix: str) -> Form:
    return form_of(CASES[prefix].program, CASES[prefix].form)


def solved(prefix: str) -> ExplicitSolution:
    own = form(prefix).solution
    assert own is not None
    return own


@pytest.mark.parametrize("prefix", TREES)
@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_no_walk_is_longer_than_the_loop(prefix: str, precision: str) -> None:
    name, made = design(prefix, precision).prefix, package(precision)
    table = tables(made, name)
    depth = longest_walk(table["below"], table["above"])
    assert depth == dimension(made, name, "TREE_DEPTH")
    leaves = np.concatenate([table["below"], table["above"]])
    assert np.max(-1 - leaves) < dimension(made, name, "LAWS")


@pytest.mark.parametrize("prefix", TREES)
def test_the_tree_of_the_c_is_right_leaf_by_leaf(prefix: str) -> None:
    """Exactly as grown, and in float64 not a digit less."""
    name, made, own = design(prefix).prefix, package("float64"), design(prefix).form
    table, tree = tables(made, name), tree_of(made, name)
    np.testing.assert_array_equal(tree.normals, own.tree.normals)
    np.testing.assert_array_equal(table["gains"], own.gains.ravel())
    np.testing.assert_array_equal(table["constants"], own.offsets.ravel())
    if own.matrix.size:
        proof = prove_tree(tree, solved(prefix))
        assert proof.holds()
        assert proof.leaves == tree.leaves
        assert proof.unreached == 0


def test_a_wrong_leaf_of_the_c_is_seen() -> None:
    tree = tree_of(package("float64"), design("lawtree").prefix)
    children = np.array(tree.children)
    leaves = np.argwhere(children < 0)
    children[tuple(leaves[3])] = -1 - (-children[tuple(leaves[3])] % 11)
    wrong = type(tree)(tree.normals, tree.offsets, children, tree.root, tree.mirror)
    assert not prove_tree(wrong, solved("lawtree")).holds()


def test_float32_s_tables_are_off_by_little() -> None:
    """With the rounding of tables, laws and heights, within ten bounds."""
    prefix, made = "cliptree", package("float32")
    name, solution = design(prefix, "float32").prefix, solved(prefix)
    table, tree = tables(made, name), tree_of(made, name)
    reach = np.full(solution.image.size, 10.0)
    eye = np.eye(reach.size)
    proof = prove_tree(
        tree,
        solution,
        slack=rounding_slack(tree, reach, 1e-6 * reach),
        within=(np.vstack([eye, -eye]), np.concatenate([reach, reach])),
        clip=(float(design(prefix).low[0]), float(design(prefix).high[0])),
        laws=(table["gains"].reshape(-1, 1, reach.size), table["constants"][:, None]),
    )
    assert 0.0 < proof.worst_difference < 0.5  # mA of 1000


@cache
def counted() -> dict[str, Count]:
    folder, made = temporary_folder("counts"), package("float64")
    made.write(folder)
    parts = ("evaluate", "solve", "find")
    names = [f"{design(p).prefix}_{part}" for p in CASES for part in parts]
    found = count_package([folder / file for file in made.sources], [folder], names)
    return dict(found.entry_points)


def test_the_chosen_form_is_short() -> None:
    """Counted from the C: products, and comparisons of reals, of the worst case, in what a step of
    the MPC calls; ``find`` looks at each parameter first."""
    total = counted()["chosen_d_solve"].total()
    assert total.cmp == counted()["chosen_d_evaluate"].total().cmp
    assert total.mul <= 40
    assert total.cmp <= 12
    assert total.div == 0


@pytest.mark.parametrize("prefix", CASES)
def test_the_c_does_what_the_choice_was_made_by(prefix: str) -> None:
    """Every operation on reals of the C is one that ``choose`` compared forms by, and told."""
    total, own = counted()[f"{design(prefix).prefix}_evaluate"].total(), form(prefix).count
    assert own is not None
    assert total.mul == own.multiply_adds
    assert total.add == own.all_additions
    assert total.cmp == own.comparisons
    assert total.neg == own.sign_changes
    assert total.floating_point == total.mul + total.add + total.cmp + total.neg


def test_every_declared_operation_is_counted() -> None:
    for prefix in CASES:
        declaration = Lookup(design(prefix)).declaration
        whole = counted()[f"{declaration.prefix}_find"]
        part = counted()[f"{declaration.prefix}_evaluate"]
        assert whole.total().covers(part.total())
        assert whole.total().cmp > part.total().cmp
