/* SPDX-License-Identifier: MIT */
/*
 * Made by servogen 0.1.0 from eva.c.jinja; not to be edited.
 * Design 2df8fd9b7b96227c8a47a2bccc487b135ad72d7fa713a19599e6540c03996ab1.
 *
 * What Frama-C Eva is given of two_stage: every sequence of calls, from dirty memory on.
 * It claims of every call what the contract two_stage_contract.c promises to the callers.
 */
#include "two_stage.h"
#include "two_stage_eva.h"

/* The cases that sg_check keeps apart are one again: it has just seen a single one. */
static void sg_forget(void)
{
    (void)sg_check((sg_real)0, (sg_real)0, (sg_real)0);
}

static void held(const two_stage_t *self)
{
    (void)self;
}

static void try_reset(two_stage_t *self)
{
    two_stage_reset_in in;
    in.position_x = sg_draw(-0.4, 0.4);
    in.position_y = sg_draw(-0.4, 0.4);
    const sg_status status = two_stage_reset(self, &in);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    held(self);
    sg_forget();
}

static void try_step(two_stage_t *self)
{
    two_stage_step_in in;
    two_stage_step_out out;
    in.x_position = sg_draw(-0.6000000000000001, 0.6000000000000001);
    in.x_velocity = sg_draw(-2.8, 2.8);
    in.x_acceleration = sg_draw(-58.84, 58.84);
    in.y_position = sg_draw(-0.6000000000000001, 0.6000000000000001);
    in.y_velocity = sg_draw(-2.8, 2.8);
    in.y_acceleration = sg_draw(-58.84, 58.84);
    for (int i = 0; i < 150; i++) {
        in.points_x[i] = sg_draw(-0.4, 0.4);
    }
    for (int i = 0; i < 150; i++) {
        in.points_y[i] = sg_draw(-0.4, 0.4);
    }
    in.n_points = sg_draw_count(0, 150);
    const sg_status status = two_stage_step(self, &in, &out);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    /*@ assert \is_finite(out.command_x) && -0.6000000000000001d <= out.command_x <= 0.6000000000000001d; */ ;
    /*@ assert \is_finite(out.command_y) && -0.6000000000000001d <= out.command_y <= 0.6000000000000001d; */ ;
    /*@ assert 0 <= out.points_taken <= 150; */ ;
    /*@ assert 0 <= out.interval_points <= 150; */ ;
    /*@ assert 0 <= out.pending <= 3000; */ ;
    /*@ assert 0 <= out.iterations_x <= 186; */ ;
    /*@ assert 0 <= out.iterations_y <= 186; */ ;
    /*@ assert 0 <= out.status_x <= 10; */ ;
    /*@ assert 0 <= out.status_y <= 10; */ ;
    held(self);
    sg_forget();
}

static void try_predict(two_stage_t *self)
{
    two_stage_predict_in in;
    two_stage_predict_out out;
    in.x_position = sg_draw(-0.6000000000000001, 0.6000000000000001);
    in.x_velocity = sg_draw(-2.8, 2.8);
    in.x_acceleration = sg_draw(-58.84, 58.84);
    in.y_position = sg_draw(-0.6000000000000001, 0.6000000000000001);
    in.y_velocity = sg_draw(-2.8, 2.8);
    in.y_acceleration = sg_draw(-58.84, 58.84);
    const sg_status status = two_stage_predict(self, &in, &out);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    /*@ assert \is_finite(out.x_position); */ ;
    /*@ assert \is_finite(out.x_velocity); */ ;
    /*@ assert \is_finite(out.x_acceleration); */ ;
    /*@ assert \is_finite(out.y_position); */ ;
    /*@ assert \is_finite(out.y_velocity); */ ;
    /*@ assert \is_finite(out.y_acceleration); */ ;
    held(self);
    sg_forget();
}

static void try_plan(two_stage_t *self)
{
    two_stage_plan_in in;
    two_stage_plan_out out;
    in.x_position = sg_draw(-0.6000000000000001, 0.6000000000000001);
    in.x_velocity = sg_draw(-2.8, 2.8);
    in.x_acceleration = sg_draw(-58.84, 58.84);
    in.y_position = sg_draw(-0.6000000000000001, 0.6000000000000001);
    in.y_velocity = sg_draw(-2.8, 2.8);
    in.y_acceleration = sg_draw(-58.84, 58.84);
    for (int i = 0; i < 150; i++) {
        in.points_x[i] = sg_draw(-0.4, 0.4);
    }
    for (int i = 0; i < 150; i++) {
        in.points_y[i] = sg_draw(-0.4, 0.4);
    }
    in.n_points = sg_draw_count(0, 150);
    const sg_status status = two_stage_plan(self, &in, &out);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    /*@ assert \is_finite(out.command_x) && -0.6000000000000001d <= out.command_x <= 0.6000000000000001d; */ ;
    /*@ assert \is_finite(out.command_y) && -0.6000000000000001d <= out.command_y <= 0.6000000000000001d; */ ;
    /*@ assert 0 <= out.points_taken <= 150; */ ;
    /*@ assert 0 <= out.interval_points <= 150; */ ;
    /*@ assert 0 <= out.pending <= 3000; */ ;
    /*@ assert 0 <= out.iterations_x <= 186; */ ;
    /*@ assert 0 <= out.iterations_y <= 186; */ ;
    /*@ assert 0 <= out.status_x <= 10; */ ;
    /*@ assert 0 <= out.status_y <= 10; */ ;
    held(self);
    sg_forget();
}

static void try_start(two_stage_t *self)
{
    two_stage_start_out out;
    const sg_status status = two_stage_start(self, &out);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    /*@ assert \is_finite(out.command_x) && -0.6000000000000001d <= out.command_x <= 0.6000000000000001d; */ ;
    /*@ assert \is_finite(out.command_y) && -0.6000000000000001d <= out.command_y <= 0.6000000000000001d; */ ;
    /*@ assert 0 <= out.interval_points <= 150; */ ;
    /*@ assert 0 <= out.pending <= 3000; */ ;
    held(self);
    sg_forget();
}

static void try_fast_step(two_stage_t *self)
{
    two_stage_fast_step_out out;
    two_stage_fast_step(self, &out);
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
    two_stage_t self;
    two_stage_init(&self);
    held(&self);
    /*@ widen_hints "all", 2, 3, 18, 19, 20, 21, 149, 150, 2999, 3000; */
    while (Frama_C_nondet(0, 1) == 1) {
        switch (Frama_C_interval(0, 6)) {
        case 0:
            try_reset(&self);
            break;
        case 1:
            try_step(&self);
            break;
        case 2:
            try_predict(&self);
            break;
        case 3:
            try_plan(&self);
            break;
        case 4:
            try_start(&self);
            break;
        case 5:
            try_fast_step(&self);
            break;
        default:
            two_stage_init(&self);
            held(&self);
            break;
        }
    }
    return 0;
}
