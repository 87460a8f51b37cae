"""What a system offers to the steps of the line; everything else about it they need not know.

One module per system implements ``System``; ``prepare.py`` chooses it by the project's type.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

from servogen.controllers.design import Declaration, Reference
from servogen.emit.package import CPackage
from servogen.evidence.bench import Bench
from servogen.evidence.certificate import Certificate
from servogen.evidence.finding import Finding
from servogen.precision import Precision
from servogen.progress import Progress
from servogen.project.systems import AnyProject
from servogen.sil.harness import Repeating
from servogen.sil.scenarios import Scenario
from servogen.systems.claims import Claim


class Result(Protocol):
    """What every step returns: a verdict, lines for people, JSON for programs."""

    @property
    def passed(self) -> bool: ...

    def lines(self) -> list[str]: ...

    def to_json(self) -> Mapping[str, object]: ...


class Simulation(Result, Protocol):
    """A judged closed loop; its first line says it all."""

    @property
    def faults(self) -> list[str]:
        """One sentence for each check that failed."""


@dataclass(frozen=True)
class LoopEnd:
    """How a closed loop ended: after so many periods, finished or not, with a sentence for every
    limit that its controller has to keep and did not. How well it tracks is no such limit."""

    periods: int
    complete: bool
    faults: tuple[str, ...] = ()

    @property
    def kept(self) -> bool:
        """Whether every limit was."""
        return not self.faults


@dataclass(frozen=True)
class ClosedLoop:
    """A controller around its plant.

    Attributes:
        name: for scenarios and plays, ``closed loop``.
        prefix: of the controller's declaration.
        steps: what its periods are called, ``slow periods``.
        total: periods of a whole run.
        reference: makes a fresh reference.
        run: runs a controller for so many periods or (None) to the end, telling each. Raises
            CheckFailed if it never comes to an end.
    """

    name: str
    prefix: str
    steps: str
    total: int
    reference: Callable[[], Reference]
    run: Callable[[Repeating, int | None, Callable[[], None]], LoopEnd]


@dataclass(frozen=True)
class Proof:
    """Claims about a design, and about the numbers in the C that is emitted for it.

    Attributes:
        name, title: on the certificate.
        prove: the claims, given the packages of every precision; none where ``absent`` says why
            there is nothing to claim.
        finding: in place of claims, what is found in a form of its own, about what is shipped.
    """

    name: str
    title: str
    prove: Callable[[Sequence[CPackage], Progress], Sequence[Claim]]
    absent: str = ""
    finding: Callable[[Bench, Progress], Finding] | None = None


Simulated = TypeVar("Simulated", bound=Simulation)
Studied = TypeVar("Studied", bound=Result)


@dataclass(frozen=True)
class Findings(Generic[Simulated, Studied]):
    """What the report is made of; what was not run is None and is shown as not run.

    ``build``, ``wcet``, ``sil``: the JSON of these verbs.
    """

    simulated: Simulated
    build: Mapping[str, Any]
    wcet: Mapping[str, Any] | None = None
    sil: Mapping[str, Any] | None = None
    study: Studied | None = None
    certificate: Certificate | None = None


class System(Protocol[Simulated, Studied]):
    """A judged project: its design, its closed loops, its proofs, its page of the report."""

    @property
    def project(self) -> AnyProject: ...

    @property
    def figures(self) -> Mapping[str, object]:
        """What the JSON of ``build`` says about the design."""

    @property
    def notes(self) -> Sequence[str]:
        """What a user should know before using the design, one sentence each."""

    @property
    def cheaper(self) -> str:
        """The keys that make a step cheaper, for who is over a target's budget."""

    @property
    def proofs(self) -> Sequence[Proof]:
        """In the order of the certificate."""

    def declarations(self, precision: Precision) -> tuple[Declaration, ...]:
        """Every controller, those used before those that use them."""

    def scenarios(self, precision: Precision, seed: int, count: int) -> Iterator[Scenario]:
        """Edges and ``count`` random steps for every controller."""

    def loops(self, precision: Precision) -> Sequence[ClosedLoop]:
        """The controllers that users call, each around its plant."""

    def simulate(self, package: CPackage | None, progress: Progress) -> Simulated:
        """The project's own task, with the C of ``package`` inside or (None) the references."""

    def study(self, progress: Progress) -> Studied:
        """The paper's comparison on this machine."""

    def page(self, found: Findings[Simulated, Studied]) -> str:
        """The report, one HTML file."""
