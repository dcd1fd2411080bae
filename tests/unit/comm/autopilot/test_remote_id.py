"""The operator's part of Remote ID: what is sent, when, from where; and what the transmitter says."""

from __future__ import annotations

import asyncio
import math
from typing import Any

import pytest

from hawk.comm.autopilot.remote_id import (
    EPOCH,
    OperatorPlace,
    RemoteIdReport,
    RemoteIdReports,
    fixed_place,
    takeoff_place,
    where,
    who,
)
from hawk.comm.autopilot.remote_id_sender import RemoteIdSender
from hawk.comm.autopilot.vehicle import AutopilotError, VehicleTopics
from hawk.comm.clock import Clock
from hawk.comm.topic import Topic
from hawk.config.sections import RemoteIdSettings
from hawk.model.poses import ArmPlace, GlobalPose, VehiclePose
from hawk.model.vehicle import VehicleState
from hawk.runtime.supervision import Supervisor
from tests.manual_clock import ManualClock
from tests.unit.comm.autopilot.telemetry_rig import Rig

UTC = EPOCH + 250_000_000.5
HERE = GlobalPose(60.1699, 24.9384, 12.0)
SETTINGS = RemoteIdSettings(enabled=True, operator_id="FIN87astrdge12k8")
FIXED = RemoteIdSettings(
    enabled=True,
    operator_id="FIN87astrdge12k8",
    operator_place="fixed",
    operator_latitude_deg=-43.5,
    operator_longitude_deg=172.6,
    operator_height_m=21.5,
    description="parking survey",
    serial_number="1581F4ABC123",
)


class Bench:
    """A sender whose messages are kept, on topics that are filled by hand."""

    def __init__(self, settings: RemoteIdSettings = SETTINGS) -> None:
        self.clock = ManualClock(100.0)
        self.topics = VehicleTopics.create(self.clock)
        self.sent: list[tuple[str, dict[str, Any]]] = []
        self.fails = False
        self.came = asyncio.Event()
        self.sender = RemoteIdSender(settings, self.topics, Clock(10.0), self._send, lambda: UTC)

    async def _send(self, name: str, fields: Any) -> None:
        if self.fails:
            raise AutopilotError("the link is down")
        self.sent.append((name, dict(fields)))
        if len(self.sent) >= 4:
            self.came.set()

    def heard(self, *, armed: bool = False, connected: bool = True) -> None:
        now = self.clock()
        self.topics.state.publish(VehicleState(connected, armed, 4, time=now))

    def stands(self, place: GlobalPose = HERE) -> None:
        pose = VehiclePose(self.clock(), place, None, None, None, (0.0, 0.0, 0.0), 0.0, 0.0, 0.0)
        self.topics.pose.publish(pose)

    async def second(self) -> list[str]:
        self.sent.clear()
        await self.sender.send_once()
        return [name.removeprefix("OPEN_DRONE_ID_") for name, _ in self.sent]

    def place(self) -> tuple[float, float, float]:
        fields = next(fields for name, fields in self.sent if "SYSTEM" in name)
        return fields["operator_latitude"], fields["operator_longitude"], fields["operator_altitude_geo"]


async def test_every_second_says_who_and_where_and_every_fifth_all() -> None:
    bench = Bench()
    bench.heard()
    bench.stands()
    seconds = [await bench.second() for _ in range(7)]
    assert seconds[0] == seconds[5] == ["OPERATOR_ID", "SYSTEM"]
    assert {tuple(second) for second in (*seconds[1:5], seconds[6])} == {("OPERATOR_ID", "SYSTEM_UPDATE")}


async def test_description_and_serial_number_are_sent_where_they_are_configured() -> None:
    bench = Bench(FIXED)
    bench.heard()
    assert await bench.second() == ["OPERATOR_ID", "SELF_ID", "BASIC_ID", "SYSTEM"]
    by_name = dict(bench.sent)
    assert by_name["OPEN_DRONE_ID_OPERATOR_ID"]["operator_id"] == "FIN87astrdge12k8"
    assert by_name["OPEN_DRONE_ID_SELF_ID"]["description"] == "parking survey"
    assert by_name["OPEN_DRONE_ID_SELF_ID"]["description_type"] == 0, "text"
    basic = by_name["OPEN_DRONE_ID_BASIC_ID"]
    assert bytes(basic["uas_id"]) == b"1581F4ABC123".ljust(20, b"\0")
    assert (basic["id_type"], basic["ua_type"]) == (1, 2)
    assert bench.place() == (-435_000_000, 1_726_000_000, 21.5)


def test_the_whole_place_has_type_area_category_and_a_time() -> None:
    name, fields = where(FIXED, OperatorPlace(-43.5, 172.6, None), UTC, whole=True)
    assert name == "OPEN_DRONE_ID_SYSTEM"
    assert fields["operator_location_type"] == 2  # fixed
    assert (fields["area_count"], fields["area_radius"], fields["area_ceiling"], fields["area_floor"]) == (
        1, 0, -1000.0, -1000.0,
    )  # fmt: skip
    assert (fields["category_eu"], fields["class_eu"], fields["classification_type"]) == (0, 0, 0)
    assert fields["timestamp"] == 250_000_000
    assert fields["operator_altitude_geo"] == -1000.0
    assert where(SETTINGS, OperatorPlace(1.0, 2.0, 3.0), 0.0, whole=True)[1]["operator_location_type"] == 0
    assert where(SETTINGS, OperatorPlace(1.0, 2.0, 3.0), 0.0, whole=True)[1]["timestamp"] == 0


async def test_before_take_off_it_is_where_the_drone_stands_then_where_it_was_armed() -> None:
    bench = Bench()
    bench.heard()
    bench.topics.remote_id.publish(RemoteIdReport(geoid_m=17.0))
    bench.stands()
    await bench.second()
    assert bench.place() == (601_699_000, 249_384_000, 29.0)
    bench.heard(armed=True)
    bench.topics.arm_place.publish(ArmPlace(60.0, 25.0, 10.0, 0.0, 0.0, 0.0))
    bench.stands(GlobalPose(60.2, 25.2, 40.0))
    await bench.second()
    assert bench.place() == (600_000_000, 250_000_000, 27.0)


async def test_a_program_that_starts_in_the_air_says_home() -> None:
    bench = Bench()
    bench.heard(armed=True)
    bench.stands(GlobalPose(60.2, 25.2, 40.0))
    assert await bench.second() == ["OPERATOR_ID"]
    bench.topics.home.publish(GlobalPose(60.0, 25.0, 10.0))
    await bench.second()
    assert bench.place()[:2] == (600_000_000, 250_000_000)


async def test_without_a_position_no_place_is_sent() -> None:
    bench = Bench()
    bench.heard()
    assert await bench.second() == ["OPERATOR_ID"]
    bench.stands()
    assert "SYSTEM" in await bench.second()
    bench.clock.advance(3.1)  # it may have been carried elsewhere
    assert await bench.second() == ["OPERATOR_ID"]


@pytest.mark.fault("the operator's place is not known or not finite", "it is not sent; the transmitter says so")
@pytest.mark.parametrize(
    "place",
    [GlobalPose(math.nan, 24.0, 0.0), GlobalPose(60.0, math.inf, 0.0), GlobalPose(0.0, 0.0, 5.0), GlobalPose(91, 0, 0)],
)
async def test_a_place_that_is_none_is_never_sent(place: GlobalPose) -> None:
    bench = Bench()
    bench.heard()
    bench.stands(place)
    assert await bench.second() == ["OPERATOR_ID"]


async def test_a_height_that_is_not_finite_is_never_sent() -> None:
    bench = Bench()
    bench.heard()
    bench.topics.remote_id.publish(RemoteIdReport(geoid_m=17.0))
    bench.stands(GlobalPose(60.0, 25.0, math.nan))
    assert await bench.second() == ["OPERATOR_ID"]


async def test_nothing_is_sent_to_an_autopilot_that_is_not_heard_and_all_when_it_is_back() -> None:
    bench = Bench()
    assert await bench.second() == []
    bench.heard()
    bench.stands()
    await bench.second()
    bench.heard(connected=False)
    assert await bench.second() == []
    bench.heard()
    assert await bench.second() == ["OPERATOR_ID", "SYSTEM"]


async def test_a_failed_send_is_logged_once_and_the_next_second_tries_again(caplog: pytest.LogCaptureFixture) -> None:
    bench = Bench()
    bench.heard()
    bench.stands()
    bench.fails = True
    for _ in range(3):
        assert await bench.second() == []
    assert [record.message for record in caplog.records] == ["Remote ID was not sent: the link is down"]
    bench.fails = False
    assert (await bench.second())[0] == "OPERATOR_ID"


async def test_it_runs_until_cancelled_and_the_supervisor_starts_it_again() -> None:
    bench = Bench()
    bench.heard()
    bench.stands()
    ended: list[str] = []
    supervisor = Supervisor(lambda name, _words: ended.append(name), pause_s=0.0)
    broken = bench.sender.send_once
    calls = 0

    async def once() -> None:
        nonlocal calls
        calls += 1
        if calls == 1:
            raise RuntimeError("a fault of the program")
        await broken()

    bench.sender.send_once = once  # type: ignore[method-assign]
    supervisor.start("remote-id", bench.sender.run)
    async with asyncio.timeout(10.0):
        await bench.came.wait()
    await supervisor.close()
    assert ended == ["remote-id"]


def test_a_fixed_place_is_the_configured_one_only() -> None:
    assert fixed_place(SETTINGS) is None
    assert fixed_place(FIXED) == OperatorPlace(-43.5, 172.6, 21.5)
    assert takeoff_place(HERE, None).height is None


def test_who_without_description_is_the_operator_alone() -> None:
    assert [name for name, _ in who(SETTINGS)] == ["OPEN_DRONE_ID_OPERATOR_ID"]


def reports() -> tuple[Topic[RemoteIdReport], RemoteIdReports]:
    topic: Topic[RemoteIdReport] = Topic("remote_id", ManualClock(0.0))
    return topic, RemoteIdReports(topic)


def test_the_transmitters_word_and_its_error() -> None:
    topic, ear = reports()
    ear.take_arm_status({"status": 1, "error": "missing OP_ID \0\0"}, 4.0)
    assert topic.value == RemoteIdReport(False, "missing OP_ID", 4.0)
    ear.take_arm_status({"status": 0, "error": ""}, 5.0)
    assert topic.value == RemoteIdReport(True, "", 5.0)
    ear.forget()
    assert topic.value == RemoteIdReport()


@pytest.mark.parametrize("status", [2, 255])
def test_a_status_that_is_not_known_is_not_good(status: int) -> None:
    topic, ear = reports()
    ear.take_arm_status({"status": status, "error": ""}, 4.0)
    assert topic.value is not None
    assert topic.value.good is False


@pytest.mark.parametrize(
    ("fields", "geoid"),
    [
        ({"alt": 100_000, "alt_ellipsoid": 64_500}, -35.5),
        ({"alt": 100_000, "alt_ellipsoid": 0}, None),
        ({"alt": 100_000}, None),
        ({"alt": 0, "alt_ellipsoid": 64_500}, None),
    ],
)
def test_sea_level_above_the_ellipsoid_is_the_receivers(fields: dict[str, int], geoid: float | None) -> None:
    topic, ear = reports()
    ear.take_gps(fields)
    assert (None if topic.value is None else topic.value.geoid_m) == geoid


def test_telemetry_hears_the_transmitter_and_forgets_it_at_a_boot() -> None:
    rig = Rig()
    rig.arm_here()
    rig.take(("OPEN_DRONE_ID_ARM_STATUS", {"status": 0, "error": ""}))
    assert rig.topics.remote_id.value == RemoteIdReport(True, "", rig.clock())
    rig.said.boot = 0.0
    rig.fly(0.7)
    assert rig.topics.remote_id.value == RemoteIdReport()


@pytest.mark.parametrize(
    ("latitude", "longitude", "sendable"),
    [(90.0, 180.0, True), (90.1, 0.0, False), (0.0, 180.1, False), (0.0, 0.0, False), (0.0, 1.0, True)],
)
def test_the_bounds_of_a_place(latitude: float, longitude: float, sendable: bool) -> None:
    assert OperatorPlace(latitude, longitude, None).is_sendable is sendable
