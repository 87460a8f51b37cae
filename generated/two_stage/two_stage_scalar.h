/* SPDX-License-Identifier: MIT */
/* Made by servogen 0.1.0 from scalar.h.jinja; not to be edited. Design 2df8fd9b7b96227c. */
/* The scalar of the kernels, and the kernels: for the sources of two_stage only. */
#ifndef TWO_STAGE_SCALAR_H
#define TWO_STAGE_SCALAR_H

#include "two_stage_types.h"

typedef two_stage_real sg_real;
#define SG_REAL_MAX 1.7976931348623157e+308
#define SG_REAL_BITS 64

#include "sg_kernels.h"

#endif
