/* SPDX-License-Identifier: MIT */
/*
 * One turn of parallel quadratic programming on two-sided rows, low <= A z <= high, with its two
 * accelerations. m rows, n variables; "upper" and "lower" are the duals of the two sides. The dual
 * Hessian [[D, -D], [-D, D]] is never formed: see the Python module qp/pqp.py for the argument.
 */
#ifndef SG_PQP_H
#define SG_PQP_H

#include "sg_kernels.h"
#include "sg_quotient.h"

/* What an iterate tells: its worst slack (negative: violated), where, and the duality gap. */
typedef struct {
    sg_real worst;
    sg_real gap;
    int32_t row;
    int32_t is_lower;
} sg_pqp_state;

/* Slacks and gap of an iterate from `change` = A H^-1 A' (upper - lower). */
static inline void sg_pqp_evaluate(int m, const sg_real *restrict upper,
                                   const sg_real *restrict lower,
                                   const sg_real *restrict slack_upper,
                                   const sg_real *restrict slack_lower,
                                   const sg_real *restrict change, sg_pqp_state *restrict state)
{
    state->worst = slack_upper[0] + change[0];
    state->row = 0;
    state->is_lower = 0;
    sg_real gap = (sg_real)0;
    SG_PRAGMA("MUST_ITERATE(1)")
    for (int i = 0; i < m; i++) {
        const sg_real r_upper = slack_upper[i] + change[i];
        const sg_real r_lower = slack_lower[i] - change[i];
        if (r_upper < state->worst) {
            state->worst = r_upper;
            state->row = i;
            state->is_lower = 0;
        }
        if (r_lower < state->worst) {
            state->worst = r_lower;
            state->row = i;
            state->is_lower = 1;
        }
        gap += (upper[i] * r_upper) + (lower[i] * r_lower);
    }
    state->gap = gap;
}

/*
 * sum >= |D| (upper + lower), which is all that (20) asks of it. A pair of duals below its floor counts
 * as if it stood there; what all pairs give at their floors is the table `at_floor`. The same row of
 * four steps shares one column, the first 4 `blocks` steps over; each row after them has its own.
 * Both sizes of `columns` are filled up to a multiple of four; four columns are skipped where all
 * their pairs are at the floor.
 */
static inline void sg_pqp_majorant(int m, int per_step, int blocks, int lines, int stride,
                                   const sg_real *restrict columns,
                                   const sg_real *restrict at_floor,
                                   const sg_real *restrict floor_table,
                                   const sg_real *restrict root_diagonal,
                                   const sg_real *restrict upper, const sg_real *restrict lower,
                                   sg_real *restrict above, sg_real *restrict shared,
                                   sg_real *restrict sum)
{
    const sg_real zero = (sg_real)0;
    const int grouped = per_step * blocks;
    SG_PRAGMA("MUST_ITERATE(1)")
    for (int i = 0; i < m; i++) {
        const sg_real pair = (upper[i] + lower[i]) - (floor_table[i] + floor_table[i]);
        above[i] = root_diagonal[i] * sg_max(pair, zero);
    }
    sg_fill(4, zero, &shared[lines - 4]);
    for (int block = 0; block < blocks; block++) {
        const sg_real *restrict four = &above[4 * per_step * block];
        for (int i = 0; i < per_step; i++) {
            shared[(per_step * block) + i] =
                ((four[i] + four[per_step + i]) + four[(2 * per_step) + i]) + four[(3 * per_step) + i];
        }
    }
    for (int i = 4 * grouped; i < m; i++) {
        shared[i - (3 * grouped)] = above[i];
    }
    sg_copy(stride, at_floor, sum);
    SG_PRAGMA("MUST_ITERATE(1)")
    for (int32_t j = 0; j < lines; j += 4) {
        const sg_real x0 = shared[j];
        const sg_real x1 = shared[j + 1];
        const sg_real x2 = shared[j + 2];
        const sg_real x3 = shared[j + 3];
        if (sg_max(sg_max(x0, x1), sg_max(x2, x3)) > zero) {
            const sg_real *restrict c0 = &columns[j * stride];
            const sg_real *restrict c1 = &columns[(j + 1) * stride];
            const sg_real *restrict c2 = &columns[(j + 2) * stride];
            const sg_real *restrict c3 = &columns[(j + 3) * stride];
            SG_PRAGMA("MUST_ITERATE(4)")
            for (int i = 0; i < stride; i++) {
                sum[i] = (((sum[i] + (c0[i] * x0)) + (c1[i] * x1)) + (c2[i] * x2)) + (c3[i] * x3);
            }
        }
    }
}

/* (20) on both sides of every row, with `absolute` of sg_pqp_majorant; keeps the last iterate. */
static inline void sg_pqp_multiply(int m, const sg_real *restrict absolute,
                                   const sg_real *restrict phi_diagonal,
                                   const sg_real *restrict vanish,
                                   const sg_real *restrict ceiling,
                                   const sg_real *restrict slack_upper,
                                   const sg_real *restrict slack_lower,
                                   const sg_real *restrict change, sg_real *restrict upper,
                                   sg_real *restrict lower, sg_real *restrict last_upper,
                                   sg_real *restrict last_lower, sg_real *restrict last_change)
{
    const sg_real zero = (sg_real)0;
    const sg_real half = (sg_real)0.5;
    SG_PRAGMA("MUST_ITERATE(1)")
    for (int i = 0; i < m; i++) {
        const sg_real plus = sg_max(half * (absolute[i] + change[i]), zero);
        const sg_real minus = sg_max(half * (absolute[i] - change[i]), zero);
        const sg_real keep_upper = phi_diagonal[i] * upper[i];
        const sg_real keep_lower = phi_diagonal[i] * lower[i];
        const sg_real up = (minus + keep_upper) + sg_max(-slack_upper[i], zero);
        const sg_real down = (plus + keep_upper) + sg_max(slack_upper[i], zero);
        const sg_real low_up = (plus + keep_lower) + sg_max(-slack_lower[i], zero);
        const sg_real low_down = (minus + keep_lower) + sg_max(slack_lower[i], zero);
        last_upper[i] = upper[i];
        last_lower[i] = lower[i];
        last_change[i] = change[i];
        upper[i] = sg_clamp(SG_DIVIDE(upper[i] * up, down), vanish[i], ceiling[i]);
        lower[i] = sg_clamp(SG_DIVIDE(lower[i] * low_up, low_down), vanish[i], ceiling[i]);
    }
}

/* Exact minimum of the dual along the multiplier of the most violated row. */
static inline void sg_pqp_coordinate(const sg_real *restrict inverse_diagonal,
                                     const sg_real *restrict vanish,
                                     const sg_real *restrict ceiling,
                                     const sg_pqp_state *restrict state, sg_real *restrict upper,
                                     sg_real *restrict lower)
{
    const int32_t row = state->row;
    sg_real *const target = (state->is_lower == 1) ? lower : upper;
    /* the row is violated, worst < 0: its dual grows from at least `vanish` */
    const sg_real raised =
        sg_bound_below(target[row] - (state->worst * inverse_diagonal[row]), vanish[row]);
    target[row] = sg_min(raised, ceiling[row]);
}

/*
 * Exact line search along the last step of (20); the duals that matter stay positive. Two duals, both
 * at least `vanish`, are equal or differ by more than `least_step`: comparing with it instead of with
 * zero changes nothing, and bounds the quotient.
 */
static inline void sg_pqp_extrapolate(int m, const sg_real *restrict diagonal,
                                      const sg_real *restrict vanish,
                                      const sg_real *restrict ceiling, sg_real clamp, sg_real room,
                                      sg_real weight, sg_real least_step,
                                      sg_real least_curvature, sg_real longest,
                                      const sg_real *restrict slack_upper,
                                      const sg_real *restrict slack_lower,
                                      const sg_real *restrict change, sg_real *restrict upper,
                                      sg_real *restrict lower,
                                      const sg_real *restrict last_upper,
                                      const sg_real *restrict last_lower,
                                      const sg_real *restrict last_change)
{
    const sg_real zero = (sg_real)0;
    sg_real curvature = zero;
    sg_real slope = zero;
    sg_real largest = zero;
    SG_PRAGMA("MUST_ITERATE(1)")
    for (int i = 0; i < m; i++) {
        const sg_real step_upper = upper[i] - last_upper[i];
        const sg_real step_lower = lower[i] - last_lower[i];
        curvature += (step_upper - step_lower) * (change[i] - last_change[i]);
        slope += (step_upper * (slack_upper[i] + change[i])) +
                 (step_lower * (slack_lower[i] - change[i]));
        largest = sg_max(largest, sg_max(upper[i] * diagonal[i], lower[i] * diagonal[i]));
    }
    int32_t useful = 0;
    if (slope < zero) {
        if (curvature > zero) {
            useful = 1;
        }
    }
    if (useful == 1) {
        const sg_real level = weight * largest;
        /* a slope, a curvature or a length beyond these would leave the range of the scalar type */
        const sg_real descent = sg_bound(-slope, zero, longest);
        sg_real length = SG_DIVIDE(descent, sg_bound_below(curvature, least_curvature));
        length = sg_bound(length, zero, longest);
        SG_PRAGMA("MUST_ITERATE(1)")
        for (int i = 0; i < m; i++) {
            const sg_real step_upper = upper[i] - last_upper[i];
            const sg_real step_lower = lower[i] - last_lower[i];
            if (step_upper < -least_step) {
                if ((upper[i] * diagonal[i]) >= level) {
                    length = sg_min(length, SG_DIVIDE(room * upper[i], -step_upper));
                }
            }
            if (step_lower < -least_step) {
                if ((lower[i] * diagonal[i]) >= level) {
                    length = sg_min(length, SG_DIVIDE(room * lower[i], -step_lower));
                }
            }
        }
        SG_PRAGMA("MUST_ITERATE(1)")
        for (int i = 0; i < m; i++) {
            const sg_real step_upper = upper[i] - last_upper[i];
            const sg_real step_lower = lower[i] - last_lower[i];
            const sg_real new_upper = sg_max(upper[i] + (length * step_upper), clamp * upper[i]);
            const sg_real new_lower = sg_max(lower[i] + (length * step_lower), clamp * lower[i]);
            upper[i] = sg_clamp(new_upper, vanish[i], ceiling[i]);
            lower[i] = sg_clamp(new_lower, vanish[i], ceiling[i]);
        }
    }
}

#endif
