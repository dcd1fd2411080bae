"""Stalls of a picture given to the lots of its outlines."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shapely

from hawk.algo.vision import quads
from hawk.picture.orthophoto.lots import SurveysByLot, without_pictures
from hawk.picture.orthophoto.outline import LotOutline
from hawk.picture.orthophoto.source import Orthophoto
from hawk.picture.orthophoto.survey import Findings
from hawk.picture.orthophoto.windows import Window, WindowStalls, windows_of
from hawk.picture.values import LotSurvey
from tests.unit.picture.orthophoto.drawn import UTM, opened_blank, placed

COLUMNS, ROWS = 600, 400
"""A picture of 60 by 40 m."""


@pytest.fixture
def source(tmp_path: Path) -> Orthophoto:
    return opened_blank(tmp_path, ROWS, COLUMNS, transform=placed(UTM, COLUMNS, ROWS))


def result(window: Window, middles: list[tuple[float, float]], taken: list[float]) -> WindowStalls:
    """Return findings: stalls of 2.5 by 5 m that stand upright."""
    at = np.array(middles, np.float64).reshape(-1, 2)
    corners = quads.corners(at[:, 0], at[:, 1], *(np.full(len(at), v) for v in (np.pi / 2, 25.0, 50.0)))
    seen, none = np.ones((100, 150), np.bool_), np.zeros((0, 4, 2))
    return WindowStalls(window, corners, np.array(taken), np.full(len(at), 0.9), none, ~seen, seen)


def part(source: Orthophoto, left: float, top: float, right: float, bottom: float) -> shapely.Polygon:
    """Return a part of the picture, given in its pixels, on Earth."""
    ring = np.array([(left, top), (right, top), (right, bottom), (left, bottom)], np.float64)
    return shapely.Polygon(source.grid.on_earth(ring)[:, ::-1])


def surveys(source: Orthophoto, *shapes: shapely.Polygon, failed: tuple[Window, ...] = ()) -> list[LotSurvey]:
    middles = [(250.0, 200.0), (300.0, 200.0), (330.0, 200.0), (400.0, 200.0)]
    (window,) = windows_of(source)
    findings = Findings.of(source, [result(window, middles, [0.95, 0.9, 0.05, 0.6])])
    return [without_pictures(each) for each in SurveysByLot(findings, LotOutline.of(*shapes), failed)]


def states(survey: LotSurvey) -> list[str]:
    return [stall.state for stall in survey.mapped.survey.stalls]


def test_lots_that_touch_stay_apart_and_stalls_beside_them_are_none(source: Orthophoto) -> None:
    west, east = surveys(source, part(source, 100, 100, 315, 300), part(source, 315, 100, 390, 300))
    assert (states(west), states(east)) == (["taken", "taken"], ["free"])
    assert west.unsure == pytest.approx(1 - 0.9 * (0.95 + 0.9) / 2, abs=1e-6)
    assert west.doubts == ()
    assert west.unseen_share == pytest.approx(0, abs=1e-3)
    assert east.mapped.survey.stalls[0].id == f"{east.facts.id}/1"


def test_of_outlines_that_overlap_the_smaller_one_has_the_stall(source: Orthophoto) -> None:
    large, small = surveys(source, part(source, 100, 100, 500, 300), part(source, 280, 150, 345, 250))
    assert (len(states(large)), states(small)) == (2, ["taken", "free"])
    assert large.doubts == ("It overlaps Lot 2: the smaller outline has the stalls of both.",)


def test_a_stall_on_the_border_belongs_to_the_lot_that_has_most_of_it(source: Orthophoto) -> None:
    """Its middle is a corner of both: an L about it has three quarters, the notch one."""
    notch = part(source, 300, 100, 420, 200)
    around = part(source, 180, 100, 420, 300).difference(notch)
    metres = np.array(source.grid.metres)
    lots = SurveysByLot(
        Findings.of(source, [result(windows_of(source)[0], [(300.0, 200.0)], [0.9])]), LotOutline.of(notch, around)
    )
    exact = [shapely.box(30, 10, 42, 20), shapely.box(18, 10, 42, 30).difference(shapely.box(30, 10, 42, 20))]
    lots._ground = np.array([shapely.transform(each, lambda at: at * metres * 10) for each in exact], object)
    lots._tree = shapely.STRtree(lots._ground)
    assert lots._owners(lots._findings.stalls.corners).tolist() == [1]


def test_a_window_that_was_left_out_is_a_doubt_of_the_lots_at_it(source: Orthophoto) -> None:
    box = (450, 0, 600, 400)
    shapes = part(source, 100, 100, 300, 300), part(source, 310, 100, 430, 300)
    west, east = surveys(source, *shapes, failed=(Window(box, box),))
    assert west.doubts == ()
    assert east.doubts == ("A window at it could not be looked at.",)


@pytest.mark.slow
def test_a_coarse_picture_is_a_doubt_of_every_lot(tmp_path: Path) -> None:
    source = opened_blank(tmp_path, ROWS, COLUMNS, transform=placed(UTM, COLUMNS, ROWS, metres=0.18))
    for each in surveys(source, part(source, 100, 100, 300, 300), part(source, 310, 100, 430, 300)):
        assert each.doubts[0].startswith("A pixel covers more than 12 cm")
