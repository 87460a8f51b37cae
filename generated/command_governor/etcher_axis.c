/* SPDX-License-Identifier: MIT */
/*
 * Made by servogen 0.1.0 from command_governor_axis.c.jinja; not to be edited.
 * Design db73e1a8671115da28984cf35db7dd65b73d330d546f213644560d85ebcdbb92.
 *
 * Extended command governor (17) of one axis: dual active-set method, property (b)
 *
 * Counted in this C, calls of other files included (servogen wcet): operations on etcher_real, bytes
 * of C objects on the stack. Constant tables of this file: 28808 bytes.
 *
 * worst case of one call                    add    mul   div    cmp other    load  store stack
 * etcher_axis_init                            0      0     0      0     0       0   3676    36
 * etcher_axis_reset                           0      0     0      5     0       2     45    48
 * etcher_axis_foresee                      2258   1412     0   1067     1    3215   1671   708
 * etcher_axis_step                       743525 695029 11044 312119 96775 1384322 236006  2248
 *   fixed part                            87830  85639    19   7649  2680  148307  17486
 *   each of 45 ETCHER_AXIS_ITERATION_CAP  14571  13542   245   6766  2091   27467   4856
 * etcher_axis_predict                        12     12     0     15     0      42     24   188
 */
#include "etcher_axis.h"
#include "etcher_scalar.h"
#include "sg_quotient.h"
#include "etcher_axis_tables.h"

/* A x + B v(0) of the plan; `ahead` must not be `state`. */
static void etcher_axis_advance(const etcher_axis_t *self, const sg_real *restrict state, sg_real *restrict ahead)
{
    sg_matvec(ETCHER_AXIS_PLANT_ORDER, ETCHER_AXIS_PLANT_ORDER, etcher_axis_a_columns, state, ahead);
    SG_PRAGMA("MUST_ITERATE(3, 3)")
    for (int i = 0; i < ETCHER_AXIS_PLANT_ORDER; i++) {
        ahead[i] += etcher_axis_b[i] * self->plan[0];
    }
}

/* Take `plan` from `state` on. The state expected keeps to the declared range of a measured one: a
 * caller may go on without measurements for as long as she likes. */
static void etcher_axis_accept(etcher_axis_t *self, const sg_real *restrict state, const sg_real *restrict plan)
{
    sg_real ahead[ETCHER_AXIS_PLANT_ORDER];
    SG_PRAGMA("MUST_ITERATE(41, 41)")
    for (int i = 0; i < ETCHER_AXIS_VARIABLES; i++) {
        self->plan[i] = sg_clamp(plan[i], -etcher_axis_command_limit, etcher_axis_command_limit);
    }
    etcher_axis_advance(self, state, ahead);
    SG_PRAGMA("MUST_ITERATE(3, 3)")
    for (int i = 0; i < ETCHER_AXIS_PLANT_ORDER; i++) {
        self->predicted[i] = sg_clamp(ahead[i], -etcher_axis_bound[i], etcher_axis_bound[i]);
    }
}

/* The plan one period on: the shifted register, the same rho. */
static void etcher_axis_move(const etcher_axis_t *self, sg_real *restrict moved)
{
    sg_copy(ETCHER_AXIS_VARIABLES, self->plan, moved);
    sg_shift(ETCHER_AXIS_VARIABLES, moved, self->plan[ETCHER_AXIS_VARIABLES - 1]);
}

/* A z and what the state at the start adds: the plant driven by z. */
static void etcher_axis_rows(const sg_real *restrict start, const sg_real *restrict z, sg_real *restrict rows)
{
    sg_real x0 = start[0];
    sg_real x1 = start[1];
    sg_real x2 = start[2];
    sg_real x3 = start[3];
    SG_PRAGMA("MUST_ITERATE(41, 41)")
    for (int32_t k = 0; k < ETCHER_AXIS_STEPS; k++) {
        const int32_t first = k * ETCHER_AXIS_ROWS_PER_STEP;
        const sg_real u0 = z[k];
        const sg_real y0 = (((etcher_axis_plant[0] * x0) +
            (etcher_axis_plant[1] * x1)) +
            (etcher_axis_plant[2] * x2)) +
            (etcher_axis_plant[3] * u0);
        const sg_real y1 = (((etcher_axis_plant[4] * x0) +
            (etcher_axis_plant[5] * x1)) +
            (etcher_axis_plant[6] * x2)) +
            (etcher_axis_plant[7] * u0);
        const sg_real y2 = (((etcher_axis_plant[8] * x0) +
            (etcher_axis_plant[9] * x1)) +
            (etcher_axis_plant[10] * x2)) +
            (etcher_axis_plant[11] * u0);
        const sg_real y3 = (etcher_axis_plant[12] * u0);
        const sg_real r0 = y0;
        rows[first] = r0;
        const sg_real r1 = y1;
        rows[first + 1] = r1;
        const sg_real r2 = (((etcher_axis_plant[13] * x0) +
            (etcher_axis_plant[14] * x1)) +
            (etcher_axis_plant[15] * x2)) +
            (etcher_axis_plant[16] * u0);
        rows[first + 2] = r2;
        const sg_real r3 = (((etcher_axis_plant[17] * x0) +
            (etcher_axis_plant[18] * x1)) +
            (etcher_axis_plant[19] * x2)) +
            (etcher_axis_plant[20] * u0);
        rows[first + 3] = r3;
        const sg_real r4 = (((etcher_axis_plant[21] * x0) +
            (etcher_axis_plant[22] * x1)) +
            (etcher_axis_plant[23] * x2)) +
            (etcher_axis_plant[24] * u0);
        rows[first + 4] = r4;
        const sg_real r5 = (((etcher_axis_plant[25] * x0) +
            (etcher_axis_plant[26] * x1)) +
            (etcher_axis_plant[27] * x2)) +
            (etcher_axis_plant[28] * u0);
        rows[first + 5] = r5;
        x0 = y0;
        x1 = y1;
        x2 = y2;
        x3 = y3;
    }
    const sg_real last[ETCHER_AXIS_ORDER] = { x0, x1, x2, x3 };
    sg_matvec(ETCHER_AXIS_TERMINAL_ROWS, ETCHER_AXIS_ORDER, etcher_axis_terminal_columns, last,
              &rows[ETCHER_AXIS_STEPS * ETCHER_AXIS_ROWS_PER_STEP]);
}

/* The same, and the largest violation of a bound, while the rows are at hand. */
static sg_real etcher_axis_violation(const sg_real *restrict start, const sg_real *restrict z,
                                 const sg_real *restrict low, const sg_real *restrict high,
                                 sg_real *restrict rows)
{
    sg_real most = -SG_REAL_MAX;
    sg_real x0 = start[0];
    sg_real x1 = start[1];
    sg_real x2 = start[2];
    sg_real x3 = start[3];
    SG_PRAGMA("MUST_ITERATE(41, 41)")
    for (int32_t k = 0; k < ETCHER_AXIS_STEPS; k++) {
        const int32_t first = k * ETCHER_AXIS_ROWS_PER_STEP;
        const sg_real u0 = z[k];
        const sg_real y0 = (((etcher_axis_plant[0] * x0) +
            (etcher_axis_plant[1] * x1)) +
            (etcher_axis_plant[2] * x2)) +
            (etcher_axis_plant[3] * u0);
        const sg_real y1 = (((etcher_axis_plant[4] * x0) +
            (etcher_axis_plant[5] * x1)) +
            (etcher_axis_plant[6] * x2)) +
            (etcher_axis_plant[7] * u0);
        const sg_real y2 = (((etcher_axis_plant[8] * x0) +
            (etcher_axis_plant[9] * x1)) +
            (etcher_axis_plant[10] * x2)) +
            (etcher_axis_plant[11] * u0);
        const sg_real y3 = (etcher_axis_plant[12] * u0);
        const sg_real r0 = y0;
        rows[first] = r0;
        most = sg_max(most, sg_max(r0 - high[first], low[first] - r0));
        const sg_real r1 = y1;
        rows[first + 1] = r1;
        most = sg_max(most, sg_max(r1 - high[first + 1], low[first + 1] - r1));
        const sg_real r2 = (((etcher_axis_plant[13] * x0) +
            (etcher_axis_plant[14] * x1)) +
            (etcher_axis_plant[15] * x2)) +
            (etcher_axis_plant[16] * u0);
        rows[first + 2] = r2;
        most = sg_max(most, sg_max(r2 - high[first + 2], low[first + 2] - r2));
        const sg_real r3 = (((etcher_axis_plant[17] * x0) +
            (etcher_axis_plant[18] * x1)) +
            (etcher_axis_plant[19] * x2)) +
            (etcher_axis_plant[20] * u0);
        rows[first + 3] = r3;
        most = sg_max(most, sg_max(r3 - high[first + 3], low[first + 3] - r3));
        const sg_real r4 = (((etcher_axis_plant[21] * x0) +
            (etcher_axis_plant[22] * x1)) +
            (etcher_axis_plant[23] * x2)) +
            (etcher_axis_plant[24] * u0);
        rows[first + 4] = r4;
        most = sg_max(most, sg_max(r4 - high[first + 4], low[first + 4] - r4));
        const sg_real r5 = (((etcher_axis_plant[25] * x0) +
            (etcher_axis_plant[26] * x1)) +
            (etcher_axis_plant[27] * x2)) +
            (etcher_axis_plant[28] * u0);
        rows[first + 5] = r5;
        most = sg_max(most, sg_max(r5 - high[first + 5], low[first + 5] - r5));
        x0 = y0;
        x1 = y1;
        x2 = y2;
        x3 = y3;
    }
    const sg_real last[ETCHER_AXIS_ORDER] = { x0, x1, x2, x3 };
    sg_matvec(ETCHER_AXIS_TERMINAL_ROWS, ETCHER_AXIS_ORDER, etcher_axis_terminal_columns, last,
              &rows[ETCHER_AXIS_STEPS * ETCHER_AXIS_ROWS_PER_STEP]);
    for (int i = ETCHER_AXIS_ROWS - ETCHER_AXIS_TERMINAL_ROWS; i < ETCHER_AXIS_ROWS; i++) {
        most = sg_max(most, sg_max(rows[i] - high[i], low[i] - rows[i]));
    }
    return most;
}

/* The largest violation of a bound; negative where all rows are inside. */
static sg_real etcher_axis_worst(const sg_real *restrict rows, const sg_real *restrict low,
                             const sg_real *restrict high)
{
    sg_real most = sg_max(rows[0] - high[0], low[0] - rows[0]);
    for (int i = 1; i < ETCHER_AXIS_ROWS; i++) {
        most = sg_max(most, sg_max(rows[i] - high[i], low[i] - rows[i]));
    }
    return most;
}

/* A row's last variable; its coefficient is at `place`, that of the variable before at `place` + 1, ... */
static int32_t etcher_axis_last(int32_t row, int32_t *place)
{
    int32_t output = row % ETCHER_AXIS_ROWS_PER_STEP;
    int32_t last = (((row / ETCHER_AXIS_ROWS_PER_STEP) + 1) * ETCHER_AXIS_INPUTS) - 1;
    if (row >= (ETCHER_AXIS_STEPS * ETCHER_AXIS_ROWS_PER_STEP)) {
        output = row - ((ETCHER_AXIS_STEPS - 1) * ETCHER_AXIS_ROWS_PER_STEP);
        last = ETCHER_AXIS_VARIABLES - 1;
    }
    *place = output * ETCHER_AXIS_VARIABLES;
    return last;
}

/* A row's coefficients from `begin` up to the last one; how many variables there are up to it. */
static int32_t etcher_axis_row(int32_t row, sg_real *own, int32_t *begin)
{
    int32_t place = 0;
    /*@ split row; */
    const int32_t last = etcher_axis_last(row, &place);
    *begin = 0;
    for (int32_t j = 0; j < ETCHER_AXIS_VARIABLES; j++) {
        if (j > last) {
            break;
        }
        own[j] = etcher_axis_responses[(place + last) - j];
    }
    /*@ merge row; */
    return last + 1;
}

static sg_real etcher_axis_row_dot(int32_t row, const sg_real *v)
{
    int32_t place = 0;
    /*@ split row; */
    const int32_t last = etcher_axis_last(row, &place);
    sg_real sum = (sg_real)0;
    sum = etcher_axis_responses[place + last] * v[0];
    for (int32_t j = 1; j < ETCHER_AXIS_VARIABLES; j++) {
        if (j > last) {
            break;
        }
        sum += etcher_axis_responses[(place + last) - j] * v[j];
    }
    /*@ merge row; */
    return sum;
}

/* The row one sample later, -1 where it is past. */
static int32_t etcher_axis_shifted(int32_t row)
{
    int32_t moved = -1;
    if (row >= ETCHER_AXIS_ROWS_PER_STEP) {
        moved = row - ETCHER_AXIS_ROWS_PER_STEP;
    }
    if (row >= (ETCHER_AXIS_STEPS * ETCHER_AXIS_ROWS_PER_STEP)) {
        moved = row;
    }
    return moved;
}

/*
 * What outlives a pass is kept within `large`, and what is divided by above `small`: the factor's entries,
 * pivots and multipliers stay far inside because every row that enters is independent of the others, which
 * intervals do not tell. For the same reason a vector of which a part is written is filled first.
 */
static sg_real etcher_axis_within(sg_real x)
{
    return sg_bound(x, -etcher_axis_large, etcher_axis_large);
}

/* Where line j of the factor begins, which has j entries. */
static int32_t etcher_axis_line(int32_t j)
{
    return sg_bound_count((j * (j - 1)) / 2, 0, ETCHER_AXIS_FACTOR - ETCHER_AXIS_VARIABLES);
}

/* Whether one of four is not zero. */
static int32_t etcher_axis_any(const sg_real *x)
{
    int32_t any = 1;
    if (x[0] == (sg_real)0) {
        if (x[1] == (sg_real)0) {
            if (x[2] == (sg_real)0) {
                any = (x[3] == (sg_real)0) ? 0 : 1;
            }
        }
    }
    return any;
}

/* x becomes L^-1 x, four lines at a time; x is zero beyond the set, and all of it and of L is finite. */
static void etcher_axis_forward(const etcher_axis_t *self, sg_real *restrict x)
{
    int32_t moved = 0;
    for (int32_t j = 0; j < (ETCHER_AXIS_VARIABLES - 3); j += 4) {
        if (j >= self->size) {
            break;
        }
        const sg_real *restrict l0 = &self->factor[(j * (j - 1)) / 2];
        const sg_real *restrict l1 = &l0[j];
        const sg_real *restrict l2 = &l1[j + 1];
        const sg_real *restrict l3 = &l2[j + 2];
        sg_real t0 = x[j];
        sg_real t1 = x[j + 1];
        sg_real t2 = x[j + 2];
        sg_real t3 = x[j + 3];
        const int32_t here = etcher_axis_any(&x[j]); /* asked always: compilers do, and what runs is counted */
        if ((moved + here) == 0) {
            continue;
        }
        moved = 1;
        for (int32_t k = 0; k < j; k += 4) {
            const sg_real a0 = x[k];
            const sg_real a1 = x[k + 1];
            const sg_real a2 = x[k + 2];
            const sg_real a3 = x[k + 3];
            t0 = (((t0 - (l0[k] * a0)) - (l0[k + 1] * a1)) - (l0[k + 2] * a2)) - (l0[k + 3] * a3);
            t1 = (((t1 - (l1[k] * a0)) - (l1[k + 1] * a1)) - (l1[k + 2] * a2)) - (l1[k + 3] * a3);
            t2 = (((t2 - (l2[k] * a0)) - (l2[k + 1] * a1)) - (l2[k + 2] * a2)) - (l2[k + 3] * a3);
            t3 = (((t3 - (l3[k] * a0)) - (l3[k + 1] * a1)) - (l3[k + 2] * a2)) - (l3[k + 3] * a3);
        }
        t0 = etcher_axis_within(t0);
        t1 = etcher_axis_within(t1 - (l1[j] * t0));
        t2 = etcher_axis_within((t2 - (l2[j] * t0)) - (l2[j + 1] * t1));
        t3 = etcher_axis_within(((t3 - (l3[j] * t0)) - (l3[j + 1] * t1)) -
             (l3[j + 2] * t2));
        x[j] = t0;
        x[j + 1] = ((j + 1) < self->size) ? t1 : (sg_real)0; /* lines beyond the set are old */
        x[j + 2] = ((j + 2) < self->size) ? t2 : (sg_real)0;
        x[j + 3] = ((j + 3) < self->size) ? t3 : (sg_real)0;
    }
    if (self->size > 40) {
        const sg_real *const line = &self->factor[780];
        sg_real total = x[40];
        for (int32_t k = 0; k < 40; k++) {
            total -= line[k] * x[k];
        }
        x[40] = etcher_axis_within(total);
    }
}

/* x becomes L^-T x; x is zero beyond the set, and all of it is finite. */
static void etcher_axis_back(const etcher_axis_t *self, sg_real *restrict x)
{
    if (self->size > 40) {
        const sg_real *const line = &self->factor[780];
        const sg_real factor = etcher_axis_within(x[40]);
        for (int32_t k = 0; k < 40; k++) {
            x[k] -= line[k] * factor;
        }
        x[40] = factor;
    }
    for (int32_t j = 36; j >= 0; j -= 4) {
        if (j >= self->size) {
            continue;
        }
        const sg_real *restrict l0 = &self->factor[(j * (j - 1)) / 2];
        const sg_real *restrict l1 = &l0[j];
        const sg_real *restrict l2 = &l1[j + 1];
        const sg_real *restrict l3 = &l2[j + 2];
        const sg_real t3 = etcher_axis_within(x[j + 3]);
        const sg_real t2 = etcher_axis_within(x[j + 2] - (l3[j + 2] * t3));
        const sg_real t1 = etcher_axis_within((x[j + 1] - (l3[j + 1] * t3)) -
            (l2[j + 1] * t2));
        const sg_real t0 = etcher_axis_within(((x[j] - (l3[j] * t3)) - (l2[j] * t2)) -
                               (l1[j] * t1));
        x[j] = t0;
        x[j + 1] = t1;
        x[j + 2] = t2;
        x[j + 3] = t3;
        for (int32_t k = 0; k < j; k++) {
            x[k] = (((x[k] - (l3[k] * t3)) - (l2[k] * t2)) -
                    (l1[k] * t1)) - (l0[k] * t0);
        }
    }
}

/*
 * Extend the factor by a row; 0, and the set as it was, where it depends on the set's. Line `size` of
 * the factor then holds its products with the others, solved for L and divided by D. `square` is that of
 * the row in the metric of H^-1, `left` what the set leaves of it, and `least` the share that must be left.
 */
static int32_t etcher_axis_append(etcher_axis_t *self, int32_t row, int32_t side, sg_real least,
                                sg_real *square, sg_real *left)
{
    const int32_t size = self->size;
    sg_real *const under = &self->factor[etcher_axis_line(size)];
    sg_real own[ETCHER_AXIS_VARIABLES];
    sg_real vector[ETCHER_AXIS_VARIABLES]; /* -H^-1 times the row */
    sg_real product[ETCHER_AXIS_VARIABLES];
    sg_fill(ETCHER_AXIS_VARIABLES, (sg_real)0, own);
    sg_fill(ETCHER_AXIS_VARIABLES, (sg_real)0, product);
    int32_t begin = 0;
    const int32_t length = etcher_axis_row(row, own, &begin);
    sg_fill(ETCHER_AXIS_VARIABLES, (sg_real)0, vector);
    for (int32_t j = 0; j < (ETCHER_AXIS_VARIABLES - 3); j += 4) {
        if (j >= length) {
            break;
        }
        const sg_real a0 = own[j];
        const sg_real a1 = own[j + 1];
        const sg_real a2 = own[j + 2];
        const sg_real a3 = own[j + 3];
        const sg_real *restrict column = &etcher_axis_minus_inverse[j * ETCHER_AXIS_VARIABLES];
        for (int i = 0; i < ETCHER_AXIS_VARIABLES; i++) {
            vector[i] = (((vector[i] + (column[i] * a0)) + (column[ETCHER_AXIS_VARIABLES + i] * a1)) +
                         (column[(2 * ETCHER_AXIS_VARIABLES) + i] * a2)) +
                        (column[(3 * ETCHER_AXIS_VARIABLES) + i] * a3);
        }
    }
    for (int i = 0; i < ETCHER_AXIS_VARIABLES; i++) {
        vector[i] += etcher_axis_minus_inverse[1640 + i] * own[40];
    }
    sg_real pivot = -etcher_axis_row_dot(row, vector);
    *square = pivot;
    for (int32_t j = 0; j < ETCHER_AXIS_VARIABLES; j++) {
        if (j >= size) {
            break;
        }
        const sg_real along = etcher_axis_row_dot(self->row[j], vector);
        product[j] = (side == self->side[j]) ? -along : along;
    }
    etcher_axis_forward(self, product);
    for (int32_t j = 0; j < ETCHER_AXIS_VARIABLES; j++) {
        if (j >= size) {
            break;
        }
        under[j] = etcher_axis_within(product[j] * self->pivots[j]);
        pivot -= under[j] * product[j];
    }
    *left = sg_clamp(pivot, etcher_axis_rounding * *square, etcher_axis_large);
    int32_t independent = 0;
    if (size < ETCHER_AXIS_VARIABLES) {
        if (pivot > (least * *square)) {
            independent = 1;
            self->pivots[size] = SG_DIVIDE((sg_real)1, sg_bound(pivot, etcher_axis_small, etcher_axis_large));
            self->square[size] = *square;
            sg_copy(ETCHER_AXIS_VARIABLES, vector, &self->vectors[self->slot[size] * ETCHER_AXIS_VARIABLES]);
            self->row[size] = row;
            self->side[size] = side;
            self->size = size + 1;
        }
    }
    return independent;
}

/*
 * Take the row at `place` out: the lines after it move up without their entry for it, and L D L' of the
 * rest is updated by the rank-one matrix of these entries, line by line.
 */
static void etcher_axis_remove(etcher_axis_t *self, int32_t place)
{
    const int32_t last = sg_bound_count(self->size - 1, 0, ETCHER_AXIS_VARIABLES - 1);
    const int32_t freed = self->slot[place];
    sg_real below[ETCHER_AXIS_VARIABLES];
    sg_real share[ETCHER_AXIS_VARIABLES];
    sg_real weight = SG_DIVIDE((sg_real)1, sg_bound_below(self->pivots[place], etcher_axis_small));
    sg_fill(ETCHER_AXIS_VARIABLES, (sg_real)0, below);
    sg_fill(ETCHER_AXIS_VARIABLES, (sg_real)0, share);
    for (int32_t i = 0; i < (ETCHER_AXIS_VARIABLES - 1); i++) {
        if (i >= last) {
            break;
        }
        if (i < place) {
            continue;
        }
        sg_real *const to = &self->factor[etcher_axis_line(i)];
        const sg_real *const from = &self->factor[etcher_axis_line(i + 1)];
        sg_real own = from[place];
        for (int32_t k = 0; k < (ETCHER_AXIS_VARIABLES - 2); k++) {
            if (k >= i) {
                break;
            }
            if (k < place) {
                to[k] = from[k];
            } else {
                const sg_real entry = from[k + 1];
                own -= below[k] * entry;
                to[k] = etcher_axis_within(entry + (share[k] * own));
            }
        }
        own = etcher_axis_within(own);
        const sg_real old = SG_DIVIDE((sg_real)1, sg_bound_below(self->pivots[i + 1], etcher_axis_small));
        const sg_real part = weight * own;
        const sg_real inverse = SG_DIVIDE((sg_real)1, sg_bound(old + (part * own), etcher_axis_small, etcher_axis_large));
        weight = sg_bound((old * weight) * inverse, (sg_real)0, etcher_axis_large);
        below[i] = own;
        share[i] = etcher_axis_within(part * inverse);
        self->pivots[i] = inverse;
        self->square[i] = self->square[i + 1];
        self->row[i] = self->row[i + 1];
        self->side[i] = self->side[i + 1];
        self->slot[i] = self->slot[i + 1];
        self->dual[i] = self->dual[i + 1];
        self->missed[i] = self->missed[i + 1];
    }
    self->slot[last] = freed;
    self->dual[last] = (sg_real)0; /* what is beyond the set is added and copied, never read */
    self->missed[last] = (sg_real)0;
    self->size = last;
}

/*
 * Go to the multipliers at which the rows of the set hold, or, where some of them are negative, to
 * where the first one vanishes, and drop its row; 1 if one was dropped.
 */
static int32_t etcher_axis_descend(etcher_axis_t *self, sg_real *restrict step)
{
    sg_real share = (sg_real)1;
    int32_t place = -1;
    sg_copy(ETCHER_AXIS_VARIABLES, self->missed, step);
    etcher_axis_forward(self, step);
    for (int i = 0; i < ETCHER_AXIS_VARIABLES; i++) {
        step[i] *= self->pivots[i];
    }
    etcher_axis_back(self, step);
    for (int32_t j = 0; j < ETCHER_AXIS_VARIABLES; j++) {
        if (j >= self->size) {
            break;
        }
        const sg_real star = self->dual[j] + step[j];
        if (star < (sg_real)0) {
            const sg_real here = SG_DIVIDE(self->dual[j], sg_bound_below(self->dual[j] - star, etcher_axis_small));
            if (place < 0) {
                share = here;
                place = j;
            } else if (here < share) {
                share = here;
                place = j;
            } else {
                /* another one vanishes first */
            }
        }
    }
    if (place < 0) {
        for (int i = 0; i < ETCHER_AXIS_VARIABLES; i++) {
            self->dual[i] = sg_bound(self->dual[i] + step[i], (sg_real)0, etcher_axis_large);
        }
    } else {
        share = sg_bound(share, (sg_real)0, (sg_real)1);
        for (int i = 0; i < ETCHER_AXIS_VARIABLES; i++) {
            const sg_real star = self->dual[i] + step[i];
            self->dual[i] =
                sg_clamp(self->dual[i] + (share * (star - self->dual[i])), (sg_real)0, etcher_axis_large);
            self->missed[i] = etcher_axis_within(self->missed[i] - (share * self->missed[i]));
        }
    }
    if (place >= 0) {
        etcher_axis_remove(self, place);
    }
    return (place >= 0) ? 1 : 0;
}

/*
 * A row of this square depends on the set: raise its multiplier until one of the set vanishes and
 * leaves. By how much; negative where none falls: no point keeps all rows.
 */
static sg_real etcher_axis_make_room(etcher_axis_t *self, sg_real square)
{
    const sg_real own = (etcher_axis_falls * etcher_axis_falls) * square;
    const sg_real *const line = &self->factor[etcher_axis_line(self->size)];
    sg_real share[ETCHER_AXIS_VARIABLES];
    sg_real length = (sg_real)-1;
    int32_t place = -1;
    sg_fill(ETCHER_AXIS_VARIABLES, (sg_real)0, share);
    for (int32_t j = 0; j < ETCHER_AXIS_VARIABLES; j++) {
        if (j >= self->size) {
            break;
        }
        share[j] = line[j];
    }
    etcher_axis_back(self, share);
    for (int32_t j = 0; j < ETCHER_AXIS_VARIABLES; j++) {
        if (j >= self->size) {
            break;
        }
        const sg_real falling = sg_clamp(share[j], (sg_real)0, etcher_axis_large);
        if (((falling * falling) * self->square[j]) > own) {
            const sg_real here = SG_DIVIDE(self->dual[j], sg_bound_below(falling, etcher_axis_small));
            if (place < 0) {
                length = here;
                place = j;
            } else if (here < length) {
                length = here;
                place = j;
            } else {
                /* another one vanishes first */
            }
        }
    }
    if (place >= 0) {
        length = sg_bound(length, (sg_real)0, etcher_axis_large);
        for (int i = 0; i < ETCHER_AXIS_VARIABLES; i++) { /* beyond the set zero, and stays so */
            self->dual[i] = sg_clamp(self->dual[i] - (length * share[i]), (sg_real)0, etcher_axis_large);
        }
        etcher_axis_remove(self, place);
    }
    return length;
}

/* The largest of the rows' sizes. */
static sg_real etcher_axis_reach(const sg_real *rows)
{
    sg_real reach = (sg_real)0;
    for (int i = 0; i < ETCHER_AXIS_ROWS; i++) {
        reach = sg_max(reach, sg_max(rows[i], -rows[i]));
    }
    return sg_bound(reach, (sg_real)0, etcher_axis_large);
}

/*
 * Whether a row that cannot be kept is beyond doubt. What the set leaves of it, `left` of its square, is
 * rounding, or counts as that: points that keep all rows are at least excess / sqrt(left) away, in the
 * metric of H. That is far where it is more than the reach many times over: of the rows at z, and of the
 * moves V lambda, of which z is what rounding has left. What has come near `large` may have met it, and
 * leaves doubt.
 */
static int32_t etcher_axis_no_point(const etcher_axis_t *self, const sg_real *rows, sg_real excess, sg_real left)
{
    sg_real greatest = etcher_axis_reach(rows);
    sg_real reach = greatest * greatest;
    for (int32_t j = 0; j < ETCHER_AXIS_VARIABLES; j++) {
        if (j >= self->size) {
            break;
        }
        greatest = sg_max(greatest, self->dual[j]);
        reach = sg_max(reach, (self->dual[j] * self->dual[j]) * self->square[j]);
    }
    reach = etcher_axis_doubt * sg_bound(reach, (sg_real)0, etcher_axis_large * etcher_axis_large);
    const sg_real most = sg_bound(excess, (sg_real)0, etcher_axis_large);
    int32_t beyond = 0;
    if (greatest < ((sg_real)0.5 * etcher_axis_large)) {
        beyond = ((most * most) > (reach * left)) ? 1 : 0;
    }
    return beyond;
}

/* Be as a first call finds it: the order of the slots is one of sums too. */
static void etcher_axis_forget(etcher_axis_t *self)
{
    self->size = 0;
    self->pending = 0;
    self->refining = 0;
    self->forced = 0;
    self->stalled = 0;
    SG_PRAGMA("MUST_ITERATE(41, 41)")
    for (int32_t i = 0; i < ETCHER_AXIS_VARIABLES; i++) {
        self->slot[i] = i;
    }
}

/* What the rows of the set miss at a point with these `rows`; the least of it, or zero. */
static sg_real etcher_axis_measure(etcher_axis_t *self, const sg_real *restrict rows, const sg_real *restrict low,
                               const sg_real *restrict high)
{
    sg_real least = (sg_real)0;
    sg_fill(ETCHER_AXIS_VARIABLES, (sg_real)0, self->missed);
    for (int32_t j = 0; j < ETCHER_AXIS_VARIABLES; j++) {
        if (j >= self->size) {
            break;
        }
        const int32_t row = self->row[j];
        const sg_real missed =
            (self->side[j] > 0) ? (rows[row] - high[row]) : (low[row] - rows[row]);
        self->missed[j] = missed;
        least = sg_min(least, missed);
    }
    return least;
}

/* Take V dual from z; four vectors share one pass over z, where one of them is in use. */
static void etcher_axis_less(const etcher_axis_t *self, const sg_real *restrict dual, sg_real *restrict z)
{
    sg_real by_slot[ETCHER_AXIS_VARIABLES];
    sg_fill(ETCHER_AXIS_VARIABLES, (sg_real)0, by_slot);
    for (int32_t j = 0; j < ETCHER_AXIS_VARIABLES; j++) {
        if (j >= self->size) {
            break;
        }
        by_slot[self->slot[j]] = (self->side[j] > 0) ? dual[j] : -dual[j];
    }
    for (int32_t j = 0; j < (ETCHER_AXIS_VARIABLES - 3); j += 4) {
        if (etcher_axis_any(&by_slot[j]) == 0) {
            continue;
        }
        const sg_real d0 = by_slot[j];
        const sg_real d1 = by_slot[j + 1];
        const sg_real d2 = by_slot[j + 2];
        const sg_real d3 = by_slot[j + 3];
        const sg_real *const vector = &self->vectors[j * ETCHER_AXIS_VARIABLES];
        for (int i = 0; i < ETCHER_AXIS_VARIABLES; i++) {
            z[i] = (((z[i] + (vector[i] * d0)) + (vector[ETCHER_AXIS_VARIABLES + i] * d1)) +
                    (vector[(2 * ETCHER_AXIS_VARIABLES) + i] * d2)) + (vector[(3 * ETCHER_AXIS_VARIABLES) + i] * d3);
        }
    }
    for (int i = 0; i < ETCHER_AXIS_VARIABLES; i++) {
        z[i] += self->vectors[1640 + i] * by_slot[40];
    }
}

/* The row of the largest violation, which is `most`. */
static int32_t etcher_axis_where(const sg_real *restrict rows, const sg_real *restrict low,
                             const sg_real *restrict high, sg_real most)
{
    int32_t row = 0;
    for (int32_t i = 0; i < ETCHER_AXIS_ROWS; i++) {
        if (sg_max(rows[i] - high[i], low[i] - rows[i]) >= most) {
            row = i;
            break;
        }
    }
    return row;
}

/* A violated row, or -1 if it is in the set: that is what rounding left, and the next step takes it. */
static int32_t etcher_axis_new(etcher_axis_t *self, int32_t row, const sg_real *rows, const sg_real *low,
                           const sg_real *high)
{
    int32_t entering = row;
    for (int32_t j = 0; j < ETCHER_AXIS_VARIABLES; j++) {
        if (j >= self->size) {
            break;
        }
        if (self->row[j] == row) {
            entering = -1;
        }
    }
    if (entering < 0) {
        (void)etcher_axis_measure(self, rows, low, high);
    } else {
        sg_fill(ETCHER_AXIS_VARIABLES, (sg_real)0, self->missed);
    }
    return entering;
}

/* The last call's working set: as it is if large, else one sample on and factored anew. */
static void etcher_axis_begin(etcher_axis_t *self)
{
    const int32_t size = self->size;
    sg_real square = (sg_real)0;
    sg_real left = (sg_real)0;
    if (size < ETCHER_AXIS_KEEP) {
        self->size = 0;
        for (int32_t j = 0; j < (ETCHER_AXIS_KEEP - 1); j++) {
            if (j >= size) {
                break;
            }
            const int32_t moved = etcher_axis_shifted(self->row[j]);
            if (moved >= 0) {
                (void)etcher_axis_append(self, moved, self->side[j], etcher_axis_dependent, &square, &left);
            }
        }
    }
    sg_fill(ETCHER_AXIS_VARIABLES, (sg_real)0, self->dual);
}

/* The point of the last call's multipliers; a refinement begins with what is missed there, as it would have. */
static void etcher_axis_resume(etcher_axis_t *self, const sg_real *restrict free, const sg_real *restrict low,
                           const sg_real *restrict high, sg_real *restrict rows, sg_real *restrict z)
{
    for (int32_t i = 0; i < ETCHER_AXIS_VARIABLES; i++) {
        if (i >= self->size) {
            self->dual[i] = (sg_real)0;
            self->missed[i] = (sg_real)0;
        }
    }
    sg_copy(ETCHER_AXIS_VARIABLES, free, z);
    etcher_axis_less(self, self->dual, z);
    etcher_axis_rows(self->start, z, rows);
    if (self->refining == 1) {
        (void)etcher_axis_measure(self, rows, low, high);
    }
}

/* How the iteration stands at the cap; the row that is to enter goes to the place after the set's, which is
 * not full: a row has made room, or there was some. */
static void etcher_axis_leave(etcher_axis_t *self, int32_t entering, int32_t side, sg_real raised, sg_real excess)
{
    self->pending = 0;
    if (entering >= 0) {
        const int32_t at = sg_bound_count(self->size, 0, ETCHER_AXIS_VARIABLES - 1);
        self->row[at] = entering;
        self->side[at] = side;
        self->dual[at] = raised;
        self->missed[at] = excess;
        self->pending = 1;
    }
}

/* Rows that rounding does not let hold are no beginning for another program. */
static void etcher_axis_drop_stalled(etcher_axis_t *self)
{
    self->size = sg_bound_count(self->size, 0, ETCHER_AXIS_VARIABLES) * (1 - sg_bound_count(self->stalled, 0, 1));
    self->stalled = 0;
}

/*
 * The optimum in `z`, from the unconstrained one and its rows: SG_OK, SG_INFEASIBLE where no point keeps
 * all rows, SG_BACKUP at the cap. `rows` are those of z.
 */
static sg_status etcher_axis_solve(etcher_axis_t *self, const sg_real *restrict free,
                               const sg_real *restrict low, const sg_real *restrict high,
                               sg_real *restrict rows, sg_real *restrict z, int32_t *iterations)
{
    sg_status status = SG_BACKUP;
    int32_t entering = -1;
    int32_t side = 1;
    sg_real raised = (sg_real)0;
    sg_real excess = (sg_real)0;
    sg_real square = (sg_real)0;
    sg_real left = (sg_real)0;
    int32_t lost = 0;
    int32_t forced = 0;
    int32_t kept = (self->size >= ETCHER_AXIS_KEEP) ? 1 : 0;
    int32_t refining = 0;
    int32_t stalled = 0;
    sg_real step[ETCHER_AXIS_VARIABLES];
    if (self->waited > 0) {
        kept = 0;
        refining = sg_bound_count(self->refining, 0, 1);
        forced = sg_bound_count(self->forced, 0, 1);
        stalled = sg_bound_count(self->stalled, 0, 1);
        if (self->pending == 1) {
            const int32_t at = sg_bound_count(self->size, 0, ETCHER_AXIS_VARIABLES - 1);
            entering = self->row[at];
            side = self->side[at];
            raised = self->dual[at];
            excess = self->missed[at];
        }
        etcher_axis_resume(self, free, low, high, rows, z);
    } else {
        etcher_axis_begin(self);
        (void)etcher_axis_measure(self, rows, low, high);
    }
    SG_PRAGMA("MUST_ITERATE(1, 45)")
    for (int k = 0; k < ETCHER_AXIS_ITERATION_CAP; k++) {
        int32_t dropped = 0;
        *iterations = k + 1;
        if (entering < 0) {
            dropped = etcher_axis_descend(self, step);
            if ((dropped & kept) == 1) {
                /* the set kept is not the right one: perhaps none is needed, as for a new one */
                if (!(etcher_axis_worst(rows, low, high) > etcher_axis_tolerance)) {
                    self->size = 0;
                    sg_copy(ETCHER_AXIS_VARIABLES, free, z);
                    status = SG_OK;
                }
            }
            kept = 0;
            if (dropped == 1) {
                refining = 0;
                stalled = 0;
            } else {
                /* a refinement goes on from z, what is left is then as small as its step; every other one anew */
                if (refining == 1) {
                    etcher_axis_less(self, step, z);
                    for (int i = 0; i < ETCHER_AXIS_VARIABLES; i++) {
                        z[i] = etcher_axis_within(z[i]);
                    }
                } else {
                    sg_copy(ETCHER_AXIS_VARIABLES, free, z);
                    etcher_axis_less(self, self->dual, z);
                }
                excess = etcher_axis_violation(self->start, z, low, high, rows);
                if (excess > etcher_axis_tolerance) {
                    const int32_t row = etcher_axis_where(rows, low, high, excess);
                    raised = (sg_real)0;
                    side = -1;
                    if ((rows[row] - high[row]) >= (low[row] - rows[row])) {
                        side = 1;
                    }
                    entering = etcher_axis_new(self, row, rows, low, high);
                    if (entering >= 0) {
                        refining = 0;
                        stalled = 0;
                    } else {
                        refining = 1 - refining;
                        stalled = 1;
                        if (low[row] > high[row]) {
                            status = SG_INFEASIBLE;
                        }
                    }
                } else {
                    const sg_real least = etcher_axis_measure(self, rows, low, high);
                    if (least >= -etcher_axis_tolerance) {
                        status = SG_OK;
                    }
                    refining = 1; /* else rounding has left a row of the set inside: once more */
                    stalled = 1;
                }
            }
        }
        if (entering >= 0) {
            const sg_real least = (forced == 1) ? etcher_axis_rounding : etcher_axis_dependent;
            if (etcher_axis_append(self, entering, side, least, &square, &left) == 1) {
                const int32_t last = sg_bound_count(self->size - 1, 0, ETCHER_AXIS_VARIABLES - 1);
                self->dual[last] = raised;
                self->missed[last] = excess;
                entering = -1;
                forced = 0;
            } else {
                const sg_real gained = etcher_axis_make_room(self, square);
                forced = 0;
                if (gained < (sg_real)0) { /* one that depends only nearly is appended after all */
                    if (self->size < ETCHER_AXIS_VARIABLES) {
                        forced = (left > (etcher_axis_rounding * square)) ? 1 : 0; /* else it is rounding */
                    }
                    lost = 1 - forced;
                }
                raised = sg_bound(raised + sg_max(gained, (sg_real)0), (sg_real)0, etcher_axis_large);
            }
        }
        const int32_t over = (status != SG_BACKUP) ? 1 : lost;
        if (over == 1) {
            break;
        }
    }
    if (lost == 1) {
        if (etcher_axis_no_point(self, rows, excess, left) == 1) {
            status = SG_INFEASIBLE;
        }
    }
    /* rows that contradict are no beginning for another program, nor is a set that is full of them */
    const int32_t useless = (status == SG_INFEASIBLE) ? 1 : lost;
    if (useless > 0) {
        etcher_axis_forget(self);
    } else {
        etcher_axis_leave(self, entering, side, raised, excess);
        self->refining = refining;
        self->forced = forced;
        self->stalled = (status == SG_BACKUP) ? stalled : 0;
    }
    return status;
}

/* What the rows start from: the state in their units, positions counted from its own. */
static void etcher_axis_start(etcher_axis_t *self, const sg_real *restrict state)
{
    SG_PRAGMA("MUST_ITERATE(3, 3)")
    for (int i = 0; i < ETCHER_AXIS_PLANT_ORDER; i++) {
        self->start[i] = state[i] * etcher_axis_start_scale[i];
    }
    self->start[0] = (sg_real)0;
    self->start[ETCHER_AXIS_PLANT_ORDER] = (sg_real)0;
}

/* The rows of `plan` from there. */
static void etcher_axis_foreseen(etcher_axis_t *self, sg_real origin, const sg_real *restrict plan)
{
    SG_PRAGMA("MUST_ITERATE(41, 41)")
    for (int i = 0; i < ETCHER_AXIS_VARIABLES; i++) {
        self->relative[i] = plan[i] - origin;
    }
    etcher_axis_rows(self->start, self->relative, self->rows);
}

/* A row that moves with the position is bounded about the middle of its range, another about zero. */
static void etcher_axis_limit(etcher_axis_t *self, int32_t row, sg_real middle, sg_real limit)
{
    self->above[row] = (middle + limit) - etcher_axis_margin;
    self->below[row] = (middle - limit) + etcher_axis_margin;
}

/* And by the positions allowed in an interval. */
static void etcher_axis_allow(etcher_axis_t *self, int32_t row, int32_t interval, sg_real settle, sg_real origin,
                          const etcher_axis_step_in *in)
{
    const sg_real high = ((in->high[interval] - origin) * etcher_axis_position_scale) - settle;
    const sg_real low = ((in->low[interval] - origin) * etcher_axis_position_scale) + settle;
    self->above[row] = sg_min(self->above[row], high - etcher_axis_margin);
    self->below[row] = sg_max(self->below[row], low + etcher_axis_margin);
}

/* Bounds of the rows, relative to the position, drawn in by the margin. */
static void etcher_axis_bounds(etcher_axis_t *self, sg_real origin, const etcher_axis_step_in *in)
{
    const sg_real middle = (etcher_axis_centre - origin) * etcher_axis_position_scale;
    SG_PRAGMA("MUST_ITERATE(41, 41)")
    for (int32_t k = 0; k < ETCHER_AXIS_VARIABLES; k++) {
        SG_PRAGMA("MUST_ITERATE(6, 6)")
        for (int32_t i = 0; i < ETCHER_AXIS_ROWS_PER_STEP; i++) {
            const int32_t row = (k * ETCHER_AXIS_ROWS_PER_STEP) + i;
            etcher_axis_limit(self, row, (etcher_axis_step_moves[i] == 1) ? middle : (sg_real)0, etcher_axis_step_limit[i]);
            if (etcher_axis_step_stroke[i] > 0) {
                etcher_axis_allow(self, row, k, (sg_real)0, origin, in);
            }
            if (etcher_axis_step_stroke[i] > 1) {
                etcher_axis_allow(self, row, k + 1, (sg_real)0, origin, in);
            }
        }
    }
    SG_PRAGMA("MUST_ITERATE(34, 34)")
    for (int32_t i = 0; i < ETCHER_AXIS_TERMINAL_ROWS; i++) {
        const int32_t row = (ETCHER_AXIS_ROWS - ETCHER_AXIS_TERMINAL_ROWS) + i;
        const sg_real settle = (i == (ETCHER_AXIS_TERMINAL_ROWS - 1)) ? etcher_axis_settle : (sg_real)0;
        etcher_axis_limit(self, row, (etcher_axis_end_moves[i] == 1) ? middle : (sg_real)0, etcher_axis_end_limit[i]);
        if (etcher_axis_end_stroke[i] > 0) {
            etcher_axis_allow(self, row, ETCHER_AXIS_INTERVALS - 1, settle, origin, in);
        }
    }
}

/* Property (b): the moved plan, held to the true bounds from the measured state. */
static sg_status etcher_axis_judge(etcher_axis_t *self, sg_real origin, const sg_real *restrict plan)
{
    sg_status status = SG_BACKUP;
    etcher_axis_foreseen(self, origin, plan);
    SG_PRAGMA("MUST_ITERATE(280, 280)")
    for (int i = 0; i < ETCHER_AXIS_ROWS; i++) {
        if (self->rows[i] > (self->above[i] + etcher_axis_margin)) {
            status = SG_INFEASIBLE;
        }
        if (self->rows[i] < (self->below[i] - etcher_axis_margin)) {
            status = SG_INFEASIBLE;
        }
    }
    return status;
}

/* The optimum in self->relative: the references themselves where all bounds hold there. */
static sg_status etcher_axis_optimum(etcher_axis_t *self, int32_t *iterations)
{
    sg_status status = SG_OK;
    int32_t inside = 0;
    if (self->size >= ETCHER_AXIS_KEEP) {
        etcher_axis_rows(self->start, self->free_plan, self->rows); /* a large set is tried first */
    } else {
        const sg_real excess =
            etcher_axis_violation(self->start, self->free_plan, self->below, self->above, self->rows);
        inside = (excess > etcher_axis_tolerance) ? 0 : 1;
    }
    if (inside == 1) {
        self->size = 0;
        sg_copy(ETCHER_AXIS_VARIABLES, self->free_plan, self->relative);
    } else {
        status = etcher_axis_solve(self, self->free_plan, self->below, self->above, self->rows,
                               self->relative, iterations);
    }
    return status;
}

/* Whether this is next to the end of the plan before. */
static int32_t etcher_axis_near(sg_real where, sg_real rest)
{
    int32_t near = 1;
    if (where < (rest - etcher_axis_standing)) {
        near = 0;
    }
    if (where > (rest + etcher_axis_standing)) {
        near = 0;
    }
    return near;
}

/* Whether the stage is there and the new plan leaves it there. */
static int32_t etcher_axis_stands(const etcher_axis_t *self, sg_real position, sg_real rest)
{
    int32_t stands = etcher_axis_near(position, rest);
    stands *= etcher_axis_near(self->predicted[0], rest);
    SG_PRAGMA("MUST_ITERATE(41, 41)")
    for (int i = 0; i < ETCHER_AXIS_VARIABLES; i++) {
        stands *= etcher_axis_near(self->plan[i], rest);
    }
    return stands;
}

/* The next step begins anew. */
static void etcher_axis_go_on_with_none(etcher_axis_t *self)
{
    self->waited = 0;
    etcher_axis_drop_stalled(self);
}

/* A stage at rest has the same program again, as long as the points and so its bounds stay. Begun anew it
 * would be at the cap for ever: the next step goes on with it. After PATIENCE steps the plan at rest is its
 * answer. */
static sg_status etcher_axis_patient(etcher_axis_t *self, sg_status status, int32_t standing)
{
    const int32_t waits = (status == SG_BACKUP) ? standing : 0;
    if (waits == 1) {
        self->waited = sg_bound_count(self->waited + 1, 0, ETCHER_AXIS_PATIENCE);
    } else {
        etcher_axis_go_on_with_none(self);
    }
    return (self->waited == ETCHER_AXIS_PATIENCE) ? SG_SUBOPTIMAL : status;
}

/* All inputs are in range. */
static sg_status etcher_axis_govern(etcher_axis_t *self, const etcher_axis_step_in *in, int32_t *iterations,
                               int32_t *standing)
{
    const sg_real rest = self->plan[ETCHER_AXIS_VARIABLES - 1];
    sg_real state[ETCHER_AXIS_PLANT_ORDER];
    sg_real plan[ETCHER_AXIS_VARIABLES];
    state[0] = in->position;
    state[1] = in->velocity;
    state[2] = in->acceleration;
    const sg_real origin = state[0];
    SG_PRAGMA("MUST_ITERATE(41, 41)")
    for (int i = 0; i < ETCHER_AXIS_VARIABLES; i++) {
        self->free_plan[i] = in->reference[i] - origin;
    }
    etcher_axis_start(self, state);
    etcher_axis_bounds(self, origin, in);
    sg_status status = etcher_axis_optimum(self, iterations);
    if (status == SG_OK) {
        SG_PRAGMA("MUST_ITERATE(41, 41)")
        for (int i = 0; i < ETCHER_AXIS_VARIABLES; i++) {
            plan[i] = self->relative[i] + origin;
        }
    } else {
        etcher_axis_move(self, plan);
        status = etcher_axis_judge(self, origin, plan);
    }
    etcher_axis_accept(self, state, plan);
    *standing = etcher_axis_stands(self, origin, rest);
    return etcher_axis_patient(self, status, *standing);
}

/* Go on with the plan, from the state predicted. */
static void etcher_axis_continue(etcher_axis_t *self)
{
    sg_real state[ETCHER_AXIS_PLANT_ORDER];
    sg_real plan[ETCHER_AXIS_VARIABLES];
    sg_copy(ETCHER_AXIS_PLANT_ORDER, self->predicted, state);
    etcher_axis_move(self, plan);
    etcher_axis_accept(self, state, plan);
    etcher_axis_go_on_with_none(self);
}

void etcher_axis_init(etcher_axis_t *self)
{
    sg_fill(ETCHER_AXIS_VARIABLES, (sg_real)0, self->plan);
    sg_fill(ETCHER_AXIS_PLANT_ORDER, (sg_real)0, self->predicted);
    sg_fill(ETCHER_AXIS_VARIABLES, (sg_real)0, self->dual);
    sg_fill(ETCHER_AXIS_VARIABLES, (sg_real)0, self->missed);
    sg_fill(ETCHER_AXIS_VARIABLES, (sg_real)0, self->pivots);
    sg_fill(ETCHER_AXIS_VARIABLES, (sg_real)0, self->square);
    sg_fill(ETCHER_AXIS_FACTOR, (sg_real)0, self->factor);
    sg_fill(ETCHER_AXIS_VECTORS, (sg_real)0, self->vectors);
    SG_PRAGMA("MUST_ITERATE(41, 41)")
    for (int i = 0; i < ETCHER_AXIS_VARIABLES; i++) {
        self->row[i] = 0;
    }
    SG_PRAGMA("MUST_ITERATE(41, 41)")
    for (int i = 0; i < ETCHER_AXIS_VARIABLES; i++) {
        self->side[i] = 0;
    }
    SG_PRAGMA("MUST_ITERATE(41, 41)")
    for (int i = 0; i < ETCHER_AXIS_VARIABLES; i++) {
        self->slot[i] = 0;
    }
    self->size = 0;
    self->pending = 0;
    self->refining = 0;
    self->forced = 0;
    self->stalled = 0;
    self->waited = 0;
    sg_fill(ETCHER_AXIS_VARIABLES, (sg_real)0, self->relative);
    sg_fill(ETCHER_AXIS_STATES, (sg_real)0, self->start);
    sg_fill(ETCHER_AXIS_VARIABLES, (sg_real)0, self->free_plan);
    sg_fill(ETCHER_AXIS_ROWS, (sg_real)0, self->below);
    sg_fill(ETCHER_AXIS_ROWS, (sg_real)0, self->above);
    sg_fill(ETCHER_AXIS_ROWS, (sg_real)0, self->rows);
    self->ready = 0;
}

sg_status etcher_axis_reset(etcher_axis_t *self, const etcher_axis_reset_in *in)
{
    sg_status status = SG_OK;
    /*@ dynamic_split status; */
    status = sg_worse(status, sg_check(in->position, -0.375, 0.375));
    self->ready = (status == SG_OK) ? 1 : 0;
    const sg_real where = (status == SG_OK) ? in->position : etcher_axis_centre;
    sg_fill(ETCHER_AXIS_VARIABLES, where, self->plan);
    sg_fill(ETCHER_AXIS_PLANT_ORDER, (sg_real)0, self->predicted);
    self->predicted[0] = where;
    self->waited = 0;
    etcher_axis_forget(self);
    /*@ merge status; */
    return status;
}

/* What is in reach of all positions in an interval is in reach of this one too. */
static void etcher_axis_reach_from(sg_real position, int32_t interval, sg_real settle, etcher_axis_foresee_out *out)
{
    out->greatest[interval] = sg_min(out->greatest[interval], position - settle);
    out->least[interval] = sg_max(out->least[interval], position + settle);
}

sg_status etcher_axis_foresee(etcher_axis_t *self, const etcher_axis_foresee_in *in, etcher_axis_foresee_out *out)
{
    sg_real state[ETCHER_AXIS_PLANT_ORDER];
    sg_real plan[ETCHER_AXIS_VARIABLES];
    sg_status status = SG_OK;
    /*@ dynamic_split status; */
    status = sg_worse(status, sg_check(in->position, -0.375, 0.375));
    status = sg_worse(status, sg_check(in->velocity, -0.4, 0.4));
    status = sg_worse(status, sg_check(in->acceleration, -40.0, 40.0));
    if (self->ready == 0) {
        status = SG_NOT_READY;
    }
    state[0] = (status == SG_OK) ? in->position : self->predicted[0];
    state[1] = (status == SG_OK) ? in->velocity : self->predicted[1];
    state[2] = (status == SG_OK) ? in->acceleration : self->predicted[2];
    etcher_axis_start(self, state);
    etcher_axis_move(self, plan);
    etcher_axis_foreseen(self, state[0], plan);
    sg_fill(ETCHER_AXIS_INTERVALS, -etcher_axis_farthest, out->least);
    sg_fill(ETCHER_AXIS_INTERVALS, etcher_axis_farthest, out->greatest);
    out->least[0] = (sg_real)0; /* the position at which the first interval begins */
    out->greatest[0] = (sg_real)0;
    SG_PRAGMA("MUST_ITERATE(41, 41)")
    for (int32_t k = 0; k < ETCHER_AXIS_VARIABLES; k++) {
        SG_PRAGMA("MUST_ITERATE(6, 6)")
        for (int32_t i = 0; i < ETCHER_AXIS_ROWS_PER_STEP; i++) {
            const sg_real row = self->rows[(k * ETCHER_AXIS_ROWS_PER_STEP) + i];
            if (etcher_axis_step_stroke[i] > 0) {
                etcher_axis_reach_from(row, k, (sg_real)0, out);
            }
            if (etcher_axis_step_stroke[i] > 1) {
                etcher_axis_reach_from(row, k + 1, (sg_real)0, out);
            }
        }
    }
    SG_PRAGMA("MUST_ITERATE(34, 34)")
    for (int32_t i = 0; i < ETCHER_AXIS_TERMINAL_ROWS; i++) {
        const sg_real row = self->rows[(ETCHER_AXIS_ROWS - ETCHER_AXIS_TERMINAL_ROWS) + i];
        const sg_real settle = (i == (ETCHER_AXIS_TERMINAL_ROWS - 1)) ? etcher_axis_settle : (sg_real)0;
        if (etcher_axis_end_stroke[i] > 0) {
            etcher_axis_reach_from(row, ETCHER_AXIS_INTERVALS - 1, settle, out);
        }
    }
    SG_PRAGMA("MUST_ITERATE(42, 42)")
    for (int i = 0; i < ETCHER_AXIS_INTERVALS; i++) {
        out->least[i] = ((out->least[i] - etcher_axis_in_reach) * etcher_axis_unit) + state[0];
        out->greatest[i] = ((out->greatest[i] + etcher_axis_in_reach) * etcher_axis_unit) + state[0];
    }
    /*@ merge status; */
    return status;
}

sg_status etcher_axis_step(etcher_axis_t *self, const etcher_axis_step_in *in, etcher_axis_step_out *out)
{
    sg_status status = SG_OK;
    /*@ dynamic_split status; */
    status = sg_worse(status, sg_check(in->position, -0.375, 0.375));
    status = sg_worse(status, sg_check(in->velocity, -0.4, 0.4));
    status = sg_worse(status, sg_check(in->acceleration, -40.0, 40.0));
    status = sg_worse(status, sg_check_array(41, in->reference, -0.375, 0.375));
    status = sg_worse(status, sg_check_array(42, in->low, -0.425, 0.425));
    status = sg_worse(status, sg_check_array(42, in->high, -0.425, 0.425));
    int32_t iterations = 0;
    int32_t standing = 0;
    if (self->ready == 0) {
        status = SG_NOT_READY;
    } else if (status != SG_OK) {
        etcher_axis_continue(self);
    } else {
        status = etcher_axis_govern(self, in, &iterations, &standing);
    }
    out->command = (self->ready == 0) ? etcher_axis_centre : self->plan[0];
    out->iterations = iterations;
    out->standing = standing;
    /*@ merge status; */
    return status;
}

sg_status etcher_axis_predict(const etcher_axis_t *self, const etcher_axis_predict_in *in, etcher_axis_predict_out *out)
{
    sg_real state[ETCHER_AXIS_PLANT_ORDER];
    sg_real ahead[ETCHER_AXIS_PLANT_ORDER];
    sg_status status = SG_OK;
    /*@ dynamic_split status; */
    status = sg_worse(status, sg_check(in->position, -0.375, 0.375));
    status = sg_worse(status, sg_check(in->velocity, -0.4, 0.4));
    status = sg_worse(status, sg_check(in->acceleration, -40.0, 40.0));
    if (self->ready == 0) {
        status = SG_NOT_READY;
    }
    sg_copy(ETCHER_AXIS_PLANT_ORDER, self->predicted, ahead);
    if (status == SG_OK) {
        state[0] = in->position;
        state[1] = in->velocity;
        state[2] = in->acceleration;
        etcher_axis_advance(self, state, ahead);
    }
    out->position = ahead[0];
    out->velocity = ahead[1];
    out->acceleration = ahead[2];
    /*@ merge status; */
    return status;
}
