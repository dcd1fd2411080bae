from __future__ import annotations

import numpy as np
import pytest

from hawk.picture.reconstruction.alignment import Reconstruction, reconstruct
from hawk.picture.reconstruction.features import Features
from tests.unit.picture.flights import Flight, flight, found

NOTHING = Features(np.zeros((0, 2)), np.zeros((0, 128), np.uint8))


def _adjusted(flown: Flight, without: frozenset[int] = frozenset()) -> Reconstruction:
    seen = [NOTHING if k in without else one for k, one in enumerate(found(flown))]
    return reconstruct(flown.known, seen.__getitem__, lens_is_known=True)


def _apart(flown: Flight, adjusted: Reconstruction) -> float:
    """Return how far the adjusted places lie from the true ones, after the best shift, turn and scale (p95)."""
    own = np.array([(one.north, one.east) for one in adjusted.posed]) @ (1, 1j)
    true = np.array([(one.north, one.east) for one in flown.true]) @ (1, 1j)
    factor, shift = np.polyfit(own, true, 1)
    return float(np.percentile(np.abs(own * factor + shift - true), 95))


@pytest.mark.nightly
def test_photographs_lie_right_to_each_other_afterwards() -> None:
    flown = flight(lanes=2, count=3)
    steps: list[str] = []
    adjusted = reconstruct(
        flown.known, found(flown).__getitem__, lens_is_known=True, progress=lambda step, *_: steps.append(step)
    )
    assert adjusted.is_adjusted.all()
    assert adjusted.residual is not None
    assert adjusted.residual < 0.5
    assert _apart(flown, adjusted) < 0.15
    assert {*steps} == {"match", "match again"}
    assert adjusted.turned == frozenset()


@pytest.mark.slow
def test_pictures_that_were_turned_afterwards_are_put_right_and_named() -> None:
    flown = flight(lanes=2, count=3, turned=frozenset({0, 1, 2}), sigma=0.5)
    adjusted = _adjusted(flown)
    assert adjusted.turned == {0, 1, 2}
    assert adjusted.is_adjusted.all()
    assert _apart(flown, adjusted) < 0.15


@pytest.mark.slow
def test_a_photograph_without_features_keeps_its_place_beside_the_others() -> None:
    flown = flight(lanes=2, count=3)
    adjusted = _adjusted(flown, without=frozenset({5}))
    assert adjusted.is_adjusted.tolist() == [True] * 5 + [False]
    said = flown.known[5].posed
    assert np.hypot(adjusted.posed[5].north - said.north, adjusted.posed[5].east - said.east) < 3.0


@pytest.mark.slow
def test_without_ties_the_places_of_the_files_stay() -> None:
    flown = flight(lanes=1, count=2)
    adjusted = _adjusted(flown, without=frozenset({0, 1}))
    assert adjusted.residual is None
    assert not adjusted.is_adjusted.any()
    assert [one.north for one in adjusted.posed] == pytest.approx([one.posed.north for one in flown.known])
