/* SPDX-License-Identifier: MIT */
/*
 * Made by servogen 0.1.0 from command_governor.c.jinja; not to be edited.
 * Design db73e1a8671115da28984cf35db7dd65b73d330d546f213644560d85ebcdbb92.
 *
 * Extended command governor (17)-(18), (21), both axes
 *
 * Counted in this C, calls of other files included (servogen wcet): operations on etcher_real, bytes
 * of C objects on the stack. Constant tables of this file: 48 bytes.
 *
 * worst case of one call                     add     mul   div     cmp  other    load  store stack
 * etcher_init                                  0       0     0       0      0       0   7692    52
 * etcher_reset                                 0       0     0      16      2      12     96   132
 * etcher_predict                              24      24     0      30      0      96     60   300
 * etcher_step                            1491736 1392882 22088 1212686 193562 3577326 490486  3456
 *   fixed part                            180346  174102    38  603746   5372 1105296  53446
 *   each of 45 ETCHER_AXIS_ITERATION_CAP   29142   27084   490   13532   4182   54934   9712
 */
#include "etcher.h"
#include "etcher_scalar.h"
#include "etcher_tables.h"

/* Points in reach. */
typedef struct {
    sg_real least_x;
    sg_real greatest_x;
    sg_real least_y;
    sg_real greatest_y;
} etcher_box;

/* What a period goes by: the states, and how many of the points given. */
typedef struct {
    sg_real x[ETCHER_ORDER];
    sg_real y[ETCHER_ORDER];
    int32_t count;
} etcher_seen;

/* A point by its number from the last one machined, which is 0. */
static sg_real etcher_at(sg_real last, const sg_real *points, int32_t number)
{
    const int32_t at = sg_bound_count(number, 0, ETCHER_WINDOW); /* as indices are */
    return (at == 0) ? last : points[at - 1];
}

/* Whether it is, the point with this number. */
static int32_t etcher_inside(const etcher_t *self, const etcher_step_in *in, int32_t number,
                              const etcher_box *box)
{
    int32_t inside = 1;
    const sg_real x = etcher_at(self->last_x, in->points_x, number);
    if (x < box->least_x) {
        inside = 0;
    }
    if (x > box->greatest_x) {
        inside = 0;
    }
    const sg_real y = etcher_at(self->last_y, in->points_y, number);
    if (y < box->least_y) {
        inside = 0;
    }
    if (y > box->greatest_y) {
        inside = 0;
    }
    return inside;
}

/* The first `count` of the window; the rest is not read. */
static sg_status etcher_check(int32_t count, const sg_real *points, sg_real limit)
{
    const sg_real low = -limit;
    sg_status worst = SG_OK;
    SG_PRAGMA("MUST_ITERATE(1, 8000)")
    for (int32_t i = 0; i < ETCHER_WINDOW; i++) {
        if (i >= count) {
            break;
        }
        const sg_status here = sg_check(points[i], low, limit);
        if (worst == SG_OK) {
            worst = here;
        }
        if (here == SG_NOT_FINITE) {
            worst = here;
        }
    }
    return worst;
}

/* A point that was checked before, as the proof can see too. */
static sg_real etcher_checked(sg_real point, sg_real limit)
{
    return sg_clamp_any(point, -limit, limit);
}

/* Where the stage is: as measured, or where its own model expects it if that is no use. */
static sg_status etcher_look_x(const etcher_t *self, const etcher_step_in *in, etcher_seen *seen)
{
    sg_status status = SG_OK;
    /*@ dynamic_split status; */
    status = sg_worse(status, sg_check(in->x_position, -0.375, 0.375));
    status = sg_worse(status, sg_check(in->x_velocity, -0.4, 0.4));
    status = sg_worse(status, sg_check(in->x_acceleration, -40.0, 40.0));
    seen->x[0] = (status == SG_OK) ? in->x_position : self->x.predicted[0];
    seen->x[1] = (status == SG_OK) ? in->x_velocity : self->x.predicted[1];
    seen->x[2] = (status == SG_OK) ? in->x_acceleration : self->x.predicted[2];
    /*@ merge status; */
    return status;
}

/* Where the stage is: as measured, or where its own model expects it if that is no use. */
static sg_status etcher_look_y(const etcher_t *self, const etcher_step_in *in, etcher_seen *seen)
{
    sg_status status = SG_OK;
    /*@ dynamic_split status; */
    status = sg_worse(status, sg_check(in->y_position, -0.375, 0.375));
    status = sg_worse(status, sg_check(in->y_velocity, -0.4, 0.4));
    status = sg_worse(status, sg_check(in->y_acceleration, -40.0, 40.0));
    seen->y[0] = (status == SG_OK) ? in->y_position : self->y.predicted[0];
    seen->y[1] = (status == SG_OK) ? in->y_velocity : self->y.predicted[1];
    seen->y[2] = (status == SG_OK) ? in->y_acceleration : self->y.predicted[2];
    /*@ merge status; */
    return status;
}

/* What is in reach, from these states: of every interval, and so far of itself alone. */
static void etcher_foresee(etcher_t *self, const etcher_seen *seen)
{
    etcher_axis_foresee_in ask_x;
    etcher_axis_foresee_out told_x;
    ask_x.position = seen->x[0];
    ask_x.velocity = seen->x[1];
    ask_x.acceleration = seen->x[2];
    (void)etcher_axis_foresee(&self->x, &ask_x, &told_x); /* checked before */
    sg_copy(ETCHER_INTERVALS, told_x.least, self->least_x);
    sg_copy(ETCHER_INTERVALS, told_x.least, self->least_on_x);
    sg_copy(ETCHER_INTERVALS, told_x.greatest, self->greatest_x);
    sg_copy(ETCHER_INTERVALS, told_x.greatest, self->greatest_on_x);
    etcher_axis_foresee_in ask_y;
    etcher_axis_foresee_out told_y;
    ask_y.position = seen->y[0];
    ask_y.velocity = seen->y[1];
    ask_y.acceleration = seen->y[2];
    (void)etcher_axis_foresee(&self->y, &ask_y, &told_y); /* checked before */
    sg_copy(ETCHER_INTERVALS, told_y.least, self->least_y);
    sg_copy(ETCHER_INTERVALS, told_y.least, self->least_on_y);
    sg_copy(ETCHER_INTERVALS, told_y.greatest, self->greatest_y);
    sg_copy(ETCHER_INTERVALS, told_y.greatest, self->greatest_on_y);
}

/* What is in reach from an interval on, until interval `until`. */
static void etcher_narrow(etcher_t *self, int32_t until)
{
    SG_PRAGMA("MUST_ITERATE(1, 41)")
    for (int32_t i = 0; i < ETCHER_VARIABLES; i++) {
        if (i >= until) {
            break;
        }
        self->least_on_x[i] = sg_max(self->least_on_x[i], self->least_x[until]);
        self->greatest_on_x[i] =
            sg_min(self->greatest_on_x[i], self->greatest_x[until]);
        self->least_on_y[i] = sg_max(self->least_on_y[i], self->least_y[until]);
        self->greatest_on_y[i] =
            sg_min(self->greatest_on_y[i], self->greatest_y[until]);
    }
}

static int32_t etcher_index(const etcher_t *self, int32_t interval)
{
    return sg_bound_count(self->indices[interval], 0, ETCHER_WINDOW); /* never more than n_points */
}

/*
 * The last point up to which all are in reach of an interval, and which the next one can begin with; -1
 * where there is none. What was planned for them is not asked again.
 */
static int32_t etcher_take(const etcher_t *self, const etcher_step_in *in, int32_t interval, int32_t count)
{
    const int32_t following = (interval < (ETCHER_INTERVALS - 2)) ? (interval + 2) : (ETCHER_INTERVALS - 1);
    const int32_t planned = self->planned[interval + 1];
    const int32_t after = self->planned[following];
    const int32_t begin = etcher_index(self, interval);
    const int32_t given = (begin > planned) ? begin : planned;
    etcher_box here;
    etcher_box next;
    int32_t ends = -1;
    here.least_x = self->least_x[interval];
    next.least_x = self->least_x[interval + 1];
    here.greatest_x = self->greatest_x[interval];
    next.greatest_x = self->greatest_x[interval + 1];
    here.least_y = self->least_y[interval];
    next.least_y = self->least_y[interval + 1];
    here.greatest_y = self->greatest_y[interval];
    next.greatest_y = self->greatest_y[interval + 1];
    SG_PRAGMA("MUST_ITERATE(1, 501)")
    for (int32_t k = 0; k < (ETCHER_POINTS + 1); k++) {
        const int32_t number = begin + k;
        int32_t open = 0;
        if (number <= count) {
            open = (number > given) ? etcher_inside(self, in, number, &here) : 1;
        }
        if (open == 0) {
            break;
        }
        int32_t good = etcher_inside(self, in, number, &next);
        if (number >= planned) {
            good = (number <= after) ? 1 : good;
        }
        ends = (good == 1) ? number : ends;
    }
    return ends;
}

/* The last of the points taken before an interval, beyond `planned`, that is in reach from then on; -1
 * where there is none. */
static int32_t etcher_stay(const etcher_t *self, const etcher_step_in *in, int32_t interval, int32_t planned)
{
    const int32_t before = etcher_index(self, interval - 1);
    const int32_t end = etcher_index(self, interval);
    const int32_t least = (before > planned) ? before : planned;
    etcher_box box;
    int32_t stays = -1;
    box.least_x = self->least_on_x[interval];
    box.greatest_x = self->greatest_on_x[interval];
    box.least_y = self->least_on_y[interval];
    box.greatest_y = self->greatest_on_y[interval];
    SG_PRAGMA("MUST_ITERATE(1, 500)")
    for (int32_t k = 0; k < ETCHER_POINTS; k++) {
        const int32_t number = end - k;
        int32_t over = 1;
        if (number > least) {
            over = etcher_inside(self, in, number, &box);
            stays = (over == 1) ? number : stays;
        }
        if (over == 1) {
            break;
        }
    }
    return stays;
}

/* The same index from one interval to another. */
static void etcher_wait(etcher_t *self, int32_t from, int32_t until, int32_t index)
{
    SG_PRAGMA("MUST_ITERATE(42, 42)")
    for (int32_t i = 0; i < ETCHER_INTERVALS; i++) {
        if (i >= from) {
            if (i <= until) {
                self->indices[i] = index;
            }
        }
    }
}

/* Take up the indices planned, from the last interval whose own they hold. */
static void etcher_rejoin(etcher_t *self, int32_t until)
{
    int32_t from = 0;
    SG_PRAGMA("MUST_ITERATE(1, 41)")
    for (int32_t i = 0; i < ETCHER_VARIABLES; i++) {
        if (i >= until) {
            break;
        }
        if (self->indices[i] <= self->planned[i + 1]) {
            from = i + 1;
        }
    }
    SG_PRAGMA("MUST_ITERATE(42, 42)")
    for (int32_t i = 0; i < ETCHER_INTERVALS; i++) {
        if (i >= from) {
            if (i <= until) {
                self->indices[i] = self->planned[i];
            }
        }
    }
}

/*
 * The largest indices, interval after interval, that end well. Where an interval can take no point with
 * which the next one can begin, the tool waits at one taken before. A point that is not in reach from
 * its interval until some other is not until a later one either: it is looked at once, and each turn ends
 * an interval or is done with the points of one. Of these there are no more than intervals ended by taking
 * points, and of failures no more than intervals ended otherwise: ROUNDS are enough.
 */
static void etcher_plan(etcher_t *self, const etcher_step_in *in, int32_t count)
{
    int32_t interval = 0;
    int32_t parts = 0;
    int32_t waiting = 0;
    self->indices[0] = 0;
    SG_PRAGMA("MUST_ITERATE(1, 82)")
    for (int round = 0; round < ETCHER_ROUNDS; round++) {
        if (interval >= ETCHER_VARIABLES) {
            break;
        }
        const int32_t next = interval + 1;
        int32_t ends = -1;
        if (waiting == 0) {
            etcher_narrow(self, next);
            ends = etcher_take(self, in, interval, count);
            if (ends > self->indices[interval]) {
                self->parts[parts] = next;
                parts = sg_bound_count(parts + 1, 0, ETCHER_VARIABLES); /* as next */
            }
        } else if (parts > 0) {
            const int32_t part = sg_bound_count(self->parts[parts - 1], 1, ETCHER_VARIABLES); /* a next */
            ends = etcher_stay(self, in, part, self->planned[next]);
            if (ends >= 0) {
                etcher_wait(self, part, interval, ends);
            } else {
                parts -= 1;
            }
        } else {
            etcher_rejoin(self, next);
            ends = self->indices[next];
        }
        waiting = 1;
        if (ends >= 0) {
            self->indices[next] = ends;
            interval = next;
            waiting = 0;
        }
    }
}

/* References (21), and positions of every interval that keep S_k. */
static void etcher_ask_x(const etcher_t *self, const etcher_step_in *in, const etcher_seen *seen,
                            etcher_axis_step_in *ask)
{
    ask->position = seen->x[0];
    ask->velocity = seen->x[1];
    ask->acceleration = seen->x[2];
    SG_PRAGMA("MUST_ITERATE(42, 42)")
    for (int32_t i = 0; i < ETCHER_INTERVALS; i++) {
        const int32_t next = (i < ETCHER_VARIABLES) ? (i + 1) : i;
        const int32_t begin = etcher_index(self, i);
        const int32_t end = etcher_index(self, next);
        sg_real greatest = etcher_at(self->last_x, in->points_x, begin);
        sg_real least = greatest;
        SG_PRAGMA("MUST_ITERATE(1, 500)")
        for (int32_t k = 0; k < ETCHER_POINTS; k++) {
            const int32_t at = begin + k; /* the point after that one */
            if (at >= end) {
                break;
            }
            greatest = sg_max(greatest, in->points_x[at]);
            least = sg_min(least, in->points_x[at]);
        }
        ask->low[i] = greatest - etcher_stroke_x;
        ask->high[i] = least + etcher_stroke_x;
        if (i < ETCHER_VARIABLES) {
            const int32_t ahead = end;
            const int32_t number = (ahead < seen->count) ? (ahead + 1) : ahead;
            ask->reference[i] = etcher_at(self->last_x, in->slow_x, number);
        }
    }
    if (self->lost == 1) { /* back to where the tool is, wherever that leads the stage by */
        const sg_real far = etcher_limit_x + etcher_stroke_x;
        sg_fill(ETCHER_VARIABLES, self->home_x, ask->reference);
        sg_fill(ETCHER_INTERVALS, -far, ask->low);
        sg_fill(ETCHER_INTERVALS, far, ask->high);
    }
}

static sg_status etcher_govern_x(etcher_t *self, const etcher_step_in *in, const etcher_seen *seen,
                                    etcher_step_out *out, int32_t *standing)
{
    etcher_axis_step_in ask;
    etcher_axis_step_out told;
    etcher_ask_x(self, in, seen, &ask);
    const sg_status status = etcher_axis_step(&self->x, &ask, &told);
    out->command_x = told.command;
    out->status_x = (int32_t)status;
    out->iterations_x = told.iterations;
    if (told.standing == 0) {
        *standing = 0;
    }
    return status;
}

/* References (21), and positions of every interval that keep S_k. */
static void etcher_ask_y(const etcher_t *self, const etcher_step_in *in, const etcher_seen *seen,
                            etcher_axis_step_in *ask)
{
    ask->position = seen->y[0];
    ask->velocity = seen->y[1];
    ask->acceleration = seen->y[2];
    SG_PRAGMA("MUST_ITERATE(42, 42)")
    for (int32_t i = 0; i < ETCHER_INTERVALS; i++) {
        const int32_t next = (i < ETCHER_VARIABLES) ? (i + 1) : i;
        const int32_t begin = etcher_index(self, i);
        const int32_t end = etcher_index(self, next);
        sg_real greatest = etcher_at(self->last_y, in->points_y, begin);
        sg_real least = greatest;
        SG_PRAGMA("MUST_ITERATE(1, 500)")
        for (int32_t k = 0; k < ETCHER_POINTS; k++) {
            const int32_t at = begin + k; /* the point after that one */
            if (at >= end) {
                break;
            }
            greatest = sg_max(greatest, in->points_y[at]);
            least = sg_min(least, in->points_y[at]);
        }
        ask->low[i] = greatest - etcher_stroke_y;
        ask->high[i] = least + etcher_stroke_y;
        if (i < ETCHER_VARIABLES) {
            const int32_t ahead = end;
            const int32_t number = (ahead < seen->count) ? (ahead + 1) : ahead;
            ask->reference[i] = etcher_at(self->last_y, in->slow_y, number);
        }
    }
    if (self->lost == 1) { /* back to where the tool is, wherever that leads the stage by */
        const sg_real far = etcher_limit_y + etcher_stroke_y;
        sg_fill(ETCHER_VARIABLES, self->home_y, ask->reference);
        sg_fill(ETCHER_INTERVALS, -far, ask->low);
        sg_fill(ETCHER_INTERVALS, far, ask->high);
    }
}

static sg_status etcher_govern_y(etcher_t *self, const etcher_step_in *in, const etcher_seen *seen,
                                    etcher_step_out *out, int32_t *standing)
{
    etcher_axis_step_in ask;
    etcher_axis_step_out told;
    etcher_ask_y(self, in, seen, &ask);
    const sg_status status = etcher_axis_step(&self->y, &ask, &told);
    out->command_y = told.command;
    out->status_y = (int32_t)status;
    out->iterations_y = told.iterations;
    if (told.standing == 0) {
        *standing = 0;
    }
    return status;
}

/* Whether the moved plans keep the tool, where it waits, in reach for ever. */
static int32_t etcher_back(const etcher_t *self, const etcher_step_in *in)
{
    int32_t back = 1;
    SG_PRAGMA("MUST_ITERATE(42, 42)")
    for (int i = 0; i < ETCHER_INTERVALS; i++) {
        etcher_box box;
        box.least_x = self->least_x[i];
        box.greatest_x = self->greatest_x[i];
        box.least_y = self->least_y[i];
        box.greatest_y = self->greatest_y[i];
        if (etcher_inside(self, in, 0, &box) == 0) {
            back = 0;
        }
    }
    return back;
}

/* What is planned is forgotten: the plans held are those of other points. */
static void etcher_forget(etcher_t *self)
{
    SG_PRAGMA("MUST_ITERATE(42, 42)")
    for (int i = 0; i < ETCHER_INTERVALS; i++) {
        self->planned[i] = 0;
    }
}

/* How many points in every interval, which nobody asks while the stages come back to the tool. */
static void etcher_share(etcher_t *self, const etcher_step_in *in, const etcher_seen *seen)
{
    etcher_foresee(self, seen);
    if (self->lost == 1) {
        self->lost = 1 - etcher_back(self, in);
    }
    SG_PRAGMA("MUST_ITERATE(42, 42)")
    for (int i = 0; i < ETCHER_INTERVALS; i++) {
        self->planned[i] = (self->planned[i] < seen->count) ? self->planned[i] : seen->count;
    }
    etcher_plan(self, in, seen->count);
}

/* Of a period that went well: whether there is no point, or none in reach. */
static sg_status etcher_told(const etcher_t *self, sg_status status, int32_t count, int32_t standing)
{
    sg_status told = status;
    if (status < SG_BACKUP) {
        if (count == 0) {
            told = SG_FINISHED;
        } else if (self->indices[ETCHER_INTERVALS - 1] == 0) {
            told = (standing == 1) ? SG_UNREACHABLE : status;
        } else {
            told = status;
        }
    }
    return told;
}

/* One period from these states; the points machined in it go to `taken`. */
static sg_status etcher_period(etcher_t *self, const etcher_step_in *in, const etcher_seen *seen,
                           etcher_step_out *out)
{
    int32_t standing = 1;
    etcher_share(self, in, seen);
    sg_status status = etcher_govern_x(self, in, seen, out, &standing);
    status = sg_worse(status, etcher_govern_y(self, in, seen, out, &standing));
    if (self->lost == 1) {
        status = sg_worse(status, SG_INFEASIBLE);
    }
    int32_t taken = sg_bound_count(self->indices[1], 0, ETCHER_POINTS); /* an interval's */
    if (status == SG_INFEASIBLE) {
        taken = 0; /* the moved plan does not keep what these points ask for: the tool waits */
        etcher_forget(self);
        self->lost = 1;
    } else {
        self->lost = 0;
        SG_PRAGMA("MUST_ITERATE(42, 42)")
        for (int32_t i = 0; i < ETCHER_INTERVALS; i++) {
            const int32_t next = (i < ETCHER_VARIABLES) ? (i + 1) : i;
            self->planned[i] = etcher_index(self, next) - taken;
        }
    }
    const sg_real last_x = etcher_at(self->last_x, in->points_x, taken);
    const sg_real home_x = etcher_at(self->home_x, in->slow_x, taken);
    self->last_x = etcher_checked(last_x, etcher_limit_x);
    self->home_x = etcher_checked(home_x, etcher_limit_x);
    const sg_real last_y = etcher_at(self->last_y, in->points_y, taken);
    const sg_real home_y = etcher_at(self->home_y, in->slow_y, taken);
    self->last_y = etcher_checked(last_y, etcher_limit_y);
    self->home_y = etcher_checked(home_y, etcher_limit_y);
    out->points_taken = taken;
    return etcher_told(self, status, seen->count, standing);
}

void etcher_init(etcher_t *self)
{
    self->last_x = (sg_real)0;
    self->last_y = (sg_real)0;
    self->home_x = (sg_real)0;
    self->home_y = (sg_real)0;
    SG_PRAGMA("MUST_ITERATE(42, 42)")
    for (int i = 0; i < ETCHER_INTERVALS; i++) {
        self->planned[i] = 0;
    }
    etcher_axis_init(&self->x);
    etcher_axis_init(&self->y);
    SG_PRAGMA("MUST_ITERATE(42, 42)")
    for (int i = 0; i < ETCHER_INTERVALS; i++) {
        self->indices[i] = 0;
    }
    SG_PRAGMA("MUST_ITERATE(42, 42)")
    for (int i = 0; i < ETCHER_INTERVALS; i++) {
        self->parts[i] = 0;
    }
    sg_fill(ETCHER_INTERVALS, (sg_real)0, self->least_x);
    sg_fill(ETCHER_INTERVALS, (sg_real)0, self->greatest_x);
    sg_fill(ETCHER_INTERVALS, (sg_real)0, self->least_on_x);
    sg_fill(ETCHER_INTERVALS, (sg_real)0, self->greatest_on_x);
    sg_fill(ETCHER_INTERVALS, (sg_real)0, self->least_y);
    sg_fill(ETCHER_INTERVALS, (sg_real)0, self->greatest_y);
    sg_fill(ETCHER_INTERVALS, (sg_real)0, self->least_on_y);
    sg_fill(ETCHER_INTERVALS, (sg_real)0, self->greatest_on_y);
    self->lost = 0;
    self->ready = 0;
}

sg_status etcher_reset(etcher_t *self, const etcher_reset_in *in)
{
    sg_status status = SG_OK;
    etcher_axis_reset_in ask_x;
    ask_x.position = in->position_x;
    const sg_status status_x = etcher_axis_reset(&self->x, &ask_x);
    const sg_real start_x = (status_x == SG_OK) ? in->position_x : etcher_centre_x;
    self->last_x = etcher_checked(start_x, etcher_limit_x);
    self->home_x = self->last_x;
    status = sg_worse(status, status_x);
    etcher_axis_reset_in ask_y;
    ask_y.position = in->position_y;
    const sg_status status_y = etcher_axis_reset(&self->y, &ask_y);
    const sg_real start_y = (status_y == SG_OK) ? in->position_y : etcher_centre_y;
    self->last_y = etcher_checked(start_y, etcher_limit_y);
    self->home_y = self->last_y;
    status = sg_worse(status, status_y);
    etcher_forget(self);
    self->lost = 0;
    self->ready = (status == SG_OK) ? 1 : 0;
    return status;
}

sg_status etcher_predict(const etcher_t *self, const etcher_predict_in *in, etcher_predict_out *out)
{
    sg_status status = SG_OK;
    etcher_axis_predict_in ask_x;
    etcher_axis_predict_out told_x;
    ask_x.position = in->x_position;
    ask_x.velocity = in->x_velocity;
    ask_x.acceleration = in->x_acceleration;
    status = sg_worse(status, etcher_axis_predict(&self->x, &ask_x, &told_x));
    out->x_position = told_x.position;
    out->x_velocity = told_x.velocity;
    out->x_acceleration = told_x.acceleration;
    etcher_axis_predict_in ask_y;
    etcher_axis_predict_out told_y;
    ask_y.position = in->y_position;
    ask_y.velocity = in->y_velocity;
    ask_y.acceleration = in->y_acceleration;
    status = sg_worse(status, etcher_axis_predict(&self->y, &ask_y, &told_y));
    out->y_position = told_y.position;
    out->y_velocity = told_y.velocity;
    out->y_acceleration = told_y.acceleration;
    return status;
}

sg_status etcher_step(etcher_t *self, const etcher_step_in *in, etcher_step_out *out)
{
    sg_status status = SG_OK;
    etcher_seen seen;
    /*@ dynamic_split status; */
    if (in->n_points < 0) {
        status = sg_worse(status, SG_OUT_OF_RANGE);
    }
    if (in->n_points > 8000) {
        status = sg_worse(status, SG_OUT_OF_RANGE);
    }
    /*@ merge status; */
    if (status != SG_OUT_OF_RANGE) { /* else n_points may be */
        status = sg_worse(status, etcher_check(in->n_points, in->points_x, etcher_limit_x));
        status = sg_worse(status, etcher_check(in->n_points, in->slow_x, etcher_limit_x));
        status = sg_worse(status, etcher_check(in->n_points, in->points_y, etcher_limit_y));
        status = sg_worse(status, etcher_check(in->n_points, in->slow_y, etcher_limit_y));
    }
    status = sg_worse(status, etcher_look_x(self, in, &seen));
    status = sg_worse(status, etcher_look_y(self, in, &seen));
    /* checked; all of them or none */
    seen.count = (status == SG_OK) ? sg_bound_count(in->n_points, 0, ETCHER_WINDOW) : 0;
    out->points_taken = 0;
    if (self->ready == 0) {
        status = SG_NOT_READY;
        out->command_x = self->last_x;
        out->status_x = (int32_t)SG_NOT_READY;
        out->iterations_x = 0;
        out->command_y = self->last_y;
        out->status_y = (int32_t)SG_NOT_READY;
        out->iterations_y = 0;
    } else {
        const sg_status planned = etcher_period(self, in, &seen, out);
        if (status == SG_OK) {
            status = planned;
        } else {
            out->status_x = (int32_t)status;
            out->status_y = (int32_t)status;
        }
    }
    return status;
}
