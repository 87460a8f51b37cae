/* SPDX-License-Identifier: MIT */
/* Made by servogen 0.1.0 from types.h.jinja; not to be edited. Design efe801d2719c8dc7. */
#ifndef HEADSTOCK_TYPES_H
#define HEADSTOCK_TYPES_H

#include <stdint.h>

#include "sg_status.h"

#ifndef HEADSTOCK_REAL
#define HEADSTOCK_REAL float
#endif

typedef HEADSTOCK_REAL headstock_real;

#endif
