/* SPDX-License-Identifier: MIT */
/* Made by servogen 0.1.0 from tables.h.jinja; not to be edited. Design 2df8fd9b7b96227c. */
/* Constant tables of two_stage_governor; included by two_stage_governor.c only. */
#ifndef TWO_STAGE_GOVERNOR_TABLES_H
#define TWO_STAGE_GOVERNOR_TABLES_H

/* share of every bound that may be used */
static const sg_real two_stage_governor_keep = 0.999998;
/* m: fast stage range, x */
static const sg_real two_stage_governor_range_x = 0.035;
/* m: path points, x */
static const sg_real two_stage_governor_limit_x = 0.4;
/* end position on r - p */
static const sg_real two_stage_governor_ahead_reference_x = 0.17912052779249438;
/* m: fast stage range, y */
static const sg_real two_stage_governor_range_y = 0.035;
/* m: path points, y */
static const sg_real two_stage_governor_limit_y = 0.4;
/* end position on r - p */
static const sg_real two_stage_governor_ahead_reference_y = 0.17912052779249438;

/* x: (13) on (v, a, ...), transposed; 2 x 5 */
SG_PRAGMA("DATA_ALIGN(two_stage_governor_rows_x, 8)")
static const sg_real two_stage_governor_rows_x[10] = {
    0.0, -0.0, 0.10519535679991598, -0.0928849868940457, 0.022297427332483827, 0.0, -0.0,
    0.000789260795719599, -0.0007743742081260305, 0.00024025345590549338
};

/* x: (13) on p; 5 */
SG_PRAGMA("DATA_ALIGN(two_stage_governor_shift_x, 8)")
static const sg_real two_stage_governor_shift_x[5] = {
    1.0, -0.0, 5.5828330360798715, 0.0, 1.6261577469313884
};

/* x: (13), right-hand side; 5 */
SG_PRAGMA("DATA_ALIGN(two_stage_governor_bound_x, 8)")
static const sg_real two_stage_governor_bound_x[5] = {
    0.396, 0.035, 2.2331332144319482, 0.04516207474365939, 0.6504630987725554
};

/* x: end position on (v, a, ...); 2 */
SG_PRAGMA("DATA_ALIGN(two_stage_governor_ahead_x, 8)")
static const sg_real two_stage_governor_ahead_x[2] = {
    0.018842647831320707, 0.00014137281029521863
};

/* y: (13) on (v, a, ...), transposed; 2 x 5 */
SG_PRAGMA("DATA_ALIGN(two_stage_governor_rows_y, 8)")
static const sg_real two_stage_governor_rows_y[10] = {
    0.0, -0.0, 0.10519535679991598, -0.0928849868940457, 0.022297427332483827, 0.0, -0.0,
    0.000789260795719599, -0.0007743742081260305, 0.00024025345590549338
};

/* y: (13) on p; 5 */
SG_PRAGMA("DATA_ALIGN(two_stage_governor_shift_y, 8)")
static const sg_real two_stage_governor_shift_y[5] = {
    1.0, -0.0, 5.5828330360798715, 0.0, 1.6261577469313884
};

/* y: (13), right-hand side; 5 */
SG_PRAGMA("DATA_ALIGN(two_stage_governor_bound_y, 8)")
static const sg_real two_stage_governor_bound_y[5] = {
    0.396, 0.035, 2.2331332144319482, 0.04516207474365939, 0.6504630987725554
};

/* y: end position on (v, a, ...); 2 */
SG_PRAGMA("DATA_ALIGN(two_stage_governor_ahead_y, 8)")
static const sg_real two_stage_governor_ahead_y[2] = {
    0.018842647831320707, 0.00014137281029521863
};

#endif
