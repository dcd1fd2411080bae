from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely

from hawk.algo.footprint import ground_footprint
from hawk.algo.path_plan.following import Motion
from hawk.algo.path_plan.footprint import GRAVITY, Floats, Footprint
from hawk.algo.path_plan.rehearsal import Rehearsal, flown_ahead
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.algo.path_plan.sweep import Swath
from hawk.algo.path_plan.tour import Terms, Wanted
from hawk.model import CameraModel, MapPose

SETTINGS = PathPlanSettings()
FOOTPRINT = Footprint(40.0, 24.0)
TERMS = Terms(FOOTPRINT, short_by=10.0, leg_m=2.0)
CAMERA = CameraModel(1280, 720, 914.0, 914.0, 639.5, 359.5)
NOWHERE = np.zeros(2)
HOVERING = Motion(NOWHERE, NOWHERE, NOWHERE, NOWHERE, 0.0, NOWHERE)


def ground(north: tuple[float, float], east: tuple[float, float], spare: float = 0.0) -> Wanted:
    cells = np.array([(n, e) for n in np.arange(*north, 2.0) for e in np.arange(*east, 2.0)], np.float32)
    return Wanted(cells, np.full(len(cells), 4.0, np.float32), spare)


def rehearsal(wanted: Wanted, terms: Terms = TERMS) -> Rehearsal:
    return Rehearsal(wanted, terms, HOVERING, SETTINGS)


def tour(*places: tuple[float, float]) -> Floats:
    return np.array([(0.0, 0.0), *places])


@pytest.mark.parametrize(("ahead", "aside", "yaw"), [(0.0, 0.0, 0.4), (2.5, 0.0, 0.0), (1.0, -2.0, 2.3)])
def test_a_picture_shows_what_the_leaning_camera_shows(ahead: float, aside: float, yaw: float) -> None:
    """``ahead`` and ``aside`` are the acceleration in the drone's own directions."""
    pitch = -math.atan(ahead / GRAVITY)
    roll = math.atan(aside / GRAVITY * math.cos(pitch))
    outline = shapely.Polygon(
        [(p.north, p.east) for p in ground_footprint(CAMERA, MapPose(5, -3, 35, roll, pitch, yaw))]
    )
    swath = Swath.of(CAMERA, 35.0, 1.0)
    foot = Footprint.of(swath, SETTINGS)
    cells = np.random.default_rng(1).uniform(-45, 45, (800, 2)).astype(np.float32)
    c, s = math.cos(yaw), math.sin(yaw)
    lean = np.array([[ahead * c - aside * s, ahead * s + aside * c]])
    seen = foot.seen(cells, np.array([[5.0, -3.0]]), np.array([yaw]), lean)[0]
    inside = shapely.contains_xy(outline, *cells.T)
    clear = np.abs([outline.exterior.distance(shapely.Point(*cell)) for cell in cells.tolist()]) > 0.5
    assert inside.sum() > 100
    assert np.array_equal(seen[clear], inside[clear])


def test_a_camera_that_is_kept_level_does_not_lean() -> None:
    foot = Footprint.of(Swath.of(CAMERA, 35.0, 1.0), replace(SETTINGS, lean_deg=0.0))
    cells = ground((-40, 40), (-40, 40)).cells
    still, pulled = (foot.seen(cells, np.zeros((1, 2)), np.zeros(1), np.array([[pull, 0.0]])) for pull in (0.0, 2.5))
    assert np.array_equal(still, pulled)


def test_what_is_shown_costs_its_way_and_the_way_points() -> None:
    wanted = ground((0, 60), (-15, 15))
    cost = rehearsal(wanted).costs([tour((30.0, 0.0), (60.0, 0.0))])[0]
    assert 55 + 4 < cost < 62 + 4


def test_what_is_not_shown_costs_what_sweeping_it_would_several_times_over() -> None:
    wanted = ground((0, 60), (-15, 15))
    assert rehearsal(wanted).costs([np.zeros((1, 2))])[0] == pytest.approx(wanted.total * 10.0 / 40.0)
    spared = replace(wanted, spare=wanted.total)
    assert rehearsal(spared).costs([np.zeros((1, 2))])[0] == 0.0


def test_what_the_camera_shows_as_the_drone_speeds_up_counts() -> None:
    """Leaning ahead it looks back: ground behind the drone, that no level picture on the way shows."""
    behind = ground((-18, -14), (-6, 6))
    level, leaning = (
        rehearsal(behind, replace(TERMS, footprint=replace(FOOTPRINT, leans=leans))).costs([tour((30.0, 0.0))])[0]
        for leans in (0.0, 1.0)
    )
    assert level == pytest.approx(leaning + behind.total * 10.0 / 40.0)


def test_where_the_tour_ends_the_turn_on_the_spot_counts() -> None:
    wanted = ground((20, 26), (-22, 22))
    spinning = replace(TERMS, footprint=replace(FOOTPRINT, spun=22.0))
    without, spun = (rehearsal(wanted, terms).costs([tour((10.0, 0.0))])[0] for terms in (TERMS, spinning))
    assert spun < without - 5


def test_what_lies_far_ahead_is_weighed_by_its_legs() -> None:
    wanted = ground((0, 400), (-15, 15))
    line = tour(*((40.0 * number, 0.0) for number in range(1, 11)))
    assert flown_ahead(line) < 6
    assert rehearsal(wanted).costs([line])[0] == pytest.approx(400 + 20, abs=8)


def test_tours_of_different_lengths_are_weighed_together_as_alone() -> None:
    wanted = ground((-40, 120), (-40, 40))
    line = tour(*((30.0 * number, 5.0 * number) for number in range(1, 8)))
    tours = [line, line[:3], line[:1], np.delete(line, 1, axis=0), line[::-1] - line[-1]]
    together = rehearsal(wanted).costs(tours)
    assert together == pytest.approx([rehearsal(wanted).costs([one])[0] for one in tours], abs=1e-3)


def test_no_more_is_flown_in_the_mind_than_a_frame_has_time_for() -> None:
    assert flown_ahead(np.zeros((1, 2))) == 0
    assert flown_ahead(tour((5.0, 0.0))) == 1
    assert flown_ahead(tour(*((2.0 * number, 0.0) for number in range(1, 30)))) == 6
    assert flown_ahead(tour((200.0, 0.0), (400.0, 0.0))) == 1
