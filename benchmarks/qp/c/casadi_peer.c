/* CasADi's generated code: solve_qp(f, low, high, z of the last program, H, A) -> z, its solver qrqp. */
#include <stdlib.h>
#include <string.h>
#include "generated.h"
#include "peer.h"

static const double *given[64];
static double *made[64];
static casadi_int *whole;
static double *work, last[4096], rows_by_column[1 << 20];
static casadi_int sizes[4];

int peer_setup(const problem *p, double *f, double *low, double *high)
{
    for (int i = 0; i < p->m; i++) {
        for (int j = 0; j < p->n; j++) {
            rows_by_column[j * p->m + i] = p->rows[i * p->n + j];
        }
    }
    solve_qp_work(&sizes[0], &sizes[1], &sizes[2], &sizes[3]);
    whole = calloc((size_t)sizes[2] + 1, sizeof(casadi_int));
    work = calloc((size_t)sizes[3] + 1, sizeof(double));
    peer_load(p, f, low, high);
    given[3] = last;
    given[4] = p->hessian;
    given[5] = rows_by_column;
    made[0] = answer;
    return (sizes[0] > 64 || sizes[1] > 64) ? 1 : 0;
}

void peer_load(const problem *p, double *f, double *low, double *high)
{
    memcpy(last, answer, sizeof(double) * (size_t)p->n);
    given[0] = f;
    given[1] = low;
    given[2] = high;
}

__attribute__((noinline)) int solve_one(void)
{
    return solve_qp(given, made, whole, work, 0);
}

int peer_answer(const problem *p)
{
    (void)p;
    return -1;
}

void peer_bytes(const problem *p, long *kept, long *written)
{
    *kept = 8 * ((long)p->n * p->n + (long)p->m * p->n + 2L * p->n + 2L * p->m);
    *written = (long)(sizes[2] * (long)sizeof(casadi_int) + sizes[3] * (long)sizeof(double));
}
