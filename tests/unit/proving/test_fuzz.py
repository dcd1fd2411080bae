from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from hawk.comm.autopilot.telemetry import Telemetry
from hawk.comm.mavlink.frames import heartbeats
from hawk.comm.mavlink.peer import PeerKeeper
from hawk.comm.protocol.commands import Ack, Command, Outgoing, parse_command
from hawk.comm.protocol.heartbeat import ClientId
from proving.fuzz.__main__ import figures, link_figures
from proving.fuzz.answers import id_of, problem_with
from proving.fuzz.cases import Case, Cases
from proving.fuzz.datagrams import AUTOPILOT, Datagrams, frame
from proving.fuzz.link import ROUND, LinkRun
from proving.fuzz.run import Result, Run

MESSAGES = 3000


@pytest.mark.fault(
    "fuzzed messages, HTTP requests and WebSocket frames",
    "each is answered once with field and remedy, nothing raises, a second client's commands are all answered",
)
@pytest.mark.slow
async def test_some_thousand_fuzzed_messages_find_nothing(tmp_path: Path) -> None:
    result = await Run(tmp_path, 1, MESSAGES).run()
    assert result.findings == []
    assert result.messages == MESSAGES
    assert result.accepted > MESSAGES / 20, "valid commands are among them"
    assert result.refused > MESSAGES / 2
    assert result.connections > MESSAGES / 100
    assert result.witnessed == 2 * -(-MESSAGES // 32)
    assert len(result.reasons) > 50


@pytest.mark.slow
async def test_a_defect_behind_a_command_is_found(tmp_path: Path) -> None:
    def broken(client: ClientId, command: Command) -> Outgoing:
        raise RuntimeError("a defect")

    run = Run(tmp_path, 1, 320)
    run.rig.side.socket.attach(broken)
    result = await run.run()
    assert any("a defect" in finding for finding in result.findings)


@pytest.mark.slow
@pytest.mark.nightly
async def test_a_lost_answer_is_found(tmp_path: Path) -> None:
    run = Run(tmp_path, 1, 64)
    send = run.rig.side.hub.send_to
    answers: list[str] = []

    def lossy(client: ClientId, text: str) -> None:
        answers.append(text)
        if len(answers) % 20:
            send(client, text)

    run.rig.side.socket._send_to = lossy
    result = await run.run()
    assert any("messages" in finding or "witness" in finding for finding in result.findings)


@pytest.mark.slow
def test_cases_depend_on_seed_and_number_only() -> None:
    first, again, other = Cases(1), Cases(1), Cases(2)
    drawn = [first.at(number) for number in range(200)]
    assert [again.at(number) for number in reversed(range(200))] == drawn[::-1]
    assert [other.at(number) for number in range(200)] != drawn


def test_many_cases_are_valid_commands() -> None:
    valid, cases = 0, Cases(1)
    for number in range(500):
        case = cases.at(number)
        try:
            valid += isinstance(case.message, str) and bool(parse_command(case.message))
        except ValueError:
            continue
    assert valid > 100


def refusal(reason: str) -> dict[str, Any]:
    answer: dict[str, Any] = json.loads(Ack(id=1, accepted=False, reason=reason).to_json())
    return answer


@pytest.mark.parametrize(
    ("message", "reason", "problem"),
    [
        ('{"Type": "Hold", "Fast": 1}', "Fast: is no key of a Hold; leave it out", ""),
        ('{"Type": "Hold", "Fast": 1}', "Something is wrong with it.", "names no field"),
        ('{"Type": "Hold", "Fast": 1}', "Slow: is no key; leave it out", "not at fault"),
        ('{"Type": "Hold", "Fast": 1}', "Fast: is not permitted", "no remedy"),
        ('{"Type": "Hold", "Fast": 1}', "", "0 characters"),
        ('{"Type": "Hold"}', "On the ground.", ""),
        ('{"Type": "Hold"}', "nonsense", "no sentence"),
        (b"\x00", "message: is binary; send JSON text", ""),
        (b"\x00", "On the ground.", "binary"),
    ],
)
def test_a_refusal_is_judged(message: str | bytes, reason: str, problem: str) -> None:
    found = problem_with(Case(message), refusal(reason))
    assert problem in found
    assert bool(found) == bool(problem)


@pytest.mark.parametrize(
    ("message", "found"),
    [('{"Id": 7}', 7), ('{"Id": "a"}', "a"), ('{"Id": true}', None), ("[1]", None), ("{", None), (b"\xff", None)],
)
def test_the_id_of_a_message_is_that_of_its_answer(message: str | bytes, found: str | int | None) -> None:
    assert id_of(message) == found


def test_a_finding_misses_the_limit() -> None:
    shown = {figure.key: figure for figure in figures(Result(messages=10, seconds=2.0, findings=["x"]))}
    assert shown["fuzz_per_s"].value == 5.0
    assert shown["fuzz_findings"].passed is False


@pytest.mark.fault(
    "fuzzed datagrams at the autopilot's port: random fields, damaged frames, noise, a stranger",
    "nothing raises, an honest heartbeat is heard after each 64, the stranger is never believed, the pose is "
    "honest again afterwards. 10⁶ datagrams of seed 1: 15,625 honest heartbeats, 101,296 states, no finding",
)
@pytest.mark.slow
async def test_some_thousand_fuzzed_datagrams_find_nothing() -> None:
    result = await LinkRun(1, 50 * ROUND).run()
    assert result.findings == []
    assert (result.datagrams, result.honest) == (50 * ROUND, 50)
    assert result.strange > ROUND
    assert result.states > result.honest, "fuzzed frames of the autopilot are believed, too"
    assert len(link_figures(result)) == 6


@pytest.mark.slow
async def test_a_defect_behind_a_datagram_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> None:
        raise RuntimeError("a defect")

    monkeypatch.setattr(Telemetry, "_on_attitude", broken)
    run = LinkRun(1, 10 * ROUND)
    result = await run.run()
    assert any("a defect" in finding for finding in result.findings)


@pytest.mark.fault("fuzzed datagrams at the autopilot's port: random fields, damaged frames, noise, a stranger")
@pytest.mark.slow
async def test_a_stranger_that_is_believed_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(PeerKeeper, "admit", lambda *_: True)
    result = await LinkRun(1, 10 * ROUND).run()
    assert any("a stranger was believed" in finding for finding in result.findings)


def test_datagrams_depend_on_seed_and_number_only() -> None:
    first, again, other = Datagrams(1), Datagrams(1), Datagrams(2)
    drawn = [first.at(number) for number in range(200)]
    assert [again.at(number) for number in reversed(range(200))] == drawn[::-1]
    assert [other.at(number) for number in range(200)] != drawn


def test_a_frame_is_read_as_it_was_made() -> None:
    payload = bytes.fromhex("040000000203810403")
    for version in (0xFD, 0xFE):
        (beat,) = heartbeats(frame(0, payload, AUTOPILOT, version=version))
        assert (beat.system, beat.component, beat.autopilot, beat.base_mode) == (*AUTOPILOT, 3, 0x81)
