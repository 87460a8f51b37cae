"""Ctrl-C as it comes from a keyboard: a signal, in the middle of writing."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

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
        [sys.executable, "-c", SCRIPT, str(small), str(out)],
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
