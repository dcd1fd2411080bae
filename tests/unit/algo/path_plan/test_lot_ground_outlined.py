from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.algo.frame import FrameInput
from hawk.algo.ground import COARSE_M, Window
from hawk.algo.path_plan.app import PathPlanApp
from hawk.algo.path_plan.lot_ground import OutlinedGround, cells_inside
from hawk.model.lot_map import Stall, StallState
from hawk.model.plans import AskedGround
from hawk.model.poses import MapPoint
from tests.examples import examples
from tests.unit.algo.path_plan.flight import LEVEL, Flight, KnownMap, fence_around, fly
from tests.unit.algo.synthetic import frame_at, pose_at

places = st.tuples(st.floats(-60.0, 60.0), st.floats(-60.0, 60.0))


def asked(shape: shapely.Geometry) -> AskedGround:
    pieces = []
    for part in shapely.get_parts(shape):
        rings = (part.exterior, *part.interiors)
        pieces.append(tuple(tuple((float(n), float(e)) for n, e in ring.coords[:-1]) for ring in rings))
    return AskedGround(tuple(pieces), float(shape.area))


@pytest.mark.slow
@settings(max_examples=examples(60), deadline=None)
@given(st.lists(places, min_size=3, max_size=7), st.lists(places, min_size=3, max_size=5))
def test_a_cell_belongs_to_the_ground_when_its_centre_lies_inside(
    outer: list[tuple[float, float]], hole: list[tuple[float, float]]
) -> None:
    shape = shapely.MultiPoint(outer).convex_hull.difference(shapely.MultiPoint(hole).convex_hull)
    shape = shapely.union_all([part for part in shapely.get_parts(shape) if part.geom_type == "Polygon"])
    rings = [ring for piece in asked(shape).pieces for ring in piece]
    window = Window(-30, -45, 70, 90, COARSE_M)
    rows, columns = np.mgrid[: window.rows, : window.columns]
    north, east = window.centres(rows, columns)
    away = shapely.distance(shapely.boundary(shape), shapely.points(north, east))
    clear = ~(away < 1e-6)
    inside = shapely.contains_xy(shape, north, east)
    assert (cells_inside(rings, window)[clear] == inside[clear]).all()


def test_a_cell_has_the_same_answer_in_every_window() -> None:
    outlined = OutlinedGround(asked(shapely.box(-31.3, -17.9, 22.2, 40.1).difference(shapely.box(-5, -5, 9, 9))))
    whole = Window(-60, -60, 120, 120, COARSE_M)
    for part in (Window(-10, -10, 30, 20, COARSE_M), Window(50, 50, 40, 40, COARSE_M), Window(-90, 0, 40, 9, COARSE_M)):
        wider = whole.joined(part)
        assert (outlined.mask(wider)[wider.part(part)] == outlined.mask(part)).all()
    assert outlined.area_m2 == pytest.approx(outlined.ground.area, rel=0.02)


def test_outside_everything_counts_as_seen_and_inside_as_lot_until_half_of_a_cell_was_seen_well() -> None:
    outlined = OutlinedGround(asked(shapely.box(-16.0, -16.0, 16.0, 16.0)))
    known = KnownMap(shapely.box(40.0, 40.0, 60.0, 60.0), 80.0)
    known.look(pose_at(0.0, 0.0))
    layers = outlined.on(known.coarse(Window(-40, -40, 80, 80, COARSE_M)))
    inside = outlined.mask(layers.window) > 0
    assert (layers.lot == inside).all()
    assert (layers.seen[~inside] == 1).all()
    seen = known.coarse(layers.window).well >= 0.5
    assert (layers.well[inside & seen] == 1).all()
    assert outlined.unseen_m2(known) == pytest.approx(float((inside & ~seen).sum()) * COARSE_M**2)


def test_without_pieces_there_is_no_ground() -> None:
    outlined = OutlinedGround(AskedGround((), 0.0, 500.0))
    assert outlined.extent is None
    assert outlined.area_m2 == 0.0
    assert not outlined.contains((0.0, 0.0))


def explored(lot: shapely.Geometry, ground: shapely.Geometry, margin: float = 30.0) -> tuple[Flight, KnownMap]:
    known = KnownMap(lot, 160.0)
    fence = fence_around(shapely.union(lot, ground).convex_hull, margin)
    return fly(lot, (0.0, 0.0), fence, PathPlanApp(LEVEL), known=known, ground=asked(ground)), known


@pytest.mark.nightly
@pytest.mark.flight
def test_every_cell_of_the_outline_is_looked_at_and_nothing_beside_it_though_it_is_lot() -> None:
    lot, ground = shapely.box(-20.0, -20.0, 60.0, 110.0), shapely.box(-20.0, -20.0, 35.0, 30.0)
    flight, known = explored(lot, ground)
    assert flight.done
    end = flight.plans[-1].explore
    assert end.unseen_m2 == 0.0
    assert end.asked_m2 == pytest.approx(ground.area, rel=0.02)
    assert max(place[1] for place in flight.places) < 45.0
    assert OutlinedGround(asked(ground)).unseen_m2(known) == 0.0


@pytest.mark.flight
@pytest.mark.nightly
def test_ground_without_any_lot_is_seen_whole() -> None:
    lot, ground = shapely.box(-150.0, -150.0, -140.0, -140.0), shapely.box(-30.0, 20.0, 30.0, 80.0)
    flight, known = explored(lot, ground)
    assert flight.done
    assert all(plan.explore.lot_known for plan in flight.plans)
    assert OutlinedGround(asked(ground)).unseen_m2(known) == 0.0


@pytest.mark.flight
@pytest.mark.nightly
def test_an_outline_beyond_the_fence_widens_it_not_and_what_was_not_seen_is_outlined() -> None:
    """The planner is given ground that nobody cut off at the fence."""
    lot = shapely.box(-30.0, -30.0, 30.0, 30.0)
    ground = shapely.box(-30.0, -30.0, 30.0, 120.0)
    fence = fence_around(lot, 10.0)
    known = KnownMap(lot, 160.0)
    flight = fly(lot, (0.0, 0.0), fence, PathPlanApp(LEVEL), known=known, ground=asked(ground))
    inside = shapely.Polygon(fence.polygon)
    targets = [plan.target for plan in flight.plans if plan.target is not None]
    assert targets
    assert all(inside.covers(shapely.Point(target.north, target.east)) for target in targets)
    assert all(inside.covers(shapely.Point(place)) for place in flight.places)
    assert flight.done
    unseen = flight.plans[-1].explore.unseen_m2
    assert unseen is not None
    assert 60.0 * 50.0 < unseen < 60.0 * 85.0


@pytest.mark.flight
def test_an_outline_wholly_outside_the_fence_gives_no_target_and_ends() -> None:
    lot = shapely.box(-30.0, -30.0, 30.0, 30.0)
    ground = shapely.box(-30.0, 90.0, 30.0, 120.0)
    flight = fly(lot, (0.0, 0.0), fence_around(lot, 10.0), PathPlanApp(LEVEL), most_s=120.0, ground=asked(ground))
    assert [plan.target for plan in flight.plans if plan.target is not None] == []
    assert flight.done
    assert flight.plans[-1].explore.unseen_m2 == pytest.approx(ground.area, rel=0.05)


@pytest.mark.slow
def test_another_outline_begins_the_exploration_again() -> None:
    known = KnownMap(shapely.box(-30.0, -30.0, 30.0, 30.0), 160.0)
    known.look(pose_at(0.0, 0.0))
    app = PathPlanApp(LEVEL)
    one, other = asked(shapely.box(-10.0, -10.0, 10.0, 10.0)), asked(shapely.box(-10.0, 60.0, 10.0, 90.0))
    for number in range(30):
        plan = app.plan(replaced(number, one), known)
    assert plan.path.explore.done
    for number in range(30, 60):
        plan = app.plan(replaced(number, other), known)
    assert not plan.path.explore.done
    assert plan.path.target is not None
    assert plan.path.target.east > 20.0


@pytest.mark.slow
def test_only_unclear_stalls_of_the_outline_are_looked_at_again() -> None:
    class Unclear(KnownMap):
        def unclear_stalls(self) -> dict[int, Stall]:
            return {
                i: Stall(i, 0.0, east, 0.0, 2.6, 5.2, 0.5, StallState.UNKNOWN, 0.9, 3, 1.0, 1)
                for i, east in ((1, 15.0), (2, 40.0))
            }

    known = Unclear(shapely.box(-30.0, -30.0, 30.0, 60.0), 160.0)
    known.seen[:] = known.well[:] = 1
    app = PathPlanApp(LEVEL)
    ground = asked(shapely.box(-20.0, -20.0, 20.0, 20.0))
    targets = {app.plan(replaced(number, ground), known).path.target for number in range(30)}
    assert targets - {None} == {MapPoint(0.0, 15.0)}


def replaced(number: int, ground: AskedGround) -> FrameInput:
    return replace(frame_at(pose_at(0.0, 0.0), number), asked_ground=ground, speed=0.0)
