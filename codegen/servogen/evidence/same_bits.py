"""Two sets of answers to the same calls, compared bit for bit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from servogen.controllers.design import Declaration
from servogen.sil.player import Answer, Play, decode, differing, status_name


def first_difference(
    declarations: Sequence[Declaration], plays: Sequence[Play], right: bytes, told: bytes
) -> str | None:
    """Where ``told`` first says something else than ``right``, with both values; None if nowhere.

    Padding does not count.
    """
    if right == told:
        return None
    try:
        for one, other in zip(
            decode(declarations, plays, right), decode(declarations, plays, told), strict=True
        ):
            item = differing(one, other)
            if item is not None:
                return _sentence(one, other, item)
    except ValueError as error:
        return f"there are not as many answers as calls: {error}"
    return None


def _sentence(right: Answer, told: Answer, item: str) -> str:
    where = f"{right.play}, call {right.index}, {right.prefix}_{right.operation}"
    if item == "status":
        said = f"{status_name(told.status)} instead of {status_name(right.status)}"
        return f"{where}: status {said}"
    assert right.outputs is not None
    assert told.outputs is not None
    first, second = np.atleast_1d(right.outputs[item]), np.atleast_1d(told.outputs[item])
    place = next(i for i in range(first.size) if first[i].tobytes() != second[i].tobytes())
    name = f"{item}[{place}]" if first.size > 1 else item
    return f"{where}: {name} is {_text(second[place])} instead of {_text(first[place])}"


def _text(value: Any) -> str:
    return float(value).hex() if isinstance(value, np.floating) else str(int(value))
