"""The proof of an explicit solution from its program alone: no findings of the search are used.

What is taken from a solution are its active sets, rows and laws, with the coordinates that they are
in; each is proved or refuted against the matrices of the quadratic program (``restated``):

- every active set is optimal all over its region, and the law is its first move (``optimality``);
- the regions leave no feasible parameter out but what is too narrow to see (``covering``).

So wherever the program has a solution there is a region, and what the region says is optimal. Two
regions that overlap say the same, since the optimum is unique: that they do not is not needed.
"""

from __future__ import annotations

from dataclasses import dataclass

from servogen.explicit.covering import Cover, prove_cover
from servogen.explicit.optimality import Optimal, prove_optimal
from servogen.explicit.restated import Restated, domain_excess, restate
from servogen.explicit.solution import ExplicitSolution
from servogen.explicit.tolerances import HOLE, PROVED, PROVED_LAW, SEEN
from servogen.progress import Progress


@dataclass(frozen=True)
class CertifiedLaws:
    """What was found of each region on its own.

    Attributes:
        unseen: what of a multiplier, slack or first move the coordinates do not show, as a share of
            its terms; domain: by how much a parameter of the domain may lie outside that in them.
        optimal: see there.
    """

    unseen: float
    domain: float
    optimal: Optimal


@dataclass(frozen=True)
class Certified(CertifiedLaws):
    """What was found of a solution: of its regions and of what they cover."""

    cover: Cover

    @property
    def holds(self) -> bool:
        """All of it, within the tolerances."""
        return (
            max(self.unseen, self.domain) <= SEEN
            and self.optimal.law_error <= PROVED_LAW
            and self.optimal.reach <= PROVED
            and self.covers
        )

    @property
    def covers(self) -> bool:
        """Whether the regions leave nothing out."""
        return not self.cover.open and self.cover.hole <= HOLE


def certify(solution: ExplicitSolution, progress: Progress) -> Certified:
    """The proof of all regions of a solution; its ``findings`` are not looked at."""
    laws, regions = certify_laws(solution, progress), solution.regions
    with progress.task("Proving what regions cover", total=len(regions)) as task:
        cover = prove_cover(_own(solution), regions, task)
    return Certified(laws.unseen, laws.domain, laws.optimal, cover)


def certify_laws(solution: ExplicitSolution, progress: Progress) -> CertifiedLaws:
    """That every region is optimal all over and has its optimum's first move; not that none is
    missing."""
    own, regions = _own(solution), solution.regions
    with progress.task("Proving regions", total=len(regions)) as task:
        optimal = prove_optimal(own, regions, solution.law_of, solution.laws, task)
    unseen = max(optimal.unseen, own.feasible_rows()[3])
    return CertifiedLaws(unseen, domain_excess(own), optimal)


def _own(solution: ExplicitSolution) -> Restated:
    program = solution.program
    return restate(solution.problem, solution.image, program.domain_rows, program.domain_bounds)
