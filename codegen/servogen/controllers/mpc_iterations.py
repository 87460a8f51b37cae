"""The program of a tracking MPC with everything it is given as a parameter."""

from __future__ import annotations

import numpy as np

from servogen.controllers.mpc_design import MpcDesign, state_ports
from servogen.explicit.iteration_program import IterationProgram
from servogen.qp.active_set_tables import ActiveSetTables
from servogen.qp.parametric import parameter_box

# Without a limit of their own there is no set of parameters to certify: position, velocity and
# acceleration have one.
LIMITED_STATES = 3


def mpc_program(design: MpcDesign) -> IterationProgram | None:
    """theta is the state (n,), the references r_0..r_N, the lower bounds of y_1..y_N, the upper
    ones: each within its declared range. None where PQP iterates or the state has components
    without a limit.
    """
    tables = design.solver
    n, horizon, qp, limits = design.plant.order, design.horizon, design.qp, design.limits
    if not isinstance(tables, ActiveSetTables) or n > LIMITED_STATES:
        return None
    p = n + (horizon + 1) + 2 * horizon
    unit = np.eye(p + 1)
    state, reference = unit[:n], unit[n : n + horizon + 1]
    low, high = np.split(unit[n + horizon + 1 : p], 2)
    one = unit[p]
    relative = reference - state[0]
    on_state = design.plan_state.T.astype(np.float64)
    on_reference = design.plan_reference.T.astype(np.float64)
    free = on_state @ state[1:] + on_reference @ relative
    start = state / qp.state_scale[:, None]
    start[0] = 0.0
    m, first = design.rows, design.rows - qp.terminal_rows
    margin, scale = design.tol.margin, 1.0 / limits.fast_range_m
    above, below = np.tile((1.0 - margin) * one, (m, 1)), np.tile((margin - 1.0) * one, (m, 1))
    above[0 : first : qp.rows_per_step] = (high - state[0]) * scale - margin * one
    below[0 : first : qp.rows_per_step] = (low - state[0]) * scale + margin * one
    centre = np.outer(qp.terminal_reference, relative[-1])
    centre = centre + np.outer(qp.terminal_position, state[0])
    reach = np.outer(qp.terminal_bound, one)
    above[first:] = reach - centre - margin * one
    below[first:] = margin * one - reach - centre
    most = np.concatenate(
        [
            [port.high for port in state_ports("", n, limits)],
            np.full(horizon + 1, limits.position_m),
            np.full(2 * horizon, state_ports("", n, limits)[0].high),
        ]
    )
    box, bounds = parameter_box(-most, most)
    return IterationProgram(
        tables=tables,
        free=free,
        low=below,
        high=above,
        domain_rows=box,
        domain_bounds=bounds,
        start=start,
    )
