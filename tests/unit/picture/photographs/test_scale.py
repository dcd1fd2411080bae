from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from hawk.model.pictures import CameraModel
from hawk.picture.photographs.scale import (
    HeightPrior,
    Scale,
    ScaleEstimate,
    by_height,
    by_places,
    by_stalls,
    choose_scale,
    middle_height,
    scale_poses,
)
from hawk.picture.reconstruction.alignment import PosePrior, Reconstruction
from hawk.picture.reconstruction.camera_pose import CameraPose
from hawk.picture.values import PictureError, Shot

CAMERA = CameraModel(1200, 800, 800.0, 800.0, 599.5, 399.5)
TRUE_M = 60.0


@dataclass(frozen=True)
class Drawn:
    """A flight at 60 m as it was adjusted: larger than true by the inverse of ``factor``."""

    shots: list[Shot]
    known: list[PosePrior]
    adjusted: Reconstruction
    factor: float

    def decided(self, given: float | None = None, stalls: float | None = None) -> Scale:
        """Return the scale for a height that a person gives, and stalls that say another one, metres."""
        known = self.known
        if given is not None:
            known = [replace(one, posed=replace(one.posed, height=given)) for one in known]
        look = None if stalls is None else ScaleEstimate(stalls / middle_height(self.adjusted), 0.08)
        return choose_scale(
            "yard", by_places(self.shots, known, self.adjusted), by_height(known, self.adjusted, lens_is_known=True),
            HeightPrior(given), middle_height(self.adjusted), lambda _: look,
        )  # fmt: skip


def drawn(seed: int, said_m: float | None = None, lanes: int = 2, count: int = 4, sigma: float = 2.0) -> Drawn:
    """Return a flight whose receiver errs by white noise and by a wander of some minutes; files say ``sigma``."""
    rng = np.random.default_rng(seed)
    factor = math.exp(rng.uniform(-0.2, 0.2))
    white, lasting = rng.uniform(0.05, 0.8, 2) * sigma
    wander = rng.normal(0, lasting, 2)
    heights = TRUE_M * math.exp(rng.normal(0, 0.03)) if said_m is None else said_m
    shots, known, posed = [], [], []
    for k in range(lanes * count):
        lane, step = divmod(k, count)
        place = np.array([lane * 25.0, (step if lane % 2 == 0 else count - 1 - step) * 20.0])
        wander = wander * math.exp(-5 / 600) + rng.normal(0, lasting * math.sqrt(1 - math.exp(-10 / 600)), 2)
        north, east = (place + wander + rng.normal(0, white, 2)).tolist()
        said = CameraPose(CAMERA, north, east, heights, (0.0, 0.0, 0.0))
        shots.append(Shot(Path(f"{k}.jpg"), CAMERA, 0.0, 0.0, None, heights, None, (sigma, sigma), 5.0 * k))
        known.append(PosePrior(said, sigma, 0.6, 0.02, 0.1))
        seen = (place / factor).tolist()
        posed.append(CameraPose(CAMERA, seen[0], seen[1], TRUE_M / factor, (0.0, 0.0, 0.0)))
    return Drawn(shots, known, Reconstruction(tuple(posed), np.ones(len(posed), np.bool_), 0.1, 999), factor)


def _answered(flight: Drawn) -> tuple[Scale, bool]:
    """Return the scale, after the answer to a question that was asked, and whether one was."""
    try:
        return flight.decided(), False
    except PictureError as error:
        fits = re.search(r"--height ([0-9.]+) would fit", str(error))
    return flight.decided(0.0 if fits is None else float(fits[1])), True


@pytest.mark.nightly
@pytest.mark.parametrize(("lanes", "count"), [(2, 3), (2, 4), (3, 8)])
def test_the_true_scale_lies_within_the_bound_in_nine_of_ten_folders_with_wrong_heights(lanes: int, count: int) -> None:
    rng = np.random.default_rng(lanes * count)
    held, asked = [], 0
    for seed in range(200):
        flight = drawn(seed, TRUE_M * math.exp(rng.uniform(-0.5, 0.5)), lanes, count)
        scale, was_asked = _answered(flight)
        held.append(abs(scale.factor / flight.factor - 1) <= scale.off)
        asked += was_asked
    assert np.mean(held) >= 0.9
    assert asked > 100


@pytest.mark.slow
def test_right_heights_are_not_asked_about() -> None:
    asked = [_answered(drawn(seed, lanes=3, count=6))[1] for seed in range(200)]
    assert np.mean(asked) < 0.04


@pytest.mark.parametrize("said_m", [84.0, 42.0])
def test_a_height_above_another_place_is_asked_about_with_the_one_that_fits(said_m: float) -> None:
    flight = drawn(1, said_m, 3, 6)
    with pytest.raises(
        PictureError, match=rf"yard: the files give {said_m:.0f} m.*distances.* say (5[89]|6[012]) m.*--height (5|6)"
    ):
        flight.decided()
    assert flight.decided(60.0).factor == pytest.approx(flight.factor, rel=0.03)


def test_two_heights_for_one_flight_do_not_both_claim_to_be_right() -> None:
    for said_m in (84.0, 42.0):
        with pytest.raises(
            PictureError, match=rf"--height {said_m:g}, but the distances.*--height (5[89]|6[012]) would fit"
        ):
            drawn(1, lanes=3, count=6).decided(said_m)


def test_a_person_and_the_stalls_overrule_places_and_the_bound_is_that_of_a_height() -> None:
    scale = drawn(1, lanes=3, count=6).decided(84.0, stalls=86.0)
    assert scale.height == pytest.approx(84.0)
    assert not scale.is_by_places
    assert scale.off > 0.08


def test_places_that_hang_together_by_nothing_leave_it_to_height_and_stalls() -> None:
    flight = drawn(2, 84.0, 1, 2, sigma=8.0)
    assert flight.decided().off > 0.07
    with pytest.raises(PictureError, match=r"the files give 84 m.*stalls 2\.6 m wide say 57 m.*--height \d+ would fit"):
        flight.decided(stalls=57.0)
    assert flight.decided(84.0, stalls=57.0).height > 70.0, "a person's word goes before the size of stalls alone"


def test_a_map_by_ties_that_fit_badly_claims_less() -> None:
    flight = drawn(3, 60.0, 2, 4)
    rng = np.random.default_rng(1)
    noisy = [
        replace(one, posed=replace(one.posed, north=one.posed.north + n, east=one.posed.east + e))
        for one, (n, e) in zip(flight.known, rng.normal(0, 9.0, (8, 2)).tolist(), strict=True)
    ]
    good, bad = (by_places(flight.shots, known, flight.adjusted) for known in (flight.known, noisy))
    assert good is not None
    assert bad is not None
    assert bad.share > 2 * good.share


def test_places_by_rtk_say_the_scale_to_parts_of_a_thousand() -> None:
    exact = by_places(*(getattr(drawn(4, sigma=0.02), name) for name in ("shots", "known", "adjusted")))
    assert exact is not None
    assert exact.share < 1e-3


def test_one_photograph_says_nothing_by_places_and_few_stalls_nothing_by_their_width() -> None:
    flight = drawn(5)
    alone = replace(flight.adjusted, is_adjusted=np.arange(8) < 1)
    assert by_places(flight.shots, flight.known, alone) is None
    assert by_stalls([2.6] * 5) is None
    stalls = by_stalls([3.38] * 6)
    assert stalls is not None
    assert stalls.factor == pytest.approx(1 / 1.3)


def test_a_map_that_grows_keeps_its_middle_and_photographs_that_lie_alone_their_places() -> None:
    flight = drawn(6)
    some = replace(flight.adjusted, is_adjusted=np.arange(8) < 6)
    larger = scale_poses(some, 1.5)
    before, after = (np.array([(one.north, one.east) for one in each.posed]) for each in (some, larger))
    assert after[:6].mean(axis=0) == pytest.approx(before[:6].mean(axis=0))
    assert np.ptp(after[:6, 1]) == pytest.approx(1.5 * np.ptp(before[:6, 1]))
    assert after[6:].tolist() == before[6:].tolist()
    assert larger.posed[7].height == pytest.approx(1.5 * some.posed[7].height)
