/* SPDX-License-Identifier: MIT */
/* Made by servogen 0.1.0 from scalar.h.jinja; not to be edited. Design 194d8956393bab30. */
/* The scalar of the kernels, and the kernels: for the sources of headstock only. */
#ifndef HEADSTOCK_SCALAR_H
#define HEADSTOCK_SCALAR_H

#include "headstock_types.h"

typedef headstock_real sg_real;
#define SG_REAL_MAX 3.40282347e+38f

#include "sg_kernels.h"

#endif
