"""Motions that a servo drive is asked for, as functions of time; degrees and seconds."""

from __future__ import annotations

import numpy as np

from servogen.precision import FloatArray
from servogen.project.servo_reference import SineReference, TrapezoidReference
from servogen.systems.servo_loop import Motion


def sine(amplitude_deg: float, frequency_hz: float, start_deg: float = 0.0) -> Motion:
    """start + amplitude sin(2 pi f t)."""

    def motion(time_s: FloatArray) -> FloatArray:
        swing = amplitude_deg * np.sin(2.0 * np.pi * frequency_hz * time_s)
        result: FloatArray = start_deg + swing
        return result

    return motion


def trapezoid(wanted: TrapezoidReference) -> Motion:
    """From the start by the stroke at a trapezoid of speed, then rest; at rest before 0 s too."""
    reached, acceleration = wanted.reached_deg_per_s, wanted.acceleration_deg_per_s2
    duration, ramp = wanted.lasts_s, reached / acceleration

    def motion(time_s: FloatArray) -> FloatArray:
        t = np.clip(time_s, 0.0, duration)
        rising = 0.5 * acceleration * np.minimum(t, ramp) ** 2
        level = reached * np.clip(t - ramp, 0.0, duration - 2.0 * ramp)
        falling = np.clip(t - (duration - ramp), 0.0, ramp)
        slowing = reached * falling - 0.5 * acceleration * falling**2
        result: FloatArray = wanted.start_deg + (rising + level + slowing)
        return result

    return motion


def reference_motion(wanted: SineReference | TrapezoidReference) -> tuple[Motion, float]:
    """A project's reference and how long it lasts, s."""
    if isinstance(wanted, SineReference):
        return sine(wanted.amplitude_deg, wanted.frequency_hz, wanted.start_deg), wanted.lasts_s
    return trapezoid(wanted), wanted.lasts_s
