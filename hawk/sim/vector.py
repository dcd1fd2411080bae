"""Small helpers on triples of floats: at a hundred steps a second NumPy's overhead would be the larger part."""

from __future__ import annotations

import math

Vector = tuple[float, float, float]
"""North, east, down."""
Flat = tuple[float, float]
"""North, east."""


def add(a: Vector, b: Vector) -> Vector:
    """Return a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def subtract(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def limit(x: float, y: float, longest: float) -> Flat:
    """Return the flat vector, shortened to ``longest`` when it is longer."""
    length = math.hypot(x, y)
    if length <= longest:
        return x, y
    return x * longest / length, y * longest / length


def clamp(value: float, low: float, high: float) -> float:
    """Return the value inside [low, high]."""
    return low if value < low else high if value > high else value


def wrap_angle(angle: float) -> float:
    """Return the angle in (-pi, pi]."""
    wrapped = math.remainder(angle, math.tau)
    return math.pi if wrapped == -math.pi else wrapped


def sqrt_controller(error: float, gain: float, acceleration: float) -> float:
    """Return the speed (m/s) for a distance: linear when near, the square root that the deceleration allows when far.

    ArduPilot's ``sqrt_controller`` (libraries/AP_Math/control.cpp) without its time step.
    """
    linear = acceleration / gain**2
    if abs(error) <= linear:
        return error * gain
    return math.copysign(math.sqrt(2.0 * acceleration * (abs(error) - linear / 2.0)), error)
