/* SPDX-License-Identifier: MIT */
/*
 * Made by servogen 0.1.0 from eva.c.jinja; not to be edited.
 * Design 2df8fd9b7b96227c8a47a2bccc487b135ad72d7fa713a19599e6540c03996ab1.
 *
 * What Frama-C Eva is given of two_stage_mpc: every sequence of calls, from dirty memory on.
 * It claims of every call what the contract two_stage_mpc_contract.c promises to the callers.
 */
#include "two_stage_mpc.h"
#include "two_stage_eva.h"
#include "two_stage_mpc_tables.h"

/* The cases that sg_check keeps apart are one again: it has just seen a single one. */
static void sg_forget(void)
{
    (void)sg_check((sg_real)0, (sg_real)0, (sg_real)0);
}

static void held(const two_stage_mpc_t *self)
{
    (void)self;
    for (int i = 0; i < 3; i++) {
        /*@ assert -two_stage_mpc_bound[i] <= self->predicted[i] <= two_stage_mpc_bound[i]; */ ;
    }
}

static void try_reset(two_stage_mpc_t *self)
{
    two_stage_mpc_reset_in in;
    in.position = sg_draw(-0.6000000000000001, 0.6000000000000001);
    const sg_status status = two_stage_mpc_reset(self, &in);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    held(self);
    sg_forget();
}

static void try_seed(two_stage_mpc_t *self)
{
    two_stage_mpc_seed_in in;
    in.command = sg_draw(-0.6000000000000001, 0.6000000000000001);
    const sg_status status = two_stage_mpc_seed(self, &in);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    held(self);
    sg_forget();
}

static void try_candidate(two_stage_mpc_t *self)
{
    two_stage_mpc_candidate_in in;
    two_stage_mpc_candidate_out out;
    in.position = sg_draw(-0.6000000000000001, 0.6000000000000001);
    in.velocity = sg_draw(-2.8, 2.8);
    in.acceleration = sg_draw(-58.84, 58.84);
    const sg_status status = two_stage_mpc_candidate(self, &in, &out);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    /*@ assert \is_finite(out.position); */ ;
    /*@ assert \is_finite(out.velocity); */ ;
    /*@ assert \is_finite(out.acceleration); */ ;
    held(self);
    sg_forget();
}

static void try_step(two_stage_mpc_t *self)
{
    two_stage_mpc_step_in in;
    two_stage_mpc_step_out out;
    in.position = sg_draw(-0.6000000000000001, 0.6000000000000001);
    in.velocity = sg_draw(-2.8, 2.8);
    in.acceleration = sg_draw(-58.84, 58.84);
    for (int i = 0; i < 21; i++) {
        in.reference[i] = sg_draw(-0.4, 0.4);
    }
    for (int i = 0; i < 20; i++) {
        in.low[i] = sg_draw(-0.6000000000000001, 0.6000000000000001);
    }
    for (int i = 0; i < 20; i++) {
        in.high[i] = sg_draw(-0.6000000000000001, 0.6000000000000001);
    }
    const sg_status status = two_stage_mpc_step(self, &in, &out);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    /*@ assert \is_finite(out.command) && -0.6000000000000001d <= out.command <= 0.6000000000000001d; */ ;
    /*@ assert 0 <= out.iterations <= 186; */ ;
    held(self);
    sg_forget();
}

static void try_hold(two_stage_mpc_t *self)
{
    two_stage_mpc_hold_in in;
    two_stage_mpc_hold_out out;
    in.reference = sg_draw(-0.4, 0.4);
    const sg_status status = two_stage_mpc_hold(self, &in, &out);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    /*@ assert \is_finite(out.command) && -0.6000000000000001d <= out.command <= 0.6000000000000001d; */ ;
    /*@ assert \is_finite(out.position); */ ;
    /*@ assert \is_finite(out.velocity); */ ;
    /*@ assert \is_finite(out.acceleration); */ ;
    held(self);
    sg_forget();
}

int main(void)
{
    two_stage_mpc_t self;
    two_stage_mpc_init(&self);
    held(&self);
    /*@ widen_hints "all", 0, 1, 2, 3, 4, 5, 6, 19, 20, 21, 62, 63, 64, 185, 186; */
    while (Frama_C_nondet(0, 1) == 1) {
        switch (Frama_C_interval(0, 5)) {
        case 0:
            try_reset(&self);
            break;
        case 1:
            try_seed(&self);
            break;
        case 2:
            try_candidate(&self);
            break;
        case 3:
            try_step(&self);
            break;
        case 4:
            try_hold(&self);
            break;
        default:
            two_stage_mpc_init(&self);
            held(&self);
            break;
        }
    }
    return 0;
}
