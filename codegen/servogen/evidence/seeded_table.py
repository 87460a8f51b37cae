"""The tables of planted faults and checks, as a page of the docs: one of each project."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from servogen.evidence.bench import Bench
from servogen.evidence.seeded_faults import Fault

MARKS = {"caught": "**caught**", "missed": "missed"}

_HEAD = """\
# Planted faults

Made by `make seeded`; not to be edited. Of each project each row is one fault, planted in a copy of
its C, each column one check that was run on that copy. *caught*: the check failed, or refused the
file; *missed*: it ran and found nothing; anything else says why it was not run. The first three
columns need no more than gcc; `make test` asserts of every fault that one of them catches it, on a
small controller.

- `gcc -Werror`: the strict warning set at -O2.
- `sil`: the answers to edges, random calls and the closed loop, bit for bit those of the sound C,
  which are the reference's.
- `count of the head`: the worst case, counted from the text, is what the file's head states.
- the others: `servogen check NAME`, as it is shipped; sanitizers, pil and prove with fewer calls,
  fuzz for 20 s.

"""
_SECTION = """\
<!-- seeded:{name} -->

## `{name}`, {precision}

{first} of the {rows} are caught by one of the first three columns. The sound C has the digest
{digest}.
"""
_END = "<!-- seeded:end -->\n"
_SECTIONS = re.compile(r"<!-- seeded:(\w+) -->\n.*?" + _END, re.DOTALL)


@dataclass(frozen=True)
class Row:
    """``said``: title of a check -> caught, missed, or why it was not run."""

    fault: Fault
    said: Mapping[str, str]


def table_text(bench: Bench, rows: Sequence[Row]) -> str:
    """The section of a project; the same rows give the same bytes."""
    name = bench.subjects[0].package.name
    titles = list(rows[0].said)
    own = bench.subjects[0]
    first = sum("caught" in [row.said[title] for title in titles[:3]] for row in rows)
    head = _SECTION.format(
        name=name,
        precision=own.precision.name,
        digest=own.digest[:16],
        first="All" if first == len(rows) else first,
        rows=len(rows),
    )
    lines = [head]
    lines.append(f"| kind | fault | {' | '.join(titles)} |")
    lines.append("|---" * (2 + len(titles)) + "|")
    for row in rows:
        cells = [MARKS.get(row.said[t], row.said[t]) for t in titles]
        lines.append(f"| {row.fault.kind} | {row.fault.name} | {' | '.join(cells)} |")
    lines += ["", _tally(rows, titles), "", "### What was changed", ""]
    for row in rows:
        lines += _described(row.fault, name)
    return "\n".join([*lines, _END])


def page_text(page: str, section: str) -> str:
    """The page with a project's section in the place of the one that it had, or after the others;
    text outside of sections is made anew."""
    sections = {found[1]: found[0] for found in _SECTIONS.finditer(page + section)}
    return _HEAD + "\n".join(sections.values())


def _tally(rows: Sequence[Row], titles: Sequence[str]) -> str:
    told = []
    for title in titles:
        said = [row.said[title] for row in rows]
        if {"caught", "missed"} & set(said):
            told.append(f"{title} {said.count('caught')}")
    return f"Caught, of {len(rows)}: {', '.join(told)}."


def _described(fault: Fault, name: str) -> list[str]:
    def shown(text: str) -> str:
        named = text.replace("@p", name).replace("@P", name.upper())
        return " ".join(named.split())

    return [
        f"**{fault.kind}: {fault.name}** (`{shown(fault.file)}`): {fault.effect}.",
        "",
        "```c",
        f"{shown(fault.old)}   /* becomes */",
        f"{shown(fault.new)}",
        "```",
        "",
    ]
