"""The certificate as a page of the report: every check, what it found, with which tools."""

from __future__ import annotations

from servogen.evidence.certificate import FAILED, NOT_RUN, PASSED, Entry
from servogen.reports.data import Found
from servogen.reports.tables import BAD, GOOD, MUTED, Cell, Missing, Table, key_table, text

_KINDS = {PASSED: GOOD, FAILED: BAD}


def evidence_parts(data: Found) -> list[Table | Missing]:
    """One row per check; the faults of those that failed; which C it is all about."""
    certificate = data.certificate
    if certificate is None:
        return [Missing("No evidence has been gathered", f"servogen run {data.toml} -o OUT")]
    rows = tuple(_row(entry) for entry in certificate.entries)
    note = (
        "About the C whose digests stand below, in the precisions named. A check that was not run, "
        "ran on other C or from another input, counts for nothing. The input is named by its "
        "sha-256. Its date is the day when the newest of the project's files was modified, as the "
        "file system says: in a fresh copy, the day of copying."
    )
    columns = ("check", "result", "found", "precision", "tools", "input modified")
    parts: list[Table | Missing] = [
        Table(f"Certificate: {certificate.result}", columns, rows, note)
    ]
    faults = [(e.title, fault) for e in certificate.entries for fault in e.faults]
    if faults:
        told = tuple((text(title, "name"), Cell(fault, BAD)) for title, fault in faults)
        parts.append(Table("Faults", ("check", "fault"), told))
    details = [(e.title, line) for e in certificate.entries for line in e.details]
    if details:
        told = tuple((text(title, "name"), text(line.strip())) for title, line in details)
        parts.append(Table("Details", ("check", "found"), told, folded=True))
    parts.append(
        key_table(
            "What it is about",
            {
                "design": certificate.design_hash,
                "emitted in": certificate.precision,
                **{f"C, {p}, sha-256": digest for p, digest in certificate.digests.items()},
                "servogen": certificate.version,
                "input, sha-256": certificate.origin.digest,
                "input, last modified": certificate.origin.modified,
            },
        )
    )
    return parts


def _row(entry: Entry) -> tuple[Cell, ...]:
    told = entry.summary
    if entry.state == NOT_RUN:
        told = f"{told + ': ' if told else ''}servogen {entry.command}"
    tools = "; ".join(f"{name}: {version}" for name, version in entry.tools.items())
    return (
        text(entry.title, "name"),
        Cell(entry.state, _KINDS.get(entry.state, MUTED)),
        text(told),
        text(" and ".join(entry.precisions)),
        text(tools, MUTED),
        text(entry.input_modified),
    )
