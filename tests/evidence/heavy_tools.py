"""Tests that start a prover, an emulated processor or a checker of rules for seconds each.

``make test`` leaves them to ``make test-tools``, so that it stays a matter of minutes; CI runs
both.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable

import pytest

Test = Callable[..., None]


def needs(tool: str, target: str) -> Callable[[Test], Test]:
    """A test with a tool, skipped where it is not installed; ``make <target>`` is not."""
    missing = pytest.mark.skipif(
        shutil.which(tool) is None, reason=f"no {tool} here; make {target} needs it"
    )
    return lambda test: pytest.mark.tools(missing(test))


needs_framac = needs("frama-c", "prove")
needs_clang = needs("clang", "fuzz")
