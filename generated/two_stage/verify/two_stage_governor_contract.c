/* SPDX-License-Identifier: MIT */
/*
 * Made by servogen 0.1.0 from contract.c.jinja; not to be edited.
 * Design 2df8fd9b7b96227c8a47a2bccc487b135ad72d7fa713a19599e6540c03996ab1.
 *
 * What callers of two_stage_governor may rely on, for Frama-C Eva in place of two_stage_governor.c: after any
 * call, any status and any outputs in their declared ranges; of the state, the members that callers may
 * read, within their tables. The state has no other members here but for one that init writes: no call
 * is allowed before. two_stage_governor_eva.c is the proof that the C keeps to this.
 */
#include "two_stage_governor_contract.h"
#include "two_stage_eva.h"

static void two_stage_governor_anything(two_stage_governor_t *self)
{
    (void)self;
}

void two_stage_governor_init(two_stage_governor_t *self)
{
    self->begun = SG_BEGUN;
    two_stage_governor_anything(self);
}

sg_status two_stage_governor_step(two_stage_governor_t *self, const two_stage_governor_step_in *in, two_stage_governor_step_out *out)
{
    /*@ assert \initialized(&self->begun) && self->begun == SG_BEGUN; */ ;
    (void)in;
    /*@ assert \initialized(&in->x_position) && (SG_EVA_INPUTS == 2 || \is_finite(in->x_position)); */ ;
    /*@ assert \initialized(&in->x_velocity) && (SG_EVA_INPUTS == 2 || \is_finite(in->x_velocity)); */ ;
    /*@ assert \initialized(&in->x_acceleration) && (SG_EVA_INPUTS == 2 || \is_finite(in->x_acceleration)); */ ;
    /*@ assert \initialized(&in->y_position) && (SG_EVA_INPUTS == 2 || \is_finite(in->y_position)); */ ;
    /*@ assert \initialized(&in->y_velocity) && (SG_EVA_INPUTS == 2 || \is_finite(in->y_velocity)); */ ;
    /*@ assert \initialized(&in->y_acceleration) && (SG_EVA_INPUTS == 2 || \is_finite(in->y_acceleration)); */ ;
    /*@ assert \initialized(&in->last_x) && (SG_EVA_INPUTS == 2 || \is_finite(in->last_x)); */ ;
    /*@ assert \initialized(&in->last_y) && (SG_EVA_INPUTS == 2 || \is_finite(in->last_y)); */ ;
    for (int i = 0; i < 150; i++) {
        /*@ assert \initialized(&in->points_x[i]) && (SG_EVA_INPUTS == 2 || \is_finite(in->points_x[i])); */ ;
    }
    for (int i = 0; i < 150; i++) {
        /*@ assert \initialized(&in->points_y[i]) && (SG_EVA_INPUTS == 2 || \is_finite(in->points_y[i])); */ ;
    }
    /*@ assert \initialized(&in->n_points); */ ;
    two_stage_governor_anything(self);
    out->points_taken = sg_promise_count(0, 150);
    out->reference_x = sg_promise(-0.4, 0.4);
    out->low_x = sg_promise(-0.4, 0.4);
    out->high_x = sg_promise(-0.4, 0.4);
    out->reference_y = sg_promise(-0.4, 0.4);
    out->low_y = sg_promise(-0.4, 0.4);
    out->high_y = sg_promise(-0.4, 0.4);
    return (sg_status)Frama_C_interval(SG_OK, SG_UNREACHABLE);
}
