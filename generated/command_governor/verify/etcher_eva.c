/* SPDX-License-Identifier: MIT */
/*
 * Made by servogen 0.1.0 from eva.c.jinja; not to be edited.
 * Design db73e1a8671115da28984cf35db7dd65b73d330d546f213644560d85ebcdbb92.
 *
 * What Frama-C Eva is given of etcher: every sequence of calls, from dirty memory on.
 * It claims of every call what the contract etcher_contract.c promises to the callers.
 */
#include "etcher.h"
#include "etcher_eva.h"

/* The cases that sg_check keeps apart are one again: it has just seen a single one. */
static void sg_forget(void)
{
    (void)sg_check((sg_real)0, (sg_real)0, (sg_real)0);
}

static void held(const etcher_t *self)
{
    (void)self;
}

static void try_reset(etcher_t *self)
{
    etcher_reset_in in;
    in.position_x = sg_draw(-0.375, 0.375);
    in.position_y = sg_draw(-0.375, 0.375);
    const sg_status status = etcher_reset(self, &in);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    held(self);
    sg_forget();
}

static void try_predict(etcher_t *self)
{
    etcher_predict_in in;
    etcher_predict_out out;
    in.x_position = sg_draw(-0.375, 0.375);
    in.x_velocity = sg_draw(-0.4, 0.4);
    in.x_acceleration = sg_draw(-40.0, 40.0);
    in.y_position = sg_draw(-0.375, 0.375);
    in.y_velocity = sg_draw(-0.4, 0.4);
    in.y_acceleration = sg_draw(-40.0, 40.0);
    const sg_status status = etcher_predict(self, &in, &out);
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

static void try_step(etcher_t *self)
{
    etcher_step_in in;
    etcher_step_out out;
    in.x_position = sg_draw(-0.375, 0.375);
    in.x_velocity = sg_draw(-0.4, 0.4);
    in.x_acceleration = sg_draw(-40.0, 40.0);
    in.y_position = sg_draw(-0.375, 0.375);
    in.y_velocity = sg_draw(-0.4, 0.4);
    in.y_acceleration = sg_draw(-40.0, 40.0);
    for (int i = 0; i < 8000; i++) {
        in.points_x[i] = sg_draw(-0.375, 0.375);
    }
    for (int i = 0; i < 8000; i++) {
        in.points_y[i] = sg_draw(-0.375, 0.375);
    }
    for (int i = 0; i < 8000; i++) {
        in.slow_x[i] = sg_draw(-0.375, 0.375);
    }
    for (int i = 0; i < 8000; i++) {
        in.slow_y[i] = sg_draw(-0.375, 0.375);
    }
    in.n_points = sg_draw_count(0, 8000);
    const sg_status status = etcher_step(self, &in, &out);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    /*@ assert 0 <= out.points_taken <= 500; */ ;
    /*@ assert \is_finite(out.command_x) && -0.375d <= out.command_x <= 0.375d; */ ;
    /*@ assert -2147483647 - 1 <= out.status_x <= 2147483647; */ ;
    /*@ assert 0 <= out.iterations_x <= 45; */ ;
    /*@ assert \is_finite(out.command_y) && -0.375d <= out.command_y <= 0.375d; */ ;
    /*@ assert -2147483647 - 1 <= out.status_y <= 2147483647; */ ;
    /*@ assert 0 <= out.iterations_y <= 45; */ ;
    held(self);
    sg_forget();
}

int main(void)
{
    etcher_t self;
    etcher_init(&self);
    held(&self);
    /*@ widen_hints "all", 2, 3, 40, 41, 42, 81, 82, 499, 500, 7999, 8000; */
    while (Frama_C_nondet(0, 1) == 1) {
        switch (Frama_C_interval(0, 3)) {
        case 0:
            try_reset(&self);
            break;
        case 1:
            try_predict(&self);
            break;
        case 2:
            try_step(&self);
            break;
        default:
            etcher_init(&self);
            held(&self);
            break;
        }
    }
    return 0;
}
