from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable
from copy import deepcopy
from datetime import datetime
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import shapely

from hawk.worlds.bays import LEAST, Room
from hawk.worlds.generate import SiteSize, WorldOptions, generate_world, plan_lot_site
from hawk.worlds.moment import clock_of
from hawk.worlds.parked_cars import number_stalls
from hawk.worlds.plan import PlannedStall, SitePlan, Surface, Vehicle
from hawk.worlds.repaint import CHANGES, Change, add_bays, build_island, change_pitch, close_row, repaint
from hawk.worlds.runs import runs_of
from hawk.worlds.scene.canvas import Points
from hawk.worlds.world import TrueStall, World, WorldError, load_truth
from tests.unit.worlds.builders import GREY, areas_of, generator, largest_overlap, plain_plan

PLACE = (43.2609, -79.9192)
NOON = datetime(2026, 5, 4, 12, tzinfo=clock_of(PLACE[1]))
SIZE_M = (125.0, 105.0)
SEEDS = (1, 2, 3, 4, 5)
STALL = np.array([(0.0, 0.0), (2.6, 0.0), (2.6, 5.2), (0.0, 5.2)])


@cache
def _planned(seed: int) -> SitePlan:
    rng = np.random.default_rng(seed)
    size = SiteSize((70.0, 85.0), (45.0, 60.0), 0.3)
    return plan_lot_site(rng, (SIZE_M[0] / 2, SIZE_M[1] / 2), size)


def lot(seed: int) -> SitePlan:
    """A planned lot with numbered stalls, of its own."""
    plan = deepcopy(_planned(seed))
    number_stalls(plan)
    return plan


def row(count: int = 10) -> SitePlan:
    """One row of stalls with cars on a lot with an aisle, and room on its far side."""
    outline = np.array([(5.0, 5.0), (45.0, 5.0), (45.0, 25.0), (5.0, 25.0)])
    plan = plain_plan(lots=[outline])
    plan.add_surface(Surface(outline, GREY))
    for k in range(count):
        corners = STALL + np.array([8 + 2.6 * k, 19.0])
        plan.stalls.append(PlannedStall(corners, "perpendicular", True, False, 1.0))
        x, y = corners.mean(0).tolist()
        plan.vehicles.append(Vehicle(x, y, 1.57, "suv"))
    for k in range(count + 1):
        plan.line((8 + 2.6 * k, 19.0), (8 + 2.6 * k, 24.2), 0.12, 0, 1.0)
    number_stalls(plan)
    return plan


def places(plan: SitePlan) -> dict[int | None, bytes]:
    return {stall.number: stall.corners.tobytes() for stall in plan.stalls}


@pytest.mark.nightly
@pytest.mark.parametrize("seed", SEEDS)
def test_stalls_that_stay_keep_their_ids_and_no_id_is_used_again(seed: int) -> None:
    plan = lot(seed)
    seen = places(plan)
    names = []
    for number in range(1, 9):
        before = places(plan)
        names.append(repaint(plan, seed, number, SIZE_M))
        after = places(plan)
        assert len(after) == len(plan.stalls), "every stall has an id of its own"
        assert all(after[k] == before[k] for k in after.keys() & before.keys())
        added = after.keys() - before.keys()
        assert not added & seen.keys()
        seen |= after
        assert len(after.keys() & before.keys()) > 0.5 * len(before), names
    assert set(names[:4]) <= set(CHANGES)
    assert Counter(names)["none"] == 0


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_a_changed_lot_stays_a_lot(seed: int) -> None:
    plan = lot(seed)
    roofs = [shapely.Polygon(building.polygon) for building in plan.buildings if not building.shelter]
    for number in range(1, 9):
        repaint(plan, seed, number, SIZE_M)
    quads = areas_of(plan.stalls)
    assert largest_overlap(quads) < 0.5
    outline = shapely.union_all([shapely.Polygon(one).buffer(0) for one in plan.lots]).buffer(0.6)
    assert all(outline.covers(quad) for quad in quads)
    islands = shapely.union_all([shapely.Polygon(island.polygon) for island in plan.islands])
    assert max(quad.intersection(islands).area for quad in quads) < 0.6
    assert not shapely.union_all(roofs).intersects(shapely.union_all(quads).buffer(-0.3))
    closed = shapely.union_all([shapely.Polygon(stall.corners) for stall in plan.stalls if stall.closed])
    assert not any(closed.contains(shapely.Point(vehicle.x, vehicle.y)) for vehicle in plan.vehicles)


@pytest.mark.nightly
def test_the_same_changes_follow_from_the_same_seed() -> None:
    def changed(seed: int) -> tuple[dict[int | None, bytes], list[str]]:
        plan = lot(1)
        names = [repaint(plan, seed, number, SIZE_M) for number in range(1, 6)]
        return places(plan), names

    assert changed(4) == changed(4)
    assert changed(4)[0] != changed(5)[0]


@pytest.mark.nightly
def test_each_kind_has_its_turn() -> None:
    """A lot without room for bays gives their turn away: not every seed has all four."""
    turns = []
    for seed in SEEDS:
        plan = lot(seed)
        turns.append([repaint(plan, seed, number, SIZE_M) for number in range(1, 5)])
    assert set().union(*turns) == set(CHANGES)
    assert sum(len(set(names)) == len(CHANGES) for names in turns) >= 2
    assert len({names[0] for names in turns}) > 1


def test_another_pitch_paints_other_stalls_on_the_same_length() -> None:
    plan = row()
    whole = shapely.union_all(areas_of(plan.stalls))
    assert change_pitch(plan, generator(2), SIZE_M)
    number_stalls(plan)
    assert {stall.number for stall in plan.stalls} == set(range(10, 10 + len(plan.stalls)))
    assert len(plan.stalls) != 10
    assert whole.symmetric_difference(shapely.union_all(areas_of(plan.stalls))).area < 0.01
    lines = sorted(float(stroke.polygon.mean(0)[0]) for stroke in plan.strokes)
    width = 26.0 / len(plan.stalls)
    assert lines == pytest.approx([8 + width * k for k in range(len(plan.stalls) + 1)], abs=1e-6)
    assert all(2.3 <= width <= 3.2 for width in (width,))
    taken = {stall.number for stall in plan.stalls if stall.taken}
    with_car = {
        stall.number
        for stall in plan.stalls
        for vehicle in plan.vehicles
        if shapely.Polygon(stall.corners).contains(shapely.Point(vehicle.x, vehicle.y))
    }
    assert with_car == taken


def test_an_island_takes_the_place_of_stalls_cars_and_lines() -> None:
    plan = row()
    before = places(plan)
    assert build_island(plan, generator(3), SIZE_M)
    (island,) = plan.islands
    area = shapely.Polygon(island.polygon)
    gone = before.keys() - places(plan).keys()
    assert len(gone) in (2, 3)
    assert not gone & {0, 9}, "the ends of the row stay"
    assert not any(area.contains(shapely.Point(vehicle.x, vehicle.y)) for vehicle in plan.vehicles)
    assert not any(area.contains(shapely.Point(stroke.polygon.mean(0))) for stroke in plan.strokes)
    assert len(plan.strokes) == 11 - (len(gone) - 1)
    assert len(plan.vehicles) == len(plan.stalls) == 10 - len(gone)


def test_added_bays_are_painted_beside_an_edge_with_an_aisle_before_them() -> None:
    plan = row()
    assert add_bays(plan, generator(1), (60.0, 40.0))
    number_stalls(plan)
    added = [stall for stall in plan.stalls if stall.number is not None and stall.number >= 10]
    assert len(added) >= LEAST
    assert len(plan.strokes) == 11 + len(added) + 1
    lots = shapely.union_all([shapely.Polygon(one) for one in plan.lots]).buffer(0.05)
    assert all(lots.covers(quad) for quad in areas_of(plan.stalls))
    assert largest_overlap(areas_of(plan.stalls)) < 1e-3
    sides = [np.linalg.norm(stall.corners[1] - stall.corners[0]) for stall in added]
    lengths = [np.linalg.norm(stall.corners[2] - stall.corners[1]) for stall in added]
    assert max(sides) < min(lengths), "the short end comes first"


def test_where_there_is_no_room_no_bays_are_added() -> None:
    plan = row()
    plan.lots = [np.array([(7.0, 18.0), (35.0, 18.0), (35.0, 25.0), (7.0, 25.0)])]
    before = len(plan.strokes)
    assert Room(plan, (60.0, 40.0)).places() == []
    assert not add_bays(plan, generator(1), (60.0, 40.0))
    assert len(plan.strokes) == before


def test_bays_stay_clear_of_stalls_and_roads() -> None:
    plan = row()
    road = np.array([(-9.0, -9.0), (60.0, -9.0), (60.0, 4.5), (-9.0, 4.5)])
    without = len(Room(plan, (60.0, 40.0)).places())
    plan.add_surface(Surface(road, GREY))
    stalls = shapely.union_all(areas_of(plan.stalls))
    found = Room(plan, (60.0, 40.0)).places()
    assert 0 < len(found) < without
    for place in found:
        bays, aisle = shapely.Polygon(place.outline), shapely.Polygon(place.aisle)
        assert not bays.intersects(stalls)
        assert not aisle.intersects(stalls)
        assert not bays.intersects(aisle.buffer(-1e-6))
        assert not (place.bay.outside and bays.intersects(shapely.Polygon(road)))


def test_fences_stand_about_a_closed_row_and_no_car_in_it() -> None:
    plan = row()
    assert close_row(plan, generator(), SIZE_M)
    assert all(stall.closed and not stall.taken for stall in plan.stalls)
    assert plan.vehicles == []
    assert len(plan.blocks) == 4
    inside = shapely.union_all([shapely.Polygon(block.polygon) for block in plan.blocks]).convex_hull
    assert inside.area == pytest.approx(26.0 * 5.2, rel=0.1)
    assert runs_of(plan, 1) == [], "a closed row is left alone by later changes"


@pytest.mark.parametrize("change", CHANGES.values())
def test_an_empty_lot_is_not_changed(change: Change) -> None:
    plan = plain_plan()
    assert not change(plan, generator(), SIZE_M)
    assert repaint(plan, 1, 1, SIZE_M) == "none"


def _shifted(by: Points) -> Callable[[PlannedStall], PlannedStall]:
    return lambda stall: PlannedStall(stall.corners + by, stall.kind, stall.taken, stall.worn, stall.paint)


def test_a_gap_ends_a_run() -> None:
    plan = row()
    plan.stalls[5:] = [_shifted(np.array([2.6, 0.0]))(stall) for stall in plan.stalls[5:]]
    assert [len(run) for run in runs_of(plan, 2)] == [5, 5]


@cache
def world(changes: int, at: datetime | None = NOON) -> World:
    return generate_world(6, WorldOptions(metres_per_pixel=0.2, repaint=changes, at=at, place=PLACE))


@pytest.mark.nightly
@pytest.mark.slow
def test_a_repainted_world_has_the_truth_of_its_layout() -> None:
    before, after = ({stall.id: stall for stall in world(changes).stalls} for changes in (0, 4))
    stayed = [(before[k], after[k]) for k in before.keys() & after.keys()]
    assert 0.5 * len(before) < len(stayed) < len(before)
    for one, same in stayed:
        np.testing.assert_array_equal(one.corners, same.corners)
        assert same.closed or one.taken is same.taken
    closed = [stall for stall in after.values() if stall.closed]
    assert closed
    assert {stall.state for stall in closed} == {"unclear"}
    open_ones = [stall for stall in after.values() if not stall.closed]
    assert np.mean([stall.covered > 0.3 for stall in open_ones if stall.taken]) > 0.9
    assert np.mean([stall.covered < 0.15 for stall in open_ones if not stall.taken]) > 0.9


@pytest.mark.slow
def test_ground_away_from_a_change_stays_as_it_was() -> None:
    one, other = world(0), world(4)
    assert 0.6 < np.mean((one.ground == other.ground).all(2)) < 0.99


def test_the_truth_says_which_stalls_are_closed(tmp_path: Path) -> None:
    path = tmp_path / "truth.json"
    path.write_text(json.dumps(world(4).truth_json()))
    saved: dict[int, TrueStall] = {stall.id: stall for stall in load_truth(path).stalls}
    assert {k for k, stall in saved.items() if stall.closed} == {s.id for s in world(4).stalls if s.closed}


@pytest.mark.nightly
@pytest.mark.slow
def test_a_repainted_world_needs_no_moment() -> None:
    still = world(2, None)
    assert any(stall.taken for stall in still.stalls)
    assert {stall.id for stall in still.stalls} == {stall.id for stall in world(2).stalls}


@pytest.mark.parametrize("changes", [-1, 101])
def test_a_number_of_changes_out_of_bounds_is_refused(changes: int) -> None:
    with pytest.raises(WorldError, match="repaint: must be 0 to 100"):
        WorldOptions(repaint=changes)
