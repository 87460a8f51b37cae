"""What is claimed of a servo drive's lookup, proved on its regions and its trees.

What the emitted form was made from is proved from its program's matrices alone
(``explicit.certify``), its tree is descended with every region, and a lookup without a tree has its
clips proved. Boxes have a region for every pattern; that the largest of them
leave nothing out is left with that count and a sample.
"""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from servogen.explicit.certify import Certified, CertifiedLaws, certify, certify_laws
from servogen.explicit.choose import Choice, Form
from servogen.explicit.clip_laws import prove_clips
from servogen.explicit.clips import RecursiveClips, without_first_bounds
from servogen.explicit.cover import facet_of, generic_point
from servogen.explicit.prove import prove_tree
from servogen.explicit.solution import ExplicitSolution
from servogen.explicit.tolerances import HOLE, PROVED, PROVED_LAW, SEEN, SLIVER
from servogen.progress import Progress
from servogen.qp.parametric import ParametricQP
from servogen.systems.claims import Claim

# How far beyond a facet its neighbour is sought: a thousandth of what counts as a region's size.
BEYOND = 1e-6
# Regions of a box up to which what they cover is proved: seven bounded variables, some seconds.
# Beyond, neighbours are sought among a hundred thousand facets. Their laws are proved all the same.
MOST = 2500


def solutions(choice: Choice) -> list[tuple[str, ExplicitSolution]]:
    """What the emitted lookup was made from: the chosen form's solution, and the program's own,
    whence the rows of its feasible set. Forms that were counted and left are nobody's code."""
    found: list[tuple[str, ExplicitSolution]] = []
    if choice.chosen.solution is not None:
        found.append((choice.chosen.name, choice.chosen.solution))
    if choice.own is not None and choice.own is not choice.chosen.solution:
        found.append(("the program", choice.own))
    return found


def region_claims(choice: Choice, problem: ParametricQP, progress: Progress) -> list[Claim]:
    """Every feasible parameter is in a region, and every region's law is its first move.

    Args:
        problem: the program that the lookup is for.
    """
    claims = []
    for name, solution in solutions(choice):
        told = f"{name}, {len(solution.regions)} regions"
        claims.append(_its_program(told, solution, problem))
        if solution.findings.closed_form:
            claims.append(_counted(told, solution))
        if solution.findings.closed_form and len(solution.regions) > MOST:
            claims += _optimal(told, solution, certify_laws(solution, progress))
            claims.append(_behind_facets(told, solution))
        else:
            found = certify(solution, progress)
            claims += _optimal(told, solution, found)
            claims += _covered(told, solution, found)
    return claims


def _its_program(told: str, solution: ExplicitSolution, problem: ParametricQP) -> Claim:
    """What was solved is the lookup's program, but for bounds that are clipped to afterwards."""
    wanted = [problem]
    if problem.first_move == 1 and np.any(np.isfinite([problem.lower[0], problem.upper[0]])):
        wanted.append(without_first_bounds(problem)[0])
    same = any(
        all(np.array_equal(getattr(own, f.name), getattr(solution.problem, f.name))
            for f in fields(ParametricQP))
        for own in wanted
    )  # fmt: skip
    title = f"{told}: of the program itself, or of it without the first move's bounds"
    return Claim(title, same, float(not same), 0.0, len(fields(ParametricQP)))


def _optimal(told: str, solution: ExplicitSolution, found: CertifiedLaws) -> list[Claim]:
    optimal, count = found.optimal, len(solution.regions)
    unseen = max(found.unseen, found.domain, 0.0)
    return [
        Claim(f"{told}: their coordinates show what matters", unseen <= SEEN, unseen, SEEN, count),
        Claim(
            f"{told}: optimal all over each", optimal.reach <= PROVED, optimal.reach, PROVED,
            optimal.rows or count,
        ),
        Claim(
            f"{told}: each law is the optimum's first move", optimal.law_error <= PROVED_LAW,
            optimal.law_error, PROVED_LAW, count,
        ),
    ]  # fmt: skip


def _covered(told: str, solution: ExplicitSolution, found: Certified) -> list[Claim]:
    cover, count = found.cover, len(solution.regions)
    worst = max((0.0, *cover.open))
    left = f"what {len(cover.slivers)} slivers and gaps leave open holds no larger ball"
    # a program that nothing bounds has one region, the whole space, without facets
    return [
        Claim(
            f"{told}: every facet is shared or bounds the feasible set",
            not cover.open and count > 0, worst, SLIVER, cover.facets or count,
        ),
        Claim(
            f"{told}: {left}", found.covers, cover.hole, HOLE,
            cover.facets or count,
        ),
    ]  # fmt: skip


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


def tree_claims(choice: Choice, problem: ParametricQP, progress: Progress) -> list[Claim]:
    """Of the tree that is emitted, or of the clips that stand in its place."""
    if choice.chosen.tree is None:
        return [_clips(choice.chosen, problem)]
    with progress.task("Proving the search tree", total=1) as task:
        claims = [_proved(choice.chosen)]
        task.advance()
    return claims


def _clips(form: Form, problem: ParametricQP) -> Claim:
    """Every number of the clips matters in some pattern: there the law is the optimum's."""
    assert isinstance(form.lookup, RecursiveClips)
    found = prove_clips(problem, form.lookup)
    title = f"{form.name}: in each pattern of {{lower, free, upper}} the optimum's first move"
    holds, kind = found.error <= PROVED_LAW, "proof" if found.complete else "sample"
    return Claim(title, holds, found.error, PROVED_LAW, found.patterns, kind)


def _proved(form: Form) -> Claim:
    assert form.tree is not None
    assert form.solution is not None
    found = prove_tree(form.tree, form.solution)
    title = f"{form.name}, {form.tree.nodes} nodes: every region that reaches a leaf has its law"
    wrong = float(len(found.wrong))
    return Claim(title, found.holds() and found.arrivals > 0, wrong, 0.0, found.arrivals)
