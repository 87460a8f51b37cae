/* SPDX-License-Identifier: MIT */
/* Made by servogen 0.1.0 from controller.h.jinja; not to be edited. Design 2df8fd9b7b96227c. */
/* Tracking MPC (16) of one axis: condensed QP (19), PQP (20)-(21), Corollary 1 */
#ifndef TWO_STAGE_MPC_H
#define TWO_STAGE_MPC_H

#include "two_stage_types.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    TWO_STAGE_MPC_ORDER = 3, /* states of the slow stage */
    TWO_STAGE_MPC_HORIZON = 20, /* N */
    TWO_STAGE_MPC_REFERENCES = 21, /* r_0..r_N */
    TWO_STAGE_MPC_ROWS = 63, /* two-sided rows of (19b) */
    TWO_STAGE_MPC_ROWS_PER_STEP = 3, /* position, velocity, ... */
    TWO_STAGE_MPC_TERMINAL_ROWS = 3, /* of (16g), not implied */
    TWO_STAGE_MPC_ITERATION_CAP = 186, /* iterations at the most */
    TWO_STAGE_MPC_VARIABLES = 20, /* of the program */
    TWO_STAGE_MPC_STRIDE = 64, /* ROWS, filled up to a multiple of four */
    TWO_STAGE_MPC_LINES = 20, /* columns of the bound on |D|, filled up likewise */
    TWO_STAGE_MPC_BLOCKS = 5, /* of four steps whose rows share columns */
    TWO_STAGE_MPC_STEPS = 20, /* of the horizon */
    TWO_STAGE_MPC_INPUTS = 1, /* variables of one step */
    TWO_STAGE_MPC_BOUNDS = 0, /* rows of a step that are its variables */
    TWO_STAGE_MPC_LIMITED = 3, /* states that are rows */
    TWO_STAGE_MPC_PERIOD = 6 /* turns of an acceleration cycle */
};

/* All state; the caller owns it, as many as she likes. Members are private. */
typedef struct {
    SG_GIVEN int32_t begun; /* SG_BEGUN after init */
    SG_GIVEN two_stage_real predicted[TWO_STAGE_MPC_ORDER]; /* state expected at the next step */
} two_stage_mpc_t;

typedef struct {
    two_stage_real position; /* m [-0.6000000000000001 .. 0.6000000000000001]: where the stage stands */
} two_stage_mpc_reset_in;

typedef struct {
    two_stage_real command; /* m [-0.6000000000000001 .. 0.6000000000000001]: command */
} two_stage_mpc_seed_in;

typedef struct {
    two_stage_real position; /* m [-0.6000000000000001 .. 0.6000000000000001]: slow stage position */
    two_stage_real velocity; /* m/s [-2.8 .. 2.8]: slow stage velocity */
    two_stage_real acceleration; /* m/s^2 [-58.84 .. 58.84]: slow stage acceleration */
} two_stage_mpc_candidate_in;

typedef struct {
    two_stage_real position; /* m [-0.6000000000000001 .. 0.6000000000000001]: slow stage position */
    two_stage_real velocity; /* m/s [-2.8 .. 2.8]: slow stage velocity */
    two_stage_real acceleration; /* m/s^2 [-58.84 .. 58.84]: slow stage acceleration */
    two_stage_real reference[21]; /* m [-0.4 .. 0.4]: r_0..r_N, the points reached at the slow samples 0..N ahead */
    two_stage_real low[20]; /* m [-0.6000000000000001 .. 0.6000000000000001]: lower bound of the position at the slow samples 1..N ahead */
    two_stage_real high[20]; /* m [-0.6000000000000001 .. 0.6000000000000001]: upper bound of the position at the slow samples 1..N ahead */
} two_stage_mpc_step_in;

typedef struct {
    two_stage_real reference; /* m [-0.4 .. 0.4]: r_N */
} two_stage_mpc_hold_in;

typedef struct {
    two_stage_real position; /* m: slow stage position */
    two_stage_real velocity; /* m/s: slow stage velocity */
    two_stage_real acceleration; /* m/s^2: slow stage acceleration */
} two_stage_mpc_candidate_out;

typedef struct {
    two_stage_real command; /* m [-0.6000000000000001 .. 0.6000000000000001]: slow stage position command for this period */
    int32_t iterations; /* 1 [0 .. 186]: iterates evaluated; 0: none needed */
} two_stage_mpc_step_out;

typedef struct {
    two_stage_real command; /* m [-0.6000000000000001 .. 0.6000000000000001]: slow stage position command for this period */
    two_stage_real position; /* m: slow stage position */
    two_stage_real velocity; /* m/s: slow stage velocity */
    two_stage_real acceleration; /* m/s^2: slow stage acceleration */
} two_stage_mpc_hold_out;

/* Before anything else: clears the state. */
void two_stage_mpc_init(two_stage_mpc_t *self);

/* Stand still at a position: the plan commands it for ever. */
sg_status two_stage_mpc_reset(two_stage_mpc_t *self, const two_stage_mpc_reset_in *in);

/* Shift the plan and append a command (priming), a bad one not: the last repeats. */
sg_status two_stage_mpc_seed(two_stage_mpc_t *self, const two_stage_mpc_seed_in *in);

/* State at the end of the shifted plan but one, from the measured state if usable. */
sg_status two_stage_mpc_candidate(const two_stage_mpc_t *self, const two_stage_mpc_candidate_in *in, two_stage_mpc_candidate_out *out);

/* Solve (16); at the cap without a feasible iterate, use the shifted plan. */
sg_status two_stage_mpc_step(two_stage_mpc_t *self, const two_stage_mpc_step_in *in, two_stage_mpc_step_out *out);

/* No usable measurement: go on with the shifted plan, from the predicted state. */
sg_status two_stage_mpc_hold(two_stage_mpc_t *self, const two_stage_mpc_hold_in *in, two_stage_mpc_hold_out *out);

#ifdef __cplusplus
}
#endif

#endif
