/* TinyMPC's core, from the C++ of its sdist. It takes states and boxes instead of f and rows: the file
   "stated" has, after int32 nx, nu, N, T: A, B, Q, R, rho, Kinf, Pinf, Quu^-1, (A - B Kinf)' and then
   per program x_0, the state's bounds (N columns of nx, lower then upper) and the input's (N - 1). The
   cache is given: its own recursion stops where gains change by less than 1e-5. */
#include <cstdio>
#include <iostream>
#include <vector>
#include <tinympc/tiny_api.hpp>
#include "asked.h"
#include "peer.h"

using Rows = Matrix<double, Dynamic, Dynamic, RowMajor>;

static TinySolver *solver;
static int nx, nu, knots, steps, step;
static std::vector<double> programs;
static double *now;

static tinyMatrix matrix(FILE *in, int rows, int columns)
{
    Rows read(rows, columns);
    if (std::fread(read.data(), sizeof(double), static_cast<size_t>(read.size()), in)
        != static_cast<size_t>(read.size())) {
        std::fprintf(stderr, "the file of states is short\n");
        std::exit(2);
    }
    return read;
}

int peer_setup(const problem *, double *, double *, double *)
{
    int size[4];
    FILE *in = std::fopen("stated", "rb");
    if (in == nullptr || std::fread(size, sizeof(int), 4, in) != 4) {
        return 1;
    }
    nx = size[0];
    nu = size[1];
    knots = size[2];
    steps = size[3];
    const tinyMatrix a = matrix(in, nx, nx), b = matrix(in, nx, nu);
    const tinyVector q = matrix(in, nx, 1), r = matrix(in, nu, 1);
    const double rho = matrix(in, 1, 1)(0, 0);
    asked_counting = 1;
    if (tiny_setup(&solver, a, b, tinyMatrix::Zero(nx, 1), q.asDiagonal(), r.asDiagonal(), rho, nx,
                   nu, knots, 0) != 0) {
        return 2;
    }
    solver->cache->Kinf = matrix(in, nu, nx);
    solver->cache->Pinf = matrix(in, nx, nx);
    solver->cache->Quu_inv = matrix(in, nu, nu);
    solver->cache->AmBKt = matrix(in, nx, nx);
    asked_counting = 0;
    solver->settings->abs_pri_tol = TOLERANCE;
    solver->settings->abs_dua_tol = TOLERANCE;
    solver->settings->max_iter = ITERATIONS;
    const tinyMatrix all = matrix(in, steps, nx + 2 * (nx * knots + nu * (knots - 1)));
    const Rows by_step = all;
    programs.assign(by_step.data(), by_step.data() + by_step.size());
    std::fclose(in);
    std::cout.setstate(std::ios_base::failbit);  /* it reports every solve */
    const tinyMatrix low = tinyMatrix::Zero(nx, knots), high = tinyMatrix::Zero(nu, knots - 1);
    return tiny_set_bound_constraints(solver, low, low, high, high);
}

void peer_load(const problem *, double *, double *, double *)
{
    const size_t each = programs.size() / static_cast<size_t>(steps);
    now = programs.data() + each * static_cast<size_t>(step);
    step = (step + 1) % steps;
}

__attribute__((noinline)) int solve_one(void)
{
    TinyWorkspace *work = solver->work;
    const int states = nx * knots, inputs = nu * (knots - 1);
    const double *bounds = now + nx;
    work->x.col(0) = Map<const VectorXd>(now, nx);
    work->x_min = Map<const MatrixXd>(bounds, nx, knots);
    work->x_max = Map<const MatrixXd>(bounds + states, nx, knots);
    work->u_min = Map<const MatrixXd>(bounds + 2 * states, nu, knots - 1);
    work->u_max = Map<const MatrixXd>(bounds + 2 * states + inputs, nu, knots - 1);
    tiny_solve(solver);
    return solver->solution->solved ? 0 : 1;
}

int peer_answer(const problem *p)
{
    Map<VectorXd>(answer, p->n) = Map<VectorXd>(solver->solution->u.data(), p->n);
    return solver->solution->iter;
}

void peer_bytes(const problem *p, long *kept, long *written)
{
    (void)p;
    *kept = 8L * (nx + 2 * (nx * knots + nu * (knots - 1)));
    *written = asked_bytes
        + static_cast<long>(sizeof *solver + sizeof *solver->work + sizeof *solver->cache
                            + sizeof *solver->settings + sizeof *solver->solution);
}
