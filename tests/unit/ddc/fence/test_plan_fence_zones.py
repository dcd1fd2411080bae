"""A drawn fence with exclusion zones, through the whole of the drone's control: kept, uploaded, guarded."""

from __future__ import annotations

import itertools
import json
from pathlib import Path

import pytest

from hawk.comm.protocol.commands import (
    Arm,
    AutonomousExplore,
    AutonomousMove,
    CheckFence,
    CompulsiveMove,
    FenceCheck,
    SetFence,
)
from hawk.comm.protocol.heartbeat import FenceCorner
from hawk.config.sections import FenceSettings
from hawk.ddc.fence.geometry import FenceError, Ring, contains, outside_by, ring_from_map, ring_to_map, zone_of
from hawk.ddc.fence.keepers import FENCE_FILE
from hawk.ddc.settings import DdcSettings
from hawk.model.operation import StateName
from hawk.model.plans import Fence
from hawk.model.poses import MapPoint
from tests.unit.ddc.fakes import PLACE, Rig

SQUARE = ((-60.0, -60.0), (60.0, -60.0), (60.0, 60.0), (-60.0, 60.0))


def box(south: float, west: float, north: float, east: float) -> Ring:
    return ((south, west), (north, west), (north, east), (south, east))


ROOF, MAST = box(20, -15, 40, 15), ((-30.0, -30.0), (-26.0, -30.0), (-28.0, -26.0))
"""The drone stands at (0, 0): the roof lies 20 m north of it."""


def corners(ring: Ring) -> list[FenceCorner]:
    return [FenceCorner(latitude=lat, longitude=lon) for lat, lon in ring_from_map(PLACE, ring)]


def zoned(*zones: Ring, ring: Ring = SQUARE) -> SetFence:
    return SetFence(corners=corners(ring), ceiling=80, zones=[corners(zone) for zone in zones])


def check_of(command: SetFence) -> CheckFence:
    return CheckFence(corners=command.corners, ceiling=command.ceiling, zones=command.zones)


async def draw(rig: Rig, command: SetFence) -> None:
    rig.order(command)
    await rig.manager.requests.finish()
    await rig.tick()
    rig.expect(StateName.IDLE)


@pytest.fixture
async def aloft(rig: Rig) -> Rig:
    """A drone in the air, south of a roof that it keeps out of."""
    await draw(rig, zoned(ROOF, MAST))
    rig.order(Arm())
    await rig.until(StateName.ARM)
    await rig.run(0.5)
    rig.autopilot.put_in_air()
    await rig.run(0.5)
    rig.expect(StateName.HOVER)
    return rig


# -- kept and uploaded ------------------------------------------------------------------------------------------------


async def test_zones_are_uploaded_with_the_fence_and_guarded_with_our_margin(rig: Rig) -> None:
    await draw(rig, zoned(ROOF, MAST))
    rig.order(Arm())
    await rig.run(0.5)
    uploaded = rig.autopilot.asked("upload_fence")[-1]
    assert isinstance(uploaded, Fence)
    assert [len(zone) for zone in uploaded.autopilot_zones] == [4, 3]
    for corner, wanted in zip(uploaded.autopilot_zones[0], ROOF, strict=True):
        assert corner == pytest.approx(wanted, abs=0.01)
    assert rig.fence == uploaded
    assert not contains(uploaded, MapPoint(16, 0))
    assert contains(uploaded, MapPoint(14, 0))


async def test_operators_see_the_zones_of_the_plan_and_those_in_force(aloft: Rig) -> None:
    setup = aloft.manager.fences.setup
    assert [len(zone) for zone in setup.zones] == [4, 3]
    assert len(setup.inner_zones) == 2
    site = aloft.shown.site
    assert [len(zone) for zone in site.fence_zone_limits] == [4, 3]
    assert min(point.north for point in site.fence_zones[0]) == pytest.approx(15, abs=0.01)
    assert min(point.north for point in site.fence_zone_limits[0]) == pytest.approx(20, abs=0.01)


async def test_a_later_start_takes_the_zones_up_from_interior_rings(rig: Rig, tmp_path: Path) -> None:
    await draw(rig, zoned(ROOF, MAST))
    coordinates = json.loads((tmp_path / FENCE_FILE).read_text())["geometry"]["coordinates"]
    assert [len(ring) for ring in coordinates] == [5, 5, 4]
    turns = [sum((b[0] - a[0]) * (b[1] + a[1]) for a, b in itertools.pairwise(ring)) for ring in coordinates]
    assert [turn < 0 for turn in turns] == [True, False, False], "RFC 7946: the outer ring counterclockwise"
    again = Rig(tmp_path)
    await again.run(2)
    assert (again.manager.fences.setup.problem, len(again.manager.fences.plan.zones)) == ("", 2)
    again.order(Arm())
    await again.run(0.5)
    assert again.fence is not None
    assert not contains(again.fence, MapPoint(30, 0))
    await again.close()


async def test_a_file_without_zones_loads_as_before(rig: Rig, tmp_path: Path) -> None:
    """The file as version 0.2 wrote it."""
    ring = [[lon, lat] for lat, lon in ring_from_map(PLACE, SQUARE)]
    feature = {"type": "Feature", "properties": {"name": "fence", "ceiling_m": 70.0},
               "geometry": {"type": "Polygon", "coordinates": [[*ring, ring[0]]]}}  # fmt: skip
    (tmp_path / FENCE_FILE).write_text(json.dumps(feature))
    again = Rig(tmp_path)
    await again.run(2)
    setup = again.manager.fences.setup
    assert (setup.source, setup.ceiling, setup.zones, setup.problem) == ("drawn", 70, [], "")
    await again.close()


@pytest.mark.parametrize(
    ("zones", "words"),
    [
        ([box(50, 0, 70, 10)], "Zone 1: crosses the fence's edge"),
        ([[(0.0, 0.0), (1.0, 1.0)]], r"coordinates\[1\]: has 2 corners"),
    ],
)
async def test_a_kept_file_with_a_bad_zone_keeps_the_drone_on_the_ground(
    tmp_path: Path, zones: list[Ring], words: str
) -> None:
    rings = [[[lon, lat] for lat, lon in ring_from_map(PLACE, tuple(ring))] for ring in (SQUARE, *zones)]
    (tmp_path / FENCE_FILE).write_text(json.dumps({"type": "Polygon", "coordinates": rings}))
    rig = Rig(tmp_path)
    await rig.run(2)
    assert not rig.command(Arm()).accepted
    with pytest.raises(FenceError, match=words):
        raise FenceError(rig.manager.fences.problem)
    await rig.close()


async def test_zones_of_the_configured_file_count_too(tmp_path: Path) -> None:
    path = tmp_path / "configured.geojson"
    ring, zone = ([[lon, lat] for lat, lon in ring_from_map(PLACE, each)] for each in (SQUARE, ROOF))
    features = [
        {"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [ring]}},
        {"type": "Feature", "properties": {"exclusion": True}, "geometry": {"type": "Polygon", "coordinates": [zone]}},
    ]
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    rig = Rig(tmp_path / "store", settings=DdcSettings(fence=FenceSettings(file=path)))
    await rig.run(2)
    rig.order(Arm())
    await rig.run(0.5)
    assert rig.fence is not None
    assert zone_of(rig.fence, MapPoint(30, 0)) == 1
    await rig.close()


# -- refused ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (zoned(box(50, 0, 70, 10)), "Zone 1: crosses the fence's edge: move its corners inside the fence."),
        (zoned(ROOF, box(70, 0, 80, 10)), "Zone 2: lies outside the fence: "),
        (zoned(ROOF, box(30, 0, 50, 20)), "Zone 2: it crosses or holds zone 1: "),
        (zoned(((20, 0), (40, 20), (40, 0), (20, 20))), "Zone 1: the sides 1-2 and 3-4 cross: "),
        (zoned(box(20, 0, 20.7, 0.7)), "Zone 1: it holds 0.5 m², too little to be meant: "),
        (zoned(box(10, -58, 30, 58)), "Zone 1: with 5 m around it, it cuts 2200 m² off the inside of the fence: "),
    ],
)
async def test_a_zone_that_cannot_be_is_refused_with_field_and_remedy(rig: Rig, command: SetFence, words: str) -> None:
    answer = rig.command(command)
    assert not answer.accepted
    assert answer.reason.startswith(words)
    assert rig.manager.fences.setup.source == "circle"
    check = await rig.check_fence(check_of(command), "eve")
    assert isinstance(check, FenceCheck)
    assert check.problem == answer.reason, "what is said while drawing is what is said when saving"


@pytest.mark.fault("the drone stands in a zone or its margin", "Arm is refused")
async def test_a_drone_in_a_zone_is_not_armed(rig: Rig) -> None:
    command = zoned(MAST, box(-8, -8, 12, 12))
    check = await rig.check_fence(check_of(command))
    assert isinstance(check, FenceCheck)
    assert (check.problem, check.notes) == ("", ["The drone stands 13 m inside the dotted line of zone 2: it could "
                                                 "not be armed there."])  # fmt: skip
    await draw(rig, command)
    await rig.run(1)
    answer = rig.command(Arm())
    assert not answer.accepted
    assert "inside the dotted line of zone 2" in answer.reason
    assert rig.autopilot.asked("upload_fence") == []


@pytest.mark.fault("the drone stands in a zone or its margin")
async def test_a_drone_in_the_margin_of_a_zone_is_not_armed(rig: Rig) -> None:
    await draw(rig, zoned(box(3, -8, 12, 12)))
    await rig.run(1)
    assert "inside the dotted line of zone 1" in rig.command(Arm()).reason


async def test_a_check_shows_zones_area_and_that_the_path_home_is_not_free(rig: Rig) -> None:
    check = await rig.check_fence(check_of(zoned(ROOF)))
    assert isinstance(check, FenceCheck)
    assert check.area == pytest.approx(120 * 120 - 20 * 30, rel=1e-3)
    assert check.notes == [
        "From parts of it the straight path home crosses a zone. Our returns stay inside; the autopilot's own "
        "failsafes "
        "(lost link, its battery failsafe, a dead companion computer) fly straight."
    ]
    (inner,) = check.inner_zones
    ring = ring_to_map(PLACE, tuple((each.latitude, each.longitude) for each in inner))
    assert min(north for north, _ in ring) == pytest.approx(15, abs=0.01)


# -- in the air -------------------------------------------------------------------------------------------------------


@pytest.mark.fault(
    "a move into a zone or across one; a planner that points there",
    "refused; nothing is sent, Hover after 10 s",
)
async def test_a_move_into_a_zone_or_straight_across_one_is_refused(aloft: Rig) -> None:
    into = aloft.command(CompulsiveMove(x=30, y=0, frame="Map"))
    assert into.reason == "X, Y: the place is in zone 1 or its margin: choose one inside."
    across = aloft.command(CompulsiveMove(x=50, y=0, frame="Map"))
    assert across.reason == (
        "X, Y: the straight path there leaves the fence or crosses a zone: go around it in two moves."
    )
    assert not aloft.command(AutonomousMove(x=30, y=0, frame="Map")).accepted
    aloft.expect(StateName.HOVER)
    aloft.order(CompulsiveMove(x=0, y=-40, frame="Map"))


@pytest.mark.slow
@pytest.mark.fault("a move into a zone or across one; a planner that points there")
async def test_a_planner_that_points_into_or_across_a_zone_is_not_followed(aloft: Rig) -> None:
    for north in (30.0, 50.0):
        aloft.target_plan(north, 0.0)
        aloft.order(AutonomousExplore())
        sent = len(aloft.autopilot.targets)
        await aloft.run(5)
        assert len(aloft.autopilot.targets) == sent
        assert aloft.autopilot.north == pytest.approx(0, abs=1)
        await aloft.until(StateName.HOVER, 20)
    assert any("leaves the fence or crosses a zone" in text for text in aloft.log)


@pytest.mark.slow
async def test_no_tick_of_a_flight_around_a_zone_sends_a_target_into_it(aloft: Rig) -> None:
    for north, east in ((0, -40), (50, -40), (50, 40)):
        aloft.order(CompulsiveMove(x=north, y=east, frame="Map"))
        await aloft.run(0.2)
        await aloft.until(StateName.HOVER, 60)
        assert (aloft.autopilot.north, aloft.autopilot.east) == pytest.approx((north, east), abs=2)
    fence = aloft.fence
    assert fence is not None
    assert all(contains(fence, MapPoint(t.north, t.east)) for t in aloft.autopilot.targets)


@pytest.mark.slow
@pytest.mark.fault(
    "the wind carries the drone into a zone",
    "led out at the nearest edge, never deeper; Return To Launch after 10 s in it",
)
@pytest.mark.parametrize(("north", "east"), [(22.0, 3.0), (30.0, 12.0), (16.0, -18.0)])
async def test_a_drone_that_the_wind_carries_into_a_zone_is_led_out_at_the_nearest_edge(
    aloft: Rig, north: float, east: float
) -> None:
    fence = aloft.fence
    assert fence is not None
    deep = outside_by(fence, MapPoint(north, east))
    assert deep > 0.5
    aloft.autopilot.north, aloft.autopilot.east = north, east
    sent = len(aloft.autopilot.targets)
    await aloft.run(0.2)
    assert aloft.manager.situation().facts.is_breached
    assert aloft.detail == "In zone 1 or its margin: going out of it."
    assert aloft.command(CompulsiveMove(x=-20, y=0, frame="Map")).reason.startswith("Outside the fence")
    await aloft.run(9)
    aloft.expect(StateName.HOVER)
    here = MapPoint(aloft.autopilot.north, aloft.autopilot.east)
    assert contains(fence, here)
    assert here.distance(MapPoint(north, east)) < deep + 2 + 1
    depths = [outside_by(fence, MapPoint(t.north, t.east)) for t in aloft.autopilot.targets[sent:]]
    assert max(depths) <= deep + 0.01
    assert "In zone 1 or its margin: going out of it." in aloft.log


@pytest.mark.slow
@pytest.mark.fault("the wind carries the drone into a zone")
async def test_a_drone_that_cannot_leave_a_zone_returns_home(aloft: Rig) -> None:
    for _ in range(11 * 20):
        aloft.autopilot.north, aloft.autopilot.east = 30.0, 0.0
        await aloft.tick()
    aloft.expect(StateName.RETURN_TO_LAUNCH)
