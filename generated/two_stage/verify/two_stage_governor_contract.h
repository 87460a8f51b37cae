/* SPDX-License-Identifier: MIT */
/* Made by servogen 0.1.0 from controller.h.jinja; not to be edited. Design 2df8fd9b7b96227c. */
/* Spatial reference governor (14)-(15), both axes */
#ifndef TWO_STAGE_GOVERNOR_H
#define TWO_STAGE_GOVERNOR_H

#include "two_stage_types.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    TWO_STAGE_GOVERNOR_ORDER = 3, /* states of a slow stage */
    TWO_STAGE_GOVERNOR_POINTS = 150, /* M, points per interval at the most */
    TWO_STAGE_GOVERNOR_CHOICES = 151, /* eta = 0..M */
    TWO_STAGE_GOVERNOR_PAIRS_X = 5, /* row pairs of (13), x */
    TWO_STAGE_GOVERNOR_PAIRS_Y = 5 /* row pairs of (13), y */
};

/* All state; the caller owns it, as many as she likes. Members are private. */
typedef struct {
    SG_GIVEN int32_t begun; /* SG_BEGUN after init */
} two_stage_governor_t;

typedef struct {
    two_stage_real x_position; /* m [-0.6000000000000001 .. 0.6000000000000001]: slow stage position */
    two_stage_real x_velocity; /* m/s [-2.8 .. 2.8]: slow stage velocity */
    two_stage_real x_acceleration; /* m/s^2 [-58.84 .. 58.84]: slow stage acceleration */
    two_stage_real y_position; /* m [-0.6000000000000001 .. 0.6000000000000001]: slow stage position */
    two_stage_real y_velocity; /* m/s [-2.8 .. 2.8]: slow stage velocity */
    two_stage_real y_acceleration; /* m/s^2 [-58.84 .. 58.84]: slow stage acceleration */
    two_stage_real last_x; /* m [-0.4 .. 0.4]: last point taken */
    two_stage_real last_y; /* m [-0.4 .. 0.4]: last point taken */
    two_stage_real points_x[150]; /* m [-0.4 .. 0.4]: the next points of the path, x; in range, as zero is, beyond n_points too */
    two_stage_real points_y[150]; /* m [-0.4 .. 0.4]: the next points of the path, y; in range, as zero is, beyond n_points too */
    int32_t n_points; /* 1 [0 .. 150]: valid points */
} two_stage_governor_step_in;

typedef struct {
    int32_t points_taken; /* 1 [0 .. 150]: eta of (14) */
    two_stage_real reference_x; /* m [-0.4 .. 0.4]: r of (15b) */
    two_stage_real low_x; /* m [-0.4 .. 0.4]: least coordinate among the points of the interval */
    two_stage_real high_x; /* m [-0.4 .. 0.4]: greatest coordinate among them */
    two_stage_real reference_y; /* m [-0.4 .. 0.4]: r of (15b) */
    two_stage_real low_y; /* m [-0.4 .. 0.4]: least coordinate among the points of the interval */
    two_stage_real high_y; /* m [-0.4 .. 0.4]: greatest coordinate among them */
} two_stage_governor_step_out;

/* Before anything else: clears the state. */
void two_stage_governor_init(two_stage_governor_t *self);

/* The most points, at most M, that keep (14b)-(14d); none is always allowed. */
sg_status two_stage_governor_step(two_stage_governor_t *self, const two_stage_governor_step_in *in, two_stage_governor_step_out *out);

#ifdef __cplusplus
}
#endif

#endif
