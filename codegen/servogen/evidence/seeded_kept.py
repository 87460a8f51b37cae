"""Results of checks on mutants, kept from run to run: the whole table takes an hour or more."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

from servogen.evidence.bench import Bench
from servogen.outputs import write_file

_HERE = Path(__file__).resolve().parent


class Kept:
    """A file of results. One is only used again for the same C and the same text of the check.

    Args:
        path: made when the first result is kept; text that is not its own counts as empty.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._said: dict[str, str] = {}
        try:
            read = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            read = {}
        if isinstance(read, dict):
            self._said = {str(k): str(v) for k, v in read.items()}

    def find(self, check: str, mutant: Bench) -> str | None:
        """What the check said of this C, if it was ever asked."""
        return self._said.get(_key(check, mutant))

    def keep(self, check: str, mutant: Bench, said: str) -> None:
        self._said[_key(check, mutant)] = said
        write_file(self._path, json.dumps(self._said, indent=0, sort_keys=True) + "\n")


def _key(check: str, mutant: Bench) -> str:
    """From the C and the check's own modules; the three quick checks share theirs."""
    modules = sorted(_HERE.glob(f"{check}*.py")) or [_HERE / "seeded_quick.py"]
    parts = [check, *(m.read_text(encoding="utf-8") for m in modules), *mutant.digests.values()]
    return f"{check} {hashlib.sha256(chr(0).join(parts).encode()).hexdigest()[:32]}"
