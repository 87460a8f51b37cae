/* SPDX-License-Identifier: MIT */
/*
 * Made by servogen 0.1.0 from fast.c.jinja; not to be edited.
 * Design 2df8fd9b7b96227c8a47a2bccc487b135ad72d7fa713a19599e6540c03996ab1.
 *
 * Fast stage commands (22)-(23) and the feed along the points
 *
 * Counted in this C, calls of other files included (servogen wcet): operations on two_stage_real, bytes
 * of C objects on the stack. Constant tables of this file: 384 bytes.
 *
 * worst case of one call   add mul div  cmp other load store stack
 * two_stage_follower_init    0   0   0    0     0    0  6320    28
 * two_stage_follower_reset   0   0   0   10     0    8  6326    40
 * two_stage_follower_push    0   0   0 1500     0  600   300    80
 * two_stage_follower_begin  10   7   0   50     2   26    12   132
 * two_stage_follower_room    2   1   0    0     1    3     0     8
 * two_stage_follower_step   42  36   0   22    17  112    37   156
 */
#include "two_stage_follower.h"
#include "two_stage_scalar.h"
#include "two_stage_follower_tables.h"

/* An index into the ring of points, one turn past the end at most. */
static int32_t two_stage_follower_wrap(int32_t index)
{
    return (index >= TWO_STAGE_FOLLOWER_BUFFER) ? (index - TWO_STAGE_FOLLOWER_BUFFER) : index;
}

/*
 * Feed rates (points per fast sample) at the start, in the flat middle and at the end. The start is
 * where the last interval ended; the end is the mean of this interval's and the next one's feed,
 * kept where both can still cover their points at rates from 0 to 1.
 */
static void two_stage_follower_plan_feed(two_stage_follower_t *self, sg_real points, sg_real following)
{
    const sg_real zero = (sg_real)0;
    const sg_real one = (sg_real)1;
    const sg_real most = points * two_stage_follower_ramp_twice_inverse;
    const sg_real least = (points - two_stage_follower_flat) * two_stage_follower_ramp_twice_inverse;
    sg_real begin = self->rate_end;
    sg_real end = (points + following) * two_stage_follower_rate_scale;
    end = sg_min(end, following * two_stage_follower_ramp_twice_inverse);
    end = sg_max(end, ((following - two_stage_follower_flat) * two_stage_follower_ramp_twice_inverse) - one);
    end = sg_min(end, most - begin);
    end = sg_max(end, least - begin);
    end = sg_clamp(end, zero, one);
    begin = sg_min(begin, most - end);
    begin = sg_max(begin, least - end);
    begin = sg_clamp(begin, zero, one);
    self->rate_begin = begin;
    self->rate_end = end;
    self->rate_flat = (points - (two_stage_follower_ramp_half * (begin + end))) * two_stage_follower_flat_inverse;
}

static sg_real two_stage_follower_rate(const two_stage_follower_t *self)
{
    const int32_t left = TWO_STAGE_FOLLOWER_POINTS - self->done;
    sg_real rate;
    if (self->done < TWO_STAGE_FOLLOWER_RAMP) {
        const sg_real share = ((sg_real)self->done + (sg_real)0.5) * two_stage_follower_ramp_inverse;
        rate = self->rate_begin + ((self->rate_flat - self->rate_begin) * share);
    } else if (left <= TWO_STAGE_FOLLOWER_RAMP) {
        const sg_real share = ((sg_real)left - (sg_real)0.5) * two_stage_follower_ramp_inverse;
        rate = self->rate_end + ((self->rate_flat - self->rate_end) * share);
    } else {
        rate = self->rate_flat;
    }
    return rate;
}

/* The point `along` points into the interval. */
static sg_real two_stage_follower_point(const two_stage_follower_t *self, const sg_real *path)
{
    sg_real point = path[self->head];
    if (self->current > 0) {
        int32_t index = (int32_t)self->along;
        index = (index > (self->current - 1)) ? (self->current - 1) : index;
        const sg_real share = self->along - (sg_real)index;
        const sg_real here = path[two_stage_follower_wrap(self->head + index)];
        const sg_real there = path[two_stage_follower_wrap(self->head + index + 1)];
        point = here + (share * (there - here));
    }
    return point;
}

void two_stage_follower_init(two_stage_follower_t *self)
{
    sg_fill(TWO_STAGE_FOLLOWER_BUFFER, (sg_real)0, self->path_x);
    sg_fill(TWO_STAGE_FOLLOWER_BUFFER, (sg_real)0, self->path_y);
    sg_fill(TWO_STAGE_FOLLOWER_ORDER, (sg_real)0, self->state_x);
    sg_fill(TWO_STAGE_FOLLOWER_ORDER, (sg_real)0, self->state_y);
    sg_fill(TWO_STAGE_FOLLOWER_ORDER, (sg_real)0, self->scratch_x);
    sg_fill(TWO_STAGE_FOLLOWER_ORDER, (sg_real)0, self->scratch_y);
    self->command_x = (sg_real)0;
    self->command_y = (sg_real)0;
    self->along = (sg_real)0;
    self->rate_begin = (sg_real)0;
    self->rate_flat = (sg_real)0;
    self->rate_end = (sg_real)0;
    SG_PRAGMA("MUST_ITERATE(20, 20)")
    for (int i = 0; i < TWO_STAGE_FOLLOWER_INTERVALS; i++) {
        self->queue[i] = 0;
    }
    self->waiting = 0;
    self->head = 0;
    self->tail = 0;
    self->current = 0;
    self->done = 0;
    self->ready = 0;
}

sg_status two_stage_follower_reset(two_stage_follower_t *self, const two_stage_follower_reset_in *in)
{
    sg_status status = SG_OK;
    /*@ dynamic_split status; */
    status = sg_worse(status, sg_check(in->position_x, -0.4, 0.4));
    status = sg_worse(status, sg_check(in->position_y, -0.4, 0.4));
    two_stage_follower_init(self);
    if (status == SG_OK) {
        self->path_x[0] = in->position_x;
        self->state_x[0] = in->position_x;
        self->command_x = in->position_x;
        self->path_y[0] = in->position_y;
        self->state_y[0] = in->position_y;
        self->command_y = in->position_y;
        self->ready = 1;
    }
    self->done = TWO_STAGE_FOLLOWER_POINTS;
    /*@ merge status; */
    return status;
}

sg_status two_stage_follower_push(two_stage_follower_t *self, const two_stage_follower_push_in *in)
{
    sg_status status = SG_OK;
    /*@ dynamic_split status; */
    status = sg_worse(status, sg_check_array(150, in->points_x, -0.4, 0.4));
    status = sg_worse(status, sg_check_array(150, in->points_y, -0.4, 0.4));
    if (in->n_points < 0) {
        status = sg_worse(status, SG_OUT_OF_RANGE);
    }
    if (in->n_points > 150) {
        status = sg_worse(status, SG_OUT_OF_RANGE);
    }
    if (self->waiting >= TWO_STAGE_FOLLOWER_INTERVALS) {
        status = (status == SG_OK) ? SG_OVERFLOW : status;
    }
    if (self->ready == 0) {
        status = SG_NOT_READY;
    }
    if (status == SG_OK) {
        SG_PRAGMA("MUST_ITERATE(150, 150)")
        for (int i = 0; i < TWO_STAGE_FOLLOWER_POINTS; i++) {
            if (i < in->n_points) {
                self->tail = two_stage_follower_wrap(self->tail + 1);
                self->path_x[self->tail] = in->points_x[i];
                self->path_y[self->tail] = in->points_y[i];
            }
        }
        self->queue[self->waiting] = in->n_points;
        self->waiting = self->waiting + 1;
    }
    /*@ merge status; */
    return status;
}

sg_status two_stage_follower_begin(two_stage_follower_t *self, const two_stage_follower_begin_in *in, two_stage_follower_begin_out *out)
{
    sg_status status = SG_OK;
    /*@ dynamic_split status; */
    status = sg_worse(status, sg_check(in->x_position, -0.6000000000000001, 0.6000000000000001));
    status = sg_worse(status, sg_check(in->x_velocity, -2.8, 2.8));
    status = sg_worse(status, sg_check(in->x_acceleration, -58.84, 58.84));
    status = sg_worse(status, sg_check(in->slow_command_x, -0.6000000000000001, 0.6000000000000001));
    status = sg_worse(status, sg_check(in->y_position, -0.6000000000000001, 0.6000000000000001));
    status = sg_worse(status, sg_check(in->y_velocity, -2.8, 2.8));
    status = sg_worse(status, sg_check(in->y_acceleration, -58.84, 58.84));
    status = sg_worse(status, sg_check(in->slow_command_y, -0.6000000000000001, 0.6000000000000001));
    if (self->ready == 0) {
        out->interval_points = 0;
        status = SG_NOT_READY;
    } else {
        if (status == SG_OK) {
            self->state_x[0] = in->x_position;
            self->state_x[1] = in->x_velocity;
            self->state_x[2] = in->x_acceleration;
            self->command_x = in->slow_command_x;
            self->state_y[0] = in->y_position;
            self->state_y[1] = in->y_velocity;
            self->state_y[2] = in->y_acceleration;
            self->command_y = in->slow_command_y;
        }
        self->head = two_stage_follower_wrap(self->head + self->current);
        self->current = 0;
        if (self->waiting > 0) {
            self->current = self->queue[0];
            SG_PRAGMA("MUST_ITERATE(19, 19)")
            for (int i = 0; i < (TWO_STAGE_FOLLOWER_INTERVALS - 1); i++) {
                self->queue[i] = self->queue[i + 1];
            }
            self->waiting = self->waiting - 1;
        }
        const int32_t following = (self->waiting > 0) ? self->queue[0] : self->current;
        self->done = 0;
        self->along = (sg_real)0;
        two_stage_follower_plan_feed(self, (sg_real)self->current, (sg_real)following);
        out->interval_points = self->current;
    }
    /*@ merge status; */
    return status;
}

void two_stage_follower_room(const two_stage_follower_t *self, two_stage_follower_room_out *out)
{
    /* an interval that ramps from the present end rate to one and stays there */
    out->points = (int32_t)(two_stage_follower_flat + (two_stage_follower_ramp_half * ((sg_real)1 + self->rate_end)));
}

void two_stage_follower_step(two_stage_follower_t *self, two_stage_follower_step_out *out)
{
    {
        /* between two points of the path, all of them within its limits */
        const sg_real reference =
            sg_bound(two_stage_follower_point(self, self->path_x), -two_stage_follower_end_x, two_stage_follower_end_x);
        const sg_real taken = sg_dot(TWO_STAGE_FOLLOWER_ORDER, two_stage_follower_row_x, self->state_x) +
                              (two_stage_follower_direct_x * self->command_x);
        out->reference_x = reference;
        out->command_x = sg_clamp(reference - taken, -two_stage_follower_limit_x, two_stage_follower_limit_x);
        sg_matvec(TWO_STAGE_FOLLOWER_ORDER, TWO_STAGE_FOLLOWER_ORDER, two_stage_follower_model_x, self->state_x,
                  self->scratch_x);
        /* a stable model of a machine within its limits; it stays finite however long it runs alone */
        SG_PRAGMA("MUST_ITERATE(3, 3)")
        for (int i = 0; i < TWO_STAGE_FOLLOWER_ORDER; i++) {
            self->state_x[i] =
                sg_bound(self->scratch_x[i] + (two_stage_follower_input_x[i] * self->command_x),
                         -two_stage_follower_bound_x[i], two_stage_follower_bound_x[i]);
        }
    }
    {
        /* between two points of the path, all of them within its limits */
        const sg_real reference =
            sg_bound(two_stage_follower_point(self, self->path_y), -two_stage_follower_end_y, two_stage_follower_end_y);
        const sg_real taken = sg_dot(TWO_STAGE_FOLLOWER_ORDER, two_stage_follower_row_y, self->state_y) +
                              (two_stage_follower_direct_y * self->command_y);
        out->reference_y = reference;
        out->command_y = sg_clamp(reference - taken, -two_stage_follower_limit_y, two_stage_follower_limit_y);
        sg_matvec(TWO_STAGE_FOLLOWER_ORDER, TWO_STAGE_FOLLOWER_ORDER, two_stage_follower_model_y, self->state_y,
                  self->scratch_y);
        /* a stable model of a machine within its limits; it stays finite however long it runs alone */
        SG_PRAGMA("MUST_ITERATE(3, 3)")
        for (int i = 0; i < TWO_STAGE_FOLLOWER_ORDER; i++) {
            self->state_y[i] =
                sg_bound(self->scratch_y[i] + (two_stage_follower_input_y[i] * self->command_y),
                         -two_stage_follower_bound_y[i], two_stage_follower_bound_y[i]);
        }
    }
    out->along = self->along;
    if (self->done < TWO_STAGE_FOLLOWER_POINTS) {
        /* never backwards: the feed is planned between 0 and 1 at both ends and in the middle */
        self->along = sg_min(sg_bound_below(self->along + two_stage_follower_rate(self), (sg_real)0),
                             (sg_real)self->current);
        self->done = self->done + 1;
    }
    if (self->done == TWO_STAGE_FOLLOWER_POINTS) {
        self->along = (sg_real)self->current;
    }
}
