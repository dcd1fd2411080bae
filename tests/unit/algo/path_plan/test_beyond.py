"""A border of known lot is closed only where what lies beyond it was looked at."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hawk.algo.ground import COARSE_M, CoarseLayers, Mask, Window
from hawk.algo.path_plan.beyond import Border
from hawk.algo.path_plan.field import InformationField, information_field, left_out, share_of, with_beyond
from hawk.algo.path_plan.footprint import Footprint
from hawk.algo.path_plan.phases import GivenUp
from hawk.algo.path_plan.settings import PathPlanSettings

WINDOW = Window(-50, -50, 100, 100, COARSE_M)
PICTURE = Footprint(40.0, 24.0)
SETTINGS = PathPlanSettings()
EVERYWHERE: Mask = np.ones(WINDOW.shape, np.uint8)
LOT = slice(50, 80)
"""Rows of the lot; north of it other ground was seen, as far as a drive goes, and nothing beyond."""


def layers(seen_m: float, *, alike: bool = False) -> CoarseLayers:
    """A lot 48 m deep from a fence to a drive; ``seen_m`` metres north of it were looked at, and are no lot.

    ``alike``: the farthest 5 m of them look like lot, and were seen at the edge of a picture only.
    """
    lot, seen, well, likely = (np.zeros(WINDOW.shape, np.float32) for _ in range(4))
    first = LOT.start - round(seen_m / COARSE_M)
    columns = slice(20, 80)
    for layer in (lot, well, likely):
        layer[LOT, columns] = 1.0
    seen[first:] = 1.0
    well[first:] = 1.0
    if alike:
        likely[first : first + 3, columns] = 1.0
        well[first : first + 3, columns] = 0.0
    return CoarseLayers(WINDOW, lot, seen, well, likely)


def field(known: CoarseLayers, ours: Mask = EVERYWHERE) -> InformationField:
    border = Border(ours, SETTINGS.beyond_m, SETTINGS.beyond_alike_m, SETTINGS.beyond_width_m)
    return information_field(known, EVERYWHERE, SETTINGS.near_lot_m, border)


def north_m2(one: InformationField, worth: float = 1.0) -> float:
    """Wanted square metres north of the lot, by the rule for borders alone."""
    nothing = np.zeros(WINDOW.shape, np.float32)
    share = with_beyond(nothing, one, PICTURE, SETTINGS.beyond_least_m2, worth)
    return float(share[: LOT.start].sum()) * COARSE_M**2


def test_across_a_drive_that_was_seen_the_lot_may_go_on() -> None:
    """Drive, footpath and strip, 11 m: known to be no lot. By the likelihood of lot nothing is wanted behind them."""
    known = layers(11.2)
    one = field(known)
    likely = share_of(one, PICTURE, SETTINGS.last_least_gain_m2, SETTINGS.border, SETTINGS.open_end_m2)
    assert not likely[: LOT.start - 2].any()
    assert north_m2(one) > 600


def test_a_border_is_closed_once_what_lies_beyond_was_looked_at() -> None:
    """So that the drone does not go on for ever."""
    assert north_m2(field(layers(SETTINGS.beyond_m))) == 0
    assert north_m2(field(layers(SETTINGS.beyond_m - 4 * COARSE_M))) > 0


def test_ground_that_looks_like_lot_keeps_the_border_open_farther_out() -> None:
    """Stalls that are not confirmed yet were seen at the edge of a picture, and nothing behind them."""
    far = SETTINGS.beyond_m
    assert north_m2(field(layers(far, alike=True))) > 0
    seen_well = layers(far, alike=True)
    alike = field(replace(seen_well, well=seen_well.seen))
    assert north_m2(alike) > 0, "what lies behind them is open still"


def test_the_drone_goes_out_over_ground_that_looks_like_lot_only_to_look_beyond() -> None:
    known = layers(SETTINGS.beyond_m, alike=True)
    border = Border(EVERYWHERE, SETTINGS.beyond_m, SETTINGS.beyond_alike_m, SETTINGS.beyond_width_m)
    out, at_home = (
        information_field(known, EVERYWHERE, SETTINGS.near_lot_m, replace(border, is_flown_to=is_flown_to))
        for is_flown_to in (True, False)
    )
    without = information_field(known, EVERYWHERE, SETTINGS.near_lot_m)
    assert out.allowed.sum() > without.allowed.sum()
    assert (at_home.allowed == without.allowed).all()
    assert (at_home.passable == without.passable).all()


@pytest.mark.parametrize(("metres", "open_"), [(SETTINGS.beyond_width_m - 2 * COARSE_M, False), (19.2, True)])
def test_the_fence_decides_what_belongs(metres: float, open_: bool) -> None:
    """Of the ground between what was seen and the fence, a strip too narrow for rows does not belong to the lot."""
    ours = EVERYWHERE.copy()
    ours[: LOT.start - round((4.8 + metres) / COARSE_M)] = 0
    assert (north_m2(field(layers(4.8), ours)) > 0) is open_


def test_each_opening_is_worth_all_the_ground_behind_it() -> None:
    """The same opening, before 24 m of unseen ground inside the fence and before 16 m."""
    fences = []
    for metres in (24.0, 16.0):
        ours = EVERYWHERE.copy()
        ours[: LOT.start - round((11.2 + metres) / COARSE_M)] = 0
        fences.append(north_m2(field(layers(11.2), ours), 0.1))
    deep, shallow = fences
    assert deep > 1.3 * shallow > 0


def test_without_worth_or_border_nothing_is_looked_for() -> None:
    known = layers(11.2)
    assert north_m2(field(known), 0.0) == 0
    assert north_m2(information_field(known, EVERYWHERE, SETTINGS.near_lot_m)) == 0


def test_the_drone_may_fly_near_ground_that_looks_like_lot() -> None:
    far = SETTINGS.beyond_m
    plain, alike = (field(layers(far, alike=alike)) for alike in (False, True))
    row = LOT.start - round(far / COARSE_M)
    assert alike.allowed[row, 50]
    assert not plain.allowed[row, 50]


def test_ground_that_was_not_looked_at_stands_under_its_reason() -> None:
    known = layers(11.2)
    known.well[LOT.start : LOT.start + 10, 20:80] = 0.0
    ours = EVERYWHERE.copy()
    ours[:, 75:] = 0  # five columns of the lot lie outside the fence
    area = COARSE_M**2
    outside, hidden, given_up, beside = left_out(field(known, ours), PICTURE).sum((1, 2))
    assert (outside, hidden, given_up) == (pytest.approx(10 * 5 * area), 0.0, 0.0)
    assert beside > 600
    border = Border(ours, SETTINGS.beyond_m, SETTINGS.beyond_alike_m, SETTINGS.beyond_width_m)
    south = np.zeros_like(EVERYWHERE)
    south[75:] = 1  # the drone may be at the lot's other end only: 12 m from there are in its pictures
    limited = information_field(known, south, SETTINGS.near_lot_m, border)
    assert left_out(limited, PICTURE).sum((1, 2))[1] == pytest.approx(10 * 55 * area)


def test_places_that_were_given_up_close_the_border_in_the_end() -> None:
    given_up, one = GivenUp(SETTINGS), field(layers(11.2))
    before = north_m2(one)
    for number in range(7):
        given_up.add((20.0, 12.0 * number - 40.0))
    taken_out = given_up._taken_out(one, PICTURE.depth)  # the scene about it is of no interest here
    assert before > 600
    assert north_m2(taken_out) == 0
    assert left_out(taken_out, PICTURE).sum((1, 2))[2] > 600
