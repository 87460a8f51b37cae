/* SPDX-License-Identifier: MIT */
/* The minimal motion of a whole path, for the host: compiled by servogen/paths/taut_compiled.py. */
#include <stdint.h>

typedef double sg_real;
#define SG_REAL_MAX 1.7976931348623157e+308
#define SG_REAL_BITS 64

#include "../sg_taut.h"

/* The points after `from` up to the apex, x of them. */
static void fill(int32_t n, int32_t from, double begin, const sg_taut *s, const double *lower,
                 const double *upper, double *x)
{
    const int32_t to = s->apex;
    const double slope = sg_taut_slope(n, from, begin, to, s->height);
    for (int32_t i = from + 1; i <= to; i++) {
        x[i] = sg_taut_at(i, from, begin, to, s->height, slope, lower[i], upper[i]);
    }
}

/*
 * x of n points from `start` one point before the first; `low` and `high` are workspace of n each.
 * Returns how many points ahead had to be seen for the point that needed most.
 */
int32_t sg_minimal_motion(int32_t n, const double *lower, const double *upper, double start,
                          int32_t *low, int32_t *high, double *x)
{
    sg_taut s;
    int32_t ahead = 0;
    int32_t from = -1;
    double begin = start;
    sg_taut_begin(start, &s);
    while (s.point < n) {
        const int32_t seen = s.point;
        if (sg_taut_turn(n, lower, upper, low, high, &s) == 1) {
            fill(n, from, begin, &s, lower, upper, x);
            ahead = ((seen - (from + 1)) > ahead) ? (seen - (from + 1)) : ahead;
            from = s.apex;
            begin = s.height;
        }
    }
    ahead = ((n - 2 - from) > ahead) ? (n - 2 - from) : ahead;
    const int32_t way = sg_taut_way(n, lower, upper, low, high, &s);
    while (from < (n - 1)) {
        sg_taut_close(n, way, n - 1, lower, upper, low, high, &s);
        fill(n, from, begin, &s, lower, upper, x);
        from = s.apex;
        begin = s.height;
    }
    return ahead;
}
