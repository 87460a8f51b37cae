"""Ctrl-C as it comes from a keyboard: a signal, in the middle of writing, or of a check."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from servogen.errors import CheckFailed
from servogen.evidence.children import in_order
from servogen.evidence.tools import run_tool

# A job in the background of a script begins with SIGINT ignored; one at a keyboard does not.
LISTEN = """
import signal
signal.signal(signal.SIGINT, signal.default_int_handler)
"""
SCRIPT = """
import sys, time, types
import servogen
from servogen import outputs
from servogen.cli import main

def build(project, out, progress):
    write = outputs._write
    def slow(path, data):
        write(path, data)
        if path.name == "second.c":
            print("half-way", flush=True)
            time.sleep(60)
    outputs._write = slow
    outputs.write_tree(out, {"first.c": "", "second.c": "", "manifest.json": "{}"})

servogen.pipeline = sys.modules["servogen.pipeline"] = types.SimpleNamespace(build=build)
sys.exit(main(["build", sys.argv[1], "-o", sys.argv[2]]))
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_real_signal_ends_with_one_line_status_130_and_the_old_output(
    small: Path, tmp_path: Path, number: signal.Signals
) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "manifest.json").write_text('{"schema": "servogen.manifest/1"}')
    process = subprocess.Popen(
        [sys.executable, "-c", LISTEN + SCRIPT, str(small), str(out)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "half-way\n"
    process.send_signal(number)
    _, err = process.communicate(timeout=30)
    assert process.returncode == 130
    assert err.strip() == "servogen: interrupted"
    assert [path.name for path in out.iterdir()] == ["manifest.json"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out", "small"]


POOL = """
import sys, types
import servogen
from servogen.cli import main
from servogen.evidence import pil
from servogen.evidence.tools import run_tool
from servogen.progress import Silent

def examine(stand, short, precision, core, plugin):
    for _ in range(2):  # a tool that has failed does not keep all work from going on
        run_tool(["sh", "-c", f"sleep 60 & echo $$ $! >> {sys.argv[2]}; wait"])

def check(project, name, out, progress):
    subjects = [types.SimpleNamespace(precision=number) for number in range(3)]
    pil._examine_all(subjects, [(None, None)] * 3, None, Silent())

pil.examine = examine
servogen.pipeline = sys.modules["servogen.pipeline"] = types.SimpleNamespace(check=check)
sys.exit(main(["check", "pil", sys.argv[1], "-o", "nowhere"]))
"""


def alive(number: str) -> bool:
    """Not gone, and not only waited for."""
    status = Path("/proc", number, "stat")
    return status.exists() and status.read_text().rpartition(")")[2].split()[0] not in "ZX"


def started(places: Path, count: int) -> list[str]:
    for _ in range(300):
        numbers = places.read_text().split() if places.exists() else []
        if len(numbers) >= count:
            return numbers
        time.sleep(0.05)
    raise AssertionError("the tools were not started")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_check_ends_the_tools_of_all_its_threads(
    small: Path, tmp_path: Path, number: signal.Signals
) -> None:
    """Two of six run, each with a child of its own; none of the others is begun."""
    places = tmp_path / "pids"
    process = subprocess.Popen(
        [sys.executable, "-c", LISTEN + POOL, str(small), str(places)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    numbers = started(places, 4)
    assert all(alive(n) for n in numbers)
    process.send_signal(number)
    out, err = process.communicate(timeout=20)
    assert process.returncode == 130
    assert (out, err.strip()) == ("", "servogen: interrupted")
    assert not [n for n in places.read_text().split() if alive(n)]
    assert len(places.read_text().split()) == 4


def test_the_first_failure_ends_the_rest(tmp_path: Path) -> None:
    places = tmp_path / "pids"

    def work(job: int) -> int:
        if job == 1:
            started(places, 2)
            raise CheckFailed("no")
        run_tool(["sh", "-c", f"sleep 60 & echo $$ $! >> {places}; wait"])
        return job

    with pytest.raises(CheckFailed, match="no"):
        list(in_order(work, range(5), 2))
    assert not [n for n in places.read_text().split() if alive(n)]
    assert list(in_order(lambda job: job * job, range(5), 2)) == [0, 1, 4, 9, 16]
    assert run_tool(["echo", "after"]).stdout == "after\n"
