"""What the options of the extended command governor buy and cost, on one machine and drawing.

Each setting is run on the minimal motion and on the pattern: what happens between the samples, what
a plan sees of the path, how much stroke the reference leaves, which reading of (21).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np

from servogen.controllers.command_governor_design import CommandGovernorDesign
from servogen.controllers.design import Declaration, Status, Value
from servogen.controllers.errors import DesignError
from servogen.errors import InputError
from servogen.paths.minimal_motion import pattern_motion
from servogen.paths.places import describe_point
from servogen.plants.statespace import StateSpace
from servogen.sets.auxiliary import shift_register
from servogen.sets.errors import SetError
from servogen.sets.extended import ExtendedSet, extended_set
from servogen.systems.closed_loop import Stalled
from servogen.systems.command_governor import GovernorMachine, governor_design, on_reference
from servogen.systems.command_governor_loop import (
    Ahead,
    GovernedRun,
    Governor,
    Unreachable,
    drawing_fault,
    run_governed,
)
from servogen.systems.command_governor_rows import GovernorRow, judge_governed, stopped_row

REFERENCES = {"minimal_motion": "minimal motion", "pattern": "pattern"}
# Instants of a period, as in the facts that the comparison is held against.
INSTANTS = (1, 2, 3, 5)
# By which a stage is faster in the worst case of (15), and the share of the stroke kept clear then.
FASTER, MARGIN_SHARE = 4.0, 0.01
# Points ahead in periods of M, and the reserve in multiples of the project's.
PERIODS_AHEAD, RESERVES = (1, 2, 4, 8), (1.0, 2.0, 4.0, 8.0)

Inside = Callable[[CommandGovernorDesign], AbstractContextManager[Governor]]


@dataclass(frozen=True)
class Setting:
    """A machine under the governor that its own project asks for.

    Attributes:
        build: the machine, whose sets may take seconds; None: the project's own.
        ahead: points of the path that a plan is shown; None: all that it can use.
    """

    label: str
    build: Callable[[], GovernorMachine] | None = None
    ahead: int | None = None

    @property
    def is_project(self) -> bool:
        """Whether nothing is changed."""
        return self.build is None and self.ahead is None


@dataclass(frozen=True)
class Trial:
    """A setting, run: a row for each of ``REFERENCES``.

    Attributes:
        stroke_m: of the fast stages; None where x and y differ.
        is_project: whether it is the project as its file has it.
    """

    label: str
    stroke_m: float | None
    rows: tuple[GovernorRow, ...]
    is_project: bool = False

    @property
    def told(self) -> str:
        """The label, with which one is the project's own."""
        return f"{self.label}, the project's" if self.is_project else self.label

    def over_stroke(self, row: GovernorRow) -> str:
        """What a row is beyond the stroke at the worst fast sample: mm, or where the strokes
        differ a share of it."""
        if self.stroke_m is None:
            return f"{100.0 * row.between.stroke:+.2f} %"
        return f"{1e3 * self.stroke_m * row.between.stroke:+.3f} mm"


@dataclass(frozen=True)
class Sweep:
    """Settings that differ in one thing."""

    title: str
    note: str
    trials: tuple[Trial, ...]


class Shortsighted:
    """A governor that is shown the next ``ahead`` points, as one with that window is."""

    def __init__(self, governor: Governor, ahead: int) -> None:
        self._governor, self._ahead = governor, ahead

    @property
    def declaration(self) -> Declaration:
        return self._governor.declaration

    def call(
        self, operation: str, inputs: Mapping[str, Value] | None = None
    ) -> tuple[Status, dict[str, Value]]:
        given = dict(inputs or {})
        if operation == "step":
            given["n_points"] = min(int(np.asarray(given["n_points"])), self._ahead)
        return self._governor.call(operation, given)


def run_machine(
    machine: GovernorMachine,
    design: CommandGovernorDesign,
    governor: Governor,
    periods: int | None = None,
    advance: Callable[[], None] | None = None,
    ahead: Ahead | None = None,
) -> GovernedRun:
    """A governor along the machine's path and reference.

    Args:
        ahead: makes the reference while the path is machined; None: it is the machine's.

    Raises:
        Stalled: it stands still, with the place where that is told.
    """
    reference = machine.reference if ahead is None else ahead
    try:
        return run_governed(
            design, machine.slow, machine.points, reference, governor, periods, advance
        )
    except Unreachable as stalled:
        place = describe_point(machine.timed, stalled.point)
        raise Stalled(f"UNREACHABLE: both stages stand, and {place} is out of reach") from stalled


def sweeps(machine: GovernorMachine) -> tuple[tuple[str, str, tuple[Setting, ...]], ...]:
    """Titles, notes and settings."""
    return (
        (
            "Between the samples",
            "Limits are kept at N instants of a period and the stroke at its ends: (15) says that "
            "the stage stays between its ends, and where it turns back it does not. Beyond the "
            "limit by, at the worst fast sample; negative: what was left.",
            tuple(_between(machine)),
        ),
        (
            "Points ahead",
            "How much of the path a plan is shown. With a few periods of it the pattern as "
            "reference is slower; the minimal motion hardly changes.",
            tuple(_ahead(machine)),
        ),
        (
            "Stroke reserve",
            "What the minimal motion leaves of the stroke, and why it is slower than the pattern: "
            "where it lies on the envelope, a stage at rest at the end of its plan has only that "
            "much more in reach, and the drawing goes on by so much a period. The pattern as "
            "reference leaves the whole stroke and does not change.",
            tuple(_reserve(machine)),
        ),
        (
            "Index of (21)",
            "The reference of a period is the first point after those machined in it, l + 1, or "
            "the first one of them, l.",
            tuple(_index(machine)),
        ),
    )


def run_setting(setting: Setting, machine: GovernorMachine, inside: Inside) -> Trial:
    """On both references; what cannot be made or does not finish is a row that says so."""
    strokes = {target.limits.fast_range_m for target in machine.sets}
    stroke = strokes.pop() if len(strokes) == 1 else None
    names = [f"{setting.label}, {told}" for told in REFERENCES.values()]
    try:
        built = machine if setting.build is None else setting.build()
        design = governor_design(built)
    except (InputError, DesignError, SetError) as error:
        none = tuple(stopped_row(name, machine, str(error), promised=False) for name in names)
        return Trial(setting.label, stroke, none)
    machines = [on_reference(built, key) for key in REFERENCES]
    with inside(design) as governor:
        seen = governor if setting.ahead is None else Shortsighted(governor, setting.ahead)
        rows = [_row(name, own, design, seen) for name, own in zip(names, machines, strict=True)]
    return Trial(setting.label, stroke, tuple(rows), setting.is_project)


def _row(
    name: str, machine: GovernorMachine, design: CommandGovernorDesign, governor: Governor
) -> GovernorRow:
    reserve = machine.project.controller.motion.stroke_reserve_m
    fault = drawing_fault(design, machine.points, machine.reference, reserve)
    if fault is not None:
        why = f"the drawing asks for {fault.expected}"
        return stopped_row(name, machine, why, promised=False)
    try:
        return judge_governed(name, machine, run_machine(machine, design, governor))
    except Stalled as stalled:
        return stopped_row(name, machine, str(stalled), promised=True)


def _between(machine: GovernorMachine) -> Iterator[Setting]:
    own = machine.project.controller.governor.sub_samples
    for subs in INSTANTS:
        changed = None if subs == own else partial(_instants, machine, subs)
        yield Setting(f"N = {subs}", changed)
    margin = MARGIN_SHARE * min(target.limits.fast_range_m for target in machine.sets)
    rows = {"sub_step_stroke": True}
    both = {**rows, "stroke_margin_m": margin}
    told = f"and a margin of {1e3 * margin:.3g} mm"
    yield Setting(f"N = {own}, stroke rows at the instants", partial(_governed, machine, rows))
    yield Setting(f"N = {own}, these {told}", partial(_governed, machine, both))
    quick, stage = cache(partial(_faster, machine)), f"stage {FASTER:g} times as fast"
    yield Setting(f"{stage}, N = {own}", quick)
    yield Setting(f"{stage}, stroke rows", lambda: _governed(quick(), rows))
    yield Setting(f"{stage}, these {told}", lambda: _governed(quick(), both))


def _ahead(machine: GovernorMachine) -> Iterator[Setting]:
    governor = machine.project.controller.governor
    most = (governor.horizon + 1) * machine.ratio + 1
    own = most if governor.points_ahead == "all" else min(most, governor.points_ahead)
    for periods in PERIODS_AHEAD:
        points = periods * machine.ratio + 1
        if points < own:
            yield Setting(f"{points} points", ahead=points)
    told = "all that a plan can use"
    if own < most:
        yield Setting(f"{own} points")
        yield Setting(
            f"{most} points, {told}", partial(_governed, machine, {"points_ahead": "all"})
        )
    else:
        yield Setting(f"{most} points, {told}")


def _reserve(machine: GovernorMachine) -> Iterator[Setting]:
    """Those that leave a tube on both axes."""
    reserve = machine.project.controller.motion.stroke_reserve_m
    margin = machine.project.controller.governor.stroke_margin_m
    least = min(target.limits.fast_range_m for target in machine.sets) - margin
    for times in RESERVES:
        own = times * reserve
        if own < least:
            changed = None if times == 1.0 else partial(_reserved, machine, own)
            yield Setting(f"{1e3 * own:.3g} mm", changed)


def _index(machine: GovernorMachine) -> Iterator[Setting]:
    own = machine.project.controller.governor.reference_index
    for key, label in (("after", "l + 1, the point after"), ("at", "l, the first of them")):
        changed = None if key == own else partial(_governed, machine, {"reference_index": key})
        yield Setting(label, changed)


def _governed(machine: GovernorMachine, changes: Mapping[str, object]) -> GovernorMachine:
    """The same machine with other keys of ``[controller.governor]``, and the motion for them."""
    own = machine.project.controller
    table = own.governor.model_copy(update=changes)
    controller = own.model_copy(update={"governor": table})
    changed = replace(machine, project=replace(machine.project, controller=controller))
    return replace(changed, motion=_motion(changed)) if "stroke_margin_m" in changes else changed


def _reserved(machine: GovernorMachine, reserve_m: float) -> GovernorMachine:
    own = machine.project.controller
    motion = own.motion.model_copy(update={"stroke_reserve_m": reserve_m})
    controller = own.model_copy(update={"motion": motion})
    changed = replace(machine, project=replace(machine.project, controller=controller))
    return replace(changed, motion=_motion(changed))


def _motion(machine: GovernorMachine) -> np.ndarray:
    own = machine.project.controller
    strokes = [s.limits.fast_range_m - own.governor.stroke_margin_m for s in machine.sets]
    return pattern_motion(machine.points, strokes, own.motion.stroke_reserve_m)


def _instants(machine: GovernorMachine, subs: int) -> GovernorMachine:
    changed = _governed(machine, {"sub_samples": subs})
    return replace(changed, sets=_sets(changed))


def _faster(machine: GovernorMachine) -> GovernorMachine:
    """Every pole ``FASTER`` times as far out, all limits as they are."""
    x = _sped_up(machine.slow[0])
    changed = replace(machine, slow=(x, x if machine.alike else _sped_up(machine.slow[1])))
    return replace(changed, sets=_sets(changed))


def _sped_up(stage: StateSpace) -> StateSpace:
    """x(c t) for x = (p, v, a, ...): each derivative is c times that of the one before."""
    scale = FASTER ** np.arange(stage.order)
    a = FASTER * stage.a * scale[:, None] / scale
    return StateSpace(a=a, b=FASTER * stage.b * scale, c=stage.c / scale)


def _sets(machine: GovernorMachine) -> tuple[ExtendedSet, ExtendedSet]:
    governor = machine.project.controller.governor
    found: list[ExtendedSet] = []
    for stage, target in zip(machine.slow, machine.sets, strict=True):
        if found and machine.alike:
            break
        found.append(
            extended_set(
                stage, machine.period_s, shift_register(governor.horizon), governor.sub_samples,
                target.limits, target.centre_m, target.tightening,
            )
        )  # fmt: skip
    return found[0], found[-1]
