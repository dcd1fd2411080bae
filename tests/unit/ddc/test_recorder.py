"""Recorded facts decide again: the same facts give the same decisions."""

from __future__ import annotations

import json
from collections.abc import Awaitable, Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import pytest
from pydantic import TypeAdapter

from hawk.comm.protocol.commands import (
    Arm,
    AutonomousExplore,
    AutonomousMove,
    ClearKill,
    Command,
    CompulsiveMove,
    Configure,
    Hold,
    Kill,
    KillRequest,
    KillToken,
    Land,
    ReturnToLaunch,
    RouteRequest,
    SetFailsafes,
    Takeoff,
    parse_command,
)
from hawk.comm.protocol.heartbeat import ClientId
from hawk.ddc.decider import Decider, Decision
from hawk.ddc.facts import Facts
from hawk.ddc.recorder import COMMAND, DECISION, TICK, plain
from hawk.ddc.rules.kill import KillTokens
from hawk.ddc.settings import DdcSettings
from hawk.model.operation import StateName
from hawk.model.plans import Inbound
from hawk.model.poses import GlobalPose
from hawk.model.vehicle import CopterMode
from hawk.store.recording import to_json
from tests.unit.ddc.fakes import DEFAULT_PARAMETERS, PLACE, Rig


@dataclass(frozen=True, slots=True)
class Moment:
    """One recorded moment: its facts, its command (None: a tick), and its decision as it was recorded."""

    facts: Facts
    client: ClientId = ""
    command: Command | None = None
    decision: Mapping[str, Any] | None = None
    """None: nothing was done."""

    @property
    def kill_problem(self) -> str:
        """The recorded outcome of the token of a Kill."""
        for act in () if self.decision is None else self.decision["acts"]:
            if act["act"] == "Record" and act["kind"] == "kill token":
                return str(act["payload"][0][1])
        return ""


def moments(records: Iterable[tuple[str, Mapping[str, Any]]]) -> Iterator[Moment]:
    """Give the recorded moments in order, from the first whole facts on.

    Args:
        records: Topic and payload (plain JSON) of each record; other topics are ignored.
    """
    facts_type = TypeAdapter(Facts)
    known: dict[str, Any] = {}
    open_: Moment | None = None
    for kind, payload in records:
        if kind in (TICK, COMMAND):
            known |= payload["facts"]
            if len(known) < len(fields(Facts)):
                continue
            if open_ is not None:
                yield open_
            open_ = _moment(kind, payload, facts_type.validate_python(known))
        elif kind == DECISION and open_ is not None:
            yield Moment(open_.facts, open_.client, open_.command, payload)
            open_ = None
    if open_ is not None:
        yield open_


def _moment(kind: str, payload: Mapping[str, Any], facts: Facts) -> Moment:
    if kind == TICK:
        return Moment(facts)
    content = {name: value for name, value in payload.items() if name not in ("facts", "client")}
    if content["Type"] == Kill.model_fields["type"].default:
        content["Token"] = "token-never-recorded"  # it stands for the real one
    return Moment(facts, payload["client"], parse_command(json.dumps(content)))


class _RecordedTokens(KillTokens):
    """Confirms a Kill where the recorded flight did."""

    problem = ""

    def redeem(self, client: ClientId, token: str, now: float) -> str:
        """Return the recorded outcome."""
        return self.problem


def decide_again(flight: Iterable[Moment], settings: DdcSettings) -> Iterator[tuple[Moment, Decision]]:
    """Give each moment of a flight, from the start of the program, with the decision that its facts cause now."""
    tokens = _RecordedTokens()
    decider: Decider | None = None
    for moment in flight:
        if decider is None:
            decider = Decider(settings, tokens, moment.facts.now)
        tokens.problem = moment.kill_problem
        if moment.command is None:
            yield moment, decider.tick(moment.facts)
        else:
            yield moment, decider.command(moment.facts, moment.client, moment.command)


async def survey(rig: Rig) -> None:
    """A whole survey: failsafes set, heights saved, explored, moved, home."""
    await rig.run(2)
    rig.order(SetFailsafes())
    await rig.run(3)
    rig.order(Configure(min=12, des=25, max=48))
    await rig.until(StateName.IDLE)  # a thread writes them
    await rig.run(2)
    rig.order(Arm())
    await rig.run(1)
    rig.order(Takeoff())
    await rig.until(StateName.HOVER)
    rig.target_plan(20, 10)
    rig.order(AutonomousExplore())
    await rig.run(8)
    rig.finish_plan()
    await rig.until(StateName.HOVER)
    rig.manager.handle("eve", RouteRequest(x=10, y=10))
    rig.manager.handle("ana", AutonomousMove(x=10, y=0))
    await rig.run(8)
    assert not rig.command(CompulsiveMove(x=500, y=0)).accepted
    rig.order(ReturnToLaunch())
    await rig.until(StateName.IDLE)


async def troubles(rig: Rig) -> None:
    """A start in the air, an operator lost, a breach, a jump, a lost link, a pilot."""
    rig.autopilot.put_in_air()
    await rig.run(1)
    rig.desk.present = False
    await rig.run(3)
    rig.desk.present = True
    await rig.run(1)
    rig.order(CompulsiveMove(x=60, y=0))
    await rig.run(2)
    rig.autopilot.topics.frame_jump.publish(4.0)
    rig.autopilot.topics.estimate_jump.publish(9.0)
    rig.autopilot.move_home(GlobalPose(PLACE.latitude + 0.003, PLACE.longitude, PLACE.altitude))
    await rig.run(1)
    rig.autopilot.north = 148.0
    await rig.run(3)
    rig.autopilot.connected = False
    await rig.run(5)
    rig.autopilot.connected = True
    await rig.run(2)
    rig.autopilot.change_mode(CopterMode.LOITER)
    await rig.run(4)
    rig.order(Land(confirmed=True))
    await rig.until(StateName.IDLE)


async def refusals(rig: Rig) -> None:
    """Refused by the autopilot, by the planner and by the judge; then the motors are cut."""
    await rig.run(2)
    rig.autopilot.refuse["arm"] = "Arm: Throttle too high"
    rig.order(Arm())
    await rig.run(2)
    rig.autopilot.refuse.clear()
    rig.order(Arm())
    await rig.run(1)
    rig.order(Takeoff())
    await rig.until(StateName.HOVER)
    rig.sight.inbound = Inbound.OUTSIDE
    rig.manager.handle("ana", AutonomousMove(x=20, y=0))
    await rig.run(2)
    rig.autopilot.refuse["set_mode"] = "EKF variance"
    rig.order(ReturnToLaunch())
    await rig.run(5)
    rig.autopilot.refuse.clear()
    assert rig.command(Hold(), client="eve").reason
    token = rig.manager.handle_now("ana", KillRequest())
    assert isinstance(token, KillToken)
    assert not rig.command(Kill(token="a guess that is wrong")).accepted
    token = rig.manager.handle_now("ana", KillRequest())
    assert isinstance(token, KillToken)
    rig.order(Kill(token=token.token))
    await rig.run(3)
    rig.order(ClearKill())
    await rig.run(1)


FLIGHTS: list[Callable[[Rig], Awaitable[None]]] = [survey, troubles, refusals]


def recorded(rig: Rig) -> Iterator[tuple[str, dict[str, Any]]]:
    """Give the records as a file would give them back."""
    for kind, payload in rig.records:
        yield kind, json.loads(to_json(payload))


def as_recorded(decision: Any) -> Any:
    return json.loads(to_json(plain(decision)))


@pytest.mark.slow
@pytest.mark.parametrize("fly", FLIGHTS, ids=lambda fly: fly.__name__)
async def test_the_facts_of_a_flight_give_every_decision_again(
    fly: Callable[[Rig], Awaitable[None]], tmp_path: Path
) -> None:
    rig = Rig(tmp_path, parameters=DEFAULT_PARAMETERS if fly is survey else None)
    await fly(rig)
    await rig.close()
    flight = list(moments(recorded(rig)))
    assert len([moment for moment in flight if moment.command is None]) == rig.manager.ticks
    assert sum(moment.decision is not None for moment in flight) > 30
    for moment, decision in decide_again(flight, rig.settings):
        wanted = moment.decision or {"acts": [], "fault": ""}
        assert as_recorded(decision) == wanted, f"at {moment.facts.now}, {moment.command}"


@pytest.mark.slow
async def test_another_fact_gives_another_decision(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    await troubles(rig)
    await rig.close()
    flight = [_without_operator(moment) for moment in moments(recorded(rig))]
    again = [as_recorded(decision) for _, decision in decide_again(flight, rig.settings)]
    assert again != [moment.decision or {"acts": [], "fault": ""} for moment in flight]


async def test_facts_come_back_equal_from_the_recording(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    gathered: list[Facts] = []
    tick = rig.manager._senses.tick

    def noted() -> Facts:
        gathered.append(tick())
        return gathered[-1]

    rig.manager._senses.tick = noted  # type: ignore[method-assign]
    await rig.run(3)
    rig.autopilot.put_in_air()
    await rig.run(2)
    await rig.close()
    assert [moment.facts for moment in moments(recorded(rig))] == gathered


@pytest.mark.slow
async def test_a_reader_may_begin_anywhere(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    await rig.run(5)
    await rig.close()
    whole = [moment.facts for moment in moments(recorded(rig))]
    late = [moment.facts for moment in moments(list(recorded(rig))[37:])]
    assert 60 < len(late) < len(whole)
    assert whole[-len(late) :] == late


def _without_operator(moment: Moment) -> Moment:
    operator = replace(moment.facts.operator, is_present=False)
    return replace(moment, facts=replace(moment.facts, operator=operator))
