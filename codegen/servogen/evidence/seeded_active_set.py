"""Faults of the dual active-set method, planted as those of ``seeded_faults`` are.

They take the place of the others in a package whose MPC is solved by it: the rest of its C is that
of a package with PQP.
"""

from __future__ import annotations

from servogen.evidence.seeded_faults import Fault

ACTIVE_SET_FAULTS: tuple[Fault, ...] = (
    Fault(
        "one row too few of the set moved on", "loop bound", "@p_mpc.c",
        "for (int32_t j = 0; j < (@P_MPC_KEEP - 1); j++) {",
        "for (int32_t j = 0; j < (@P_MPC_KEEP - 2); j++) {",
        "the last row of a small set is forgotten between two calls",
    ),
    Fault(
        "what a row at its lower bound misses", "sign", "@p_mpc.c",
        "(rows[row] - high[row]) : (low[row] - rows[row]);",
        "(rows[row] - high[row]) : (rows[row] - low[row]);",
        "its multiplier moves away from where the row holds",
    ),
    Fault(
        "rows that hold on opposite sides", "sign", "@p_mpc.c",
        "product[j] = (side == self->side[j]) ? -along : along;",
        "product[j] = (side == self->side[j]) ? along : -along;",
        "the factor is that of rows mirrored at zero; the pivots are the same",
    ),
    Fault(
        "which multiplier vanishes first", "sign", "@p_mpc.c",
        "} else if (here < share) {", "} else if (here > share) {",
        "the step goes past the others, whose multipliers turn negative and are cut off at zero",
    ),
    Fault(
        "no row enters at first", "uninitialised", "@p_mpc.c",
        "int32_t entering = -1;", "int32_t entering;",
        "where the register holds a row's number, it is appended without a look at the set kept",
    ),
    Fault(
        "a pivot that counts as rounding", "wrong table", "@p_mpc.c",
        "const sg_real least = (forced == 1) ? @p_mpc_rounding : @p_mpc_dependent;",
        "const sg_real least = (forced == 1) ? @p_mpc_rounding : (sg_real)1;",
        "only what is forced is ever appended: programs that have an optimum end without one",
    ),
    Fault(
        "what is missed before the set has moved on", "wrong order", "@p_mpc.c",
        "    @p_mpc_begin(self);\n    (void)@p_mpc_measure(self, rows, low, high);\n",
        "    (void)@p_mpc_measure(self, rows, low, high);\n    @p_mpc_begin(self);\n",
        "the first step is that of the last call's rows; the set that it leads to is another one",
    ),
    Fault(
        "an entry of the factor that is kept within", "dropped clamp", "@p_mpc.c",
        "under[j] = @p_mpc_within(product[j] * self->pivots[j]);",
        "under[j] = product[j] * self->pivots[j];",
        "no program of the suite reaches it; without it no analysis of intervals can tell that "
        "the next product is a number", silent=True,
    ),
    Fault(
        "every optimum praised at once", "wrong status", "@p_mpc.c",
        "                    if (least >= -@p_mpc_tolerance) {\n"
        "                        status = SG_OK;\n                    }\n",
        "                    (void)least;\n                    status = SG_OK;\n",
        "a row of the set that rounding has left inside its bound is never looked at again; a "
        "tracking program is scaled so that none is", silent=True,
    ),
    Fault(
        "the cap told as an optimum", "wrong status", "@p_mpc.c",
        "sg_status status = SG_BACKUP;\n    int32_t entering",
        "sg_status status = SG_OK;\n    int32_t entering",
        "the first iterate is taken",
    ),
    Fault(
        "lines beyond the set", "state not reset", "@p_mpc.c",
        "x[j + 1] = ((j + 1) < self->size) ? t1 : (sg_real)0;", "x[j + 1] = t1;",
        "lines of rows that have left take part in the multipliers of those that stay",
    ),
    Fault(
        "a set that contradicts", "state not reset", "@p_mpc.c",
        "(status == SG_OK) ? 0 : (lost + stalled);", "0;",
        "the program after one that no plan solves begins with rows that cannot hold together",
    ),
)  # fmt: skip
