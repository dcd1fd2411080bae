"""The map of a round divided among its lots: each stall is that of the nearest lot, none is lost or doubled."""

from __future__ import annotations

import zlib
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.lots.survey.landing import LandingFacts, finished
from hawk.lots.survey.round_share import share_of
from hawk.lots.values import FinishedSurvey, journal_of
from hawk.model.lot_map import TILE_CELLS, TILE_M, Cell, EncodedTile, OccupancyMap, Stall
from hawk.model.plans import Outline, RoundLot
from hawk.model.vehicles import MapVehicle, VehicleKind
from tests.unit.lots.survey.test_landing import STALL, landed
from tests.unit.lots.surveys import box

WEST, EAST = box(-18.0, 4.0, 14.0, 12.0), box(-18.0, 34.0, 14.0, 12.0)
NAMES = ("west", "east")
MIDDLE_M = 25.0
"""East of the line that is as far from both lots."""


def round_of(*stalls: Stall, vehicles: dict[int, MapVehicle] | None = None) -> LandingFacts:
    """Return a round over two lots, 18 m apart, whose map is all lot."""
    cells = EncodedTile(1, zlib.compress(np.full((TILE_CELLS, TILE_CELLS), Cell.LOT, np.uint8).tobytes()))
    current = OccupancyMap(
        tiles={(0, 0): cells, (0, 1): cells},
        mosaic={(0, 0): EncodedTile(1, b"w"), (0, 1): EncodedTile(1, b"e")},
        stalls={stall.id: stall for stall in stalls},
        vehicles=vehicles,
    )
    lots = tuple(RoundLot(name, name.title()) for name in NAMES)
    return replace(landed(current), outline=Outline((*WEST.polygons, *EAST.polygons), (), lots))


def at(number: int, east: float, north: float = -10.0) -> Stall:
    return replace(STALL, id=number, north=north, east=east)


def share(flown: LandingFacts, lot: str) -> FinishedSurvey:
    mine = share_of(flown, lot, {})
    assert mine is not None
    return finished(mine)


def test_each_lot_has_its_own_survey_with_its_outline_and_the_lots_beside() -> None:
    flown = round_of(at(1, 10.0), at(2, 40.0), at(3, 41.0))
    west, east = (share(flown, name) for name in NAMES)
    assert ([s.id for s in west.stalls], [s.id for s in east.stalls]) == ([1], [2, 3])
    assert (west.outline, east.outline) == (WEST, EAST)
    assert (west.beside, east.beside) == ((EAST,), (WEST,))
    assert west.origin != east.origin
    assert {journal_of(west.origin), journal_of(east.origin)} == {"000001-x"}


@given(st.lists(st.tuples(st.floats(0.5, 50.0), st.sampled_from(["", "a", "b", "c"])), min_size=1, max_size=12))
def test_a_stall_that_the_flight_knew_is_of_its_own_lot_wherever_the_receiver_puts_it(
    stalls: list[tuple[float, str]],
) -> None:
    """Stall "c" is known, of a lot that is not of the round."""
    flown = round_of(*(replace(at(number, east), known=known) for number, (east, known) in enumerate(stalls)))
    shares = {name: share_of(flown, name, {"a": "west", "b": "east"}) for name in NAMES}
    found = {name: [] if mine is None else [*mine.current.stalls] for name, mine in shares.items()}
    assert sorted([*found["west"], *found["east"]]) == [*range(len(stalls))]
    for number, (_, known) in enumerate(stalls):
        assert known not in {"a", "b"} or number in found[{"a": "west", "b": "east"}[known]]


def test_ground_and_pictures_are_those_of_the_lot() -> None:
    flown = round_of(at(1, 10.0), at(2, 40.0))
    shares = [share_of(flown, name, {}) for name in NAMES]
    masks = []
    for mine in shares:
        assert mine is not None
        known = np.zeros((TILE_CELLS, 2 * TILE_CELLS), np.bool_)
        for (_, column), tile in mine.current.tiles.items():
            cells = np.frombuffer(zlib.decompress(tile.data), np.uint8).reshape(TILE_CELLS, TILE_CELLS)
            known[:, column * TILE_CELLS : (column + 1) * TILE_CELLS] = cells != Cell.UNKNOWN
        masks.append(known)
    assert (masks[0] ^ masks[1]).all(), "each cell is of one lot"
    border = np.flatnonzero(masks[1][100])[0] / TILE_CELLS * TILE_M
    assert border == pytest.approx(MIDDLE_M, abs=1.7)
    assert shares[0] is not None
    assert set(shares[0].current.mosaic) == {(0, 0)}


@given(st.lists(st.tuples(st.floats(-25.0, -0.5), st.floats(0.5, 50.0)), min_size=1, max_size=12))
def test_no_stall_is_lost_or_doubled(places: list[tuple[float, float]]) -> None:
    flown = round_of(*(at(number, east, north) for number, (north, east) in enumerate(places)))
    shares = [share_of(flown, name, {}) for name in NAMES]
    found = [number for mine in shares if mine is not None for number in mine.current.stalls]
    assert sorted(found) == list(range(len(places)))


@pytest.mark.parametrize(("down", "right"), [(0, 0), (3, -2), (-1, 4)])
def test_the_map_may_lie_anywhere_about_its_origin(down: int, right: int) -> None:
    north, east = -down * TILE_M, right * TILE_M
    flown = round_of(at(1, 10.0 + east, -10.0 + north), at(2, 40.0 + east, -10.0 + north))
    assert flown.outline is not None
    lots = [box(-18.0 + north, 4.0 + 30.0 * number + east, 14.0, 12.0) for number in range(2)]
    tiles = {(row + down, column + right): tile for (row, column), tile in flown.current.tiles.items()}
    flown = replace(
        flown,
        outline=replace(flown.outline, polygons=tuple(ring for lot in lots for ring in lot.polygons)),
        current=replace(flown.current, tiles=tiles, mosaic={}),
    )
    for number, name in enumerate(NAMES):
        mine = share_of(flown, name, {})
        assert mine is not None
        assert [*mine.current.stalls] == [number + 1]
        for (row, column), tile in mine.current.tiles.items():
            cells = np.frombuffer(zlib.decompress(tile.data), np.uint8).reshape(TILE_CELLS, TILE_CELLS)
            columns = (
                column * TILE_M + (np.flatnonzero((cells != Cell.UNKNOWN).any(axis=0)) + 0.5) * TILE_M / TILE_CELLS
            )
            is_mine = (columns - east < MIDDLE_M + 1.7) if number == 0 else (columns - east > MIDDLE_M - 1.7)
            assert row == down
            assert is_mine.all()


def test_a_car_is_counted_on_the_nearest_lot() -> None:
    car = MapVehicle(7, VehicleKind.VAN, -3.0, 44.0, 0.5, 2.0, 5.5, 0.9, 6, 30.0, last_seen=60.0, version=2)
    flown = round_of(at(1, 10.0), at(2, 40.0), vehicles={7: car})
    assert [len(share(flown, name).vehicles or ()) for name in NAMES] == [0, 1]


def test_a_lot_that_nothing_was_seen_of_has_no_survey() -> None:
    flown = round_of(at(1, 10.0), replace(at(2, 40.0), seen=0))
    assert share_of(flown, "east", {}) is None
    assert share_of(flown, "another", {}) is None
    assert share_of(replace(flown, current=OccupancyMap()), "west", {}) is None


def test_a_lot_of_sections_alone_has_its_survey_once_it_is_over() -> None:
    flown = round_of(at(1, 10.0))
    assert flown.outline is not None
    assert share_of(flown, "east", {}) is None
    over = tuple(replace(lot, is_over=True) for lot in flown.outline.lots)
    done = replace(flown, outline=replace(flown.outline, lots=over))
    east = share(done, "east")
    assert (east.stalls, east.outline, east.beside) == ((), EAST, (WEST,))
    assert share_of(replace(done, current=OccupancyMap()), "east", {}) is None
