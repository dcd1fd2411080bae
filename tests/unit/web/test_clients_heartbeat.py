from __future__ import annotations

import json
import math
from dataclasses import fields, replace
from typing import Any

import pytest
from pydantic import ValidationError

from hawk.comm.protocol.base import wire_key
from hawk.comm.protocol.heartbeat import (
    DroneStatus,
    FenceCorner,
    FenceSetup,
    Heartbeat,
    LogEntry,
    OperationStatus,
    OutlineSetup,
    PartsStatus,
    Point,
    PoseStatus,
    SharedHeartbeat,
    SiteStatus,
    StatusStamp,
)
from hawk.model.known_lot import FlownCount, FlownSection
from hawk.model.lot_map import OccupancyMap
from hawk.model.operation import HealthStatus, StateName, UserError
from hawk.model.poses import MapPoint
from hawk.web.clients import LOG_LIMIT, SECTION_LIMIT, TRAIL_LIMIT, ClientView
from hawk.web.sessions import ControlView

CONTROL = ControlView("Operator 1", in_control=True)


def beat(view: ClientView, status: DroneStatus, current: OccupancyMap | None = None) -> dict[str, Any]:
    text = view.heartbeat(status, current, CONTROL)
    Heartbeat.model_validate_json(text)
    found: dict[str, Any] = json.loads(text)
    return found


def section(number: int, parked: int | None) -> FlownSection:
    count = None if parked is None else FlownCount(parked, parked, parked + 2, None, 1.0, 0.0)
    return FlownSection(f"s{number}", f"Kerb {number}", ((0.0, 0.0), (0.0, 9.0), (2.0, 9.0)), 8, count)


def news(view: ClientView, sections: tuple[FlownSection, ...]) -> tuple[list[tuple[str, int | None]], list[str]] | None:
    found = json.loads(view.heartbeat(DroneStatus(), None, CONTROL, sections))["Sections"]
    return None if found is None else ([(each["Id"], each["Parked"]) for each in found["Changed"]], found["Removed"])


def test_a_section_comes_when_it_is_new_or_counted_otherwise_and_goes_when_it_is_no_more() -> None:
    view = ClientView()
    first = (section(1, 3), section(2, None))
    assert news(view, ()) is None
    assert news(view, first) == ([("s1", 3), ("s2", None)], [])
    assert news(view, first) is None
    assert news(view, (section(1, 3), section(2, 5))) == ([("s2", 5)], [])
    assert news(view, (section(2, 5),)) == ([], ["s1"])
    assert news(view, (section(2, 5), section(1, 3))) == ([("s1", 3)], [])
    assert news(view, ()) == ([], ["s2", "s1"])
    assert news(view, ()) is None


def test_more_sections_than_one_heartbeat_takes_come_with_the_next_ones() -> None:
    view, sections = ClientView(), tuple(section(number, 1) for number in range(2 * SECTION_LIMIT + 1))
    sizes = [news(view, sections) for _ in range(4)]
    assert [each and len(each[0]) for each in sizes] == [SECTION_LIMIT, SECTION_LIMIT, 1, None]


def test_a_section_is_sent_with_its_ring_and_its_whole_count() -> None:
    (sent,) = json.loads(ClientView().heartbeat(DroneStatus(), None, CONTROL, (section(1, 3),)))["Sections"]["Changed"]
    assert sent == {
        "Id": "s1", "Name": "Kerb 1", "Capacity": 8, "Parked": 3, "Least": 3, "Most": 5, "Room": None,
        "Seen Share": 1.0, "Hidden Share": 0.0,
        "Outline": [{"North": 0.0, "East": 0.0}, {"North": 0.0, "East": 9.0}, {"North": 2.0, "East": 9.0}],
    }  # fmt: skip


def entry(number: int) -> LogEntry:
    return LogEntry(number=number, time="2026-01-01T00:00:00Z", level="info", text=f"entry {number}")


def test_every_part_of_the_status_is_in_the_heartbeat() -> None:
    sent = beat(ClientView(), DroneStatus())
    assert set(sent) == {wire_key(name) for name in Heartbeat.model_fields} - {"Sentences"}  # there are none
    parts = [
        f.name
        for f in fields(DroneStatus)
        if f.name not in ("fence_setup", "outline_setup", "log", "trail", "trail_id")
    ]
    names = [name for part in parts for name in type(getattr(DroneStatus(), part)).model_fields]
    assert sorted(names) == sorted(set(SharedHeartbeat.model_fields) - {"type", "sentences"})


def test_values_arrive_under_their_keys() -> None:
    status = DroneStatus(
        operation=OperationStatus(state=StateName.LAND, user_error=UserError.NO_LOT_DETECTED),
        parts=PartsStatus(health_status=HealthStatus.UNHEALTHY),
        site=SiteStatus(
            home=Point(north=1.0, east=2.0),
            fence=tuple(Point(north=n, east=e) for n, e in ((0.0, 0.0), (9.0, 0.0), (9.0, 9.0))),
            datum=(43.0, -79.0),
        ),
        pose=PoseStatus(yaw=1.5),
    )
    sent = beat(ClientView(), status)
    assert (sent["State"], sent["User Error"], sent["Health Status"]) == ("Land", 2, 1)
    assert sent["Home"] == {"North": 1.0, "East": 2.0}
    assert len(sent["Fence"]) == 3
    assert sent["Datum"] == [43.0, -79.0]
    assert sent["Heights"] == [15.0, 35.0, 60.0]
    assert (sent["Controller"], sent["In Control"]) == ("Operator 1", True)
    assert (sent["Controller Lost"], sent["Control Taken By"]) == (False, None)


def test_local_position_x_and_y_are_not_swapped() -> None:
    sent = beat(ClientView(), DroneStatus(pose=PoseStatus(local_position_x=3.0, local_position_y=-7.0)))
    assert (sent["Local Position X"], sent["Local Position Y"]) == (3.0, -7.0)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_not_finite_is_null(value: float) -> None:
    sent = beat(
        ClientView(), DroneStatus(pose=PoseStatus(speed=value), trail=(MapPoint(1.0, value), MapPoint(1.0, 1.0)))
    )
    assert sent["Speed"] is None
    assert sent["Trail"] == [{"North": 1.0, "East": 1.0}]


def test_heights_that_are_not_finite_are_no_status() -> None:
    with pytest.raises(ValidationError):
        SiteStatus(heights=(math.nan, 1.0, 2.0))


def setup(problem: str = "") -> FenceSetup:
    return FenceSetup(
        source="drawn",
        corners=[FenceCorner(latitude=43.0, longitude=-79.0)] * 3,
        inner=[],
        radius=None,
        ceiling=80.0,
        margin=5.0,
        ceiling_margin=3.0,
        highest_ceiling=100.0,
        problem=problem,
    )


def test_the_fence_that_the_next_arm_takes_comes_once_after_each_change_to_each_client() -> None:
    one, other, first, second = ClientView(), ClientView(), setup(), setup("cannot be read")
    assert beat(one, DroneStatus(fence_setup=first))["Fence Setup"]["Corners"][0] == {
        "Latitude": 43.0,
        "Longitude": -79.0,
    }
    assert beat(one, DroneStatus(fence_setup=first))["Fence Setup"] is None
    assert beat(other, DroneStatus(fence_setup=first))["Fence Setup"]["Ceiling"] == 80.0
    assert beat(one, DroneStatus(fence_setup=second))["Fence Setup"]["Problem"] == "cannot be read"


def test_the_outline_comes_once_after_each_change_to_each_client() -> None:
    one, other = ClientView(), ClientView()
    first = OutlineSetup(
        source="set", polygons=[[FenceCorner(latitude=43.0, longitude=-79.0)] * 3], holes=[], area=80.0
    )
    second = OutlineSetup(source="none", polygons=[], holes=[], area=0.0)
    assert beat(one, DroneStatus(outline_setup=first))["Outline Setup"]["Area"] == 80.0
    assert beat(one, DroneStatus(outline_setup=first))["Outline Setup"] is None
    assert beat(other, DroneStatus(outline_setup=first))["Outline Setup"]["Source"] == "set"
    assert beat(one, DroneStatus(outline_setup=second))["Outline Setup"]["Polygons"] == []


def test_log_entries_come_once_and_in_order() -> None:
    view = ClientView()
    assert [m["Number"] for m in beat(view, DroneStatus(log=(entry(1), entry(2))))["Messages"]] == [1, 2]
    assert beat(view, DroneStatus(log=(entry(1), entry(2))))["Messages"] == []
    assert [m["Number"] for m in beat(view, DroneStatus(log=(entry(2), entry(3))))["Messages"]] == [3]


def test_a_long_log_comes_in_parts() -> None:
    view, got = ClientView(), []
    status = DroneStatus(log=tuple(entry(n) for n in range(2 * LOG_LIMIT + 5)))
    for _ in range(3):
        got += [m["Number"] for m in beat(view, status)["Messages"]]
    assert got == list(range(2 * LOG_LIMIT + 5))


def test_trail_points_come_once_until_another_trail_begins() -> None:
    view = ClientView()
    trail = tuple(MapPoint(float(n), 0.0) for n in range(TRAIL_LIMIT + 3))
    first = beat(view, DroneStatus(trail=trail, trail_id=4))
    assert first["Trail Start"] is True
    second = beat(view, DroneStatus(trail=trail, trail_id=4))
    assert second["Trail Start"] is False
    assert len(first["Trail"]) + len(second["Trail"]) == len(trail)
    assert beat(view, DroneStatus(trail=trail, trail_id=4))["Trail"] == []
    third = beat(view, DroneStatus(trail=trail[:1], trail_id=5))
    assert (third["Trail Start"], third["Trail"]) == (True, [{"North": 0.0, "East": 0.0}])


def test_the_shared_part_is_built_once_a_status() -> None:
    status = DroneStatus()
    assert status.shared_json is status.shared_json
    other = replace(status, stamp=StatusStamp(sequence=1))
    assert json.loads(other.shared_json)["Sequence"] == 1


def test_one_client_does_not_change_what_another_is_sent() -> None:
    status = DroneStatus(log=(entry(1),))
    one, two = ClientView(), ClientView()
    for view in (one, two):
        sent = json.loads(view.heartbeat(status, None, ControlView()))
        assert len(sent["Messages"]) == 1
    assert "Messages" not in json.loads(status.shared_json)
