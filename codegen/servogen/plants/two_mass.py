"""A direct drive whose motor turns a load through an elastic coupling: two masses, one current."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from servogen.plants.errors import PlantError
from servogen.plants.sampled import Sampled, hold
from servogen.plants.statespace import FloatArray, read_only

MILLIAMPERES = 1000.0
DEGREES = 180.0 / np.pi
ORDER = 4
# Columns of ``TwoMass.b``.
CURRENT, LOAD_TORQUE = 0, 1
_MAY_BE_ZERO = ("coupling_damping_n_m_s_per_rad", "motor_friction_n_m_s_per_rad",
                "load_friction_n_m_s_per_rad")  # fmt: skip


@dataclass(frozen=True)
class TwoMass:
    """States motor speed, load speed (rad/s), motor angle, load angle (rad).

    Inputs: the motor's current in mA, and a torque on the load in N m (a disturbance); output: the
    motor's angle in degrees. From one motion at one current only the ratios to the motor's inertia
    can be told.

    Raises:
        PlantError: a parameter that is not finite, negative, or zero where it divides.
    """

    motor_inertia_kg_m2: float
    load_inertia_kg_m2: float
    stiffness_n_m_per_rad: float
    coupling_damping_n_m_s_per_rad: float
    motor_friction_n_m_s_per_rad: float
    load_friction_n_m_s_per_rad: float
    torque_constant_n_m_per_a: float

    def __post_init__(self) -> None:
        for entry in fields(self):
            value = getattr(self, entry.name)
            zero = entry.name in _MAY_BE_ZERO
            if not (np.isfinite(value) and (value > 0.0 or (zero and value == 0.0))):
                expected = "zero or a positive number" if zero else "a positive number"
                raise PlantError(entry.name, value, expected)

    @property
    def a(self) -> FloatArray:
        """(4, 4) of dx/dt = a x + b u."""
        motor, load = self.motor_inertia_kg_m2, self.load_inertia_kg_m2
        k, c = self.stiffness_n_m_per_rad, self.coupling_damping_n_m_s_per_rad
        on_motor, on_load = self.motor_friction_n_m_s_per_rad, self.load_friction_n_m_s_per_rad
        return read_only(
            [
                [-(c + on_motor) / motor, c / motor, -k / motor, k / motor],
                [c / load, -(c + on_load) / load, k / load, -k / load],
                [1.0, 0.0, 0.0, 0.0],
                [0.0, 1.0, 0.0, 0.0],
            ]
        )

    @property
    def b(self) -> FloatArray:
        """(4, 2): current in mA, torque on the load in N m."""
        b = np.zeros((ORDER, 2))
        b[0, CURRENT] = self.torque_constant_n_m_per_a / MILLIAMPERES / self.motor_inertia_kg_m2
        b[1, LOAD_TORQUE] = 1.0 / self.load_inertia_kg_m2
        return read_only(b)

    @property
    def c(self) -> FloatArray:
        """(1, 4): motor angle in degrees."""
        return read_only([[0.0, 0.0, DEGREES, 0.0]])

    def sampled(self, sample_time_s: float) -> Sampled:
        """What the controller drives: the current alone, exactly held."""
        return hold(self.a, self.b[:, [CURRENT]], self.c, sample_time_s)

    def disturbed(self, sample_time_s: float) -> Sampled:
        """What is simulated: both inputs, exactly held."""
        return hold(self.a, self.b, self.c, sample_time_s)
