/* SPDX-License-Identifier: MIT */
/*
 * Made by servogen 0.1.0 from eva.c.jinja; not to be edited.
 * Design 2df8fd9b7b96227c8a47a2bccc487b135ad72d7fa713a19599e6540c03996ab1.
 *
 * What Frama-C Eva is given of two_stage_governor: every sequence of calls, from dirty memory on.
 * It claims of every call what the contract two_stage_governor_contract.c promises to the callers.
 */
#include "two_stage_governor.h"
#include "two_stage_eva.h"

/* The cases that sg_check keeps apart are one again: it has just seen a single one. */
static void sg_forget(void)
{
    (void)sg_check((sg_real)0, (sg_real)0, (sg_real)0);
}

static void held(const two_stage_governor_t *self)
{
    (void)self;
}

static void try_step(two_stage_governor_t *self)
{
    two_stage_governor_step_in in;
    two_stage_governor_step_out out;
    in.x_position = sg_draw(-0.6000000000000001, 0.6000000000000001);
    in.x_velocity = sg_draw(-2.8, 2.8);
    in.x_acceleration = sg_draw(-58.84, 58.84);
    in.y_position = sg_draw(-0.6000000000000001, 0.6000000000000001);
    in.y_velocity = sg_draw(-2.8, 2.8);
    in.y_acceleration = sg_draw(-58.84, 58.84);
    in.last_x = sg_draw(-0.4, 0.4);
    in.last_y = sg_draw(-0.4, 0.4);
    for (int i = 0; i < 150; i++) {
        in.points_x[i] = sg_draw(-0.4, 0.4);
    }
    for (int i = 0; i < 150; i++) {
        in.points_y[i] = sg_draw(-0.4, 0.4);
    }
    in.n_points = sg_draw_count(0, 150);
    const sg_status status = two_stage_governor_step(self, &in, &out);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    /*@ assert 0 <= out.points_taken <= 150; */ ;
    /*@ assert \is_finite(out.reference_x) && -0.4d <= out.reference_x <= 0.4d; */ ;
    /*@ assert \is_finite(out.low_x) && -0.4d <= out.low_x <= 0.4d; */ ;
    /*@ assert \is_finite(out.high_x) && -0.4d <= out.high_x <= 0.4d; */ ;
    /*@ assert \is_finite(out.reference_y) && -0.4d <= out.reference_y <= 0.4d; */ ;
    /*@ assert \is_finite(out.low_y) && -0.4d <= out.low_y <= 0.4d; */ ;
    /*@ assert \is_finite(out.high_y) && -0.4d <= out.high_y <= 0.4d; */ ;
    held(self);
    sg_forget();
}

int main(void)
{
    two_stage_governor_t self;
    two_stage_governor_init(&self);
    held(&self);
    /*@ widen_hints "all", 2, 3, 4, 5, 149, 150, 151; */
    while (Frama_C_nondet(0, 1) == 1) {
        switch (Frama_C_interval(0, 1)) {
        case 0:
            try_step(&self);
            break;
        default:
            two_stage_governor_init(&self);
            held(&self);
            break;
        }
    }
    return 0;
}
