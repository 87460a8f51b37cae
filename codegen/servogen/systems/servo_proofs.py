"""What is claimed of a servo drive's lookup, proved on its regions, its trees and its tables.

Trees are descended with every region, tables are compared with the tree that was proved. The
regions of a box are counted against the closed form; those of another program are what the search
itself says of them, held against points and an independent solver: no proof that none is missing.
"""

from __future__ import annotations

import numpy as np

from servogen.controllers.lookup import Lookup
from servogen.controllers.servo_parts import ServoParts
from servogen.explicit.choose import Choice, Form
from servogen.explicit.cover import facet_of, generic_point
from servogen.explicit.lookup import TreeLookup
from servogen.explicit.prove import prove_tree
from servogen.explicit.solution import ExplicitSolution
from servogen.explicit.tree import Tree
from servogen.precision import FloatArray
from servogen.progress import Progress
from servogen.qp.parametric_solver import ParametricSolver
from servogen.systems.claims import Claim

# How far beyond a facet its neighbour is sought: a thousandth of what counts as a region's size.
BEYOND = 1e-6
MOVES = 1000
SEED = 20
# Agreement of a first move with the program's solver, as a share of the input's range: what the
# solver leaves in float64, and sums of a dozen terms some hundred times the range in float32.
SAME_MOVE = {"float64": 1e-9, "float32": 1e-3}


def solutions(choice: Choice) -> list[tuple[str, ExplicitSolution]]:
    """Each solution that a form was made from, once, with the name of the first such form."""
    found: list[tuple[str, ExplicitSolution]] = []
    for form in choice.forms:
        if form.solution is not None and all(form.solution is not s for _, s in found):
            found.append((form.name, form.solution))
    return found


def region_claims(choice: Choice) -> list[Claim]:
    """Every parameter of the domain is in a region, and the laws are as many as are told."""
    claims = []
    for name, solution in solutions(choice):
        told, findings = f"{name}, {len(solution.regions)} regions", solution.findings
        open_facets = float(len(findings.unresolved))
        facets = findings.boundary_facets + findings.shared_facets + findings.stepped_facets
        if findings.closed_form:
            claims += [_counted(told, solution), _behind_facets(told, solution)]
        else:
            title = f"{told}: every facet is shared or bounds the feasible set"
            # a program that nothing bounds has one region, the whole space
            whole = len(solution.regions) == 1 and not solution.regions[0].k.size
            cases = 1 if whole else facets
            claims.append(Claim(title, not open_facets and cases > 0, open_facets, 0.0, cases))
    return claims


def _counted(told: str, solution: ExplicitSolution) -> Claim:
    """A box whose optimum takes every value has a region for every pattern, no more, no less."""
    patterns = 3 ** int(np.sum(solution.problem.bounded))
    apart = len({region.active for region in solution.regions})
    missing = float(abs(patterns - apart))
    title = f"{told}: one for each pattern of {{lower, free, upper}}"
    return Claim(title, missing == 0.0, missing, 0.0, patterns)


def _behind_facets(told: str, solution: ExplicitSolution) -> Claim:
    """Beyond a generic point of every facet lies a region."""
    points = []
    for region in solution.regions:
        for row in range(region.k.size):
            piece = facet_of(region, solution.program, row)
            found = generic_point(piece)
            if found is not None:
                points.append(found[0] + BEYOND * piece.normal)
    lost = float(np.sum(solution.locate(np.array(points), 0.0) < 0)) if points else 0.0
    title = f"{told}: beyond every facet lies another region"
    return Claim(title, lost == 0.0 and bool(points), lost, 0.0, len(points), "sample")


def tree_claims(choice: Choice, parts: ServoParts, progress: Progress) -> list[Claim]:
    """Of every tree that was grown, then of the tables that are emitted."""
    grown = [form for form in choice.forms if form.tree is not None]
    claims = []
    with progress.task("Proving search trees", total=len(grown)) as task:
        for form in grown:
            claims.append(_proved(form))
            task.advance()
    if choice.chosen.tree is not None:
        claims.append(_as_emitted(choice.chosen, parts))
        claims.append(_depth(choice.chosen, parts))
    return claims


def _proved(form: Form) -> Claim:
    assert form.tree is not None
    assert form.solution is not None
    found = prove_tree(form.tree, form.solution)
    title = f"{form.name}, {form.tree.nodes} nodes: every region that reaches a leaf has its law"
    wrong = float(len(found.wrong))
    return Claim(title, found.holds() and found.arrivals > 0, wrong, 0.0, found.arrivals)


def _as_emitted(form: Form, parts: ServoParts) -> Claim:
    """The tables are the proved tree's and laws' numbers in the lookup's own coordinates, which are
    its image or the parameters themselves."""
    tree, solution, lookup = form.tree, form.solution, parts.lookup.form
    assert tree is not None
    assert solution is not None
    assert isinstance(lookup, TreeLookup)
    own, laws = solution.image, solution.laws
    image = own.matrix if not lookup.matrix.size else np.eye(own.size)
    shift = own.offset if not lookup.matrix.size else np.zeros(own.size)
    pairs: list[tuple[FloatArray, FloatArray]] = [
        (lookup.tree.normals, tree.normals @ image),
        (lookup.tree.offsets, tree.offsets - tree.normals @ shift),
        (lookup.gains, laws.gains @ image),
        (lookup.offsets, laws.offsets + laws.gains @ shift),
    ]
    if lookup.matrix.size:
        pairs += [(lookup.matrix, own.matrix), (lookup.offset, own.offset)]
    worst = max((_apart(a, b) for a, b in pairs), default=np.inf)
    same = np.array_equal(lookup.tree.children, tree.children) and lookup.tree.mirror == tree.mirror
    cases = sum(a.size for a, _ in pairs) + tree.children.size
    title = f"{form.name}: the emitted tables are those of the proved tree"
    return Claim(title, same and worst <= 1e-12, worst, 1e-12, cases)


def _apart(first: FloatArray, second: FloatArray) -> float:
    if first.shape != second.shape:
        return float("inf")
    scale = float(np.max(np.abs(second), initial=0.0)) or 1.0
    return float(np.max(np.abs(first - second), initial=0.0)) / scale


def _depth(form: Form, parts: ServoParts) -> Claim:
    """Every way from the root of the emitted tables ends at a leaf within the bound of the loop."""
    lookup = parts.lookup.form
    assert isinstance(lookup, TreeLookup)
    declared = {d.name: d.value for d in Lookup(parts.lookup).declaration.dimensions}
    bound = declared["TREE_DEPTH"]
    over, leaves = 0, 0
    waiting = [(lookup.tree.root, 0)]
    while waiting:
        at, depth = waiting.pop()
        if at < 0:
            leaves += 1
            over = max(over, depth - bound)
        elif depth > bound:
            over = max(over, depth - bound)
        else:
            waiting += [(int(child), depth + 1) for child in lookup.tree.children[at]]
    title = f"{form.name}: no way through the emitted tree is longer than {bound} nodes"
    whole = leaves == _leaves(lookup.tree)
    return Claim(title, over == 0 and whole, float(over), 0.0, leaves)


def _leaves(tree: Tree) -> int:
    return int(np.sum(tree.children < 0)) if tree.inner else 1


def move_claims(parts: ServoParts) -> list[Claim]:
    """The lookup, in its own precision, against the program's solver: parameters within a few times
    the range in which the bounds decide, and far outside."""
    lookup, design = Lookup(parts.lookup), parts.lookup
    solver = ParametricSolver(parts.mpc.problem.qp)
    span = parts.mpc.input_bounds.upper - parts.mpc.input_bounds.lower
    worst, cases = 0.0, 0
    for theta in _parameters(parts):
        given = theta.astype(design.precision.dtype).astype(np.float64)
        optimum = solver.solve(given)
        status, move = lookup(given.astype(design.precision.dtype))
        if optimum.feasible and int(status) == 0:
            own = optimum.z[: design.moves]
            worst = max(worst, float(np.max(np.abs(move.astype(np.float64) - own) / span)))
            cases += 1
    tolerance = SAME_MOVE[design.precision.name]
    title = f"the first move is the program's, {design.precision.name}, in shares of its range"
    return [Claim(title, worst <= tolerance and cases > 0, worst, tolerance, cases, "sample")]


def _parameters(parts: ServoParts) -> FloatArray:
    """(MOVES, p): such that the unconstrained first move is of the size of its bounds, on average,
    over six decades of that size."""
    qp = parts.mpc.problem.qp
    rng = np.random.default_rng(SEED)
    slope, _ = qp.unconstrained()
    # each parameter alone moves the first input by its bound
    scale = np.max(parts.mpc.input_bounds.upper) / np.maximum(np.abs(slope[0]), 1e-300)
    sizes = 10.0 ** rng.uniform(-3.0, 3.0, (MOVES, 1))
    result: FloatArray = rng.normal(size=(MOVES, slope.shape[1])) * scale * sizes
    return result
