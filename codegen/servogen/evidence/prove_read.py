"""What Frama-C says about one run, read with suspicion: what is not understood is a fault."""

from __future__ import annotations

import csv
import io
import re
from collections import Counter
from dataclasses import dataclass

from servogen.controllers.design import Declaration

# A split by a variable that is not in scope yet: less precise until it is, never unsound.
_HARMLESS = ("this partitioning parameter cannot be evaluated safely on all states",)
_MESSAGE = re.compile(
    r"^\[(\S+)\] (?:\S+:\d+: )?(?:User )?(Warning|Error|Failure):[ \n]*(.*)", re.MULTILINE
)
_STATEMENTS = re.compile(r"^\s+(\w+): (\d+) stmts out of (\d+) \(", re.MULTILINE)
_REACHABLE = re.compile(r"Syntactically reachable functions = (\d+)")
_REACHED = re.compile(r"Semantically reached functions = (\d+)")
_PROVEN, _ASSUMED = "Valid", "Considered valid"
# The drawing functions: their contracts are the inputs, and stand in one file.
_EXTERNAL = re.compile(r"Frama_C_(?:nondet|interval|float_interval|double_interval)")


@dataclass(frozen=True)
class Proof:
    """What one run showed.

    Attributes:
        faults: nothing is proven unless there are none.
        alarms: kind -> how many; each is a fault too.
        proven: properties that Eva shows to hold, the driver's claims among them.
        functions: analysed; ``statements``: of these reached, and all.
        partly: functions with statements that are never reached, ``name reached/all``.
    """

    faults: tuple[str, ...]
    alarms: dict[str, int]
    proven: int
    functions: int
    statements: tuple[int, int]
    partly: tuple[str, ...]

    def to_json(self) -> dict[str, object]:
        return {
            "alarms": dict(self.alarms),
            "proven": self.proven,
            "functions": self.functions,
            "statements_reached": self.statements[0],
            "statements": self.statements[1],
            "partly_reached": list(self.partly),
        }


def read_proof(code: int, log: str, table: str, declaration: Declaration) -> Proof:
    """Judge a run.

    Args:
        code: Frama-C's exit status.
        log: all that it printed.
        table: its report of properties, tab-separated; empty if it wrote none.
    """
    rows = list(csv.DictReader(io.StringIO(table), delimiter="\t", quoting=csv.QUOTE_NONE))
    counted = [(n, int(a), int(b)) for n, a, b in _STATEMENTS.findall(log)]
    alarms = _alarms(rows)
    faults = [
        *_broken(code, log, rows),
        *(f"{row['file']}: takes on trust: {row['property']}" for row in _untrusted(rows)),
        *_unreached(log, counted, declaration),
        *(_described(row) for row in _open(rows)),
    ]
    return Proof(
        faults=tuple(faults),
        alarms=dict(sorted(alarms.items())),
        proven=sum(row["status"] == _PROVEN for row in rows),
        functions=len(counted),
        statements=(sum(a for _, a, _ in counted), sum(b for _, _, b in counted)),
        partly=tuple(sorted(f"{n} {a}/{b}" for n, a, b in counted if a < b)),
    )


def _broken(code: int, log: str, rows: list[dict[str, str]]) -> list[str]:
    """Everything that says that the analysis did not end as it should."""
    faults = []
    if code != 0:
        said = [line.strip() for line in log.splitlines() if "rror" in line or "abort" in line]
        faults.append(f"Frama-C ends with status {code}: {' / '.join(said[:3])}")
    if "ANALYSIS SUMMARY" not in log:
        faults.append("there is no summary of an analysis")
    if re.search(r"non[- ]terminating", log, re.I):
        faults.append("something in it never ends")
    if not rows:
        faults.append("there is no table of properties")
    for category, kind, text in _MESSAGE.findall(log):
        if category == "eva:alarm" or text.startswith(_HARMLESS):
            continue
        faults.append(f"{kind.lower()} of {category}: {text.strip()}")
    return list(dict.fromkeys(faults))


def _unreached(log: str, counted: list[tuple[str, int, int]], d: Declaration) -> list[str]:
    """Entry points that were not analysed, calls of the driver from which nothing comes back."""
    shares = {name: (a, b) for name, a, b in counted}
    wanted = [f"{d.prefix}_init", *(f"{d.prefix}_{op.name}" for op in d.entries)]
    faults = [f"{name} is not analysed" for name in wanted if shares.get(name, (0, 0))[0] == 0]
    for name in ("main", *(f"try_{op.name}" for op in d.entries)):
        reached, whole = shares.get(name, (0, 1))
        if reached < whole:
            faults.append(f"the driver's {name} is not followed to its end")
    reachable, reached_all = _REACHABLE.search(log), _REACHED.search(log)
    if reachable is None or reached_all is None:
        faults.append("there are no figures of coverage")
    elif reachable[1] != reached_all[1]:
        faults.append(f"{reached_all[1]} of {reachable[1]} functions that are called are reached")
    return faults


def _open(rows: list[dict[str, str]]) -> list[dict[str, str]]:
    """Properties that are neither shown nor part of the question."""
    return [row for row in rows if row["status"] not in (_PROVEN, _ASSUMED, "Dead")] + [
        row for row in rows if row["status"] == "Dead" and row["file"].endswith("_eva.c")
    ]


def _untrusted(rows: list[dict[str, str]]) -> list[dict[str, str]]:
    """What is assumed, in the package's files, beyond the drawing of inputs."""
    assumed = [row for row in rows if row["status"] == _ASSUMED and _is_own(row)]
    return [
        row
        for row in assumed
        if not (_EXTERNAL.fullmatch(row["function"]) and row["file"].endswith("_eva.h"))
    ]


def _is_own(row: dict[str, str]) -> bool:
    """False for Frama-C's own declarations of compiler builtins, which nothing calls."""
    return not row["directory"].startswith("FRAMAC_SHARE") and "<" not in row["file"]


def _alarms(rows: list[dict[str, str]]) -> Counter[str]:
    return Counter(row["property kind"] for row in _open(rows))


def _described(row: dict[str, str]) -> str:
    place = f"{row['file']}:{row['line']}, {row['function']}"
    return f"{place}: {row['property kind']} {row['status'].lower()}: {row['property']}"
