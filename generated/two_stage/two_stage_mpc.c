/* SPDX-License-Identifier: MIT */
/*
 * Made by servogen 0.1.0 from mpc.c.jinja; not to be edited.
 * Design 2df8fd9b7b96227c8a47a2bccc487b135ad72d7fa713a19599e6540c03996ab1.
 *
 * Tracking MPC (16) of one axis: condensed QP (19), PQP (20)-(21), Corollary 1
 *
 * Counted in this C, calls of other files included (servogen wcet): operations on two_stage_real, bytes
 * of C objects on the stack. Constant tables of this file: 21632 bytes.
 *
 * worst case of one call                       add    mul   div    cmp other   load  store stack
 * two_stage_mpc_init                             0      0     0      0     0      0    947    24
 * two_stage_mpc_reset                            0      0     0      5     0    128    150    48
 * two_stage_mpc_seed                             0      0     0      5     0     21     20    48
 * two_stage_mpc_candidate                      228    228     0     15     0    598    348   196
 * two_stage_mpc_step                        574391 484438 23622 168387 31731 926004 203205   572
 *   fixed part                                2255   1768     0    987   111   3816   1581
 *   each of 186 TWO_STAGE_MPC_ITERATION_CAP   3076   2595   127    900   170   4958   1084
 * two_stage_mpc_hold                            12     12     0     51    23    145     85   184
 */
#include "two_stage_mpc.h"
#include "two_stage_scalar.h"
#include "sg_pqp.h"
#include "two_stage_mpc_tables.h"

/* x+ = A x + B u (11); `next` must not be `state`. */
static void two_stage_mpc_advance(const sg_real *restrict state, sg_real command, sg_real *restrict next)
{
    sg_matvec(TWO_STAGE_MPC_ORDER, TWO_STAGE_MPC_ORDER, two_stage_mpc_a_columns, state, next);
    SG_PRAGMA("MUST_ITERATE(3, 3)")
    for (int i = 0; i < TWO_STAGE_MPC_ORDER; i++) {
        next[i] += two_stage_mpc_b[i] * command;
    }
}

/*
 * Take self->scratch_plan as the plan from `state` on. The state expected keeps to the declared range
 * of a measured one: a caller may go on without measurements for as long as she likes.
 */
static void two_stage_mpc_accept(two_stage_mpc_t *self, const sg_real *state)
{
    SG_PRAGMA("MUST_ITERATE(20, 20)")
    for (int i = 0; i < TWO_STAGE_MPC_HORIZON; i++) {
        self->plan[i] = sg_clamp(self->scratch_plan[i], -two_stage_mpc_command_limit, two_stage_mpc_command_limit);
    }
    two_stage_mpc_advance(state, self->plan[0], self->predicted);
    for (int i = 0; i < TWO_STAGE_MPC_ORDER; i++) {
        self->predicted[i] = sg_bound(self->predicted[i], -two_stage_mpc_bound[i], two_stage_mpc_bound[i]);
    }
}

/* Corollary 1: the last plan one step on, ending in the newest reference. */
static void two_stage_mpc_shift_plan(two_stage_mpc_t *self, sg_real reference)
{
    sg_copy(TWO_STAGE_MPC_HORIZON, self->plan, self->scratch_plan);
    sg_shift(TWO_STAGE_MPC_HORIZON, self->scratch_plan, reference);
}

/* A z and what the state at the start adds: the plant driven by z. */
static void two_stage_mpc_rows(const sg_real *restrict start, const sg_real *restrict z, sg_real *restrict rows)
{
    sg_real x0 = start[0];
    sg_real x1 = start[1];
    sg_real x2 = start[2];
    SG_PRAGMA("MUST_ITERATE(20, 20)")
    for (int32_t k = 0; k < TWO_STAGE_MPC_STEPS; k++) {
        const int32_t first = k * TWO_STAGE_MPC_ROWS_PER_STEP;
        const sg_real u0 = z[k];
        const sg_real y0 = (((two_stage_mpc_plant[0] * x0) +
            (two_stage_mpc_plant[1] * x1)) +
            (two_stage_mpc_plant[2] * x2)) +
            (two_stage_mpc_plant[3] * u0);
        const sg_real y1 = (((two_stage_mpc_plant[4] * x0) +
            (two_stage_mpc_plant[5] * x1)) +
            (two_stage_mpc_plant[6] * x2)) +
            (two_stage_mpc_plant[7] * u0);
        const sg_real y2 = (((two_stage_mpc_plant[8] * x0) +
            (two_stage_mpc_plant[9] * x1)) +
            (two_stage_mpc_plant[10] * x2)) +
            (two_stage_mpc_plant[11] * u0);
        const sg_real r0 = y0;
        rows[first] = r0;
        const sg_real r1 = y1;
        rows[first + 1] = r1;
        const sg_real r2 = y2;
        rows[first + 2] = r2;
        x0 = y0;
        x1 = y1;
        x2 = y2;
    }
    const sg_real last[TWO_STAGE_MPC_ORDER] = { x0, x1, x2 };
    sg_matvec(TWO_STAGE_MPC_TERMINAL_ROWS, TWO_STAGE_MPC_ORDER, two_stage_mpc_terminal_columns, last,
              &rows[TWO_STAGE_MPC_STEPS * TWO_STAGE_MPC_ROWS_PER_STEP]);
}

/* A'y: the plant run backwards, driven by what weighs on its outputs. */
static void two_stage_mpc_adjoint(const sg_real *restrict y, sg_real *restrict result)
{
    sg_real x0 = sg_dot(TWO_STAGE_MPC_TERMINAL_ROWS, &two_stage_mpc_terminal_columns[0],
                         &y[TWO_STAGE_MPC_STEPS * TWO_STAGE_MPC_ROWS_PER_STEP]);
    sg_real x1 = sg_dot(TWO_STAGE_MPC_TERMINAL_ROWS, &two_stage_mpc_terminal_columns[3],
                         &y[TWO_STAGE_MPC_STEPS * TWO_STAGE_MPC_ROWS_PER_STEP]);
    sg_real x2 = sg_dot(TWO_STAGE_MPC_TERMINAL_ROWS, &two_stage_mpc_terminal_columns[6],
                         &y[TWO_STAGE_MPC_STEPS * TWO_STAGE_MPC_ROWS_PER_STEP]);
    SG_PRAGMA("MUST_ITERATE(20, 20)")
    for (int32_t k = TWO_STAGE_MPC_STEPS - 1; k >= 0; k--) {
        const sg_real *const own = &y[k * TWO_STAGE_MPC_ROWS_PER_STEP];
        const sg_real w0 = x0 + own[0];
        const sg_real w1 = x1 + own[1];
        const sg_real w2 = x2 + own[2];
        x0 = ((two_stage_mpc_plant[0] * w0) +
            (two_stage_mpc_plant[4] * w1)) +
            (two_stage_mpc_plant[8] * w2);
        x1 = ((two_stage_mpc_plant[1] * w0) +
            (two_stage_mpc_plant[5] * w1)) +
            (two_stage_mpc_plant[9] * w2);
        x2 = ((two_stage_mpc_plant[2] * w0) +
            (two_stage_mpc_plant[6] * w1)) +
            (two_stage_mpc_plant[10] * w2);
        result[k] = ((two_stage_mpc_plant[3] * w0) +
            (two_stage_mpc_plant[7] * w1)) +
            (two_stage_mpc_plant[11] * w2);
    }
}

static void two_stage_mpc_cold_duals(two_stage_mpc_t *self)
{
    sg_copy(TWO_STAGE_MPC_ROWS, two_stage_mpc_floor, self->upper);
    sg_copy(TWO_STAGE_MPC_ROWS, two_stage_mpc_floor, self->lower);
}

/*
 * Duals of the last program one step on; the last step repeats, terminal rows keep theirs. The row that a
 * dual comes to may have a lower ceiling.
 */
static void two_stage_mpc_shift_duals(sg_real *y)
{
    SG_PRAGMA("MUST_ITERATE(57, 57)")
    for (int i = 0; i < (TWO_STAGE_MPC_ROWS - TWO_STAGE_MPC_TERMINAL_ROWS - TWO_STAGE_MPC_ROWS_PER_STEP); i++) {
        y[i] = y[i + TWO_STAGE_MPC_ROWS_PER_STEP];
    }
    SG_PRAGMA("MUST_ITERATE(63, 63)")
    for (int i = 0; i < TWO_STAGE_MPC_ROWS; i++) {
        y[i] = sg_clamp(y[i], two_stage_mpc_floor[i], two_stage_mpc_ceiling[i]);
    }
}

/* t = H^-1 A' (upper - lower), the correction of (21), and what it changes in the rows, A t. */
static void two_stage_mpc_correct(two_stage_mpc_t *self)
{
    sg_real at_rest[TWO_STAGE_MPC_ORDER];
    sg_real gradient[TWO_STAGE_MPC_VARIABLES];
    SG_PRAGMA("MUST_ITERATE(63, 63)")
    for (int i = 0; i < TWO_STAGE_MPC_ROWS; i++) {
        self->scratch[i] = self->upper[i] - self->lower[i];
    }
    two_stage_mpc_adjoint(self->scratch, gradient);
    sg_matvec(TWO_STAGE_MPC_VARIABLES, TWO_STAGE_MPC_VARIABLES, two_stage_mpc_inverse, gradient, self->correction);
    sg_fill(TWO_STAGE_MPC_ORDER, (sg_real)0, at_rest);
    two_stage_mpc_rows(at_rest, self->correction, self->change);
}

/* One turn of (20). */
static void two_stage_mpc_multiply(two_stage_mpc_t *self)
{
    sg_pqp_majorant(TWO_STAGE_MPC_ROWS, TWO_STAGE_MPC_ROWS_PER_STEP, TWO_STAGE_MPC_BLOCKS, TWO_STAGE_MPC_LINES, TWO_STAGE_MPC_STRIDE,
                    two_stage_mpc_columns, two_stage_mpc_at_floor, two_stage_mpc_floor, two_stage_mpc_root_diagonal, self->upper,
                    self->lower, self->scratch, self->shared, self->absolute_sum);
    sg_pqp_multiply(TWO_STAGE_MPC_ROWS, self->absolute_sum, two_stage_mpc_phi_diagonal, two_stage_mpc_vanish,
                    two_stage_mpc_ceiling, self->slack_upper, self->slack_lower, self->change,
                    self->upper, self->lower, self->last_upper, self->last_lower,
                    self->last_change);
}


/* Bounds of the rows, relative to the position, drawn in by the margin. */
static void two_stage_mpc_bounds(two_stage_mpc_t *self, sg_real origin, const two_stage_mpc_step_in *in)
{
    sg_fill(TWO_STAGE_MPC_ROWS, (sg_real)1 - two_stage_mpc_margin, self->above);
    sg_fill(TWO_STAGE_MPC_ROWS, -((sg_real)1 - two_stage_mpc_margin), self->below);
    SG_PRAGMA("MUST_ITERATE(20, 20)")
    for (int k = 0; k < TWO_STAGE_MPC_HORIZON; k++) {
        self->above[k * TWO_STAGE_MPC_ROWS_PER_STEP] =
            ((in->high[k] - origin) * two_stage_mpc_position_scale) - two_stage_mpc_margin;
        self->below[k * TWO_STAGE_MPC_ROWS_PER_STEP] =
            ((in->low[k] - origin) * two_stage_mpc_position_scale) + two_stage_mpc_margin;
    }
    const int first = TWO_STAGE_MPC_ROWS - TWO_STAGE_MPC_TERMINAL_ROWS;
    const sg_real last = self->relative[TWO_STAGE_MPC_HORIZON];
    SG_PRAGMA("MUST_ITERATE(3, 3)")
    for (int i = 0; i < TWO_STAGE_MPC_TERMINAL_ROWS; i++) {
        const sg_real centre =
            (two_stage_mpc_terminal_reference[i] * last) + (two_stage_mpc_terminal_position[i] * origin);
        self->above[first + i] = (two_stage_mpc_terminal_bound[i] - centre) - two_stage_mpc_margin;
        self->below[first + i] = (-two_stage_mpc_terminal_bound[i] - centre) + two_stage_mpc_margin;
    }
}

/* The shifted plan in self->scratch_plan, held to the true bounds from the measured state. */
static sg_status two_stage_mpc_judge(two_stage_mpc_t *self, sg_real origin)
{
    sg_status status = SG_BACKUP;
    SG_PRAGMA("MUST_ITERATE(20, 20)")
    for (int i = 0; i < TWO_STAGE_MPC_HORIZON; i++) {
        self->correction[i] = self->scratch_plan[i] - origin;
    }
    two_stage_mpc_rows(self->start, self->correction, self->rows);
    SG_PRAGMA("MUST_ITERATE(63, 63)")
    for (int i = 0; i < TWO_STAGE_MPC_ROWS; i++) {
        if (self->rows[i] > (self->above[i] + two_stage_mpc_margin)) {
            status = SG_INFEASIBLE;
        }
        if (self->rows[i] < (self->below[i] - two_stage_mpc_margin)) {
            status = SG_INFEASIBLE;
        }
    }
    return status;
}

/* Iterate (20) from the shifted duals; the number of iterates goes to `iterations`. */
static sg_status two_stage_mpc_solve(two_stage_mpc_t *self, int32_t *iterations)
{
    sg_status status = SG_BACKUP;
    sg_pqp_state seen = { (sg_real)0, (sg_real)0, 0, 0 };
    int32_t turn = 0;
    two_stage_mpc_shift_duals(self->upper);
    two_stage_mpc_shift_duals(self->lower);
    SG_PRAGMA("MUST_ITERATE(1, 186)")
    for (int k = 0; k < TWO_STAGE_MPC_ITERATION_CAP; k++) {
        two_stage_mpc_correct(self);
        sg_pqp_evaluate(TWO_STAGE_MPC_ROWS, self->upper, self->lower, self->slack_upper, self->slack_lower,
                        self->change, &seen);
        *iterations = k + 1;
        status = (seen.worst >= -two_stage_mpc_tolerance) ? SG_SUBOPTIMAL : SG_BACKUP;
        if (status == SG_SUBOPTIMAL) {
            status = (seen.gap <= two_stage_mpc_gap_limit) ? SG_OK : SG_SUBOPTIMAL;
        }
        int32_t stop = (status == SG_OK) ? 1 : 0;
        if (k == (TWO_STAGE_MPC_ITERATION_CAP - 1)) {
            stop = 1; /* the duals of the last iterate stay as they are */
        }
        if (stop == 1) {
            break;
        }
        int32_t kind = 0;
        if (turn == 0) {
            kind = (status == SG_BACKUP) ? 1 : 0;
        }
        kind = (turn == (TWO_STAGE_MPC_PERIOD - 1)) ? 2 : kind;
        if (kind == 1) {
            /*@ split seen.row; */
            sg_pqp_coordinate(two_stage_mpc_inverse_diagonal, two_stage_mpc_vanish, two_stage_mpc_ceiling, &seen, self->upper,
                              self->lower);
        } else if (kind == 2) {
            sg_pqp_extrapolate(TWO_STAGE_MPC_ROWS, two_stage_mpc_diagonal, two_stage_mpc_vanish, two_stage_mpc_ceiling,
                               two_stage_mpc_clamp, two_stage_mpc_room, two_stage_mpc_weight, two_stage_mpc_least_step,
                               two_stage_mpc_least_curvature, two_stage_mpc_longest, self->slack_upper,
                               self->slack_lower, self->change, self->upper, self->lower,
                               self->last_upper, self->last_lower, self->last_change);
        } else {
            two_stage_mpc_multiply(self);
        }
        /*@ merge seen.row; */
        turn = (turn == (TWO_STAGE_MPC_PERIOD - 1)) ? 0 : (turn + 1);
    }
    return status;
}

/* The unconstrained optimum in self->free_plan, its slacks, and whether all bounds hold there. */
static int32_t two_stage_mpc_unconstrained(two_stage_mpc_t *self, sg_real origin, const sg_real *rest,
                                     const two_stage_mpc_step_in *in)
{
    int32_t inside = 1;
    SG_PRAGMA("MUST_ITERATE(21, 21)")
    for (int i = 0; i < TWO_STAGE_MPC_REFERENCES; i++) {
        self->relative[i] = in->reference[i] - origin;
    }
    sg_matvec(TWO_STAGE_MPC_HORIZON, TWO_STAGE_MPC_ORDER - 1, two_stage_mpc_plan_state, rest, self->free_plan);
    sg_matvec(TWO_STAGE_MPC_HORIZON, TWO_STAGE_MPC_REFERENCES, two_stage_mpc_plan_reference, self->relative,
              self->correction);
    sg_add(TWO_STAGE_MPC_HORIZON, self->correction, self->free_plan);
    self->start[0] = (sg_real)0;
    SG_PRAGMA("MUST_ITERATE(2, 2)")
    for (int i = 1; i < TWO_STAGE_MPC_ORDER; i++) {
        self->start[i] = rest[i - 1] * two_stage_mpc_start_scale[i];
    }
    two_stage_mpc_bounds(self, origin, in);
    two_stage_mpc_rows(self->start, self->free_plan, self->rows);
    SG_PRAGMA("MUST_ITERATE(63, 63)")
    for (int i = 0; i < TWO_STAGE_MPC_ROWS; i++) {
        self->slack_upper[i] = self->above[i] - self->rows[i];
        self->slack_lower[i] = self->rows[i] - self->below[i];
        if (self->slack_upper[i] < (sg_real)0) {
            inside = 0;
        }
        if (self->slack_lower[i] < (sg_real)0) {
            inside = 0;
        }
    }
    return inside;
}

void two_stage_mpc_init(two_stage_mpc_t *self)
{
    sg_fill(TWO_STAGE_MPC_HORIZON, (sg_real)0, self->plan);
    sg_fill(TWO_STAGE_MPC_ORDER, (sg_real)0, self->predicted);
    sg_fill(TWO_STAGE_MPC_ROWS, (sg_real)0, self->upper);
    sg_fill(TWO_STAGE_MPC_ROWS, (sg_real)0, self->lower);
    sg_fill(TWO_STAGE_MPC_ROWS, (sg_real)0, self->slack_upper);
    sg_fill(TWO_STAGE_MPC_ROWS, (sg_real)0, self->slack_lower);
    sg_fill(TWO_STAGE_MPC_ROWS, (sg_real)0, self->change);
    sg_fill(TWO_STAGE_MPC_STRIDE, (sg_real)0, self->absolute_sum);
    sg_fill(TWO_STAGE_MPC_LINES, (sg_real)0, self->shared);
    sg_fill(TWO_STAGE_MPC_ROWS, (sg_real)0, self->scratch);
    sg_fill(TWO_STAGE_MPC_ROWS, (sg_real)0, self->last_upper);
    sg_fill(TWO_STAGE_MPC_ROWS, (sg_real)0, self->last_lower);
    sg_fill(TWO_STAGE_MPC_ROWS, (sg_real)0, self->last_change);
    sg_fill(TWO_STAGE_MPC_REFERENCES, (sg_real)0, self->relative);
    sg_fill(TWO_STAGE_MPC_ORDER, (sg_real)0, self->start);
    sg_fill(TWO_STAGE_MPC_HORIZON, (sg_real)0, self->free_plan);
    sg_fill(TWO_STAGE_MPC_HORIZON, (sg_real)0, self->correction);
    sg_fill(TWO_STAGE_MPC_HORIZON, (sg_real)0, self->scratch_plan);
    sg_fill(TWO_STAGE_MPC_ROWS, (sg_real)0, self->below);
    sg_fill(TWO_STAGE_MPC_ROWS, (sg_real)0, self->above);
    sg_fill(TWO_STAGE_MPC_ROWS, (sg_real)0, self->rows);
    self->ready = 0;
}

sg_status two_stage_mpc_reset(two_stage_mpc_t *self, const two_stage_mpc_reset_in *in)
{
    sg_status status = SG_OK;
    /*@ dynamic_split status; */
    status = sg_worse(status, sg_check(in->position, -0.6000000000000001, 0.6000000000000001));
    self->ready = (status == SG_OK) ? 1 : 0;
    const sg_real where = (status == SG_OK) ? in->position : (sg_real)0;
    sg_fill(TWO_STAGE_MPC_HORIZON, where, self->plan);
    sg_fill(TWO_STAGE_MPC_ORDER, (sg_real)0, self->predicted);
    self->predicted[0] = where;
    two_stage_mpc_cold_duals(self);
    /*@ merge status; */
    return status;
}

sg_status two_stage_mpc_seed(two_stage_mpc_t *self, const two_stage_mpc_seed_in *in)
{
    sg_status status = SG_OK;
    /*@ dynamic_split status; */
    status = sg_worse(status, sg_check(in->command, -0.6000000000000001, 0.6000000000000001));
    const sg_real command = (status == SG_OK) ? in->command : self->plan[TWO_STAGE_MPC_HORIZON - 1];
    sg_shift(TWO_STAGE_MPC_HORIZON, self->plan, command);
    /*@ merge status; */
    return status;
}

sg_status two_stage_mpc_candidate(const two_stage_mpc_t *self, const two_stage_mpc_candidate_in *in, two_stage_mpc_candidate_out *out)
{
    sg_real state[TWO_STAGE_MPC_ORDER];
    sg_real next[TWO_STAGE_MPC_ORDER];
    sg_status status = SG_OK;
    /*@ dynamic_split status; */
    status = sg_worse(status, sg_check(in->position, -0.6000000000000001, 0.6000000000000001));
    status = sg_worse(status, sg_check(in->velocity, -2.8, 2.8));
    status = sg_worse(status, sg_check(in->acceleration, -58.84, 58.84));
    state[0] = (status == SG_OK) ? in->position : self->predicted[0];
    state[1] = (status == SG_OK) ? in->velocity : self->predicted[1];
    state[2] = (status == SG_OK) ? in->acceleration : self->predicted[2];
    SG_PRAGMA("MUST_ITERATE(19, 19)")
    for (int k = 1; k < TWO_STAGE_MPC_HORIZON; k++) {
        two_stage_mpc_advance(state, self->plan[k], next);
        sg_copy(TWO_STAGE_MPC_ORDER, next, state);
    }
    out->position = state[0];
    out->velocity = state[1];
    out->acceleration = state[2];
    /*@ merge status; */
    return status;
}

sg_status two_stage_mpc_hold(two_stage_mpc_t *self, const two_stage_mpc_hold_in *in, two_stage_mpc_hold_out *out)
{
    sg_real state[TWO_STAGE_MPC_ORDER];
    sg_status status = SG_OK;
    /*@ dynamic_split status; */
    status = sg_worse(status, sg_check(in->reference, -0.4, 0.4));
    sg_copy(TWO_STAGE_MPC_ORDER, self->predicted, state);
    two_stage_mpc_shift_plan(self, (status == SG_OK) ? in->reference : self->plan[TWO_STAGE_MPC_HORIZON - 1]);
    two_stage_mpc_accept(self, state);
    out->command = self->plan[0];
    out->position = state[0];
    out->velocity = state[1];
    out->acceleration = state[2];
    /*@ merge status; */
    return status;
}

/* All inputs are in range. */
static sg_status two_stage_mpc_optimise(two_stage_mpc_t *self, const two_stage_mpc_step_in *in, int32_t *iterations)
{
    sg_status status = SG_OK;
    sg_real state[TWO_STAGE_MPC_ORDER];
    state[0] = in->position;
    state[1] = in->velocity;
    state[2] = in->acceleration;
    const sg_real origin = state[0];
    if (two_stage_mpc_unconstrained(self, origin, &state[1], in) == 1) {
        two_stage_mpc_cold_duals(self);
        sg_fill(TWO_STAGE_MPC_HORIZON, (sg_real)0, self->correction);
    } else {
        status = two_stage_mpc_solve(self, iterations);
    }
    if (status == SG_BACKUP) {
        two_stage_mpc_shift_plan(self, in->reference[TWO_STAGE_MPC_HORIZON]);
        status = two_stage_mpc_judge(self, origin);
    } else {
        SG_PRAGMA("MUST_ITERATE(20, 20)")
        for (int i = 0; i < TWO_STAGE_MPC_HORIZON; i++) {
            self->scratch_plan[i] = (self->free_plan[i] - self->correction[i]) + origin;
        }
    }
    two_stage_mpc_accept(self, state);
    return status;
}

sg_status two_stage_mpc_step(two_stage_mpc_t *self, const two_stage_mpc_step_in *in, two_stage_mpc_step_out *out)
{
    sg_status status = SG_OK;
    /*@ dynamic_split status; */
    status = sg_worse(status, sg_check(in->position, -0.6000000000000001, 0.6000000000000001));
    status = sg_worse(status, sg_check(in->velocity, -2.8, 2.8));
    status = sg_worse(status, sg_check(in->acceleration, -58.84, 58.84));
    status = sg_worse(status, sg_check_array(21, in->reference, -0.4, 0.4));
    status = sg_worse(status, sg_check_array(20, in->low, -0.6000000000000001, 0.6000000000000001));
    status = sg_worse(status, sg_check_array(20, in->high, -0.6000000000000001, 0.6000000000000001));
    int32_t iterations = 0;
    if (self->ready == 0) {
        status = SG_NOT_READY;
    } else if (status != SG_OK) {
        sg_real state[TWO_STAGE_MPC_ORDER];
        sg_copy(TWO_STAGE_MPC_ORDER, self->predicted, state);
        two_stage_mpc_shift_plan(self, self->plan[TWO_STAGE_MPC_HORIZON - 1]);
        two_stage_mpc_accept(self, state);
    } else {
        status = two_stage_mpc_optimise(self, in, &iterations);
    }
    out->command = self->plan[0];
    out->iterations = iterations;
    /*@ merge status; */
    return status;
}
