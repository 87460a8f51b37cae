/* SPDX-License-Identifier: MIT */
/*
 * Kernels that all servogen controllers share. Included by a package's own header of its scalar, after
 * sg_real (float or double), SG_REAL_MAX and SG_REAL_BITS are defined: each package has its own
 * precision.
 *
 * Comments that begin with an at sign speak to Frama-C Eva, the analyser that proves the absence of
 * run-time errors: `dynamic_split x` keeps the cases of x apart, `merge x` joins them again. They ask
 * for precision and state nothing.
 *
 * Matrices are stored transposed, column after column: the inner loop then runs over independent
 * rows, which a compiler can vectorise without changing the order of any sum. Sizes fit an int, also
 * one of 16 bits; a place in a matrix may not, so what it is computed from is an int32_t.
 */
#ifndef SG_KERNELS_H
#define SG_KERNELS_H

#include <stdint.h>

#include "sg_compiler.h"
#include "sg_status.h"

static inline sg_real sg_min(sg_real a, sg_real b)
{
    return (a < b) ? a : b;
}

static inline sg_real sg_max(sg_real a, sg_real b)
{
    return (a > b) ? a : b;
}

static inline sg_real sg_clamp(sg_real x, sg_real low, sg_real high)
{
    return sg_min(sg_max(x, low), high);
}

/* As sg_clamp, which makes `low` of a NaN too: here the proof sees that none is left. */
static inline sg_real sg_clamp_any(sg_real x, sg_real low, sg_real high)
{
    return (x == x) ? sg_clamp(x, low, high) : low;
}

/*
 * sg_bound, sg_bound_below and sg_bound_count keep what they are given in an interval that it does not
 * leave: they are for the proof, which looks at one number at a time and cannot see why. Each place says
 * why; `servogen check prove` also counts that none ever changes a number in the closed loop.
 */
static inline sg_real sg_bound(sg_real x, sg_real low, sg_real high)
{
    return sg_clamp(x, low, high);
}

static inline sg_real sg_bound_below(sg_real x, sg_real low)
{
    return sg_max(x, low);
}

static inline int32_t sg_bound_count(int32_t x, int32_t low, int32_t high)
{
    const int32_t raised = (x < low) ? low : x;
    return (raised > high) ? high : raised;
}

static inline sg_status sg_worse(sg_status a, sg_status b)
{
    return (a > b) ? a : b;
}

/* SG_NOT_FINITE, SG_OUT_OF_RANGE or SG_OK. Only a NaN differs from itself; it fails every other
 * comparison too, but that is the one from which the proof sees that none is left. */
static inline sg_status sg_check(sg_real x, sg_real low, sg_real high)
{
    sg_status status = SG_OK;
    /*@ dynamic_split status; */
    if (x < low) {
        status = SG_OUT_OF_RANGE;
    }
    if (x > high) {
        status = SG_OUT_OF_RANGE;
    }
    if (x < -SG_REAL_MAX) {
        status = SG_NOT_FINITE;
    }
    if (x > SG_REAL_MAX) {
        status = SG_NOT_FINITE;
    }
    if (!(x == x)) {
        status = SG_NOT_FINITE;
    }
    return status;
}

/* The worst of all elements; SG_NOT_FINITE goes before SG_OUT_OF_RANGE. */
static inline sg_status sg_check_array(int size, const sg_real *restrict x, sg_real low,
                                       sg_real high)
{
    sg_status finite = SG_OK;
    /*@ dynamic_split finite; */
    SG_PRAGMA("MUST_ITERATE(1)")
    for (int i = 0; i < size; i++) {
        const sg_status here = sg_check(x[i], low, high);
        if (finite == SG_OK) {
            finite = here;
        }
        if (here == SG_NOT_FINITE) {
            finite = here;
        }
    }
    /*@ merge finite; */
    return finite;
}

/*
 * The sum of squares, in four parts: no element's square is larger, and it is no number where an
 * element is none; the quick question before sg_check_array's.
 */
static inline sg_real sg_squares(int size, const sg_real *restrict x)
{
    const int rest = size % 4;
    sg_real s0 = (sg_real)0;
    sg_real s1 = (sg_real)0;
    sg_real s2 = (sg_real)0;
    sg_real s3 = (sg_real)0;
    for (int i = 0; i < (size - rest); i += 4) {
        s0 += x[i] * x[i];
        s1 += x[i + 1] * x[i + 1];
        s2 += x[i + 2] * x[i + 2];
        s3 += x[i + 3] * x[i + 3];
    }
    for (int i = size - rest; i < size; i++) {
        s0 += x[i] * x[i];
    }
    return (s0 + s1) + (s2 + s3);
}

static inline void sg_fill(int n, sg_real value, sg_real *x)
{
    SG_PRAGMA("MUST_ITERATE(1)")
    for (int i = 0; i < n; i++) {
        x[i] = value;
    }
}

static inline void sg_copy(int n, const sg_real *restrict from, sg_real *restrict to)
{
    SG_PRAGMA("MUST_ITERATE(1)")
    for (int i = 0; i < n; i++) {
        to[i] = from[i];
    }
}

/* The first `used` of at most `size` elements; the rest becomes zero and is not read. */
static inline void sg_copy_some(int size, int32_t used, const sg_real *restrict from,
                                sg_real *restrict to)
{
    SG_PRAGMA("MUST_ITERATE(1)")
    for (int i = 0; i < size; i++) {
        to[i] = (sg_real)0;
        if (i < used) {
            to[i] = from[i];
        }
    }
}

/* Drop x[0], append `last`. */
static inline void sg_shift(int n, sg_real *x, sg_real last)
{
    for (int i = 0; i < (n - 1); i++) {
        x[i] = x[i + 1];
    }
    x[n - 1] = last;
}

/*
 * y = M x; `columns` is M transposed, (cols, rows). Every y[i] is summed from the first column to the
 * last; four columns share one pass over y, which saves three of four loads and stores of it.
 */
static inline void sg_matvec(int rows, int cols, const sg_real *restrict columns,
                             const sg_real *restrict x, sg_real *restrict y)
{
    const int blocks = cols / 4;
    SG_PRAGMA("MUST_ITERATE(1)")
    for (int i = 0; i < rows; i++) {
        y[i] = (sg_real)0;
    }
    for (int block = 0; block < blocks; block++) {
        const int32_t j = 4 * (int32_t)block;
        const sg_real x0 = x[j];
        const sg_real x1 = x[j + 1];
        const sg_real x2 = x[j + 2];
        const sg_real x3 = x[j + 3];
        const sg_real *restrict c0 = &columns[j * rows];
        const sg_real *restrict c1 = &columns[(j + 1) * rows];
        const sg_real *restrict c2 = &columns[(j + 2) * rows];
        const sg_real *restrict c3 = &columns[(j + 3) * rows];
        SG_PRAGMA("MUST_ITERATE(1)")
        for (int i = 0; i < rows; i++) {
            y[i] = (((y[i] + (c0[i] * x0)) + (c1[i] * x1)) + (c2[i] * x2)) + (c3[i] * x3);
        }
    }
    for (int32_t j = 4 * (int32_t)blocks; j < cols; j++) {
        const sg_real factor = x[j];
        const sg_real *restrict column = &columns[j * rows];
        SG_PRAGMA("MUST_ITERATE(1)")
        for (int i = 0; i < rows; i++) {
            y[i] += column[i] * factor;
        }
    }
}

/* y += z */
static inline void sg_add(int n, const sg_real *restrict z, sg_real *restrict y)
{
    SG_PRAGMA("MUST_ITERATE(1)")
    for (int i = 0; i < n; i++) {
        y[i] += z[i];
    }
}

static inline sg_real sg_dot(int n, const sg_real *restrict x, const sg_real *restrict y)
{
    sg_real sum = x[0] * y[0];
    for (int i = 1; i < n; i++) {
        sum += x[i] * y[i];
    }
    return sum;
}

#endif
