/* SPDX-License-Identifier: MIT */
/*
 * Made by servogen 0.1.0 from contract.c.jinja; not to be edited.
 * Design db73e1a8671115da28984cf35db7dd65b73d330d546f213644560d85ebcdbb92.
 *
 * What callers of etcher_axis may rely on, for Frama-C Eva in place of etcher_axis.c: after any
 * call, any status and any outputs in their declared ranges; of the state, the members that callers may
 * read, within their tables. The state has no other members here but for one that init writes: no call
 * is allowed before. etcher_axis_eva.c is the proof that the C keeps to this.
 */
#include "etcher_axis_contract.h"
#include "etcher_eva.h"
#include "etcher_axis_tables.h"

static void etcher_axis_anything(etcher_axis_t *self)
{
    (void)self;
    for (int i = 0; i < 3; i++) {
        self->predicted[i] = sg_promise(-etcher_axis_bound[i], etcher_axis_bound[i]);
    }
}

void etcher_axis_init(etcher_axis_t *self)
{
    self->begun = SG_BEGUN;
    etcher_axis_anything(self);
}

sg_status etcher_axis_reset(etcher_axis_t *self, const etcher_axis_reset_in *in)
{
    /*@ assert \initialized(&self->begun) && self->begun == SG_BEGUN; */ ;
    (void)in;
    /*@ assert \initialized(&in->position) && (SG_EVA_INPUTS == 2 || \is_finite(in->position)); */ ;
    etcher_axis_anything(self);
    return (sg_status)Frama_C_interval(SG_OK, SG_UNREACHABLE);
}

sg_status etcher_axis_foresee(etcher_axis_t *self, const etcher_axis_foresee_in *in, etcher_axis_foresee_out *out)
{
    /*@ assert \initialized(&self->begun) && self->begun == SG_BEGUN; */ ;
    (void)in;
    /*@ assert \initialized(&in->position) && (SG_EVA_INPUTS == 2 || \is_finite(in->position)); */ ;
    /*@ assert \initialized(&in->velocity) && (SG_EVA_INPUTS == 2 || \is_finite(in->velocity)); */ ;
    /*@ assert \initialized(&in->acceleration) && (SG_EVA_INPUTS == 2 || \is_finite(in->acceleration)); */ ;
    etcher_axis_anything(self);
    for (int i = 0; i < 42; i++) {
        out->least[i] = sg_promise(-SG_REAL_MAX, SG_REAL_MAX);
    }
    for (int i = 0; i < 42; i++) {
        out->greatest[i] = sg_promise(-SG_REAL_MAX, SG_REAL_MAX);
    }
    return (sg_status)Frama_C_interval(SG_OK, SG_UNREACHABLE);
}

sg_status etcher_axis_step(etcher_axis_t *self, const etcher_axis_step_in *in, etcher_axis_step_out *out)
{
    /*@ assert \initialized(&self->begun) && self->begun == SG_BEGUN; */ ;
    (void)in;
    /*@ assert \initialized(&in->position) && (SG_EVA_INPUTS == 2 || \is_finite(in->position)); */ ;
    /*@ assert \initialized(&in->velocity) && (SG_EVA_INPUTS == 2 || \is_finite(in->velocity)); */ ;
    /*@ assert \initialized(&in->acceleration) && (SG_EVA_INPUTS == 2 || \is_finite(in->acceleration)); */ ;
    for (int i = 0; i < 41; i++) {
        /*@ assert \initialized(&in->reference[i]) && (SG_EVA_INPUTS == 2 || \is_finite(in->reference[i])); */ ;
    }
    for (int i = 0; i < 42; i++) {
        /*@ assert \initialized(&in->low[i]) && (SG_EVA_INPUTS == 2 || \is_finite(in->low[i])); */ ;
    }
    for (int i = 0; i < 42; i++) {
        /*@ assert \initialized(&in->high[i]) && (SG_EVA_INPUTS == 2 || \is_finite(in->high[i])); */ ;
    }
    etcher_axis_anything(self);
    out->command = sg_promise(-0.375, 0.375);
    out->iterations = sg_promise_count(0, 45);
    out->standing = sg_promise_count(0, 1);
    return (sg_status)Frama_C_interval(SG_OK, SG_UNREACHABLE);
}

sg_status etcher_axis_predict(const etcher_axis_t *self, const etcher_axis_predict_in *in, etcher_axis_predict_out *out)
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
