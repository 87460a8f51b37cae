"""The checks there are, in the order of the certificate."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec

from servogen.errors import InputError
from servogen.evidence.bench import Bench
from servogen.evidence.finding import Finding
from servogen.progress import Progress

Run = Callable[[Bench, Progress], Finding]


@dataclass(frozen=True)
class Check:
    """One check. ``needs``: the packages of Debian or Ubuntu it wants, empty for none."""

    name: str
    title: str
    needs: tuple[str, ...] = ()

    def run(self, bench: Bench, progress: Progress) -> Finding:
        """Run it.

        Raises:
            ToolMissing: it cannot run here.
            InputError: this version does not have it yet.
        """
        if find_spec(f"servogen.evidence.{self.name}") is None:
            expected = "a check that this version has; this one is not written yet"
            raise InputError(None, "CHECK", self.name, expected)
        run: Run = import_module(f"servogen.evidence.{self.name}").run
        return run(bench, progress)


CHECKS: dict[str, Check] = {
    check.name: check
    for check in (
        Check("counts", "Static counts cover every run"),
        Check("compilers", "Compiler matrix"),
        Check("coverage", "Branches reached"),
        Check("sanitizers", "Kept corpus under sanitizers"),
        Check("misra", "MISRA C:2012", ("cppcheck",)),
        Check(
            "pil",
            "Processor in the loop",
            ("gcc-arm-none-eabi", "picolibc-arm-none-eabi", "qemu-system-arm"),
        ),
        Check("prove", "Absence of run-time errors", ("frama-c-base",)),
        Check("fuzz", "Fuzzing", ("clang", "libclang-rt-14-dev")),
        Check("dsp", "C6000 compile", ("gcc-12-source", "binutils-source")),
    )
}
