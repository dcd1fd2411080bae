from __future__ import annotations

import asyncio
import contextlib
import json
from typing import Any

import aiohttp
import pytest

from hawk.comm.message_socket import CLIENT_WAITING
from hawk.comm.protocol.commands import (
    Arm,
    CheckFence,
    Hold,
    Kill,
    KillRequest,
    Land,
    ReturnToLaunch,
    RouteRequest,
    Takeoff,
)
from hawk.comm.protocol.heartbeat import DroneStatus, OperationStatus, PoseStatus, StatusStamp, VehicleStatus
from hawk.config.sections import WebSettings
from hawk.model.operation import StateName
from hawk.web import ws
from hawk.web.clients import OUTBOX_LIMIT
from hawk.web.services import COUNTERS
from hawk.web.ws import FLOOD_S, IN_FLIGHT_LIMIT, READS_AT_ONCE, READS_PER_S, ReadPace
from tests.unit.web.rig import PATIENCE_S, Connect, Rig, Visitor, browser


async def settle(rig: Rig, tester: Visitor) -> None:
    """Wait until the server has read everything that this client sent."""
    await tester.ask(Type="Heartbeat", Id="settle")


async def test_welcome_has_what_never_changes(connect: Connect) -> None:
    page = await connect()
    assert page.welcome["Simulation"] is True
    assert page.welcome["Version"] == "1.2.3"
    assert (page.welcome["Cell Size"], page.welcome["Tile Cells"]) == (0.1, 256)
    assert (page.welcome["Operator Timeout"], page.welcome["Operator Hold"]) == (10.0, 30.0)


async def test_heartbeat_carries_the_specifications_keys(rig: Rig, connect: Connect) -> None:
    page = await connect()
    rig.publish(
        DroneStatus(
            operation=OperationStatus(state=StateName.HOVER),
            vehicle=VehicleStatus(armed=True),
            pose=PoseStatus(latitude=43.2, local_position_y=2.0),
        )
    )
    beat = await page.next("Heartbeat")
    assert beat["State"] == "Hover"
    assert beat["Armed"] is True
    assert beat["Latitude"] == 43.2
    assert beat["Local Position Y"] == 2.0
    assert beat["Longitude"] is None
    assert beat["Occupancy Map"] is None
    assert (beat["User Error"], beat["Health Status"]) == (0, 0)


async def test_a_command_in_control_reaches_the_manager_and_is_answered(rig: Rig, connect: Connect) -> None:
    page = await connect()
    assert (await page.take_control())["Accepted"]
    await page.send(Type="Arm", Id=7)
    await settle(rig, page)
    ((client, command),) = rig.serve_commands()
    assert command == Arm(id=7)
    assert rig.side.desk.has_control(client)
    assert await page.next("Ack") == {"Type": "Ack", "Id": 7, "Accepted": True, "Reason": ""}


@pytest.mark.nightly
@pytest.mark.parametrize(
    "command",
    [
        {"Type": "Configure", "Min": 15.0, "Des": 30.0, "Max": 60.0},
        {"Type": "Arm"},
        {"Type": "Takeoff"},
        {"Type": "Autonomous Explore"},
        {"Type": "Compulsive Move", "X": 1.0, "Y": 1.0},
        {"Type": "Autonomous Move", "X": 1.0, "Y": 1.0},
        {"Type": "Disarm"},
        {"Type": "Resume"},
        {"Type": "Clear Kill"},
        {"Type": "Set Failsafes"},
    ],
)
async def test_commands_need_control(rig: Rig, connect: Connect, command: dict[str, object]) -> None:
    watcher = await connect()
    answer = await refused(rig, watcher, Id="a", **command)
    reason = "Take control first."
    said = [{"Text": reason, "Code": "take-control-first", "Values": {}}]
    assert answer == {"Type": "Ack", "Id": "a", "Accepted": False, "Reason": reason, "Sentences": said}
    operator = await connect()
    await operator.take_control()
    answer = await refused(rig, watcher, **command)
    assert not answer["Accepted"]
    assert answer["Reason"] == "Someone else has control."


async def refused(rig: Rig, page: Visitor, **command: object) -> dict[str, Any]:
    """Send a command that its sender may not send, and return the answer."""
    await page.send(**command)
    await page.send(Type="Map Resync", Id="settle")
    answers: list[dict[str, Any]] = []
    while not answers or answers[-1]["Id"] != "settle":
        answers.append(await page.next("Ack"))
    assert rig.serve_commands() == []
    assert rig.manager.urgent == []
    return answers[0] if len(answers) == 2 else await page.next("Ack")


async def test_who_only_watches_may_ask_for_a_route_and_check_a_fence(rig: Rig, connect: Connect) -> None:
    await (await connect()).take_control()
    watcher = await connect()
    corners = [{"Latitude": 43.0 + n, "Longitude": -79.0 + n * n} for n in range(3)]
    await watcher.send(Type="Route Request", X=1.0, Y=1.0)
    await watcher.send(Type="Check Fence", Corners=corners, Ceiling=80.0)
    await settle(rig, watcher)
    assert [type(command) for _, command in rig.serve_commands()] == [RouteRequest, CheckFence]


@pytest.mark.nightly
async def test_one_clients_commands_leave_room_for_anothers(rig: Rig, connect: Connect) -> None:
    operator, watcher = await connect(), await connect()
    await operator.take_control()
    for _ in range(100):
        await watcher.send(Type="Arm")
    await watcher.send(Type="Heartbeat", Id="last")
    while (await watcher.next("Ack"))["Id"] != "last":
        pass
    await operator.send(Type="Takeoff")
    await settle(rig, operator)
    assert [command for _, command in rig.serve_commands()] == [Takeoff()]


def test_a_client_that_sends_without_end_is_read_at_its_pace_and_a_page_at_once() -> None:
    pace = ReadPace()
    now, read = 0.0, 0
    while not pace.is_flooded:
        now += pace.pause(now)
        read += 1
    assert now == pytest.approx(FLOOD_S, abs=0.05)
    assert read == pytest.approx(READS_AT_ONCE + READS_PER_S * FLOOD_S, abs=3)
    page = ReadPace()
    assert max(page.pause(n * 0.05) for n in range(400)) == 0.0
    bursts = ReadPace()
    assert max(bursts.pause(n // 40) for n in range(400)) == 0.0
    assert not page.is_flooded
    assert not bursts.is_flooded


@pytest.mark.parametrize("kind", ["Return To Launch", "Land"])
async def test_going_home_needs_control_or_that_nobody_has_it(rig: Rig, connect: Connect, kind: str) -> None:
    watcher = await connect()
    await watcher.send(Type=kind)
    await settle(rig, watcher)
    ((_, command),) = rig.manager.urgent
    assert isinstance(command, ReturnToLaunch | Land)
    rig.manager.urgent.clear()
    await (await connect()).take_control()
    await watcher.next("Ack")
    answer = await refused(rig, watcher, Type=kind)
    assert (answer["Accepted"], answer["Reason"]) == (False, "Someone else has control.")


@pytest.mark.parametrize("command", [{"Type": "Kill Request"}, {"Type": "Kill", "Token": "t" * 32}])
async def test_cutting_the_motors_needs_control_or_that_nobody_has_it(
    rig: Rig, connect: Connect, command: dict[str, object]
) -> None:
    watcher = await connect()
    await watcher.send(**command)
    await settle(rig, watcher)
    assert [taken.type for _, taken in rig.manager.urgent] == [command["Type"]]
    rig.manager.urgent.clear()
    await (await connect()).take_control()
    answer = await refused(rig, watcher, **command)
    assert (answer["Accepted"], answer["Reason"]) == (False, "Someone else has control.")


async def test_anyone_may_hold_and_it_passes_the_queue(rig: Rig, connect: Connect) -> None:
    operator, watcher = await connect(), await connect()
    await operator.take_control()
    await operator.send(Type="Arm")
    await settle(rig, operator)
    assert (await watcher.ask(Type="Hold", Id="h"))["Accepted"]
    ((client, command),) = rig.manager.urgent
    assert command == Hold(id="h")
    assert not rig.side.desk.has_control(client)
    assert rig.side.socket.receive() == []
    assert "Hold came first" in (await operator.next("Ack"))["Reason"], "what was sent before a stop is not done after"


async def test_kill_in_two_steps_passes_the_queue(rig: Rig, connect: Connect) -> None:
    page = await connect()
    await page.take_control()
    await page.send(Type="Kill Request", Id=1)
    token = (await page.next("Kill Token"))["Token"]
    assert (await page.ask(Type="Kill", Token=token))["Accepted"]
    assert [type(command) for _, command in rig.manager.urgent] == [KillRequest, Kill]
    assert rig.side.socket.receive() == []


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("no json", "not JSON"),
        ("{}", "Type: missing"),
        ("[1]", "message"),
        ('{"Type": "Fly"}', "Type"),
        ('{"Type": "Arm", "Speed": 3}', "Speed"),
        ('{"Type": "Compulsive Move", "X": NaN, "Y": 0}', "X"),
        ('{"Type": "Compulsive Move", "X": 1, "Y": 1e999}', "Y"),
        ('{"Type": "Compulsive Move", "X": 1, "Y": 10001}', "Y"),
        ('{"Type": "Compulsive Move", "X": 1}', "Y"),
        ('{"Type": "Configure", "Min": "15", "Des": 30, "Max": 60}', "Min"),
        ('{"Type": "Configure", "Min": 0, "Des": 30, "Max": 60}', "Min"),
        ('{"Type": "Kill", "Token": "short"}', "Token"),
        ('{"Type": "Arm", "Id": true}', "Id"),
        ('{"Type": "Arm", "Id": "' + "x" * 65 + '"}', "Id"),
        ("[" * 15000, "not JSON"),
        ('{"Type": "Arm", "Id": "' + "x" * 17000 + '"}', "too large"),
        ('{"Type": "Arm"' + " " * 500_000 + "}", "too large"),
    ],
)
async def test_bad_text_is_answered_by_what_is_wrong(rig: Rig, connect: Connect, text: str, said: str) -> None:
    page = await connect()
    await page.take_control()
    await page.socket.send_str(text)
    answer = await page.next("Ack")
    assert not answer["Accepted"]
    assert said in answer["Reason"]
    assert len(answer["Reason"]) < 500
    assert (await page.ask(Type="Heartbeat"))["Accepted"], "the connection stays"
    assert rig.side.socket.receive() == []


async def test_a_bad_message_keeps_its_id(connect: Connect) -> None:
    page = await connect()
    assert (await page.ask(Type="Fly", Id="q1"))["Id"] == "q1"


async def test_binary_is_refused_and_the_connection_stays(connect: Connect) -> None:
    page = await connect()
    await page.socket.send_bytes(b"\x00\x01")
    answer = await page.next("Ack")
    assert not answer["Accepted"]
    assert "binary" in answer["Reason"]
    assert (await page.ask(Type="Heartbeat"))["Accepted"]


async def test_a_message_beyond_all_measure_ends_that_connection_only(connect: Connect) -> None:
    other, page = await connect(), await connect()
    await page.socket.send_str("x" * (1024 * 1024 + 1))
    async with asyncio.timeout(5):
        message = await page.socket.receive()
    assert message.type is aiohttp.WSMsgType.CLOSE
    assert message.data == aiohttp.WSCloseCode.MESSAGE_TOO_BIG
    assert (await other.ask(Type="Heartbeat"))["Accepted"]


async def test_a_defect_in_the_manager_is_answered_and_the_connection_stays(
    rig: Rig, connect: Connect, caplog: pytest.LogCaptureFixture
) -> None:
    page = await connect()
    rig.manager.fail = True
    answer = await page.ask(Type="Hold")
    assert not answer["Accepted"]
    assert "a defect" in caplog.text
    assert (await page.ask(Type="Heartbeat"))["Accepted"]


async def test_too_many_commands_are_answered_not_dropped(rig: Rig, connect: Connect) -> None:
    page = await connect()
    await page.take_control()
    for number in range(CLIENT_WAITING + 4):
        await page.send(Type="Takeoff", Id=number)
    answers = [await page.next("Ack") for _ in range(4)]
    assert [a["Id"] for a in answers] == list(range(CLIENT_WAITING, CLIENT_WAITING + 4))
    assert all("Too many commands" in a["Reason"] and not a["Accepted"] for a in answers)
    assert [command.id for _, command in rig.serve_commands()] == list(range(CLIENT_WAITING))


@pytest.mark.slow
@pytest.mark.fault("a viewer sends valid commands without end")
async def test_a_flood_of_one_client_delays_no_other_and_ends_its_connection(
    connect: Connect, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ws, "READS_PER_S", 5.0)
    monkeypatch.setattr(ws, "READS_AT_ONCE", 10)
    monkeypatch.setattr(ws, "FLOOD_S", 0.1)
    operator, flooder = await connect(), await connect()
    ending = asyncio.create_task(until_closed(flooder.socket))
    with contextlib.suppress(ConnectionError):
        for number in range(200):  # 40 s at the pace at which they are read
            await flooder.send(Type="Map Resync", Id=number)
    assert (await operator.ask(Type="Heartbeat", Id="mine"))["Id"] == "mine"
    answers, end = await ending
    assert (end.data, end.extra) == (aiohttp.WSCloseCode.POLICY_VIOLATION, ws.FLOODED)
    assert 10 <= answers < 200
    assert (await operator.ask(Type="Heartbeat", Id="again"))["Id"] == "again"


async def until_closed(socket: aiohttp.ClientWebSocketResponse) -> tuple[int, aiohttp.WSMessage]:
    """Read to the end of a connection; return the number of answers and the last message."""
    answers = 0
    async with asyncio.timeout(PATIENCE_S):
        while (message := await socket.receive()).type is aiohttp.WSMsgType.TEXT:
            answers += '"Ack"' in message.data
    return answers, message


async def test_too_many_pages_are_refused_with_the_setting(rig: Rig, connect: Connect) -> None:
    rig.web = WebSettings(maximum_clients=1)
    first = await connect()
    with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
        await connect()
    assert refused.value.status == 503
    assert (await first.ask(Type="Heartbeat"))["Accepted"]


async def test_a_page_that_goes_makes_room(rig: Rig, connect: Connect) -> None:
    rig.web = WebSettings(maximum_clients=1)
    page = await connect()
    await page.socket.close()
    async with asyncio.timeout(5):
        await rig.nobody_connected()
    await connect()


async def test_heartbeats_are_at_most_ten_a_second_whatever_the_clock_does(rig: Rig, connect: Connect) -> None:
    page = await connect()
    for _ in range(20):  # status every 50 ms real: a simulation at speed 4
        rig.real.advance(0.05)
        rig.clock.advance(0.2)
        rig.status.publish(
            DroneStatus(stamp=StatusStamp(sequence=1 + (rig.status.value or DroneStatus()).stamp.sequence))
        )
        await settle(rig, page)
    rig.publish(DroneStatus(operation=OperationStatus(state=StateName.LAND)))
    beats = 0
    while (await page.next("Heartbeat"))["State"] != "Land":
        beats += 1
    assert beats <= 10


@pytest.mark.nightly
async def test_a_client_that_stops_reading_never_holds_up_another(rig: Rig, connect: Connect) -> None:
    async with browser() as session:
        stuck = await connect(session)  # never reads again
        page = await connect()
        for _ in range(100):
            rig.publish(DroneStatus(operation=OperationStatus(detail="x" * 20_000)))
            assert (await page.next("Heartbeat"))["Sequence"] == rig.sequence
        assert rig.app is not None
        sent_to_stuck = rig.app[COUNTERS].heartbeats - 100
        assert sent_to_stuck <= IN_FLIGHT_LIMIT, "they do not pile up in transit"
        assert (await page.ask(Type="Heartbeat"))["Accepted"]
        await stuck.socket.close()


@pytest.mark.slow
async def test_a_slow_client_gets_the_newest_heartbeat_when_it_reads_again(rig: Rig, connect: Connect) -> None:
    page = await connect()
    for _ in range(5):
        rig.publish()  # no turn of the loop between: all five came due before one could be sent
    assert (await page.next("Heartbeat"))["Sequence"] == 5


async def test_a_status_that_cannot_be_encoded_is_logged_once_and_the_next_goes_out(
    rig: Rig, connect: Connect, caplog: pytest.LogCaptureFixture
) -> None:
    page = await connect()
    for _ in range(3):
        rig.publish(DroneStatus(site=None))  # type: ignore[arg-type]
        await settle(rig, page)
    rig.publish(DroneStatus(operation=OperationStatus(state=StateName.LAND)))
    assert (await page.next("Heartbeat"))["State"] == "Land"
    assert caplog.text.count("could not be built") == 1


async def test_what_is_not_finite_is_null(rig: Rig, connect: Connect) -> None:
    page = await connect()
    rig.publish(DroneStatus(pose=PoseStatus(pose_age=float("inf"), yaw=float("nan"))))
    beat = await page.next("Heartbeat")
    assert (beat["Pose Age"], beat["Yaw"]) == (None, None)


async def test_the_operator_that_is_lost_gets_no_heartbeat_the_others_do(rig: Rig, connect: Connect) -> None:
    lost, watcher = await connect(), await connect()
    await lost.take_control()
    rig.publish()
    assert (await lost.next("Heartbeat"))["In Control"] is True
    rig.clock.advance(10.1)
    rig.publish(DroneStatus(operation=OperationStatus(state=StateName.COMMUNICATION_LOST)))
    while (await watcher.next("Heartbeat"))["State"] != "CommunicationLost":
        pass
    await lost.send(Type="Heartbeat", Id="back")
    answer = json.loads((await lost.socket.receive()).data)
    assert answer["Type"] == "Ack", "no heartbeat came while it was lost"
    rig.publish()
    assert (await lost.next("Heartbeat"))["In Control"] is True


@pytest.mark.fault(
    "the operator in control is lost, another client asks for control",
    "granted at once after `operator_timeout_s` (10 s) of silence; its page names who has it when it is back",
)
async def test_control_of_a_lost_operator_is_granted_at_once_and_it_learns_by_whom(rig: Rig, connect: Connect) -> None:
    lost, watcher = await connect(), await connect()
    await lost.take_control()
    assert not (await watcher.take_control())["Accepted"]
    rig.clock.advance(10.1)
    rig.publish()
    while not (beat := await watcher.next("Heartbeat"))["Controller Lost"]:
        pass
    assert (beat["Controller"], beat["In Control"]) == ("Operator 1", False)
    assert (await watcher.take_control())["Accepted"]
    assert not (await lost.ask(Type="Control", Action="Release"))["Accepted"]
    rig.publish()
    beat = await lost.next("Heartbeat")
    assert (beat["In Control"], beat["Controller Lost"], beat["Control Taken By"]) == (False, False, "Operator 2")


async def test_server_stop_closes_every_connection(rig: Rig, connect: Connect) -> None:
    page = await connect()
    assert rig.server is not None
    async with asyncio.timeout(5):
        closing = asyncio.create_task(rig.server.close())
        message = await page.socket.receive()
        await closing
    assert message.type is aiohttp.WSMsgType.CLOSE
    assert message.data == aiohttp.WSCloseCode.GOING_AWAY
    assert len(rig.side.hub) == 0


async def test_pings_are_answered(connect: Connect) -> None:
    page = await connect(autoping=False)
    await page.socket.ping(b"there?")
    async with asyncio.timeout(5):
        message = await page.socket.receive()
    assert (message.type, message.data) == (aiohttp.WSMsgType.PONG, b"there?")


async def test_heartbeats_wait_for_a_client_that_is_behind_and_go_on_when_it_has_caught_up(
    rig: Rig, connect: Connect
) -> None:
    page = await connect(autoping=False)
    marks: list[bytes] = []
    for _ in range(10):
        rig.publish()
        await asyncio.sleep(0)
    for number in range(IN_FLIGHT_LIMIT + 3):
        if number >= IN_FLIGHT_LIMIT:
            await page.socket.pong(marks[number - IN_FLIGHT_LIMIT])
            rig.publish()
        beat = await page.next("Heartbeat")
        marks.append((await page.socket.receive()).data)
    assert beat["Sequence"] == rig.sequence
    await page.socket.pong(b"of another ping")
    rig.publish()
    with pytest.raises(TimeoutError):
        async with asyncio.timeout(0.05):
            await page.socket.receive()


async def test_a_client_that_never_reads_its_answers_is_disconnected(
    rig: Rig, connect: Connect, caplog: pytest.LogCaptureFixture
) -> None:
    page = await connect()
    (client,) = rig.side.hub._clients.values()
    for _ in range(OUTBOX_LIMIT + 1):
        client.put("an answer")  # no turn of the loop between: none can be sent
    await page.send(Type="Heartbeat")
    async with asyncio.timeout(5):
        await rig.nobody_connected()
    assert "does not read its answers" in caplog.text


async def test_a_writer_that_fails_ends_the_connection_so_that_the_client_connects_again(
    rig: Rig, connect: Connect, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = await connect()

    def fail(_self: object) -> str | None:
        raise ValueError("broken")

    monkeypatch.setattr("hawk.web.clients.Client.take", fail)
    rig.publish(DroneStatus(operation=OperationStatus(state=StateName.HOVER)))
    async with asyncio.timeout(PATIENCE_S):
        while not page.socket.closed:
            await page.socket.receive()
    await rig.nobody_connected()


async def test_a_page_says_that_it_is_hidden_and_any_other_command_shows_somebody_there(
    rig: Rig, connect: Connect
) -> None:
    page = await connect()
    await page.take_control()
    await page.ask(Type="Heartbeat", Hidden=True, Id="hidden")
    assert rig.side.desk.hidden_since() == rig.clock()
    rig.clock.advance(1.0)
    await page.ask(Type="Map Resync", Id="by itself")
    assert rig.side.desk.hidden_since() == rig.clock() - 1.0
    await page.ask(Type="Control", Action="Request", Id="a click")
    assert rig.side.desk.hidden_since() is None
    answer = await refused(rig, page, Type="Heartbeat", Hidden="yes")
    assert "Hidden" in answer["Reason"]
