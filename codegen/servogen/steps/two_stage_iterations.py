"""``servogen check iterations`` of a two-stage machine: a proof if there is one, else figures."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from servogen.controllers.design import Declaration, Status, Value
from servogen.controllers.mpc_design import MpcDesign
from servogen.controllers.mpc_iterations import LIMITED_STATES, mpc_program
from servogen.evidence.bench import Bench
from servogen.evidence.finding import Finding
from servogen.explicit.errors import ExplicitError
from servogen.explicit.iteration_certificate import IterationCertificate, certify_iterations
from servogen.precision import FloatArray, IntArray
from servogen.progress import Progress
from servogen.qp.active_set_tables import ActiveSetTables
from servogen.sil.build import built
from servogen.sil.compiled import CompiledController
from servogen.sil.harness import Call
from servogen.sil.random_calls import random_calls
from servogen.systems.closed_loop import Run, run_closed_loop
from servogen.systems.two_stage import Machine

CHECK = "iterations"
# What a certificate is tried for, by measurement: one sample takes a second, two take 20 s from a
# cold start and more than the budget from every set that a call can leave, three do not end.
LONGEST_HORIZON = 2
COLD_BUDGET = 40_000
WARM_BUDGET = 30_000
SEED = 20263
RANDOM_STEPS = 5_000
# Of the search for hard steps: beginnings, and changes tried from each.
BEGINNINGS, CHANGES = 20, 150
# What was measured is known by these names, the last two after the program's.
LOOP, RANDOM, SEARCH = "closed loop", "random states", "search"


@dataclass(frozen=True)
class Taken:
    """Iterations of many steps and how they ended, (steps,) each."""

    iterations: IntArray
    status: IntArray

    @property
    def most(self) -> int:
        return int(self.iterations.max(initial=0))

    @property
    def most_solved(self) -> int:
        """The most of a step that ended with the optimum."""
        return int(self.iterations[self.status == Status.OK].max(initial=0))

    def figures(self) -> dict[str, object]:
        """Plain JSON values; ``histogram`` counts steps by their number of iterations."""
        counts = np.bincount(self.iterations) if self.iterations.size else np.zeros(1, dtype=int)
        return {
            "steps": int(self.iterations.size),
            "none_needed": int(np.sum(self.iterations == 0)),
            "median": float(np.median(self.iterations)) if self.iterations.size else 0.0,
            "p99": float(np.percentile(self.iterations, 99)) if self.iterations.size else 0.0,
            "most": self.most,
            "most_solved": self.most_solved,
            "backup": int(np.sum(self.status == Status.BACKUP)),
            "infeasible": int(np.sum(self.status == Status.INFEASIBLE)),
            "histogram": {str(i): int(c) for i, c in enumerate(counts) if c},
        }


@dataclass(frozen=True)
class Program:
    """One MPC and what was proved about it: None where nothing was tried, ``why`` says why."""

    design: MpcDesign
    cold: IterationCertificate | None = None
    warm: IterationCertificate | None = None
    why: str = ""

    @property
    def proved(self) -> int | None:
        """The certified worst case of any sequence of calls."""
        return self.warm.bound if self.warm is not None and self.warm.exact else None

    def sentence(self) -> str:
        """What is proved, in words that cannot be taken for more."""
        if self.cold is None:
            return f"not certified: {self.why}"
        cold, warm = _told(self.cold, "from a cold start"), ""
        if self.warm is not None:
            warm = "; " + _told(self.warm, "after any other call")
        cap, bound = self.design.solver.cap, self.proved
        if bound is None:
            return f"not certified: {cold}{warm}"
        below = f"; the cap of {cap} is BELOW it, the backup acts there" if cap < bound else ""
        return f"certified: {cold}{warm}{below}"

    def figures(self) -> dict[str, object]:
        return {
            "certified": self.proved,
            "why_not": self.why,
            "cold": None if self.cold is None else _figures(self.cold),
            "warm": None if self.warm is None else _figures(self.warm),
        }


def iterations_finding(
    machine: Machine, designs: Sequence[MpcDesign], bench: Bench, progress: Progress
) -> Finding:
    """The worst case of every program, and what the emitted C took: in the closed loop, on random
    states, and at the end of a search for hard ones."""
    programs = [_certified(design, progress) for design in _different(designs)]
    package = bench.subjects[0].package
    with built(package) as module:
        with progress.task("Iterations of the closed loop"):
            run = run_closed_loop(machine, CompiledController(module, package.declarations[-1]))
        taken = {LOOP: _of_run(run)}
        for program in programs:
            own = next(d for d in package.declarations if d.prefix == program.design.prefix)
            with progress.task("Hard programs", BEGINNINGS) as task:
                steps = list(_random_steps(program.design))
                taken[f"{own.prefix}: {RANDOM}"] = _played(CompiledController(module, own), steps)
                found = _search(CompiledController(module, own), own, steps, task.advance)
            taken[f"{own.prefix}: {SEARCH}"] = found
    return _finding(programs, taken, bench)


def _finding(programs: Sequence[Program], taken: Mapping[str, Taken], bench: Bench) -> Finding:
    cap = programs[0].design.solver.cap
    programs, faults = _against(programs, taken)
    told = {p.design.prefix: p.sentence() for p in programs}
    figures = {name: own.figures() for name, own in taken.items()}
    loop = figures[LOOP]
    hardest = max(own.most_solved for own in taken.values())
    seen = (
        f"measured: at most {loop['most']} in the closed loop, backup on {loop['backup']} of "
        f"{loop['steps']} axis steps; {hardest} in the hardest solved program found; cap {cap}"
    )
    proved = [p.proved for p in programs]
    held = all(bound is not None and bound <= cap for bound in proved)
    return Finding(
        check=CHECK,
        passed=not faults,
        summary=f"{'; '.join(dict.fromkeys(told.values()))}; {seen}",
        tools={},
        subjects=bench.own_digest,
        figures={
            "cap": cap,
            "programs": {p.design.prefix: p.figures() for p in programs},
            "measured": figures,
        },
        details=tuple(
            f"{name}: {own['steps']} steps, {own['none_needed']} need none, median "
            f"{own['median']:g}, 99 % {own['p99']:g}, most {own['most']}, backup {own['backup']}, "
            f"infeasible {own['infeasible']}"
            for name, own in figures.items()
        ),
        faults=faults,
        measured=not held,
    )


def _against(
    programs: Sequence[Program], taken: Mapping[str, Taken]
) -> tuple[list[Program], tuple[str, ...]]:
    """The programs with their bounds taken back where a run took more, and a sentence for each.

    The closed loop runs all of them and does not say whose step it was: it is held against the
    largest bound, and only where all have one.
    """
    bounds = [program.proved for program in programs]
    largest = max((bound for bound in bounds if bound is not None), default=0)
    beyond = None not in bounds and taken[LOOP].most > largest
    judged, faults = list[Program](), list[str]()
    for program in programs:
        own = {n: run for n, run in taken.items() if n.startswith(f"{program.design.prefix}: ")}
        # every step of the search follows a reset
        resets = {name: run for name, run in own.items() if name.endswith(SEARCH)}
        cold = _held(program.cold, resets, " from a cold start", faults)
        loop = {LOOP: taken[LOOP]} if beyond else {}
        judged.append(replace(program, cold=cold, warm=_held(program.warm, own | loop, "", faults)))
    return judged, tuple(dict.fromkeys(faults))


def _held(
    found: IterationCertificate | None, runs: Mapping[str, Taken], when: str, faults: list[str]
) -> IterationCertificate | None:
    """What is left of a certificate after these runs; what breaks it goes to ``faults``."""
    if found is None or not found.exact:
        return found
    more = {name: run.most for name, run in runs.items() if run.most > found.bound}
    for name, most in more.items():
        faults.append(f"{name}: a step took {most} iterations; certified{when}: {found.bound}")
    return replace(found, refuted=max(more.values())) if more else found


def _told(found: IterationCertificate, when: str) -> str:
    if found.exact:
        return f"at most {found.bound} iterations {when}, attained ({found.pieces} pieces)"
    if found.finished and found.refuted:
        return f"{found.bound} {when} by {found.pieces} pieces, but {found.refuted} were taken"
    if found.finished and found.rounds:
        least = (
            f"accept {found.accept:.1e} is not above the {found.rounding:.1e} that rows round to"
        )
        return f"{found.bound} {when} by {found.pieces} pieces, but {least}"
    if found.finished:
        return f"at most {found.bound} {when}, {found.attained} seen ({found.pieces} pieces)"
    return f"{when} not finished after {found.pieces} pieces, {found.attained} iterations seen"


def _figures(found: IterationCertificate) -> dict[str, object]:
    return {
        "exact": found.exact,
        "finished": found.finished,
        "bound": found.bound,
        "attained": found.attained,
        "refuted": found.refuted,
        "rounding": found.rounding,
        "accept": found.accept,
        "rounding_may_cost_more": found.rounds,
        "pieces": found.pieces,
        "flat_pieces": found.flat,
        "starting_sets": found.starts,
        "left": found.left,
        "infeasible_pieces": found.infeasible,
        "pieces_by_iterations": list(found.by_iterations),
        "witness": [theta.tolist() for theta in found.witness],
    }


def _different(designs: Iterable[MpcDesign]) -> list[MpcDesign]:
    """Alike axes share one."""
    return list({design.prefix: design for design in designs}.values())


def _certified(design: MpcDesign, progress: Progress) -> Program:
    if not isinstance(design.solver, ActiveSetTables):
        return Program(design, why="PQP has no bound but its cap")
    if design.horizon > LONGEST_HORIZON:
        told = f"a horizon of {design.horizon}, beyond {LONGEST_HORIZON}, has too many pieces"
        return Program(design, why=told)
    program = mpc_program(design)
    if program is None:
        return Program(design, why=f"a state of more than {LIMITED_STATES} has no range")
    try:
        cold = certify_iterations(program, COLD_BUDGET, warm=False, progress=progress)
    except ExplicitError as error:
        return Program(design, why=str(error))
    if not cold.finished:
        return Program(design, cold)
    return Program(design, cold, certify_iterations(program, WARM_BUDGET, progress=progress))


def _of_run(run: Run) -> Taken:
    return Taken(run.iterations.ravel(), run.status_axis.ravel())


def _random_steps(design: MpcDesign) -> Iterator[Call]:
    """Resets and steps as ``servogen sil`` draws them: states in motion, at limits, or anywhere."""
    for call in random_calls(design, SEED, RANDOM_STEPS):
        if call.operation in ("reset", "step"):
            yield call


def _played(controller: CompiledController, calls: Sequence[Call]) -> Taken:
    """Steps in a row, each after what the last one left."""
    iterations, statuses = [], []
    for call in calls:
        status, out = controller.call(call.operation, call.inputs)
        if call.operation == "step":
            iterations.append(int(np.asarray(out["iterations"])))
            statuses.append(int(status))
    return Taken(np.array(iterations, dtype=np.int64), np.array(statuses, dtype=np.int64))


def _search(
    controller: CompiledController,
    declaration: Declaration,
    calls: Sequence[Call],
    advance: Callable[[], None],
) -> Taken:
    """From random steps uphill in iterations, each from a cold start: a change of the state, the
    references or the bounds stays if the program is solved and takes no fewer."""
    rng = np.random.default_rng(SEED)
    reach = {p.name: p.high for p in declaration.operation("step").inputs if p.high is not None}
    iterations, statuses = [], []

    def of(inputs: Mapping[str, Value]) -> int:
        controller.call("reset", {"position": inputs["position"]})
        status, out = controller.call("step", inputs)
        count = int(np.asarray(out["iterations"]))
        iterations.append(count)
        statuses.append(int(status))
        return count if status is Status.OK else -1

    steps = [call.inputs for call in calls if call.operation == "step"]
    scored = sorted(((of(own), i) for i, own in enumerate(steps[: 20 * BEGINNINGS])), reverse=True)
    for _, i in scored[:BEGINNINGS]:
        at, best = dict(steps[i]), of(steps[i])
        for _ in range(CHANGES):
            tried = _changed(rng, at, reach)
            count = of(tried)
            if count >= best:
                at, best = tried, count
        advance()
    return Taken(np.array(iterations, dtype=np.int64), np.array(statuses, dtype=np.int64))


def _changed(
    rng: np.random.Generator, inputs: Mapping[str, Value], reach: Mapping[str, float]
) -> dict[str, Value]:
    """One input, moved by a share of its range from a ten-thousandth to a tenth, within it."""
    name = str(rng.choice(sorted(inputs)))
    value = np.asarray(inputs[name], dtype=np.float64)
    most = reach[name]
    step = most * 10.0 ** rng.uniform(-4.0, -1.0) * rng.normal(size=value.shape)
    moved: FloatArray = np.clip(value + step, -most, most)
    return {**inputs, name: moved if value.ndim else float(moved)}
