/* SPDX-License-Identifier: MIT */
/* Made by servogen 0.1.0 from controller.h.jinja; not to be edited. Design db73e1a8671115da. */
/* Extended command governor (17)-(18), (21), both axes */
#ifndef ETCHER_H
#define ETCHER_H

#include "etcher_types.h"
#include "etcher_axis.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    ETCHER_ORDER = 3, /* states of a slow stage */
    ETCHER_POINTS = 500, /* M, points per period at the most */
    ETCHER_WINDOW = 8000, /* points ahead that a plan looks at */
    ETCHER_INTERVALS = 42, /* periods of the plan, and all that follows */
    ETCHER_VARIABLES = 41, /* commands of the plan */
    ETCHER_ROUNDS = 82 /* turns of the planning */
};

/* All state; the caller owns it, as many as she likes. Members are private. */
typedef struct {
    etcher_real last_x; /* the last point machined, m */
    etcher_real last_y; /* the last point machined, m */
    etcher_real home_x; /* its reference, m */
    etcher_real home_y; /* its reference, m */
    int32_t planned[ETCHER_INTERVALS]; /* points machined at the start of an interval */
    etcher_axis_t x; /* of the axis */
    etcher_axis_t y; /* of the axis */
    int32_t indices[ETCHER_INTERVALS]; /* workspace, no meaning between calls: the new ones */
    int32_t parts[ETCHER_INTERVALS]; /* workspace, no meaning between calls: intervals before which points were taken */
    etcher_real least_x[ETCHER_INTERVALS]; /* workspace, no meaning between calls: in reach in an interval */
    etcher_real greatest_x[ETCHER_INTERVALS]; /* workspace, no meaning between calls: in reach in an interval */
    etcher_real least_on_x[ETCHER_INTERVALS]; /* workspace, no meaning between calls: in reach from one on */
    etcher_real greatest_on_x[ETCHER_INTERVALS]; /* workspace, no meaning between calls: in reach from one on */
    etcher_real least_y[ETCHER_INTERVALS]; /* workspace, no meaning between calls: in reach in an interval */
    etcher_real greatest_y[ETCHER_INTERVALS]; /* workspace, no meaning between calls: in reach in an interval */
    etcher_real least_on_y[ETCHER_INTERVALS]; /* workspace, no meaning between calls: in reach from one on */
    etcher_real greatest_on_y[ETCHER_INTERVALS]; /* workspace, no meaning between calls: in reach from one on */
    int32_t lost; /* 1 where the tool waits for the stages to come back */
    int32_t ready; /* 1 after a successful reset */
} etcher_t;

typedef struct {
    etcher_real position_x; /* m [-0.375 .. 0.375]: first point, where the stage stands */
    etcher_real position_y; /* m [-0.375 .. 0.375]: first point, where the stage stands */
} etcher_reset_in;

typedef struct {
    etcher_real x_position; /* m [-0.375 .. 0.375]: slow stage position */
    etcher_real x_velocity; /* m/s [-0.4 .. 0.4]: slow stage velocity */
    etcher_real x_acceleration; /* m/s^2 [-40.0 .. 40.0]: slow stage acceleration */
    etcher_real y_position; /* m [-0.375 .. 0.375]: slow stage position */
    etcher_real y_velocity; /* m/s [-0.4 .. 0.4]: slow stage velocity */
    etcher_real y_acceleration; /* m/s^2 [-40.0 .. 40.0]: slow stage acceleration */
} etcher_predict_in;

typedef struct {
    etcher_real x_position; /* m [-0.375 .. 0.375]: slow stage position */
    etcher_real x_velocity; /* m/s [-0.4 .. 0.4]: slow stage velocity */
    etcher_real x_acceleration; /* m/s^2 [-40.0 .. 40.0]: slow stage acceleration */
    etcher_real y_position; /* m [-0.375 .. 0.375]: slow stage position */
    etcher_real y_velocity; /* m/s [-0.4 .. 0.4]: slow stage velocity */
    etcher_real y_acceleration; /* m/s^2 [-40.0 .. 40.0]: slow stage acceleration */
    etcher_real points_x[8000]; /* m [-0.375 .. 0.375]: points after the last one machined, x; those beyond n_points are not read */
    etcher_real points_y[8000]; /* m [-0.375 .. 0.375]: points after the last one machined, y; those beyond n_points are not read */
    etcher_real slow_x[8000]; /* m [-0.375 .. 0.375]: (19), x; those beyond n_points are not read */
    etcher_real slow_y[8000]; /* m [-0.375 .. 0.375]: (19), y; those beyond n_points are not read */
    int32_t n_points; /* 1 [0 .. 8000]: valid points */
} etcher_step_in;

typedef struct {
    etcher_real x_position; /* m: slow stage position */
    etcher_real x_velocity; /* m/s: slow stage velocity */
    etcher_real x_acceleration; /* m/s^2: slow stage acceleration */
    etcher_real y_position; /* m: slow stage position */
    etcher_real y_velocity; /* m/s: slow stage velocity */
    etcher_real y_acceleration; /* m/s^2: slow stage acceleration */
} etcher_predict_out;

typedef struct {
    int32_t points_taken; /* 1 [0 .. 500]: machined in this period */
    etcher_real command_x; /* m [-0.375 .. 0.375]: command of this period */
    int32_t status_x; /* 1: of the axis */
    int32_t iterations_x; /* 1 [0 .. 45]: of the axis */
    etcher_real command_y; /* m [-0.375 .. 0.375]: command of this period */
    int32_t status_y; /* 1: of the axis */
    int32_t iterations_y; /* 1 [0 .. 45]: of the axis */
} etcher_step_out;

/* Before anything else: clears the state. */
void etcher_init(etcher_t *self);

/* Stand still at the first point. */
sg_status etcher_reset(etcher_t *self, const etcher_reset_in *in);

/* States at the next sample: plan from them while this period lasts. */
sg_status etcher_predict(const etcher_t *self, const etcher_predict_in *in, etcher_predict_out *out);

/* Plan from the state at a sample: the commands and points of the period it begins. */
sg_status etcher_step(etcher_t *self, const etcher_step_in *in, etcher_step_out *out);

#ifdef __cplusplus
}
#endif

#endif
