/* ProxQP's dense solver, from its headers; warm from its last result. */
#include <proxsuite/proxqp/dense/dense.hpp>
#include "asked.h"
#include "peer.h"

using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Numbers = Eigen::Map<Eigen::VectorXd>;
using namespace proxsuite;

static proxqp::dense::QP<double> *solver;
static Eigen::VectorXd linear, below, above;

int peer_setup(const problem *p, double *f, double *low, double *high)
{
    const Eigen::MatrixXd hessian = Eigen::Map<Rows>(p->hessian, p->n, p->n);
    const Eigen::MatrixXd rows = Eigen::Map<Rows>(p->rows, p->m, p->n);
    peer_load(p, f, low, high);
    asked_counting = 1;
    solver = new proxqp::dense::QP<double>(p->n, 0, p->m);
    solver->settings.eps_abs = TOLERANCE;
    solver->settings.eps_rel = 0.0;
    /* without it small residuals are enough, and z may be 1e-2 away */
    solver->settings.check_duality_gap = true;
    solver->settings.eps_duality_gap_abs = TOLERANCE;
    solver->settings.eps_duality_gap_rel = 0.0;
    solver->init(hessian, linear, nullopt, nullopt, rows, below, above);
    solver->solve();
    solver->settings.initial_guess = proxqp::InitialGuessStatus::WARM_START_WITH_PREVIOUS_RESULT;
    asked_counting = 0;
    return 0;
}

void peer_load(const problem *p, double *f, double *low, double *high)
{
    linear = Numbers(f, p->n);
    below = Numbers(low, p->m);
    above = Numbers(high, p->m);
}

__attribute__((noinline)) int solve_one(void)
{
    solver->update(nullopt, linear, nullopt, nullopt, nullopt, below, above);
    solver->solve();
    return solver->results.info.status == proxqp::QPSolverOutput::PROXQP_SOLVED ? 0 : 1;
}

int peer_answer(const problem *p)
{
    Numbers(answer, p->n) = solver->results.x;
    return static_cast<int>(solver->results.info.iter);
}

/* it keeps copies of everything: all of it is counted as workspace */
void peer_bytes(const problem *p, long *kept, long *written)
{
    *kept = 8 * (p->n + 2L * p->m);
    *written = asked_bytes + static_cast<long>(sizeof *solver);
}
