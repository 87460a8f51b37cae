/* SPDX-License-Identifier: MIT */
/* Status codes of every servogen step. Larger is worse: a caller may keep the maximum. */
#ifndef SG_STATUS_H
#define SG_STATUS_H

typedef enum {
    SG_OK = 0,
    SG_PRIMING = 1,      /* the horizon is being filled; the machine stands */
    SG_FINISHED = 2,     /* the whole path is processed */
    SG_SUBOPTIMAL = 3,   /* iteration cap reached, a feasible plan short of the optimum is used */
    SG_BACKUP = 4,       /* iteration cap reached, it is not; the shifted plan is used */
    SG_INFEASIBLE = 5,   /* not even the shifted plan is feasible; it is held all the same */
    SG_NOT_FINITE = 6,   /* an input is NaN or infinite; the plan goes on without it */
    SG_OUT_OF_RANGE = 7, /* an input is outside its declared range; likewise */
    SG_OVERFLOW = 8,     /* no room for another interval; nothing was taken */
    SG_NOT_READY = 9,    /* called before a successful reset */
    SG_UNREACHABLE = 10  /* the path cannot be followed: the machine stands until it is given another */
} sg_status;

#endif
