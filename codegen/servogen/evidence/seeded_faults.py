"""Faults that are planted in copies of the emitted C, ten kinds, each as one change of its text.

``@p`` and ``@P`` stand for the package's prefix, small and in capitals. What is replaced must be in
the file exactly once: a template that has moved on makes the planting fail, and not the finding.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from servogen.emit.package import CPackage
from servogen.errors import CheckFailed


@dataclass(frozen=True)
class Fault:
    """One planted fault.

    Attributes:
        kind: one of ``KINDS``.
        file: name in the package; a runtime header, or a file that a template made.
        old, new: the text and what takes its place.
        effect: why the C behaves differently with it.
        silent: the answers of defined calls may all be the same; what is wrong is the way.
    """

    name: str
    kind: str
    file: str
    old: str
    new: str
    effect: str
    silent: bool = False


KINDS = (
    "index",
    "loop bound",
    "sign",
    "uninitialised",
    "division by zero",
    "wrong table",
    "wrong order",
    "dropped clamp",
    "wrong status",
    "state not reset",
)

FAULTS: tuple[Fault, ...] = (
    Fault(
        "a shift that copies in place", "index", "sg_kernels.h",
        "x[i] = x[i + 1];", "x[i] = x[i];",
        "horizons and plans lose one element at their end and keep the oldest",
    ),
    Fault(
        "duals shifted by one row too many", "index", "@p_mpc.c",
        "y[i] = y[i + @P_MPC_ROWS_PER_STEP];", "y[i] = y[i + @P_MPC_ROWS_PER_STEP + 1];",
        "the solver starts from the duals of other rows; no index leaves the array",
    ),
    Fault(
        "the point behind the last", "index", "@p_governor.c",
        "(eta == 0) ? 0 : (eta - 1)", "(eta == 0) ? 0 : eta",
        "each choice is judged by the point after it; with all points offered, one past the array",
    ),
    Fault(
        "a shift one element too long", "loop bound", "sg_kernels.h",
        "i < (n - 1)", "i < n",
        "reads one element past the array; that place is written again right after, so answers "
        "stay as they are", silent=True,
    ),
    Fault(
        "the last command left out", "loop bound", "@p_mpc.c",
        "for (int i = 0; i < @P_MPC_HORIZON; i++) {\n        self->plan[i] = sg_clamp(",
        "for (int i = 0; i < @P_MPC_HORIZON - 1; i++) {\n        self->plan[i] = sg_clamp(",
        "the plan ends in a command of an earlier program",
    ),
    Fault(
        "slack of the lower side", "sign", "sg_pqp.h",
        "const sg_real r_lower = slack_lower[i] - change[i];\n        if (r_upper",
        "const sg_real r_lower = slack_lower[i] + change[i];\n        if (r_upper",
        "violated lower bounds look kept and the other way round",
    ),
    Fault(
        "greatest reference of the governor", "sign", "@p_governor.c",
        "sg_min(axis->greatest, half - middle)", "sg_min(axis->greatest, half + middle)",
        "the set is mirrored on one side",
    ),
    Fault(
        "duality gap", "uninitialised", "sg_pqp.h",
        "sg_real gap = (sg_real)0;", "sg_real gap;",
        "the sum starts from whatever the register holds",
    ),
    Fault(
        "no choice found", "uninitialised", "@p_governor.c",
        "int32_t taken = -1;", "int32_t taken;",
        "where no choice is allowed, the answer is whatever the register holds",
    ),
    Fault(
        "denominator without the kept share", "division by zero", "sg_pqp.h",
        "(plus + keep_upper) + sg_max(slack_upper[i], zero)",
        "sg_max(slack_upper[i], zero)",
        "zero for every row whose slack is not positive",
    ),
    Fault(
        "rate by the samples done", "division by zero", "@p_follower.c",
        "const sg_real share = ((sg_real)self->done + (sg_real)0.5) * @p_follower_ramp_inverse;",
        "const sg_real share = (sg_real)1 / (sg_real)self->done;",
        "zero at the first fast sample of every interval",
    ),
    Fault(
        "an entry of the governor's table", "wrong table", "@p_governor_tables.h",
        "@p_governor_ahead_x[2] = {\n    ", "@p_governor_ahead_x[2] = {\n    1",
        "a digit too many in front: the predicted end of the interval is another",
    ),
    Fault(
        "an entry of the plant's table", "wrong table", "@p_mpc_tables.h",
        "@p_mpc_b[3] = {\n    ", "@p_mpc_b[3] = {\n    1",
        "a digit too many in front: the predicted state is another",
    ),
    Fault(
        "a constant of the iteration", "wrong table", "sg_pqp.h",
        "const sg_real half = (sg_real)0.5;", "const sg_real half = (sg_real)0.25;",
        "the splitting of the update is no longer that of the proof",
    ),
    Fault(
        "order of a sum", "wrong order", "sg_kernels.h",
        "+ (c1[i] * x1)) + (c2[i] * x2)) +", "+ (c2[i] * x2)) + (c1[i] * x1)) +",
        "equal on paper, other last digits",
    ),
    Fault(
        "the interval ends before it is passed", "wrong order", "@p_follower.c",
        "        self->head = @p_follower_wrap(self->head + self->current);\n"
        "        self->current = 0;\n",
        "        self->current = 0;\n"
        "        self->head = @p_follower_wrap(self->head + self->current);\n",
        "the ring's head stays where it is for ever",
    ),
    Fault(
        "multipliers without a floor", "dropped clamp", "sg_pqp.h",
        "sg_clamp(SG_DIVIDE(lower[i] * low_up, low_down), vanish[i], ceiling[i])",
        "SG_DIVIDE(lower[i] * low_up, low_down)",
        "a dual that has vanished never comes back",
    ),
    Fault(
        "the fast command unbounded", "dropped clamp", "@p_follower.c",
        "sg_clamp(reference - taken, -@p_follower_limit_x, @p_follower_limit_x)",
        "(reference - taken)",
        "commands beyond the fast stage's range",
    ),
    Fault(
        "the last reference as it comes", "dropped clamp", "@p_governor.c",
        "sg_clamp_any(in->last_x, -@p_governor_limit_x, @p_governor_limit_x)", "in->last_x",
        "a NaN that was refused is handed on all the same",
    ),
    Fault(
        "a bound that is there for the proof", "dropped clamp", "@p_follower.c",
        "sg_bound_below(self->along + @p_follower_rate(self), (sg_real)0)",
        "(self->along + @p_follower_rate(self))",
        "no machine that runs ever reaches it; without it no analysis of intervals can tell that "
        "the index stays in the ring", silent=True,
    ),
    Fault(
        "infinity out of range", "wrong status", "sg_kernels.h",
        "if (x > SG_REAL_MAX) {\n        status = SG_NOT_FINITE;",
        "if (x > SG_REAL_MAX) {\n        status = SG_OUT_OF_RANGE;",
        "the caller hears of a range where a number is no number",
    ),
    Fault(
        "a broken backup plan praised", "wrong status", "@p_mpc.c",
        "if (self->rows[i] > (self->above[i] + @p_mpc_margin)) {\n"
        "            status = SG_INFEASIBLE;",
        "if (self->rows[i] > (self->above[i] + @p_mpc_margin)) {\n"
        "            status = SG_BACKUP;",
        "a plan above its bounds is told to be feasible",
    ),
    Fault(
        "the measurement's status forgotten", "wrong status", "@p.c",
        "    status = sg_worse(status, measured);\n    if (self->priming > 0) {",
        "    if (self->priming > 0) {",
        "a measurement that could not be used is not told while the horizon is being filled",
    ),
    Fault(
        "the row of the last iterate", "state not reset", "sg_pqp.h",
        "    state->is_lower = 0;\n    sg_real gap", "    sg_real gap",
        "where the first row is the worst, the side is that of the iterate before",
    ),
    Fault(
        "an interval begun in its middle", "state not reset", "@p_follower.c",
        "        self->along = (sg_real)0;\n        @p_follower_plan_feed",
        "        @p_follower_plan_feed",
        "the first sample of an interval starts where the last one ended",
    ),
    Fault(
        "a queue that outlives init", "state not reset", "@p_follower.c",
        "    self->waiting = 0;\n    self->head = 0;", "    self->head = 0;",
        "after a reset intervals of the last path are waiting, after power-up any number",
    ),
)  # fmt: skip


def plant(fault: Fault, package: CPackage) -> CPackage:
    """The package with the fault in it; the original is left as it is.

    Raises:
        CheckFailed: the text is not there exactly once.
    """
    file, old, new = (_named(text, package) for text in (fault.file, fault.old, fault.new))
    text = package.files.get(file)
    found = 0 if text is None else text.count(old)
    if text is None or found != 1:
        raise CheckFailed(f"{fault.name}: {old!r} is {found} times in {file}, not once")
    planted = {**package.files, file: text.replace(old, new)}
    return replace(package, files=planted, hash=package.hash[::-1])


def _named(text: str, package: CPackage) -> str:
    return text.replace("@p", package.name).replace("@P", package.name.upper())
