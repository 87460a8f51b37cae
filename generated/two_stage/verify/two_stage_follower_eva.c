/* SPDX-License-Identifier: MIT */
/*
 * Made by servogen 0.1.0 from eva.c.jinja; not to be edited.
 * Design 2df8fd9b7b96227c8a47a2bccc487b135ad72d7fa713a19599e6540c03996ab1.
 *
 * What Frama-C Eva is given of two_stage_follower: every sequence of calls, from dirty memory on.
 * It claims of every call what the contract two_stage_follower_contract.c promises to the callers.
 */
#include "two_stage_follower.h"
#include "two_stage_eva.h"

/* The cases that sg_check keeps apart are one again: it has just seen a single one. */
static void sg_forget(void)
{
    (void)sg_check((sg_real)0, (sg_real)0, (sg_real)0);
}

static void held(const two_stage_follower_t *self)
{
    (void)self;
}

static void try_reset(two_stage_follower_t *self)
{
    two_stage_follower_reset_in in;
    in.position_x = sg_draw(-0.4, 0.4);
    in.position_y = sg_draw(-0.4, 0.4);
    const sg_status status = two_stage_follower_reset(self, &in);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    held(self);
    sg_forget();
}

static void try_push(two_stage_follower_t *self)
{
    two_stage_follower_push_in in;
    for (int i = 0; i < 150; i++) {
        in.points_x[i] = sg_draw(-0.4, 0.4);
    }
    for (int i = 0; i < 150; i++) {
        in.points_y[i] = sg_draw(-0.4, 0.4);
    }
    in.n_points = sg_draw_count(0, 150);
    const sg_status status = two_stage_follower_push(self, &in);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    held(self);
    sg_forget();
}

static void try_begin(two_stage_follower_t *self)
{
    two_stage_follower_begin_in in;
    two_stage_follower_begin_out out;
    in.x_position = sg_draw(-0.6000000000000001, 0.6000000000000001);
    in.x_velocity = sg_draw(-2.8, 2.8);
    in.x_acceleration = sg_draw(-58.84, 58.84);
    in.slow_command_x = sg_draw(-0.6000000000000001, 0.6000000000000001);
    in.y_position = sg_draw(-0.6000000000000001, 0.6000000000000001);
    in.y_velocity = sg_draw(-2.8, 2.8);
    in.y_acceleration = sg_draw(-58.84, 58.84);
    in.slow_command_y = sg_draw(-0.6000000000000001, 0.6000000000000001);
    const sg_status status = two_stage_follower_begin(self, &in, &out);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    /*@ assert 0 <= out.interval_points <= 150; */ ;
    held(self);
    sg_forget();
}

static void try_room(two_stage_follower_t *self)
{
    two_stage_follower_room_out out;
    two_stage_follower_room(self, &out);
    /*@ assert 0 <= out.points <= 150; */ ;
    held(self);
    sg_forget();
}

static void try_step(two_stage_follower_t *self)
{
    two_stage_follower_step_out out;
    two_stage_follower_step(self, &out);
    /*@ assert \is_finite(out.command_x) && -0.042d <= out.command_x <= 0.042d; */ ;
    /*@ assert \is_finite(out.command_y) && -0.042d <= out.command_y <= 0.042d; */ ;
    /*@ assert \is_finite(out.reference_x) && -0.4d <= out.reference_x <= 0.4d; */ ;
    /*@ assert \is_finite(out.reference_y) && -0.4d <= out.reference_y <= 0.4d; */ ;
    /*@ assert \is_finite(out.along) && 0.0d <= out.along <= 150.0d; */ ;
    held(self);
    sg_forget();
}

int main(void)
{
    two_stage_follower_t self;
    two_stage_follower_init(&self);
    held(&self);
    /*@ widen_hints "all", 2, 3, 19, 20, 49, 50, 149, 150, 3150, 3151; */
    while (Frama_C_nondet(0, 1) == 1) {
        switch (Frama_C_interval(0, 5)) {
        case 0:
            try_reset(&self);
            break;
        case 1:
            try_push(&self);
            break;
        case 2:
            try_begin(&self);
            break;
        case 3:
            try_room(&self);
            break;
        case 4:
            try_step(&self);
            break;
        default:
            two_stage_follower_init(&self);
            held(&self);
            break;
        }
    }
    return 0;
}
