/* SPDX-License-Identifier: MIT */
/*
 * Made by servogen 0.1.0 from eva.c.jinja; not to be edited.
 * Design db73e1a8671115da28984cf35db7dd65b73d330d546f213644560d85ebcdbb92.
 *
 * What Frama-C Eva is given of etcher_axis: every sequence of calls, from dirty memory on.
 * It claims of every call what the contract etcher_axis_contract.c promises to the callers.
 */
#include "etcher_axis.h"
#include "etcher_eva.h"
#include "etcher_axis_tables.h"

/* The cases that sg_check keeps apart are one again: it has just seen a single one. */
static void sg_forget(void)
{
    (void)sg_check((sg_real)0, (sg_real)0, (sg_real)0);
}

static void held(const etcher_axis_t *self)
{
    (void)self;
    for (int i = 0; i < 3; i++) {
        /*@ assert -etcher_axis_bound[i] <= self->predicted[i] <= etcher_axis_bound[i]; */ ;
    }
}

static void try_reset(etcher_axis_t *self)
{
    etcher_axis_reset_in in;
    in.position = sg_draw(-0.375, 0.375);
    const sg_status status = etcher_axis_reset(self, &in);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    held(self);
    sg_forget();
}

static void try_foresee(etcher_axis_t *self)
{
    etcher_axis_foresee_in in;
    etcher_axis_foresee_out out;
    in.position = sg_draw(-0.375, 0.375);
    in.velocity = sg_draw(-0.4, 0.4);
    in.acceleration = sg_draw(-40.0, 40.0);
    const sg_status status = etcher_axis_foresee(self, &in, &out);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    for (int i = 0; i < 42; i++) {
        /*@ assert \is_finite(out.least[i]); */ ;
    }
    for (int i = 0; i < 42; i++) {
        /*@ assert \is_finite(out.greatest[i]); */ ;
    }
    held(self);
    sg_forget();
}

static void try_step(etcher_axis_t *self)
{
    etcher_axis_step_in in;
    etcher_axis_step_out out;
    in.position = sg_draw(-0.375, 0.375);
    in.velocity = sg_draw(-0.4, 0.4);
    in.acceleration = sg_draw(-40.0, 40.0);
    for (int i = 0; i < 41; i++) {
        in.reference[i] = sg_draw(-0.375, 0.375);
    }
    for (int i = 0; i < 42; i++) {
        in.low[i] = sg_draw(-0.425, 0.425);
    }
    for (int i = 0; i < 42; i++) {
        in.high[i] = sg_draw(-0.425, 0.425);
    }
    const sg_status status = etcher_axis_step(self, &in, &out);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    /*@ assert \is_finite(out.command) && -0.375d <= out.command <= 0.375d; */ ;
    /*@ assert 0 <= out.iterations <= 45; */ ;
    /*@ assert 0 <= out.standing <= 1; */ ;
    held(self);
    sg_forget();
}

static void try_predict(etcher_axis_t *self)
{
    etcher_axis_predict_in in;
    etcher_axis_predict_out out;
    in.position = sg_draw(-0.375, 0.375);
    in.velocity = sg_draw(-0.4, 0.4);
    in.acceleration = sg_draw(-40.0, 40.0);
    const sg_status status = etcher_axis_predict(self, &in, &out);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    /*@ assert \is_finite(out.position); */ ;
    /*@ assert \is_finite(out.velocity); */ ;
    /*@ assert \is_finite(out.acceleration); */ ;
    held(self);
    sg_forget();
}

int main(void)
{
    etcher_axis_t self;
    etcher_axis_init(&self);
    held(&self);
    /*@ widen_hints "all", 0, 1, 2, 3, 4, 5, 6, 19, 20, 33, 34, 40, 41, 42, 44, 45, 46, 279, 280, 860, 861, 1680, 1681; */
    while (Frama_C_nondet(0, 1) == 1) {
        switch (Frama_C_interval(0, 4)) {
        case 0:
            try_reset(&self);
            break;
        case 1:
            try_foresee(&self);
            break;
        case 2:
            try_step(&self);
            break;
        case 3:
            try_predict(&self);
            break;
        default:
            etcher_axis_init(&self);
            held(&self);
            break;
        }
    }
    return 0;
}
