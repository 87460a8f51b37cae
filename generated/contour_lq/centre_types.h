/* SPDX-License-Identifier: MIT */
/* Made by servogen 0.1.0 from types.h.jinja; not to be edited. Design 57e8c839fdacd111. */
#ifndef CENTRE_TYPES_H
#define CENTRE_TYPES_H

#include <stdint.h>

#include "sg_status.h"

#ifndef CENTRE_REAL
#define CENTRE_REAL float
#endif

typedef CENTRE_REAL centre_real;

#endif
