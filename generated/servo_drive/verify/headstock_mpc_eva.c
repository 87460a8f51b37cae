/* SPDX-License-Identifier: MIT */
/*
 * Made by servogen 0.1.0 from eva.c.jinja; not to be edited.
 * Design 194d8956393bab306f4e51be322f6fe719d57e926f5156d4a75b3bef48eebba1.
 *
 * What Frama-C Eva is given of headstock_mpc: every sequence of calls, from dirty memory on.
 * It claims of every call what the contract headstock_mpc_contract.c promises to the callers.
 */
#include "headstock_mpc.h"
#include "headstock_eva.h"

/* The cases that sg_check keeps apart are one again: it has just seen a single one. */
static void sg_forget(void)
{
    (void)sg_check((sg_real)0, (sg_real)0, (sg_real)0);
}

static void held(const headstock_mpc_t *self)
{
    (void)self;
}

static void try_reset(headstock_mpc_t *self)
{
    headstock_mpc_reset_in in;
    in.position = sg_draw(-36000.0f, 36000.0f);
    const sg_status status = headstock_mpc_reset(self, &in);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    held(self);
    sg_forget();
}

static void try_step(headstock_mpc_t *self)
{
    headstock_mpc_step_in in;
    headstock_mpc_step_out out;
    in.position = sg_draw(-36000.0f, 36000.0f);
    for (int i = 0; i < 3; i++) {
        in.reference[i] = sg_draw(-36000.0f, 36000.0f);
    }
    const sg_status status = headstock_mpc_step(self, &in, &out);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    /*@ assert \is_finite(out.current) && -1000.0f <= out.current <= 1000.0f; */ ;
    held(self);
    sg_forget();
}

int main(void)
{
    headstock_mpc_t self;
    headstock_mpc_init(&self);
    held(&self);
    /*@ widen_hints "all", 0, 1, 2, 3, 4, 7, 8; */
    while (Frama_C_nondet(0, 1) == 1) {
        switch (Frama_C_interval(0, 2)) {
        case 0:
            try_reset(&self);
            break;
        case 1:
            try_step(&self);
            break;
        default:
            headstock_mpc_init(&self);
            held(&self);
            break;
        }
    }
    return 0;
}
