"""cppcheck's MISRA addon, run so that what it did not look at cannot pass for clean.

- Every file that is checked is a copy that ends in a planted violation. Where that one is not
  reported, the addon did not run or did not come so far.
- The addon sees an included header's syntax tree, but the text only of files on the command line:
  the headers are given to it once more.
- Every rule has a text of its own. cppcheck drops a finding whose text, file and line equal
  another's, and without texts its addon says the same of every rule.
- A header that is not found, and whatever else cppcheck says that is not known to be harmless, is
  a fault.
"""

from __future__ import annotations

import json
import re
import sys
from collections import Counter
from collections.abc import Mapping, Set
from dataclasses import dataclass, field
from pathlib import Path
from subprocess import CompletedProcess
from tempfile import TemporaryDirectory

from servogen.emit.package import CPackage, included, signature
from servogen.evidence.misra_tool import Cppcheck
from servogen.evidence.tools import run_tool

# cppcheck knows the types of these headers itself and wants no text of them.
KNOWN_HEADERS = ("stdint.h",)
_HARMLESS = ("checkersReport", "normalCheckLevelMaxBranches", "unmatchedSuppression")
_COLUMNS = r"--template={file}\t{line}\t{id}\t{severity}\t{message}"
_CALLER = "servogen_caller.c"
_HEADERS = "servogen_headers.c"

_PLANTED = """
static int planted_{stem}(int x)
{{
    if (x) return 010;
    return x;
}}
"""
# Some rules are about the text of a file, some about its syntax tree: one of either kind.
_TEXT_RULES = frozenset({"7.1", "15.6"})
_SOURCE_RULES = _TEXT_RULES | {"15.5"}


@dataclass(frozen=True)
class Violation:
    """``rule`` is ``15.4``; ``text`` the line of C, without the white space around it."""

    rule: str
    file: str
    line: int
    text: str


@dataclass
class Report:
    """What one cppcheck says of one package.

    Attributes:
        violations: of MISRA rules, in the package's own lines.
        faults: why this run is no evidence, or what cppcheck itself calls an error or a warning.
        remarks: how often cppcheck gave advice on style of its own, by its name for it.
        files: the sources and headers that were checked.
        configurations: sets of macros that were taken as defined, the empty text for none.
    """

    violations: list[Violation] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)
    remarks: Counter[str] = field(default_factory=Counter)
    files: tuple[str, ...] = ()
    configurations: set[str] = field(default_factory=set)


def examine(package: CPackage, tool: Cppcheck, python: str = sys.executable) -> Report:
    """Check every source and header of the package.

    Args:
        python: the interpreter that runs the addon.
    """
    with TemporaryDirectory(prefix="servogen-misra-") as folder:
        return _Run(package, tool, python, Path(folder)).report


class _Run:
    """One package before one cppcheck, in a folder of its own."""

    def __init__(self, package: CPackage, tool: Cppcheck, python: str, folder: Path) -> None:
        self.package, self.tool, self.folder = package, tool, folder
        self.begins: dict[str, int] = {}
        self.texts = package.code
        self.report = Report(files=tuple(sorted(included(package.files, package.sources))))
        for name in sorted(set(self.texts) - set(self.report.files)):
            self._fault(f"no source includes {name}")
        self._write(self.texts)
        self._look_for_headers()
        self._compare_with_the_type_given()
        self.options = [_COLUMNS, "-j1", "--std=c99", f"--addon={_addon(folder, python)}"]
        self.options += ["--enable=warning,style,portability", *tool.levels]
        self._check_sources()
        self._check_headers()

    def _fault(self, text: str) -> None:
        self.report.faults.append(f"{self.tool.label}: {text}")

    def _write(self, texts: Mapping[str, str]) -> None:
        for name, text in texts.items():
            (self.folder / name).write_text(text, encoding="utf-8")

    def _cppcheck(self, *arguments: str) -> CompletedProcess[str]:
        return run_tool([self.tool.path, *arguments], self.folder)

    def _look_for_headers(self) -> None:
        options = ["-q", "--check-config", "--enable=missingInclude,information", "--std=c99"]
        done = self._cppcheck(*options, _COLUMNS, *self.package.sources)
        for line in sorted(set((done.stdout + done.stderr).splitlines())):
            missing = re.search(r'Include file: ([<"])([^>"]+)[>"] not found', line)
            if missing and missing[1] == "<" and missing[2] in KNOWN_HEADERS:
                continue
            if missing:
                self._fault(f"{missing[2]} is included and not found")
            elif line.strip() and not any(word in line for word in _HARMLESS):
                self._fault(_readable(line))

    def _compare_with_the_type_given(self) -> None:
        """The scalar's macro may come from the command line: the C after it is the same then."""
        name = f"{self.package.name.upper()}_REAL"
        given = f"-D{name}={self.package.declarations[0].precision.c_type}"
        for source in self.package.sources:
            plain, defined = (
                re.sub(r"^#.*\n|\s+", "", self._cppcheck("-q", "-E", d, source).stdout, flags=re.M)
                for d in ("-DSERVOGEN_PLAIN", given)
            )
            if plain != defined or not plain:
                self._fault(f"{source} is other C if {name} is defined")

    def _check_sources(self) -> None:
        """All rules, in every configuration; all at once, as some rules are about all of them."""
        planted = {source: _SOURCE_RULES for source in self.package.sources}
        self._write({f: self.texts[f] + _PLANTED.format(stem=Path(f).stem) for f in planted})
        self._write({_CALLER: _caller(self.package)})
        done = self._cppcheck(*self.options, "--max-configs=64", *planted, _CALLER)
        self.report.configurations |= _configurations(done.stdout)
        self._judge(done, planted, self.report.remarks)

    def _check_headers(self) -> None:
        """The rules about text, on the headers, one after the other where no compiler looks."""
        planted = {name: _TEXT_RULES for name in self.report.files if name.endswith(".h")}
        text = "#if 0\n"
        for name in planted:
            self.begins[name] = text.count("\n")
            text += self.texts[name] + _PLANTED.format(stem=Path(name).stem)
        self._write({_HEADERS: f"{text}#endif\nint servogen_headers(void);\n"})
        done = self._cppcheck(*self.options, _HEADERS)
        self._judge(done, planted, Counter(), without={"2.5"})  # no macro is used there

    def _place(self, file: str, line: int) -> tuple[str, int]:
        """Where a line really is that cppcheck saw in the headers' common file."""
        if file != _HEADERS or line == 0:
            return file, line
        name = max((n for n, b in self.begins.items() if b < line), key=self.begins.__getitem__)
        return name, line - self.begins[name]

    def _judge(
        self,
        done: CompletedProcess[str],
        planted: Mapping[str, Set[str]],
        remarks: Counter[str],
        without: Set[str] = frozenset(),
    ) -> None:
        """Sort what a run said; ``planted``: the rules that have to be reported in each file."""
        if done.returncode != 0:
            self._fault(f"ended with exit status {done.returncode}")
        seen: dict[str, set[str]] = {file: set() for file in planted}
        for line in filter(str.strip, done.stderr.splitlines()):
            parts = line.split("\t", 4)
            if len(parts) != 5 or not parts[1].isdigit():
                self._fault(line.strip())
                continue
            file, number = self._place(Path(parts[0]).name, int(parts[1]))
            name, severity = parts[2:4]
            lines = self.texts.get(file, "").splitlines()
            rule = re.fullmatch(r"misra-c2012-(\d+\.\d+)", name)
            if file in seen and number > len(lines):
                seen[file].add(rule[1] if rule else name)
            elif rule and file != _CALLER and rule[1] not in without:
                text = lines[number - 1].strip() if 0 < number <= len(lines) else ""
                self._add(Violation(rule[1], file, number, text))
            elif rule is None and severity in ("style", "performance"):
                remarks[name] += 1
            elif rule is None and name not in _HARMLESS:
                self._fault(_readable(line))
        for file, rules in planted.items():
            if not rules <= seen[file]:
                self._fault(f"{file} was not checked to its end")

    def _add(self, violation: Violation) -> None:
        if violation not in self.report.violations:
            self.report.violations.append(violation)


def _caller(package: CPackage) -> str:
    """A caller of every declared entry point: what 8.7 still tells of has no caller at all."""
    lines = [f'#include "{d.prefix}.h"' for d in package.declarations]
    for d in package.declarations:
        prototypes = [f"void {d.prefix}_init({d.prefix}_t *self)"]
        prototypes += [signature(d, operation) for operation in d.entries]
        for text in prototypes:
            head, _, arguments = text.removesuffix(")").partition("(")
            kind, _, name = head.partition(" ")
            values = ", ".join(re.findall(r"(\w+)(?:,|$)", arguments))
            call = f"{'' if kind == 'void' else 'return '}{name}({values});"
            lines.append(f"{kind} call_{name}({arguments});")
            lines.append(f"{kind} call_{name}({arguments})\n{{\n    {call}\n}}")
    return "\n".join(lines) + "\n"


def _addon(folder: Path, python: str) -> Path:
    """The addon's configuration, with texts of our own: MISRA's are not ours to give away."""
    rules = [f"Rule {c}.{r}\nNumber {c}.{r}" for c in range(1, 24) for r in range(1, 31)]
    texts, place = folder / "texts.txt", folder / "misra.json"
    texts.write_text("\n".join(["Appendix A Summary of guidelines", *rules, ""]), encoding="utf-8")
    arguments = [f"--rule-texts={texts}"]
    configuration = {"script": "misra.py", "args": arguments, "python": python}
    place.write_text(json.dumps(configuration), encoding="utf-8")
    return place


def _configurations(said: str) -> set[str]:
    """Sets of macros from ``Checking a.c: A;B=B...``; the empty text for none."""
    found = re.findall(r"^Checking [^\s:]+(?:: (.+?))? ?\.\.\.$", said, flags=re.M)
    return {", ".join(part.partition("=")[0] for part in text.split(";")) for text in found}


def _readable(line: str) -> str:
    parts = line.split("\t", 4)
    return f"{parts[0]}:{parts[1]}: {parts[4]} ({parts[2]})" if len(parts) == 5 else line.strip()
