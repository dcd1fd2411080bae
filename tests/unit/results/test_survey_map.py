from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from hawk.model.lot_map import TILE_CELLS, Cell, Stall, StallState
from hawk.model.poses import GlobalPose
from hawk.model.tile_picture import encode_picture
from hawk.results.map_picture import map_picture
from hawk.results.survey_map import SurveyMap

DATUM = GlobalPose(43.26, -79.92, 100.0)


def stall(number: int, north: float, east: float, state: StallState, taken: float) -> Stall:
    return Stall(number, north, east, math.radians(30), 2.6, 5.4, taken, state, 0.9, 4, 10.0, 1)


def flown_map() -> SurveyMap:
    """Return a map of four stalls, one of each state."""
    tile = np.full((TILE_CELLS, TILE_CELLS), Cell.LOT, np.uint8)
    tile[:, :40] = Cell.NON_LOT
    stalls = [
        stall(7, -10.0, 12.0, StallState.FREE, 0.05),
        stall(2, -16.0, 12.0, StallState.TAKEN, 0.97),
        stall(3, -10.0, 20.0, StallState.UNKNOWN, 0.5),
        stall(9, -16.0, 20.0, StallState.SUGGESTED, 1.0),
    ]
    return SurveyMap(DATUM, {s.id: s for s in stalls}, {(0, 0): tile, (0, 1): tile})


@pytest.fixture
def survey() -> SurveyMap:
    return flown_map()


def test_counts_and_extent(survey: SurveyMap) -> None:
    assert (survey.counts.free, survey.counts.taken, survey.counts.unknown, survey.counts.total) == (1, 1, 1, 3)
    assert survey.counts.suggested == 1
    cells = survey.cells()
    assert cells.values.shape == (TILE_CELLS, 2 * TILE_CELLS)
    assert (cells.north, cells.east) == (0.0, 0.0)


def test_tiles_north_of_the_datum_lie_above_those_south_of_it() -> None:
    north, south = np.full((TILE_CELLS,) * 2, Cell.LOT, np.uint8), np.full((TILE_CELLS,) * 2, Cell.NON_LOT, np.uint8)
    cells = SurveyMap(DATUM, {}, {(-1, -1): north, (0, -1): south}).cells()
    assert cells.north == pytest.approx(25.6)
    assert cells.east == pytest.approx(-25.6)
    assert cells.values[0, 0] == Cell.LOT
    assert cells.values[-1, 0] == Cell.NON_LOT


def test_picture_shows_every_state_differently_even_in_grey(survey: SurveyMap) -> None:
    picture = map_picture(survey)
    assert picture.shape == (TILE_CELLS, 2 * TILE_CELLS, 3)

    def patch(number: int) -> np.ndarray:
        s = survey.stalls[number]
        row, column = int(-s.north * 10), int(s.east * 10)
        return cv2.cvtColor(picture[row - 8 : row + 8, column - 8 : column + 8], cv2.COLOR_BGR2GRAY)

    free, taken, unknown, suggested = patch(7), patch(2), patch(3), patch(9)
    assert suggested.std() == 0, "a suggested one has nothing but its corners"
    assert cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)[160 - 30 : 160 + 30, 200 - 30 : 200 + 30].max() > 240
    assert taken.std() > 2 * free.std()
    assert unknown.mean() < free.mean() - 15


def test_the_mosaic_lies_under_the_stalls(survey: SurveyMap) -> None:
    green = np.zeros((TILE_CELLS, TILE_CELLS, 3), np.uint8)
    green[:] = (20, 200, 20)
    jpeg = cv2.imencode(".jpg", green)[1].tobytes()
    picture = map_picture(SurveyMap(DATUM, survey.stalls, survey.tiles, {(0, 1): jpeg}))
    assert abs(int(picture[200, TILE_CELLS + 100, 1]) - 200) < 5
    assert picture[200, 100, 1] == 150


def test_ground_that_was_not_seen_is_light_and_its_outline_is_smooth(survey: SurveyMap) -> None:
    green = np.zeros((TILE_CELLS, TILE_CELLS, 3), np.uint8)
    green[:] = (20, 200, 20)
    seen = np.full((TILE_CELLS, TILE_CELLS), 255, np.uint8)
    seen[:, 128:] = np.where((np.arange(TILE_CELLS) // 4 % 2)[:, None] > 0, 0, seen[:, 128:])
    seen[:, 132:] = 0
    unknown = np.full((TILE_CELLS, TILE_CELLS), Cell.UNKNOWN, np.uint8)
    picture = map_picture(SurveyMap(DATUM, {}, {(0, 1): unknown}, {(0, 1): encode_picture(green, seen)}))
    assert picture.max(axis=2).min() > 150, "nothing is black"
    edge = [int(np.argmax(row > 100)) for row in picture[20:-20, :, 2]]
    assert max(edge) - min(edge) <= 1, "teeth of 0.4 m are gone"
    assert 120 <= edge[0] <= 140
    assert picture[100, 20].tolist() == pytest.approx([20, 200, 20], abs=4)
    assert picture[100, 200].min() > 220


def test_a_picture_that_cannot_be_read_is_left_out(survey: SurveyMap) -> None:
    picture = map_picture(SurveyMap(DATUM, {}, survey.tiles, {(0, 1): b"no picture"}))
    assert picture[200, TILE_CELLS + 100].tolist() == picture[200, 100].tolist() == [150, 150, 150]
