"""Vectors, angles and the origin of the world.

Triples of floats: at a hundred steps a second NumPy's overhead would be the larger part.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import pymap3d

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


@dataclass(frozen=True, slots=True)
class Origin:
    """The world's origin: WGS-84 degrees, ground height in metres above mean sea level.

    World coordinates are NED metres on the tangent plane here; the origin is the upper-left corner of the world's
    picture, so that north is minus its y and east its x.
    """

    latitude: float = 43.2609
    longitude: float = -79.9192
    altitude: float = 100.0

    def to_geodetic(self, place: Vector) -> Vector:
        """Return latitude, longitude (degrees) and altitude (metres above sea level) of a place in the world."""
        latitude, longitude, altitude = pymap3d.ned2geodetic(*place, self.latitude, self.longitude, self.altitude)
        return float(latitude), float(longitude), float(altitude)

    def to_world(self, latitude: float, longitude: float, altitude: float) -> Vector:
        """Return the place in the world (NED metres) of geodetic coordinates."""
        north, east, down = pymap3d.geodetic2ned(
            latitude, longitude, altitude, self.latitude, self.longitude, self.altitude
        )
        return float(north), float(east), float(down)


@dataclass(frozen=True, slots=True)
class Slope:
    """Ground that rises by ``percent`` towards ``direction`` (radians clockwise from north), zero at ``start``."""

    percent: float = 0.0
    direction: float = 0.0
    start: Flat = (0.0, 0.0)

    def height(self, north: float, east: float) -> float:
        """Return the ground's height at a place in the world, metres above the ground at the start."""
        if self.percent == 0.0:
            return 0.0
        along = (north - self.start[0]) * math.cos(self.direction) + (east - self.start[1]) * math.sin(self.direction)
        return along * self.percent / 100.0

    def tilt(self, yaw: float) -> Flat:
        """Return roll and pitch (radians) of a drone that stands on it with this heading."""
        gradient = self.percent / 100.0
        ahead, right = (gradient * function(self.direction - yaw) for function in (math.cos, math.sin))
        pitch = math.atan(ahead)
        return -math.atan(right * math.cos(pitch)), pitch
