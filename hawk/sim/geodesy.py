"""Where the simulated world lies on the earth."""

from __future__ import annotations

from dataclasses import dataclass

import pymap3d

from hawk.sim.vector import Vector


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
