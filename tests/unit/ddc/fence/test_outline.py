"""An outline is checked, cut off at the fence, kept with the survey, and never lets the drone leave the fence."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.comm.protocol.commands import Ack, AutonomousExplore, ClearOutline, SetOutline
from hawk.comm.protocol.heartbeat import DroneStatus, FenceCorner
from hawk.config.sections import FlightSettings
from hawk.ddc.fence.geojson import read_survey_outline
from hawk.ddc.fence.geometry import polygon_fence, ring_from_map
from hawk.ddc.fence.outline import OutlineError, check_rings, ground_of, outline_of
from hawk.ddc.settings import DdcSettings, SurveyMemory
from hawk.model.operation import StateName, UserError
from hawk.model.plans import ExploreStatus, Outline, PathPlan
from hawk.model.poses import MapPoint
from tests.unit.ddc.fakes import PLACE, Rig

S = StateName
Ring = tuple[tuple[float, float], ...]


def box(south: float, west: float, north: float, east: float) -> Ring:
    """Return the corners of a box (metres about PLACE) in degrees."""
    return ring_from_map(PLACE, ((south, west), (south, east), (north, east), (north, west)))


def command(*polygons: Ring, holes: tuple[Ring, ...] = ()) -> SetOutline:
    def corners(rings: tuple[Ring, ...]) -> list[list[FenceCorner]]:
        return [[FenceCorner(latitude=latitude, longitude=longitude) for latitude, longitude in ring] for ring in rings]

    return SetOutline(polygons=corners(polygons), holes=corners(holes))


INSIDE = command(box(-20, -20, 30, 40))
BOW_TIE = ring_from_map(PLACE, ((0.0, 0.0), (40.0, 40.0), (40.0, 0.0), (0.0, 40.0)))


def status_of(rig: Rig) -> DroneStatus:
    status = rig.manager.status.value
    assert status is not None
    return status


def reason(rig: Rig, given: SetOutline | ClearOutline | AutonomousExplore) -> str:
    answer = rig.manager.handle("ana", given)
    assert isinstance(answer, Ack)
    assert answer.accepted is (answer.reason == "")
    return answer.reason


# -- geometry ---------------------------------------------------------------------------------------------------------

places = st.tuples(st.floats(-150.0, 150.0), st.floats(-150.0, 150.0))


@pytest.mark.nightly
@settings(max_examples=60, deadline=None)
@given(st.lists(places, min_size=4, max_size=8, unique=True), st.booleans())
def test_what_is_surveyed_lies_in_outline_and_drawn_fence_and_the_rest_is_counted(
    corners: list[tuple[float, float]], has_zone: bool
) -> None:
    hull = shapely.MultiPoint(corners).convex_hull
    if hull.geom_type != "Polygon" or hull.area < 100.0:
        return
    zones = (((-10.0, -10.0), (-10.0, 20.0), (15.0, 20.0), (15.0, -10.0)),) if has_zone else ()
    drawn = shapely.box(-80.0, -60.0, 80.0, 60.0)
    fence = polygon_fence(list(drawn.exterior.coords)[:-1], 5.0, 80.0, 3.0, zones)
    ring = tuple((float(n), float(e)) for n, e in hull.exterior.coords[:-1])
    ground = ground_of(Outline((ring_from_map(PLACE, ring),)), PLACE, fence)
    pieces = shapely.union_all([shapely.Polygon(piece[0], piece[1:]) for piece in ground.pieces])
    allowed = drawn.difference(shapely.union_all([shapely.Polygon(zone) for zone in zones]))
    assert pieces.difference(allowed.buffer(1e-3)).area < 1e-6
    assert pieces.difference(hull.buffer(1e-3)).area < 1e-6
    assert ground.area == pytest.approx(pieces.area, abs=0.1)
    assert ground.area + ground.outside == pytest.approx(hull.area, rel=1e-4, abs=0.1)
    assert ground.area == pytest.approx(hull.intersection(allowed).area, rel=1e-4, abs=0.1)


@pytest.mark.parametrize(
    ("polygons", "holes", "fault"),
    [
        ((BOW_TIE,), (), "Polygon 1: the sides 1-2 and 3-4 cross"),
        ((box(0, 0, 30, 30), BOW_TIE), (), "Polygon 2: the sides"),
        ((box(0, 0, 5, 5),), (), "Polygon 1: holds 25 m²: draw 50 m² at least"),
        ((box(0, 0, 30, 30), box(0, 4500, 30, 4600)), (), "m wide: draw it at most 4000 m wide"),
        ((box(0, 0, 30, 30),), (box(100, 100, 110, 110),), "Hole 1: lies outside every polygon"),
        ((box(0, 0, 30, 30),), (box(-5, -5, 35, 35),), "Holes: they leave 0 m² of the outline"),
    ],
)
def test_an_outline_that_cannot_be_surveyed_is_refused_with_its_fault(
    polygons: tuple[Ring, ...], holes: tuple[Ring, ...], fault: str
) -> None:
    with pytest.raises(OutlineError, match=fault.replace("(", r"\(")):
        check_rings(outline_of(command(*polygons, holes=holes)))


def test_overlapping_polygons_count_once_and_holes_not() -> None:
    outline = outline_of(command(box(0, 0, 30, 30), box(0, 20, 30, 50), holes=(box(10, 10, 20, 20),)))
    assert check_rings(outline) == pytest.approx(30 * 50 - 100, rel=1e-3)


# -- GeoJSON ----------------------------------------------------------------------------------------------------------


def geojson(*features: dict[str, Any]) -> str:
    return json.dumps({"type": "FeatureCollection", "features": list(features)})


def feature(kind: str, coordinates: Any, **properties: Any) -> dict[str, Any]:
    return {"type": "Feature", "properties": properties, "geometry": {"type": kind, "coordinates": coordinates}}


def closed(ring: Ring) -> list[list[float]]:
    return [[longitude, latitude] for latitude, longitude in (*ring, ring[0])]


def test_polygons_multi_polygons_interior_rings_and_exclusions_are_read(tmp_path: Path) -> None:
    file = tmp_path / "lot.geojson"
    one, hole, two, three, exclusion = (
        box(0, 0, 60, 60),
        box(10, 10, 20, 20),
        box(0, 80, 30, 120),
        box(0, 130, 30, 160),
        box(30, 30, 40, 40),
    )
    file.write_text(
        geojson(
            feature("Polygon", [closed(one), closed(hole)]),
            feature("MultiPolygon", [[closed(two)], [closed(three)]]),
            feature("Polygon", [closed(exclusion)], exclusion=True),
        )
    )
    assert read_survey_outline(file) == Outline((one, two, three), (hole, exclusion))


@pytest.mark.parametrize(
    ("content", "fault"),
    [
        ("{", "cannot be read"),
        ("[]", "must hold Polygons"),
        (json.dumps({"type": "Point", "coordinates": [0, 0]}), "must hold Polygons"),
        (json.dumps({"type": "Polygon", "coordinates": []}), "hold no ring"),
        (json.dumps({"type": "Polygon", "coordinates": [closed(BOW_TIE)]}), "sides cross"),
        (json.dumps({"type": "Polygon", "coordinates": [[[0, 0], [1e-4, "x"], [0, 1e-4]]]}), "longitude, latitude"),
        (json.dumps({"type": "Polygon", "coordinates": [[[0, 91], [1e-4, 91], [0, 92]]]}), "not degrees"),
        (geojson(*(feature("Polygon", [closed(box(0, i * 20, 15, i * 20 + 15))]) for i in range(13))), "at most 12"),
    ],
)
def test_a_file_that_is_no_outline_says_why(tmp_path: Path, content: str, fault: str) -> None:
    file = tmp_path / "bad.geojson"
    file.write_text(content)
    with pytest.raises(OutlineError, match=fault) as caught:
        read_survey_outline(file)
    assert str(file) in str(caught.value)


# -- set and cleared --------------------------------------------------------------------------------------------------


async def test_an_outline_is_taken_on_the_ground_reported_with_its_size_and_journalled(tmp_path: Path) -> None:
    kept: list[Outline] = []
    rig = Rig(tmp_path, memory=SurveyMemory(keep_outline=kept.append))
    await rig.run(2.0)
    assert status_of(rig).site.outline_area is None
    assert reason(rig, INSIDE) == ""
    await rig.run(0.5)
    rig.expect(S.IDLE)
    assert kept == [outline_of(INSIDE)]
    assert "The outline is taken: 3000 m²." in rig.log
    setup = status_of(rig).outline_setup
    assert setup is not None
    assert (setup.source, len(setup.polygons)) == ("set", 1)
    assert setup.area == pytest.approx(3000, rel=1e-3)
    assert status_of(rig).site.outline_area == pytest.approx(3000, rel=1e-3)
    assert reason(rig, ClearOutline()) == ""
    await rig.run(0.5)
    assert kept[-1] == Outline()
    assert status_of(rig).site.outline_area is None
    assert reason(rig, ClearOutline()) == "No outline is set."
    await rig.close()


async def test_what_lies_outside_the_fence_is_left_out_and_reported_with_its_size(flying: Rig) -> None:
    """The fence is a circle of 150 m about the arm place."""
    assert reason(flying, command(box(100, -10, 200, 10))) == ""
    await flying.run(0.5)
    outside = status_of(flying).site.outline_outside
    assert outside == pytest.approx(1000, abs=20)
    assert any("outside the fence are left out." in line for line in flying.log)


@pytest.mark.parametrize("state", [S.IDLE, S.HOVER])
async def test_an_outline_outside_the_fence_is_refused(fresh: Rig, state: StateName) -> None:
    await fresh.enter(state)
    refused = reason(fresh, command(box(300, 300, 350, 350)))
    assert refused.startswith("Polygons: nothing of the outline lies inside the fence")
    assert fresh.manager.outlines.outline is None


async def test_it_needs_control_and_waits_while_the_drone_explores(fresh: Rig) -> None:
    await fresh.enter(S.AUTONOMOUS_EXPLORE)
    assert reason(fresh, INSIDE) == "Exploring: Hold first."
    answer = fresh.manager.handle("bob", INSIDE)
    assert isinstance(answer, Ack)
    assert not answer.accepted
    assert fresh.manager.outlines.outline is None


# -- exploring --------------------------------------------------------------------------------------------------------


async def test_with_an_outline_explore_needs_no_lot_in_sight(tmp_path: Path) -> None:
    flying = Rig(tmp_path, settings=replace(DdcSettings(), flight=FlightSettings(explore_lost_lot_s=2.0)))
    await flying.enter(S.HOVER)
    flying.sight.lot = False
    await flying.run(0.5)
    assert reason(flying, AutonomousExplore()).startswith("No lot in sight")
    flying.order(INSIDE)
    await flying.run(0.2)
    flying.order(AutonomousExplore())
    await flying.run(5.0)
    flying.expect(S.AUTONOMOUS_EXPLORE)
    await flying.close()


async def test_an_outline_that_a_later_fence_leaves_out_is_not_explored(fresh: Rig) -> None:
    """It was taken before a fence was known; a fence that leaves all of it out gives no target."""
    fresh.manager.outlines.use(outline_of(command(box(300, 300, 350, 350))))
    await fresh.enter(S.HOVER)
    assert reason(fresh, AutonomousExplore()).startswith("Nothing of the outline lies inside the fence")
    fresh.expect(S.HOVER)


async def test_with_an_outline_a_target_outside_the_fence_is_not_sent(flying: Rig) -> None:
    flying.order(command(box(100, -10, 200, 10)))
    await flying.run(0.2)
    flying.sight.plan = PathPlan(target=MapPoint(190.0, 0.0), explore=ExploreStatus(asked_m2=1000.0))
    flying.order(AutonomousExplore())
    await flying.run(5.0)
    assert all(math.hypot(t.north, t.east) <= 145.0 for t in flying.autopilot.targets)
    assert math.hypot(flying.autopilot.north, flying.autopilot.east) < 5.0


@pytest.mark.parametrize(
    ("unseen", "words"),
    [
        (0.0, "Explored: the outline is seen whole."),
        (120.0, "Explored: the rest cannot be reached. 880 m² of 1000 m² seen, 120 m² not reached."),
    ],
)
async def test_at_the_end_what_was_left_out_is_reported_with_its_size(flying: Rig, unseen: float, words: str) -> None:
    flying.order(command(box(100, -10, 200, 10)))
    await flying.run(0.2)
    flying.order(AutonomousExplore())
    await flying.tick()
    end = ExploreStatus(done=True, seen=1.0, remaining_m=0.0, asked_m2=1000.0, unseen_m2=unseen)
    flying.sight.plan = PathPlan(explore=end)
    await flying.run(2.0)
    flying.expect(S.HOVER)
    said = next(line for line in flying.log if line.startswith("Explored"))
    assert said.startswith(words)
    assert said.endswith("m² outside the fence were left out. Holding.")
    assert status_of(flying).perception.outline_unseen == unseen
    assert status_of(flying).operation.user_error is UserError.NONE


async def test_before_take_off_the_battery_is_judged_by_the_outline(rig: Rig) -> None:
    await rig.run(1.0)
    assert status_of(rig).vehicle.survey_basis == "fence"
    rig.order(INSIDE)
    await rig.run(1.0)
    assert status_of(rig).vehicle.survey_basis == "outline"
    (check,) = [each for each in rig.manager.situation().checks if each.name == "Survey"]
    assert check.value.startswith("enough for the outline (0.3 ha)")


# -- kept -------------------------------------------------------------------------------------------------------------


@pytest.fixture
def with_file(tmp_path: Path) -> tuple[Path, DdcSettings]:
    file = tmp_path / "lot.geojson"
    file.write_text(geojson(feature("Polygon", [closed(box(0, 0, 50, 50))])))
    return file, replace(DdcSettings(), flight=FlightSettings(outline_file=file))


async def test_the_settings_file_counts_until_an_operator_sets_or_clears_one(
    tmp_path: Path, with_file: tuple[Path, DdcSettings]
) -> None:
    _, configured = with_file
    cases = [
        (None, "file", 2500.0),
        (outline_of(INSIDE), "set", 3000.0),
        (Outline(), "none", 0.0),
        (Outline((BOW_TIE,)), "file", 2500.0),  # a journalled one that cannot be used
    ]
    for kept, source, area in cases:
        rig = Rig(tmp_path, settings=configured, memory=SurveyMemory(outline=kept))
        setup = rig.manager.outlines.setup
        assert setup.source == source
        assert setup.area == pytest.approx(area, rel=1e-3)
        await rig.close()


async def test_an_outline_that_goes_on_is_reported_at_the_start(tmp_path: Path) -> None:
    rig = Rig(tmp_path, memory=SurveyMemory(outline=outline_of(INSIDE)))
    assert "The outline of the survey goes on: 3000 m²." in rig.log
    await rig.close()


async def test_a_configured_file_that_cannot_be_read_ends_the_start(tmp_path: Path) -> None:
    configured = replace(DdcSettings(), flight=FlightSettings(outline_file=tmp_path / "none.geojson"))
    with pytest.raises(OutlineError, match=r"^flight\.outline_file: .*none\.geojson: cannot be read"):
        Rig(tmp_path, settings=configured)
