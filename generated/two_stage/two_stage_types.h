/* SPDX-License-Identifier: MIT */
/* Made by servogen 0.1.0 from types.h.jinja; not to be edited. Design 2df8fd9b7b96227c. */
#ifndef TWO_STAGE_TYPES_H
#define TWO_STAGE_TYPES_H

#include <stdint.h>

#include "sg_status.h"

#ifndef TWO_STAGE_REAL
#define TWO_STAGE_REAL double
#endif

typedef TWO_STAGE_REAL two_stage_real;

#endif
