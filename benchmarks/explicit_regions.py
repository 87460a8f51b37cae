"""Critical regions of the servo drive: our time against PPOPT's, in one run, inside one box.

    python benchmarks/explicit_regions.py [H_u ...]

Both get the same program with the same eight parameters; PPOPT gets it with all of them scaled to
one, which is in its favour, and is asked for its combinatorial algorithm, which is its default.
Printed: regions of both, whether the active sets are the same, the median time of ours over a few
runs, PPOPT's time, and their ratio. Status 1 where the sets differ or the ratio is below twenty.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from statistics import median

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "explicit"))

from explicit_problems import servo_drive
from ppopt_peer import ppopt_active_sets

from servogen.explicit.explore import solve

RUNS = 5
LEAST_RATIO = 20.0


def main() -> int:
    well = True
    for moves in [int(word) for word in sys.argv[1:]] or [3, 4, 5]:
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
        well = well and ours == theirs and spent >= LEAST_RATIO * median(times)
    return 0 if well else 1


if __name__ == "__main__":
    sys.exit(main())
