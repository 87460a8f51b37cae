/* DAQP as it ships: warm from the working set of the last program. Simple bounds, if the first
   SIMPLE rows are the unit vectors, as such. What its setup asks of malloc is summed up. */
#include <stdlib.h>
#include <string.h>
#include "api.h"
#include "asked.h"
#include "peer.h"
#include "utils.h"

static DAQPWorkspace work;
static DAQPProblem qp;
static DAQPResult result;
static double dual[4096];
int peer_setup(const problem *p, double *f, double *low, double *high)
{
    int *sense = calloc((size_t)p->m, sizeof(int));
    memset(&qp, 0, sizeof qp);
    memset(&work, 0, sizeof work);
    qp.n = p->n;
    qp.m = p->m;
    qp.ms = SIMPLE;
    qp.H = p->hessian;
    qp.A = p->rows + SIMPLE * p->n;
    qp.f = f;
    qp.bupper = high;
    qp.blower = low;
    qp.sense = sense;
    result.x = answer;
    result.lam = dual;
    asked_counting = 1;
    allocate_daqp_settings(&work);
    work.settings->primal_tol = TOLERANCE;
    const int flag = setup_daqp(&qp, &work, NULL);
    asked_counting = 0;
    return (flag < 0) ? 1 : 0;
}

void peer_load(const problem *p, double *f, double *low, double *high)
{
    (void)p;
    qp.f = f;
    qp.bupper = high;
    qp.blower = low;
}

__attribute__((noinline)) int solve_one(void)
{
    daqp_update_ldp(DAQP_UPDATE_v | DAQP_UPDATE_d, &work, &qp);
    daqp_solve(&result, &work);
    return (result.exitflag == 1) ? 0 : 1;
}

int peer_answer(const problem *p)
{
    (void)p;
    return result.iter;
}

void peer_bytes(const problem *p, long *kept, long *written)
{
    const long n = p->n, m = p->m;
    /* H, A, f, both bounds and sense, which its DAQPProblem points to */
    *kept = 8 * (n * n + (m - SIMPLE) * n + n + 2 * m) + 4 * m;
    *written = asked_bytes + (long)(sizeof work + sizeof qp);
}
