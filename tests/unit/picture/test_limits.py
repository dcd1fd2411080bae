from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hawk.lots.source import Limit, SourceKind
from hawk.model.pictures import CameraModel
from hawk.model.plans import Outline
from hawk.picture.adjust.app import Adjusted
from hawk.picture.adjust.posed import Posed
from hawk.picture.limits import fit_error, limits_of, source_of, stretch, unseen_share
from hawk.picture.values import Shot
from tests.unit.lots.surveys import box, survey

CAMERA = CameraModel(480, 360, 360.0, 360.0, 239.5, 179.5)
SEEN = replace(survey(), outline=box(0, 0, 20, 40), seen=box(-5, -5, 40, 60))


def adjusted(*places: tuple[float, float], by_ties: bool = True) -> Adjusted:
    """Return shots at places north and east, metres."""
    posed = tuple(Posed(CAMERA, north, east, 60.0, (0.0, 0.0, 0.0)) for north, east in places)
    return Adjusted(posed, np.full(len(posed), by_ties, np.bool_), None, 0)


def shot(sigma: float) -> Shot:
    return Shot(Path("a.jpg"), CAMERA, 52.0, 5.0, None, 60.0, None, (sigma, sigma), None)


@pytest.mark.parametrize(
    ("sigma", "by_ties", "scale", "wanted"),
    [
        (2.0, True, 0.02, ()),
        (2.0, False, 0.02, (Limit.BY_GPS,)),
        (0.02, False, 0.02, ()),
        (2.0, True, 0.15, (Limit.COARSE,)),
    ],
)
def test_pictures_that_lie_by_their_receiver_or_are_coarse_limit_a_survey(
    sigma: float, by_ties: bool, scale: float, wanted: tuple[Limit, ...]
) -> None:
    assert limits_of([shot(sigma)], adjusted((0.0, 0.0), by_ties=by_ties), scale, SEEN) == wanted


@pytest.mark.parametrize(
    ("sigma", "spacing", "wanted"), [(3.0, 20.0, (Limit.STRETCHED,)), (0.02, 20.0, ()), (3.0, 200.0, ())]
)
def test_a_map_that_few_places_hold_loosely_is_limited(sigma: float, spacing: float, wanted: tuple[Limit, ...]) -> None:
    three = adjusted(*((k * spacing, 0.0) for k in range(3)))
    shots = [shot(sigma)] * 3
    assert stretch(shots, three) == pytest.approx(1.645 * sigma / (spacing * 2**0.5), rel=1e-3)
    assert limits_of(shots, three, 0.02, SEEN) == wanted
    assert stretch(shots[:1], adjusted((0.0, 0.0))) == 0.0


def test_a_lot_of_which_a_part_was_not_seen_is_one_in_part() -> None:
    half = replace(SEEN, seen=box(0, 0, 20, 20))
    assert unseen_share(half) == pytest.approx(0.5, abs=0.01)
    assert limits_of([], adjusted(), 0.02, half) == (Limit.PARTLY,)
    assert unseen_share(replace(half, outline=Outline())) == 0.0


def test_a_name_that_cannot_be_shown_is_that_of_the_kind() -> None:
    assert source_of(SourceKind.FILM, "DJI 1.MP4").words == "film DJI 1.MP4"
    assert source_of(SourceKind.PHOTOGRAPHS, "\ud800").name == "photographs"


def test_turn_and_scale_err_as_a_fit_to_noisy_places_does() -> None:
    rng = np.random.default_rng(1)
    places = np.array([(north, east) for north in (0.0, 20.0, 40.0) for east in (0.0, 12.0, 24.0, 36.0)])
    own = (places - places.mean(axis=0)) @ (1, 1j)
    said = own + rng.normal(0, 1.5, (4000, len(own))) + 1j * rng.normal(0, 1.5, (4000, len(own))) + (3 + 4j)
    fitted = (said - said.mean(axis=1, keepdims=True)) @ own.conj() / (np.abs(own) ** 2).sum()
    expected = fit_error(places, 1.5)
    assert np.angle(fitted).std() == pytest.approx(expected, rel=0.05)
    assert np.abs(fitted).std() == pytest.approx(expected, rel=0.05)
    assert fit_error(places[:1], 1.5) == np.inf
