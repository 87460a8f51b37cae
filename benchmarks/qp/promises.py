"""What servogen promises of its active-set back end beside DAQP, and whether it holds."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from qp.counted import Measured
from qp.peers import COLUMNS, DAQP, STAGES
from qp.tolerance import ACCURACY


@dataclass(frozen=True)
class Promise:
    """``found`` at most ``limit``; None: not measured, which breaks it."""

    told: str
    limit: float
    found: float | None

    @property
    def kept(self) -> bool:
        return self.found is not None and self.found <= self.limit

    def sentence(self) -> str:
        found = "not measured" if self.found is None else f"{self.found:.4g}"
        return (
            f"{'kept  ' if self.kept else 'BROKEN'}  {self.told}: {found}, at most {self.limit:g}"
        )


def as_rows(made: Iterable[Promise]) -> list[dict[str, object]]:
    """For JSON."""
    return [{"promise": p.told, "limit": p.limit, "found": p.found, "kept": p.kept} for p in made]


Results = Mapping[str, Mapping[str, Measured]]


def _ratio(own: Measured | None, peer: Measured | None, how: str) -> float | None:
    if own is None or peer is None:
        return None
    if how == "bytes":
        return (own.kept + own.written) / (peer.kept + peer.written)
    of = np.median if how == "median" else np.max
    return float(of(own.cost) / of(peer.cost))


def promises(results: Results, tight: tuple[str, ...]) -> list[Promise]:
    """``results``: by sequence, by solver."""
    limits = {"qp_mpc20b": (0.20, 0.40)} | {name: (0.25, 1.0) for name in tight}
    made = []
    for name, (median, largest) in limits.items():
        found = results.get(name, {})
        own, peer = found.get(STAGES), found.get(DAQP)
        for how, limit in (("median", median), ("maximum", largest)):
            told = f"{name}: {how} of the instructions by DAQP's"
            made.append(Promise(told, limit, _ratio(own, peer, how)))
    for name, found in results.items():
        if STAGES in found or name in limits:
            ratio = _ratio(found.get(STAGES), found.get(DAQP), "bytes")
            made.append(Promise(f"{name}: bytes by DAQP's", 0.5, ratio))
    for solver in (STAGES, COLUMNS):
        ours = [found[solver] for found in results.values() if solver in found]
        errors = [float(np.max(m.error)) for m in ours]
        unsolved = sum(int(np.sum(~m.solved)) for m in ours)
        made.append(
            Promise(
                f"{solver}: largest error of all sequences", ACCURACY, max(errors, default=None)
            )
        )
        made.append(Promise(f"{solver}: programs not solved", 0, unsolved if ours else None))
    return made
