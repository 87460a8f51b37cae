/* SPDX-License-Identifier: MIT */
/*
 * Made by servogen 0.1.0 from servo_pid.c.jinja; not to be edited.
 * Design 194d8956393bab306f4e51be322f6fe719d57e926f5156d4a75b3bef48eebba1.
 *
 * Cascaded PID of a servo axis with the notch filter of its current loop
 *
 * Counted in this C, calls of other files included (servogen wcet): operations on headstock_real, bytes
 * of C objects on the stack. Constant tables of this file: 64 bytes.
 *
 * worst case of one call    add mul div cmp other load store stack
 * headstock_pid_init          0   0   0   0     0    0     5     4
 * headstock_pid_reset         0   0   0   5     0    2     6    28
 * headstock_pid_step         14   8   0  26     8   29     6   124
 * headstock_pid_filter_step   4   5   0   6     2   16     4    56
 */
#include "headstock_pid.h"
#include "headstock_scalar.h"
#include "sg_angle.h"
#include "headstock_pid_tables.h"

/* Speed loop: what it asks for is limited, and its integral takes on nothing that would ask for more. */
static void headstock_pid_speed_loop(headstock_pid_t *self, sg_real error)
{
    const sg_real direct = headstock_pid_velocity_gain * error;
    sg_real integral = self->integral + (headstock_pid_integral_gain * error);
    const sg_real wanted = direct + integral;
    if (wanted > headstock_pid_limit_high) {
        integral = self->integral;
    }
    if (wanted < headstock_pid_limit_low) {
        integral = self->integral;
    }
    self->integral = sg_clamp(integral, headstock_pid_limit_low, headstock_pid_limit_high);
    self->wanted = sg_clamp(direct + self->integral, headstock_pid_limit_low, headstock_pid_limit_high);
}

/* The speed since the last usable measurement, zero without one now. */
static sg_status headstock_pid_measure(headstock_pid_t *self, const headstock_pid_step_in *in, sg_real *speed)
{
    sg_status status = SG_OK;
    /*@ dynamic_split status; */
    status = sg_worse(status, sg_check(in->position, -36000.0f, 36000.0f));
    *speed = (sg_real)0;
    if (status == SG_OK) {
        const sg_real moved = sg_shortest(in->position - self->last, headstock_pid_turn, headstock_pid_half_turn, headstock_pid_turn_inverse);
        *speed = moved * headstock_pid_rate;
        self->last = in->position;
    }
    /*@ merge status; */
    return status;
}

/* Position loop; without a usable input nothing is asked for. */
static sg_status headstock_pid_position_loop(headstock_pid_t *self, const headstock_pid_step_in *in, sg_status seen,
                                       sg_real speed)
{
    sg_status status = seen;
    /*@ dynamic_split status; */
    status = sg_worse(status, sg_check(in->reference, -36000.0f, 36000.0f));
    if (status == SG_OK) {
        const sg_real error = sg_shortest(in->reference - self->last, headstock_pid_turn, headstock_pid_half_turn, headstock_pid_turn_inverse);
        headstock_pid_speed_loop(self, (headstock_pid_position_gain * error) - speed);
    } else {
        self->integral = (sg_real)0;
        self->wanted = (sg_real)0;
    }
    /*@ merge status; */
    return status;
}

void headstock_pid_init(headstock_pid_t *self)
{
    self->last = (sg_real)0;
    self->integral = (sg_real)0;
    self->wanted = (sg_real)0;
    self->memory_1 = (sg_real)0;
    self->memory_2 = (sg_real)0;
    self->ready = 0;
}

sg_status headstock_pid_reset(headstock_pid_t *self, const headstock_pid_reset_in *in)
{
    sg_status status = SG_OK;
    /*@ dynamic_split status; */
    status = sg_worse(status, sg_check(in->position, -36000.0f, 36000.0f));
    headstock_pid_init(self);
    if (status == SG_OK) {
        self->ready = 1;
        self->last = in->position;
    }
    /*@ merge status; */
    return status;
}

sg_status headstock_pid_step(headstock_pid_t *self, const headstock_pid_step_in *in, headstock_pid_step_out *out)
{
    sg_status status = SG_NOT_READY;
    if (self->ready == 1) {
        sg_real speed;
        const sg_status seen = headstock_pid_measure(self, in, &speed);
        status = headstock_pid_position_loop(self, in, seen, speed);
    }
    out->wanted = self->wanted;
    return status;
}

sg_status headstock_pid_filter_step(headstock_pid_t *self, headstock_pid_filter_step_out *out)
{
    sg_status status = SG_NOT_READY;
    out->current = (sg_real)0;
    if (self->ready == 1) {
        const sg_real output = (headstock_pid_b0 * self->wanted) + self->memory_1;
        const sg_real first = ((headstock_pid_b1 * self->wanted) - (headstock_pid_a1 * output)) + self->memory_2;
        const sg_real second = (headstock_pid_b2 * self->wanted) - (headstock_pid_a2 * output);
        /* a stable filter of a bounded current */
        self->memory_1 = sg_bound(first, -headstock_pid_most_1, headstock_pid_most_1);
        self->memory_2 = sg_bound(second, -headstock_pid_most_2, headstock_pid_most_2);
        out->current = sg_clamp(output, headstock_pid_limit_low, headstock_pid_limit_high);
        status = SG_OK;
    }
    return status;
}
