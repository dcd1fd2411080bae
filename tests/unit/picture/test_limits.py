from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hawk.lots.survey.source import Limit, SourceKind
from hawk.model.pictures import CameraModel
from hawk.model.plans import Outline
from hawk.picture.limits import limits_of, stretch, unseen_share
from hawk.picture.photographs.scale import Scale
from hawk.picture.reconstruction.alignment import Reconstruction
from hawk.picture.reconstruction.camera_pose import CameraPose
from hawk.picture.values import Provenance, Shot
from tests.unit.lots.surveys import box, survey

CAMERA = CameraModel(480, 360, 360.0, 360.0, 239.5, 179.5)
SEEN = replace(survey(), outline=box(0, 0, 20, 40), seen_ground=box(-5, -5, 40, 60))


def adjusted(*places: tuple[float, float], by_ties: bool = True) -> Reconstruction:
    """Return shots at places north and east, metres."""
    posed = tuple(CameraPose(CAMERA, north, east, 60.0, (0.0, 0.0, 0.0)) for north, east in places)
    return Reconstruction(posed, np.full(len(posed), by_ties, np.bool_), None, 0)


def held(off: float, turn: float = 0.0) -> Scale:
    return Scale(1.0, off, turn, 60.0, True)


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
    assert limits_of([shot(sigma)], adjusted((0.0, 0.0), by_ties=by_ties), held(0.01), scale, SEEN) == wanted


@pytest.mark.parametrize(
    ("off", "turn", "wanted"),
    [(0.06, 0.01, (Limit.STRETCHED,)), (0.01, 0.06, (Limit.STRETCHED,)), (0.04, 0.04, ())],
)
def test_a_map_that_is_held_loosely_is_limited(off: float, turn: float, wanted: tuple[Limit, ...]) -> None:
    three, shots, scale = adjusted(*((k * 20.0, 0.0) for k in range(3))), [shot(2.0)] * 3, held(off, turn)
    assert limits_of(shots, three, scale, 0.02, SEEN) == wanted
    assert stretch(adjusted((0.0, 0.0)), scale) == 0.0


def test_a_lot_of_which_a_part_was_not_seen_is_one_in_part() -> None:
    half = replace(SEEN, seen_ground=box(0, 0, 20, 20))
    assert unseen_share(half) == pytest.approx(0.5, abs=0.01)
    assert limits_of([], adjusted(), held(0.0), 0.02, half) == (Limit.PARTLY,)
    assert unseen_share(replace(half, outline=Outline())) == 0.0


def test_a_name_that_cannot_be_shown_is_that_of_the_kind() -> None:
    assert Provenance("DJI 1.MP4", SourceKind.FILM).source().words == "film DJI 1.MP4"
    assert Provenance("\ud800", SourceKind.PHOTOGRAPHS).source().name == "photographs"
