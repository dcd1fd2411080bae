"""Rows: autopilot silent, reconnect, set-points to a dead link, link cut, ground-station failsafe."""

from __future__ import annotations

import math
import time

import pytest
from mavsdk.logging import log_subscribe, log_unsubscribe
from mavsdk.plugins.action import ActionError
from mavsdk.plugins.offboard import Offboard, VelocityNedYaw

from tests.contract.vehicle import GUIDED, HEIGHT, RTL, Vehicle

pytestmark = pytest.mark.contract


def test_a_silent_autopilot_is_noticed_commands_time_out_and_the_cache_stays(grounded: Vehicle) -> None:
    pilot = grounded.pilot
    position = pilot.telemetry.position()
    with grounded.cut():
        assert 1.5 < pilot.wait(lambda: not pilot.system.is_connected(), 10.0) < 5.0
        began = time.monotonic()
        with pytest.raises(ActionError, match="TIMEOUT"):
            pilot.action.arm()
        assert 1.5 < time.monotonic() - began < 4.5
        assert abs(pilot.telemetry.position().latitude_deg - position.latitude_deg) < 1e-4
    pilot.wait(pilot.system.is_connected, 5.0)


def test_a_connection_that_was_added_again_recovers_and_subscriptions_survive(grounded: Vehicle) -> None:
    pilot = grounded.pilot
    pilot._mavsdk.remove_connection(pilot.connection)
    pilot.pause(1.0)
    before = dict(pilot.counts)
    pilot.connection = pilot._mavsdk.add_any_connection_with_handle(grounded.relay.url)
    names = ("HEARTBEAT", "LOCAL_POSITION_NED")
    assert pilot.wait(lambda: all(pilot.counts[name] > before[name] for name in names), 10.0) < 3.0
    assert pilot.command(176, 1, 0) == 0


def test_set_points_to_a_dead_link_are_logged_one_by_one(grounded: Vehicle) -> None:
    pilot = grounded.pilot
    lines: list[str] = []

    def take(_level: object, text: str, _file: object, _line: object) -> bool:
        lines.append(text)
        return True

    with grounded.cut():
        pilot._mavsdk.remove_connection(pilot.connection)
        pilot.connection = pilot._mavsdk.add_any_connection_with_handle(grounded.relay.url)
        log_subscribe(take)
        try:
            for _ in range(5):
                pilot.target(0.0, 0.0, -5.0)
            pilot.wait(lambda: len([line for line in lines if "Sending message failed" in line]) >= 5, 5.0)
        finally:
            log_unsubscribe()


def test_a_velocity_goes_on_for_three_seconds_after_a_cut_and_resumes_after_it(flying: Vehicle) -> None:
    offboard = Offboard(flying.pilot.system)
    offboard.set_velocity_ned(VelocityNedYaw(3.0, 0.0, 0.0, 0.0))
    offboard.start()
    flying.wait(lambda: flying.velocity[0] > 2.5, 10.0)
    with flying.cut():
        before = flying.place[0]
        flying.let_pass(10.0)
    offboard.set_velocity_ned(VelocityNedYaw(0.0, 0.0, 0.0, 0.0))
    since = flying.pilot.counts["LOCAL_POSITION_NED"]
    flying.wait(lambda: flying.pilot.counts["LOCAL_POSITION_NED"] > since + 5, 10.0)
    assert 4.0 < flying.place[0] - before < 25.0  # 3 s at 3 m/s, then until it stands
    assert flying.mode == GUIDED
    offboard.stop()


def test_a_position_is_flown_to_although_the_link_is_cut(flying: Vehicle) -> None:
    flying.pilot.target(25.0, 0.0, -HEIGHT)
    flying.wait(lambda: flying.velocity[0] > 1.0, 10.0)
    with flying.cut():
        flying.let_pass(12.0)
    since = flying.pilot.counts["LOCAL_POSITION_NED"]
    flying.wait(lambda: flying.pilot.counts["LOCAL_POSITION_NED"] > since + 5, 10.0)
    assert math.dist(flying.place, (25.0, 0.0, -HEIGHT)) < 1.0
    assert flying.mode == GUIDED


@pytest.mark.fault(
    "link, radio, GPS or battery lost on hawk-sim and on a real ArduCopter",
    "the autopilot does as `tests/contract` states: RTL 3.5 to 7 s after the uplink is cut, RTL without a "
    "radio, LAND without GPS, RTL 10 s below BATT_LOW_VOLT",
)
def test_the_ground_station_failsafe_returns_when_both_ids_are_equal(flying: Vehicle) -> None:
    flying.set({"FS_GCS_ENABLE": 1, flying.gcs_parameter: 245, "FS_OPTIONS": 0})
    flying.go(15.0, 0.0, -HEIGHT)
    flying.pilot.pause(2.5)  # heartbeats with the id that is watched now
    flying.relay.uplink = False
    assert 3.5 < flying.pilot.wait(lambda: flying.mode == RTL, 20.0) < 7.0  # real seconds, as its heartbeats
    flying.wait(lambda: flying.said("GCS Failsafe"), 3.0)
    flying.relay.uplink = True
    flying.wait(lambda: flying.said("GCS Failsafe Cleared"), 10.0 * flying.speed)
