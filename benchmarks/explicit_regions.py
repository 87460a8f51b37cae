"""Critical regions of the servo drive: our time against PPOPT's, in one run, inside one box; and
the search trees that are grown from them, with the work that a lookup by each is.

    python benchmarks/explicit_regions.py [H_u ...]

Both get the same program with the same parameters; PPOPT gets it with all of them scaled to one,
which is in its favour, and is asked for its combinatorial algorithm, which is its default. Times
are the processor's, so that what else a machine does tells little; ours is the median of a few
runs. Printed: regions of both, whether the active sets are the same, both times and their ratio;
then, for H_u = 3, every tree's nodes and depth. Status 1 where the sets differ, the ratio is below
twenty, or a tree is larger than it has to be.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from statistics import median

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "explicit"))

import numpy as np
from explicit_problems import servo_drive
from ppopt_peer import ppopt_active_sets

from servogen.explicit.clips import without_first_bounds
from servogen.explicit.explore import solve
from servogen.explicit.grow import Growth
from servogen.explicit.lookup import tree_lookup
from servogen.explicit.pieces import arrange
from servogen.explicit.turned import turned

RUNS = 5
LEAST_RATIO = 20.0
WORK = 10_000
# The tree, whether in the box, without the first move's bounds, across which of its hyperplanes it
# is mirrored; and the most nodes and depth that are allowed for it.
TREES = (
    ("law tree in the box", True, False, None, (79, 7)),
    ("law tree", False, False, None, (91, 7)),
    ("law tree, odd", False, False, 30, None),
    ("clip tree", False, True, None, (27, 5)),
    ("clip tree, odd", False, True, 4, (15, 3)),
)


def main() -> int:
    horizons = [int(word) for word in sys.argv[1:]] or [3, 4, 5]
    well = [*(enumerated(moves) for moves in horizons), grown()]
    return 0 if all(well) else 1


def enumerated(moves: int) -> bool:
    """Ours against PPOPT's."""
    problem = servo_drive(moves, moves, inside_box=True)
    times = []
    for _ in range(RUNS):
        start = time.process_time()
        solution = solve(problem, 3**moves)
        times.append(time.process_time() - start)
    start = time.process_time()
    theirs = ppopt_active_sets(problem, "combinatorial", process=True)
    spent = time.process_time() - start
    ours = sorted(region.active for region in solution.regions)
    same = "the same" if ours == theirs else "NOT the same"
    print(
        f"H_u = {moves}: {len(ours)} regions, PPOPT {len(theirs)}, {same} active sets; "
        f"{1e3 * median(times):.0f} ms against {spent:.2f} s, "
        f"{spent / median(times):.0f} times faster"
    )
    return ours == theirs and spent >= LEAST_RATIO * median(times)


def grown() -> bool:
    """The trees for H_u = 3."""
    print(
        f"\n{'H_u = 3':24} {'regions':>7} {'laws':>5}  greedy: nodes depth  searched: nodes depth"
        "  multiply-adds comparisons sign changes"
    )
    well = True
    for name, in_box, clipped, across, allowed in TREES:
        problem, clip = servo_drive(3, inside_box=in_box), None
        if clipped:
            problem, clip = without_first_bounds(problem)
        solution = solve(problem, 100)
        mirror = -1
        if across is not None:
            normal = arrange(solution).planes[across, :-1]
            solution, mirror = turned(solution, normal / np.linalg.norm(normal))
        growth = Growth(arrange(solution), mirror)
        greedy = growth.tree()
        growth.thin_out(WORK - growth.lower(WORK))
        tree = growth.tree()
        count = tree_lookup(solution, tree, clip).count
        print(
            f"{name:24} {len(solution.regions):7} {solution.laws.count:5} "
            f"{greedy.nodes:14} {greedy.depth:5} {tree.nodes:16} {tree.depth:5} "
            f"{count.multiply_adds:14} {count.comparisons:11} {count.sign_changes:12}"
        )
        well = well and (allowed is None or (tree.nodes <= allowed[0] and tree.depth <= allowed[1]))
    return well


if __name__ == "__main__":
    sys.exit(main())
