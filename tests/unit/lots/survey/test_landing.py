from __future__ import annotations

import math
import zlib
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest

from hawk.lots.registration.georeference import about, ground_about
from hawk.lots.survey.landing import LandingFacts, at_landing, finished, seen_ground, seen_lot
from hawk.lots.values import LotInputError
from hawk.model.lot_map import CELL_M, TILE_CELLS, Cell, EncodedTile, OccupancyMap, Stall, StallState
from hawk.model.vehicles import MapVehicle, VehicleKind
from hawk.results.survey_map import SurveyMap
from tests.unit.lots.surveys import BEGAN, DATUM, box

STALL = Stall(1, -10.0, 10.0, 0.0, 2.5, 5.0, 0.9, StallState.TAKEN, 0.95, 12, last_seen=40.0, version=3)


def lot_map(stalls: dict[int, Stall]) -> OccupancyMap:
    """One tile: a lot of 14 by 14 m with a hedge of 1 m across it, and a lone patch of 2 by 2 m."""
    cells = np.full((TILE_CELLS, TILE_CELLS), Cell.NON_LOT, np.uint8)
    cells[20:160, 20:160] = Cell.LOT
    cells[80:90, 20:160] = Cell.NON_LOT
    cells[236:256, 236:256] = Cell.LOT
    cells[236:256, 20:50] = Cell.UNKNOWN
    return OccupancyMap(tiles={(0, 0): EncodedTile(1, zlib.compress(cells.tobytes()))}, stalls=stalls, version=5)


def landed(current: OccupancyMap) -> LandingFacts:
    return LandingFacts(
        name="000001-x", datum=DATUM, current=current, outline=None, seconds=100.0, utc=BEGAN, time_is_sure=True,
        flown_s=600.0, program="0.3.0", speed=4.0,
    )  # fmt: skip


def test_stalls_have_the_time_of_their_last_look_at_any_speed_of_the_clock() -> None:
    survey = finished(landed(lot_map({1: STALL})))
    (found,) = survey.stalls
    assert found.looked_at == pytest.approx(BEGAN - 15.0)
    assert survey.began == pytest.approx(BEGAN - 600.0)
    assert (found.id, found.north, found.taken_probability, found.state, found.picture_count) == (
        1,
        -10.0,
        0.9,
        StallState.TAKEN,
        12,
    )


def test_vehicles_have_the_time_of_their_last_look_and_are_none_where_no_network_looked() -> None:
    seen = MapVehicle(7, VehicleKind.VAN, -3.0, 4.0, 0.5, 2.0, 5.5, 0.9, 6, 30.0, last_seen=60.0, version=2)
    (found,) = finished(landed(replace(lot_map({}), vehicles={7: seen}))).vehicles or ()
    assert (found.id, found.kind, found.looks, found.stood_s) == (7, VehicleKind.VAN, 6, 30.0)
    assert found.looked_at == pytest.approx(BEGAN - 10.0)
    assert finished(landed(replace(lot_map({}), vehicles={}))).vehicles == ()
    assert finished(landed(lot_map({}))).vehicles is None


def test_a_stall_that_only_blurred_pictures_showed_says_so() -> None:
    flown = {1: replace(STALL, is_blurred=True), 2: replace(STALL, id=2, is_blurred=False), 3: replace(STALL, id=3)}
    assert [each.is_blurred for each in finished(landed(lot_map(flown))).stalls] == [True, False, None]


def test_suggested_stalls_are_not_of_the_survey() -> None:
    assert finished(landed(lot_map({1: replace(STALL, state=StallState.SUGGESTED)}))).stalls == ()


def test_a_find_beside_given_stalls_is_of_the_survey_with_the_state_that_was_seen() -> None:
    found = replace(STALL, state=StallState.SUGGESTED, extra=StallState.TAKEN)
    (kept,) = finished(landed(lot_map({1: found}))).stalls
    assert (kept.state, kept.is_extra, kept.is_witness) == (StallState.TAKEN, True, True)


def test_the_ground_of_a_lot_is_its_outline_without_its_islands_and_without_lone_patches() -> None:
    outline = seen_lot(SurveyMap.of(DATUM, lot_map({})))
    (ring,) = outline.polygons
    ground = ground_about((DATUM.latitude, DATUM.longitude), outline)
    assert ground.area == pytest.approx(196.0, rel=0.08)
    corners = about((DATUM.latitude, DATUM.longitude), np.array(ring))
    north, east = -20 * CELL_M, 20 * CELL_M
    assert corners[:, 0].max() == pytest.approx(north, abs=0.7)
    assert corners[:, 1].min() == pytest.approx(east, abs=0.7)
    assert corners[:, 0].min() == pytest.approx(north - 14, abs=0.7)


def test_the_ground_that_was_seen_is_all_of_it_with_its_holes() -> None:
    seen = seen_ground(SurveyMap.of(DATUM, lot_map({})))
    ground = ground_about((DATUM.latitude, DATUM.longitude), seen)
    tile = CELL_M * TILE_CELLS
    assert (len(seen.polygons), len(seen.holes)) == (1, 0)  # what was not seen lies at the edge
    assert ground.area == pytest.approx(tile**2 - 6.0, rel=0.04)
    south, west, north, east = ground.bounds
    assert (south, west, north, east) == pytest.approx((-tile, 0.0, 0.0, tile), abs=0.6)
    current = lot_map({})
    cells = np.full((TILE_CELLS, TILE_CELLS), Cell.LOT, np.uint8)
    cells[100:150, 100:150] = Cell.UNKNOWN
    cells[50:60, 50:60] = Cell.UNKNOWN  # hides no stall
    holed = replace(current, tiles={(0, 0): EncodedTile(1, zlib.compress(cells.tobytes()))})
    survey = finished(landed(holed))
    assert (len(survey.seen_ground.polygons), len(survey.seen_ground.holes)) == (1, 1)
    (hole,) = survey.seen_ground.holes
    corners = about((DATUM.latitude, DATUM.longitude), np.array(hole))[:, :2]
    assert (*corners.min(0), *corners.max(0)) == pytest.approx((-15.0, 10.0, -10.0, 15.0), abs=0.7)


def test_nothing_was_seen_without_cells() -> None:
    assert finished(landed(OccupancyMap(stalls={1: STALL}))).seen_ground.polygons == ()


def test_the_outline_that_was_asked_for_is_the_survey_s() -> None:
    asked = box(0, 0, 10, 10)
    assert finished(replace(landed(lot_map({})), outline=asked)).outline == asked


def test_stalls_without_cells_have_their_hull_and_nothing_has_no_outline() -> None:
    outline = finished(landed(OccupancyMap(stalls={1: STALL, 2: replace(STALL, id=2, east=30.0)}))).outline
    area = ground_about((DATUM.latitude, DATUM.longitude), outline).area
    assert area == pytest.approx(5.0 * 22.5, rel=0.01)
    assert finished(landed(OccupancyMap())).outline.polygons == ()


@pytest.mark.fault(
    "a survey holds numbers that are none",
    "refused by the field's name",
)
def test_a_stall_without_a_place_is_refused_by_name() -> None:
    with pytest.raises(LotInputError, match=r"stalls\[1\]\.north: must be a finite number"):
        finished(landed(lot_map({1: replace(STALL, north=math.nan)})))


CLOCK = 1_795_000_000.0


@pytest.mark.parametrize(
    ("heard", "is_kept", "is_sure"),
    [
        (CLOCK + 2.0, True, True),
        (CLOCK + 2.0, False, True),
        (CLOCK + 40 * 365 * 86_400.0, True, False),  # GNSS is in 2062, a time server is not
        (CLOCK - 1024 * 7 * 86_400.0, True, False),  # a receiver after the roll-over of its weeks
        (CLOCK + 90 * 86_400.0, False, True),  # a computer without a clock of its own
        (None, True, True),
        (None, False, False),
    ],
)
def test_the_autopilots_time_and_a_clock_that_is_kept_witness_each_other(
    heard: float | None, is_kept: bool, is_sure: bool
) -> None:
    said = None if heard is None else datetime.fromtimestamp(heard, UTC)
    moment = at_landing(said, CLOCK, is_kept=is_kept)
    assert moment.is_sure is is_sure
    assert at_landing(said, CLOCK, is_kept=is_kept, is_simulated=True).is_sure is (is_sure if said is None else True)
    assert moment.value == (CLOCK if heard is None else heard)


def test_a_survey_that_ends_before_it_begins_is_refused_with_field_and_remedy() -> None:
    flown = replace(landed(lot_map({1: STALL})), flown_s=-60.0)
    with pytest.raises(LotInputError, match=r"^ended: .* is before began, .*: correct the clock"):
        finished(flown)
    assert finished(replace(flown, flown_s=0.0)).began == BEGAN, "pictures of one moment"
