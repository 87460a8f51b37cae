"""MISRA C:2012, as far as cppcheck's addon reads it, on every file of a package that is shipped."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from servogen.emit.package import CPackage
from servogen.evidence.bench import Bench
from servogen.evidence.finding import Finding
from servogen.evidence.misra_deviations import Entry, load, template_of
from servogen.evidence.misra_run import Report, Violation, examine
from servogen.evidence.misra_tool import REMEDY, find_cppchecks
from servogen.progress import Progress


def run(bench: Bench, progress: Progress) -> Finding:
    """Both precisions with every cppcheck there is.

    Raises:
        ToolMissing: there is none.
    """
    tools, entries = find_cppchecks(), load()
    faults: list[str] = []
    figures: dict[str, object] = {}
    covered, files = 0, 0
    work = [(subject, tool) for subject in bench.subjects for tool in tools]
    with progress.task("MISRA", len(work)) as task:
        for subject, tool in work:
            report = examine(subject.package, tool)
            more, figure = judge(report, subject.package, tool.version, entries)
            faults += [f"{subject.precision.name}: {text}" for text in more]
            figures[f"{subject.precision.name}, {tool.label}"] = figure
            covered += len(report.violations)
            files += len(report.files)
            task.advance()
    missing = {"system", "PyPI"} - {tool.origin for tool in tools}
    return Finding(
        check="misra",
        passed=not faults,
        summary=f"{files // len(work)} files, {' and '.join(t.version for t in tools)}: "
        f"{len(faults)} faults, {covered} findings covered by {len(entries)} declared deviations",
        tools={f"cppcheck ({tool.origin})": tool.version for tool in tools},
        subjects=bench.digests,
        figures=figures,
        faults=tuple(faults),
        not_run=tuple(f"cppcheck of {origin}: {REMEDY}" for origin in sorted(missing)),
    )


def judge(
    report: Report, package: CPackage, version: str, entries: Iterable[Entry]
) -> tuple[list[str], dict[str, object]]:
    """Hold a report against the list.

    Returns:
        The faults: what the run itself tells, violations that no entry covers, entries that cover
        nothing although the package has files they are about and the tool is one that reports it.
        And figures for the finding.
    """
    faults = list(dict.fromkeys(report.faults))
    if not report.files:
        faults.append("no file was checked")
    templates = {f: template_of(f, package.files[f]) for f in report.files}
    used: set[Entry] = set()
    for violation in sorted(report.violations, key=lambda v: (v.file, v.line, v.rule)):
        entry = _covering(entries, violation, templates.get(violation.file, violation.file))
        if entry is None:
            faults.append(
                f"rule {violation.rule}: {violation.file}:{violation.line}: {violation.text}"
            )
        else:
            used.add(entry)
    for entry in entries:
        concerned = entry.expected_of(version) and entry.concerns(list(templates.values()))
        if concerned and entry not in used:
            faults.append(f"the deviation from {entry.label} covers nothing in {package.name}")
    return faults, {
        "files": len(report.files),
        "configurations": sorted(report.configurations),
        "findings": dict(sorted(Counter(v.rule for v in report.violations).items())),
        "remarks": dict(sorted(report.remarks.items())),
    }


def _covering(entries: Iterable[Entry], violation: Violation, template: str) -> Entry | None:
    return next((e for e in entries if e.covers(violation, template)), None)
