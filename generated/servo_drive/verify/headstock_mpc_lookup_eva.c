/* SPDX-License-Identifier: MIT */
/*
 * Made by servogen 0.1.0 from eva.c.jinja; not to be edited.
 * Design 194d8956393bab306f4e51be322f6fe719d57e926f5156d4a75b3bef48eebba1.
 *
 * What Frama-C Eva is given of headstock_mpc_lookup: every sequence of calls, from dirty memory on.
 * It claims of every call what the contract headstock_mpc_lookup_contract.c promises to the callers.
 */
#include "headstock_mpc_lookup.h"
#include "headstock_eva.h"

/* The cases that sg_check keeps apart are one again: it has just seen a single one. */
static void sg_forget(void)
{
    (void)sg_check((sg_real)0, (sg_real)0, (sg_real)0);
}

static void held(const headstock_mpc_lookup_t *self)
{
    (void)self;
}

static void try_find(headstock_mpc_lookup_t *self)
{
    headstock_mpc_lookup_find_in in;
    headstock_mpc_lookup_find_out out;
    for (int i = 0; i < 8; i++) {
        in.theta[i] = sg_draw(-1.0e+20f, 1.0e+20f);
    }
    const sg_status status = headstock_mpc_lookup_find(self, &in, &out);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    for (int i = 0; i < 1; i++) {
        /*@ assert \is_finite(out.move[i]) && -1000.0f <= out.move[i] <= 1000.0f; */ ;
    }
    /*@ assert -1 <= out.law <= 8; */ ;
    held(self);
    sg_forget();
}

static void try_solve(headstock_mpc_lookup_t *self)
{
    headstock_mpc_lookup_solve_in in;
    headstock_mpc_lookup_solve_out out;
    for (int i = 0; i < 8; i++) {
        in.theta[i] = sg_promise(-1.0e+20f, 1.0e+20f);
    }
    const sg_status status = headstock_mpc_lookup_solve(self, &in, &out);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    for (int i = 0; i < 1; i++) {
        /*@ assert \is_finite(out.move[i]) && -1000.0f <= out.move[i] <= 1000.0f; */ ;
    }
    /*@ assert -1 <= out.law <= 8; */ ;
    held(self);
    sg_forget();
}

int main(void)
{
    headstock_mpc_lookup_t self;
    headstock_mpc_lookup_init(&self);
    held(&self);
    /*@ widen_hints "all", 0, 1, 2, 3, 6, 7, 8, 9; */
    while (Frama_C_nondet(0, 1) == 1) {
        switch (Frama_C_interval(0, 2)) {
        case 0:
            try_find(&self);
            break;
        case 1:
            try_solve(&self);
            break;
        default:
            headstock_mpc_lookup_init(&self);
            held(&self);
            break;
        }
    }
    return 0;
}
