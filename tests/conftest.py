"""A folder that all workers of one run share, for what is compiled once in it."""

from __future__ import annotations

import os
import shutil
import tempfile

import pytest

SHARED = "SERVOGEN_TESTS_SHARED"  # read by tests/sil/shared_builds.py
_made = pytest.StashKey[str]()


def pytest_configure(config: pytest.Config) -> None:
    """Made before the workers start, which inherit the environment."""
    if not hasattr(config, "workerinput"):
        folder = tempfile.mkdtemp(prefix="servogen-tests-")
        config.stash[_made] = os.environ[SHARED] = folder


def pytest_unconfigure(config: pytest.Config) -> None:
    folder = config.stash.get(_made, None)
    if folder is not None:
        os.environ.pop(SHARED, None)
        shutil.rmtree(folder, ignore_errors=True)
