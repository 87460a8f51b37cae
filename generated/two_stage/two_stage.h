/* SPDX-License-Identifier: MIT */
/* Made by servogen 0.1.0 from controller.h.jinja; not to be edited. Design 2df8fd9b7b96227c. */
/* SPRG-MPC cascade for a two-stage machine */
#ifndef TWO_STAGE_H
#define TWO_STAGE_H

#include "two_stage_types.h"
#include "two_stage_governor.h"
#include "two_stage_mpc.h"
#include "two_stage_follower.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    TWO_STAGE_ORDER = 3, /* states of a slow stage */
    TWO_STAGE_POINTS = 150, /* M */
    TWO_STAGE_HORIZON = 20, /* N; 0: the governor alone */
    TWO_STAGE_REFERENCES = 21, /* r_0..r_N */
    TWO_STAGE_INTERVALS = 20, /* intervals looked ahead */
    TWO_STAGE_WAITING = 3000, /* points that can wait */
    TWO_STAGE_PRIMING = 19 /* steps that fill the horizon */
};

/* All state; the caller owns it, as many as she likes. Members are private. */
typedef struct {
    two_stage_governor_t governor; /* governor */
    two_stage_mpc_t mpc_x; /* tracking MPC, x */
    two_stage_mpc_t mpc_y; /* tracking MPC, y */
    two_stage_follower_t fast; /* fast stage */
    two_stage_real reference_x[TWO_STAGE_REFERENCES]; /* r_0..r_N, m */
    two_stage_real low_x[TWO_STAGE_INTERVALS]; /* least coordinate of intervals 1..N */
    two_stage_real high_x[TWO_STAGE_INTERVALS]; /* greatest coordinate of them */
    two_stage_real state_x[TWO_STAGE_ORDER]; /* state of the slow stage used */
    two_stage_real command_x; /* slow stage command, m */
    two_stage_real reference_y[TWO_STAGE_REFERENCES]; /* r_0..r_N, m */
    two_stage_real low_y[TWO_STAGE_INTERVALS]; /* least coordinate of intervals 1..N */
    two_stage_real high_y[TWO_STAGE_INTERVALS]; /* greatest coordinate of them */
    two_stage_real state_y[TWO_STAGE_ORDER]; /* state of the slow stage used */
    two_stage_real command_y; /* slow stage command, m */
    int32_t pending; /* points taken and not yet processed */
    int32_t offered; /* points offered to the last plan */
    int32_t planned; /* 1 between plan and start */
    int32_t priming; /* priming steps left */
    int32_t ready; /* 1 after a successful reset */
} two_stage_t;

typedef struct {
    two_stage_real position_x; /* m [-0.4 .. 0.4]: first point */
    two_stage_real position_y; /* m [-0.4 .. 0.4]: first point */
} two_stage_reset_in;

typedef struct {
    two_stage_real x_position; /* m [-0.6000000000000001 .. 0.6000000000000001]: slow stage position */
    two_stage_real x_velocity; /* m/s [-2.8 .. 2.8]: slow stage velocity */
    two_stage_real x_acceleration; /* m/s^2 [-58.84 .. 58.84]: slow stage acceleration */
    two_stage_real y_position; /* m [-0.6000000000000001 .. 0.6000000000000001]: slow stage position */
    two_stage_real y_velocity; /* m/s [-2.8 .. 2.8]: slow stage velocity */
    two_stage_real y_acceleration; /* m/s^2 [-58.84 .. 58.84]: slow stage acceleration */
    two_stage_real points_x[150]; /* m [-0.4 .. 0.4]: the next points of the path, x; those beyond n_points are not read */
    two_stage_real points_y[150]; /* m [-0.4 .. 0.4]: the next points of the path, y; those beyond n_points are not read */
    int32_t n_points; /* 1 [0 .. 150]: valid points */
} two_stage_step_in;

typedef struct {
    two_stage_real x_position; /* m [-0.6000000000000001 .. 0.6000000000000001]: slow stage position */
    two_stage_real x_velocity; /* m/s [-2.8 .. 2.8]: slow stage velocity */
    two_stage_real x_acceleration; /* m/s^2 [-58.84 .. 58.84]: slow stage acceleration */
    two_stage_real y_position; /* m [-0.6000000000000001 .. 0.6000000000000001]: slow stage position */
    two_stage_real y_velocity; /* m/s [-2.8 .. 2.8]: slow stage velocity */
    two_stage_real y_acceleration; /* m/s^2 [-58.84 .. 58.84]: slow stage acceleration */
} two_stage_predict_in;

typedef struct {
    two_stage_real command_x; /* m [-0.6000000000000001 .. 0.6000000000000001]: slow stage position command */
    two_stage_real command_y; /* m [-0.6000000000000001 .. 0.6000000000000001]: slow stage position command */
    int32_t points_taken; /* 1 [0 .. 150]: points to drop from the front of the path */
    int32_t interval_points; /* 1 [0 .. 150]: points of the interval that begins */
    int32_t pending; /* 1 [0 .. 3000]: points taken and not yet processed */
    int32_t iterations_x; /* 1 [0 .. 186]: iterations of the MPC's program */
    int32_t iterations_y; /* 1 [0 .. 186]: iterations of the MPC's program */
    int32_t status_x; /* 1 [0 .. 10]: status of this axis */
    int32_t status_y; /* 1 [0 .. 10]: status of this axis */
} two_stage_step_out;

typedef struct {
    two_stage_real x_position; /* m: slow stage position */
    two_stage_real x_velocity; /* m/s: slow stage velocity */
    two_stage_real x_acceleration; /* m/s^2: slow stage acceleration */
    two_stage_real y_position; /* m: slow stage position */
    two_stage_real y_velocity; /* m/s: slow stage velocity */
    two_stage_real y_acceleration; /* m/s^2: slow stage acceleration */
} two_stage_predict_out;

typedef struct {
    two_stage_real command_x; /* m [-0.6000000000000001 .. 0.6000000000000001]: slow stage position command */
    two_stage_real command_y; /* m [-0.6000000000000001 .. 0.6000000000000001]: slow stage position command */
    int32_t interval_points; /* 1 [0 .. 150]: points of the interval that begins */
    int32_t pending; /* 1 [0 .. 3000]: points taken and not yet processed */
} two_stage_start_out;

typedef struct {
    two_stage_real command_x; /* m [-0.042 .. 0.042]: fast stage command */
    two_stage_real command_y; /* m [-0.042 .. 0.042]: fast stage command */
    two_stage_real reference_x; /* m [-0.4 .. 0.4]: r_f of (22), where the tool should be */
    two_stage_real reference_y; /* m [-0.4 .. 0.4]: r_f of (22), where the tool should be */
    two_stage_real along; /* 1 [0.0 .. 150.0]: points of the interval behind that point */
} two_stage_fast_step_out;

typedef two_stage_step_in two_stage_plan_in;
typedef two_stage_step_out two_stage_plan_out;

/* Before anything else: clears the state. */
void two_stage_init(two_stage_t *self);

/* Stand at the first point of the path. */
sg_status two_stage_reset(two_stage_t *self, const two_stage_reset_in *in);

/* plan and start in one, for a processor that needs no time to speak of. */
sg_status two_stage_step(two_stage_t *self, const two_stage_step_in *in, two_stage_step_out *out);

/* State at the next slow sample, from the one measured at the last. */
sg_status two_stage_predict(const two_stage_t *self, const two_stage_predict_in *in, two_stage_predict_out *out);

/* Govern and optimise for the state at the next slow sample; takes its time. */
sg_status two_stage_plan(two_stage_t *self, const two_stage_plan_in *in, two_stage_plan_out *out);

/* At the slow sample, not interrupted by fast_step: begin what was planned. */
sg_status two_stage_start(two_stage_t *self, two_stage_start_out *out);

/* One fast sample. */
void two_stage_fast_step(two_stage_t *self, two_stage_fast_step_out *out);

#ifdef __cplusplus
}
#endif

#endif
