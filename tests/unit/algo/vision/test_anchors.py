"""Pictures of earlier in the flight that are kept, with features made up: random ones on the ground."""

from __future__ import annotations

import numpy as np
import pytest

from hawk.algo.vision.anchors import AGAIN_S, CAPACITY, EARLIER_S, FIRST, Anchors
from hawk.algo.vision.similarity import GroundFeatures
from hawk.model.pictures import GroundAgain
from hawk.model.poses import MapPose

RNG = np.random.default_rng(5)
GROUND = RNG.uniform(-400, 400, 60_000) + 1j * RNG.uniform(-40, 40, 60_000)
DESCRIPTORS = RNG.integers(0, 256, (60_000, 32), np.uint8)
HEIGHT = 20.0


def seen(true: complex, grown: float = 1.0) -> GroundFeatures:
    """Return the features within 8 m of a place, from the drone; ``grown``: by which they lie too far away."""
    near = np.abs(GROUND - true) < 8.0
    return GroundFeatures((GROUND[near] - true) * grown, DESCRIPTORS[near], 0.08)


def look(
    anchors: Anchors, time: float, true: complex, reported: complex, beyond: complex = 0j, height: float = HEIGHT
) -> GroundAgain | None:
    pose = MapPose(reported.real, reported.imag, height, 0.0, 0.0, 0.0)
    return anchors.look(time, pose, seen(true), beyond)


def test_a_drone_that_holds_is_compared_with_the_picture_of_where_it_began() -> None:
    anchors = Anchors()
    assert look(anchors, 0.0, 0j, 0j) is None
    assert look(anchors, EARLIER_S - 0.5, 0j, 0j) is None, "too young"
    for k in range(20):  # it walks by 0.2 m a second, unreported
        again = look(anchors, 10.0 + k, -0.2 * k + 0j, 0j, 0j if k == 0 else -0.2 + 0j)
        assert again is not None
        assert again.since == 0.0
        assert complex(*again.beyond) == pytest.approx(-0.2 * k, abs=0.02)
        assert again.reported == (0.0, 0.0)


def test_the_movement_that_is_reported_is_none_beyond_it() -> None:
    anchors = Anchors()
    look(anchors, 0.0, 0j, 100 + 50j)
    again = look(anchors, 9.0, 2 - 3j, 102 + 47j)
    assert again is not None
    assert complex(*again.beyond) == pytest.approx(0.0, abs=0.02)
    assert again.reported == (2.0, -3.0)


def test_pictures_are_compared_twice_a_second() -> None:
    anchors = Anchors()
    look(anchors, 0.0, 0j, 0j)
    assert look(anchors, 9.0, 0j, 0j) is not None
    assert look(anchors, 9.0 + AGAIN_S / 2, 0j, 0j) is None
    assert look(anchors, 9.0 + 1.01 * AGAIN_S, 0j, 0j) is not None


def test_ground_that_is_flown_over_again_is_compared_with_its_first_picture() -> None:
    anchors = Anchors()
    for k in range(40):  # 60 m north and back, while the position goes wrong by 2 m to the east
        look(anchors, float(k), 1.5 * k + 0j, 1.5 * k + 0j)
    found = [
        look(anchors, 60.0 + k, 1.5 * (40 - k) - 2j, 1.5 * (40 - k) + 0j, -2j if k == 0 else 0j) for k in range(40)
    ]
    again = [each for each in found if each is not None]
    assert len(again) >= 38
    assert again[-1].since <= 3.0
    assert [complex(*each.beyond) for each in again] == pytest.approx([-2j] * len(again), abs=0.05)


def test_a_match_far_from_the_place_or_of_another_size_is_none() -> None:
    anchors = Anchors()
    anchors.look(0.0, MapPose(0.0, 0.0, HEIGHT, 0.0, 0.0, 0.0), seen(0j), 0j)
    for grown, is_found in ((1.0, True), (1.15, True), (1.3, False)):
        pose = MapPose(0.0, 0.0, HEIGHT, 0.0, 0.0, 0.0)
        assert (anchors.look(9.0 + 10 * grown, pose, seen(0j, grown), 0j) is not None) is is_found
    assert look(anchors, 40.0, 300 + 0j, 0j) is None, "other ground"


def test_a_place_higher_up_has_a_picture_of_its_own_and_a_clearing_forgets_all() -> None:
    anchors = Anchors()
    look(anchors, 0.0, 0j, 0j)
    assert look(anchors, 9.0, 0j, 0j, height=HEIGHT * 1.4) is None
    again = look(anchors, 18.0, 0j, 0j, height=HEIGHT * 1.4)
    assert again is not None
    assert again.since == 9.0
    anchors.clear()
    assert look(anchors, 30.0, 0j, 0j) is None


def test_the_first_pictures_are_kept_for_good_and_of_the_others_the_newest() -> None:
    anchors = Anchors()
    for k in range(CAPACITY + 20):
        look(anchors, float(k), complex(-390 + 6 * k), complex(-390 + 6 * k))
    kept = [anchor.time for anchor in anchors._kept]
    assert len(kept) == CAPACITY
    assert kept[:FIRST] == [float(k) for k in range(FIRST)]
    assert kept[FIRST] == FIRST + 20
