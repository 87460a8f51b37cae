/* harness PROGRAMS ANSWERS: solves all programs of a file in order; writes, per program, the answer
   (n doubles), what the solver says (0: solved) and its iterations.
   harness PROGRAMS TIMES PASSES: the same a few times over; writes the least seconds per program. */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include "peer.h"

double answer[4096];

static void must(int well)
{
    if (!well) {
        fprintf(stderr, "the file of programs cannot be read\n");
        exit(2);
    }
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void clocked(const problem *p, double *programs, size_t steps, int passes, FILE *out)
{
    const size_t n = (size_t)p->n, m = (size_t)p->m, each = n + 2 * m;
    double *least = malloc(sizeof(double) * steps);
    for (int pass = 0; pass < passes; pass++) {
        for (size_t t = 0; t < steps; t++) {
            double *f = programs + t * each;
            peer_load(p, f, f + n, f + n + m);
            const double begin = now();
            (void)solve_one();
            const double spent = now() - begin;
            least[t] = (pass == 0 || spent < least[t]) ? spent : least[t];
            (void)peer_answer(p);
        }
    }
    fwrite(least, sizeof(double), steps, out);
    free(least);
}

static void answered(const problem *p, double *programs, size_t steps, FILE *out)
{
    const size_t n = (size_t)p->n, m = (size_t)p->m, each = n + 2 * m;
    for (size_t t = 0; t < steps; t++) {
        double *f = programs + t * each;
        peer_load(p, f, f + n, f + n + m);
        const int status = solve_one();
        const int iterations = peer_answer(p);
        const double told[2] = { (double)status, (double)iterations };
        fwrite(answer, sizeof(double), n, out);
        fwrite(told, sizeof(double), 2, out);
    }
}

int main(int count, char **words)
{
    int size[3];
    problem p;
    FILE *in = (count == 3 || count == 4) ? fopen(words[1], "rb") : NULL;
    must(in != NULL);
    must(fread(size, sizeof(int), 3, in) == 3);
    p.n = size[0];
    p.m = size[1];
    const size_t n = (size_t)p.n, m = (size_t)p.m, steps = (size_t)size[2], each = n + 2 * m;
    p.hessian = malloc(sizeof(double) * n * n);
    p.rows = malloc(sizeof(double) * m * n);
    double *programs = malloc(sizeof(double) * steps * each);
    must(fread(p.hessian, sizeof(double), n * n, in) == n * n);
    must(fread(p.rows, sizeof(double), m * n, in) == m * n);
    must(fread(programs, sizeof(double), steps * each, in) == steps * each);
    fclose(in);
    FILE *out = fopen(words[2], "wb");
    must(out != NULL);
    if (peer_setup(&p, programs, programs + n, programs + n + m) != 0) {
        fprintf(stderr, "setup failed\n");
        return 3;
    }
    if (count == 4) {
        clocked(&p, programs, steps, atoi(words[3]), out);
    } else {
        answered(&p, programs, steps, out);
    }
    fclose(out);
    long kept = 0, written = 0;
    peer_bytes(&p, &kept, &written);
    printf("{\"kept\": %ld, \"written\": %ld}\n", kept, written);
    return 0;
}
