/* quadprog's qpgen2_, cold, its matrices kept: what it overwrites is copied and counted, as its
   Python does. G'z >= b with the inverse of the factor of H in place of H. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "peer.h"

int qpgen2_(double *G, double *av, int n, double *xv, double *lagr, double *obj, double *C,
            double *bv, int q, int meq, int *iact, int *nact, int *iter, double *work, int factorized);

static double *factor, *rows, *gradient, *bound, *dual, *work, *factor_copy, *rows_copy;
static const double *linear, *below, *above;
static int *held, iterations[2], n, m;

/* upper triangular inverse of the upper factor R, H = R'R, by columns */
static int factored(const double *hessian)
{
    double *r = calloc((size_t)(n * n), sizeof(double));
    for (int j = 0; j < n; j++) {
        for (int i = 0; i <= j; i++) {
            double sum = hessian[i * n + j];
            for (int k = 0; k < i; k++) {
                sum -= r[k * n + i] * r[k * n + j];
            }
            r[i * n + j] = (i == j) ? sqrt(sum) : sum / r[i * n + i];
        }
    }
    for (int j = 0; j < n; j++) {
        for (int i = j; i >= 0; i--) {
            double sum = (i == j) ? 1.0 : 0.0;
            for (int k = i + 1; k <= j; k++) {
                sum -= r[i * n + k] * factor[j * n + k];
            }
            factor[j * n + i] = sum / r[i * n + i];
        }
    }
    const int well = isfinite(factor[n * n - 1]);
    free(r);
    return well ? 0 : 1;
}

static double *doubles(int count)
{
    return calloc((size_t)count, sizeof(double));
}

static int least(int a, int b)
{
    return a < b ? a : b;
}

int peer_setup(const problem *p, double *f, double *low, double *high)
{
    n = p->n;
    m = p->m;
    const int q = 2 * m;
    factor = doubles(n * n);
    factor_copy = doubles(n * n);
    rows = doubles(n * q);
    rows_copy = doubles(n * q);
    gradient = doubles(n);
    bound = doubles(q);
    dual = doubles(q);
    work = doubles(2 * n + 2 * q + least(n, q) * (least(n, q) + 5) / 2);
    held = calloc((size_t)q, sizeof(int));
    for (int i = 0; i < m; i++) {
        for (int j = 0; j < n; j++) {
            rows[i * n + j] = -p->rows[i * n + j];
            rows[(m + i) * n + j] = p->rows[i * n + j];
        }
    }
    peer_load(p, f, low, high);
    return factored(p->hessian);
}

void peer_load(const problem *p, double *f, double *low, double *high)
{
    (void)p;
    linear = f;
    below = low;
    above = high;
}

__attribute__((noinline)) int solve_one(void)
{
    double cost;
    int count;
    memcpy(factor_copy, factor, sizeof(double) * (size_t)(n * n));
    memcpy(rows_copy, rows, sizeof(double) * (size_t)(2 * n * m));
    for (int i = 0; i < n; i++) {
        gradient[i] = -linear[i];
    }
    for (int i = 0; i < m; i++) {
        bound[i] = -above[i];
        bound[m + i] = below[i];
    }
    return qpgen2_(factor_copy, gradient, n, answer, dual, &cost, rows_copy, bound, 2 * m, 0, held,
                   &count, iterations, work, 1);
}

int peer_answer(const problem *p)
{
    (void)p;
    return iterations[0];
}

void peer_bytes(const problem *p, long *kept, long *written)
{
    const long q = 2L * p->m, size = p->n, few = size < q ? size : q;
    *kept = 8 * (size * size + size * q + size + q);
    *written = 8 * (size * size + size * q + size + 2 * q + 2 * size + 2 * q + few * (few + 5) / 2)
        + 4 * q;
}
