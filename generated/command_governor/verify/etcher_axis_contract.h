/* SPDX-License-Identifier: MIT */
/* Made by servogen 0.1.0 from controller.h.jinja; not to be edited. Design db73e1a8671115da. */
/* Extended command governor (17) of one axis: dual active-set method, property (b) */
#ifndef ETCHER_AXIS_H
#define ETCHER_AXIS_H

#include "etcher_types.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    ETCHER_AXIS_PLANT_ORDER = 3, /* states of the slow stage */
    ETCHER_AXIS_ORDER = 4, /* states behind the rows: and the command held */
    ETCHER_AXIS_STATES = 4, /* the same */
    ETCHER_AXIS_INTERVALS = 42, /* periods of the plan, and all that follows */
    ETCHER_AXIS_ROWS = 280, /* two-sided rows */
    ETCHER_AXIS_ROWS_PER_STEP = 6, /* rows of one period */
    ETCHER_AXIS_TERMINAL_ROWS = 34, /* rows after the last period */
    ETCHER_AXIS_ITERATION_CAP = 45, /* iterations at the most */
    ETCHER_AXIS_PATIENCE = 46, /* periods at rest and at the cap */
    ETCHER_AXIS_VARIABLES = 41, /* of the program */
    ETCHER_AXIS_FACTOR = 861, /* L of the working set, and the row that enters */
    ETCHER_AXIS_VECTORS = 1681, /* -H^-1 a of the working set */
    ETCHER_AXIS_KEEP = 20, /* a working set of so many rows stays as it is */
    ETCHER_AXIS_STEPS = 41, /* of the horizon */
    ETCHER_AXIS_INPUTS = 1, /* variables of one step */
    ETCHER_AXIS_BOUNDS = 0, /* rows of a step that are its variables */
    ETCHER_AXIS_LIMITED = 2 /* states that are rows */
};

/* All state; the caller owns it, as many as she likes. Members are private. */
typedef struct {
    SG_GIVEN int32_t begun; /* SG_BEGUN after init */
    SG_GIVEN etcher_real predicted[ETCHER_AXIS_PLANT_ORDER]; /* state expected at the next step */
} etcher_axis_t;

typedef struct {
    etcher_real position; /* m [-0.375 .. 0.375]: where the stage stands */
} etcher_axis_reset_in;

typedef struct {
    etcher_real position; /* m [-0.375 .. 0.375]: slow stage position */
    etcher_real velocity; /* m/s [-0.4 .. 0.4]: slow stage velocity */
    etcher_real acceleration; /* m/s^2 [-40.0 .. 40.0]: slow stage acceleration */
} etcher_axis_foresee_in;

typedef struct {
    etcher_real position; /* m [-0.375 .. 0.375]: slow stage position */
    etcher_real velocity; /* m/s [-0.4 .. 0.4]: slow stage velocity */
    etcher_real acceleration; /* m/s^2 [-40.0 .. 40.0]: slow stage acceleration */
    etcher_real reference[41]; /* m [-0.375 .. 0.375]: r(0), ..., r(n) of (21) */
    etcher_real low[42]; /* m [-0.425 .. 0.425]: least position of an interval */
    etcher_real high[42]; /* m [-0.425 .. 0.425]: greatest position of an interval */
} etcher_axis_step_in;

typedef struct {
    etcher_real position; /* m [-0.375 .. 0.375]: slow stage position */
    etcher_real velocity; /* m/s [-0.4 .. 0.4]: slow stage velocity */
    etcher_real acceleration; /* m/s^2 [-40.0 .. 40.0]: slow stage acceleration */
} etcher_axis_predict_in;

typedef struct {
    etcher_real least[42]; /* m: least point in reach */
    etcher_real greatest[42]; /* m: greatest point in reach */
} etcher_axis_foresee_out;

typedef struct {
    etcher_real command; /* m [-0.375 .. 0.375]: command of this period */
    int32_t iterations; /* 1 [0 .. 45]: 0: none needed */
    int32_t standing; /* 1 [0 .. 1]: 1: at the end of its plan, which stays */
} etcher_axis_step_out;

typedef struct {
    etcher_real position; /* m: slow stage position */
    etcher_real velocity; /* m/s: slow stage velocity */
    etcher_real acceleration; /* m/s^2: slow stage acceleration */
} etcher_axis_predict_out;

/* Before anything else: clears the state. */
void etcher_axis_init(etcher_axis_t *self);

/* Stand still at a position: the plan commands it for ever. */
sg_status etcher_axis_reset(etcher_axis_t *self, const etcher_axis_reset_in *in);

/* Points within the stroke of the moved plan in every interval. */
sg_status etcher_axis_foresee(etcher_axis_t *self, const etcher_axis_foresee_in *in, etcher_axis_foresee_out *out);

/* Solve (17); where no optimum is found use the moved plan. */
sg_status etcher_axis_step(etcher_axis_t *self, const etcher_axis_step_in *in, etcher_axis_step_out *out);

/* State at the next sample, under the command of this period. */
sg_status etcher_axis_predict(const etcher_axis_t *self, const etcher_axis_predict_in *in, etcher_axis_predict_out *out);

#ifdef __cplusplus
}
#endif

#endif
