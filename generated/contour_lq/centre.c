/* SPDX-License-Identifier: MIT */
/*
 * Made by servogen 0.1.0 from contour_lq.c.jinja; not to be edited.
 * Design 57e8c839fdacd1111a3d54d19166de3db0812a4643fcf0fa37d321135b5a91fd.
 *
 * Receding-horizon LQ contour control (11)-(13), gains computed on line
 *
 * Counted in this C, calls of other files included (servogen wcet): operations on centre_real, bytes
 * of C objects on the stack. Constant tables of this file: 2080 bytes.
 *
 * worst case of one call add mul div cmp other load store stack
 * centre_init              0   0   0   0     0    0    14    20
 * centre_reset             0   0   0  10     0    4    16    56
 * centre_step            770 971  29 402    94 2249   707  1028
 * centre_follow          716 921  29 400    78 2129   679  1032
 */
#include "centre.h"
#include "centre_scalar.h"
#include "sg_quotient.h"
#include "centre_tables.h"

/* The filter's correction by a measurement, in the axis x. */
static void centre_measure_x(centre_t *self, sg_real here)
{
    const sg_real innovation = (here - self->last[0]) - self->ahead[0];
    sg_real *const hidden = &self->hidden[0];
    SG_PRAGMA("MUST_ITERATE(2, 2)")
    for (int i = 0; i < CENTRE_HIDDEN_X; i++) {
        hidden[i] = sg_clamp(hidden[i] + (centre_hidden_gain_x[i] * innovation), -centre_hidden_bound, centre_hidden_bound);
    }
    self->ahead[0] = sg_clamp(centre_gain_x * innovation, -centre_twice_reach, centre_twice_reach);
    self->last[0] = here;
}

/* What it expects of the next sample, under a command that is held till then. */
static void centre_predict_x(centre_t *self, sg_real command)
{
    const sg_real position = self->last[0] + self->ahead[0];
    sg_real ahead = (self->ahead[0] + (centre_drift_x * position)) + (centre_drive_x * command);
    sg_real *const hidden = &self->hidden[0];
    sg_real moved[CENTRE_HIDDEN_X];
    ahead += sg_dot(CENTRE_HIDDEN_X, centre_hidden_moves_x, hidden);
    sg_matvec(CENTRE_HIDDEN_X, CENTRE_HIDDEN_X, centre_on_hidden_x, hidden, moved);
    SG_PRAGMA("MUST_ITERATE(2, 2)")
    for (int i = 0; i < CENTRE_HIDDEN_X; i++) {
        const sg_real driven = (centre_hidden_drift_x[i] * position) + (centre_hidden_drive_x[i] * command);
        hidden[i] = sg_clamp(moved[i] + driven, -centre_hidden_bound, centre_hidden_bound);
    }
    self->ahead[0] = sg_clamp(ahead, -centre_twice_reach, centre_twice_reach);
}

/* The filter's correction by a measurement, in the axis y. */
static void centre_measure_y(centre_t *self, sg_real here)
{
    const sg_real innovation = (here - self->last[1]) - self->ahead[1];
    sg_real *const hidden = &self->hidden[2];
    SG_PRAGMA("MUST_ITERATE(4, 4)")
    for (int i = 0; i < CENTRE_HIDDEN_Y; i++) {
        hidden[i] = sg_clamp(hidden[i] + (centre_hidden_gain_y[i] * innovation), -centre_hidden_bound, centre_hidden_bound);
    }
    self->ahead[1] = sg_clamp(centre_gain_y * innovation, -centre_twice_reach, centre_twice_reach);
    self->last[1] = here;
}

/* What it expects of the next sample, under a command that is held till then. */
static void centre_predict_y(centre_t *self, sg_real command)
{
    const sg_real position = self->last[1] + self->ahead[1];
    sg_real ahead = (self->ahead[1] + (centre_drift_y * position)) + (centre_drive_y * command);
    sg_real *const hidden = &self->hidden[2];
    sg_real moved[CENTRE_HIDDEN_Y];
    ahead += sg_dot(CENTRE_HIDDEN_Y, centre_hidden_moves_y, hidden);
    sg_matvec(CENTRE_HIDDEN_Y, CENTRE_HIDDEN_Y, centre_on_hidden_y, hidden, moved);
    SG_PRAGMA("MUST_ITERATE(4, 4)")
    for (int i = 0; i < CENTRE_HIDDEN_Y; i++) {
        const sg_real driven = (centre_hidden_drift_y[i] * position) + (centre_hidden_drive_y[i] * command);
        hidden[i] = sg_clamp(moved[i] + driven, -centre_hidden_bound, centre_hidden_bound);
    }
    self->ahead[1] = sg_clamp(ahead, -centre_twice_reach, centre_twice_reach);
}

/* Whether `here` is apart from the last distinct point; then it is that, and reached by a new direction. */
static int32_t centre_go_on(const sg_real *restrict here, sg_real *restrict point, sg_real *restrict direction)
{
    sg_real way[CENTRE_AXES];
    sg_real farthest = (sg_real)0;
    int32_t fresh = 0;
    SG_PRAGMA("MUST_ITERATE(2, 2)")
    for (int i = 0; i < CENTRE_AXES; i++) {
        way[i] = here[i] - point[i];
        farthest = sg_max(farthest, sg_max(way[i], -way[i]));
    }
    if (farthest > centre_apart) {
        const sg_real scale = SG_DIVIDE((sg_real)1, farthest);
        fresh = 1;
        SG_PRAGMA("MUST_ITERATE(2, 2)")
        for (int i = 0; i < CENTRE_AXES; i++) {
            direction[i] = sg_bound(way[i] * scale, (sg_real)-2, (sg_real)2); /* one, and a rounding */
            point[i] = here[i];
        }
    }
    return fresh;
}

/* By which direction a point is reached, its square, and whether the point before is another one. */
typedef struct {
    sg_real direction[CENTRE_AXES];
    sg_real square;
    int32_t fresh;
} centre_course;

/* Of all points, and the course up to the present one to the state. How many have a direction: with the
 * first one that is found all of them do. */
static int32_t centre_reach(centre_t *self, const sg_real *points, centre_course *reached)
{
    sg_real point[CENTRE_AXES];
    sg_real direction[CENTRE_AXES];
    (void)centre_go_on(points, self->point, self->direction);
    sg_copy(CENTRE_AXES, self->point, point);
    sg_copy(CENTRE_AXES, self->direction, direction);
    sg_copy(CENTRE_AXES, direction, reached[0].direction);
    reached[0].square = sg_dot(CENTRE_AXES, direction, direction);
    reached[0].fresh = 0;
    SG_PRAGMA("MUST_ITERATE(10, 10)")
    for (int32_t j = 1; j <= CENTRE_PREVIEW; j++) {
        reached[j].fresh = centre_go_on(&points[j * CENTRE_AXES], point, direction);
        sg_copy(CENTRE_AXES, direction, reached[j].direction);
        reached[j].square = sg_dot(CENTRE_AXES, direction, direction);
    }
    return (reached[CENTRE_PREVIEW].square > (sg_real)0) ? CENTRE_PREVIEW : 0;
}

/* 1 - share. In one step libgcc's double subtraction for ARM rounds it the wrong way for some shares next to
 * 2^-33. */
static sg_real centre_rest(sg_real share)
{
    return ((sg_real)0.75 - share) + (sg_real)0.25;
}

/* The tangent between the directions by which a point is reached, which may not be known yet, and left;
 * returns 1 - c^2, whose square is 1 - phi. */
static sg_real centre_between(const centre_course *reached, const centre_course *left, sg_real *middle)
{
    const centre_course *const before = (reached->square > (sg_real)0) ? reached : left;
    const sg_real cosine = sg_dot(CENTRE_AXES, before->direction, left->direction);
    const sg_real side = (cosine >= (sg_real)0) ? (sg_real)1 : (sg_real)-1; /* r r' has no sign */
    const sg_real squares = sg_bound_below(before->square * left->square, centre_least_square);
    const sg_real squared = SG_DIVIDE(cosine * cosine, squares);
    SG_PRAGMA("MUST_ITERATE(2, 2)")
    for (int i = 0; i < CENTRE_AXES; i++) {
        middle[i] = before->direction[i] + (side * left->direction[i]);
    }
    return centre_rest(squared);
}

/* Tangents t, an axis after the other, and the prices of sliding along them. */
static void centre_tangents(const centre_course *reached, sg_real *restrict along, sg_real *restrict price)
{
    const centre_course *left = &reached[CENTRE_PREVIEW];
    SG_PRAGMA("MUST_ITERATE(9, 9)")
    for (int32_t j = CENTRE_SLIDES; j > 0; j--) {
        sg_real middle[CENTRE_AXES];
        const sg_real turned = centre_between(&reached[j], left, middle);
        const sg_real lost = turned * turned;
        const sg_real phi = centre_rest(lost);
        const sg_real dear = centre_least_price + ((centre_share * lost) * ((sg_real)1 + phi));
        SG_PRAGMA("MUST_ITERATE(2, 2)")
        for (int32_t i = 0; i < CENTRE_AXES; i++) {
            along[(i * CENTRE_SLIDES) + (j - 1)] = middle[i] * phi;
        }
        price[j - 1] = sg_dot(CENTRE_AXES, middle, middle) * dear;
        if (reached[j].fresh == 1) {
            left = &reached[j];
        }
    }
}

/* Lower triangle of price + sum of T P T, column after column. */
static void centre_stiffness(const sg_real *restrict along, const sg_real *restrict price, sg_real *restrict matrix)
{
    const sg_real *const x = &along[0];
    const sg_real *const y = &along[9];
    SG_PRAGMA("MUST_ITERATE(9, 9)")
    for (int32_t k = 0; k < CENTRE_SLIDES; k++) {
        for (int32_t i = k; i < CENTRE_SLIDES; i++) {
            const int32_t at = (k * CENTRE_SLIDES) + i;
            matrix[at] = ((centre_stiffness_x[at] * x[i]) * x[k]) + ((centre_stiffness_y[at] * y[i]) * y[k]);
        }
        matrix[(k * CENTRE_SLIDES) + k] += price[k];
    }
}

/* The right side: errors that the plan without slides leaves, along the tangents. */
static void centre_errors(const sg_real *restrict given, const sg_real *restrict along, sg_real *restrict right)
{
    sg_real error[CENTRE_SLIDES];
    const sg_real *const x = &along[0];
    sg_matvec(CENTRE_SLIDES, CENTRE_GIVEN_X, centre_error_x, &given[0], error);
    SG_PRAGMA("MUST_ITERATE(9, 9)")
    for (int32_t i = 0; i < CENTRE_SLIDES; i++) {
        right[i] = x[i] * error[i];
    }
    const sg_real *const y = &along[9];
    sg_matvec(CENTRE_SLIDES, CENTRE_GIVEN_Y, centre_error_y, &given[13], error);
    SG_PRAGMA("MUST_ITERATE(9, 9)")
    for (int32_t i = 0; i < CENTRE_SLIDES; i++) {
        right[i] = right[i] + (y[i] * error[i]);
    }
}

/* L D L' of the matrix, column by column, and the slides in place of the right side. No pivot is below the
 * least price; nor does anything come near the other bounds but by rounding of a hopeless matrix. */
static void centre_solve(sg_real *restrict matrix, sg_real *restrict s)
{
    sg_real inverse[CENTRE_SLIDES];
    sg_real column[CENTRE_SLIDES];
    sg_fill(CENTRE_SLIDES, (sg_real)0, column);
    SG_PRAGMA("MUST_ITERATE(9, 9)")
    for (int32_t k = 0; k < CENTRE_SLIDES; k++) {
        sg_real *const own = &matrix[k * CENTRE_SLIDES];
        inverse[k] = SG_DIVIDE((sg_real)1, sg_max(own[k], centre_least_price));
        s[k] = sg_bound(s[k], -centre_farthest, centre_farthest);
        for (int32_t i = k + 1; i < CENTRE_SLIDES; i++) {
            column[i] = sg_bound(own[i], -centre_stiffest, centre_stiffest);
            own[i] = column[i] * inverse[k];
            s[i] -= own[i] * s[k];
        }
        for (int32_t j = k + 1; j < CENTRE_SLIDES; j++) {
            sg_real *const rest = &matrix[j * CENTRE_SLIDES];
            for (int32_t i = j; i < CENTRE_SLIDES; i++) {
                rest[i] -= own[i] * column[j];
            }
        }
    }
    SG_PRAGMA("MUST_ITERATE(9, 9)")
    for (int32_t k = 0; k < CENTRE_SLIDES; k++) {
        s[k] = s[k] * inverse[k];
    }
    SG_PRAGMA("MUST_ITERATE(9, 9)")
    for (int32_t k = CENTRE_SLIDES - 1; k >= 0; k--) {
        s[k] = sg_bound(s[k], -centre_farthest, centre_farthest);
        for (int32_t i = 0; i < k; i++) {
            s[i] -= matrix[(i * CENTRE_SLIDES) + k] * s[k];
        }
    }
}

/* What the slides add to the first input of an axis. */
static sg_real centre_slid(const sg_real *restrict slide, const sg_real *restrict along, const sg_real *restrict s)
{
    sg_real sum = (slide[0] * along[0]) * s[0];
    for (int32_t i = 1; i < CENTRE_SLIDES; i++) {
        sum += (slide[i] * along[i]) * s[i];
    }
    return sum;
}

/* The contour's share of the commands; returns how many points have a direction. */
static int32_t centre_contour(centre_t *self, const sg_real *points, const sg_real *given, sg_real *command)
{
    centre_course reached[CENTRE_PREVIEW + 1];
    const int32_t known = centre_reach(self, points, reached);
    if (known > 0) {
        sg_real along[CENTRE_AXES * CENTRE_SLIDES];
        sg_real price[CENTRE_SLIDES];
        sg_real matrix[CENTRE_SLIDES * CENTRE_SLIDES];
        sg_real s[CENTRE_SLIDES];
        centre_tangents(reached, along, price);
        centre_stiffness(along, price, matrix);
        centre_errors(given, along, s);
        centre_solve(matrix, s);
        command[0] += centre_slid(centre_slide_x, &along[0], s);
        command[1] += centre_slid(centre_slide_y, &along[9], s);
    }
    return known;
}

/* References of an axis less its position, and that. */
static void centre_relative(int32_t axis, const sg_real *points, sg_real last, sg_real ahead, sg_real *own)
{
    SG_PRAGMA("MUST_ITERATE(10, 10)")
    for (int32_t j = 0; j < CENTRE_PREVIEW; j++) {
        own[j] = (points[((j + 1) * CENTRE_AXES) + axis] - last) - ahead;
    }
    own[CENTRE_PREVIEW] = last + ahead;
}

/* What the tables take: references less the position, the position, the hidden states. */
static void centre_gather(const sg_real *points, const sg_real *last, const sg_real *ahead, const sg_real *hidden, sg_real *given)
{
    centre_relative(0, points, last[0], ahead[0], &given[0]);
    sg_copy(CENTRE_HIDDEN_X, &hidden[0], &given[11]);
    centre_relative(1, points, last[1], ahead[1], &given[13]);
    sg_copy(CENTRE_HIDDEN_Y, &hidden[2], &given[24]);
}

/* Commands for points and a state that are in range; returns how many of the points have a direction. */
static int32_t centre_command(centre_t *self, const sg_real *points, const sg_real *last, const sg_real *ahead, const sg_real *hidden, sg_real *command)
{
    sg_real given[CENTRE_GIVEN];
    centre_gather(points, last, ahead, hidden, given);
    command[0] = sg_dot(CENTRE_GIVEN_X, centre_first_x, &given[0]);
    command[1] = sg_dot(CENTRE_GIVEN_Y, centre_first_y, &given[13]);
    if (self->begun == 0) {
        sg_copy(CENTRE_AXES, points, self->point);
        self->begun = 1;
    }
    return centre_contour(self, points, given, command);
}

/* A velocity that is held would run an axis into its end. */
static void centre_stop(centre_step_out *out)
{
    sg_fill(CENTRE_AXES, (sg_real)0, out->command);
    out->limited = 0;
    out->known = 0;
}

/* The worst of a sample's inputs decides: commands within their limits, or zero. */
static sg_status centre_answer(centre_t *self, sg_status worst, const sg_real *points, const sg_real *last, const sg_real *ahead, const sg_real *hidden, centre_step_out *out)
{
    sg_status status = worst;
    centre_stop(out);
    if (status == SG_OK) {
        sg_real command[CENTRE_AXES];
        out->known = centre_command(self, points, last, ahead, hidden, command);
        out->command[0] = sg_clamp(command[0], -centre_limit_x, centre_limit_x);
        if (out->command[0] != command[0]) {
            out->limited += 1;
        }
        out->command[1] = sg_clamp(command[1], -centre_limit_y, centre_limit_y);
        if (out->command[1] != command[1]) {
            out->limited += 1;
        }
        status = (out->known > 0) ? SG_OK : SG_PRIMING;
    }
    return status;
}

/* What is measured corrects the filter, if it is usable. */
static sg_status centre_measure(centre_t *self, const centre_step_in *in)
{
    sg_status status = SG_OK;
    /*@ dynamic_split status; */
    status = sg_worse(status, sg_check_array(2, in->position, -0.05f, 0.05f));
    if (status == SG_OK) {
        centre_measure_x(self, in->position[0]);
        centre_measure_y(self, in->position[1]);
    }
    /*@ merge status; */
    return status;
}

/* What is wanted answers it, if both are. */
static sg_status centre_pursue(centre_t *self, const centre_step_in *in, sg_status seen, centre_step_out *out)
{
    sg_status status = seen;
    /*@ dynamic_split status; */
    status = sg_worse(status, sg_check_array(22, in->reference, -0.05f, 0.05f));
    status = centre_answer(self, status, in->reference, self->last, self->ahead, self->hidden, out);
    /*@ merge status; */
    return status;
}

void centre_init(centre_t *self)
{
    sg_fill(CENTRE_AXES, (sg_real)0, self->last);
    sg_fill(CENTRE_AXES, (sg_real)0, self->ahead);
    sg_fill(CENTRE_HIDDEN, (sg_real)0, self->hidden);
    sg_fill(CENTRE_AXES, (sg_real)0, self->point);
    sg_fill(CENTRE_AXES, (sg_real)0, self->direction);
    self->begun = 0;
    self->ready = 0;
}

sg_status centre_reset(centre_t *self, const centre_reset_in *in)
{
    sg_status status = SG_OK;
    /*@ dynamic_split status; */
    status = sg_worse(status, sg_check_array(2, in->position, -0.05f, 0.05f));
    centre_init(self);
    if (status == SG_OK) {
        self->ready = 1;
        sg_copy(CENTRE_AXES, in->position, self->last);
    }
    /*@ merge status; */
    return status;
}

sg_status centre_step(centre_t *self, const centre_step_in *in, centre_step_out *out)
{
    sg_status status = SG_NOT_READY;
    if (self->ready == 1) {
        status = centre_pursue(self, in, centre_measure(self, in), out);
        centre_predict_x(self, out->command[0]);
        centre_predict_y(self, out->command[1]);
    } else {
        centre_stop(out);
    }
    return status;
}

sg_status centre_follow(centre_t *self, const centre_follow_in *in, centre_follow_out *out)
{
    centre_step_out told;
    sg_real ahead[CENTRE_AXES];
    sg_status status = SG_OK;
    /*@ dynamic_split status; */
    status = sg_worse(status, sg_check_array(2, in->position, -0.05f, 0.05f));
    status = sg_worse(status, sg_check_array(6, in->hidden, -2.0f, 2.0f));
    status = sg_worse(status, sg_check_array(22, in->reference, -0.05f, 0.05f));
    if (self->ready == 0) {
        status = SG_NOT_READY;
    }
    sg_fill(CENTRE_AXES, (sg_real)0, ahead);
    status = centre_answer(self, status, in->reference, in->position, ahead, in->hidden, &told);
    sg_copy(CENTRE_AXES, told.command, out->command);
    out->limited = told.limited;
    out->known = told.known;
    /*@ merge status; */
    return status;
}
