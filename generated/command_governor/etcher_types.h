/* SPDX-License-Identifier: MIT */
/* Made by servogen 0.1.0 from types.h.jinja; not to be edited. Design db73e1a8671115da. */
#ifndef ETCHER_TYPES_H
#define ETCHER_TYPES_H

#include <stdint.h>

#include "sg_status.h"

#ifndef ETCHER_REAL
#define ETCHER_REAL double
#endif

typedef ETCHER_REAL etcher_real;

#endif
