from __future__ import annotations

import cv2
import numpy as np
import pytest

from benchmarks.chain_flight.known import plan_of
from benchmarks.perception.eyes import NetworkEye
from benchmarks.perception.places import Place, state_array
from benchmarks.perception.plans import SHIFT_M, Planned, figures, look_with_plan, moved_plan
from hawk.algo.rows.fit import Rectangles
from hawk.algo.vision.network import StallNetwork
from hawk.model.lot_map import StallState
from hawk.survey.accuracy import LabelledPlace
from hawk.worlds.generate import generate_world
from hawk.worlds.world import World


@pytest.fixture(scope="module")
def world() -> World:
    return generate_world(2)


@pytest.fixture(scope="module")
def place(world: World) -> Place:
    corners = np.array([stall.corners for stall in world.stalls])
    states = state_array([StallState(stall.state) for stall in world.stalls])
    image = cv2.resize(world.ground, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    truth = LabelledPlace(corners, states, tuple(world.lots))
    return Place("drawn", np.asarray(image, np.uint8), world.metres_per_pixel * 2, truth)


@pytest.fixture(scope="module")
def eye() -> NetworkEye:
    return NetworkEye(StallNetwork.load(None))


@pytest.mark.slow
def test_a_plan_beside_its_place_is_found_and_each_of_its_stalls_has_a_state(eye: NetworkEye, place: Place) -> None:
    looked = look_with_plan(eye, place)
    assert looked.judged == looked.stalls == len(place.truth.stalls)
    assert looked.off_m < 0.5
    assert not looked.doubt


@pytest.mark.slow
def test_a_picture_of_another_lot_is_not_judged_by_the_plan(eye: NetworkEye, place: Place) -> None:
    turned = Place("drawn", np.ascontiguousarray(place.image[::-1, ::-1]), place.metres_per_pixel, place.truth)
    looked = look_with_plan(eye, turned)
    assert looked.judged == 0
    assert looked.doubt


def test_the_plan_of_a_name_is_moved_alike_each_time_and_not_too_far() -> None:
    labels = Rectangles(np.array([[10.0, 10.0], [30.0, 10.0]]), np.zeros(2), np.full(2, 2.6), np.full(2, 5.2))
    size = np.array([40.0, 20.0])
    one, two = (moved_plan("place", labels, size) for _ in range(2))
    assert (one.centres == two.centres).all()
    off = np.hypot(*(one.centres.mean(0) - labels.centres.mean(0)))
    assert 0 < off <= SHIFT_M * np.sqrt(2)


def test_figures_add_up_over_places_and_count_those_that_are_not_certain() -> None:
    planned = [
        Planned("one", 10, judged=10, named=8, right=6, proposed=3, false=1, off_m=0.2),
        Planned("two", 30, doubt="two places fit alike"),
    ]
    found = {figure.key: figure.value for figure in figures(planned)}
    assert found["plan_judged"] == 0.25
    assert found["plan_state_accuracy"] == 0.75
    assert found["plan_false_proposals"] == 0.1
    assert found["plan_off_max_m"] == 0.2
    assert found["plan_uncertain"] == 1


def test_the_plan_of_a_world_has_its_stalls_beside_their_places(world: World) -> None:
    plan = plan_of(world)
    x0, y0 = world.start()
    centres = np.array([stall.corners.mean(0) for stall in world.stalls])
    off = np.array([(s.north, s.east) for s in plan.stalls]) - np.column_stack([y0 - centres[:, 1], centres[:, 0] - x0])
    assert 0.1 < np.hypot(*off.T).max() < 5.0
    assert all(stall.is_confirmed for stall in plan.stalls)
