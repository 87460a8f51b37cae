/* A lookup emitted by servogen, prefix "sgl", in the harness of QP solvers: f is the parameter. CALL is
   its find, or its solve, which trusts the parameter. */
#include "peer.h"
#include "sgl.h"

static sgl_t self;
static sgl_find_in in;
static sgl_find_out out;

int peer_setup(const problem *p, double *f, double *low, double *high)
{
    (void)p;
    (void)f;
    (void)low;
    (void)high;
    sgl_init(&self);
    return 0;
}

void peer_load(const problem *p, double *f, double *low, double *high)
{
    (void)low;
    (void)high;
    for (int i = 0; i < p->n; i++) {
        in.theta[i] = f[i];
    }
}

__attribute__((noinline)) int solve_one(void)
{
    return (int)CALL(&self, &in, &out);
}

int peer_answer(const problem *p)
{
    (void)p;
    for (int j = 0; j < SGL_MOVES; j++) {
        answer[j] = out.move[j];
    }
    return -1;
}

void peer_bytes(const problem *p, long *kept, long *written)
{
    (void)p;
    *kept = TABLE_BYTES + (long)sizeof in;
    *written = (long)(sizeof self + sizeof out);
}
