/* SPDX-License-Identifier: MIT */
/*
 * Made by servogen 0.1.0 from eva.c.jinja; not to be edited.
 * Design 194d8956393bab306f4e51be322f6fe719d57e926f5156d4a75b3bef48eebba1.
 *
 * What Frama-C Eva is given of headstock_pid: every sequence of calls, from dirty memory on.
 * It claims of every call what the contract headstock_pid_contract.c promises to the callers.
 */
#include "headstock_pid.h"
#include "headstock_eva.h"

/* The cases that sg_check keeps apart are one again: it has just seen a single one. */
static void sg_forget(void)
{
    (void)sg_check((sg_real)0, (sg_real)0, (sg_real)0);
}

static void held(const headstock_pid_t *self)
{
    (void)self;
}

static void try_reset(headstock_pid_t *self)
{
    headstock_pid_reset_in in;
    in.position = sg_draw(-36000.0f, 36000.0f);
    const sg_status status = headstock_pid_reset(self, &in);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    held(self);
    sg_forget();
}

static void try_step(headstock_pid_t *self)
{
    headstock_pid_step_in in;
    headstock_pid_step_out out;
    in.position = sg_draw(-36000.0f, 36000.0f);
    in.reference = sg_draw(-36000.0f, 36000.0f);
    const sg_status status = headstock_pid_step(self, &in, &out);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    /*@ assert \is_finite(out.wanted) && -1000.0f <= out.wanted <= 1000.0f; */ ;
    held(self);
    sg_forget();
}

static void try_filter_step(headstock_pid_t *self)
{
    headstock_pid_filter_step_out out;
    const sg_status status = headstock_pid_filter_step(self, &out);
    /*@ assert SG_OK <= status <= SG_UNREACHABLE; */
    (void)status;
    /*@ assert \is_finite(out.current) && -1000.0f <= out.current <= 1000.0f; */ ;
    held(self);
    sg_forget();
}

int main(void)
{
    headstock_pid_t self;
    headstock_pid_init(&self);
    held(&self);
    /*@ widen_hints "all", 7, 8; */
    while (Frama_C_nondet(0, 1) == 1) {
        switch (Frama_C_interval(0, 3)) {
        case 0:
            try_reset(&self);
            break;
        case 1:
            try_step(&self);
            break;
        case 2:
            try_filter_step(&self);
            break;
        default:
            headstock_pid_init(&self);
            held(&self);
            break;
        }
    }
    return 0;
}
