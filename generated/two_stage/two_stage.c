/* SPDX-License-Identifier: MIT */
/*
 * Made by servogen 0.1.0 from cascade.c.jinja; not to be edited.
 * Design 2df8fd9b7b96227c8a47a2bccc487b135ad72d7fa713a19599e6540c03996ab1.
 *
 * SPRG-MPC cascade for a two-stage machine
 *
 * Counted in this C, calls of other files included (servogen wcet): operations on two_stage_real, bytes
 * of C objects on the stack. Constant tables of this file: 224 bytes.
 *
 * worst case of one call                        add    mul   div    cmp other    load  store stack
 * two_stage_init                                  0      0     0      0     0       0   8948    32
 * two_stage_reset                                 0      0     0     30     0     280  15704    92
 * two_stage_step                            1151256 969735 47244 342556 64136 1860377 409662  5492
 *   fixed part                                 6984   4395     0   7756   896   16001   6414
 *   each of 186 TWO_STAGE_MPC_ITERATION_CAP    6152   5190   254   1800   340    9916   2168
 * two_stage_predict                              24     24     0     30     0      84     48   236
 * two_stage_plan                            1151246 969728 47244 342506 64134 1860343 409642  5476
 *   fixed part                                 6974   4388     0   7706   894   15967   6394
 *   each of 186 TWO_STAGE_MPC_ITERATION_CAP    6152   5190   254   1800   340    9916   2168
 * two_stage_start                                10      7     0     50     2      36     22   228
 * two_stage_fast_step                            42     36     0     22    17     117     42   204
 */
#include "two_stage.h"
#include "two_stage_scalar.h"
#include "two_stage_tables.h"

/* The measured states, if they are usable. */
static sg_status two_stage_measure(two_stage_t *self, const two_stage_step_in *in)
{
    sg_status status = SG_OK;
    /*@ dynamic_split status; */
    status = sg_worse(status, sg_check(in->x_position, -0.6000000000000001, 0.6000000000000001));
    status = sg_worse(status, sg_check(in->x_velocity, -2.8, 2.8));
    status = sg_worse(status, sg_check(in->x_acceleration, -58.84, 58.84));
    status = sg_worse(status, sg_check(in->y_position, -0.6000000000000001, 0.6000000000000001));
    status = sg_worse(status, sg_check(in->y_velocity, -2.8, 2.8));
    status = sg_worse(status, sg_check(in->y_acceleration, -58.84, 58.84));
    if (status == SG_OK) {
        self->state_x[0] = in->x_position;
        self->state_x[1] = in->x_velocity;
        self->state_x[2] = in->x_acceleration;
        self->state_y[0] = in->y_position;
        self->state_y[1] = in->y_velocity;
        self->state_y[2] = in->y_acceleration;
    }
    /*@ merge status; */
    return status;
}

/* Ask the governor from the given states; queue the points it takes. */
static sg_status two_stage_govern(two_stage_t *self, const two_stage_step_in *in, const sg_real *end_x,
                                const sg_real *end_y, int32_t n_points, int32_t *taken)
{
    two_stage_governor_step_in ask;
    two_stage_governor_step_out told;
    two_stage_follower_push_in push;
    ask.x_position = end_x[0];
    ask.x_velocity = end_x[1];
    ask.x_acceleration = end_x[2];
    ask.last_x = self->reference_x[TWO_STAGE_HORIZON];
    sg_copy_some(TWO_STAGE_POINTS, n_points, in->points_x, ask.points_x);
    ask.y_position = end_y[0];
    ask.y_velocity = end_y[1];
    ask.y_acceleration = end_y[2];
    ask.last_y = self->reference_y[TWO_STAGE_HORIZON];
    sg_copy_some(TWO_STAGE_POINTS, n_points, in->points_y, ask.points_y);
    ask.n_points = n_points;
    sg_status status = two_stage_governor_step(&self->governor, &ask, &told);
    push.n_points = told.points_taken;
    sg_copy_some(TWO_STAGE_POINTS, told.points_taken, in->points_x, push.points_x);
    sg_copy_some(TWO_STAGE_POINTS, told.points_taken, in->points_y, push.points_y);
    const sg_status pushed = two_stage_follower_push(&self->fast, &push);
    if (pushed != SG_OK) { /* nothing was queued, so nothing may be taken */
        told.points_taken = 0;
        told.reference_x = self->reference_x[TWO_STAGE_HORIZON];
        told.low_x = told.reference_x;
        told.high_x = told.reference_x;
        told.reference_y = self->reference_y[TWO_STAGE_HORIZON];
        told.low_y = told.reference_y;
        told.high_y = told.reference_y;
    }
    status = sg_worse(status, pushed);
    /* the sum of what waits in the fast stage's queue */
    self->pending = sg_bound_count(self->pending + told.points_taken, 0, TWO_STAGE_WAITING);
    sg_shift(TWO_STAGE_REFERENCES, self->reference_x, told.reference_x);
    sg_shift(TWO_STAGE_INTERVALS, self->low_x, told.low_x);
    sg_shift(TWO_STAGE_INTERVALS, self->high_x, told.high_x);
    sg_shift(TWO_STAGE_REFERENCES, self->reference_y, told.reference_y);
    sg_shift(TWO_STAGE_INTERVALS, self->low_y, told.low_y);
    sg_shift(TWO_STAGE_INTERVALS, self->high_y, told.high_y);
    *taken = told.points_taken;
    return status;
}

/* Start the fast stage's next interval; FINISHED when nothing is left. */
static sg_status two_stage_begin(two_stage_t *self, sg_status status, int32_t *interval)
{
    two_stage_follower_begin_in ask;
    two_stage_follower_begin_out told;
    sg_status result = status;
    ask.x_position = self->state_x[0];
    ask.x_velocity = self->state_x[1];
    ask.x_acceleration = self->state_x[2];
    ask.slow_command_x = self->command_x;
    ask.y_position = self->state_y[0];
    ask.y_velocity = self->state_y[1];
    ask.y_acceleration = self->state_y[2];
    ask.slow_command_y = self->command_y;
    result = sg_worse(result, two_stage_follower_begin(&self->fast, &ask, &told));
    if (result == SG_OK) {
        if (self->pending == 0) {
            if (self->offered == 0) {
                result = SG_FINISHED;
            }
        }
    }
    self->pending = sg_bound_count(self->pending - told.interval_points, 0, TWO_STAGE_WAITING);
    self->planned = 0;
    *interval = told.interval_points;
    return result;
}

/* Bounds of y_1..y_N: range (16e, f) at both ends of every interval, position limit. */
static void two_stage_window_x(const two_stage_t *self, two_stage_mpc_step_in *ask)
{
    SG_PRAGMA("MUST_ITERATE(20, 20)")
    for (int k = 0; k < TWO_STAGE_HORIZON; k++) {
        sg_real low = self->high_x[k];
        sg_real high = self->low_x[k];
        if (k < (TWO_STAGE_HORIZON - 1)) {
            low = sg_max(low, self->high_x[k + 1]);
            high = sg_min(high, self->low_x[k + 1]);
        }
        ask->low[k] = sg_max(low - two_stage_range_x, -two_stage_position_limit_x);
        ask->high[k] = sg_min(high + two_stage_range_x, two_stage_position_limit_x);
    }
}

/* Solve this axis, or go on with its plan where there is no usable measurement. */
static sg_status two_stage_optimise_x(two_stage_t *self, sg_status measured, int32_t *iterations)
{
    sg_status status = measured;
    if (measured == SG_OK) {
        two_stage_mpc_step_in ask;
        two_stage_mpc_step_out told;
        ask.position = self->state_x[0];
        ask.velocity = self->state_x[1];
        ask.acceleration = self->state_x[2];
        sg_copy(TWO_STAGE_REFERENCES, self->reference_x, ask.reference);
        two_stage_window_x(self, &ask);
        status = two_stage_mpc_step(&self->mpc_x, &ask, &told);
        self->command_x = told.command;
        *iterations = told.iterations;
    } else {
        two_stage_mpc_hold_in ask;
        two_stage_mpc_hold_out told;
        ask.reference = self->reference_x[TWO_STAGE_HORIZON];
        (void)two_stage_mpc_hold(&self->mpc_x, &ask, &told); /* a point of the path: in range */
        self->command_x = told.command;
        *iterations = 0;
    }
    return status;
}

/* State at the end of the shifted plan; the measurement gives way to the prediction if unusable. */
static void two_stage_end_x(two_stage_t *self, int32_t usable, sg_real *end)
{
    two_stage_mpc_candidate_in ask;
    two_stage_mpc_candidate_out told;
    if (usable == 0) {
        sg_copy(TWO_STAGE_ORDER, self->mpc_x.predicted, self->state_x);
    }
    ask.position = self->state_x[0];
    ask.velocity = self->state_x[1];
    ask.acceleration = self->state_x[2];
    (void)two_stage_mpc_candidate(&self->mpc_x, &ask, &told); /* measured: checked before */
    end[0] = told.position;
    end[1] = told.velocity;
    end[2] = told.acceleration;
}

static void two_stage_seed_x(two_stage_t *self)
{
    two_stage_mpc_seed_in seed;
    seed.command = self->reference_x[TWO_STAGE_HORIZON];
    (void)two_stage_mpc_seed(&self->mpc_x, &seed); /* a point of the path: in range */
}

/* Bounds of y_1..y_N: range (16e, f) at both ends of every interval, position limit. */
static void two_stage_window_y(const two_stage_t *self, two_stage_mpc_step_in *ask)
{
    SG_PRAGMA("MUST_ITERATE(20, 20)")
    for (int k = 0; k < TWO_STAGE_HORIZON; k++) {
        sg_real low = self->high_y[k];
        sg_real high = self->low_y[k];
        if (k < (TWO_STAGE_HORIZON - 1)) {
            low = sg_max(low, self->high_y[k + 1]);
            high = sg_min(high, self->low_y[k + 1]);
        }
        ask->low[k] = sg_max(low - two_stage_range_y, -two_stage_position_limit_y);
        ask->high[k] = sg_min(high + two_stage_range_y, two_stage_position_limit_y);
    }
}

/* Solve this axis, or go on with its plan where there is no usable measurement. */
static sg_status two_stage_optimise_y(two_stage_t *self, sg_status measured, int32_t *iterations)
{
    sg_status status = measured;
    if (measured == SG_OK) {
        two_stage_mpc_step_in ask;
        two_stage_mpc_step_out told;
        ask.position = self->state_y[0];
        ask.velocity = self->state_y[1];
        ask.acceleration = self->state_y[2];
        sg_copy(TWO_STAGE_REFERENCES, self->reference_y, ask.reference);
        two_stage_window_y(self, &ask);
        status = two_stage_mpc_step(&self->mpc_y, &ask, &told);
        self->command_y = told.command;
        *iterations = told.iterations;
    } else {
        two_stage_mpc_hold_in ask;
        two_stage_mpc_hold_out told;
        ask.reference = self->reference_y[TWO_STAGE_HORIZON];
        (void)two_stage_mpc_hold(&self->mpc_y, &ask, &told); /* a point of the path: in range */
        self->command_y = told.command;
        *iterations = 0;
    }
    return status;
}

/* State at the end of the shifted plan; the measurement gives way to the prediction if unusable. */
static void two_stage_end_y(two_stage_t *self, int32_t usable, sg_real *end)
{
    two_stage_mpc_candidate_in ask;
    two_stage_mpc_candidate_out told;
    if (usable == 0) {
        sg_copy(TWO_STAGE_ORDER, self->mpc_y.predicted, self->state_y);
    }
    ask.position = self->state_y[0];
    ask.velocity = self->state_y[1];
    ask.acceleration = self->state_y[2];
    (void)two_stage_mpc_candidate(&self->mpc_y, &ask, &told); /* measured: checked before */
    end[0] = told.position;
    end[1] = told.velocity;
    end[2] = told.acceleration;
}

static void two_stage_seed_y(two_stage_t *self)
{
    two_stage_mpc_seed_in seed;
    seed.command = self->reference_y[TWO_STAGE_HORIZON];
    (void)two_stage_mpc_seed(&self->mpc_y, &seed); /* a point of the path: in range */
}

void two_stage_init(two_stage_t *self)
{
    two_stage_governor_init(&self->governor);
    two_stage_mpc_init(&self->mpc_x);
    two_stage_mpc_init(&self->mpc_y);
    two_stage_follower_init(&self->fast);
    sg_fill(TWO_STAGE_REFERENCES, (sg_real)0, self->reference_x);
    sg_fill(TWO_STAGE_INTERVALS, (sg_real)0, self->low_x);
    sg_fill(TWO_STAGE_INTERVALS, (sg_real)0, self->high_x);
    sg_fill(TWO_STAGE_ORDER, (sg_real)0, self->state_x);
    self->command_x = (sg_real)0;
    sg_fill(TWO_STAGE_REFERENCES, (sg_real)0, self->reference_y);
    sg_fill(TWO_STAGE_INTERVALS, (sg_real)0, self->low_y);
    sg_fill(TWO_STAGE_INTERVALS, (sg_real)0, self->high_y);
    sg_fill(TWO_STAGE_ORDER, (sg_real)0, self->state_y);
    self->command_y = (sg_real)0;
    self->pending = 0;
    self->offered = 0;
    self->planned = 0;
    self->priming = 0;
    self->ready = 0;
}

sg_status two_stage_reset(two_stage_t *self, const two_stage_reset_in *in)
{
    two_stage_follower_reset_in fast;
    sg_status status = SG_OK;
    /*@ dynamic_split status; */
    status = sg_worse(status, sg_check(in->position_x, -0.4, 0.4));
    status = sg_worse(status, sg_check(in->position_y, -0.4, 0.4));
    two_stage_init(self);
    fast.position_x = in->position_x;
    fast.position_y = in->position_y;
    status = sg_worse(status, two_stage_follower_reset(&self->fast, &fast));
    two_stage_mpc_reset_in mpc_x;
    mpc_x.position = in->position_x;
    status = sg_worse(status, two_stage_mpc_reset(&self->mpc_x, &mpc_x));
    two_stage_mpc_reset_in mpc_y;
    mpc_y.position = in->position_y;
    status = sg_worse(status, two_stage_mpc_reset(&self->mpc_y, &mpc_y));
    if (status == SG_OK) {
        sg_fill(TWO_STAGE_REFERENCES, in->position_x, self->reference_x);
        sg_fill(TWO_STAGE_INTERVALS, in->position_x, self->low_x);
        sg_fill(TWO_STAGE_INTERVALS, in->position_x, self->high_x);
        self->state_x[0] = in->position_x;
        self->command_x = in->position_x;
        sg_fill(TWO_STAGE_REFERENCES, in->position_y, self->reference_y);
        sg_fill(TWO_STAGE_INTERVALS, in->position_y, self->low_y);
        sg_fill(TWO_STAGE_INTERVALS, in->position_y, self->high_y);
        self->state_y[0] = in->position_y;
        self->command_y = in->position_y;
        self->priming = TWO_STAGE_PRIMING;
        self->ready = 1;
    }
    /*@ merge status; */
    return status;
}

void two_stage_fast_step(two_stage_t *self, two_stage_fast_step_out *out)
{
    two_stage_follower_step_out told;
    two_stage_follower_step(&self->fast, &told);
    out->command_x = told.command_x;
    out->command_y = told.command_y;
    out->reference_x = told.reference_x;
    out->reference_y = told.reference_y;
    out->along = told.along;
}

/* One period of a controller that is ready. */
static sg_status two_stage_period(two_stage_t *self, const two_stage_step_in *in, two_stage_step_out *out)
{
    sg_real end_x[TWO_STAGE_ORDER];
    sg_real end_y[TWO_STAGE_ORDER];
    int32_t taken = 0;
    const sg_status measured = two_stage_measure(self, in);
    const int32_t usable = (measured == SG_OK) ? 1 : 0;
    two_stage_end_x(self, usable, end_x);
    two_stage_end_y(self, usable, end_y);
    sg_status status = two_stage_govern(self, in, end_x, end_y, (usable == 1) ? in->n_points : 0, &taken);
    status = sg_worse(status, measured);
    if (self->priming > 0) {
        self->priming = self->priming - 1;
        two_stage_seed_x(self);
        two_stage_seed_y(self);
        status = sg_worse(status, SG_PRIMING);
    } else {
        const sg_status status_x = two_stage_optimise_x(self, measured, &out->iterations_x);
        status = sg_worse(status, status_x);
        out->status_x = (int32_t)status_x;
        out->command_x = self->command_x;
        const sg_status status_y = two_stage_optimise_y(self, measured, &out->iterations_y);
        status = sg_worse(status, status_y);
        out->status_y = (int32_t)status_y;
        out->command_y = self->command_y;
    }
    out->points_taken = taken;
    return status;
}

/* (11): where the present command leads in one period. */
static void two_stage_ahead_x(const two_stage_t *self, const sg_real *restrict state,
                                sg_real *restrict ahead)
{
    sg_matvec(TWO_STAGE_ORDER, TWO_STAGE_ORDER, two_stage_a_columns_x, state, ahead);
    SG_PRAGMA("MUST_ITERATE(3, 3)")
    for (int i = 0; i < TWO_STAGE_ORDER; i++) {
        ahead[i] += two_stage_b_x[i] * self->command_x;
    }
}

/* (11): where the present command leads in one period. */
static void two_stage_ahead_y(const two_stage_t *self, const sg_real *restrict state,
                                sg_real *restrict ahead)
{
    sg_matvec(TWO_STAGE_ORDER, TWO_STAGE_ORDER, two_stage_a_columns_y, state, ahead);
    SG_PRAGMA("MUST_ITERATE(3, 3)")
    for (int i = 0; i < TWO_STAGE_ORDER; i++) {
        ahead[i] += two_stage_b_y[i] * self->command_y;
    }
}

sg_status two_stage_predict(const two_stage_t *self, const two_stage_predict_in *in, two_stage_predict_out *out)
{
    sg_status status = SG_OK;
    sg_real state_x[TWO_STAGE_ORDER];
    sg_real ahead_x[TWO_STAGE_ORDER];
    sg_copy(TWO_STAGE_ORDER, self->state_x, state_x);
    sg_real state_y[TWO_STAGE_ORDER];
    sg_real ahead_y[TWO_STAGE_ORDER];
    sg_copy(TWO_STAGE_ORDER, self->state_y, state_y);
    /*@ dynamic_split status; */
    status = sg_worse(status, sg_check(in->x_position, -0.6000000000000001, 0.6000000000000001));
    status = sg_worse(status, sg_check(in->x_velocity, -2.8, 2.8));
    status = sg_worse(status, sg_check(in->x_acceleration, -58.84, 58.84));
    status = sg_worse(status, sg_check(in->y_position, -0.6000000000000001, 0.6000000000000001));
    status = sg_worse(status, sg_check(in->y_velocity, -2.8, 2.8));
    status = sg_worse(status, sg_check(in->y_acceleration, -58.84, 58.84));
    if (status == SG_OK) {
        state_x[0] = in->x_position;
        state_x[1] = in->x_velocity;
        state_x[2] = in->x_acceleration;
        state_y[0] = in->y_position;
        state_y[1] = in->y_velocity;
        state_y[2] = in->y_acceleration;
    }
    two_stage_ahead_x(self, state_x, ahead_x);
    out->x_position = ahead_x[0];
    out->x_velocity = ahead_x[1];
    out->x_acceleration = ahead_x[2];
    two_stage_ahead_y(self, state_y, ahead_y);
    out->y_position = ahead_y[0];
    out->y_velocity = ahead_y[1];
    out->y_acceleration = ahead_y[2];
    /*@ merge status; */
    return (self->ready == 1) ? status : SG_NOT_READY;
}

sg_status two_stage_plan(two_stage_t *self, const two_stage_plan_in *in, two_stage_plan_out *out)
{
    sg_status status = SG_NOT_READY;
    out->command_x = self->command_x;
    out->command_y = self->command_y;
    out->points_taken = 0;
    out->interval_points = 0;
    out->pending = 0;
    out->iterations_x = 0;
    out->iterations_y = 0;
    out->status_x = 0;
    out->status_y = 0;
    if (self->ready == 1) {
        const int32_t complete = (self->priming == 0) ? 1 : 0;
        self->planned = 0; /* a start that comes too early finds no plan, not half of one */
        self->offered = in->n_points;
        status = two_stage_period(self, in, out);
        self->planned = complete;
    }
    out->pending = self->pending;
    return status;
}

sg_status two_stage_start(two_stage_t *self, two_stage_start_out *out)
{
    sg_status status = SG_NOT_READY;
    out->interval_points = 0;
    if (self->planned == 1) {
        status = two_stage_begin(self, SG_OK, &out->interval_points);
    }
    out->command_x = self->command_x;
    out->command_y = self->command_y;
    out->pending = self->pending;
    return status;
}

sg_status two_stage_step(two_stage_t *self, const two_stage_step_in *in, two_stage_step_out *out)
{
    sg_status status = two_stage_plan(self, in, out);
    if (self->planned == 1) {
        status = two_stage_begin(self, status, &out->interval_points);
    }
    out->pending = self->pending;
    return status;
}
