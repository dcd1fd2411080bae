"""Autonomous Move over an L-shaped lot: the straight path leaves it, the flown one does not.

The lot is put into the flight journal as an earlier flight would have left it, and flown below the height from which
pictures are looked at, so that what is known of it stays.
"""

from __future__ import annotations

import itertools
from collections.abc import AsyncIterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import pytest_asyncio
import shapely

from hawk.algo.ground import Window
from hawk.algo.mapper import delta
from hawk.algo.mapper.evidence import EVIDENCE_M
from hawk.algo.mapper.grid import EvidenceGrid, EvidenceTile
from hawk.comm.protocol.commands import Ack, AutonomousMove, Disarm, NewSurvey, RouteAnswer, RouteRequest
from hawk.comm.protocol.heartbeat import Heartbeat, Point
from hawk.model.lot_map import Cell
from hawk.model.operation import StateName, UserError
from hawk.store.journal import FlightJournal
from hawk.survey.stack import SimulatedStack
from tests.integration.daemon_support import Operator, end_daemon, operator, over_a_picture

pytestmark = [pytest.mark.integration, pytest.mark.alone, pytest.mark.asyncio(loop_scope="module")]

LOT = shapely.union(shapely.box(-8.0, -8.0, 50.0, 12.0), shapely.box(30.0, -8.0, 50.0, 60.0))
"""(north, east) metres of the map: an L about where the drone takes off."""
TARGET = (42.0, 54.0)
OFF_LOT = (0.0, 40.0)
GNSS_M = 1.0
"""Greatest error of the drone's own position, metres."""


@dataclass(frozen=True)
class Flight:
    answer: RouteAnswer
    answer_off_lot: RouteAnswer
    refused: Ack
    refused_beat: Heartbeat
    beats: list[Heartbeat]
    arrived: Heartbeat


@dataclass(frozen=True)
class Another:
    """Heartbeats and map ids about a new survey after the flight: before it, after it, and armed after a restart."""

    before: tuple[Heartbeat, str | None]
    after: tuple[Heartbeat, str | None]
    restarted: tuple[Heartbeat, str | None]
    surveys: list[str]


def lot_parts() -> dict[str, bytes]:
    """Return the journal's parts of a map that shows `LOT` and ground about it that is none."""
    window = Window.around(np.array(LOT.buffer(30.0).envelope.exterior.coords), EVIDENCE_M)
    grid = EvidenceGrid()
    for key, in_tile, in_window in window.tiles():
        tile = grid.tiles.setdefault(key, EvidenceTile())
        rows = np.arange(in_window[0].start, in_window[0].stop) + window.row
        columns = np.arange(in_window[1].start, in_window[1].stop) + window.column
        north, east = np.meshgrid(-(rows + 0.5) * EVIDENCE_M, (columns + 0.5) * EVIDENCE_M, indexing="ij")
        is_lot = shapely.contains_xy(LOT, north, east)
        tile.layers.shown[in_tile] = np.where(is_lot, Cell.LOT, Cell.NON_LOT)
        tile.layers.lot[in_tile] = np.where(is_lot, 4.0, -4.0)
        tile.layers.looks[in_tile] = 8.0
    parts = {delta.tile_name(delta.GRID, key): tile.to_bytes() for key, tile in grid.tiles.items()}
    return parts | {delta.META: delta.MapMeta("drawn", 1, 1, (0.0, 0.0, 0.0)).to_bytes()}


async def put_into_journal(folder: Path) -> None:
    journal = FlightJournal(folder / "run" / "store" / "journal")
    journal.put_map(lot_parts())
    assert await journal.flush(10.0)
    await journal.close()


@pytest_asyncio.fixture(loop_scope="module", scope="module")
async def flown(tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[tuple[Flight, Another]]:
    folder = tmp_path_factory.mktemp("route")
    stack = over_a_picture(folder)
    try:
        url = (await stack.start()).url
        async with operator(url) as pilot:
            await pilot.arm()
            await pilot.order(Disarm())
            await pilot.until_down()
        await end_daemon(stack)
        await put_into_journal(folder)
        await stack.start_daemon()
        async with operator(url) as pilot:
            await pilot.take_off()
            await pilot.until(lambda b: (b.lot_area or 0.0) > 1000.0)
            flight = await fly(pilot)
            await pilot.come_home()
        another = await begin_another(stack, url, folder)
    finally:
        await stack.stop()
    yield flight, another


@pytest.fixture
def flight(flown: tuple[Flight, Another]) -> Flight:
    return flown[0]


@pytest.fixture
def another(flown: tuple[Flight, Another]) -> Another:
    return flown[1]


async def begin_another(stack: SimulatedStack, url: str, folder: Path) -> Another:
    """Begin a new survey on the ground, end the daemon, and arm with the next one."""
    async with operator(url) as pilot:
        await pilot.take_control()
        before = await pilot.until(lambda b: (b.lot_area or 0.0) > 1000.0), pilot.drone.map.map_id
        await pilot.order(NewSurvey())
        after = await pilot.until(lambda b: not b.lot_area and b.datum is None), pilot.drone.map.map_id
    await end_daemon(stack)
    await stack.start_daemon()
    async with operator(url) as pilot:
        await pilot.arm()
        restarted = await pilot.until(lambda b: b.datum is not None and b.home is not None), pilot.drone.map.map_id
    surveys = sorted(path.name for path in (folder / "run" / "store" / "journal").iterdir())
    return Another(before, after, restarted, surveys)


async def fly(pilot: Operator) -> Flight:
    off_lot = AutonomousMove(x=OFF_LOT[0], y=OFF_LOT[1], frame="Map")
    answer_off_lot = await pilot.drone.ask(RouteRequest(x=OFF_LOT[0], y=OFF_LOT[1], frame="Map"))
    assert isinstance(answer_off_lot, RouteAnswer)
    refused = await pilot.drone.ask(off_lot)
    assert isinstance(refused, Ack)
    refused_beat = await pilot.until(lambda b: b.user_error != UserError.NONE)
    answer = await pilot.drone.ask(RouteRequest(x=TARGET[0], y=TARGET[1], frame="Map"))
    assert isinstance(answer, RouteAnswer)
    await pilot.order(AutonomousMove(x=TARGET[0], y=TARGET[1], frame="Map"))
    beats: list[Heartbeat] = []

    def arrived(beat: Heartbeat) -> bool:
        beats.append(beat)
        return beat.state == StateName.HOVER

    await pilot.until_state(StateName.AUTONOMOUS_MOVE)
    return Flight(answer, answer_off_lot, refused, refused_beat, beats, await pilot.until(arrived))


def place(beat: Heartbeat) -> tuple[float, float]:
    assert beat.north is not None
    assert beat.east is not None
    return beat.north, beat.east


def line(points: Sequence[Point]) -> shapely.LineString:
    return shapely.LineString([(p.north, p.east) for p in points])


async def test_the_straight_path_leaves_the_lot_and_the_flown_one_does_not(flight: Flight) -> None:
    places = [place(beat) for beat in flight.beats]
    assert not shapely.covers(LOT.buffer(GNSS_M), shapely.LineString([places[0], TARGET]))
    assert shapely.covers(LOT.buffer(GNSS_M), shapely.LineString(places))
    assert np.hypot(*np.subtract(place(flight.arrived), TARGET)) < 3.0
    assert flight.arrived.detail.startswith("There.")


async def test_the_distance_was_known_before_and_nothing_flew_for_it(flight: Flight) -> None:
    assert flight.answer.refused is None
    assert flight.answer.length is not None
    assert shapely.covers(LOT, line(flight.answer.points))
    assert line(flight.answer.points).length == pytest.approx(flight.answer.length, abs=0.5)
    flown = sum(np.hypot(*np.subtract(a, b)) for a, b in itertools.pairwise(map(place, flight.beats)))
    assert flown == pytest.approx(flight.answer.length, rel=0.15)


async def test_the_distance_left_is_shown_in_flight_and_not_after(flight: Flight) -> None:
    moving = [beat for beat in flight.beats if beat.state == StateName.AUTONOMOUS_MOVE]
    assert len(moving) > 20
    assert all(len(beat.route) >= 2 for beat in moving)
    assert all(shapely.covers(LOT.buffer(GNSS_M), line(beat.route)) for beat in moving)
    left = [line(beat.route).length for beat in moving]
    assert left[-1] < 10 < left[0]
    assert flight.arrived.route == ()


async def test_it_does_not_stop_at_the_corner(flight: Flight) -> None:
    speeds = [beat.speed or 0.0 for beat in flight.beats if beat.state == StateName.AUTONOMOUS_MOVE]
    assert min(speeds[15:-15]) > 1.0


async def test_a_place_off_the_lot_is_refused_with_user_error_1(flight: Flight) -> None:
    assert not flight.refused.accepted
    assert "outside the lot" in flight.refused.reason
    assert flight.refused_beat.user_error == UserError.DESIRED_LOCATION_OUT_OF_BOUNDS
    assert flight.refused_beat.state == StateName.HOVER
    assert flight.answer_off_lot.refused == flight.refused.reason


async def test_a_new_survey_empties_the_map_and_keeps_the_earlier_one_on_disk(another: Another) -> None:
    (_, former), (after, current) = another.before, another.after
    assert former != current
    assert (after.free, after.taken, after.lot_area) == (0, 0, 0.0)
    assert len(another.surveys) >= 2, "each has a journal of its own"


async def test_after_a_restart_the_earlier_survey_does_not_come_back(another: Another) -> None:
    restarted, map_id = another.restarted
    assert map_id != another.before[1]
    assert not restarted.lot_area
    assert restarted.state == StateName.ARM
