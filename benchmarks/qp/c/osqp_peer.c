/* OSQP's generated code, prefix "gen_". */
#include "osqp.h"
#include "gen_workspace.h"
#include "peer.h"

static double *linear, *lower, *upper;

int peer_setup(const problem *p, double *f, double *low, double *high)
{
    peer_load(p, f, low, high);
    return 0;
}

void peer_load(const problem *p, double *f, double *low, double *high)
{
    (void)p;
    linear = f;
    lower = low;
    upper = high;
}

__attribute__((noinline)) int solve_one(void)
{
    osqp_update_data_vec(&gen_solver, linear, lower, upper);
    osqp_solve(&gen_solver);
    return (gen_solver.info->status_val == OSQP_SOLVED) ? 0 : 1;
}

int peer_answer(const problem *p)
{
    for (int i = 0; i < p->n; i++) {
        answer[i] = gen_solver.solution->x[i];
    }
    return (int)gen_solver.info->iter;
}

/* all of it is static: read from the symbols of the linked program */
void peer_bytes(const problem *p, long *kept, long *written)
{
    *kept = 8 * (p->n + 2L * p->m);
    *written = 0;
}
