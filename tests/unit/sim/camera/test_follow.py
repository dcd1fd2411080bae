from __future__ import annotations

import itertools
import math
from typing import Any

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.sim.camera.camera import FRAME_S
from hawk.sim.camera.follow import Follower
from hawk.sim.geometry import Origin
from tests.unit.sim.camera.test_camera import HandClock


def joined(station: Any) -> tuple[Follower, HandClock]:
    """Return a follower that talks to a simulated vehicle."""
    clock = HandClock()
    return Follower(Origin(), clock), clock


def fly_along(station: Any, follower: Follower, clock: HandClock, seconds: float) -> list[Any]:
    """Let both talk to each other; return the shots."""
    shots = []
    for _ in range(round(seconds / 0.01)):
        station.autopilot.step()
        clock.real += 0.01
        for data in station.link.poll():
            follower.receive(data)
        for data in follower.poll():
            station.link.receive(data)
        shots += follower.shots()
    return shots


@pytest.mark.slow
def test_asks_for_what_it_needs_and_shoots_fifteen_a_second(flying: Any) -> None:
    follower, clock = joined(flying)
    fly_along(flying, follower, clock, 4.0)
    shots = fly_along(flying, follower, clock, 4.0)
    assert len(shots) == pytest.approx(60, abs=1)
    gaps = [b.stamp - a.stamp for a, b in itertools.pairwise(shots)]
    assert max(gaps) < FRAME_S + 0.03


@pytest.mark.slow
def test_shoots_as_often_as_it_is_asked_to(flying: Any) -> None:
    clock = HandClock()
    follower = Follower(Origin(), clock, frame_s=0.25)
    fly_along(flying, follower, clock, 4.0)
    assert len(fly_along(flying, follower, clock, 4.0)) == pytest.approx(16, abs=1)


@pytest.mark.nightly
def test_sees_the_world_from_where_the_vehicle_is(flying: Any) -> None:
    follower, clock = joined(flying)
    flying.local_target(20.0, -10.0, -15.0, 1.0)
    shots = fly_along(flying, follower, clock, 12.0)
    last, body = shots[-1], flying.autopilot.body
    assert (last.x_east, -last.y_south) == pytest.approx((body.position[1], body.position[0]), abs=0.1)
    assert last.height == pytest.approx(body.height, abs=0.1)
    assert last.yaw == pytest.approx(body.yaw, abs=0.02)
    assert last.stamp == pytest.approx(flying.autopilot.time_boot, abs=0.1)


@pytest.mark.slow
def test_a_moving_vehicle_is_followed_between_its_positions(flying: Any) -> None:
    follower, clock = joined(flying)
    flying.local_target(60.0, 0.0, -12.0)
    shots = fly_along(flying, follower, clock, 6.0)[-20:]
    steps = [(b.y_south - a.y_south) / (b.stamp - a.stamp) for a, b in itertools.pairwise(shots)]
    assert min(steps) == pytest.approx(-5.0, abs=0.6)
    assert max(steps) == pytest.approx(-5.0, abs=0.6)


def test_nothing_is_shot_without_a_position(station: Any) -> None:
    follower, _ = joined(station)
    encoder = mavlink.MAVLink(None, 1, 1)
    follower.receive(bytes(mavlink.MAVLink_attitude_message(1000, 0, 0, 0, 0, 0, 0).pack(encoder)))
    assert follower.shots() == []
    assert follower.last is None


def test_a_stale_position_is_not_used() -> None:
    follower = Follower(Origin(), HandClock())
    encoder = mavlink.MAVLink(None, 1, 1)
    position = mavlink.MAVLink_global_position_int_message(1000, 432609000, -799192000, 0, 10_000, 0, 0, 0, 0)
    follower.receive(bytes(position.pack(encoder)))
    follower.receive(bytes(mavlink.MAVLink_attitude_message(2500, 0, 0, 0, 0, 0, 0).pack(encoder)))
    assert follower.shots() == []
    follower.receive(bytes(mavlink.MAVLink_attitude_message(1050, 0, 0, 0, 0, 0, 0).pack(encoder)))
    assert len(follower.shots()) == 1


@pytest.mark.slow
def test_a_reboot_of_the_vehicle_is_followed(flying: Any) -> None:
    follower, clock = joined(flying)
    fly_along(flying, follower, clock, 3.0)
    flying.autopilot.boot()
    shots = fly_along(flying, follower, clock, 6.0)
    assert shots[-1].stamp == pytest.approx(6.0, abs=0.2)
    assert math.isfinite(shots[-1].height)


def test_garbage_is_survived() -> None:
    follower = Follower(Origin(), HandClock())
    follower.receive(b"\xfd\xff garbage " * 20)
    assert follower.shots() == []


ZEROS = dict.fromkeys(
    ("q1", "q2", "q3", "q4", "roll", "pitch", "xacc", "yacc", "zacc", "xgyro", "ygyro", "zgyro", "lat",
     "lon", "std_dev_horz", "std_dev_vert", "vn", "ve", "vd"), 0.0,
)  # fmt: skip
"""Fields of SIM_STATE that nobody reads."""


@pytest.mark.slow
def test_a_position_that_is_older_than_the_truth_is_no_error_of_the_estimate() -> None:
    """At 4 m/s, with positions ten times a second: the camera sees from the place of its moment."""
    origin, follower = Origin(), Follower(Origin(), HandClock())
    vehicle = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)

    def hear(message: Any) -> None:
        follower.receive(bytes(message.pack(vehicle)))

    worst = 0.0
    for ms in range(1000, 9000, 20):
        north = 4.0 * ms * 1e-3
        latitude, longitude, _ = origin.to_geodetic((north, 0.0, 0.0))
        lat, lon = round(latitude * 1e7), round(longitude * 1e7)
        if ms % 100 == 0:
            hear(mavlink.MAVLink_global_position_int_message(ms, lat, lon, 0, 20_000, 400, 0, 0, 0))
        hear(mavlink.MAVLink_attitude_message(ms, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
        if ms % 60 == 0:
            known = {"lat_int": lat, "lon_int": lon}
            hear(mavlink.MAVLink_sim_state_message(**ZEROS, yaw=0.0, alt=origin.altitude + 20.0, **known))
        for shot in follower.shots():
            worst = max(worst, abs(-shot.y_south - 4.0 * shot.stamp))
    assert worst < 0.05


@pytest.mark.parametrize(("looks", "away"), [(1, 0.0), (2, 0.0), (3, 6.0)])
def test_a_leap_of_the_estimate_must_be_seen_three_times(looks: int, away: float) -> None:
    origin, follower = Origin(), Follower(Origin(), HandClock())
    vehicle = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)

    def hear(message: Any) -> None:
        follower.receive(bytes(message.pack(vehicle)))

    def look(ms: int, true_north: float) -> float:
        latitude, longitude, _ = origin.to_geodetic((0.0, 0.0, 0.0))
        place = (round(latitude * 1e7), round(longitude * 1e7))
        hear(mavlink.MAVLink_global_position_int_message(ms, *place, 0, 20_000, 0, 0, 0, 0))
        latitude, longitude, _ = origin.to_geodetic((true_north, 0.0, 0.0))
        known = {"lat_int": round(latitude * 1e7), "lon_int": round(longitude * 1e7)}
        hear(mavlink.MAVLink_attitude_message(ms, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
        hear(mavlink.MAVLink_sim_state_message(**ZEROS, yaw=0.0, alt=origin.altitude + 20.0, **known))
        hear(mavlink.MAVLink_attitude_message(ms + 99, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
        return -follower.shots()[-1].y_south

    for k in range(10):
        look(1000 + 100 * k, 0.0)
    for k in range(looks):
        seen = look(2000 + 100 * k, 6.0)
    assert seen == pytest.approx(away, abs=0.1)


def test_a_simulated_vehicle_whose_sensors_lie_is_followed_to_its_true_place() -> None:
    """GNSS is 12 m off, the barometer 9 m high and the compasses 0.4 rad: the camera sees from where it truly is."""
    origin, follower = Origin(), Follower(Origin(), HandClock())
    vehicle = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)

    def hear(message: Any) -> None:
        follower.receive(bytes(message.pack(vehicle)))

    def fly(reported: tuple[float, float, float], true: tuple[float, float, float], since: int, count: int) -> Any:
        for k in range(count):
            ms = since + 50 * k
            latitude, longitude, _ = origin.to_geodetic((reported[0], reported[1], 0.0))
            hear(
                mavlink.MAVLink_global_position_int_message(
                    ms, round(latitude * 1e7), round(longitude * 1e7), 0, round(reported[2] * 1e3), 0, 0, 0, 0
                )
            )
            latitude, longitude, _ = origin.to_geodetic((true[0], true[1], 0.0))
            known = {"lat_int": round(latitude * 1e7), "lon_int": round(longitude * 1e7)}
            hear(mavlink.MAVLink_sim_state_message(**ZEROS, yaw=0.6, alt=origin.altitude + true[2], **known))
            hear(mavlink.MAVLink_attitude_message(ms, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0))
        return follower.shots()[-1]

    shot = fly((0.0, 0.0, 20.0), (0.0, 0.0, 20.0), 1000, 20)
    assert (shot.x_east, shot.y_south, shot.height) == pytest.approx((0.0, 0.0, 20.0), abs=0.05)
    shot = fly((0.0, 0.0, 20.0), (-12.0, 3.0, 11.0), 2000, 20)
    assert (shot.x_east, shot.y_south, shot.height) == pytest.approx((3.0, 12.0, 11.0), abs=0.05)
    assert shot.yaw == pytest.approx(0.6, abs=0.02)
    shot = fly((0.0, 0.0, 20.0), (-11.0, 3.0, 11.0), 3000, 30)
    assert shot.y_south == pytest.approx(11.0, abs=0.05), "a walk is followed, too"
