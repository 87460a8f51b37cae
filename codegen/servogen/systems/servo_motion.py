"""Motions that a servo drive is asked for, as functions of time; degrees and seconds."""

from __future__ import annotations

import numpy as np

from servogen.precision import FloatArray
from servogen.project.servo_schema import SineReference, TrapezoidReference
from servogen.systems.servo_loop import Motion


def sine(amplitude_deg: float, frequency_hz: float) -> Motion:
    """amplitude sin(2 pi f t)."""

    def motion(time_s: FloatArray) -> FloatArray:
        result: FloatArray = amplitude_deg * np.sin(2.0 * np.pi * frequency_hz * time_s)
        return result

    return motion


def trapezoid_duration(stroke_deg: float, speed: float, acceleration: float) -> float:
    """Seconds from rest to rest; a short stroke does not reach the speed."""
    reached = min(speed, float(np.sqrt(stroke_deg * acceleration)))
    return stroke_deg / reached + reached / acceleration


def trapezoid(stroke_deg: float, speed: float, acceleration: float) -> Motion:
    """From 0 to the stroke at a trapezoid of speed, then rest; at rest before 0 too."""
    reached = min(speed, float(np.sqrt(stroke_deg * acceleration)))
    duration, ramp = trapezoid_duration(stroke_deg, speed, acceleration), reached / acceleration

    def motion(time_s: FloatArray) -> FloatArray:
        t = np.clip(time_s, 0.0, duration)
        rising = 0.5 * acceleration * np.minimum(t, ramp) ** 2
        level = reached * np.clip(t - ramp, 0.0, duration - 2.0 * ramp)
        falling = np.clip(t - (duration - ramp), 0.0, ramp)
        result: FloatArray = rising + level + reached * falling - 0.5 * acceleration * falling**2
        return result

    return motion


def reference_motion(wanted: SineReference | TrapezoidReference) -> tuple[Motion, float]:
    """A project's reference and how long it lasts, s."""
    if isinstance(wanted, SineReference):
        lasts = wanted.cycles / wanted.frequency_hz
        return sine(wanted.amplitude_deg, wanted.frequency_hz), lasts
    shape = (wanted.stroke_deg, wanted.speed_deg_per_s, wanted.acceleration_deg_per_s2)
    return trapezoid(*shape), trapezoid_duration(*shape)
