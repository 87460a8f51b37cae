/* SPDX-License-Identifier: MIT */
/*
 * The taut string through a tube, a funnel: lower[k] <= x[k] <= upper[k] for k = 0, 1, ..., from `start`
 * one point before the first. Its reference is servogen/paths/taut_string.py; after sg_real.
 *
 * Two chains lead from the apex, up to where the string is known, to the points that were looked at
 * last: the upper one is the greatest convex line below the upper bounds, the lower one the least
 * concave line above the lower bounds. Where a new bound crosses the other chain the apex moves on. A
 * point enters each chain once and leaves it once, so sg_taut_turn is called at most four times for
 * each point.
 *
 * Slopes are compared by multiplying crosswise: places are whole numbers, so a comparison is wrong only
 * where the slopes agree but for rounding, and costs no division.
 */
#ifndef SG_TAUT_H
#define SG_TAUT_H

#include <stdint.h>

#include "sg_kernels.h"
#include "sg_quotient.h"

/* Elements head to tail - 1 of an array of places: a chain without the apex. */
typedef struct {
    int32_t head;
    int32_t tail;
} sg_chain;

typedef struct {
    int32_t point; /* looked at next */
    int32_t side;  /* 0: its upper bound, 1: its lower */
    int32_t apex;  /* the string is known up to here; -1: the start */
    sg_real height;
    sg_chain upper;
    sg_chain lower;
} sg_taut;

static inline void sg_taut_begin(sg_real start, sg_taut *s)
{
    s->point = 0;
    s->side = 0;
    s->apex = -1;
    s->height = start;
    s->upper.head = 0;
    s->upper.tail = 0;
    s->lower.head = 0;
    s->lower.tail = 0;
}

/*
 * One change for the bound `own[point]`: the last of its own chain leaves, the apex moves along the
 * chain `across`, or, with 1 returned, the bound enters its chain and is done with. `sign` is 1 for an
 * upper bound, -1 for a lower.
 */
static inline int32_t sg_taut_change(sg_real sign, const sg_real *own, const sg_real *other,
                                     int32_t *places, const int32_t *places_across, sg_chain *chain,
                                     sg_chain *across, sg_taut *s)
{
    const sg_real value = own[s->point];
    int32_t entered = 1;
    if (chain->head < chain->tail) {
        const int32_t last = places[chain->tail - 1];
        int32_t base = s->apex;
        sg_real from = s->height;
        if ((chain->tail - chain->head) > 1) {
            base = places[chain->tail - 2];
            from = own[base];
        }
        const sg_real to_last = (own[last] - from) * (sg_real)(s->point - base);
        const sg_real to_here = (value - from) * (sg_real)(last - base);
        if ((sign * to_last) >= (sign * to_here)) {
            chain->tail -= 1;
            entered = 0;
        }
    } else if (across->head < across->tail) {
        const int32_t next = places_across[across->head];
        const sg_real to_next = (other[next] - s->height) * (sg_real)(s->point - s->apex);
        const sg_real to_here = (value - s->height) * (sg_real)(next - s->apex);
        if ((sign * to_next) > (sign * to_here)) {
            s->apex = next;
            s->height = other[next];
            across->head += 1;
            entered = 0;
        }
    } else {
        /* the first point */
    }
    if (entered == 1) {
        places[chain->tail] = s->point;
        chain->tail += 1;
    }
    return entered;
}

/* One change; returns 1 where the apex has moved. `high` and `low` have room for every place. */
static inline int32_t sg_taut_turn(const sg_real *lower, const sg_real *upper, int32_t *low,
                                   int32_t *high, sg_taut *s)
{
    const int32_t before = s->apex;
    if (s->side == 0) {
        s->side = sg_taut_change((sg_real)1, upper, lower, high, low, &s->upper, &s->lower, s);
    } else {
        const int32_t entered =
            sg_taut_change((sg_real)-1, lower, upper, low, high, &s->lower, &s->upper, s);
        s->side = 1 - entered;
        s->point += entered;
    }
    return (s->apex > before) ? 1 : 0;
}

/* Whether a chain leads from the apex away: down for the upper (`sign` 1), up for the lower (-1). */
static inline int32_t sg_taut_leads(sg_real sign, const sg_real *own, const int32_t *places,
                                    const sg_chain *chain, sg_real height)
{
    int32_t leads = 0;
    if (chain->head < chain->tail) {
        leads = ((sign * own[places[chain->head]]) < (sign * height)) ? 1 : 0;
    }
    return leads;
}

/* Where the bounds end the string ends level: which chain it follows until then, 0 if none. */
static inline int32_t sg_taut_way(const sg_real *lower, const sg_real *upper, const int32_t *low,
                                  const int32_t *high, const sg_taut *s)
{
    int32_t way = 0;
    if (sg_taut_leads((sg_real)1, upper, high, &s->upper, s->height) == 1) {
        way = 1;
    } else if (sg_taut_leads((sg_real)-1, lower, low, &s->lower, s->height) == 1) {
        way = -1;
    } else {
        /* level from here on */
    }
    return way;
}

/* The apex moves along that chain, or, where it turns back, level to the last point. */
static inline void sg_taut_close(int32_t way, int32_t last, const sg_real *lower,
                                 const sg_real *upper, const int32_t *low, const int32_t *high,
                                 sg_taut *s)
{
    if ((way == 1) && (sg_taut_leads((sg_real)1, upper, high, &s->upper, s->height) == 1)) {
        s->apex = high[s->upper.head];
        s->height = upper[s->apex];
        s->upper.head += 1;
    } else if ((way == -1) && (sg_taut_leads((sg_real)-1, lower, low, &s->lower, s->height) == 1)) {
        s->apex = low[s->lower.head];
        s->height = lower[s->apex];
        s->lower.head += 1;
    } else {
        s->apex = last;
    }
}

/* Rise per point between two knots. */
static inline sg_real sg_taut_slope(int32_t from, sg_real begin, int32_t to, sg_real end)
{
    return SG_DIVIDE(end - begin, (sg_real)(to - from));
}

/* The string between two knots, exactly the second's height at its place, never beyond the tube. */
static inline sg_real sg_taut_at(int32_t i, int32_t from, sg_real begin, int32_t to, sg_real end,
                                 sg_real slope, sg_real lower, sg_real upper)
{
    const sg_real between = begin + (slope * (sg_real)(i - from));
    return sg_clamp((i == to) ? end : between, lower, upper);
}

#endif
