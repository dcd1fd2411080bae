"""The ground of a survey: where its picture and its stalls lie, and the sheet that is drawn of both."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from hawk.exports import ground as ground_module
from hawk.exports.ground import OCCUPANCY, ground_of, lot_picture, occupancy
from hawk.lots.registration.frames import Move
from hawk.lots.registration.georeference import about
from hawk.lots.survey.source import PictureSource, SourceKind
from hawk.lots.values import LotStoreError, utc
from hawk.model.lot_map import TILE_CELLS, TILE_M
from hawk.model.tile_picture import encode_picture
from hawk.results.map_picture import Caption, Picture
from tests.unit.exports.stored import Stored, mosaic

TILES = {key: tile.data for key, tile in mosaic().items()}


@pytest.mark.slow
def test_the_picture_lies_where_the_survey_saw_it_and_is_cropped_to_it(stored: Stored) -> None:
    ground = ground_of(stored.read(), TILES, Move())
    assert (ground.north, ground.east) == pytest.approx((25.6, -25.6), abs=0.11)
    assert ground.seen.shape == pytest.approx((512, 1024), abs=2)
    assert ground.seen.min() == 255
    moved = ground_of(stored.read(), TILES, Move(3.0, -2.0, 0.0))
    assert (moved.north, moved.east) == pytest.approx((28.6, -27.6), abs=0.11)


@pytest.mark.slow
def test_a_turned_survey_is_turned_back_onto_the_lot(stored: Stored) -> None:
    """A white mark in the survey's picture is found where the move puts it."""
    pixels, seen = np.full((TILE_CELLS, TILE_CELLS, 3), 80, np.uint8), np.full((TILE_CELLS, TILE_CELLS), 255, np.uint8)
    pixels[96:104, 196:204] = 255  # middle 10 m south and 20 m east of the tile's corner
    move = Move(1.0, 2.0, math.radians(2.0))
    ground = ground_of(stored.read(), {**TILES, (0, 1): encode_picture(pixels, seen)}, move)
    ((column, row),) = ground.pixels(move.of(np.array([(-10.0, TILE_M + 20.0)])))
    rows, columns = np.nonzero((ground.image > 200).all(axis=2))
    assert (rows.mean(), columns.mean()) == pytest.approx((row - 0.5, column - 0.5), abs=1.0)
    assert ground.seen.min() == 0, "its corners are not seen"


@pytest.mark.slow
def test_without_a_picture_there_is_ground_about_the_stalls(stored: Stored) -> None:
    survey = stored.read()
    ground = ground_of(survey, {}, Move())
    assert not ground.seen.any()
    stalls = about(survey.origin, np.array([corner for stall in survey.stalls for corner in stall.corners]))[:, :2]
    at = ground.pixels(stalls)
    assert at.min() >= 39
    assert (at.max(axis=0) <= np.array(ground.seen.shape[::-1]) - 39).all()


@pytest.mark.slow
def test_nothing_to_draw_and_a_broken_picture_are_refused(stored: Stored) -> None:
    survey = stored.read()
    with pytest.raises(LotStoreError, match="has neither a picture nor a stall"):
        ground_of(replace(survey, stalls=()), {}, Move())
    with pytest.raises(LotStoreError, match="cannot be read"):
        ground_of(survey, {(0, 0): b"no picture"}, Move())


@pytest.mark.slow
def test_occupancy_has_the_state_of_each_stall_at_its_place(stored: Stored) -> None:
    survey = stored.read()
    ground = ground_of(survey, TILES, Move())
    raster = occupancy(survey, ground)
    middles = about(survey.origin, np.array([stall.place for stall in survey.stalls]))[:, :2]
    columns, rows = ground.pixels(middles).astype(int).T
    assert raster[rows, columns].tolist() == [OCCUPANCY[stall.state] for stall in survey.stalls]
    area = np.count_nonzero(raster) * ground.metres**2
    assert area == pytest.approx(sum(stall.width * stall.length for stall in survey.stalls), rel=0.08)


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("kind", "sure", "unsure"),
    [
        (None, "{time}", "{time} (the clock was not set)"),
        (SourceKind.PHOTOGRAPHS, "{time}, from photographs may", "{time} (time zone not known), from photographs may"),
        (SourceKind.FILM, "{time}, from film may", "{time} (time zone not known), from film may"),
        (SourceKind.ORTHOPHOTO, "{time}, from orthophoto may", "time not known, from orthophoto may"),
    ],
)
def test_the_sheet_says_what_is_not_sure_of_its_time(
    stored: Stored, monkeypatch: pytest.MonkeyPatch, kind: SourceKind | None, sure: str, unsure: str
) -> None:
    captions: list[Caption] = []

    def sheet(picture: Picture, _: float, caption: Caption) -> Picture:
        captions.append(caption)
        return picture

    monkeypatch.setattr(ground_module, "sheet", sheet)
    pictures = None if kind is None else PictureSource(kind, "may")
    for is_sure in (True, False):
        survey = replace(stored.read(), pictures=pictures, time_is_sure=is_sure)
        lot_picture(survey, ground_of(survey, TILES, Move()))
    time = utc(stored.read().ended)
    assert [each.lines[0] for each in captions] == [sure.format(time=time), unsure.format(time=time)]


@pytest.mark.slow
def test_the_sheet_fades_to_paper_without_black_and_stands_above_its_words(stored: Stored) -> None:
    survey = stored.read()
    tiles = {key: data for key, data in TILES.items() if key != (0, 2)}
    picture = lot_picture(survey, ground_of(survey, tiles, Move()))
    ground = ground_of(survey, tiles, Move())
    height, width = ground.seen.shape
    assert picture.shape == (height + 96, max(width, 900), 3)
    assert (picture[ground.seen.shape[0] - 3, width - 3] > 230).all(), "what was not seen is paper"
    assert picture[height - 40 :].min() < 60, "words are dark"
    between_rows = round((ground.north + 4.5) / ground.metres)
    edge = picture[between_rows, width - 300 : width - 200].astype(int).mean(axis=1)
    assert edge[0] < 110
    assert edge[-1] == 236
    assert np.abs(np.diff(edge)).max() < 60, "no jagged edge"
