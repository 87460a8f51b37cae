/* SPDX-License-Identifier: MIT */
/* Made by servogen 0.1.0 from tables.h.jinja; not to be edited. Design 194d8956393bab30. */
/* Constant tables of headstock_mpc; included by headstock_mpc.c only. */
#ifndef HEADSTOCK_MPC_TABLES_H
#define HEADSTOCK_MPC_TABLES_H

/* deg: one turn */
static const sg_real headstock_mpc_turn = 360.0f;
/* half of it */
static const sg_real headstock_mpc_half_turn = 180.0f;
/* 1 / turn */
static const sg_real headstock_mpc_turn_inverse = 0.0027777778f;

/* A_p, transposed; 4 x 4 */
SG_PRAGMA("DATA_ALIGN(headstock_mpc_on_state, 8)")
static const sg_real headstock_mpc_on_state[16] = {
    0.3565848f, 0.18323088f, 0.00038305018f, 3.3295084e-05f, 0.6429153f, 0.8162693f,
    0.00011682485f, 0.00046657995f, -2081.0427f, 593.09717f, 0.37375608f, 0.17847952f,
    2081.0427f, -593.09717f, 0.6262439f, 0.8215205f
};

/* B_p, transposed; 1 x 4 */
SG_PRAGMA("DATA_ALIGN(headstock_mpc_on_input, 8)")
static const sg_real headstock_mpc_on_input[4] = {
    8.633951e-05f, 7.5047114e-06f, 2.4709829e-08f, 9.862356e-10f
};

/* C_p, transposed; 4 x 1 */
SG_PRAGMA("DATA_ALIGN(headstock_mpc_on_output, 8)")
static const sg_real headstock_mpc_on_output[4] = {
    0.0f, 0.0f, 57.29578f, 0.0f
};

/* Kalman gain of dx_p, transposed; 1 x 4 */
SG_PRAGMA("DATA_ALIGN(headstock_mpc_gain_state, 8)")
static const sg_real headstock_mpc_gain_state[4] = {
    0.05638338f, 1.133999f, 0.0029330286f, 0.0021662235f
};

/* of the output's estimate, less what is measured, transposed; 1 x 1 */
SG_PRAGMA("DATA_ALIGN(headstock_mpc_gain_output, 8)")
static const sg_real headstock_mpc_gain_output[1] = {
    -0.5063584f
};

/* largest dx_p that measurements can make; 4 */
SG_PRAGMA("DATA_ALIGN(headstock_mpc_bound, 8)")
static const sg_real headstock_mpc_bound[4] = {
    6629.873f, 2862.0842f, 6.8142467f, 6.3026495f
};

/* lower bounds of (10); 1 */
SG_PRAGMA("DATA_ALIGN(headstock_mpc_input_low, 8)")
static const sg_real headstock_mpc_input_low[1] = {
    -1000.0f
};

/* upper bounds of (10); 1 */
SG_PRAGMA("DATA_ALIGN(headstock_mpc_input_high, 8)")
static const sg_real headstock_mpc_input_high[1] = {
    1000.0f
};

#endif
