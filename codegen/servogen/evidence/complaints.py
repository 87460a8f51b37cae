"""What a sanitizer, libFuzzer or the fuzzing harness says, in one line."""

from __future__ import annotations

import re
from pathlib import Path

_COMPLAINT = re.compile(r"servogen fuzz: .*|.*runtime error: .*|.*ERROR: (?:Address|lib).*")


def complaint(said: str, folder: Path) -> str:
    """The first line that says what it is about, without paths of ours, process numbers and
    addresses; failing that the first line."""
    found = _COMPLAINT.search(said)
    text = found[0] if found else (said.strip().splitlines() or ["it ended early"])[0]
    return re.sub(r"==\d+==|0x[0-9a-f]+", "", text.replace(f"{folder}/", "")).strip()
