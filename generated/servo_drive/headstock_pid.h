/* SPDX-License-Identifier: MIT */
/* Made by servogen 0.1.0 from controller.h.jinja; not to be edited. Design 194d8956393bab30. */
/* Cascaded PID of a servo axis with the notch filter of its current loop */
#ifndef HEADSTOCK_PID_H
#define HEADSTOCK_PID_H

#include "headstock_types.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    HEADSTOCK_PID_RATIO = 8 /* runs of the filter in a sample */
};

/* All state; the caller owns it, as many as she likes. Members are private. */
typedef struct {
    headstock_real last; /* last usable measurement, deg */
    headstock_real integral; /* of the speed error, mA */
    headstock_real wanted; /* current asked for, held between samples, mA */
    headstock_real memory_1; /* of the notch */
    headstock_real memory_2; /* of the notch */
    int32_t ready; /* whether reset has been called */
} headstock_pid_t;

typedef struct {
    headstock_real position; /* deg [-36000.0 .. 36000.0]: measured now */
} headstock_pid_reset_in;

typedef struct {
    headstock_real position; /* deg [-36000.0 .. 36000.0]: measured now */
    headstock_real reference; /* deg [-36000.0 .. 36000.0]: wanted now */
} headstock_pid_step_in;

typedef struct {
    headstock_real wanted; /* mA [-1000.0 .. 1000.0]: what the speed loop asks for */
} headstock_pid_step_out;

typedef struct {
    headstock_real current; /* mA [-1000.0 .. 1000.0]: what the drive is given */
} headstock_pid_filter_step_out;

/* Before anything else: clears the state. */
void headstock_pid_init(headstock_pid_t *self);

/* The axis stands at a position, without current. */
sg_status headstock_pid_reset(headstock_pid_t *self, const headstock_pid_reset_in *in);

/* One sample of the position and speed loops. */
sg_status headstock_pid_step(headstock_pid_t *self, const headstock_pid_step_in *in, headstock_pid_step_out *out);

/* One run of the filter on the current asked for last. */
sg_status headstock_pid_filter_step(headstock_pid_t *self, headstock_pid_filter_step_out *out);

#ifdef __cplusplus
}
#endif

#endif
