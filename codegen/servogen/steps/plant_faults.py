"""``make seeded``: plant faults in the C of a project, ask every check, write the table.

Arguments: the project file, the page whose section of this project is written, a file that keeps
what was found about the same C, and the checks to ask (all if none is named). A project whose MPC
is solved by the active set gets the faults of that method.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path

from servogen.errors import ServogenError
from servogen.evidence.catalogue import CHECKS
from servogen.evidence.seeded import FUZZING, columns_for, remembered, run_seeded
from servogen.evidence.seeded_kept import Kept
from servogen.evidence.seeded_table import page_text, table_text
from servogen.progress import for_stream
from servogen.project.systems import load_any_project
from servogen.steps.check import bench_of
from servogen.steps.prepare import prepare


def main(arguments: Sequence[str]) -> int:
    """Write the table; status 1 where a fault escapes all checks."""
    if len(arguments) < 3 or set(arguments[3:]) - set(CHECKS):
        print(
            f"usage: seeded PROJECT.toml TABLE.md KEPT.json [{' '.join(CHECKS)}]", file=sys.stderr
        )
        return 2
    progress = for_stream(sys.stderr)
    os.environ.update(FUZZING)
    try:
        bench = remembered(bench_of(prepare(load_any_project(Path(arguments[0])), progress)))
        kept = Kept(Path(arguments[2]))
        rows = run_seeded(bench, columns_for(bench, arguments[3:], kept), progress, kept)
    except ServogenError as error:
        print(f"servogen: {error}", file=sys.stderr)
        return error.exit_status
    page = Path(arguments[1])
    before = page.read_text(encoding="utf-8") if page.is_file() else ""
    page.write_text(page_text(before, table_text(bench, rows)), encoding="utf-8")
    escaped = [row.fault.name for row in rows if "caught" not in row.said.values()]
    for name in escaped:
        print(f"nothing that ran caught: {name}")
    return 1 if escaped else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
