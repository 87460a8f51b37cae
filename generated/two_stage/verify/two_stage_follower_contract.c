/* SPDX-License-Identifier: MIT */
/*
 * Made by servogen 0.1.0 from contract.c.jinja; not to be edited.
 * Design 2df8fd9b7b96227c8a47a2bccc487b135ad72d7fa713a19599e6540c03996ab1.
 *
 * What callers of two_stage_follower may rely on, for Frama-C Eva in place of two_stage_follower.c: after any
 * call, any status and any outputs in their declared ranges; of the state, the members that callers may
 * read, within their tables. The state has no other members here but for one that init writes: no call
 * is allowed before. two_stage_follower_eva.c is the proof that the C keeps to this.
 */
#include "two_stage_follower_contract.h"
#include "two_stage_eva.h"

static void two_stage_follower_anything(two_stage_follower_t *self)
{
    (void)self;
}

void two_stage_follower_init(two_stage_follower_t *self)
{
    self->begun = SG_BEGUN;
    two_stage_follower_anything(self);
}

sg_status two_stage_follower_reset(two_stage_follower_t *self, const two_stage_follower_reset_in *in)
{
    /*@ assert \initialized(&self->begun) && self->begun == SG_BEGUN; */ ;
    (void)in;
    /*@ assert \initialized(&in->position_x) && (SG_EVA_INPUTS == 2 || \is_finite(in->position_x)); */ ;
    /*@ assert \initialized(&in->position_y) && (SG_EVA_INPUTS == 2 || \is_finite(in->position_y)); */ ;
    two_stage_follower_anything(self);
    return (sg_status)Frama_C_interval(SG_OK, SG_UNREACHABLE);
}

sg_status two_stage_follower_push(two_stage_follower_t *self, const two_stage_follower_push_in *in)
{
    /*@ assert \initialized(&self->begun) && self->begun == SG_BEGUN; */ ;
    (void)in;
    for (int i = 0; i < 150; i++) {
        /*@ assert \initialized(&in->points_x[i]) && (SG_EVA_INPUTS == 2 || \is_finite(in->points_x[i])); */ ;
    }
    for (int i = 0; i < 150; i++) {
        /*@ assert \initialized(&in->points_y[i]) && (SG_EVA_INPUTS == 2 || \is_finite(in->points_y[i])); */ ;
    }
    /*@ assert \initialized(&in->n_points); */ ;
    two_stage_follower_anything(self);
    return (sg_status)Frama_C_interval(SG_OK, SG_UNREACHABLE);
}

sg_status two_stage_follower_begin(two_stage_follower_t *self, const two_stage_follower_begin_in *in, two_stage_follower_begin_out *out)
{
    /*@ assert \initialized(&self->begun) && self->begun == SG_BEGUN; */ ;
    (void)in;
    /*@ assert \initialized(&in->x_position) && (SG_EVA_INPUTS == 2 || \is_finite(in->x_position)); */ ;
    /*@ assert \initialized(&in->x_velocity) && (SG_EVA_INPUTS == 2 || \is_finite(in->x_velocity)); */ ;
    /*@ assert \initialized(&in->x_acceleration) && (SG_EVA_INPUTS == 2 || \is_finite(in->x_acceleration)); */ ;
    /*@ assert \initialized(&in->slow_command_x) && (SG_EVA_INPUTS == 2 || \is_finite(in->slow_command_x)); */ ;
    /*@ assert \initialized(&in->y_position) && (SG_EVA_INPUTS == 2 || \is_finite(in->y_position)); */ ;
    /*@ assert \initialized(&in->y_velocity) && (SG_EVA_INPUTS == 2 || \is_finite(in->y_velocity)); */ ;
    /*@ assert \initialized(&in->y_acceleration) && (SG_EVA_INPUTS == 2 || \is_finite(in->y_acceleration)); */ ;
    /*@ assert \initialized(&in->slow_command_y) && (SG_EVA_INPUTS == 2 || \is_finite(in->slow_command_y)); */ ;
    two_stage_follower_anything(self);
    out->interval_points = sg_promise_count(0, 150);
    return (sg_status)Frama_C_interval(SG_OK, SG_UNREACHABLE);
}

void two_stage_follower_room(const two_stage_follower_t *self, two_stage_follower_room_out *out)
{
    /*@ assert \initialized(&self->begun) && self->begun == SG_BEGUN; */ ;
    (void)self;
    out->points = sg_promise_count(0, 150);
}

void two_stage_follower_step(two_stage_follower_t *self, two_stage_follower_step_out *out)
{
    /*@ assert \initialized(&self->begun) && self->begun == SG_BEGUN; */ ;
    two_stage_follower_anything(self);
    out->command_x = sg_promise(-0.042, 0.042);
    out->command_y = sg_promise(-0.042, 0.042);
    out->reference_x = sg_promise(-0.4, 0.4);
    out->reference_y = sg_promise(-0.4, 0.4);
    out->along = sg_promise(0.0, 150.0);
}
