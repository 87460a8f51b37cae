/* SPDX-License-Identifier: MIT */
/* Made by servogen 0.1.0 from types.h.jinja; not to be edited. Design 194d8956393bab30. */
#ifndef HEADSTOCK_TYPES_H
#define HEADSTOCK_TYPES_H

#include <stdint.h>

#include "sg_status.h"

#ifndef HEADSTOCK_REAL
#define HEADSTOCK_REAL float
#endif

typedef HEADSTOCK_REAL headstock_real;

#endif
