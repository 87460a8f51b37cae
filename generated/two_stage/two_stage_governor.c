/* SPDX-License-Identifier: MIT */
/*
 * Made by servogen 0.1.0 from governor.c.jinja; not to be edited.
 * Design 2df8fd9b7b96227c8a47a2bccc487b135ad72d7fa713a19599e6540c03996ab1.
 *
 * Spatial reference governor (14)-(15), both axes
 *
 * Counted in this C, calls of other files included (servogen wcet): operations on two_stage_real, bytes
 * of C objects on the stack. Constant tables of this file: 408 bytes.
 *
 * worst case of one call   add mul div  cmp other load store stack
 * two_stage_governor_init    0   0   0    0     0    0   604    24
 * two_stage_governor_step 1928 396   0 4016   632 5403   742   404
 */
#include "two_stage_governor.h"
#include "two_stage_scalar.h"
#include "two_stage_governor_tables.h"

/* What a state allows on one axis; positions and references relative to the position. */
typedef struct {
    sg_real least;    /* (14b): least reference */
    sg_real greatest; /* (14b): greatest reference */
    sg_real reach;    /* fast stage range */
    sg_real ahead;    /* position at the end of the interval for a reference of zero */
    sg_real slope;    /* and what a reference adds to it */
} two_stage_governor_axis;

/* (13) for a given state leaves an interval of references; `keep` is the share of the bounds. */
static void two_stage_governor_section(int pairs, const sg_real *restrict rows, const sg_real *restrict shift,
                            const sg_real *restrict bound, sg_real origin,
                            const sg_real *restrict rest, sg_real keep, sg_real *restrict centre,
                            two_stage_governor_axis *restrict axis)
{
    sg_matvec(pairs, TWO_STAGE_GOVERNOR_ORDER - 1, rows, rest, centre);
    axis->least = -SG_REAL_MAX;
    axis->greatest = SG_REAL_MAX;
    SG_PRAGMA("MUST_ITERATE(1)")
    for (int i = 0; i < pairs; i++) {
        const sg_real middle = centre[i] + (shift[i] * origin);
        const sg_real half = bound[i] * keep;
        axis->least = sg_max(axis->least, -half - middle);
        axis->greatest = sg_min(axis->greatest, half - middle);
    }
}

/* (14b)-(14d) of one axis for one eta: its last point, least and greatest coordinate. */
static int32_t two_stage_governor_axis_allows(const two_stage_governor_axis *axis, sg_real origin, sg_real point,
                                   sg_real least, sg_real greatest)
{
    int32_t allowed = 1;
    const sg_real reference = point - origin;
    const sg_real lowest = least - origin;
    const sg_real highest = greatest - origin;
    if (reference < axis->least) {
        allowed = 0;
    }
    if (reference > axis->greatest) {
        allowed = 0;
    }
    if (highest > axis->reach) {
        allowed = 0;
    }
    if (lowest < -axis->reach) {
        allowed = 0;
    }
    const sg_real ahead = axis->ahead + (axis->slope * reference);
    if ((highest - ahead) > axis->reach) {
        allowed = 0;
    }
    if ((lowest - ahead) < -axis->reach) {
        allowed = 0;
    }
    return allowed;
}

static void two_stage_governor_axis_x(const two_stage_governor_step_in *in, sg_real keep, two_stage_governor_axis *axis)
{
    sg_real centre[TWO_STAGE_GOVERNOR_PAIRS_X];
    sg_real rest[TWO_STAGE_GOVERNOR_ORDER - 1];
    rest[0] = in->x_velocity;
    rest[1] = in->x_acceleration;
    two_stage_governor_section(TWO_STAGE_GOVERNOR_PAIRS_X, two_stage_governor_rows_x, two_stage_governor_shift_x,
                    two_stage_governor_bound_x, in->x_position, rest, keep, centre, axis);
    axis->reach = two_stage_governor_range_x * keep;
    axis->ahead = sg_dot(TWO_STAGE_GOVERNOR_ORDER - 1, two_stage_governor_ahead_x, rest);
    axis->slope = two_stage_governor_ahead_reference_x;
}

static void two_stage_governor_axis_y(const two_stage_governor_step_in *in, sg_real keep, two_stage_governor_axis *axis)
{
    sg_real centre[TWO_STAGE_GOVERNOR_PAIRS_Y];
    sg_real rest[TWO_STAGE_GOVERNOR_ORDER - 1];
    rest[0] = in->y_velocity;
    rest[1] = in->y_acceleration;
    two_stage_governor_section(TWO_STAGE_GOVERNOR_PAIRS_Y, two_stage_governor_rows_y, two_stage_governor_shift_y,
                    two_stage_governor_bound_y, in->y_position, rest, keep, centre, axis);
    axis->reach = two_stage_governor_range_y * keep;
    axis->ahead = sg_dot(TWO_STAGE_GOVERNOR_ORDER - 1, two_stage_governor_ahead_y, rest);
    axis->slope = two_stage_governor_ahead_reference_y;
}

/* Greatest eta of 0..n_points that both axes allow, -1 if none does (14a). */
static int32_t two_stage_governor_search(const two_stage_governor_t *self, const two_stage_governor_step_in *in, sg_real keep,
                              int32_t n_points)
{
    two_stage_governor_axis x;
    two_stage_governor_axis y;
    int32_t taken = -1;
    two_stage_governor_axis_x(in, keep, &x);
    two_stage_governor_axis_y(in, keep, &y);
    SG_PRAGMA("MUST_ITERATE(1, 151)")
    for (int back = 0; back < TWO_STAGE_GOVERNOR_CHOICES; back++) {
        const int32_t eta = TWO_STAGE_GOVERNOR_POINTS - back;
        int32_t allowed = (eta <= n_points) ? 1 : 0;
        if (allowed == 1) {
            const int32_t last = (eta == 0) ? 0 : (eta - 1);
            const sg_real here_x = (eta == 0) ? in->last_x : in->points_x[last];
            const sg_real here_y = (eta == 0) ? in->last_y : in->points_y[last];
            allowed = two_stage_governor_axis_allows(&x, in->x_position, here_x, self->least_x[eta],
                                          self->greatest_x[eta]);
            if (allowed == 1) {
                allowed = two_stage_governor_axis_allows(&y, in->y_position, here_y, self->least_y[eta],
                                              self->greatest_y[eta]);
            }
        }
        if (allowed == 1) {
            taken = eta;
            break;
        }
    }
    return taken;
}

/* Least and greatest coordinate of the first 0..n_points points, the last one taken included; that
 * one is bounded even where it is not in range (a NaN becomes the lower limit). */
static void two_stage_governor_extremes(two_stage_governor_t *self, const two_stage_governor_step_in *in, int32_t n_points)
{
    self->least_x[0] = sg_clamp_any(in->last_x, -two_stage_governor_limit_x, two_stage_governor_limit_x);
    self->greatest_x[0] = self->least_x[0];
    self->least_y[0] = sg_clamp_any(in->last_y, -two_stage_governor_limit_y, two_stage_governor_limit_y);
    self->greatest_y[0] = self->least_y[0];
    SG_PRAGMA("MUST_ITERATE(150, 150)")
    for (int i = 0; i < TWO_STAGE_GOVERNOR_POINTS; i++) {
        if (i < n_points) {
            self->least_x[i + 1] = sg_min(self->least_x[i], in->points_x[i]);
            self->greatest_x[i + 1] = sg_max(self->greatest_x[i], in->points_x[i]);
            self->least_y[i + 1] = sg_min(self->least_y[i], in->points_y[i]);
            self->greatest_y[i + 1] = sg_max(self->greatest_y[i], in->points_y[i]);
        }
    }
}

void two_stage_governor_init(two_stage_governor_t *self)
{
    sg_fill(TWO_STAGE_GOVERNOR_CHOICES, (sg_real)0, self->least_x);
    sg_fill(TWO_STAGE_GOVERNOR_CHOICES, (sg_real)0, self->greatest_x);
    sg_fill(TWO_STAGE_GOVERNOR_CHOICES, (sg_real)0, self->least_y);
    sg_fill(TWO_STAGE_GOVERNOR_CHOICES, (sg_real)0, self->greatest_y);
}

sg_status two_stage_governor_step(two_stage_governor_t *self, const two_stage_governor_step_in *in, two_stage_governor_step_out *out)
{
    sg_status status = SG_OK;
    int32_t taken = 0;
    /*@ dynamic_split status; */
    status = sg_worse(status, sg_check(in->x_position, -0.6000000000000001, 0.6000000000000001));
    status = sg_worse(status, sg_check(in->x_velocity, -2.8, 2.8));
    status = sg_worse(status, sg_check(in->x_acceleration, -58.84, 58.84));
    status = sg_worse(status, sg_check(in->y_position, -0.6000000000000001, 0.6000000000000001));
    status = sg_worse(status, sg_check(in->y_velocity, -2.8, 2.8));
    status = sg_worse(status, sg_check(in->y_acceleration, -58.84, 58.84));
    status = sg_worse(status, sg_check(in->last_x, -0.4, 0.4));
    status = sg_worse(status, sg_check(in->last_y, -0.4, 0.4));
    status = sg_worse(status, sg_check_array(150, in->points_x, -0.4, 0.4));
    status = sg_worse(status, sg_check_array(150, in->points_y, -0.4, 0.4));
    if (in->n_points < 0) {
        status = sg_worse(status, SG_OUT_OF_RANGE);
    }
    if (in->n_points > 150) {
        status = sg_worse(status, SG_OUT_OF_RANGE);
    }
    two_stage_governor_extremes(self, in, 0);
    if (status == SG_OK) {
        two_stage_governor_extremes(self, in, in->n_points);
        taken = two_stage_governor_search(self, in, two_stage_governor_keep, in->n_points);
        if (taken < 0) {
            taken = two_stage_governor_search(self, in, (sg_real)1, 0);
            status = (taken < 0) ? SG_INFEASIBLE : SG_OK;
            taken = 0;
        }
    }
    const int32_t last = (taken == 0) ? 0 : (taken - 1);
    out->points_taken = taken;
    out->reference_x = (taken == 0) ? self->least_x[0] : in->points_x[last];
    out->low_x = self->least_x[taken];
    out->high_x = self->greatest_x[taken];
    out->reference_y = (taken == 0) ? self->least_y[0] : in->points_y[last];
    out->low_y = self->least_y[taken];
    out->high_y = self->greatest_y[taken];
    /*@ merge status; */
    return status;
}
