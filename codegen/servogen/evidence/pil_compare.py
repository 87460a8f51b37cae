"""Two sets of answers to the same calls, bit for bit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from servogen.controllers.design import Declaration
from servogen.sil.player import Answer, Play, decode, differing, status_name


def first_difference(
    declarations: Sequence[Declaration], plays: Sequence[Play], host: bytes, board: bytes
) -> str | None:
    """Where the board first says something else than the host, with both values; None if nowhere.

    Padding does not count.
    """
    if host == board:
        return None
    try:
        for ours, theirs in zip(
            decode(declarations, plays, host), decode(declarations, plays, board), strict=True
        ):
            item = differing(ours, theirs)
            if item is not None:
                return _sentence(ours, theirs, item)
    except ValueError as error:
        return f"there are not as many answers as calls: {error}"
    return None


def _sentence(host: Answer, board: Answer, item: str) -> str:
    where = f"{host.play}, call {host.index}, {host.prefix}_{host.operation}"
    if item == "status":
        ours, theirs = status_name(host.status), status_name(board.status)
        return f"{where}: status {theirs} instead of the host's {ours}"
    assert host.outputs is not None
    assert board.outputs is not None
    first, second = np.atleast_1d(host.outputs[item]), np.atleast_1d(board.outputs[item])
    place = next(i for i in range(first.size) if first[i].tobytes() != second[i].tobytes())
    name = f"{item}[{place}]" if first.size > 1 else item
    return f"{where}: {name} is {_text(second[place])} instead of the host's {_text(first[place])}"


def _text(value: Any) -> str:
    return float(value).hex() if isinstance(value, np.floating) else str(int(value))
