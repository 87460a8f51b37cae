/* SPDX-License-Identifier: MIT */
/*
 * Made by servogen 0.1.0 from contract.c.jinja; not to be edited.
 * Design 194d8956393bab306f4e51be322f6fe719d57e926f5156d4a75b3bef48eebba1.
 *
 * What callers of headstock_mpc_lookup may rely on, for Frama-C Eva in place of headstock_mpc_lookup.c: after any
 * call, any status and any outputs in their declared ranges; of the state, the members that callers may
 * read, within their tables. The state has no other members here but for one that init writes: no call
 * is allowed before. headstock_mpc_lookup_eva.c is the proof that the C keeps to this.
 */
#include "headstock_mpc_lookup_contract.h"
#include "headstock_eva.h"

static void headstock_mpc_lookup_anything(headstock_mpc_lookup_t *self)
{
    (void)self;
}

void headstock_mpc_lookup_init(headstock_mpc_lookup_t *self)
{
    self->begun = SG_BEGUN;
    headstock_mpc_lookup_anything(self);
}

sg_status headstock_mpc_lookup_find(headstock_mpc_lookup_t *self, const headstock_mpc_lookup_find_in *in, headstock_mpc_lookup_find_out *out)
{
    /*@ assert \initialized(&self->begun) && self->begun == SG_BEGUN; */ ;
    (void)in;
    for (int i = 0; i < 8; i++) {
        /*@ assert \initialized(&in->theta[i]) && (SG_EVA_INPUTS == 2 || \is_finite(in->theta[i])); */ ;
    }
    headstock_mpc_lookup_anything(self);
    for (int i = 0; i < 1; i++) {
        out->move[i] = sg_promise(-1000.0f, 1000.0f);
    }
    out->law = sg_promise_count(-1, 8);
    return (sg_status)Frama_C_interval(SG_OK, SG_UNREACHABLE);
}

sg_status headstock_mpc_lookup_solve(headstock_mpc_lookup_t *self, const headstock_mpc_lookup_solve_in *in, headstock_mpc_lookup_solve_out *out)
{
    /*@ assert \initialized(&self->begun) && self->begun == SG_BEGUN; */ ;
    (void)in;
    for (int i = 0; i < 8; i++) {
        /*@ assert \initialized(&in->theta[i]) && \is_finite(in->theta[i]) && -1.0e+20f <= in->theta[i] <= 1.0e+20f; */ ;
    }
    headstock_mpc_lookup_anything(self);
    for (int i = 0; i < 1; i++) {
        out->move[i] = sg_promise(-1000.0f, 1000.0f);
    }
    out->law = sg_promise_count(-1, 8);
    return (sg_status)Frama_C_interval(SG_OK, SG_UNREACHABLE);
}
