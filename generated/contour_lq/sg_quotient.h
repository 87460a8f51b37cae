/* SPDX-License-Identifier: MIT */
/* With SG_OWN_DIVISION, for a processor that has neither a division nor a library of one. */
#ifndef SG_QUOTIENT_H
#define SG_QUOTIENT_H

#if defined(SG_OWN_DIVISION)
#include "sg_division.h"
#define SG_DIVIDE(a, b) sg_divide((a), (b))
#else
#define SG_DIVIDE(a, b) ((a) / (b))
#endif

#endif
