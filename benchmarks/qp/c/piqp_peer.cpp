/* PIQP's dense interior-point solver, from its headers. Cold: it has no warm start. */
#include <piqp/piqp.hpp>
#include "asked.h"
#include "peer.h"

using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Numbers = Eigen::Map<Eigen::VectorXd>;

static piqp::DenseSolver<double> *solver;
static Eigen::VectorXd linear, below, above;

int peer_setup(const problem *p, double *f, double *low, double *high)
{
    const Eigen::MatrixXd hessian = Eigen::Map<Rows>(p->hessian, p->n, p->n);
    const Eigen::MatrixXd rows = Eigen::Map<Rows>(p->rows, p->m, p->n);
    peer_load(p, f, low, high);
    asked_counting = 1;
    solver = new piqp::DenseSolver<double>();
    solver->settings().eps_abs = TOLERANCE;
    solver->settings().eps_rel = 0.0;
    solver->settings().eps_duality_gap_abs = TOLERANCE;
    solver->settings().eps_duality_gap_rel = 0.0;
    solver->setup(hessian, linear, piqp::nullopt, piqp::nullopt, rows, below, above);
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
    solver->update(piqp::nullopt, linear, piqp::nullopt, piqp::nullopt, piqp::nullopt, below, above);
    return solver->solve() == piqp::Status::PIQP_SOLVED ? 0 : 1;
}

int peer_answer(const problem *p)
{
    Numbers(answer, p->n) = solver->result().x;
    return static_cast<int>(solver->result().info.iter);
}

/* it keeps copies of everything: all of it is counted as workspace */
void peer_bytes(const problem *p, long *kept, long *written)
{
    *kept = 8 * (p->n + 2L * p->m);
    *written = asked_bytes + static_cast<long>(sizeof *solver);
}
