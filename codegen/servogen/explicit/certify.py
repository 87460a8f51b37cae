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
from servogen.explicit.restated import domain_excess, restate
from servogen.explicit.solution import ExplicitSolution
from servogen.explicit.tolerances import HOLE, PROVED, PROVED_LAW, SEEN
from servogen.progress import Progress


@dataclass(frozen=True)
class Certified:
    """What was found of a solution.

    Attributes:
        unseen: what of a multiplier, slack or first move the coordinates do not show, as a share of
            its terms; domain: by how much a parameter of the domain may lie outside that in them.
        optimal, cover: see there.
    """

    unseen: float
    domain: float
    optimal: Optimal
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
    program, regions = solution.program, solution.regions
    own = restate(solution.problem, solution.image, program.domain_rows, program.domain_bounds)
    with progress.task("Proving regions", total=2 * len(regions)) as task:
        optimal = prove_optimal(own, regions, solution.law_of, solution.laws, task)
        cover = prove_cover(own, regions, task)
    unseen = max(optimal.unseen, own.feasible_rows()[3])
    return Certified(unseen, domain_excess(own), optimal, cover)
