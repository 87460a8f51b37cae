"""What servogen promises of its active-set back end beside DAQP, and whether it holds; and what the
same limits say where nothing was promised."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from qp.counted import Measured
from qp.peers import COLUMNS, DAQP, STAGES
from qp.tolerance import ACCURACY
from qp.unreached import Unreached

BYTES = 0.5
# Median and maximum of the instructions by DAQP's: where few rows hold, and where nearly all can.
EASY, FULL = (0.20, 0.40), (0.25, 1.0)
HOWS = ("median", "maximum", "bytes")


@dataclass(frozen=True)
class Promise:
    """``found`` at most ``limit``; None: not measured, which breaks it.

    Attributes:
        promised: else only reported: no limit was promised there.
        known: of a broken one the most that the benchmark's page admits; None: it admits nothing.
        sequence, solver, how: what it is about, where that is one number of one sequence; ``fits``:
            of the form of the rows that fits the sequence.
    """

    told: str
    limit: float
    found: float | None
    promised: bool = True
    known: float | None = None
    sequence: str = ""
    solver: str = ""
    how: str = ""
    fits: bool = True

    @property
    def kept(self) -> bool:
        return self.found is not None and self.found <= self.limit

    @property
    def admitted(self) -> bool:
        """Not kept, but no worse than the page says."""
        worst = -np.inf if self.known is None else self.known
        return not self.kept and self.found is not None and self.found <= worst

    @property
    def verdict(self) -> str:
        if self.kept:
            return "kept" if self.promised else "holds"
        if not self.promised:
            return "does not hold"
        return "BROKEN, as the page says" if self.admitted else "BROKEN"

    def sentence(self) -> str:
        found = "not measured" if self.found is None else f"{self.found:.4g}"
        return f"{self.verdict}: {self.told}: {found}, at most {self.limit:g}"


def as_rows(made: Iterable[Promise]) -> list[dict[str, object]]:
    """For JSON."""
    return [
        {
            "promise": p.told, "limit": p.limit, "found": p.found, "kept": p.kept,
            "promised": p.promised, "admitted": p.admitted, "sequence": p.sequence,
            "solver": p.solver, "how": p.how, "fits": p.fits,
        }
        for p in made
    ]  # fmt: skip


def status(made: Sequence[Promise]) -> int:
    """0: all promises are kept; 1: one is broken or was not measured; 3: only such are broken as
    the page admits, and none is worse than it says. What is only reported changes nothing."""
    broken = [p for p in made if p.promised and not p.kept]
    if not broken:
        return 0
    return 3 if all(p.admitted for p in broken) else 1


Results = Mapping[str, Mapping[str, Measured]]


def _ratio(own: Measured | None, peer: Measured | None, how: str) -> float | None:
    if own is None or peer is None:
        return None
    if how == "bytes":
        if min(own.kept, own.written, peer.kept, peer.written) < 0:
            return None
        return (own.kept + own.written) / (peer.kept + peer.written)
    of = np.median if how == "median" else np.max
    return float(of(own.cost) / of(peer.cost))


def promises(
    results: Results, full: tuple[str, ...], unreached: Mapping[tuple[str, str], Unreached]
) -> list[Promise]:
    """Of every sequence that of both forms of the rows.

    Promised is what the form that fits does: rows of a plant where there is one, else columns. Of
    qp_mpc20b and the sequences ``full``, whose working sets reach 19 of 20 variables, that is
    instructions and bytes, of all others bytes. Columns beside a plant, which are told no more than
    DAQP, and instructions elsewhere are reported, at the same limits.

    Args:
        results: by sequence, by solver.
        unreached: by sequence and measure, of the form that fits.
    """
    made: list[Promise] = []
    measured = ("qp_mpc20b", *full)
    for name in dict.fromkeys((*measured, *results)):
        found = results.get(name, {})
        fits = STAGES if STAGES in found or name in measured else COLUMNS
        for solver in dict.fromkeys((fits, COLUMNS)):
            limits = (*(EASY if name == "qp_mpc20b" else FULL), BYTES)
            for how, limit in zip(HOWS, limits, strict=True):
                what = "bytes" if how == "bytes" else f"{how} of the instructions"
                told = f"{name}, {solver.removeprefix('servogen, ')}: {what} by DAQP's"
                ratio = _ratio(found.get(solver), found.get(DAQP), how)
                promised = solver == fits and (how == "bytes" or name in measured)
                admitted = unreached.get((name, how)) if promised else None
                known = None if admitted is None else admitted.at_most
                of = (name, solver, how, solver == fits)
                made.append(Promise(told, limit, ratio, promised, known, *of))
    return made + list(_answers(results))


def _answers(results: Results) -> Iterator[Promise]:
    for solver in (STAGES, COLUMNS):
        ours = [found[solver] for found in results.values() if solver in found]
        errors = [float(np.max(m.error)) for m in ours]
        unsolved = sum(int(np.sum(~m.solved)) for m in ours)
        told = f"{solver}: largest error of all sequences"
        yield Promise(told, ACCURACY, max(errors, default=None))
        yield Promise(f"{solver}: programs not solved", 0, unsolved if ours else None)
