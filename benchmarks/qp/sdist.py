"""Sources of a peer from the package index, kept beside what is built of them."""

from __future__ import annotations

import importlib.metadata
import sys
import tarfile
from functools import cache
from pathlib import Path

from qp.counted import PeerFailed, run


@cache
def sdist(name: str, folder: Path, version: str | None = None) -> Path:
    """The unpacked sources of a package, of the installed version or the one given.

    Raises:
        PeerFailed: neither installed nor a version given, or the index does not give it.
    """
    if version is None:
        try:
            version = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError as missing:
            raise PeerFailed(f"not installed: {missing}") from missing
    place = folder / f"{name}-{version}"
    if not place.is_dir():
        folder.mkdir(parents=True, exist_ok=True)
        run(
            [sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check",
             "--no-deps", "--no-binary", name, "-d", folder, f"{name}=={version}"],
            folder,
        )  # fmt: skip
        archive = folder / f"{name}-{version}.tar.gz"
        if not archive.is_file():
            raise PeerFailed(f"the index has no sources of {name} {version}")
        with tarfile.open(archive) as packed:
            packed.extractall(folder, filter="data")
    return place
