/* What the harness asks of a solver of min 1/2 z'Hz + f'z, low <= A z <= high. */
#ifndef PEER_H
#define PEER_H

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    int n;            /* variables */
    int m;            /* two-sided rows */
    double *hessian;  /* n by n */
    double *rows;     /* m by n, by rows */
} problem;

extern double answer[];

/* Before the first program; returns 0 if it went well. */
int peer_setup(const problem *p, double *f, double *low, double *high);
/* The program of the next call, where the caller's own buffers have to be filled; not counted. */
void peer_load(const problem *p, double *f, double *low, double *high);
/* All that a sample costs; counted. Returns 0 if the solver says it is solved. */
int solve_one(void);
/* answer[] = z; not counted. Returns iterations, -1 if not told. */
int peer_answer(const problem *p);
/* Bytes: of tables and problem data that stay, and of what the solver writes to. */
void peer_bytes(const problem *p, long *kept, long *written);

#ifdef __cplusplus
}
#endif

#endif
