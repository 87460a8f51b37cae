"""What was not run, or ran on other C, counts for nothing; what does not say it passed has not."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from servogen.evidence.certificate import (
    FAILED,
    MEASURED,
    NOT_APPLICABLE,
    NOT_RUN,
    PASSED,
    Certificate,
    Wanted,
    entry_of,
    strangers_in,
)
from servogen.evidence.finding import Finding, Origin, evidence_file, keep
from servogen.pipeline import RunResult

DIGESTS = {"float64": "a" * 64, "float32": "b" * 64}
BOTH = ("float64", "float32")
WANTED = Wanted("pil", "Processor in the loop", "check pil p.toml -o out", BOTH)
ORIGIN = Origin("d" * 64, "2026-01-02")
GOOD = Finding("pil", True, "all equal", {"qemu": "7.2"}, DIGESTS, {"calls": 5})


def state(out: Path) -> str:
    return entry_of(WANTED, out, DIGESTS, ORIGIN).state


def test_what_is_kept_is_shown_with_its_tools_and_date(tmp_path: Path) -> None:
    keep(GOOD, tmp_path, ORIGIN)
    entry = entry_of(WANTED, tmp_path, DIGESTS, ORIGIN)
    assert (entry.state, entry.summary, entry.input_modified) == (PASSED, "all equal", "2026-01-02")
    assert entry.tools == {"qemu": "7.2"}
    assert entry.figures == {"calls": 5}


def test_nothing_kept_is_not_run_and_names_the_command(tmp_path: Path) -> None:
    entry = entry_of(WANTED, tmp_path, DIGESTS, ORIGIN)
    assert (entry.state, entry.command) == (NOT_RUN, "check pil p.toml -o out")


@pytest.mark.parametrize(
    "subjects",
    [{}, {"float64": "a" * 64}, {"float64": "a" * 64, "float32": "c" * 64}],
    ids=["none", "one precision", "other C"],
)
def test_a_finding_about_other_c_is_no_evidence(tmp_path: Path, subjects: dict[str, str]) -> None:
    keep(replace(GOOD, subjects=subjects), tmp_path, ORIGIN)
    entry = entry_of(WANTED, tmp_path, DIGESTS, ORIGIN)
    assert entry.state == NOT_RUN
    assert "another build" in entry.summary
    assert not entry.figures


def test_what_was_measured_counts_neither_as_passed_nor_as_failed(tmp_path: Path) -> None:
    keep(replace(GOOD, measured=True), tmp_path, ORIGIN)
    assert state(tmp_path) == MEASURED
    entry = entry_of(WANTED, tmp_path, DIGESTS, ORIGIN)
    found = Certificate("p", "0", "h", "float64", DIGESTS, ORIGIN, (entry,))
    assert found.result == "incomplete"  # nothing passed
    assert found.lines()[0] == "evidence  incomplete: 1 measured"
    keep(replace(GOOD, measured=True, passed=False, faults=("no",)), tmp_path, ORIGIN)
    assert state(tmp_path) == FAILED


def test_a_finding_from_another_input_is_no_evidence(tmp_path: Path) -> None:
    """The C may be the same for another share, target or drawing."""
    keep(GOOD, tmp_path, Origin("e" * 64, "2026-01-02"))
    entry = entry_of(WANTED, tmp_path, DIGESTS, ORIGIN)
    assert entry.state == NOT_RUN
    assert "have changed" in entry.summary


def test_a_check_of_what_is_shipped_needs_that_precision_alone(tmp_path: Path) -> None:
    keep(replace(GOOD, subjects={"float64": "a" * 64}), tmp_path, ORIGIN)
    wanted = replace(WANTED, precisions=("float64",))
    entry = entry_of(wanted, tmp_path, DIGESTS, ORIGIN)
    assert (entry.state, entry.precisions) == (PASSED, ("float64",))
    assert entry_of(replace(WANTED, precisions=()), tmp_path, DIGESTS, ORIGIN).state == NOT_RUN


def test_failed_and_not_applicable(tmp_path: Path) -> None:
    keep(replace(GOOD, passed=False), tmp_path, ORIGIN)
    assert state(tmp_path) == FAILED
    keep(replace(GOOD, faults=("call 3 differs",)), tmp_path, ORIGIN)
    assert state(tmp_path) == FAILED
    keep(replace(GOOD, applies=False), tmp_path, ORIGIN)
    assert state(tmp_path) == NOT_APPLICABLE


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        '{"schema": "servogen.evidence/1", "check": "misra"}',
        '{"schema": "servogen.evidence/1", "check": "pil", "passed": true, "tools": [3]}',
        '{"schema": "servogen.evidence/1", "check": "pil", "passed": true, "faults": 3}',
        "[" * 100_000,
        "\xff",
    ],
)
def test_a_file_that_is_no_finding_is_not_run_and_stops_nothing(tmp_path: Path, text: str) -> None:
    file = evidence_file(tmp_path, "pil")
    file.parent.mkdir()
    file.write_bytes(text.encode("latin-1"))
    entry = entry_of(WANTED, tmp_path, DIGESTS, ORIGIN)
    assert (entry.state, entry.command) == (NOT_RUN, WANTED.command)
    assert entry.summary.startswith("evidence/pil.json cannot be read, expected ")
    whole = Certificate("p", "1", "e", "float64", DIGESTS, ORIGIN, (entry,))
    assert whole.result == "incomplete"
    assert "pil         not run   evidence/pil.json cannot be read" in whole.lines()[1]


def test_a_finding_that_does_not_say_passed_has_failed(tmp_path: Path) -> None:
    keep(GOOD, tmp_path, ORIGIN)
    file = evidence_file(tmp_path, "pil")
    data = json.loads(file.read_text())
    for value in (None, "true", 1):
        file.write_text(json.dumps(data | {"passed": value}))
        assert state(tmp_path) == FAILED


def certificate(*states: str) -> Certificate:
    made = entry_of(WANTED, Path("/nowhere"), DIGESTS, ORIGIN)
    entries = tuple(replace(made, state=s) for s in states)
    return Certificate("p", "0", "h", "float64", DIGESTS, ORIGIN, entries)


@pytest.mark.parametrize(
    ("states", "result"),
    [
        ((PASSED, PASSED), "passed"),
        ((PASSED, NOT_APPLICABLE), "passed"),
        ((PASSED, NOT_RUN), "incomplete"),
        ((NOT_APPLICABLE,), "incomplete"),
        ((), "incomplete"),
        ((PASSED, FAILED, NOT_RUN), "failed"),
    ],
)
def test_the_result_is_that_of_the_worst(states: tuple[str, ...], result: str) -> None:
    made = certificate(*states)
    assert made.result == result
    assert made.to_json()["result"] == result
    assert made.passed is (result != "failed")


def test_c_beside_it_that_is_not_the_build_s_is_named(tmp_path: Path) -> None:
    files = {"a.c": "int a;\n", "verify/b.c": "int b;\n"}
    assert strangers_in(files, tmp_path) == ()  # nothing is beside it
    for name, text in files.items():
        place = tmp_path / "c" / name
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(text)
    assert strangers_in(files, tmp_path) == ()
    (tmp_path / "c" / "a.c").write_text("int a\n;")
    (tmp_path / "c" / "more.c").write_text("")
    (tmp_path / "c" / "verify" / "b.c").unlink()
    assert strangers_in(files, tmp_path) == ("a.c", "more.c", "verify/b.c")
    whole = certificate(PASSED)
    assert whole.result == PASSED
    edited = replace(whole, strangers=("a.c",))
    assert edited.result == FAILED
    assert edited.lines()[-1].endswith("is not what this certificate is about: a.c")


def test_the_command_told_works_where_it_is_told(tmp_path: Path) -> None:
    missing = replace(certificate(NOT_RUN), arguments="a/b.toml -o out/b")
    assert missing.lines()[-1].endswith("servogen check pil a/b.toml -o out/b")


def test_what_was_left_out_stands_in_the_one_line(tmp_path: Path) -> None:
    left = ("clang: apt-get install clang", "gcc 32-bit, calls: no crt1.o", "clang: once more")
    keep(replace(GOOD, details=("a line",), not_run=left), tmp_path, ORIGIN)
    entry = entry_of(WANTED, tmp_path, DIGESTS, ORIGIN)
    assert entry.summary == "all equal; not run: clang; gcc 32-bit, calls"
    assert entry.details == ("a line", *(f"not run: {text}" for text in left))
    told = replace(certificate(), entries=(entry,)).lines()
    assert told[-1].endswith("passed    all equal; not run: clang; gcc 32-bit, calls")


def test_the_last_line_of_a_run_tells_what_was_only_measured(tmp_path: Path) -> None:
    keep(replace(GOOD, measured=True), tmp_path, ORIGIN)
    entry = entry_of(WANTED, tmp_path, DIGESTS, ORIGIN)
    found = Certificate("p", "0", "h", "float64", DIGESTS, ORIGIN, (entry,))
    told = RunResult({}, found).lines()[-1]
    assert told == "run       all checks passed; measured, not proved: pil"
