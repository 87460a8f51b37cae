/* SPDX-License-Identifier: MIT */
/* Made by servogen 0.1.0 from tables.h.jinja; not to be edited. Design 2df8fd9b7b96227c. */
/* Constant tables of two_stage_follower; included by two_stage_follower.c only. */
#ifndef TWO_STAGE_FOLLOWER_TABLES_H
#define TWO_STAGE_FOLLOWER_TABLES_H

/* 1 / RAMP */
static const sg_real two_stage_follower_ramp_inverse = 0.02;
/* RAMP / 2 */
static const sg_real two_stage_follower_ramp_half = 25.0;
/* 2 / RAMP */
static const sg_real two_stage_follower_ramp_twice_inverse = 0.04;
/* M - RAMP */
static const sg_real two_stage_follower_flat = 100.0;
/* 1 / (M - RAMP) */
static const sg_real two_stage_follower_flat_inverse = 0.01;
/* 1 / (2 M) */
static const sg_real two_stage_follower_rate_scale = 0.0033333333333333335;
/* x: compensation on the command */
static const sg_real two_stage_follower_direct_x = 1.2709992392075466e-05;
/* m: no point of the path beyond it */
static const sg_real two_stage_follower_end_x = 0.4;
/* m: no fast command beyond it */
static const sg_real two_stage_follower_limit_x = 0.042;
/* y: compensation on the command */
static const sg_real two_stage_follower_direct_y = 1.2709992392075466e-05;
/* m: no point of the path beyond it */
static const sg_real two_stage_follower_end_y = 0.4;
/* m: no fast command beyond it */
static const sg_real two_stage_follower_limit_y = 0.042;

/* x: slow stage at T_f, transposed; 3 x 3 */
SG_PRAGMA("DATA_ALIGN(two_stage_follower_model_x, 8)")
static const sg_real two_stage_follower_model_x[9] = {
    0.9999998791544491, -0.001809419261213504, -18.028994859213487, 0.0001999935488551391,
    0.999903376793851, -0.9633558117525997, 1.985645279795341e-08, 0.00019784905195296013,
    0.9785356791829313
};

/* x: slow stage at T_f, input; 3 */
SG_PRAGMA("DATA_ALIGN(two_stage_follower_input_x, 8)")
static const sg_real two_stage_follower_input_x[3] = {
    1.2084555093542547e-07, 0.001809419261213504, 18.028994859213487
};

/* x: compensation on the state; 3 */
SG_PRAGMA("DATA_ALIGN(two_stage_follower_row_x, 8)")
static const sg_real two_stage_follower_row_x[3] = {
    0.9999872900076079, 0.0011659877729578866, 5.706222013856438e-07
};

/* x: model's state; 3 */
SG_PRAGMA("DATA_ALIGN(two_stage_follower_bound_x, 8)")
static const sg_real two_stage_follower_bound_x[3] = {
    0.6000000000000001, 2.8, 58.84
};

/* y: slow stage at T_f, transposed; 3 x 3 */
SG_PRAGMA("DATA_ALIGN(two_stage_follower_model_y, 8)")
static const sg_real two_stage_follower_model_y[9] = {
    0.9999998791544491, -0.001809419261213504, -18.028994859213487, 0.0001999935488551391,
    0.999903376793851, -0.9633558117525997, 1.985645279795341e-08, 0.00019784905195296013,
    0.9785356791829313
};

/* y: slow stage at T_f, input; 3 */
SG_PRAGMA("DATA_ALIGN(two_stage_follower_input_y, 8)")
static const sg_real two_stage_follower_input_y[3] = {
    1.2084555093542547e-07, 0.001809419261213504, 18.028994859213487
};

/* y: compensation on the state; 3 */
SG_PRAGMA("DATA_ALIGN(two_stage_follower_row_y, 8)")
static const sg_real two_stage_follower_row_y[3] = {
    0.9999872900076079, 0.0011659877729578866, 5.706222013856438e-07
};

/* y: model's state; 3 */
SG_PRAGMA("DATA_ALIGN(two_stage_follower_bound_y, 8)")
static const sg_real two_stage_follower_bound_y[3] = {
    0.6000000000000001, 2.8, 58.84
};

#endif
