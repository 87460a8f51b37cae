"""One compilation of the same C for all workers of a test run."""

from __future__ import annotations

import fcntl
import hashlib
import os
from collections.abc import Sequence
from pathlib import Path

from servogen.emit.package import CPackage
from servogen.sil import build


def compiled_once(packages: Sequence[CPackage], flags: Sequence[str]) -> build.Module:
    """``compile_package``, or what another worker made of the same text with the same flags.

    Nothing outlives the run: the folder is made and removed by tests/conftest.py.
    """
    shared = Path(os.environ["SERVOGEN_TESTS_SHARED"])
    folder = shared / key(packages, flags)
    with (shared / f"{folder.name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        done = folder / "done"
        if done.exists():
            path = folder / done.read_text(encoding="utf-8")
            return build._load(path.name.partition(".")[0], path)
        folder.mkdir(exist_ok=True)
        module = build.compile_package(packages, folder, flags)
        if file := getattr(module, "__file__", None):  # none where Python's headers are missing
            done.write_text(str(Path(file).relative_to(folder)), encoding="utf-8")
        return module


def key(packages: Sequence[CPackage], flags: Sequence[str]) -> str:
    """A hash of every file and every flag."""
    said = hashlib.sha256(repr((build.COMPILE_FLAGS, tuple(flags))).encode())
    for package in packages:
        said.update(repr((package.name, package.hash, sorted(package.files.items()))).encode())
        said.update(repr([(d.prefix, d.operations) for d in package.declarations]).encode())
    return said.hexdigest()[:16]
