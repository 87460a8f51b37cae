/* SPDX-License-Identifier: MIT */
/* Made by servogen 0.1.0 from controller.h.jinja; not to be edited. Design 57e8c839fdacd111. */
/* Receding-horizon LQ contour control (11)-(13), gains computed on line */
#ifndef CENTRE_H
#define CENTRE_H

#include "centre_types.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    CENTRE_AXES = 2, /* p */
    CENTRE_PREVIEW = 10, /* N_p, points ahead */
    CENTRE_SLIDES = 9, /* S, points whose reference may slide */
    CENTRE_HIDDEN = 6, /* states but the positions, all axes */
    CENTRE_HIDDEN_X = 2, /* of x */
    CENTRE_HIDDEN_Y = 4, /* of y */
    CENTRE_GIVEN = 28, /* references, position, hidden states of all axes */
    CENTRE_GIVEN_X = 13, /* of x */
    CENTRE_GIVEN_Y = 15 /* of y */
};

/* All state; the caller owns it, as many as she likes. Members are private. */
typedef struct {
    centre_real last[CENTRE_AXES]; /* last usable measurement */
    centre_real ahead[CENTRE_AXES]; /* position expected at the next sample, less that */
    centre_real hidden[CENTRE_HIDDEN]; /* hidden states expected at it */
    centre_real point[CENTRE_AXES]; /* last distinct point of the contour */
    centre_real direction[CENTRE_AXES]; /* by which it was reached, or zeros */
    int32_t begun; /* whether a reference has been taken */
    int32_t ready; /* whether reset has been called */
} centre_t;

typedef struct {
    centre_real position[2]; /* m [-0.05 .. 0.05]: of every axis, now */
} centre_reset_in;

typedef struct {
    centre_real position[2]; /* m [-0.05 .. 0.05]: of every axis, now */
    centre_real reference[22]; /* m [-0.05 .. 0.05]: the present point and the N_p ahead of it, the axes of one together */
} centre_step_in;

typedef struct {
    centre_real position[2]; /* m [-0.05 .. 0.05]: of every axis, now */
    centre_real hidden[6]; /* 1 [-2.0 .. 2.0]: other states of every axis, axis after axis, in shares of their largest */
    centre_real reference[22]; /* m [-0.05 .. 0.05]: the present point and the N_p ahead of it, the axes of one together */
} centre_follow_in;

typedef struct {
    centre_real command[2]; /* 1 [-20.0 .. 20.0]: of every axis, in the unit of its input; zero where an input cannot be used */
    int32_t limited; /* 1 [0 .. 2]: axes whose command was cut */
    int32_t known; /* 1 [0 .. 10]: points ahead with a direction; without one every error counts as one of contour */
} centre_step_out;

typedef struct {
    centre_real command[2]; /* 1 [-20.0 .. 20.0]: of every axis, in the unit of its input; zero where an input cannot be used */
    int32_t limited; /* 1 [0 .. 2]: axes whose command was cut */
    int32_t known; /* 1 [0 .. 10]: points ahead with a direction; without one every error counts as one of contour */
} centre_follow_out;

/* Before anything else: clears the state. */
void centre_init(centre_t *self);

/* The axes stand at a position. */
sg_status centre_reset(centre_t *self, const centre_reset_in *in);

/* One sample by the encoders: estimate, tangents, slides, command; then predict. */
sg_status centre_step(centre_t *self, const centre_step_in *in, centre_step_out *out);

/* One sample with the whole state given, in place of step. */
sg_status centre_follow(centre_t *self, const centre_follow_in *in, centre_follow_out *out);

#ifdef __cplusplus
}
#endif

#endif
