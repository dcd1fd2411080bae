"""Grounds of features: rings run counter-clockwise, and those that cross themselves, have holes or parts are mended."""

from __future__ import annotations

import json

import numpy as np
import pytest
import shapely

from hawk.exports.features import Box, _grounds
from hawk.lots.answers import Geometry
from hawk.lots.storage.outlines import outline_json
from hawk.model.plans import Outline

SQUARE = ((52.0, 5.0), (52.0, 5.1), (52.1, 5.1), (52.1, 5.0))
HOLE = ((52.04, 5.04), (52.04, 5.06), (52.06, 5.06), (52.06, 5.04))
FIVE = (*SQUARE, (52.05, 4.9))
BOW = (SQUARE[0], SQUARE[2], SQUARE[1], SQUARE[3])
FAR = tuple((a + 1, b) for a, b in SQUARE)


def drawn(*outlines: Outline) -> list[Geometry | None]:
    return _grounds([json.loads(outline_json(each)) for each in outlines])


@pytest.mark.parametrize("ring", [SQUARE, SQUARE[::-1], FIVE])
def test_a_ring_runs_counter_clockwise_whichever_it_was(ring: tuple[tuple[float, float], ...]) -> None:
    ((found,),) = [ground.coordinates for ground in drawn(Outline((ring,))) if ground is not None]
    assert shapely.is_ccw(shapely.linearrings(found[0]))
    assert {(a, b) for b, a in found[0]} == set(ring)
    assert found[0][0] == found[0][-1]


def test_a_ring_that_is_closed_already_is_drawn_like_one_that_is_not() -> None:
    assert drawn(Outline(((*SQUARE, SQUARE[0]),))) == drawn(Outline((SQUARE,)))
    ground = drawn(Outline((SQUARE,)))[0]
    assert ground is not None
    assert len(ground.coordinates[0][0]) == len(SQUARE) + 1


def test_each_outline_has_its_own_ground() -> None:
    outlines = (Outline((SQUARE,)), Outline(), Outline((FIVE,)), Outline((BOW,)), Outline((SQUARE, FAR), (HOLE,)))
    grounds = drawn(*outlines)
    areas = [0.0 if each is None else shapely.geometry.shape(dict(each)).area for each in grounds]
    assert areas == pytest.approx([0.01, 0.0, 0.015, 0.0025, 0.02 - 0.0004])  # one wing of the bow stays
    assert grounds[1] is None
    assert [each is None or shapely.geometry.shape(dict(each)).is_valid for each in grounds] == [True] * 5


def test_no_outline_has_no_ground() -> None:
    assert drawn() == []
    assert drawn(Outline()) == [None]


def test_a_box_over_the_date_line_holds_both_sides() -> None:
    boxes = np.array([(179.0, 0, 179.5, 1), (-179.5, 0, -179.0, 1), (0.0, 0, 1.0, 1), (179.0, 5, 179.5, 6)], float)
    assert Box(178.0, -1, -178.0, 2).meets(boxes).tolist() == [True, True, False, False]
    assert Box(-1.0, 0.5, 0.5, 2).meets(boxes).tolist() == [False, False, True, False]
