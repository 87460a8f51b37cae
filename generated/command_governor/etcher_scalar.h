/* SPDX-License-Identifier: MIT */
/* Made by servogen 0.1.0 from scalar.h.jinja; not to be edited. Design db73e1a8671115da. */
/* The scalar of the kernels, and the kernels: for the sources of etcher only. */
#ifndef ETCHER_SCALAR_H
#define ETCHER_SCALAR_H

#include "etcher_types.h"

typedef etcher_real sg_real;
#define SG_REAL_MAX 1.7976931348623157e+308
#define SG_REAL_BITS 64

#include "sg_kernels.h"

#endif
