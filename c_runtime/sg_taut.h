/* SPDX-License-Identifier: MIT */
/*
 * The taut string through a tube, a funnel: lower[k] <= x[k] <= upper[k] for k = 0, 1, ..., from `start`
 * one point before the first. Its reference is servogen/paths/taut_string.py; after sg_real.
 *
 * Two chains lead from the apex, up to where the string is known, to the points that were looked at
 * last: the upper one is the greatest convex line below the upper bounds, the lower one the least
 * concave line above the lower bounds. Where a new bound crosses the other chain the apex moves on. A
 * point enters each chain once and leaves it once, so sg_taut_turn is called at most four times for
 * each point, and no chain holds more than all of them.
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

/* An element of a chain. Places are those of points, and a chain has no more elements than there are
 * points: see above. */
static inline int32_t sg_taut_place(int32_t size, const int32_t *places, int32_t at)
{
    return sg_bound_count(places[sg_bound_count(at, 0, size - 1)], 0, size - 1);
}

/* Rise between two heights times the run from `begin` to `end`: what slopes are compared by. */
static inline sg_real sg_taut_cross(sg_real from, sg_real to, int32_t begin, int32_t end)
{
    const int32_t run = end - begin;
    return (to - from) * (sg_real)run;
}

/*
 * One change for the bound `own[point]`: the last of its own chain leaves, the apex moves along the
 * chain `across`, or, with 1 returned, the bound enters its chain and is done with. `sign` is 1 for an
 * upper bound, -1 for a lower.
 */
static inline int32_t sg_taut_change(int32_t size, int32_t point, sg_real sign, const sg_real *own,
                                     const sg_real *other, int32_t *places,
                                     const int32_t *places_across, sg_chain *chain,
                                     sg_chain *across, sg_taut *s)
{
    const sg_real value = own[point];
    int32_t entered = 1;
    if (chain->head < chain->tail) {
        const int32_t last = sg_taut_place(size, places, chain->tail - 1);
        int32_t base = s->apex;
        sg_real from = s->height;
        if ((chain->tail - chain->head) > 1) {
            base = sg_taut_place(size, places, chain->tail - 2);
            from = own[base];
        }
        const sg_real to_last = sg_taut_cross(from, own[last], base, point);
        const sg_real to_here = sg_taut_cross(from, value, base, last);
        if ((sign * to_last) >= (sign * to_here)) {
            chain->tail -= 1;
            entered = 0;
        }
    } else if (across->head < across->tail) {
        const int32_t next = sg_taut_place(size, places_across, across->head);
        const sg_real to_next = sg_taut_cross(s->height, other[next], s->apex, point);
        const sg_real to_here = sg_taut_cross(s->height, value, s->apex, next);
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
        const int32_t end = sg_bound_count(chain->tail, 0, size - 1);
        places[end] = point;
        chain->tail = end + 1;
    }
    return entered;
}

/* One change, while there are points left to look at; returns 1 where the apex has moved. `high` and
 * `low` have room for every place. */
static inline int32_t sg_taut_turn(int32_t size, const sg_real *lower, const sg_real *upper,
                                   int32_t *low, int32_t *high, sg_taut *s)
{
    const int32_t before = s->apex;
    const int32_t point = sg_bound_count(s->point, 0, size - 1); /* as there are points left */
    if (s->side == 0) {
        s->side = sg_taut_change(size, point, (sg_real)1, upper, lower, high, low, &s->upper,
                                 &s->lower, s);
    } else {
        const int32_t entered = sg_taut_change(size, point, (sg_real)-1, lower, upper, low, high,
                                               &s->lower, &s->upper, s);
        s->side = 1 - entered;
        s->point = point + entered;
    }
    return (s->apex > before) ? 1 : 0;
}

/* Whether a chain leads from the apex away: down for the upper (`sign` 1), up for the lower (-1). */
static inline int32_t sg_taut_leads(int32_t size, sg_real sign, const sg_real *own,
                                    const int32_t *places, const sg_chain *chain, sg_real height)
{
    int32_t leads = 0;
    if (chain->head < chain->tail) {
        const sg_real next = own[sg_taut_place(size, places, chain->head)];
        leads = ((sign * next) < (sign * height)) ? 1 : 0;
    }
    return leads;
}

/* Where the bounds end the string ends level: which chain it follows until then, 0 if none. */
static inline int32_t sg_taut_way(int32_t size, const sg_real *lower, const sg_real *upper,
                                  const int32_t *low, const int32_t *high, const sg_taut *s)
{
    int32_t way = 0;
    if (sg_taut_leads(size, (sg_real)1, upper, high, &s->upper, s->height) == 1) {
        way = 1;
    } else if (sg_taut_leads(size, (sg_real)-1, lower, low, &s->lower, s->height) == 1) {
        way = -1;
    } else {
        /* level from here on */
    }
    return way;
}

/* The apex moves along a chain; returns 0 where that does not lead away any more. */
static inline int32_t sg_taut_along(int32_t size, sg_real sign, const sg_real *own,
                                    const int32_t *places, sg_chain *chain, sg_taut *s)
{
    const int32_t leads = sg_taut_leads(size, sign, own, places, chain, s->height);
    if (leads == 1) {
        const int32_t head = sg_bound_count(chain->head, 0, size - 1);
        s->apex = sg_taut_place(size, places, head);
        s->height = own[s->apex];
        chain->head = head + 1;
    }
    return leads;
}

/* The apex moves along the chain of that way, or, where it turns back, level to the last point. */
static inline void sg_taut_close(int32_t size, int32_t way, int32_t last, const sg_real *lower,
                                 const sg_real *upper, const int32_t *low, const int32_t *high,
                                 sg_taut *s)
{
    int32_t moved = 0;
    if (way == 1) {
        moved = sg_taut_along(size, (sg_real)1, upper, high, &s->upper, s);
    }
    if (way == -1) {
        moved = sg_taut_along(size, (sg_real)-1, lower, low, &s->lower, s);
    }
    if (moved == 0) {
        s->apex = last;
    }
}

/* Rise per point between two knots, the second after the first. */
static inline sg_real sg_taut_slope(int32_t size, int32_t from, sg_real begin, int32_t to,
                                    sg_real end)
{
    const int32_t run = sg_bound_count(to - from, 1, size);
    const sg_real rise = end - begin;
    return SG_DIVIDE(rise, (sg_real)run);
}

/* The string between two knots, exactly the second's height at its place, never beyond the tube. */
static inline sg_real sg_taut_at(int32_t i, int32_t from, sg_real begin, int32_t to, sg_real end,
                                 sg_real slope, sg_real lower, sg_real upper)
{
    const int32_t run = i - from;
    const sg_real between = begin + (slope * (sg_real)run);
    return sg_clamp((i == to) ? end : between, lower, upper);
}

#endif
