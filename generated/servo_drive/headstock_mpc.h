/* SPDX-License-Identifier: MIT */
/* Made by servogen 0.1.0 from controller.h.jinja; not to be edited. Design 194d8956393bab30. */
/* Trajectory-tracking MPC of a servo axis, with its Kalman filter */
#ifndef HEADSTOCK_MPC_H
#define HEADSTOCK_MPC_H

#include "headstock_types.h"
#include "headstock_mpc_lookup.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    HEADSTOCK_MPC_ORDER = 4, /* n, states */
    HEADSTOCK_MPC_INPUTS = 1, /* l */
    HEADSTOCK_MPC_OUTPUTS = 1, /* m */
    HEADSTOCK_MPC_TRAJECTORY = 3, /* H_t, references taken */
    HEADSTOCK_MPC_PARAMETERS = 8 /* length of theta */
};

/* All state; the caller owns it, as many as she likes. Members are private. */
typedef struct {
    headstock_real increment[HEADSTOCK_MPC_ORDER]; /* dx_p, predicted for the next sample */
    headstock_real drift[HEADSTOCK_MPC_OUTPUTS]; /* output predicted for it, less the last measured */
    headstock_real last[HEADSTOCK_MPC_OUTPUTS]; /* last usable measurement */
    headstock_real previous[HEADSTOCK_MPC_INPUTS]; /* u(k-1) */
    headstock_mpc_lookup_t lookup; /* of the first move */
    int32_t ready; /* whether reset has been called */
} headstock_mpc_t;

typedef struct {
    headstock_real position; /* deg [-36000.0 .. 36000.0]: measured now */
} headstock_mpc_reset_in;

typedef struct {
    headstock_real position; /* deg [-36000.0 .. 36000.0]: measured now */
    headstock_real reference[3]; /* deg [-36000.0 .. 36000.0]: wanted one to H_t samples ahead */
} headstock_mpc_step_in;

typedef struct {
    headstock_real current; /* mA [-1000.0 .. 1000.0]: what the drive is given; moves towards zero where the status is not OK */
} headstock_mpc_step_out;

/* Before anything else: clears the state. */
void headstock_mpc_init(headstock_mpc_t *self);

/* The axis stands at a position, without current. */
sg_status headstock_mpc_reset(headstock_mpc_t *self, const headstock_mpc_reset_in *in);

/* One sample: measure, estimate, look up, bound; then predict the next. */
sg_status headstock_mpc_step(headstock_mpc_t *self, const headstock_mpc_step_in *in, headstock_mpc_step_out *out);

#ifdef __cplusplus
}
#endif

#endif
