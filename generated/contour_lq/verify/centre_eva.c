/* SPDX-License-Identifier: MIT */
/*
 * Made by servogen 0.1.0 from eva.c.jinja; not to be edited.
 * Design 57e8c839fdacd1111a3d54d19166de3db0812a4643fcf0fa37d321135b5a91fd.
 *
 * What Frama-C Eva is given of centre: every sequence of calls, from dirty memory on.
 * It claims of every call what the contract centre_contract.c promises to the callers.
 */
#include "centre.h"
#include "centre_eva.h"

/* The cases that sg_check keeps apart are one again: it has just seen a single one. */
static void sg_forget(void)
{
    (void)sg_check((sg_real)0, (sg_real)0, (sg_real)0);
}

static void held(const centre_t *self)
{
    (void)self;
}

static void try_reset(centre_t *self)
{
    centre_reset_in in;
    for (int i = 0; i < 2; i++) {
        in.position[i] = sg_draw(-0.05f, 0.05f);
    }
    const sg_status status = centre_reset(self, &in);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    held(self);
    sg_forget();
}

static void try_step(centre_t *self)
{
    centre_step_in in;
    centre_step_out out;
    for (int i = 0; i < 2; i++) {
        in.position[i] = sg_draw(-0.05f, 0.05f);
    }
    for (int i = 0; i < 22; i++) {
        in.reference[i] = sg_draw(-0.05f, 0.05f);
    }
    const sg_status status = centre_step(self, &in, &out);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    for (int i = 0; i < 2; i++) {
        /*@ assert \is_finite(out.command[i]) && -20.0f <= out.command[i] <= 20.0f; */ ;
    }
    /*@ assert 0 <= out.limited <= 2; */ ;
    /*@ assert 0 <= out.known <= 10; */ ;
    held(self);
    sg_forget();
}

static void try_follow(centre_t *self)
{
    centre_follow_in in;
    centre_follow_out out;
    for (int i = 0; i < 2; i++) {
        in.position[i] = sg_draw(-0.05f, 0.05f);
    }
    for (int i = 0; i < 6; i++) {
        in.hidden[i] = sg_draw(-2.0f, 2.0f);
    }
    for (int i = 0; i < 22; i++) {
        in.reference[i] = sg_draw(-0.05f, 0.05f);
    }
    const sg_status status = centre_follow(self, &in, &out);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    for (int i = 0; i < 2; i++) {
        /*@ assert \is_finite(out.command[i]) && -20.0f <= out.command[i] <= 20.0f; */ ;
    }
    /*@ assert 0 <= out.limited <= 2; */ ;
    /*@ assert 0 <= out.known <= 10; */ ;
    held(self);
    sg_forget();
}

int main(void)
{
    centre_t self;
    centre_init(&self);
    held(&self);
    /*@ widen_hints "all", 1, 2, 3, 4, 5, 6, 8, 9, 10, 12, 13, 14, 15, 27, 28; */
    while (Frama_C_nondet(0, 1) == 1) {
        switch (Frama_C_interval(0, 3)) {
        case 0:
            try_reset(&self);
            break;
        case 1:
            try_step(&self);
            break;
        case 2:
            try_follow(&self);
            break;
        default:
            centre_init(&self);
            held(&self);
            break;
        }
    }
    return 0;
}
