/* qpOASES as CasADi's library brings it, through CasADi's C interface: a function "solver" (of
   ca.conic) in the file solver.casadi. Warm from its last working set, the first time from that of
   the same program. */
#include <stdlib.h>
#include "casadi/casadi_c.h"
#include "peer.h"

/* h, g, a, lba, uba are the first inputs of a conic solver; z its first output */
enum { H, G, A, LBA, UBA, FIRST };

static const double *given[64];
static double *made[64], *work;
static casadi_int *whole, sizes[4];
static int id, memory;

int peer_setup(const problem *p, double *f, double *low, double *high)
{
    if (casadi_c_push_file("solver.casadi") != 0) {
        return 1;
    }
    id = casadi_c_id("solver");
    if (id < 0 || casadi_c_work_id(id, &sizes[0], &sizes[1], &sizes[2], &sizes[3]) != 0
        || sizes[0] > 64 || sizes[1] > 64) {
        return 2;
    }
    whole = calloc((size_t)sizes[2] + 1, sizeof(casadi_int));
    work = calloc((size_t)sizes[3] + 1, sizeof(double));
    const casadi_int *sparsity = casadi_c_sparsity_in_id(id, A);
    const casadi_int *column = sparsity + 2, *row = sparsity + 3 + p->n;
    double *entries = calloc((size_t)(p->n * p->m), sizeof(double));
    if (column[0] == 1) {  /* dense */
        for (int k = 0; k < p->n * p->m; k++) {
            entries[k] = p->rows[(k % p->m) * p->n + k / p->m];
        }
    } else {
        for (int j = 0; j < p->n; j++) {
            for (casadi_int k = column[j]; k < column[j + 1]; k++) {
                entries[k] = p->rows[row[k] * p->n + j];
            }
        }
    }
    given[H] = p->hessian;
    given[A] = entries;
    made[0] = answer;
    /* bounds of z by their defaults, none; without start */
    double *none = calloc((size_t)(2 * p->n), sizeof(double));
    for (int j = 0; j < p->n; j++) {
        none[j] = casadi_c_default_in_id(id, FIRST);
        none[p->n + j] = casadi_c_default_in_id(id, FIRST + 1);
    }
    given[FIRST] = none;
    given[FIRST + 1] = none + p->n;
    peer_load(p, f, low, high);
    memory = casadi_c_checkout_id(id);
    /* what it does once: others do that in their setup */
    return casadi_c_eval_id(id, given, made, whole, work, memory);
}

void peer_load(const problem *p, double *f, double *low, double *high)
{
    (void)p;
    given[G] = f;
    given[LBA] = low;
    given[UBA] = high;
}

__attribute__((noinline)) int solve_one(void)
{
    return casadi_c_eval_id(id, given, made, whole, work, memory);
}

int peer_answer(const problem *p)
{
    (void)p;
    return -1;
}

/* what the library allocates is not told */
void peer_bytes(const problem *p, long *kept, long *written)
{
    (void)p;
    *kept = -1;
    *written = -1;
}
