"""All critical regions: from one, across every facet, until every facet is accounted for.

Tondel, Johansen and Bemporad (2003): across a facet on which one multiplier vanishes, that row
leaves the active set; across one on which a slack vanishes, that row enters it, for one of the
others where it depends on them. This settles the whole facet if no other row vanishes on it; the
rest is ``cover.py``'s.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field, replace
from itertools import islice

import numpy as np

from servogen.explicit import boxes
from servogen.explicit.cover import (
    ActiveSet,
    across,
    bounds_feasible_set,
    facet_of,
    generic_point,
    optimal_set,
    subtract,
)
from servogen.explicit.errors import ExplicitError
from servogen.explicit.image import Canonical, canonical
from servogen.explicit.regions import (
    MULTIPLIER,
    Candidate,
    Region,
    balls_of,
    candidate,
    exchanges,
    facets,
    is_full,
    is_independent,
)
from servogen.explicit.small_lp import Ball, inner_ball
from servogen.explicit.solution import ExplicitSolution, Findings, first_move_law, group_laws
from servogen.explicit.tolerances import FLAT, SLIVER
from servogen.plants.statespace import FloatArray, read_only
from servogen.progress import Progress, Silent, Task
from servogen.qp.parametric import ParametricQP

# Directions tried from the middle of the feasible set for a first region that is not flat.
_STARTS = 40
# Active sets whose linear programs are solved together.
_CHUNK = 256
# Parts of facets, beyond two for every region, that may have to be stepped across. Theory settles
# nearly all; limits on steps beside limits on inputs leave one for every second region, since there
# active sets with dependent rows abound; planes too close for a double leave many times that.
_PARTS, _PARTS_PER_REGION = 100, 2


def solve(
    problem: ParametricQP, max_regions: int, progress: Progress | None = None
) -> ExplicitSolution:
    """All regions of a parametric program, its first-move laws, and what was met on the way.

    Args:
        max_regions: give up beyond this count.
        progress: told region by region; an interrupt between two regions ends the work.

    Raises:
        ExplicitError: more than ``max_regions`` regions, no feasible parameters, or only a
            lower-dimensional set of them; regions that numbers do not tell apart.
    """
    program = canonical(problem)
    watcher = Silent() if progress is None else progress
    if program.box_optimum:
        count = 3 ** int(np.sum(problem.bounded))
        if count > max_regions and not program.domain_bounds.size:
            raise _too_many(max_regions, str(count))
        with watcher.task("Computing regions", total=count) as task:
            found, findings = _all_patterns(problem, program, max_regions, task)
    else:
        # how many there are nobody knows: the count goes up to the limit at the most
        title = f"Computing regions, at most {max_regions}"
        with watcher.task(title, total=max_regions) as task:
            search = _Search(problem, program, max_regions, task)
            search.run()
        found, findings = list(search.regions.values()), search.findings()
    found.sort(key=lambda region: (len(region.active), region.active))
    pieces = [first_move_law(problem, program, region) for region in found]
    laws, index = group_laws([gain for gain, _ in pieces], [offset for _, offset in pieces])
    numbered = tuple(
        replace(region, law=int(law)) for region, law in zip(found, index, strict=True)
    )
    index.flags.writeable = False
    return ExplicitSolution(problem, program, numbered, laws, index, findings)


def _too_many(limit: int, found: str) -> ExplicitError:
    expected = f"at most {limit} (a shorter horizon, fewer constraints, or a higher limit)"
    return ExplicitError("number of regions", found, expected)


def _all_patterns(
    problem: ParametricQP, program: Canonical, limit: int, task: Task
) -> tuple[list[Region], Findings]:
    n, bounded = int(np.sum(problem.bounded)), program.domain_bounds.size > 0
    found: list[Region] = []
    waiting = boxes.patterns(n)
    while chunk := list(islice(waiting, _CHUNK)):
        made = [candidate(program, active) for active in chunk]
        full = [each for each in made if each is not None]
        assert len(full) == len(chunk)  # a box has no constant rows
        balls = balls_of(program, full) if bounded else [boxes.middle_of(each, n) for each in full]
        task.advance(len(chunk))
        kept = [i for i, ball in enumerate(balls) if not bounded or is_full(ball)]
        if len(found) + len(kept) > limit:
            raise _too_many(limit, f"more than {limit}")
        chosen = [full[i] for i in kept]
        centres = [balls[i].centre for i in kept]
        rows = facets(program, chosen, centres) if bounded else [None] * len(kept)
        for i, each, groups in zip(kept, chosen, rows, strict=True):
            found.append(_region(program, each, balls[i], groups))
    return found, Findings(closed_form=not bounded)


def _region(
    program: Canonical, made: Candidate, ball: Ball, groups: list[list[int]] | None
) -> Region:
    """The region with the first row of each group for a facet, with every row where None."""
    rows = slice(None) if groups is None else [group[0] for group in groups]
    numbers = tuple(sorted(int(program.numbers[i]) for i in made.active))
    weak = tuple(sorted(int(program.numbers[i]) for i in made.weakly_active))
    return Region(
        numbers, read_only(made.h[rows]), read_only(made.k[rows]), read_only(made.slope),
        read_only(made.offset), read_only(ball.centre), ball.radius, -1, weak,
    )  # fmt: skip


@dataclass(frozen=True)
class _Open:
    """A region whose facets are still to be crossed, with the rows that vanish on each."""

    region: Region
    made: Candidate
    groups: list[list[int]]


@dataclass
class _Search:
    problem: ParametricQP
    program: Canonical
    limit: int
    task: Task
    regions: dict[ActiveSet, Region] = field(default_factory=dict)
    queue: deque[_Open] = field(default_factory=deque)
    nothing: set[ActiveSet] = field(default_factory=set)
    flat: set[ActiveSet] = field(default_factory=set)
    unresolved: list[str] = field(default_factory=list)
    slivers: int = 0
    parts: int = 0
    counts: dict[str, int] = field(default_factory=lambda: {"end": 0, "shared": 0, "stepped": 0})

    def run(self) -> None:
        self._start()
        while self.queue:
            layer = list(self.queue)
            self.queue.clear()
            self._layer(layer)

    def _layer(self, layer: list[_Open]) -> None:
        """Crosses every facet of some regions; what lies behind them all is built together."""
        wanted = [[self._behind(work, group) for group in work.groups] for work in layer]
        near = {
            active: work.region.centre
            for work, mine in zip(layer, wanted, strict=True)
            for sets in mine
            for active in sets or ()
        }
        self._build_all(near, len(layer))
        for work, mine in zip(layer, wanted, strict=True):
            self.task.advance()
            for row, sets in enumerate(mine):
                if sets is None or not self._settled(work, row, sets):
                    self._stepped(work.region, row)

    def findings(self) -> Findings:
        weak = sum(1 for region in self.regions.values() if region.weakly_active)
        flat = tuple(sorted(tuple(int(self.program.numbers[i]) for i in a) for a in self.flat))
        return Findings(
            False, self.counts["end"], self.counts["shared"], self.counts["stepped"], flat, weak,
            tuple(self.unresolved), self.slivers,
        )  # fmt: skip

    def _build(self, active: ActiveSet) -> Region | None:
        """The region of an independent active set, taken up if new; None if flat or empty."""
        self._build_all({active: np.zeros(self.program.image.size)}, 1)
        return self.regions.get(active)

    def _build_all(self, near: dict[ActiveSet, FloatArray], crossed: int) -> None:
        """The same for several, each with a point that it may be near to, behind the facets of so
        many regions. A layer far larger than the one before it is followed by one that is larger
        by a quarter of that at least: what will not end within the limit need not be begun."""
        fresh = [a for a in near if a not in self.regions and a not in self.nothing]
        full: list[tuple[Candidate, Ball]] = []
        for start in range(0, len(fresh), _CHUNK):
            full += self._full({active: near[active] for active in fresh[start : start + _CHUNK]})
            # before the many programs that tell which of their rows are facets
            if len(self.regions) + len(full) > self.limit:
                raise _too_many(self.limit, f"more than {self.limit}")
        growth = len(full) / (4 * crossed)
        if len(full) * growth > 2 * self.limit:
            raise _too_many(self.limit, f"about {len(full) * growth:.1g} or more")
        for start in range(0, len(full), _CHUNK):
            chunk = full[start : start + _CHUNK]
            rows = facets(self.program, [made for made, _ in chunk], [b.centre for _, b in chunk])
            for (made, ball), groups in zip(chunk, rows, strict=True):
                region = _region(self.program, made, ball, groups)
                self.regions[made.active] = region
                self.queue.append(_Open(region, made, groups))

    def _full(self, near: dict[ActiveSet, FloatArray]) -> list[tuple[Candidate, Ball]]:
        """Of some active sets those with a region that is not flat; the others are put down."""
        made = {active: candidate(self.program, active) for active in near}
        able = {active: each for active, each in made.items() if each is not None}
        found = balls_of(self.program, list(able.values()), np.array([near[a] for a in able]))
        full = [pair for pair in zip(able.values(), found, strict=True) if is_full(pair[1])]
        for active, ball in zip(able, found, strict=True):
            if not is_full(ball) and ball.radius > -FLAT:
                self.flat.add(active)
        self.nothing.update(set(made) - {each.active for each, _ in full})
        return full

    def _behind(self, work: _Open, group: list[int]) -> list[ActiveSet] | None:
        """Active sets behind a facet on which one row alone vanishes: none where nothing is
        feasible, None where several rows vanish and theory does not tell."""
        if len(group) != 1:
            return None
        place, kind = int(work.made.places[group[0]]), work.made.kinds[group[0]]
        if kind == MULTIPLIER:
            return [tuple(i for i in work.made.active if i != place)]
        beyond = tuple(sorted((*work.made.active, place)))
        if is_independent(self.program, beyond):
            return [beyond]
        return exchanges(self.program, work.made.active, place)

    def _settled(self, work: _Open, row: int, sets: list[ActiveSet]) -> bool:
        """Whether the sets that theory names are what is behind a facet."""
        if not sets:
            self.counts["end"] += 1
            return True
        # behind a wide facet a region can only be missed if rows that vanish there were not seen as
        # equal; then the region found does not reach the facet everywhere, and is not the answer
        normal, height = work.region.h[row], work.region.k[row]
        behind = [self.regions[active] for active in sets if active in self.regions]
        if not any(_shares(region, normal, height) for region in behind):
            return False
        self.counts["shared"] += 1
        return True

    def _stepped(self, region: Region, row: int) -> None:
        height = float(region.k[row])
        if bounds_feasible_set(self.program, region.h[row], height):
            self.counts["end"] += 1
            return
        self.counts["stepped"] += 1
        pieces = [facet_of(region, self.program, row)]
        while pieces:
            self.parts += 1
            if self.parts > _PARTS + _PARTS_PER_REGION * len(self.regions):
                expected = "regions that numbers tell apart (fewer constraints, a shorter horizon)"
                raise ExplicitError("set of facets", "in too many parts", expected)
            piece = pieces.pop()
            place = generic_point(piece)
            if place is None:
                continue
            behind = across(self.program, piece, self._build)
            if behind.region is not None and piece.basis.shape[1]:
                pieces.extend(subtract(piece, behind.region))
            elif behind.note and place[1] <= SLIVER:
                self.slivers += 1
            elif behind.note:
                self.unresolved.append(behind.note)

    def _start(self) -> None:
        centre, radius = self._middle()
        for trial in range(_STARTS):
            shift = np.cos((1.0 + 2.3 * np.arange(centre.size)) * (1.0 + trial))
            point = centre + 0.5 * radius * shift / np.linalg.norm(shift)
            active = optimal_set(self.program, point)
            if active is not None and self._build(active) is not None:
                return
        raise ExplicitError("regions", None, "a region that is not flat around the first point")

    def _middle(self) -> tuple[FloatArray, float]:
        """A ball of feasible parameters, by one linear program in (s, eta)."""
        program = self.program
        n, r = program.g.shape[1], program.image.size
        lengths = np.linalg.norm(program.e, axis=1)
        # a ball of eta alone needs slack |e| for each row of (s, eta); given all of it, s may stay
        rows = np.vstack([
            np.column_stack([program.g, -program.e, lengths]),
            np.column_stack([np.zeros((program.domain_bounds.size, n)), program.domain_rows,
                             np.ones(program.domain_bounds.size)]),
            np.append(np.zeros(n + r), 1.0),
        ])  # fmt: skip
        bounds = np.concatenate([program.w, program.domain_bounds, [1.0]])
        point, radius = _best(rows, bounds, n)
        if radius <= FLAT:
            wide = inner_ball(rows[:-1, :-1], bounds[:-1])
            if wide.radius > FLAT:
                return wide.centre[n:], wide.radius
            expected = "a full-dimensional set of parameters for which it has a solution"
            text = "empty" if wide.radius < -FLAT else "flat"
            raise ExplicitError("feasible set of the program", text, expected)
        return point, radius


def _best(rows: FloatArray, bounds: FloatArray, n: int) -> tuple[FloatArray, float]:
    from servogen.sets.polyhedron import maximise

    objective = np.zeros(rows.shape[1])
    objective[-1] = 1.0
    best = maximise(rows, bounds, objective)
    assert best.point is not None
    return best.point[n:-1], best.value


def _shares(region: Region, normal: FloatArray, height: float) -> bool:
    """Whether ``region`` has a facet on normal eta = height, seen from the other side."""
    if not region.k.size:
        return False
    same = np.max(np.abs(region.h + normal), axis=1) <= 1e-6
    return bool(np.any(same & (np.abs(region.k + height) <= 1e-6 * (1.0 + abs(height)))))
