/* SPDX-License-Identifier: MIT */
/* Made by servogen 0.1.0 from tables.h.jinja; not to be edited. Design db73e1a8671115da. */
/* Constant tables of etcher; included by etcher.c only. */
#ifndef ETCHER_TABLES_H
#define ETCHER_TABLES_H

/* m: fast range used, x */
static const sg_real etcher_stroke_x = 0.025;
/* m: fast range used, y */
static const sg_real etcher_stroke_y = 0.025;
/* m: of points */
static const sg_real etcher_limit_x = 0.375;
/* m: of points */
static const sg_real etcher_limit_y = 0.375;
/* m: middle of the range of x */
static const sg_real etcher_centre_x = 0.125;
/* m: middle of the range of y */
static const sg_real etcher_centre_y = 0.125;

#endif
