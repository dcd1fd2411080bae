"""Rows: exclusion polygons beside the inclusion polygon, their read-back, breach, and the storage for corners."""

from __future__ import annotations

import math
from collections.abc import Sequence

import pytest
from mavsdk.plugins.action import ActionError
from mavsdk.plugins.geofence import FenceType, GeofenceData, GeofenceError, Point, Polygon

from tests.contract.vehicle import GUIDED, HEIGHT, METRES_A_DEGREE, RTL, Vehicle

pytestmark = pytest.mark.contract
AROUND = ((-45, -45), (45, -45), (45, 45), (-45, 45))
ZONE = ((14, -8), (26, -8), (26, 8), (14, 8))
SECOND = ((-30, -30), (-20, -30), (-25, -20))
RTL_ACTION = 1


def polygon(vehicle: Vehicle, kind: FenceType, corners: Sequence[tuple[float, float]]) -> Polygon:
    """Return a polygon of places in metres north and east of home."""
    home = vehicle.pilot.telemetry.home()
    east = METRES_A_DEGREE * math.cos(math.radians(home.latitude_deg))
    points = [Point(home.latitude_deg + a / METRES_A_DEGREE, home.longitude_deg + b / east) for a, b in corners]
    return Polygon(points, kind)


def zoned(vehicle: Vehicle) -> GeofenceData:
    """Return a fence with two exclusion zones."""
    kinds = ((FenceType.INCLUSION, AROUND), (FenceType.EXCLUSION, ZONE), (FenceType.EXCLUSION, SECOND))
    return GeofenceData([polygon(vehicle, kind, corners) for kind, corners in kinds], [])


def test_exclusion_polygons_are_read_back_in_their_order_with_their_corners(grounded: Vehicle) -> None:
    fence, geofence = zoned(grounded), grounded.pilot.geofence
    geofence.upload_geofence(fence)
    found = geofence.download_geofence()
    assert [one.fence_type for one in found.polygons] == [one.fence_type for one in fence.polygons]
    assert not found.circles
    for sent, read in zip(fence.polygons, found.polygons, strict=True):
        for here, there in zip(sent.points, read.points, strict=True):
            assert here.latitude_deg == pytest.approx(there.latitude_deg, abs=1.5e-7)
            assert here.longitude_deg == pytest.approx(there.longitude_deg, abs=1.5e-7)


def test_a_target_in_a_zone_is_not_taken_and_flying_into_one_is_a_breach_that_returns(flying: Vehicle) -> None:
    pilot, home = flying.pilot, flying.pilot.telemetry.home()
    pilot.geofence.upload_geofence(zoned(flying))
    flying.set({"FENCE_TYPE": 5, "FENCE_ACTION": RTL_ACTION, "FENCE_ENABLE": 1})
    flying.let_pass(3.0)  # ArduCopter takes a new fence up once a second
    with pytest.raises(ActionError, match="FAILED"):
        pilot.action.goto_location(
            home.latitude_deg + 20.0 / METRES_A_DEGREE, home.longitude_deg, home.absolute_altitude_m + HEIGHT, 0.0
        )
    before = flying.place
    pilot.target(20.0, 0.0, -HEIGHT)
    flying.let_pass(4.0)
    assert math.dist(flying.place, before) < 0.7
    assert flying.mode == GUIDED
    pilot.target(0.0, -12.0, -HEIGHT)  # beside the zone it flies on
    flying.wait(lambda: math.dist(flying.place, (0.0, -12.0, -HEIGHT)) < 1.0, 20.0)
    flying.go(0.0, 0.0, -HEIGHT)
    pilot.texts.clear()
    pilot.target(35.0, 0.0, -HEIGHT)  # beyond the zone: the path is not looked at
    farthest = 0.0

    def is_turned_back() -> bool:
        # MAVSDK hears places 20 times a second and on a busy machine late: the mode can be known before the place is.
        nonlocal farthest
        farthest = max(farthest, flying.place[0])
        return flying.mode == RTL and farthest > 13.0 and flying.place[0] < 12.0

    flying.wait(is_turned_back, 60.0)
    assert flying.said("polygon fence breached")
    assert farthest < 24.0
    flying.land()


def test_a_fence_has_room_for_560_bytes(grounded: Vehicle) -> None:
    """5 bytes, 2 a polygon and 8 a corner; one that would fill the last byte ends ArduCopter and is not tried."""

    def circle(count: int) -> list[tuple[float, float]]:
        angles = [math.tau * k / count for k in range(count)]
        return [(40.0 * math.cos(angle), 40.0 * math.sin(angle)) for angle in angles]

    geofence = grounded.pilot.geofence

    def upload(corners: int, zones: int) -> None:
        small = [[(a + 3.0 * k, b) for a, b in ((0, 0), (2, 0), (2, 2))] for k in range(zones)]
        geofence.upload_geofence(
            GeofenceData(
                [
                    polygon(grounded, FenceType.INCLUSION, circle(corners)),
                    *(polygon(grounded, FenceType.EXCLUSION, zone) for zone in small),
                ],
                [],
            )
        )

    upload(69, 0)
    upload(30, 12)
    assert [len(one.points) for one in geofence.download_geofence().polygons] == [30, *[3] * 12]
    with pytest.raises(GeofenceError, match="ERROR"):
        upload(70, 0)
    with pytest.raises(GeofenceError, match="ERROR"):
        upload(31, 12)
    with pytest.raises(GeofenceError, match="TOO_MANY"):
        upload(71, 0)
    grounded.wait(lambda: grounded.said("Fence exceeds storage size"), 5.0)
