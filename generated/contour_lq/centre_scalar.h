/* SPDX-License-Identifier: MIT */
/* Made by servogen 0.1.0 from scalar.h.jinja; not to be edited. Design 57e8c839fdacd111. */
/* The scalar of the kernels, and the kernels: for the sources of centre only. */
#ifndef CENTRE_SCALAR_H
#define CENTRE_SCALAR_H

#include "centre_types.h"

typedef centre_real sg_real;
#define SG_REAL_MAX 3.40282347e+38f
#define SG_REAL_BITS 32

#include "sg_kernels.h"

#endif
