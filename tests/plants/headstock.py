"""The headstock axis of paper 5: its printed matrices, and a two-mass drive that rounds to them."""

import numpy as np

from servogen.plants.sampled import Sampled
from servogen.plants.two_mass import TwoMass

PERIOD = 500e-6
PRINTED = Sampled(
    [
        [3.6e-1, 6.4e-1, -2.1e3, 2.1e3],
        [1.8e-1, 8.2e-1, 5.9e2, -5.9e2],
        [3.8e-4, 1.2e-4, 3.7e-1, 6.3e-1],
        [3.3e-5, 4.7e-4, 1.8e-1, 8.2e-1],
    ],
    np.array([[8.6e-5], [7.5e-6], [2.5e-8], [9.9e-10]]),
    [[0.0, 0.0, 5.7e1, 0.0]],
    PERIOD,
)
MOTOR = 0.01  # kg m^2: the printed matrices fix ratios to it, not itself
LOAD = MOTOR / 0.285
HEADSTOCK = TwoMass(
    motor_inertia_kg_m2=MOTOR,
    load_inertia_kg_m2=LOAD,
    stiffness_n_m_per_rad=5.95e6 * MOTOR,
    coupling_damping_n_m_s_per_rad=48.0 * MOTOR,
    motor_friction_n_m_s_per_rad=1.0 * MOTOR,
    load_friction_n_m_s_per_rad=1.0 * LOAD,
    torque_constant_n_m_per_a=225.4 * MOTOR,
)
