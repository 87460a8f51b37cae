"""Where the files that travel with the package are: templates, C runtime, examples.

In a checkout they stand at the top level; in an installed wheel below ``servogen/_data``.
"""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent


def resource_dir(name: str) -> Path:
    """Folder ``templates``, ``c_runtime`` or ``examples``.

    Raises:
        FileNotFoundError: neither the wheel's nor the checkout's folder is there.
    """
    for base in (_PACKAGE / "_data", _PACKAGE.parents[1]):
        candidate = base / name
        if candidate.is_dir():
            return candidate
    raise FileNotFoundError(f"servogen's own folder '{name}' is missing from this installation")
