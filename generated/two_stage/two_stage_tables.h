/* SPDX-License-Identifier: MIT */
/* Made by servogen 0.1.0 from tables.h.jinja; not to be edited. Design 2df8fd9b7b96227c. */
/* Constant tables of two_stage; included by two_stage.c only. */
#ifndef TWO_STAGE_TABLES_H
#define TWO_STAGE_TABLES_H

/* m: fast stage range, x */
static const sg_real two_stage_range_x = 0.035;
/* m: slow stage range, x */
static const sg_real two_stage_position_limit_x = 0.4;
/* m: fast stage range, y */
static const sg_real two_stage_range_y = 0.035;
/* m: slow stage range, y */
static const sg_real two_stage_position_limit_y = 0.4;

/* A of (11), x, transposed; 3 x 3 */
SG_PRAGMA("DATA_ALIGN(two_stage_a_columns_x, 8)")
static const sg_real two_stage_a_columns_x[9] = {
    0.8208794722075057, -12.8825973381518, -325.71577110870527, 0.018842647831320707,
    0.13380761417274323, -30.254105130616082, 0.00014137281029521863, 0.003574384319437096,
    -0.2522258923264631
};

/* B of (11), x; 3 */
SG_PRAGMA("DATA_ALIGN(two_stage_b_x, 8)")
static const sg_real two_stage_b_x[3] = {
    0.17912052779249438, 12.8825973381518, 325.71577110870527
};

/* A of (11), y, transposed; 3 x 3 */
SG_PRAGMA("DATA_ALIGN(two_stage_a_columns_y, 8)")
static const sg_real two_stage_a_columns_y[9] = {
    0.8208794722075057, -12.8825973381518, -325.71577110870527, 0.018842647831320707,
    0.13380761417274323, -30.254105130616082, 0.00014137281029521863, 0.003574384319437096,
    -0.2522258923264631
};

/* B of (11), y; 3 */
SG_PRAGMA("DATA_ALIGN(two_stage_b_y, 8)")
static const sg_real two_stage_b_y[3] = {
    0.17912052779249438, 12.8825973381518, 325.71577110870527
};

#endif
