/* SPDX-License-Identifier: MIT */
/* Made by servogen 0.1.0 from tables.h.jinja; not to be edited. Design f9fdffe8777881aa. */
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

#endif
