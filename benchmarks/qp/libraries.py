"""The solvers that come as libraries, compiled or linked into the harness so that callgrind counts
them as it counts the rest, without Python."""

from __future__ import annotations

import importlib.metadata
import json
import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

from qp.counted import HERE, Measured, PeerFailed, compile_peer, counted_peer, run
from qp.sdist import sdist
from qp.sequence import Sequence
from qp.tolerance import TOLERANCE, reaching

# An interior-point method stops at residuals, from which z is a few times further.
INTERIOR = (1e-10, 1e-11, 1e-12)
# Of TinyMPC; it may be tried with any version that the index has.
TINYMPC_VERSION = "0.0.8"
TINYMPC_ITERATIONS = 10_000
WRAPPED = ("-Wl,--wrap=malloc", "-Wl,--wrap=calloc")

PROXQP = "ProxQP"
PIQP = "PIQP"
QUADPROG = "quadprog"
QPOASES = "qpOASES in CasADi"
TINYMPC = "TinyMPC"


def casadi_folder() -> Path:
    try:
        import casadi
    except ImportError as missing:
        raise PeerFailed(f"not installed: {missing}") from missing
    return Path(casadi.__file__).parent


def eigen() -> Path:
    """Headers of Eigen: CasADi's package has them."""
    place = casadi_folder() / "include" / "eigen3"
    if not place.is_dir():
        raise PeerFailed("no headers of Eigen: this package of CasADi has none")
    return place


def proxsuite_headers() -> Path:
    """Of the installed package, beside its library."""
    for folder in map(Path, sys.path):
        place = folder / "cmeel.prefix" / "include"
        if (place / "proxsuite").is_dir():
            return place
    raise PeerFailed("not installed: no headers of proxsuite")


@cache
def _built(
    source: str, folder: Path, includes: tuple[Path, ...], extra: tuple[str, ...],
    others: tuple[Path, ...] = (),
) -> Path:  # fmt: skip
    """A peer that knows nothing of the sequence: once for all of them."""
    folder.mkdir(parents=True, exist_ok=True)
    return compile_peer(folder, [HERE / source, *others], includes, extra)


def _cpp(
    source: str, folder: Path, includes: Iterable[Path], tolerance: float, *extra: str,
    others: tuple[Path, ...] = (),
) -> Path:  # fmt: skip
    place = folder / f"{Path(source).stem}_{tolerance:g}"
    given = (*WRAPPED, f"-DTOLERANCE={tolerance}", "-DNDEBUG", "-std=c++17", *extra)
    return _built(source, place, tuple(includes), given, (HERE / "asked.c", *others))


def piqp(sequence: Sequence, part: slice, folder: Path) -> Measured:
    """From the headers of its sdist."""
    includes = [sdist("piqp", folder.parent) / "include", eigen()]

    def measure(tolerance: float) -> Measured:
        program = _cpp("piqp_peer.cpp", folder, includes, tolerance)
        return counted_peer(PIQP, program, sequence, part)

    return reaching(measure, INTERIOR)


def proxqp(sequence: Sequence, part: slice, folder: Path) -> Measured:
    """From the headers that its package installs."""
    program = _cpp("proxqp_peer.cpp", folder, [proxsuite_headers(), eigen()], TOLERANCE)
    return counted_peer(PROXQP, program, sequence, part)


def quadprog(sequence: Sequence, part: slice, folder: Path) -> Measured:
    """From the C of its sdist."""
    source = sdist("quadprog", folder.parent) / "quadprog"
    files = tuple(source / f"{name}.c" for name in ("solve.QP", "qr-update", "linear-algebra"))
    program = _built("quadprog_peer.c", folder, (), (), files)
    return counted_peer(QUADPROG, program, sequence, part)


@contextmanager
def _quiet() -> Iterator[None]:
    """Without what C++ writes to standard output."""
    sys.stdout.flush()
    kept, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)


def qpoases(sequence: Sequence, part: slice, folder: Path) -> Measured:
    """As CasADi's package has compiled it, through CasADi's C interface: its headers are not in
    that package."""
    place = casadi_folder()
    import casadi as ca

    n = sequence.variables
    folder.mkdir(parents=True, exist_ok=True)
    with _quiet():  # it greets
        solver = ca.conic(
            "solver", "qpoases",
            {"h": ca.Sparsity.dense(n, n), "a": ca.DM(sequence.rows).sparsity()},
            {"printLevel": "none", "hessian_type": "posdef"},
        )  # fmt: skip
        solver.save(str(folder / "solver.casadi"))
    extra = (f"-L{place}", f"-Wl,-rpath,{place}", "-lcasadi", "-Wl,--no-as-needed")
    program = _built("qpoases_peer.c", folder, (place / "include",), extra)
    return counted_peer(QPOASES, program, sequence, part, sized=False)


def tinympc(sequence: Sequence, part: slice, folder: Path) -> Measured:
    """The C++ that its code generator copies out, from its sdist, with its Eigen: below Python 3.13
    the package itself asks for SciPy below 1.12, which does not go with NumPy 2."""
    stated = sequence.stated
    if stated is None:
        raise PeerFailed(
            "cannot state it: wants boxes on states and inputs, and a last weight that follows "
            "from its penalty rho"
        )
    core = sdist("tinympc", folder.parent, TINYMPC_VERSION) / "tinympc" / "TinyMPC"
    sources = tuple(core / "src" / "tinympc" / f"{name}.cpp" for name in ("admm", "tiny_api"))
    others = (*sources, core / "src" / "tinympc" / "rho_benchmark.cpp")
    includes = [core / "src", core / "include" / "Eigen"]

    def measure(tolerance: float) -> Measured:
        program = _cpp(
            "tinympc_peer.cpp", folder, includes, tolerance, "-w",
            f"-DITERATIONS={TINYMPC_ITERATIONS}", others=others,
        )  # fmt: skip
        stated.write(program.parent / "stated", part, sequence.horizon)
        return counted_peer(TINYMPC, program, sequence, part)

    return reaching(measure, (1e-9, 1e-10))


def replaced_by(package: str) -> str:
    """What the installation of a package would replace here, "NumPy 2.4 by 1.26" and so on; empty
    where nothing, or why it cannot be told."""
    try:
        told = run(
            [sys.executable, "-m", "pip", "install", "--dry-run", "--quiet", "--report", "-",
             "--disable-pip-version-check", package],
            Path.cwd(),
        )  # fmt: skip
    except PeerFailed as why:
        return f"cannot be told: {why}"
    return ", ".join(replacements(told))


def replacements(report: str) -> list[str]:
    """Of a report of pip: packages that are here in another version."""
    found = []
    for each in json.loads(report)["install"]:
        name, version = each["metadata"]["name"], each["metadata"]["version"]
        try:
            here = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            continue
        if here != version:
            found.append(f"{name} {here} by {version}")
    return found
