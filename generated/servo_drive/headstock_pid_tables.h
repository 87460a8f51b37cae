/* SPDX-License-Identifier: MIT */
/* Made by servogen 0.1.0 from tables.h.jinja; not to be edited. Design 194d8956393bab30. */
/* Constant tables of headstock_pid; included by headstock_pid.c only. */
#ifndef HEADSTOCK_PID_TABLES_H
#define HEADSTOCK_PID_TABLES_H

/* 1/s */
static const sg_real headstock_pid_position_gain = 21.6666f;
/* mA per deg/s */
static const sg_real headstock_pid_velocity_gain = 74.066666f;
/* mA per deg/s and sample */
static const sg_real headstock_pid_integral_gain = 18.516666f;
/* 1/s: samples */
static const sg_real headstock_pid_rate = 2000.0f;
/* mA */
static const sg_real headstock_pid_limit_low = -1000.0f;
/* mA */
static const sg_real headstock_pid_limit_high = 1000.0f;
/* deg: one turn */
static const sg_real headstock_pid_turn = 360.0f;
/* half of it */
static const sg_real headstock_pid_half_turn = 180.0f;
/* 1 / turn */
static const sg_real headstock_pid_turn_inverse = 0.0027777778f;
/* notch (16), on the current asked for */
static const sg_real headstock_pid_b0 = 0.9352f;
/* on the one before */
static const sg_real headstock_pid_b1 = -1.8492645f;
/* on the one before that */
static const sg_real headstock_pid_b2 = 0.9352f;
/* on the last output, taken off */
static const sg_real headstock_pid_a1 = -1.8492f;
/* on the one before, taken off */
static const sg_real headstock_pid_a2 = 0.8651f;
/* mA: the first memory stays within */
static const sg_real headstock_pid_most_1 = 1416.063f;
/* mA: the second */
static const sg_real headstock_pid_most_2 = 1352.4562f;

#endif
