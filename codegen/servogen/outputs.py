"""Writing results: whole or not at all, and never over what servogen did not make.

Everything is first written under a hidden temporary name on the same file system and then renamed
into place. An interrupt leaves the old file or folder as it was, and nothing temporary behind.
"""

from __future__ import annotations

import errno
import os
import secrets
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path, PurePosixPath

from servogen.errors import InputError
from servogen.ownership import SCRATCH_PREFIX, check_replaceable

MARKER = "manifest.json"

_FILE, _FOLDER = "the output file", "the output folder"


def write_file(path: Path, data: bytes | str) -> None:
    """Write one file atomically, making the folders above it.

    Raises:
        InputError: the place cannot be written, or is a folder.
    """
    with _output_errors(path, _FILE):
        real = Path(os.path.realpath(path))  # through a link, so that the link stays one
        _refuse_folder(path, real)
        if _is_device(real):
            _write(real, data)
            return
        with _parents_of(real):
            scratch = _scratch_in(real.parent)
            try:
                _write(scratch, data)
                os.replace(scratch, real)
            finally:
                scratch.unlink(missing_ok=True)


def write_tree(out: Path, files: Mapping[str, bytes | str], marker: str | None = MARKER) -> None:
    """Make ``out`` a folder of exactly these files (relative names with /, contents).

    A folder that is there keeps its identity (it may be somebody's working directory or a mount
    point): its entries are exchanged, and put back if anything happens on the way.

    Args:
        marker: name of the JSON file that shows that servogen made a folder, see
            ``servogen.ownership``; None: replace no folder but an empty one.

    Raises:
        InputError: ``out`` cannot be written, is a file, or is a folder with anything in it that
            servogen did not make.
        ValueError: a name that is absolute or leads out of the folder.
    """
    for name in files:
        pure = PurePosixPath(name)
        if pure.is_absolute() or ".." in pure.parts or not pure.parts:
            raise ValueError(f"not a name inside the output folder: {name!r}")
    with _output_errors(out, _FOLDER):
        check_replaceable(out, marker)
        real = Path(os.path.realpath(out))
        with _parents_of(real):
            scratch = _scratch_in(real if real.is_dir() else real.parent)
            try:
                _fill(scratch / "new", files)
                if real.is_dir():
                    _exchange(real, scratch)
                else:
                    os.rename(scratch / "new", real)
            finally:
                shutil.rmtree(scratch, ignore_errors=True)


def check_file(path: Path) -> None:
    """Raise the InputError that ``write_file`` would raise now; leaves no trace.

    Asked before long computations, so that a mistyped name costs a second and not minutes.
    """
    with _output_errors(path, _FILE):
        real = Path(os.path.realpath(path))
        _refuse_folder(path, real)
        if not _is_device(real):
            _try_to_write(real)


def check_tree(out: Path, marker: str | None = MARKER) -> None:
    """Raise the InputError that ``write_tree`` would raise now; leaves no trace."""
    with _output_errors(out, _FOLDER):
        check_replaceable(out, marker)
        real = Path(os.path.realpath(out))
        _try_to_write(real / "any" if real.is_dir() else real)


def _refuse_folder(path: Path, real: Path) -> None:
    if real.is_dir():
        raise InputError(path, _FILE, "a folder", "the name of a file")


def _try_to_write(real: Path) -> None:
    with _parents_of(real, keep=False):
        scratch = _scratch_in(real.parent)
        try:
            scratch.write_bytes(b"")
            real.exists()  # a name too long is told here
        finally:
            scratch.unlink(missing_ok=True)


def _fill(folder: Path, files: Mapping[str, bytes | str]) -> None:
    folder.mkdir(parents=True)
    for name, data in files.items():
        place = folder / name
        place.parent.mkdir(parents=True, exist_ok=True)
        _write(place, data)


def _exchange(out: Path, scratch: Path) -> None:
    """Put ``scratch/new``'s entries into ``out`` and its old ones into ``scratch/old``, or neither.

    The old ones of an earlier run that was killed are cleared away with them.
    """
    old, new = scratch / "old", scratch / "new"
    old.mkdir()
    leaving = [entry for entry in out.iterdir() if entry != scratch]
    entering = list(new.iterdir())
    try:
        for entry in leaving:
            os.rename(entry, old / entry.name)
        for entry in entering:
            os.rename(entry, out / entry.name)
    except BaseException:
        for entry in entering:
            if not entry.exists() and (out / entry.name).exists():
                os.rename(out / entry.name, entry)
        for entry in old.iterdir():
            os.rename(entry, out / entry.name)
        raise


def _write(path: Path, data: bytes | str) -> None:
    # bytes, since a text file would turn newlines into another system's
    path.write_bytes(data.encode("utf-8") if isinstance(data, str) else data)


def _is_device(path: Path) -> bool:
    """Something like /dev/null or a pipe: written into, never replaced."""
    return path.exists() and not path.is_file() and not path.is_dir()


def _scratch_in(folder: Path) -> Path:
    return folder / f"{SCRATCH_PREFIX}{secrets.token_hex(6)}"


@contextmanager
def _parents_of(path: Path, keep: bool = True) -> Iterator[None]:
    """Make the folders above ``path``; take those made away again on failure or when not kept."""
    made = [parent for parent in path.parents if not parent.exists()]
    nearest = next(parent for parent in path.parents if parent.exists())
    if not nearest.is_dir():  # else the system says "file exists", which helps nobody
        raise NotADirectoryError(errno.ENOTDIR, f"{nearest.name} is not a directory")
    done = False
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield
        done = keep
    finally:
        if not done:
            for parent in made:
                with suppress(OSError):
                    parent.rmdir()


@contextmanager
def _output_errors(path: Path, key: str) -> Iterator[None]:
    """What the system says about a place, as an InputError."""
    try:
        yield
    except (OSError, ValueError) as error:  # ValueError: a name with a null byte
        if not isinstance(error, OSError) and "null" not in str(error):
            raise
        reason = getattr(error, "strerror", None) or str(error)
        expected = "a place that can be written"
        raise InputError(path, key, f"not writable ({reason})", expected) from error
