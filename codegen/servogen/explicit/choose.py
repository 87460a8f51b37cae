"""Which form the lookup takes: the one with the least work in the worst case, and why."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.explicit.clips import RecursiveClips, recursive_clips, without_first_bounds
from servogen.explicit.errors import ExplicitError
from servogen.explicit.explore import solve
from servogen.explicit.grow import MAX_NODES, Growth, is_odd, least_depth
from servogen.explicit.lookup import Count, TreeLookup, count_clips, tree_lookup
from servogen.explicit.pieces import Arrangement, arrange
from servogen.explicit.solution import ExplicitSolution
from servogen.explicit.tolerances import SAME_PLANE
from servogen.explicit.tree import Tree
from servogen.explicit.turned import turned
from servogen.plants.statespace import FloatArray
from servogen.progress import Progress
from servogen.qp.parametric import ParametricQP

Lookup = TreeLookup | RecursiveClips
# A greedy tree that costs this much more than the best form may still win when its depth is
# searched for: that took one to three levels off trees of five to fourteen here.
CLOSE = 1.1
# A law tree with more regions than this is not grown beside a clip tree: in every program tried its
# depth was no less, and growing takes seconds.
MANY_REGIONS = 100
# Directions that an odd program is mirrored in, those whose half holds the fewest regions; others
# gave no smaller trees.
MIRRORS = 2
# A tree with more leaves is not grown once more for half of the parameters: that takes seconds, and
# is less work only where it takes two levels off.
MANY_LEAVES = 2000


@dataclass(frozen=True)
class Form:
    """One form: what it costs, or why it was left out (``lookup`` and ``count`` None then).

    ``solution`` is what its tree is for, ``tree`` that tree in the coordinates of the
    solution, which the lookup's may not be; both None for the recursive form.
    """

    name: str
    lookup: Lookup | None
    count: Count | None
    note: str
    solution: ExplicitSolution | None = None
    tree: Tree | None = None


@dataclass(frozen=True)
class Choice:
    """The form chosen, all forms in the order looked at, and the reason in a sentence.

    ``own``: the program's own regions where they were computed, used by a form or not.
    """

    chosen: Form
    forms: tuple[Form, ...]
    reason: str
    own: ExplicitSolution | None = None


@dataclass(frozen=True)
class _Growing:
    """A tree that may still get smaller; ``clip``: bounds that its program does not have."""

    name: str
    arrangement: Arrangement
    growth: Growth
    clip: tuple[float, float] | None

    def work(self, depth: int | None = None) -> int:
        """Operations of its lookup, or of one that is so deep."""
        at = self.growth.depth if depth is None else depth
        return _work(self.arrangement.solution, self.growth.mirror, self.clip, at)

    def form(self) -> Form:
        """As it stands."""
        tree, solution = self.growth.tree(), self.arrangement.solution
        lookup = tree_lookup(solution, tree, self.clip)
        note = f"{len(solution.regions)} regions, {tree.nodes} nodes, depth {tree.depth}"
        return Form(self.name, lookup, lookup.count, note, solution, tree)


def choose(
    problem: ParametricQP,
    max_regions: int,
    work: int = 2_000,
    progress: Progress | None = None,
    max_nodes: int = MAX_NODES,
) -> Choice:
    """Builds every form that the program admits and that may win, and takes the cheapest.

    Cheapest: fewest multiply-adds, additions and comparisons together in the worst case; of equals
    the one with fewer table numbers. Sign changes are told and not compared: on the bundled targets
    a mirrored tree of three levels takes fewer cycles than the one of four levels that it halves. A
    tree is not grown where even the least depth that tells so many laws apart costs more than a
    form already found; the others are grown greedily, and the depth of those that come close to the
    best is searched, the cheapest first, each with half of the work that is left. The rest goes
    into fewer nodes of the best.

    Args:
        max_regions, work, max_nodes: see ``solve`` and ``grow_tree``.

    Raises:
        ExplicitError: no form can be had; as ``solve`` and ``grow_tree``.
    """
    found: list[Form | _Growing] = [_recursive(problem)]
    clip_solution = _solved_without_bounds(problem, max_regions, progress, found)
    too_large: list[ExplicitError] = []
    if clip_solution is not None:
        found += _trees("clip tree", *clip_solution, progress, found, max_nodes, too_large)
    if too_large and not any(isinstance(each, _Growing) or each.count for each in found):
        raise too_large[0]  # a law tree tells more regions apart
    own = _solved(problem, max_regions, progress, found)
    if own is not None:
        others = [each for each in found if isinstance(each, _Growing)]
        many = others and others[0].growth.leaves > MANY_LEAVES
        if others and (many or len(own.regions) > MANY_REGIONS):
            clipped = len(others[0].arrangement.solution.regions)
            note = f"not grown: {len(own.regions)} regions, against {clipped} of the clip tree"
            found.append(Form("law tree", None, None, note))
        else:
            found += _trees("law tree", own, None, progress, found, max_nodes, too_large)
    _search(found, work)
    forms = tuple(each.form() if isinstance(each, _Growing) else each for each in found)
    able = [form for form in forms if form.count is not None]
    if not able and too_large:
        raise too_large[0]
    if not able:
        notes = "; ".join(f"{form.name}: {form.note}" for form in forms)
        raise ExplicitError("lookup", None, f"a form that can be had ({notes})")
    best = min(able, key=lambda form: (form.count.work, form.count.numbers) if form.count else ())
    return Choice(best, forms, _reason(best, able), own)


def _recursive(problem: ParametricQP) -> Form:
    try:
        clips = recursive_clips(problem)
    except ExplicitError as error:
        return Form("recursive clips", None, None, str(error))
    return Form("recursive clips", clips, count_clips(clips), f"{clips.index.size} clips")


def _solved_without_bounds(
    problem: ParametricQP,
    max_regions: int,
    progress: Progress | None,
    found: list[Form | _Growing],
) -> tuple[ExplicitSolution, tuple[float, float]] | None:
    try:
        program, clip = without_first_bounds(problem)
        return solve(program, max_regions, progress), clip
    except ExplicitError as error:
        if error.key == "number of regions" and problem.rows.shape[0]:
            raise  # with the bounds there are more
        found.append(Form("clip tree", None, None, str(error)))
    return None


def _solved(
    problem: ParametricQP,
    max_regions: int,
    progress: Progress | None,
    found: list[Form | _Growing],
) -> ExplicitSolution | None:
    try:
        return solve(problem, max_regions, progress)
    except ExplicitError as error:
        if not any(isinstance(each, _Growing) or each.count for each in found):
            raise
        found.append(Form("law tree", None, None, str(error)))
    return None


def _trees(
    name: str,
    solution: ExplicitSolution,
    clip: tuple[float, float] | None,
    progress: Progress | None,
    so_far: list[Form | _Growing],
    max_nodes: int,
    too_large: list[ExplicitError],
) -> list[Form | _Growing]:
    """Greedy trees of a solution, for all parameters and for halves of them; why the one for all is
    not to be had goes to ``too_large``."""
    found: list[Form | _Growing] = []
    arrangement = arrange(solution)
    whole: Growth | None = None
    for title, across in [("", None), *_mirrors(arrangement)]:
        mirror = -1
        if across is not None:
            solution, mirror = turned(arrangement.solution, across)
        title = f"{name}{title}"
        least = _least([*so_far, *found])
        depth = least_depth((solution.laws.count + 1) // 2 if mirror >= 0 else solution.laws.count)
        if mirror >= 0 and whole is not None:
            if whole.leaves > MANY_LEAVES:
                note = f"not grown: the tree for all parameters has {whole.leaves} leaves"
                found.append(Form(title, None, None, note, solution))
                continue
            depth = max(depth, whole.depth - 2)
        bound = _work(solution, mirror, clip, depth)
        if bound > least:
            note = f"not grown: one of depth {depth} costs {bound}, and none less deep is likely"
            found.append(Form(title, None, None, note, solution))
            continue
        try:
            own = arrangement if mirror < 0 else arrange(solution)
            growth = Growth(own, mirror, progress, max_nodes)
        except ExplicitError as error:
            found.append(Form(title, None, None, str(error), solution))
            if mirror < 0:
                too_large.append(error)  # half a tree may still be had
            continue
        whole = growth if mirror < 0 else whole
        found.append(_Growing(title, own, growth, clip))
    return found


def _mirrors(arrangement: Arrangement) -> list[tuple[str, FloatArray]]:
    """Directions to mirror an odd program in: coordinates, and across facets of its regions. Those
    of a program with rows may lie so close that coordinates across one of them tell others apart
    by too few digits for the proof of coverage."""
    if not is_odd(arrangement.solution):
        return []
    size = arrangement.solution.image.size
    told = [(f", odd in eta_{i}", row) for i, row in enumerate(np.eye(size))]
    known = [row for _, row in told]
    box = arrangement.solution.findings.closed_form
    for i, plane in enumerate(arrangement.planes if box else ()):
        direction = plane[:size] / np.linalg.norm(plane[:size])
        if min(np.max(np.abs(direction - row)) for row in known) > SAME_PLANE:
            known.append(direction)
            told.append((f", odd across hyperplane {i}", direction))
    sizes = [arrangement.in_half(row) for _, row in told]
    best = sorted(range(len(told)), key=lambda i: sizes[i])
    return [told[i] for i in best if sizes[i] == sizes[best[0]]][:MIRRORS]


def _search(found: list[Form | _Growing], work: int) -> None:
    """Spends work on the depth of the trees that may win, then on the nodes of the best."""
    growing = [each for each in found if isinstance(each, _Growing)]
    limit = CLOSE * _least(found)
    for each in sorted(growing, key=lambda each: each.work()):
        if each.work() <= limit and each.work(each.growth.least) <= _least(found):
            work -= each.growth.lower(work // 2)
    best = [each for each in growing if each.work() == _least(found)]
    for each in sorted(best, key=lambda each: each.growth.leaves)[:1]:
        each.growth.thin_out(work)


def _least(found: list[Form | _Growing]) -> int:
    """Work of the cheapest so far."""
    works = [each.work() for each in found if isinstance(each, _Growing)]
    works += [each.count.work for each in found if isinstance(each, Form) and each.count]
    return min(works, default=10**9)


def _work(
    solution: ExplicitSolution, mirror: int, clip: tuple[float, float] | None, depth: int
) -> int:
    """Operations of a tree of some depth; the same as ``TreeLookup.count`` of a grown one."""
    r, p = solution.image.matrix.shape
    nu, problem = solution.problem.first_move, solution.problem
    bounds = [*problem.lower[:nu], *problem.upper[:nu], *(clip or ())]
    clips = 2 * nu if np.any(np.isfinite(bounds)) else 0
    rest = clips + int(mirror >= 0) + depth + nu
    within = r * p + (depth + nu) * r + (r if np.any(solution.image.offset) else 0)
    return rest + int(within if mirror >= 0 else min(within, (depth + nu) * p))


def _reason(best: Form, able: list[Form]) -> str:
    assert best.count is not None
    text = (
        f"{best.name} ({best.note}): {best.count.multiply_adds} multiply-adds, "
        f"{best.count.additions} additions, {best.count.comparisons} comparisons"
    )
    if best.count.sign_changes:
        text = f"{text}, {best.count.sign_changes} sign changes"
    others = [form for form in able if form is not best and form.count is not None]
    if not others:
        return f"{text}; no other form can be had or could be cheaper"
    second = min(others, key=lambda form: form.count.work if form.count else 0)
    assert second.count is not None
    return f"{text}, {best.count.work} in all against {second.count.work} of {second.name}"
