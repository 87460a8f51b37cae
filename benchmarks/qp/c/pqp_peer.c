/* servogen's PQP on any program: its turns (sg_pqp.h) in the order of the emitted MPC, on tables of the
   same kind; the MPC's own f and bounds, made of states and references, are given here instead. */
#include "peer.h"
typedef double sg_real;
#define SG_REAL_MAX 1.7976931348623157e+308
#include "sg_kernels.h"
#include "sg_pqp.h"
#include "pqp_tables.h"

static sg_real upper[ROWS], lower[ROWS], slack_upper[ROWS], slack_lower[ROWS], scratch[ROWS];
static sg_real change[ROWS], absolute_sum[STRIDE], last_upper[ROWS], last_lower[ROWS];
static sg_real shared[LINES];
static sg_real last_change[ROWS], rows[ROWS], free_plan[PLAN], correction[PLAN];
static const double *linear, *below, *above;
static int iterations;

static void cold(void)
{
    sg_copy(ROWS, floor_, upper);
    sg_copy(ROWS, floor_, lower);
}

static void shift(sg_real *y)
{
    for (int i = 0; i < ROWS - STAYING - PER_STEP; i++) {
        y[i] = y[i + PER_STEP];
    }
    for (int i = 0; i < ROWS; i++) {
        y[i] = sg_max(y[i], floor_[i]);
    }
}

int peer_setup(const problem *p, double *f, double *low, double *high)
{
    peer_load(p, f, low, high);
    cold();
    return 0;
}

void peer_load(const problem *p, double *f, double *low, double *high)
{
    (void)p;
    linear = f;
    below = low;
    above = high;
}

static int iterate(void)
{
    int solved = 0, turn = 0;
    sg_pqp_state seen = { 0.0, 0.0, 0, 0 };
    shift(upper);
    shift(lower);
    for (int k = 0; k < CAP; k++) {
        for (int i = 0; i < ROWS; i++) {
            scratch[i] = upper[i] - lower[i];
        }
        sg_matvec(PLAN, ROWS, inverse_columns, scratch, correction);
        sg_matvec(ROWS, PLAN, rows_columns, correction, change);
        sg_pqp_evaluate(ROWS, upper, lower, slack_upper, slack_lower, change, &seen);
        iterations = k + 1;
        const int feasible = seen.worst >= -tolerance;
        solved = feasible && (seen.gap <= gap_limit);
        if (solved || (k == CAP - 1)) {
            break;
        }
        const int kind = (turn == 0) ? !feasible : ((turn == PERIOD - 1) ? 2 : 0);
        if (kind == 1) {
            sg_pqp_coordinate(inverse_diagonal, vanish, ceiling, &seen, upper, lower);
        } else if (kind == 2) {
            sg_pqp_extrapolate(ROWS, diagonal, vanish, ceiling, clamp, room, weight, least_step,
                               least_curvature, longest, slack_upper, slack_lower, change, upper,
                               lower, last_upper, last_lower, last_change);
        } else {
            sg_pqp_majorant(ROWS, PER_STEP, BLOCKS, LINES, STRIDE, columns, at_floor, floor_,
                            root_diagonal, upper, lower, scratch, shared, absolute_sum);
            sg_pqp_multiply(ROWS, absolute_sum, phi_diagonal, vanish, ceiling, slack_upper,
                            slack_lower, change, upper, lower, last_upper, last_lower, last_change);
        }
        turn = (turn == PERIOD - 1) ? 0 : turn + 1;
    }
    return solved ? 0 : 1;
}

__attribute__((noinline)) int solve_one(void)
{
    int inside = 1, status = 0;
    iterations = 0;
    sg_matvec(PLAN, PLAN, inverse, linear, free_plan);
    for (int i = 0; i < PLAN; i++) {
        free_plan[i] = -free_plan[i];
    }
    sg_matvec(ROWS, PLAN, rows_columns, free_plan, rows);
    for (int i = 0; i < ROWS; i++) {
        slack_upper[i] = (above[i] - margin) - rows[i];
        slack_lower[i] = rows[i] - (below[i] + margin);
        inside &= (slack_upper[i] >= 0.0) && (slack_lower[i] >= 0.0);
    }
    if (inside) {
        cold();
        sg_fill(PLAN, 0.0, correction);
    } else {
        status = iterate();
    }
    return status;
}

int peer_answer(const problem *p)
{
    for (int i = 0; i < p->n; i++) {
        answer[i] = free_plan[i] - correction[i];
    }
    return iterations;
}

/* all of it is static: read from the symbols of the linked program */
void peer_bytes(const problem *p, long *kept, long *written)
{
    *kept = 8 * (p->n + 2L * p->m);
    *written = 0;
}
