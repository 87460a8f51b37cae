"""Paper 1's machine: from a judged project to the designs of its cascade."""

from __future__ import annotations

from dataclasses import dataclass, replace

from servogen.controllers.cascade_design import CascadeDesign
from servogen.controllers.fast_design import FastDesign, compensation
from servogen.controllers.governor_design import GovernorDesign, axis_section
from servogen.controllers.mpc_design import MpcDesign, SolverSettings, design_mpc
from servogen.paths.timing import TimedPath
from servogen.plants.errors import PlantError
from servogen.plants.statespace import StateSpace, discretise
from servogen.precision import PRECISIONS, Precision
from servogen.project import Project
from servogen.project.settings import axis_limits
from servogen.qp.condense import TrackingWeights
from servogen.qp.tolerances import MINIMUM_MARGIN
from servogen.sets.admissible import AdmissibleSet
from servogen.sets.constraints import AxisLimits
from servogen.systems.judgement import Plants, Sets

# The governor tests what the program will be asked to keep with bounds drawn in by one margin; it
# draws its own in by two, so that the plan it allows is feasible for the program too.
GOVERNOR_MARGINS = 2.0
# A third of the interval for each feed ramp leaves the middle third for making up.
RAMP_SHARE = 3

# The paper's cap: where the target decides, what the count starts from.
PAPER_CAP = 500


@dataclass(frozen=True)
class Tuning:
    """What may vary between designs of one machine: the rows of Table I.

    ``horizon`` 0: the governor alone.
    """

    horizon: int
    weights: TrackingWeights
    solver: SolverSettings
    mpc_inter_sample_rows: int = 0
    both_ends: bool = True


@dataclass(frozen=True)
class Machine:
    """A judged project: what every design of it starts from."""

    project: Project
    plants: Plants
    sets: Sets
    timed: TimedPath

    @property
    def slow(self) -> tuple[StateSpace, StateSpace]:
        return self.plants.x.slow, self.plants.y.slow

    @property
    def fast(self) -> tuple[StateSpace, StateSpace]:
        return self.plants.x.fast, self.plants.y.fast

    @property
    def limits(self) -> tuple[AxisLimits, AxisLimits]:
        return axis_limits(self.project.machine.x), axis_limits(self.project.machine.y)

    @property
    def slow_period_s(self) -> float:
        return self.project.sampling.slow_sample_time_s

    @property
    def fast_period_s(self) -> float:
        return self.project.sampling.fast_sample_time_s

    @property
    def ratio(self) -> int:
        return self.project.sampling.ratio

    @property
    def precision(self) -> Precision:
        return PRECISIONS[self.project.output.precision]


def project_tuning(project: Project) -> Tuning:
    """The tuning that the project file asks for."""
    mpc, solver = project.controller.mpc, project.controller.solver
    factor = 1.0 if mpc.terminal_weight == "lyapunov" else float(mpc.terminal_weight)
    cap = PAPER_CAP if solver.iteration_cap == "target" else int(solver.iteration_cap)
    return Tuning(
        horizon=mpc.horizon if project.controller.kind == "sprg_mpc" else 0,
        weights=TrackingWeights(
            mpc.weight_position,
            mpc.weight_velocity,
            mpc.weight_acceleration,
            mpc.weight_command,
            factor,
        ),
        solver=SolverSettings(
            cap=cap,
            phi=solver.phi,
            period=solver.acceleration_period,
            gap_tolerance=solver.gap_tolerance,
            margin=solver.constraint_margin,
            method=solver.method,
        ),
        mpc_inter_sample_rows=mpc.inter_sample_rows,
        both_ends=project.controller.governor.range_check == "both_ends",
    )


def with_cap(tuning: Tuning, cap: int) -> Tuning:
    """The same with another iteration cap."""
    return replace(tuning, solver=replace(tuning.solver, cap=cap))


def design_cascade(
    machine: Machine,
    tuning: Tuning,
    prefix: str | None = None,
    precision: Precision | None = None,
) -> CascadeDesign:
    """Design every controller of the cascade.

    Raises:
        InputError: axes of different order, or (23) for a fast stage that has zeros.
    """
    name = prefix or machine.project.name
    target = precision or machine.precision
    order = _common_order(machine)
    margin = max(tuning.solver.margin, MINIMUM_MARGIN[target.name])
    plants = [discretise(slow, machine.slow_period_s) for slow in machine.slow]
    sections = [
        axis_section(admissible, plant)
        for admissible, plant in zip((machine.sets.x, machine.sets.y), plants, strict=True)
    ]
    governor = GovernorDesign(
        prefix=f"{name}_governor",
        precision=target,
        points=machine.ratio,
        order=order,
        both_ends=tuning.both_ends,
        margin=GOVERNOR_MARGINS * margin,
        sample_time_s=machine.slow_period_s,
        limits=machine.limits,
        sections=(sections[0], sections[1]),
    )
    return CascadeDesign(
        prefix=name,
        governor=governor,
        mpc=_design_mpcs(machine, tuning, name, target) if tuning.horizon else None,
        fast=_design_fast(machine, tuning, name, target, order),
        plants=(plants[0], plants[1]),
    )


def _common_order(machine: Machine) -> int:
    orders = [slow.order for slow in machine.slow]
    if orders[0] != orders[1]:
        raise machine.project.error(
            "machine.y.slow",
            f"of order {orders[1]}",
            f"the order of machine.x.slow, {orders[0]}",
        )
    return orders[0]


def _design_mpcs(
    machine: Machine, tuning: Tuning, name: str, precision: Precision
) -> tuple[MpcDesign, MpcDesign]:
    def one(prefix: str, slow: StateSpace, limits: AxisLimits, own: AdmissibleSet) -> MpcDesign:
        return design_mpc(
            prefix,
            precision,
            slow,
            machine.slow_period_s,
            tuning.horizon,
            tuning.weights,
            limits,
            own,
            tuning.solver,
            tuning.mpc_inter_sample_rows,
        )

    # Alike axes share one set of tables: half the memory of the target.
    if machine.plants.y is machine.plants.x and machine.limits[0] == machine.limits[1]:
        both = one(f"{name}_mpc", machine.slow[0], machine.limits[0], machine.sets.x)
        return both, both
    return (
        one(f"{name}_mpc_x", machine.slow[0], machine.limits[0], machine.sets.x),
        one(f"{name}_mpc_y", machine.slow[1], machine.limits[1], machine.sets.y),
    )


def _design_fast(
    machine: Machine, tuning: Tuning, name: str, precision: Precision, order: int
) -> FastDesign:
    settings = machine.project.controller.fast
    axes = []
    for key, slow, fast in zip("xy", machine.slow, machine.fast, strict=True):
        try:
            axes.append(compensation(slow, fast, machine.fast_period_s, settings.matching))
        except PlantError as error:
            raise machine.project.error(
                f"controller.fast.{error.key}",
                f"{settings.matching} with machine.{key}.fast as it is",
                error.expected,
            ) from error
    return FastDesign(
        prefix=f"{name}_follower",
        precision=precision,
        points=machine.ratio,
        intervals=max(tuning.horizon, 1),
        ramp=machine.ratio // RAMP_SHARE if settings.feed_ramp else 0,
        order=order,
        sample_time_s=machine.fast_period_s,
        limits=machine.limits,
        axes=(axes[0], axes[1]),
    )
