/* A program emitted by servogen, kind "qp", prefix "sgq". */
#include "peer.h"
#include "sgq.h"

static sgq_t self;
static sgq_step_in in;
static sgq_step_out out;

int peer_setup(const problem *p, double *f, double *low, double *high)
{
    (void)p;
    (void)f;
    (void)low;
    (void)high;
    sgq_init(&self);
    sgq_reset(&self);
    return 0;
}

void peer_load(const problem *p, double *f, double *low, double *high)
{
    for (int i = 0; i < p->n; i++) {
        in.linear[i] = f[i];
    }
    for (int i = 0; i < p->m; i++) {
        in.low[i] = low[i];
        in.high[i] = high[i];
    }
}

__attribute__((noinline)) int solve_one(void)
{
    return (int)sgq_step(&self, &in, &out);
}

int peer_answer(const problem *p)
{
    for (int i = 0; i < p->n; i++) {
        answer[i] = out.z[i];
    }
    return (int)out.iterations;
}

void peer_bytes(const problem *p, long *kept, long *written)
{
    (void)p;
    *kept = TABLE_BYTES + (long)sizeof in;
    *written = (long)(sizeof self + sizeof out);
}
