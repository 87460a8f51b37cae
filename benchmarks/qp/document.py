"""The tables of docs/benchmarks.md, from what the benchmarks wrote in JSON."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from qp.peers import COLUMNS, DAQP, STAGES
from qp.timed import BASE
from qp.unreached import UNREACHED

Told = Mapping[str, Any]
# Sequences whose tables are shown whole.
SHOWN = ("qp_mpc20b", "tight_0.02", "boxes_masses_10")
SIZED = ("qp_mpc20b", "two_stage_x_5", "two_stage_x_50", "masses_10", "servo_drive_3",
         "boxes_masses_10")  # fmt: skip
GROWTH = "two_stage_x_"
PART = "<!-- bench:{} -->"


class DocumentError(ValueError):
    """A document without the places that the tables belong to, or results of a part of a run."""


def rewritten(document: str, parts: Mapping[str, str]) -> str:
    """The document with what stands between ``<!-- bench:NAME -->`` and ``<!-- bench:end -->``.

    Raises:
        DocumentError: a part has no such place.
    """
    for name, text in parts.items():
        begin, end = re.escape(PART.format(name)), re.escape(PART.format("end"))
        place = re.compile(f"({begin}\n).*?({end})", re.DOTALL)
        if len(place.findall(document)) != 1:
            raise DocumentError(f"the document has not one place for {name}")
        document = place.sub(lambda found, own=text: f"{found[1]}\n{own}\n\n{found[2]}", document)
    return document


def qp_parts(told: Told) -> dict[str, str]:
    """By the names of their places."""
    sequences = [each for each in told["sequences"] if "missing" not in each]
    return {
        "versions": _versions(told),
        "sequences": _sequences(told["sequences"]),
        "shown": "\n\n".join(_whole(each) for each in sequences if each["name"] in SHOWN),
        "ratios": _ratios(sequences),
        "times": _times(sequences),
        "bytes": _bytes_table(sequences),
        "growth": _growth(sequences),
        "missing": _missing(told["sequences"]),
        "promises": promises(told),
        "reported": reported(told),
        "unreached": unreached(told),
    }


def table(heads: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    heads = list(heads)
    lines = [heads, ["---"] * len(heads), *(list(row) for row in rows)]
    return "\n".join(f"| {' | '.join(words)} |" for words in lines)


def promises(told: Told) -> str:
    """What was promised; what is only reported has a table of its own."""
    return table(
        ("promise", "at most", "found", ""),
        (
            (
                each["promise"], f"{each['limit']:g}", _found(each),
                "kept" if each["kept"] else "**broken**",
            )
            for each in told["promises"] if each.get("promised", True)
        ),
    )  # fmt: skip


def _found(promise: Told) -> str:
    return "not measured" if promise["found"] is None else f"{promise['found']:.4g}"


def reported(told: Told) -> str:
    """Of every sequence both forms' three numbers, those beyond their limits marked."""
    cells: dict[str, dict[str, list[str]]] = {}
    for each in told["promises"]:
        if each["sequence"]:
            found = "-" if each["found"] is None else f"{each['found']:.3f}"
            over = each["found"] is not None and not each["kept"]
            words = cells.setdefault(each["sequence"], {}).setdefault(each["solver"], [])
            words.append(f"**{found}**" if over else found)
    forms = (STAGES, COLUMNS)
    return table(
        ("sequence", *forms),
        (
            (f"`{name}`", *(", ".join(own[form]) if form in own else "-" for form in forms))
            for name, own in cells.items()
        ),
    )


def unreached(told: Told) -> str:
    """What the form that fits does not reach, whether promised or not, and why."""
    lines = []
    for each in told["promises"]:
        if each["sequence"] and each["fits"] and not each["kept"]:
            why = UNREACHED.get((each["sequence"], each["how"]))
            lines.append((
                f"`{each['sequence']}`", each["solver"].removeprefix("servogen, "), each["how"],
                f"{each['limit']:g}", _found(each), "yes" if each["promised"] else "no",
                "not looked into" if why is None else why.why,
            ))  # fmt: skip
    return table(("sequence", "form", "by DAQP's", "at most", "found", "promised", "why"), lines)


def _versions(told: Told) -> str:
    told_of = told["versions"]
    packages = ", ".join(
        f"{name} {version}"
        for name, version in told_of.items()
        if name not in ("python", "machine", "gcc", "valgrind")
    )
    minutes = told["seconds"] / 60.0
    return (
        f"{told_of['gcc']}; {told_of['machine']}, {told_of['valgrind']}; {packages}. "
        f"{_tinympc(told)}The run took {minutes:.0f} minutes. Instructions; microseconds where a "
        "library is timed."
    )


def _tinympc(told: Told) -> str:
    replaced = told["tinympc_would_replace"]
    if not replaced:
        return ""
    return f"TinyMPC's package would replace {replaced} here: its sources are compiled instead. "


def _sequences(sequences: Iterable[Told]) -> str:
    return table(
        ("sequence", "variables", "rows", "programs", "working sets", "from"),
        (
            (f"`{s['name']}`", "-", "-", "0", "-", f"**missing**: {s['missing']}")
            if "missing" in s
            else (
                f"`{s['name']}`", str(s["variables"]), str(s["rows"]), str(s["programs"]),
                f"to {s['active_max']}", s["source"],
            )
            for s in sequences
        ),
    )  # fmt: skip


def _cost(row: Told, key: str) -> str:
    return f"{row[key]:,.0f}" if row["unit"] == "instructions" else f"{1e6 * row[key]:.1f} us"


def _share(row: Told, key: str) -> str:
    return f"{row[key]:.3g}" if key in row else "-"


def _whole(s: Told) -> str:
    rows = []
    for name, row in s["solvers"].items():
        if "failed" in row:
            continue
        error = f"{row['error']:.0e}" + ("" if row["accurate"] else ", **missed**")
        count = str(row["programs"])
        count += f", {row['unsolved']} unsolved" if row["unsolved"] else ""
        by = f"{_share(row, 'median_by_daqp')}, {_share(row, 'max_by_daqp')}"
        spent = "-" if row["median_us"] is None else f"{row['median_us']:.1f} us"
        costs = (_cost(row, key) for key in ("median", "p99", "max"))
        rows.append((name, count, *costs, by, spent, _share(row, "time_by_daqp"), error))
    heads = ("solver", "programs", "median", "p99", "maximum", "median, maximum by DAQP's",
             "median time", "by DAQP's", "error")  # fmt: skip
    title = (
        f"**{s['name']}**: {s['variables']} variables, {s['rows']} rows, {s['programs']} programs, "
        f"working sets to {s['active_max']}; {s['source']}"
    )
    return f"{title}\n\n{table(heads, rows)}"


def _solvers(sequences: Iterable[Told], unit: str) -> list[str]:
    """Of a unit, in order; DAQP, to which the others are compared, left out."""
    found: dict[str, None] = {}
    for s in sequences:
        for name, row in s["solvers"].items():
            if row.get("unit") == unit and name not in (DAQP, BASE):
                found[name] = None
    return list(found)


def _flag(row: Told) -> str:
    return (" m" if not row["accurate"] else "") + (" u" if row["unsolved"] else "")


def _ratios(sequences: list[Told]) -> str:
    solvers = _solvers(sequences, "instructions")
    return table(
        ("sequence", "working sets", *solvers),
        (
            (
                s["name"], f"to {s['active_max']}",
                *(
                    f"{_share(row, 'median_by_daqp')}, {_share(row, 'max_by_daqp')}{_flag(row)}"
                    if "failed" not in (row := s["solvers"][name])
                    else "-"
                    for name in solvers
                ),
            )
            for s in sequences
        ),
    )  # fmt: skip


def _times(sequences: list[Told]) -> str:
    solvers = _solvers(sequences, "instructions")
    libraries = _solvers(sequences, "seconds")
    rows = []
    for s in sequences:
        base = s["solvers"].get(DAQP, {}).get("median_us")
        words = ["-" if base is None else f"{base:.2f} us"]
        words += [_share(s["solvers"][name], "time_by_daqp") for name in solvers]
        words += [_share(s["solvers"][name], "median_by_daqp") for name in libraries]
        rows.append((s["name"], *words))
    return table(("sequence", "DAQP", *solvers, *libraries), rows)


def _bytes_table(sequences: list[Told]) -> str:
    names: dict[str, None] = {}
    for s in sequences:
        names |= {n: None for n, r in s["solvers"].items() if r.get("unit") == "instructions"}
    return table(
        ("sequence", *names),
        ((s["name"], *(_size(s["solvers"][n]) for n in names))
         for s in sequences if s["name"] in SIZED),
    )  # fmt: skip


def _size(row: Told) -> str:
    if "failed" in row:
        return "-"
    if row["table_bytes"] < 0:
        return "not told"
    return f"{row['table_bytes']:,} + {row['workspace_bytes']:,}; {row['code_bytes']:,}"


def _growth(sequences: list[Told]) -> str:
    loops = [s for s in sequences if s["name"].startswith(GROWTH)]
    names = [n for n, r in loops[0]["solvers"].items() if r.get("unit") == "instructions"] \
        if loops else []  # fmt: skip
    rows = []
    for name in names:
        found = [s["solvers"][name] for s in loops]
        words = [
            "-" if "failed" in row else f"{row['median']:,.0f} / {row['max']:,.0f}" for row in found
        ]
        rows.append((name, *words, _powers(loops, name)))
    horizons = [str(s["variables"]) for s in loops]
    last = "power of the median, maximum, 20 to 50"
    return table(("solver", *horizons, last), rows)


def _powers(loops: list[Told], name: str) -> str:
    ends = [s for s in loops if s["variables"] in (20, 50) and "failed" not in s["solvers"][name]]
    if len(ends) != 2:
        return "-"
    few, many = ends
    over = np.log(many["variables"] / few["variables"])
    both = [
        np.log(many["solvers"][name][key] / few["solvers"][name][key]) / over
        for key in ("median", "max")
    ]
    return f"{both[0]:.1f}, {both[1]:.1f}"


def _missing(sequences: Iterable[Told]) -> str:
    """Who gave nothing, why, and where."""
    why: dict[tuple[str, str], list[str]] = {}
    whole = [s for s in sequences if "missing" not in s]
    for s in whole:
        for name, row in s["solvers"].items():
            if "failed" in row:
                why.setdefault((name, row["failed"]), []).append(s["name"])
    lines = []
    for (name, reason), where in why.items():
        places = "all" if len(where) == len(whole) else f"{len(where)}: {', '.join(where)}"
        lines.append((name, reason.removeprefix("not run: "), places))
    return table(("solver", "why it shows nothing", "sequences"), lines)


def lookup_parts(told: Told) -> dict[str, str]:
    """By the names of their places."""
    programs = told["programs"]
    names: dict[str, None] = {}
    for p in programs:
        names |= {name: None for name in p["contenders"]}
    shown = [n for n in names if any("failed" not in p["contenders"][n] for p in programs)]

    def cell(p: Told, name: str, words: str) -> str:
        row = p["contenders"][name]
        if "failed" in row:
            return "-"
        return words.format(**row) + ("" if row["accurate"] else " **missed**")

    heads = ("", *(p["name"] for p in programs))
    costs = [
        (n, *(cell(p, n, "{median:,.0f}, {p99:,.0f}, {max:,.0f}") for p in programs)) for n in shown
    ]
    bytes_ = [
        (n, *(cell(p, n, "{table_bytes:,} + {workspace_bytes:,}; {code_bytes:,}")
              for p in programs)) for n in shown
    ]  # fmt: skip
    largest = max(
        row["error"] for p in programs for row in p["contenders"].values() if "failed" not in row
    )
    notes = [
        (f"`{p['name']}`", p["source"], str(p["asked"]), p["contenders"][shown[0]].get("note", "-"),
         p["contenders"][SEQUENTIAL_NAME].get("note", "-"))
        for p in programs
    ]  # fmt: skip
    why: dict[tuple[str, str], list[str]] = {}
    for p in programs:
        for name, row in p["contenders"].items():
            if "failed" in row:
                why.setdefault((name, row["failed"]), []).append(p["name"])
    lines = [(name, reason, ", ".join(where)) for (name, reason), where in why.items()]
    return {
        "lookup-programs": table(
            ("program", "", "parameters asked for", "chosen form", "regions"), notes
        ),
        "lookup-costs": f"{table(heads, costs)}\n\nLargest error of anyone: {largest:.0e}.",
        "lookup-bytes": table(heads, bytes_),
        "lookup-missing": table(("contender", "why it shows nothing", "programs"), lines),
        "lookup-promises": promises(told),
    }


SEQUENTIAL_NAME = "sequential search"


def whole(told: Told, path: Path) -> Told:
    """What was read, if it is of a whole run.

    Raises:
        DocumentError: it is not.
    """
    if not told.get("whole"):
        raise DocumentError(f"{path} is of a part of the benchmark")
    return told
