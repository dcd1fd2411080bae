from __future__ import annotations

import json
from collections.abc import Mapping
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from hawk.algo.vision.network_file import network_name
from hawk.comm.autopilot.vehicle import VehicleTopics
from hawk.comm.protocol.base import listed
from hawk.comm.protocol.heartbeat import DroneStatus, LogEntry
from hawk.comm.topic import Topic
from hawk.config.sections import Config, StoreSettings
from hawk.daemon.recording_parts import POSE_S, STALLS_S, FlightViews, json_schemas, make_recording
from hawk.model.lot_map import OccupancyMap, Stall, StallState
from hawk.model.poses import GlobalPose, VehiclePose
from hawk.model.sentences import say
from hawk.store.frame_codec import MapStalls, View, Words, to_json
from hawk.store.replay import MESSAGE, ZERO_UTC, read_metadata
from tests.manual_clock import ManualClock

DATUM = GlobalPose(48.0, 11.0, 500.0)
POSE = VehiclePose(1.0, DATUM, 30.0, None, None, (0.0, 0.0, 0.0), 0.0, 0.0, 0.0)


class Shown:
    """Topics, and what the views of them hand to the recording."""

    def __init__(self) -> None:
        self.clock = ManualClock(10.0)
        self.views: list[View] = []
        self.datum: GlobalPose | None = DATUM
        self.vehicle = VehicleTopics.create(self.clock)
        self.status: Topic[DroneStatus] = Topic("status", self.clock)
        self.map: Topic[OccupancyMap] = Topic("map", self.clock)
        self.records: list[tuple[str, Mapping[str, Any]]] = []
        views = FlightViews(self.views.append, lambda *each: self.records.append(each), self.clock, lambda: self.datum)
        views.listen(self.vehicle, self.status, self.map)

    def see(self, version: int, count: int = 1) -> None:
        stalls = {k: Stall(k, 1.0, 2.0, 0.0, 2.5, 5.0, 0.5, StallState.FREE, 0.9, 1, 1.0, 1) for k in range(count)}
        self.map.publish(OccupancyMap(stalls=stalls, version=version, map_id="m"))


def test_poses_are_shown_five_times_a_second() -> None:
    shown = Shown()
    for _ in range(40):
        shown.vehicle.pose.publish(POSE)
        shown.clock.advance(0.05)
    assert 9 <= len(shown.views) <= 11
    assert POSE_S == 0.2


def test_each_message_is_shown_once() -> None:
    shown = Shown()
    entries = [LogEntry(number=n, time="t", level="info", text=f"{n}", details="more") for n in (1, 2, 3)]
    shown.status.publish(DroneStatus(log=tuple(entries[:2])))
    shown.status.publish(DroneStatus(log=tuple(entries)))
    assert shown.views == [Words("info", "1", "more"), Words("info", "2", "more"), Words("info", "3", "more")]
    assert [(topic, message["text"]) for topic, message in shown.records] == [
        (MESSAGE, "1"),
        (MESSAGE, "2"),
        (MESSAGE, "3"),
    ]


def test_a_message_is_recorded_with_its_sentences_for_other_languages() -> None:
    shown = Shown()
    said = listed(LogEntry(number=1, time="t", level="info", text=say("At {height:.0f} m. Holding.", height=20.0)))
    shown.status.publish(DroneStatus(log=(said,)))
    [(_, message)] = shown.records
    assert json.loads(to_json(message))["sentences"] == [
        {"text": "At 20 m. Holding.", "code": "at-height-m-holding", "values": {"height": 20}}
    ]


def test_stalls_are_shown_when_they_changed_and_not_too_often() -> None:
    shown = Shown()
    for version in (1, 2, 2):
        shown.see(version)
    assert len(shown.views) == 1
    shown.clock.advance(STALLS_S)
    shown.see(2)
    shown.see(3)
    assert len(shown.views) == 2
    for _ in range(2):  # the second time nothing changed
        shown.clock.advance(STALLS_S)
        shown.see(3)
    assert [len(view.stalls) for view in shown.views if isinstance(view, MapStalls)] == [1, 1, 1]


def test_a_large_lot_is_shown_less_often() -> None:
    shown = Shown()
    shown.see(1, 2000)
    shown.clock.advance(15.0)
    shown.see(2, 2000)
    assert len(shown.views) == 1
    shown.clock.advance(6.0)
    shown.see(3, 2000)
    assert len(shown.views) == 2


def test_a_map_without_a_place_on_earth_is_not_shown() -> None:
    shown = Shown()
    shown.datum = None
    shown.see(1)
    assert shown.views == []


@pytest.mark.nightly
def test_every_schema_is_one() -> None:
    for schema in json_schemas().values():
        jsonschema.Draft202012Validator.check_schema(schema)
        assert json.loads(json.dumps(schema)) == schema


async def test_a_recording_names_version_configuration_and_speed_but_no_token() -> None:
    config = Config.model_validate({"web": {"token": "a-secret-of-twenty-letters"}})
    recording = make_recording(config, ManualClock(), 3.0, None, lambda: "000001-x", lambda _: None)
    assert recording._metadata["speed"] == "3.0"
    assert "a-secret" not in str(recording._metadata)
    await recording.close()


async def test_a_recording_names_its_survey_and_the_network_that_saw(tmp_path: Path) -> None:
    config = Config(store=StoreSettings(directory=tmp_path, minimum_free_mb=1))
    zero = datetime(2026, 5, 4, 10, tzinfo=UTC)
    recording = make_recording(
        config, ManualClock(10.0), 1.0, None, lambda: "000001-x", lambda at: zero + timedelta(seconds=at)
    )
    recording.begin()
    recording.record("state", {"now": 10.0})
    await recording.close()
    assert recording.path is not None
    found = read_metadata(recording.path)
    assert (found["survey"], found["network"]) == ("000001-x", network_name(None))
    assert len(found["network"]) == 8
    assert found[ZERO_UTC] == "2026-05-04T10:00:00+00:00", "the day that the autopilot knows, a drawn one too"
