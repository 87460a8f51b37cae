/* SPDX-License-Identifier: MIT */
/* Made by servogen 0.1.0 from controller.h.jinja; not to be edited. Design 2df8fd9b7b96227c. */
/* Fast stage commands (22)-(23) and the feed along the points */
#ifndef TWO_STAGE_FOLLOWER_H
#define TWO_STAGE_FOLLOWER_H

#include "two_stage_types.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    TWO_STAGE_FOLLOWER_ORDER = 3, /* states of a slow stage */
    TWO_STAGE_FOLLOWER_POINTS = 150, /* M, fast samples per interval */
    TWO_STAGE_FOLLOWER_INTERVALS = 20, /* intervals that can wait */
    TWO_STAGE_FOLLOWER_BUFFER = 3151, /* points kept */
    TWO_STAGE_FOLLOWER_RAMP = 50 /* fast samples of a feed ramp */
};

/* All state; the caller owns it, as many as she likes. Members are private. */
typedef struct {
    SG_GIVEN int32_t begun; /* SG_BEGUN after init */
} two_stage_follower_t;

typedef struct {
    two_stage_real position_x; /* m [-0.4 .. 0.4]: start point */
    two_stage_real position_y; /* m [-0.4 .. 0.4]: start point */
} two_stage_follower_reset_in;

typedef struct {
    two_stage_real points_x[150]; /* m [-0.4 .. 0.4]: the next points of the path, x; in range, as zero is, beyond n_points too */
    two_stage_real points_y[150]; /* m [-0.4 .. 0.4]: the next points of the path, y; in range, as zero is, beyond n_points too */
    int32_t n_points; /* 1 [0 .. 150]: valid points */
} two_stage_follower_push_in;

typedef struct {
    two_stage_real x_position; /* m [-0.6000000000000001 .. 0.6000000000000001]: slow stage position */
    two_stage_real x_velocity; /* m/s [-2.8 .. 2.8]: slow stage velocity */
    two_stage_real x_acceleration; /* m/s^2 [-58.84 .. 58.84]: slow stage acceleration */
    two_stage_real slow_command_x; /* m [-0.6000000000000001 .. 0.6000000000000001]: slow stage command */
    two_stage_real y_position; /* m [-0.6000000000000001 .. 0.6000000000000001]: slow stage position */
    two_stage_real y_velocity; /* m/s [-2.8 .. 2.8]: slow stage velocity */
    two_stage_real y_acceleration; /* m/s^2 [-58.84 .. 58.84]: slow stage acceleration */
    two_stage_real slow_command_y; /* m [-0.6000000000000001 .. 0.6000000000000001]: slow stage command */
} two_stage_follower_begin_in;

typedef struct {
    int32_t interval_points; /* 1 [0 .. 150]: its points */
} two_stage_follower_begin_out;

typedef struct {
    int32_t points; /* 1 [0 .. 150]: at most M */
} two_stage_follower_room_out;

typedef struct {
    two_stage_real command_x; /* m [-0.042 .. 0.042]: fast stage command */
    two_stage_real command_y; /* m [-0.042 .. 0.042]: fast stage command */
    two_stage_real reference_x; /* m [-0.4 .. 0.4]: r_f of (22), where the tool should be */
    two_stage_real reference_y; /* m [-0.4 .. 0.4]: r_f of (22), where the tool should be */
    two_stage_real along; /* 1 [0.0 .. 150.0]: points of the interval behind that point */
} two_stage_follower_step_out;

/* Before anything else: clears the state. */
void two_stage_follower_init(two_stage_follower_t *self);

/* Forget the queue; stand at a point. */
sg_status two_stage_follower_reset(two_stage_follower_t *self, const two_stage_follower_reset_in *in);

/* Queue the points of one interval. */
sg_status two_stage_follower_push(two_stage_follower_t *self, const two_stage_follower_push_in *in);

/* Start the next interval of the queue from the slow stage's measured state. */
sg_status two_stage_follower_begin(two_stage_follower_t *self, const two_stage_follower_begin_in *in, two_stage_follower_begin_out *out);

/* Most points the next interval can pass without a step in the feed. */
void two_stage_follower_room(const two_stage_follower_t *self, two_stage_follower_room_out *out);

/* One fast sample. */
void two_stage_follower_step(two_stage_follower_t *self, two_stage_follower_step_out *out);

#ifdef __cplusplus
}
#endif

#endif
