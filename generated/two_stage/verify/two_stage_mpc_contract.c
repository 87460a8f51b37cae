/* SPDX-License-Identifier: MIT */
/*
 * Made by servogen 0.1.0 from contract.c.jinja; not to be edited.
 * Design 2df8fd9b7b96227c8a47a2bccc487b135ad72d7fa713a19599e6540c03996ab1.
 *
 * What callers of two_stage_mpc may rely on, for Frama-C Eva in place of two_stage_mpc.c: after any
 * call, any status and any outputs in their declared ranges; of the state, the members that callers may
 * read, within their tables. The state has no other members here but for one that init writes: no call
 * is allowed before. two_stage_mpc_eva.c is the proof that the C keeps to this.
 */
#include "two_stage_mpc_contract.h"
#include "two_stage_eva.h"
#include "two_stage_mpc_tables.h"

static void two_stage_mpc_anything(two_stage_mpc_t *self)
{
    (void)self;
    for (int i = 0; i < 3; i++) {
        self->predicted[i] = sg_promise(-two_stage_mpc_bound[i], two_stage_mpc_bound[i]);
    }
}

void two_stage_mpc_init(two_stage_mpc_t *self)
{
    self->begun = SG_BEGUN;
    two_stage_mpc_anything(self);
}

sg_status two_stage_mpc_reset(two_stage_mpc_t *self, const two_stage_mpc_reset_in *in)
{
    /*@ assert \initialized(&self->begun) && self->begun == SG_BEGUN; */ ;
    (void)in;
    /*@ assert \initialized(&in->position) && (SG_EVA_INPUTS == 2 || \is_finite(in->position)); */ ;
    two_stage_mpc_anything(self);
    return (sg_status)Frama_C_interval(SG_OK, SG_UNREACHABLE);
}

sg_status two_stage_mpc_seed(two_stage_mpc_t *self, const two_stage_mpc_seed_in *in)
{
    /*@ assert \initialized(&self->begun) && self->begun == SG_BEGUN; */ ;
    (void)in;
    /*@ assert \initialized(&in->command) && (SG_EVA_INPUTS == 2 || \is_finite(in->command)); */ ;
    two_stage_mpc_anything(self);
    return (sg_status)Frama_C_interval(SG_OK, SG_UNREACHABLE);
}

sg_status two_stage_mpc_candidate(const two_stage_mpc_t *self, const two_stage_mpc_candidate_in *in, two_stage_mpc_candidate_out *out)
{
    /*@ assert \initialized(&self->begun) && self->begun == SG_BEGUN; */ ;
    (void)in;
    /*@ assert \initialized(&in->position) && (SG_EVA_INPUTS == 2 || \is_finite(in->position)); */ ;
    /*@ assert \initialized(&in->velocity) && (SG_EVA_INPUTS == 2 || \is_finite(in->velocity)); */ ;
    /*@ assert \initialized(&in->acceleration) && (SG_EVA_INPUTS == 2 || \is_finite(in->acceleration)); */ ;
    (void)self;
    out->position = sg_promise(-SG_REAL_MAX, SG_REAL_MAX);
    out->velocity = sg_promise(-SG_REAL_MAX, SG_REAL_MAX);
    out->acceleration = sg_promise(-SG_REAL_MAX, SG_REAL_MAX);
    return (sg_status)Frama_C_interval(SG_OK, SG_UNREACHABLE);
}

sg_status two_stage_mpc_step(two_stage_mpc_t *self, const two_stage_mpc_step_in *in, two_stage_mpc_step_out *out)
{
    /*@ assert \initialized(&self->begun) && self->begun == SG_BEGUN; */ ;
    (void)in;
    /*@ assert \initialized(&in->position) && (SG_EVA_INPUTS == 2 || \is_finite(in->position)); */ ;
    /*@ assert \initialized(&in->velocity) && (SG_EVA_INPUTS == 2 || \is_finite(in->velocity)); */ ;
    /*@ assert \initialized(&in->acceleration) && (SG_EVA_INPUTS == 2 || \is_finite(in->acceleration)); */ ;
    for (int i = 0; i < 21; i++) {
        /*@ assert \initialized(&in->reference[i]) && (SG_EVA_INPUTS == 2 || \is_finite(in->reference[i])); */ ;
    }
    for (int i = 0; i < 20; i++) {
        /*@ assert \initialized(&in->low[i]) && (SG_EVA_INPUTS == 2 || \is_finite(in->low[i])); */ ;
    }
    for (int i = 0; i < 20; i++) {
        /*@ assert \initialized(&in->high[i]) && (SG_EVA_INPUTS == 2 || \is_finite(in->high[i])); */ ;
    }
    two_stage_mpc_anything(self);
    out->command = sg_promise(-0.6000000000000001, 0.6000000000000001);
    out->iterations = sg_promise_count(0, 186);
    return (sg_status)Frama_C_interval(SG_OK, SG_UNREACHABLE);
}

sg_status two_stage_mpc_hold(two_stage_mpc_t *self, const two_stage_mpc_hold_in *in, two_stage_mpc_hold_out *out)
{
    /*@ assert \initialized(&self->begun) && self->begun == SG_BEGUN; */ ;
    (void)in;
    /*@ assert \initialized(&in->reference) && (SG_EVA_INPUTS == 2 || \is_finite(in->reference)); */ ;
    two_stage_mpc_anything(self);
    out->command = sg_promise(-0.6000000000000001, 0.6000000000000001);
    out->position = sg_promise(-SG_REAL_MAX, SG_REAL_MAX);
    out->velocity = sg_promise(-SG_REAL_MAX, SG_REAL_MAX);
    out->acceleration = sg_promise(-SG_REAL_MAX, SG_REAL_MAX);
    return (sg_status)Frama_C_interval(SG_OK, SG_UNREACHABLE);
}
