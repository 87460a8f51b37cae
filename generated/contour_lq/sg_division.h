/* SPDX-License-Identifier: MIT */
/*
 * a / b, rounded to nearest even as IEEE 754 says, from integer operations alone. The C6000 has no
 * division: its library's is a call, and the reciprocal that a compiler puts in its place is other
 * bits. One bit of the quotient per turn, so it is slow; what it gives is exact by construction.
 *
 * Shifts are by one or by a constant: any other of 64 bits is a library call on that processor.
 */
#ifndef SG_DIVISION_H
#define SG_DIVISION_H

#include <stdint.h>

typedef union {
    sg_real real;
    uint32_t narrow;
    uint64_t wide;
} sg_image;

/* A number apart: fraction * 2^(exponent - bias - bits), with its leading one at bit `bits`. */
typedef struct {
    uint64_t fraction;
    int32_t exponent;
    int32_t is_nan;
    int32_t is_infinite;
    int32_t is_zero;
} sg_parts;

/* sizeof would tell how many char, and a char may have 16 bits. */
enum {
    SG_BITS = (SG_REAL_BITS == 64) ? 52 : 23,       /* of the fraction */
    SG_TOP = (SG_REAL_BITS == 64) ? 0x7FF : 0xFF,   /* exponent of infinity and NaN */
    SG_SPARE = (SG_REAL_BITS == 64) ? 0 : 1         /* the image is the narrow one */
};

#define SG_SHIFT ((uint32_t)SG_BITS)
#define SG_ONE ((uint64_t)1 << SG_SHIFT)
#define SG_SIGN ((uint64_t)1 << ((SG_SPARE == 1) ? 31u : 63u))
#define SG_INFINITE ((uint64_t)SG_TOP << SG_SHIFT)

static inline uint64_t sg_to_image(sg_real x)
{
    sg_image image;
    image.wide = 0u;
    image.real = x;
    return (SG_SPARE == 1) ? (uint64_t)image.narrow : image.wide;
}

static inline sg_real sg_from_image(uint64_t bits)
{
    sg_image image;
    image.wide = bits;
    if (SG_SPARE == 1) {
        image.narrow = (uint32_t)bits;
    }
    return image.real;
}

static inline sg_parts sg_take_apart(uint64_t magnitude)
{
    sg_parts parts;
    const uint64_t exponent = magnitude >> SG_SHIFT;
    parts.fraction = magnitude & (SG_ONE - 1u);
    parts.exponent = (int32_t)exponent;
    parts.is_nan = (magnitude > SG_INFINITE) ? 1 : 0;
    parts.is_infinite = (magnitude == SG_INFINITE) ? 1 : 0;
    parts.is_zero = (magnitude == 0u) ? 1 : 0;
    if (parts.exponent != 0) {
        parts.fraction += SG_ONE;
    } else { /* below the normal numbers */
        parts.exponent = 1;
        for (int i = 0; i < SG_BITS; i++) {
            if (parts.fraction < SG_ONE) {
                parts.fraction += parts.fraction;
                parts.exponent -= 1;
            }
        }
    }
    return parts;
}

/* Image of the quotient of two numbers that are neither zero nor infinite. */
static inline uint64_t sg_quotient(const sg_parts *a, const sg_parts *b)
{
    int32_t exponent = (a->exponent - b->exponent) + (SG_TOP / 2);
    uint64_t rest = a->fraction;
    uint64_t quotient = 0u;
    uint64_t lost = 0u;
    uint64_t image = SG_INFINITE;
    if (rest < b->fraction) {
        rest += rest;
        exponent -= 1;
    }
    for (int i = 0; i < (SG_BITS + 2); i++) { /* leading one, fraction, one bit to round by */
        quotient += quotient;
        if (rest >= b->fraction) {
            rest -= b->fraction;
            quotient += 1u;
        }
        rest += rest;
    }
    lost = (rest != 0u) ? 1u : 0u;
    for (int i = 0; i < (SG_BITS + 2); i++) {
        if (i < (1 - exponent)) { /* below the normal numbers: fewer bits */
            lost |= quotient & 1u;
            quotient >>= 1;
        }
    }
    if (exponent < SG_TOP) {
        const int32_t less = (exponent > 0) ? (exponent - 1) : 0;
        const uint64_t field = (uint64_t)less;
        const uint64_t half = quotient & 1u;
        image = quotient >> 1;
        lost |= image & 1u; /* halfway: to the even one */
        image += field << SG_SHIFT; /* the leading one adds one more to the exponent */
        image += half & lost;
    }
    return image;
}

static inline sg_real sg_divide(sg_real numerator, sg_real denominator)
{
    const uint64_t over = sg_to_image(numerator);
    const uint64_t under = sg_to_image(denominator);
    const uint64_t sign = (over ^ under) & SG_SIGN;
    const sg_parts a = sg_take_apart(over & (SG_SIGN - 1u));
    const sg_parts b = sg_take_apart(under & (SG_SIGN - 1u));
    const int32_t to_zero = ((a.is_zero + b.is_infinite) > 0) ? 1 : 0;
    const int32_t to_infinity = ((a.is_infinite + b.is_zero) > 0) ? 1 : 0;
    uint64_t image = SG_INFINITE + (SG_ONE >> 1); /* a quiet NaN: 0 / 0, infinity / infinity */
    if ((a.is_nan + b.is_nan) == 0) {
        if ((to_zero + to_infinity) == 0) {
            image = sg_quotient(&a, &b);
        } else if (to_infinity == 0) {
            image = 0u;
        } else {
            image = (to_zero == 0) ? SG_INFINITE : image;
        }
    }
    return sg_from_image(image | sign);
}

#endif
