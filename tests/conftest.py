"""A folder that all workers of one run share, and which worker runs what.

pytest-xdist hands out single tests, so that every worker makes what the tests of a module share;
its ``xdist_group`` marks would mend that, but say nothing under pytest 9.2 (its issue 1386).
Here the tests of a module, or of a group, are one worker's, and the longest ones begin.
"""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from pathlib import Path
from typing import Any

import pytest
from xdist.scheduler import LoadScopeScheduling

SHARED = "SERVOGEN_TESTS_SHARED"  # read by tests/sil/shared_builds.py
_made = pytest.StashKey[str]()

# Modules and groups of 15 s and more, the longest first: whoever begins one last is waited for.
LONG = (
    "equivalence 1",
    "governor example",
    "coverage",
    "servo_drive",
    "equivalence 2",
    "governor mutants",
    "tests/sil/test_certified_iterations.py",
    "governor axis",
    "tests/systems/test_command_governor_properties.py",
    "tests/golden/test_generated_is_fresh.py",
    "tests/sets/test_admissible.py",
    "tests/evidence/test_compilers.py",
    "governor",
    "active set",
    "tests/steps/test_servo_plants.py",
    "tests/sil/test_lookup_sil.py",
    "mutants",
    "tests/cli/test_servo_verbs.py",
    "tests/evidence/test_sanitizers.py",
    "governor of the paper",
    "tests/sil/test_qp_edges.py",
    "tests/sil/test_minimal_motion_window.py",
    "tests/explicit/test_position_bounds.py",
    "tests/sil/test_command_governor_plan.py",
    "tests/cli/test_governor_verbs.py",
    "seeded",
    "tests/explicit/test_certify.py",
)


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


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The longest first; units of work are handed out in this order."""
    rank = {name: number for number, name in enumerate(LONG)}
    items.sort(key=lambda item: rank.get(_unit(item), len(LONG)))


@pytest.hookimpl(tryfirst=True)  # before xdist's own says that this worker is ready
def pytest_collection_finish(session: pytest.Session) -> None:
    """Each worker tells the units of its tests; who hands them out collects nothing."""
    if (worker := getattr(session.config, "workerinput", None)) is None:
        return
    told = Path(os.environ[SHARED]) / f"units-{worker['workerid']}.json"
    units = {item.nodeid: _unit(item) for item in session.items}
    told.write_text(json.dumps(units), encoding="utf-8")


def _unit(item: pytest.Item) -> str:
    """The name in the test's ``xdist_group`` mark, or its module."""
    mark = item.get_closest_marker("xdist_group")
    return item.nodeid.partition("::")[0] if mark is None else str(mark.args[0])


class Units(LoadScopeScheduling):
    """A unit of work is what ``_unit`` says; they go out in the order of the collection."""

    def __init__(self, config: pytest.Config, log: Any) -> None:
        super().__init__(config, log)
        config.option.loadscopereorder = False  # else the most tests first, not the longest
        self._units: dict[str, str] = {}

    def schedule(self) -> None:
        if not self._units:
            for told in Path(os.environ[SHARED]).glob("units-*.json"):
                self._units.update(json.loads(told.read_text(encoding="utf-8")))
        super().schedule()

    def _split_scope(self, nodeid: str) -> str:
        return self._units[nodeid]


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Units | None:
    return Units(config, log) if config.getvalue("dist") == "loadgroup" else None
