"""The most iterations that the dual active-set method takes over a set of parameters, and for whom.

The parameters are cut into pieces on which the method goes one way (``iteration_paths``), from a
cold start and from every working set that a call can leave for the next one; the next parameter may
be any of the set, whatever the last one was. For a controller in its loop that says too much, over
all sequences of parameters it is what happens.

A piece stays unless a linear program shows that it is empty, so that the bound is not too low; the
method itself, run at a point inside the piece that needs most, shows that it is not too high. Of
rounding the pieces know nothing: what rows may round to is bounded (``iteration_rounding``) and
held against ``accept``, and the method is run at random parameters too (``iteration_trials``).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from servogen.explicit.errors import ExplicitError
from servogen.explicit.iteration_paths import Ending, Paths, Place, Sides, Start, Way
from servogen.explicit.iteration_program import IterationProgram
from servogen.explicit.iteration_rounding import Rounding
from servogen.explicit.iteration_trials import (
    iterations_taken,
    most_taken,
    points_in_ball,
    points_inside,
)
from servogen.explicit.small_lp import inner_balls
from servogen.explicit.tolerances import FLAT, NOT_EMPTY
from servogen.plants.statespace import FloatArray
from servogen.progress import Progress, Silent
from servogen.sets.errors import SetError

# Places that go through the linear programs together.
_TOGETHER = 48
# Iterations after which a way is taken for one that does not end.
_ENDLESS = 1000
# Pieces of the most iterations that are tried with the method itself.
_TRIED = 20


@dataclass(frozen=True)
class Piece:
    """Parameters for which the method goes one way.

    After a set that was shifted, those are among them for which no iteration is needed at all; that
    they are a piece of their own is asked first.

    Attributes:
        start: what the call began with. ending, iterations: how and when it ended.
        sides: the set it left. theta: (p,) a point inside.
        rows, bounds: (r, p), (r,) of the piece in the unit box of ``Paths``.
        radius: of the largest ball in it; not above FLAT: it may be a plane between two others.
    """

    start: Start
    ending: Ending
    iterations: int
    sides: Sides
    theta: FloatArray
    rows: FloatArray
    bounds: FloatArray
    radius: float


@dataclass(frozen=True)
class IterationCertificate:
    """What is known of the iterations.

    Attributes:
        finished: every piece was found; else ``bound`` is the most that was seen by then.
        bound: of the pieces; without rounding no parameter of the set takes more iterations.
        attained: what the method took at the end of ``witness``.
        witness: parameters (p,) to give one after the other, beginning with no set.
        pieces: ways that end; ``flat`` of them are not shown to have an inside, and
            ``bound_inside`` is the most of those that have.
        starts: working sets that calls begin with. left: places not followed any further.
        unending: pieces that come to no end within 1,000. infeasible: pieces that say so.
        by_iterations: pieces by their number of iterations, from 0 on.
        refuted: the most that the method took in a trial, if that is more than ``bound``; else 0.
        rounding: what rows may round to at the places met. accept: what it is held against: where
            it is not above, a row of the set may have to be met a second time, an iteration more.
    """

    finished: bool
    bound: int
    attained: int
    witness: tuple[FloatArray, ...]
    pieces: int
    flat: int
    bound_inside: int
    starts: int
    left: int
    unending: int
    infeasible: int
    by_iterations: tuple[int, ...]
    refuted: int = 0
    rounding: float = 0.0
    accept: float = np.inf

    @property
    def rounds(self) -> bool:
        """Whether rounding may leave a row of the set farther from its bound than ``accept``."""
        return not self.rounding < self.accept

    @property
    def exact(self) -> bool:
        """Whether the bound is one, is attained, nothing that was tried takes more, and rounding
        costs no refinement."""
        sure = self.finished and not self.unending and not self.refuted and not self.rounds
        return sure and self.attained == self.bound


class _Node(NamedTuple):
    start: Start
    place: Place
    rows: FloatArray
    bounds: FloatArray
    centre: FloatArray
    radius: float


def certify_iterations(
    program: IterationProgram,
    budget: int,
    warm: bool = True,
    progress: Progress | None = None,
    keep: Callable[[Piece], None] | None = None,
) -> IterationCertificate:
    """Cut the parameters into pieces; the greatest number of iterations of any.

    The method's cap plays no part: a bound above it says that the cap would be met.

    Args:
        budget: places of the method (see ``Place``) to look at; then it ends unfinished.
        warm: follow the working sets that calls leave, not the cold start alone.
        keep: told of every piece.

    Raises:
        ExplicitError: the set of parameters is empty or unbounded; ``accept`` is too small for it
            (``Paths.least_accept``).
    """
    search = _Search(program, warm, keep)
    with (progress or Silent()).task("Ways of the active-set method", budget) as task:
        while search.open and search.looked < budget:
            before = search.looked
            search.advance()
            task.advance(search.looked - before)
    return search.certificate()


@dataclass
class _Found:
    """How a start was first met: the start before it, and a parameter of that call."""

    depth: int
    before: Start | None
    theta: FloatArray
    radius: float


@dataclass
class _Search:
    program: IterationProgram
    warm: bool
    keep: Callable[[Piece], None] | None
    open: list[_Node] = field(default_factory=list)
    looked: int = 0
    pieces: int = 0
    flat: int = 0
    inside: int = 0
    unending: int = 0
    infeasible: int = 0
    counts: dict[int, int] = field(default_factory=dict)
    longest: list[_Node] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.paths = Paths(self.program)
        accept, least = float(self.program.tables.accept), self.paths.least_accept()
        if not accept >= least:
            # rounded up, so that what is told will do
            told = f"at least {1.05 * least:.1e}, which pieces of this set of parameters can tell"
            raise ExplicitError("accept", accept, f"{told} from nothing")
        self._never_kept = self.paths.violations()
        self.rounding = Rounding(self.program, self.paths.middle, self.paths.half)
        self.starts: dict[Start, _Found] = {}
        self._meet(Start(), None, np.zeros(self.program.parameters), 1.0)

    def _meet(self, start: Start, before: Start | None, theta: FloatArray, radius: float) -> None:
        """A start, perhaps a new one; the roomiest piece that leads there is remembered."""
        depth = 0 if before is None else self.starts[before].depth + 1
        known = self.starts.get(start)
        if known is not None:
            if depth <= known.depth and radius > known.radius and before is not None:
                self.starts[start] = _Found(known.depth, before, theta, radius)
            return
        self.starts[start] = _Found(depth, before, theta, radius)
        p = self.program.parameters
        root = _Node(start, Place.nowhere(), np.zeros((0, p)), np.zeros(0), np.zeros(p), -1.0)
        self._sort([(root, way) for way in self.paths.begin(start)])

    def advance(self) -> None:
        """Every way on from the places found last."""
        batch, self.open = self.open[-_TOGETHER:], self.open[:-_TOGETHER]
        self.looked += len(batch)
        self._sort([(node, way) for node in batch for way in self.paths.onward(node.place)])

    def _sort(self, found: list[tuple[_Node, Way]]) -> None:
        """Keep what is not empty; ends become pieces."""
        reach = [
            min(node.radius, float((way.bounds - way.rows @ node.centre).min(initial=np.inf)))
            for node, way in found
        ]
        # a ball of the parent that is inside needs no program
        asked = [i for i, radius in enumerate(reach) if not radius > 100.0 * FLAT]
        asked.sort(key=lambda i: found[i][0].bounds.size + found[i][1].bounds.size)
        balls = self._balls([found[i] for i in asked])
        inside = dict(zip(asked, balls, strict=True))
        for i, (parent, way) in enumerate(found):
            centre, radius = inside.get(i, (parent.centre, reach[i]))
            if radius < -NOT_EMPTY:
                continue
            place = self.paths.entered(way.place)
            if place.stage == "look":
                self.rounding.met(place.sides, place.dual)
            h, k = np.vstack([parent.rows, way.rows]), np.append(parent.bounds, way.bounds)
            node = _Node(parent.start, place, h, k, centre, radius)
            if place.stage != "end" and place.iterations < _ENDLESS:
                self.open.append(node)
            elif not place.violated or self._some_violated(node):
                self._end(node)

    def _balls(self, asked: list[tuple[_Node, Way]]) -> list[tuple[FloatArray, float]]:
        """Centre and radius of each; a program that is not solved leaves its piece in place."""
        result: list[tuple[FloatArray, float]] = []
        p, shared = self.program.parameters, self._domain[1].size
        for first in range(0, len(asked), 256):
            chunk = asked[first : first + 256]
            most = max(node.bounds.size + way.bounds.size for node, way in chunk)
            h, k = np.zeros((len(chunk), most, p)), np.ones((len(chunk), most + shared))
            for j, (node, way) in enumerate(chunk):
                a, b = node.bounds.size, node.bounds.size + way.bounds.size
                h[j, :a], h[j, a:b] = node.rows, way.rows
                k[j, :a], k[j, a:b] = node.bounds, way.bounds
            k[:, most:] = self._domain[1]
            try:
                balls = inner_balls(h, k, shared=self._domain[0])
                result += [(ball.centre, ball.radius) for ball in balls]
            except SetError:
                result += [self._ball(h[j], k[j]) for j in range(len(chunk))]
        return result

    def _ball(self, h: FloatArray, k: FloatArray) -> tuple[FloatArray, float]:
        try:
            ball = inner_balls(h[None], k[None], shared=self._domain[0])[0]
        except SetError:
            return np.zeros(self.program.parameters), 0.0
        return ball.centre, ball.radius

    @property
    def _domain(self) -> tuple[FloatArray, FloatArray]:
        return self.paths.domain, self.paths.domain_bounds

    def _some_violated(self, node: _Node) -> bool:
        """Whether a piece has a point at which the optimum without rows does not keep them all."""
        rows, bounds = self._never_kept
        if np.any(rows @ node.centre < bounds - FLAT):
            return True
        one = [
            Way(node.place, row[None], bound[None]) for row, bound in zip(rows, bounds, strict=True)
        ]
        found = self._balls([(node, way) for way in one])
        return any(radius >= -NOT_EMPTY for _, radius in found)

    def _end(self, node: _Node) -> None:
        place, theta = node.place, self.paths.theta(node.centre)
        ending: Ending = place.ending if place.stage == "end" else "unending"
        count = place.iterations
        self.pieces += 1
        self.unending += ending == "unending"
        self.infeasible += ending == "infeasible"
        self.counts[count] = self.counts.get(count, 0) + 1
        if node.radius > FLAT:
            self.inside = max(self.inside, count)
        else:
            self.flat += 1
        if ending != "unending":
            self._remember(node)
        if self.keep is not None:
            self.keep(
                Piece(
                    node.start, ending, count, place.sides, theta, node.rows, node.bounds,
                    node.radius,
                )
            )  # fmt: skip
        if self.warm:
            left = place.sides if ending != "infeasible" else ()
            self._meet(self.paths.next_start(left), node.start, theta, node.radius)

    def _remember(self, node: _Node) -> None:
        """The longest ways, the roomiest first."""
        self.longest.append(node)
        if len(self.longest) > 4 * _TRIED:
            self.longest.sort(key=lambda one: (-one.place.iterations, -one.radius))
            del self.longest[_TRIED:]

    def certificate(self) -> IterationCertificate:
        """What was found, and the method's own word for the longest way."""
        self.longest.sort(key=lambda one: (-one.place.iterations, -one.radius))
        attained, witness = self._witness()
        most = max(self.counts, default=0)
        finished = not self.open
        # what is not finished makes no claim that a trial could take back
        tried = max(attained, self._tried()) if finished else 0
        return IterationCertificate(
            finished=finished,
            bound=most if finished else max(most, attained),
            attained=attained,
            witness=witness,
            pieces=self.pieces,
            flat=self.flat,
            bound_inside=self.inside,
            starts=len(self.starts),
            left=len(self.open),
            unending=self.unending,
            infeasible=self.infeasible,
            by_iterations=tuple(self.counts.get(i, 0) for i in range(most + 1)),
            refuted=tried if tried > most else 0,
            rounding=self.rounding.most,
            accept=float(self.program.tables.accept),
        )

    def _witness(self) -> tuple[int, tuple[FloatArray, ...]]:
        """The most that the method takes at the end of one of the longest ways, and that way."""
        attained, witness = 0, tuple[FloatArray, ...]()
        for node in self.longest[:_TRIED]:
            if attained >= node.place.iterations:
                break
            sequence = (*self._sequence(node.start), self.paths.theta(node.centre))
            taken = iterations_taken(self.program, sequence, _ENDLESS)[-1]
            if taken > attained:
                attained, witness = taken, sequence
        return attained, witness

    def _tried(self) -> int:
        """The most that the method takes anywhere: each call from no set or, where sets are
        followed, after all of them before it; and in the longest pieces."""
        rows, bounds = self._domain
        middle = self._ball(rows[:0], bounds)[0]
        thetas = [self.paths.theta(t) for t in points_inside(rows, bounds, middle)]
        sequences: list[Sequence[FloatArray]] = [[theta] for theta in thetas]
        if self.warm:
            sequences.append(thetas)
        for node in self.longest[:_TRIED]:
            before = self._sequence(node.start)
            sequences += [
                (*before, self.paths.theta(t)) for t in points_in_ball(node.centre, node.radius)
            ]
        return most_taken(self.program, sequences, _ENDLESS)

    def _sequence(self, start: Start) -> tuple[FloatArray, ...]:
        """Parameters whose calls lead to this start."""
        thetas: list[FloatArray] = []
        at: Start | None = start
        while at is not None:
            found = self.starts[at]
            if found.before is not None:
                thetas.append(found.theta)
            at = found.before
        return tuple(reversed(thetas))
