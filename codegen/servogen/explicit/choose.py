"""Which form the lookup takes: the one with the least work in the worst case, and why."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.explicit.clips import RecursiveClips, recursive_clips, without_first_bounds
from servogen.explicit.errors import ExplicitError
from servogen.explicit.explore import solve
from servogen.explicit.grow import grow_tree, is_odd, least_depth
from servogen.explicit.lookup import Count, TreeLookup, count_clips, tree_lookup
from servogen.explicit.solution import ExplicitSolution
from servogen.explicit.tree import Tree
from servogen.progress import Progress
from servogen.qp.parametric import ParametricQP

Lookup = TreeLookup | RecursiveClips
# A greedy tree that costs this much more than the best form may still win when grown with care:
# that took a level off trees of seven to eleven here, a tenth of the work at most.
CLOSE = 1.1
# A law tree with more regions than this is not grown beside a clip tree, which has a third of them:
# in every program tried its depth was greater, and growing takes minutes.
MANY_REGIONS = 100


@dataclass(frozen=True)
class Form:
    """One form: what it costs, or why it was left out (``lookup`` and ``count`` None then).

    ``solution`` is what its tree was grown for, ``tree`` that tree in the coordinates of the
    solution, which the lookup's may not be; both None for the recursive form. ``clip``: bounds of
    the first move that ``solution`` was computed without.
    """

    name: str
    lookup: Lookup | None
    count: Count | None
    note: str
    solution: ExplicitSolution | None = None
    tree: Tree | None = None
    clip: tuple[float, float] | None = None


@dataclass(frozen=True)
class Choice:
    """The form chosen, all forms in the order looked at, and the reason in a sentence."""

    chosen: Form
    forms: tuple[Form, ...]
    reason: str


def choose(
    problem: ParametricQP,
    max_regions: int,
    work: int = 2_000,
    progress: Progress | None = None,
) -> Choice:
    """Builds every form that the program admits and that may win, and takes the cheapest.

    Cheapest: fewest multiply-adds, additions and comparisons together in the worst case; of equals
    the one with fewer table numbers. A tree is not grown where even the least depth that tells so
    many laws apart costs more than a form already found; the others are grown greedily, and those
    that come close to the best once more with all the work allowed.

    Args:
        max_regions, work: see ``solve`` and ``grow_tree``.

    Raises:
        ExplicitError: no form can be had; as ``solve``.
    """
    forms = [_recursive(problem)]
    forms += _trees("clip tree", problem, max_regions, progress, forms)
    forms += _trees("law tree", problem, max_regions, progress, forms)
    least = min((form.count.work for form in forms if form.count), default=0)
    forms = [_regrown(form, CLOSE * least, work, progress) for form in forms]
    able = [form for form in forms if form.count is not None]
    if not able:
        notes = "; ".join(f"{form.name}: {form.note}" for form in forms)
        raise ExplicitError("lookup", None, f"a form that can be had ({notes})")
    best = min(able, key=lambda form: (form.count.work, form.count.numbers) if form.count else ())
    return Choice(best, tuple(forms), _reason(best, able))


def _recursive(problem: ParametricQP) -> Form:
    try:
        clips = recursive_clips(problem)
    except ExplicitError as error:
        return Form("recursive clips", None, None, str(error))
    return Form("recursive clips", clips, count_clips(clips), f"{clips.index.size} clips")


def _trees(
    name: str,
    problem: ParametricQP,
    max_regions: int,
    progress: Progress | None,
    so_far: list[Form],
) -> list[Form]:
    clip: tuple[float, float] | None = None
    program = problem
    try:
        if name == "clip tree":
            program, clip = without_first_bounds(problem)
        solution = solve(program, max_regions, progress)
    except ExplicitError as error:
        if name == "law tree" and not any(form.count for form in so_far):
            raise
        return [Form(name, None, None, str(error))]
    others = [form for form in so_far if form.solution is not None]
    if others and len(solution.regions) > MANY_REGIONS:
        note = f"{len(solution.regions)} regions, against {_regions(others[0])}"
        return [Form(name, None, None, f"not grown: {note} of the clip tree")]
    mirrors = [-1, *range(solution.image.size)] if is_odd(solution) else [-1]
    found: list[Form] = []
    least = min([form.count.work for form in so_far if form.count] or [10**9])
    for mirror in mirrors:
        title = name if mirror < 0 else f"{name}, odd in eta_{mirror}"
        bound = _least_work(solution, mirror, clip)
        if bound > least:
            note = f"no tree for {solution.laws.count} laws costs less than {bound}"
            found.append(Form(title, None, None, note))
            continue
        found.append(_grown(title, solution, 0, mirror, clip, progress))
        count = found[-1].count
        least = min(least, count.work if count else least)
    return found


def _regions(form: Form) -> int:
    return len(form.solution.regions) if form.solution else 0


def _grown(
    name: str,
    solution: ExplicitSolution,
    work: int,
    mirror: int,
    clip: tuple[float, float] | None,
    progress: Progress | None,
) -> Form:
    tree = grow_tree(solution, work, mirror, progress)
    lookup = tree_lookup(solution, tree, clip)
    note = f"{len(solution.regions)} regions, {tree.nodes} nodes, depth {tree.depth}"
    return Form(name, lookup, lookup.count, note, solution, tree, clip)


def _regrown(form: Form, limit: float, work: int, progress: Progress | None) -> Form:
    """A tree that came close, grown with all the work; the others as they are."""
    lookup = form.lookup
    if not isinstance(lookup, TreeLookup) or form.solution is None or form.count is None:
        return form
    if form.count.work > limit:
        return form
    return _grown(form.name, form.solution, work, lookup.tree.mirror, form.clip, progress)


def _least_work(solution: ExplicitSolution, mirror: int, clip: tuple[float, float] | None) -> int:
    """What the shallowest tree that could tell the laws apart would cost, were there one."""
    r, p = solution.image.matrix.shape
    laws, nu = solution.laws.count, solution.problem.first_move
    if mirror >= 0:
        laws = (laws + 1) // 2  # at most one law is its own opposite
    depth = least_depth(laws)
    problem = solution.problem
    bounds = [*problem.lower[:nu], *problem.upper[:nu], *(clip or ())]
    clips = 2 * nu if np.any(np.isfinite(bounds)) else 0
    rest = clips + int(mirror >= 0) + depth
    within = r * p + (depth + nu) * r
    return rest + int(within if mirror >= 0 else min(within, (depth + nu) * p))


def _reason(best: Form, able: list[Form]) -> str:
    assert best.count is not None
    text = (
        f"{best.name} ({best.note}): {best.count.multiply_adds} multiply-adds, "
        f"{best.count.additions} additions, {best.count.comparisons} comparisons"
    )
    others = [form for form in able if form is not best and form.count is not None]
    if not others:
        return f"{text}; no other form can be had or could be cheaper"
    second = min(others, key=lambda form: form.count.work if form.count else 0)
    assert second.count is not None
    return f"{text}, {best.count.work} in all against {second.count.work} of {second.name}"
