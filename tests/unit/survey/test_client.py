"""The client against the real web server, with the manager in the hands of the test."""

from __future__ import annotations

import asyncio
import contextlib
import zlib
from collections.abc import AsyncIterator
from dataclasses import replace
from pathlib import Path

import pytest

from hawk.comm.base_socket import ConnectionTimeout, FailedToSend
from hawk.comm.protocol.commands import Ack, Arm, Control, Disarm, KillRequest, KillToken, Takeoff
from hawk.comm.protocol.heartbeat import DroneStatus, LogEntry, SiteStatus
from hawk.config.sections import WebSettings
from hawk.lots.store import LotStore
from hawk.model.lot_map import TILE_CELLS, EncodedTile, OccupancyMap, Stall, StallState
from hawk.model.poses import MapPoint
from hawk.survey.client import CommandRefusedError, DroneClient, LinkLostError
from tests.unit.lots.plan.plans import drawn_lot
from tests.unit.web.rig import Rig

TILE = EncodedTile(1, zlib.compress(bytes([2]) * TILE_CELLS**2))
STALL = Stall(4, 1.0, 2.0, 0.5, 2.6, 5.4, 0.25, StallState.FREE, 0.9, 3, 12.0, 1)
MAP = OccupancyMap({(0, 0): TILE}, {(0, 0): EncodedTile(2, b"jpeg")}, {4: STALL}, map_id="m")


@pytest.fixture
async def rig() -> AsyncIterator[Rig]:
    made = Rig()
    await made.start()
    yield made
    assert made.server is not None
    await made.server.close()


def client_of(rig: Rig, token: str | None = None) -> DroneClient:
    assert rig.server is not None
    assert rig.server.port is not None
    return DroneClient("127.0.0.1", rig.server.port, token=token, timeout_s=2.0)


@pytest.fixture
async def drone(rig: Rig) -> AsyncIterator[DroneClient]:
    async with client_of(rig) as made:
        yield made


@contextlib.asynccontextmanager
async def ticking(rig: Rig) -> AsyncIterator[None]:
    """The manager's tick: takes commands and publishes its status."""

    async def tick() -> None:
        while True:
            rig.serve_commands()
            rig.publish_status()
            await asyncio.sleep(0.001)

    task = asyncio.create_task(tick(), name="tick")
    try:
        yield
    finally:
        task.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await task


async def test_start_returns_what_the_drone_says_of_itself(rig: Rig, drone: DroneClient) -> None:
    assert drone.welcome is not None
    assert drone.welcome.simulation is True
    assert drone.is_connected


async def test_nobody_there_is_a_connection_timeout() -> None:
    with pytest.raises(ConnectionTimeout):
        await DroneClient("127.0.0.1", 1, timeout_s=1.0).start()


async def test_the_token_opens_the_door() -> None:
    rig = Rig(web=WebSettings(token="correct-horse-battery"))
    server = await rig.start()
    try:
        with pytest.raises(ConnectionTimeout, match="token"):
            await client_of(rig).start()
        async with client_of(rig, "correct-horse-battery") as drone:
            assert drone.is_connected
    finally:
        await server.close()


async def test_commands_are_answered_each_by_its_own(rig: Rig, drone: DroneClient) -> None:
    await drone.order(Control(action="Request"))
    async with ticking(rig):
        answers = await asyncio.gather(drone.ask(Arm()), drone.ask(Takeoff()), drone.ask(Disarm()))
        assert all(isinstance(answer, Ack) and answer.accepted for answer in answers)
        assert len({answer.id for answer in answers}) == 3
    token = await drone.ask(KillRequest())
    assert isinstance(token, KillToken)


async def test_a_refusal_is_an_error_with_the_drones_reason(rig: Rig, drone: DroneClient) -> None:
    async with ticking(rig):
        with pytest.raises(CommandRefusedError, match="Take control first"):
            await drone.order(Arm())
    async with client_of(rig) as other:
        await other.order(Control(action="Request"))
        with pytest.raises(CommandRefusedError, match="Someone else has control"):
            await drone.order(Control(action="Request"))
        await other.order(Control(action="Release"))
    await drone.order(Control(action="Request"))


async def test_no_answer_is_a_lost_link(rig: Rig, drone: DroneClient) -> None:
    await drone.order(Control(action="Request"))
    with pytest.raises(LinkLostError, match="Arm"):
        await drone.ask(Arm(), timeout_s=0.05)
    with pytest.raises(LinkLostError, match="no heartbeat"):
        await drone.next_heartbeat(0.05)


async def test_lots_are_read_part_by_part_and_without_a_store_it_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("hawk.survey.client.LOTS_AT_ONCE", 1)
    rig = Rig()
    await rig.start()
    async with client_of(rig) as drone:
        with pytest.raises(CommandRefusedError, match="There is no store of lots here"):
            await drone.lots()
    assert rig.server is not None
    await rig.server.close()
    rig = Rig()
    store = rig.lots = LotStore(tmp_path / "lots.db")
    made = [await store.write(lambda connection: drawn_lot(connection, 10)) for _ in range(3)]
    await rig.start()
    async with client_of(rig) as drone:
        assert sorted(each["id"] for each in await drone.lots()) == sorted(made)
    assert rig.server is not None
    await rig.server.close()
    await store.close()


async def test_the_map_is_kept_and_fetched_with_its_pictures(rig: Rig, drone: DroneClient) -> None:
    rig.map.publish(MAP)
    rig.publish(DroneStatus(site=SiteStatus(datum=(43.0, -79.0))))
    async with ticking(rig):
        survey = await drone.survey_map()
    assert survey is not None
    assert survey.stalls == {4: STALL}
    assert set(survey.tiles) == {(0, 0)}
    assert survey.mosaic == {(0, 0): b"jpeg"}
    assert (survey.datum.latitude, survey.datum.longitude) == (43.0, -79.0)


async def test_no_survey_without_a_place_on_earth(rig: Rig, drone: DroneClient) -> None:
    async with ticking(rig):
        assert await drone.survey_map() is None


async def test_a_broken_map_is_asked_for_again(rig: Rig, drone: DroneClient, caplog: pytest.LogCaptureFixture) -> None:
    rig.map.publish(replace(MAP, tiles={(0, 0): EncodedTile(1, b"broken")}))
    rig.publish()
    await drone.next_heartbeat(2.0)
    assert drone.map.tiles == {}
    assert "asked for again" in caplog.text
    rig.map.publish(MAP)
    async with asyncio.timeout(5):
        while drone.map.stalls != {4: STALL}:
            rig.publish()
            await drone.next_heartbeat(2.0)


async def test_log_and_trail_are_collected_once(rig: Rig, drone: DroneClient) -> None:
    def entry(number: int) -> LogEntry:
        return LogEntry(number=number, time="", level="info", text=str(number))

    rig.publish(DroneStatus(log=(entry(1),), trail=(MapPoint(0.0, 0.0),), trail_id=1))
    await drone.next_heartbeat(2.0)
    trail = (MapPoint(0.0, 0.0), MapPoint(1.0, 0.0))
    rig.publish(DroneStatus(log=(entry(1), entry(2)), trail=trail, trail_id=1))
    await drone.next_heartbeat(2.0)
    assert [e.number for e in drone.log] == [1, 2]
    assert [p.north for p in drone.trail] == [0.0, 1.0]
    rig.publish(DroneStatus(trail=(MapPoint(5.0, 0.0),), trail_id=2))
    await drone.next_heartbeat(2.0)
    assert [p.north for p in drone.trail] == [5.0]


@pytest.fixture
def quick_signs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hawk.survey.client.SIGN_INTERVAL_S", 0.01)
    monkeypatch.setattr("hawk.survey.client.SHORTEST_SIGN_INTERVAL_S", 0.01)


@pytest.mark.usefixtures("quick_signs")
async def test_signs_of_life_keep_the_operator_present(rig: Rig, drone: DroneClient) -> None:
    await drone.order(Control(action="Request"))
    rig.clock.advance(9.0)
    last = rig.clock() + 9.0
    async with asyncio.timeout(5), ticking(rig):
        while not rig.side.desk.operator_present(last):
            await drone.next_heartbeat(2.0)


async def test_after_a_lost_link_it_is_back_with_control_and_the_whole_map(rig: Rig, drone: DroneClient) -> None:
    rig.map.publish(MAP)
    await drone.order(Control(action="Request"))
    rig.publish()
    await drone.next_heartbeat(2.0)
    assert drone.map.stalls
    socket = drone._base._socket
    assert socket is not None
    await socket.close()
    async with asyncio.timeout(5):
        await rig.nobody_connected()
        async with ticking(rig):
            await drone.whole_map()
            await drone.order(Arm())
    assert drone.map.stalls == {4: STALL}
    assert drone.heartbeat is not None
    assert drone.heartbeat.in_control


async def test_sending_when_the_drone_is_gone_says_so(rig: Rig, drone: DroneClient) -> None:
    assert rig.server is not None
    await rig.server.close()
    with pytest.raises((FailedToSend, LinkLostError)):
        await drone.order(Arm())


async def test_close_leaves_no_task_behind(rig: Rig) -> None:
    drone = client_of(rig)
    await drone.start()
    await drone.close()
    names = {task.get_name() for task in asyncio.all_tasks()}
    assert not {name for name in names if "drone-client" in name or "message-socket" in name}
