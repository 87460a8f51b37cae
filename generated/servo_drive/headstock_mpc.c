/* SPDX-License-Identifier: MIT */
/*
 * Made by servogen 0.1.0 from servo_mpc.c.jinja; not to be edited.
 * Design 194d8956393bab306f4e51be322f6fe719d57e926f5156d4a75b3bef48eebba1.
 *
 * Trajectory-tracking MPC of a servo axis, with its Kalman filter
 *
 * Counted in this C, calls of other files included (servogen wcet): operations on headstock_real, bytes
 * of C objects on the stack. Constant tables of this file: 152 bytes.
 *
 * worst case of one call                      add mul div cmp other load store stack
 * headstock_mpc_init                            0   0   0   0     0    0    10    24
 * headstock_mpc_reset                           0   0   0   5     0    2     7    32
 * headstock_mpc_step                          107  77   0  74    36  208    68   208
 *   fixed part                                101  68   0  71    36  187    68
 *   each of 3 HEADSTOCK_MPC_LOOKUP_TREE_DEPTH   2   3   0   1     0    7     0
 */
#include "headstock_mpc.h"
#include "headstock_scalar.h"
#include "sg_angle.h"
#include "headstock_mpc_tables.h"

/*
 * The filter's correction by a measurement, if it is usable. Positions are taken relative to the last one
 * measured, turns off first, so that what is left is as small wherever the axis stands.
 */
static sg_status headstock_mpc_measure(headstock_mpc_t *self, const headstock_mpc_step_in *in)
{
    sg_status status = SG_OK;
    /*@ dynamic_split status; */
    status = sg_worse(status, sg_check(in->position, -36000.0f, 36000.0f));
    if (status == SG_OK) {
        sg_real innovation[HEADSTOCK_MPC_OUTPUTS];
        sg_real correction[HEADSTOCK_MPC_ORDER];
        SG_PRAGMA("MUST_ITERATE(1, 1)")
        for (int i = 0; i < HEADSTOCK_MPC_OUTPUTS; i++) {
            const sg_real moved = sg_shortest(in->position - self->last[i], headstock_mpc_turn, headstock_mpc_half_turn, headstock_mpc_turn_inverse);
            innovation[i] = sg_shortest(moved - self->drift[i], headstock_mpc_turn, headstock_mpc_half_turn, headstock_mpc_turn_inverse);
            self->last[i] = in->position;
        }
        sg_matvec(HEADSTOCK_MPC_ORDER, HEADSTOCK_MPC_OUTPUTS, headstock_mpc_gain_state, innovation, correction);
        /* no sequence of measurements makes more of it */
        SG_PRAGMA("MUST_ITERATE(4, 4)")
        for (int i = 0; i < HEADSTOCK_MPC_ORDER; i++) {
            self->increment[i] = sg_bound(self->increment[i] + correction[i], -headstock_mpc_bound[i], headstock_mpc_bound[i]);
        }
        sg_matvec(HEADSTOCK_MPC_OUTPUTS, HEADSTOCK_MPC_OUTPUTS, headstock_mpc_gain_output, innovation, self->drift);
    }
    /*@ merge status; */
    return status;
}

/* theta of the program: increments, last inputs, references relative to the position. */
static void headstock_mpc_parameter(const headstock_mpc_t *self, const sg_real *reference, sg_real *theta)
{
    sg_copy(HEADSTOCK_MPC_ORDER, self->increment, theta);
    sg_copy(HEADSTOCK_MPC_INPUTS, self->previous, &theta[HEADSTOCK_MPC_ORDER]);
    SG_PRAGMA("MUST_ITERATE(1, 1)")
    for (int32_t j = 0; j < HEADSTOCK_MPC_OUTPUTS; j++) {
        sg_real *ahead = &theta[HEADSTOCK_MPC_ORDER + HEADSTOCK_MPC_INPUTS + j];
        /* each from the one before, so that the axis may lag by nearly half a turn */
        sg_real before = self->last[j];
        sg_real total = (sg_real)0;
        SG_PRAGMA("MUST_ITERATE(3, 3)")
        for (int32_t i = 0; i < HEADSTOCK_MPC_TRAJECTORY; i++) {
            const sg_real here = reference[(i * HEADSTOCK_MPC_OUTPUTS) + j];
            total += sg_shortest(here - before, headstock_mpc_turn, headstock_mpc_half_turn, headstock_mpc_turn_inverse);
            ahead[i * HEADSTOCK_MPC_OUTPUTS] = total - self->drift[j];
            before = here;
        }
    }
}

/*
 * The first inputs of the optimum in `wanted`, if all is well; it is left alone where an input is not, and
 * zero where the program has no solution: the bounds have zero between them.
 */
static sg_status headstock_mpc_look_up(headstock_mpc_t *self, const headstock_mpc_step_in *in, sg_status seen, sg_real *wanted)
{
    sg_status status = seen;
    /*@ dynamic_split status; */
    status = sg_worse(status, sg_check_array(3, in->reference, -36000.0f, 36000.0f));
    if (status == SG_OK) {
        headstock_mpc_lookup_find_in ask;
        headstock_mpc_lookup_find_out told;
        /* sums of what was checked and of what is bounded: not looked at again */
        headstock_mpc_parameter(self, in->reference, ask.theta);
        status = headstock_mpc_lookup_solve(&self->lookup, &ask, &told);
        sg_copy(HEADSTOCK_MPC_INPUTS, told.move, wanted);
    }
    /*@ merge status; */
    return status;
}

/* What is expected of the next sample. */
static void headstock_mpc_predict(headstock_mpc_t *self, const sg_real *restrict current)
{
    sg_real change[HEADSTOCK_MPC_INPUTS];
    sg_real moved[HEADSTOCK_MPC_ORDER];
    sg_real driven[HEADSTOCK_MPC_ORDER];
    sg_real output[HEADSTOCK_MPC_OUTPUTS];
    SG_PRAGMA("MUST_ITERATE(1, 1)")
    for (int i = 0; i < HEADSTOCK_MPC_INPUTS; i++) {
        change[i] = current[i] - self->previous[i];
        self->previous[i] = current[i];
    }
    sg_matvec(HEADSTOCK_MPC_ORDER, HEADSTOCK_MPC_ORDER, headstock_mpc_on_state, self->increment, moved);
    sg_matvec(HEADSTOCK_MPC_ORDER, HEADSTOCK_MPC_INPUTS, headstock_mpc_on_input, change, driven);
    /* as in the correction; without measurements a drive that only just settles could go on */
    SG_PRAGMA("MUST_ITERATE(4, 4)")
    for (int i = 0; i < HEADSTOCK_MPC_ORDER; i++) {
        self->increment[i] = sg_bound(moved[i] + driven[i], -headstock_mpc_bound[i], headstock_mpc_bound[i]);
    }
    sg_matvec(HEADSTOCK_MPC_OUTPUTS, HEADSTOCK_MPC_ORDER, headstock_mpc_on_output, self->increment, output);
    SG_PRAGMA("MUST_ITERATE(1, 1)")
    for (int i = 0; i < HEADSTOCK_MPC_OUTPUTS; i++) {
        const sg_real drift = self->drift[i] + output[i];
        self->drift[i] = sg_shortest(drift, headstock_mpc_turn, headstock_mpc_half_turn, headstock_mpc_turn_inverse);
    }
}

void headstock_mpc_init(headstock_mpc_t *self)
{
    sg_fill(HEADSTOCK_MPC_ORDER, (sg_real)0, self->increment);
    sg_fill(HEADSTOCK_MPC_OUTPUTS, (sg_real)0, self->drift);
    sg_fill(HEADSTOCK_MPC_OUTPUTS, (sg_real)0, self->last);
    sg_fill(HEADSTOCK_MPC_INPUTS, (sg_real)0, self->previous);
    headstock_mpc_lookup_init(&self->lookup);
    self->ready = 0;
}

sg_status headstock_mpc_reset(headstock_mpc_t *self, const headstock_mpc_reset_in *in)
{
    sg_status status = SG_OK;
    /*@ dynamic_split status; */
    status = sg_worse(status, sg_check(in->position, -36000.0f, 36000.0f));
    self->ready = (status == SG_OK) ? 1 : 0;
    SG_PRAGMA("MUST_ITERATE(1, 1)")
    for (int i = 0; i < HEADSTOCK_MPC_OUTPUTS; i++) {
        self->last[i] = (status == SG_OK) ? in->position : (sg_real)0;
    }
    sg_fill(HEADSTOCK_MPC_ORDER, (sg_real)0, self->increment);
    sg_fill(HEADSTOCK_MPC_OUTPUTS, (sg_real)0, self->drift);
    sg_fill(HEADSTOCK_MPC_INPUTS, (sg_real)0, self->previous);
    /*@ merge status; */
    return status;
}

sg_status headstock_mpc_step(headstock_mpc_t *self, const headstock_mpc_step_in *in, headstock_mpc_step_out *out)
{
    sg_status status = SG_NOT_READY;
    sg_real current[HEADSTOCK_MPC_INPUTS];
    sg_fill(HEADSTOCK_MPC_INPUTS, (sg_real)0, current);
    if (self->ready == 1) {
        status = headstock_mpc_look_up(self, in, headstock_mpc_measure(self, in), current);
        SG_PRAGMA("MUST_ITERATE(1, 1)")
        for (int i = 0; i < HEADSTOCK_MPC_INPUTS; i++) {
            current[i] = sg_clamp(current[i], headstock_mpc_input_low[i], headstock_mpc_input_high[i]);
        }
        headstock_mpc_predict(self, current);
    }
    out->current = current[0];
    return status;
}
