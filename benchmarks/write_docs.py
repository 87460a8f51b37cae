"""The tables and plots of docs/benchmarks.md, from the last whole run of ``make bench``.

    python benchmarks/write_docs.py [out/bench]

Text outside the marked places is left alone. The plots become pictures where there is a Chromium.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

from qp.document import DocumentError, lookup_parts, qp_parts, rewritten, whole
from qp.told import write

DOCS = Path(__file__).resolve().parents[1] / "docs"
PLOTS = ("qp_growth", "lookups")
SIZE = "900,580"


def picture(page: Path, image: Path) -> bool:
    """A screenshot of a page; False without a browser."""
    browser = next(filter(None, map(shutil.which, ("chromium", "chromium-browser"))), None)
    if browser is None:
        return False
    with tempfile.TemporaryDirectory() as profile:
        subprocess.run(
            [browser, "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run",
             "--disable-background-networking", "--disable-component-update", "--disable-sync",
             "--hide-scrollbars", f"--user-data-dir={profile}", f"--window-size={SIZE}",
             "--virtual-time-budget=10000", f"--screenshot={image}", page.resolve().as_uri()],
            check=True, capture_output=True, timeout=120,
        )  # fmt: skip
    return True


def main() -> int:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/bench")
    document = DOCS / "benchmarks.md"
    try:
        parts = {}
        for name, make in (("qp", qp_parts), ("lookups", lookup_parts)):
            place = folder / f"{name}.json"
            parts |= make(whole(json.loads(place.read_text()), place))
        write(rewritten(document.read_text(), parts), document)
    except (OSError, DocumentError) as fault:
        print(f"nothing written: {fault}")
        return 1
    print(f"{document}: {len(parts)} tables")
    for name in PLOTS:
        if not picture(folder / f"{name}.html", DOCS / "images" / f"{name}.png"):
            print("no pictures: no Chromium here")
            break
    return 0


if __name__ == "__main__":
    sys.exit(main())
