/* SPDX-License-Identifier: MIT */
/*
 * Made by servogen 0.1.0 from eva.h.jinja; not to be edited.
 *
 * For Frama-C Eva, no part of a firmware: how drivers and contracts draw a number. SG_EVA_INPUTS chooses
 * what the inputs of a call are, each drawn anew:
 *   0: any value in its declared range;
 *   1: any finite value, any int32_t;
 *   2: any value at all, infinities and NaN too, any int32_t.
 */
#ifndef CENTRE_EVA_H
#define CENTRE_EVA_H

#include "centre_scalar.h"

#ifndef SG_EVA_INPUTS
#define SG_EVA_INPUTS 1
#endif

enum { SG_BEGUN = 20071 }; /* what the state of a part holds after its init */

/*@ assigns \result \from a, b;
    ensures \result == a || \result == b; */
extern int Frama_C_nondet(int a, int b);

/*@ requires low <= high;
    assigns \result \from low, high;
    ensures low <= \result <= high; */
extern int Frama_C_interval(int low, int high);

/*@ requires \is_finite(low) && \is_finite(high) && low <= high;
    assigns \result \from low, high;
    ensures \is_finite(\result) && low <= \result <= high; */
extern float Frama_C_float_interval(float low, float high);

/* What a part gives out. */
static inline sg_real sg_promise(sg_real low, sg_real high)
{
    return Frama_C_float_interval(low, high);
}

static inline int32_t sg_promise_count(int32_t low, int32_t high)
{
    return Frama_C_interval(low, high);
}

/* What comes in from outside. */
static inline sg_real sg_draw(sg_real low, sg_real high)
{
#if SG_EVA_INPUTS == 0
    return Frama_C_float_interval(low, high);
#elif SG_EVA_INPUTS == 1
    (void)low;
    (void)high;
    return Frama_C_float_interval(-SG_REAL_MAX, SG_REAL_MAX);
#else
    sg_real x = Frama_C_float_interval(-SG_REAL_MAX, SG_REAL_MAX);
    (void)low;
    (void)high;
    if (Frama_C_nondet(0, 1) == 1) {
        x = x / (sg_real)0;
    }
    return x;
#endif
}

static inline int32_t sg_draw_count(int32_t low, int32_t high)
{
#if SG_EVA_INPUTS == 0
    return Frama_C_interval(low, high);
#else
    (void)low;
    (void)high;
    return Frama_C_interval(-2147483647 - 1, 2147483647);
#endif
}

#endif
