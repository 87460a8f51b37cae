"""Paper 4's machine: from a project to its stages, sets, timed path, minimal motion and designs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

from servogen.controllers.command_governor_design import (
    CommandGovernorDesign,
    GovernorSettings,
    design_axis_governor,
    design_command_governor,
)
from servogen.controllers.command_governor_program import GovernorWeights
from servogen.controllers.errors import DesignError
from servogen.errors import InputError
from servogen.paths.timing import TimedPath
from servogen.plants.build import slow_plant
from servogen.plants.errors import PlantError
from servogen.plants.statespace import StateSpace
from servogen.precision import PRECISIONS, FloatArray, Precision
from servogen.project.governor_load import GovernorProject
from servogen.project.settings import centred_axis_limits, stage_settings
from servogen.sets.auxiliary import AuxiliaryDynamics, no_auxiliary, shift_register
from servogen.sets.errors import SetError
from servogen.sets.extended import ExtendedSet, extended_set
from servogen.systems.command_governor_faults import (
    check_pace,
    check_path,
    check_settling,
    part_fault,
)
from servogen.systems.command_governor_motion import slow_motion_of
from servogen.systems.judgement import timed_path

# Where the target decides, what the count starts from.
FIRST_CAP = 150


@dataclass(frozen=True)
class GovernorMachine:
    """What every design and every closed loop of a project starts from.

    Attributes:
        slow: both stages. sets: P-tilde of both, the same object for axes that are alike.
        timed: the pattern (7). motion: (J, 2) its minimal motion (19)-(20), m.
        cap: iterations of an axis in a period.
    """

    project: GovernorProject
    slow: tuple[StateSpace, StateSpace]
    sets: tuple[ExtendedSet, ExtendedSet]
    timed: TimedPath
    motion: FloatArray
    cap: int

    @property
    def points(self) -> FloatArray:
        """(J, 2) of the pattern, m."""
        return self.timed.points

    @property
    def reference(self) -> FloatArray:
        """(J, 2) what the project sends its slow stages to, m."""
        least = self.project.controller.motion.reference == "minimal_motion"
        return self.motion if least else self.points

    @property
    def ratio(self) -> int:
        """M."""
        return self.project.sampling.ratio

    @property
    def period_s(self) -> float:
        """T_s."""
        return self.project.sampling.slow_sample_time_s

    @property
    def alike(self) -> bool:
        """Whether one axis is built as the other."""
        return self.sets[0] is self.sets[1]

    @property
    def precision(self) -> Precision:
        return PRECISIONS[self.project.output.precision]

    @property
    def ideal_s(self) -> float:
        """What a machine of one fast stage that reaches everything would take."""
        return self.timed.duration_s

    @cached_property
    def plain_sets(self) -> tuple[ExtendedSet, ExtendedSet]:
        """The sets of one command held for ever, for governors without a register."""
        x, y = _sets(self.project, self.slow, no_auxiliary())
        return x, y


def governor_machine(project: GovernorProject) -> GovernorMachine:
    """Build and judge all parts of a project.

    Raises:
        InputError: a stage, a set, a program or a drawing that is none, each named; a drawing that
            the governor might not finish, by its first point at fault.
    """
    x, y = (_stage(project, name) for name in ("x", "y"))
    timed = timed_path(project)
    governor = project.controller.governor
    machine = GovernorMachine(
        project=project,
        slow=(x, y),
        sets=_sets(project, (x, y), shift_register(governor.horizon)),
        timed=timed,
        motion=slow_motion_of(project, timed.points),
        cap=FIRST_CAP
        if project.controller.solver.iteration_cap == "target"
        else int(project.controller.solver.iteration_cap),
    )
    design = governor_design(machine)
    check_settling(project, design)
    check_pace(project, design)
    check_path(machine, design)
    return machine


def governor_settings(machine: GovernorMachine) -> GovernorSettings:
    """The settings that the project file asks for."""
    controller = machine.project.controller
    governor, ahead = controller.governor, controller.governor.points_ahead
    return GovernorSettings(
        weights=GovernorWeights(governor.weight_auxiliary, governor.weight_reference),
        cap=machine.cap,
        margin=controller.solver.constraint_margin,
        sub_step_stroke=governor.sub_step_stroke,
        stroke_margin_m=governor.stroke_margin_m,
        after=governor.reference_index == "after",
        points_ahead=None if ahead == "all" else int(ahead),
    )


def governor_design(
    machine: GovernorMachine, precision: Precision | None = None
) -> CommandGovernorDesign:
    """Both axes; those that are alike share one set of tables.

    Raises:
        InputError: a program that cannot be made, or axes of different order.
    """
    project, target = machine.project, precision or machine.precision
    name, settings = project.name, governor_settings(machine)
    if machine.slow[0].order != machine.slow[1].order:
        raise project.error(
            "machine.y.slow",
            f"of order {machine.slow[1].order}",
            f"the order of machine.x.slow, {machine.slow[0].order}",
        )
    axes = []
    for key, slow, admissible in zip("xy", machine.slow, machine.sets, strict=True):
        prefix = f"{name}_axis" if machine.alike else f"{name}_{key}"
        try:
            axes.append(design_axis_governor(prefix, target, slow, admissible, settings))
        except (DesignError, SetError) as error:
            raise part_fault(project, key, slow, error) from error
        if machine.alike:
            axes.append(axes[0])
            break
    return design_command_governor(name, (axes[0], axes[1]), machine.ratio, settings)


def _stage(project: GovernorProject, name: str) -> StateSpace:
    axis = project.machine.x if name == "x" else project.machine.y
    try:
        return slow_plant(stage_settings(axis.slow))
    except PlantError as error:
        if axis.slow.model == "equal_poles":  # whose transfer function is not the user's
            pole = axis.slow.pole_rad_per_s
            key = f"machine.{name}.slow.pole_rad_per_s"
            raise project.error(key, pole, f"a stage with {error.expected}") from error
        value = None if error.value is None else str(error.value)
        key = f"machine.{name}.slow.{error.key}"
        raise InputError(project.file, key, value, error.expected) from error


def _sets(
    project: GovernorProject, slow: tuple[StateSpace, StateSpace], auxiliary: AuxiliaryDynamics
) -> tuple[ExtendedSet, ExtendedSet]:
    governor = project.controller.governor
    found: list[ExtendedSet] = []
    for (name, axis), stage in zip(project.machine.axes, slow, strict=True):
        if found and project.machine.y == project.machine.x:
            return found[0], found[0]
        limits, centre = centred_axis_limits(axis)
        try:
            found.append(
                extended_set(
                    stage, project.sampling.slow_sample_time_s, auxiliary, governor.sub_samples,
                    limits, centre, governor.steady_state_tightening,
                )
            )  # fmt: skip
        except SetError as error:
            raise part_fault(project, name, stage, error) from error
    return found[0], found[1]


def on_reference(machine: GovernorMachine, name: str) -> GovernorMachine:
    """The same machine, its slow stages sent to "minimal_motion" or to the "pattern"."""
    own = machine.project.controller
    motion = own.motion.model_copy(update={"reference": name})
    controller = own.model_copy(update={"motion": motion})
    return replace(machine, project=replace(machine.project, controller=controller))
