"""Each act by itself: what it does, and that a fault in one stops no other."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest

from hawk.comm.protocol.commands import Ack, CheckFence, FenceCheck
from hawk.comm.protocol.heartbeat import FenceCorner
from hawk.ddc.acts import (
    Act,
    Ask,
    AskPlace,
    BeginSurvey,
    CompareFence,
    CountStart,
    CutMotors,
    Desire,
    EnableFence,
    EndLots,
    EnterState,
    ForgetAskedModes,
    ForgetHeldFence,
    JudgeFence,
    KeepFall,
    Log,
    PutBack,
    PutFenceInForce,
    ReadParameter,
    Record,
    Reply,
    Request,
    SendMode,
    SendTarget,
    SetArmed,
    SetDatum,
    SetHome,
    SetMode,
    SetParameters,
    SetReturnAltitude,
    SettleMode,
    SetVoice,
    ShowUserError,
    StoreFence,
    StoreHeights,
    TakeOff,
    UploadFence,
    UseHeights,
    UseOutline,
)
from hawk.ddc.fence.geometry import ring_from_map
from hawk.ddc.fence.keepers import FenceKeeper, OutlineKeeper
from hawk.ddc.fence.plan import FencePlan, Standpoint
from hawk.ddc.motion import Goal
from hawk.ddc.parameters.heights import ParameterStore
from hawk.ddc.performer import Performer, Tools
from hawk.ddc.readings.topic_interface import DdcInputs, DdcTopicInterface
from hawk.ddc.requests.flight_log import FlightLog
from hawk.ddc.requests.requests import FenceChecks, Requests
from hawk.ddc.requests.service_interface import DdcServiceInterface
from hawk.ddc.settings import SurveyMemory
from hawk.model.operation import Fall, StateName, UserError
from hawk.model.plans import DesiredPose, HeightParameters, Outline, RoundLot
from hawk.model.vehicle import CopterMode
from tests.manual_clock import ManualClock
from tests.unit.ddc.fakes import PLACE, FakeAutopilot, FakeSocket
from tests.unit.ddc.written_facts import DATUM, FENCE, SETTINGS

SQUARE = ring_from_map(PLACE, ((-80.0, -80.0), (80.0, -80.0), (80.0, 80.0), (-80.0, 80.0)))
PLAN = FencePlan("drawn", SQUARE, 90.0)
HOVER = EnterState(StateName.HOVER, may_send_targets=True, holds=True)


@dataclass
class Stage:
    """A performer with its tools, around a fake autopilot that flies at the datum."""

    directory: Path
    clock: ManualClock = field(default_factory=lambda: ManualClock(100.0))
    records: list[tuple[str, dict[str, Any]]] = field(default_factory=list)
    falls: list[Fall | None] = field(default_factory=list)
    surveys: int = 0

    def __post_init__(self) -> None:
        self.drone = FakeAutopilot(self.clock)
        self.topics = DdcTopicInterface(self.drone.topics, DdcInputs.create(self.clock), self.clock)
        self.service = DdcServiceInterface(self.drone, self.topics, self.clock, 4.0, self.record)
        self.socket = FakeSocket()
        heights = HeightParameters(15.0, 35.0, 60.0)
        self.tools = Tools(
            topics=self.topics,
            service=self.service,
            socket=self.socket,
            requests=Requests(self.clock, lambda _name, _failure: None),
            log=FlightLog(self.clock, lambda: datetime(2026, 1, 1, tzinfo=UTC)),
            heights=ParameterStore(self.directory, heights, SETTINGS.ceiling, SETTINGS.floor),
            fences=FenceKeeper(SETTINGS, self.directory),
            fence_checks=FenceChecks(SETTINGS, self.socket.reply),
            outlines=OutlineKeeper(SETTINGS.flight.outline_file, SurveyMemory()),
            record=self.record,
            count_start=lambda: 2,
            begin_survey=self.begin_survey,
            keep_fall=self.falls.append,
        )
        self.performer = Performer(self.tools)

    def record(self, kind: str, payload: dict[str, Any]) -> None:
        self.records.append((kind, payload))

    def begin_survey(self) -> None:
        self.surveys += 1

    def do(self, *acts: Act) -> None:
        assert self.performer.perform(acts) == []

    async def ask(self, request: Request) -> None:
        self.do(Ask(request, self.clock()))
        await self.tools.requests.finish()
        await asyncio.sleep(0)

    def fly(self) -> None:
        self.drone.put_in_air()
        self.drone.publish()
        self.topics.fence_pub.publish(FENCE)


@pytest.fixture
async def stage(tmp_path: Path) -> AsyncIterator[Stage]:
    made = Stage(tmp_path)
    yield made
    await made.performer.close()


@pytest.mark.parametrize(
    ("request_", "call"),
    [
        (SetArmed(True), ("arm", None)),
        (SetArmed(False), ("disarm", None)),
        (SetMode(CopterMode.RTL), ("set_mode", CopterMode.RTL)),
        (SendMode(CopterMode.LAND), ("send_mode", CopterMode.LAND)),
        (TakeOff(35.0), ("takeoff", 35.0)),
        (SetReturnAltitude(15.0), ("set_rtl_altitude", 15.0)),
        (UploadFence(FENCE), ("upload_fence", FENCE)),
        (CompareFence(FENCE), ("compare_fence", FENCE)),
        (SetHome(DATUM), ("set_home", DATUM)),
        (CutMotors(), ("kill", None)),
        (ReadParameter("RTL_ALT"), ("get_parameter", "RTL_ALT")),
        (SetParameters((("FS_GCS_ENABLE", 1.0),)), ("set_parameter", ("FS_GCS_ENABLE", 1.0))),
        (PutBack("FENCE_ENABLE", 1.0), ("set_parameter", ("FENCE_ENABLE", 1.0))),
        (EnableFence(), ("enable_fence", None)),
    ],
    ids=lambda value: type(value).__name__,
)
async def test_each_request_reaches_the_autopilot_as_it_is(
    stage: Stage, request_: Request, call: tuple[str, Any]
) -> None:
    await stage.ask(request_)
    assert stage.drone.calls[0] == call
    (answer,) = stage.tools.requests.answers()
    assert not answer.is_pending


async def test_a_parameter_that_was_read_is_a_fact(stage: Stage) -> None:
    await stage.ask(ReadParameter("RTL_ALT"))
    (answer,) = stage.tools.requests.answers()
    assert (answer.is_done, answer.value) == (True, 1500.0)


class TestTargets:
    async def test_one_is_sent_by_a_state_that_may_send_them_and_recorded(self, stage: Stage) -> None:
        stage.fly()
        stage.do(HOVER, SendTarget(Goal(1.0, 2.0, 30.0, 0.5)))
        (sent,) = stage.drone.targets
        assert (sent.north, sent.east, sent.height, sent.yaw) == (1.0, 2.0, 30.0, 0.5)
        assert ("target", {"north": 1.0, "east": 2.0, "height": 30.0, "yaw": 0.5}) in stage.records
        assert stage.tools.outcomes.target_refusal == ""

    async def test_one_that_is_refused_is_a_fact_and_recorded_once(self, stage: Stage) -> None:
        stage.fly()
        stage.do(SendTarget(Goal(1.0, 2.0, 30.0, 0.5)))
        assert stage.drone.targets == [], "the program begins in a state that sends none"
        reason = stage.tools.outcomes.target_refusal
        assert reason == "Idle sends no targets"
        stage.do(SendTarget(Goal(1.0, 2.0, 30.0, 0.5)))
        assert stage.records.count(("target refused", {"reason": reason})) == 1
        stage.do(HOVER, SendTarget(Goal(500.0, 2.0, 30.0, 0.5)))
        assert len([kind for kind, _ in stage.records if kind == "target refused"]) == 2
        stage.do(SendTarget(Goal(1.0, 2.0, 30.0, 0.5)))
        assert stage.tools.outcomes.target_refusal == ""

    async def test_a_state_that_holds_may_hold_where_a_task_may_not_go(self, stage: Stage) -> None:
        stage.fly()
        above_max = SendTarget(Goal(5.0, 0.0, 80.0, 0.0))
        stage.drone.height = 80.0
        stage.drone.publish()
        stage.do(HOVER, above_max)
        assert len(stage.drone.targets) == 1
        stage.do(replace(HOVER, holds=False), above_max)
        assert len(stage.drone.targets) == 1


async def test_the_state_is_published_and_idle_forgets_the_fence_that_was_held(stage: Stage) -> None:
    stage.drone.held_fence = FENCE
    await stage.ask(CompareFence(FENCE))
    assert stage.service.held_fence is not None
    stage.do(HOVER)
    assert stage.topics.curr_state_pub.value is StateName.HOVER
    assert stage.service.held_fence is not None
    stage.do(EnterState(StateName.IDLE, may_send_targets=False, holds=False))
    assert stage.service.held_fence is None


async def test_what_is_desired_is_published_and_the_highest_number_counted(stage: Stage) -> None:
    outcomes, desired = stage.tools.outcomes, stage.topics.des_pose_pub
    stage.do(Desire(None))
    assert (desired.value, outcomes.desired_count) == (None, 0)
    for number, count in ((5, 5), (3, 5), (6, 6)):
        stage.do(Desire(DesiredPose(number, 1.0, 2.0)))
        assert (desired.value, outcomes.desired_count) == (DesiredPose(number, 1.0, 2.0), count)
    stage.do(AskPlace(DesiredPose(9, 3.0, 4.0)))
    assert stage.topics.asked_place_pub.value == DesiredPose(9, 3.0, 4.0)
    assert outcomes.desired_count == 6


async def test_what_is_published_reported_and_kept(stage: Stage) -> None:
    heights, fall = HeightParameters(16.0, 21.0, 41.0), Fall(5.0)
    outline = Outline((SQUARE,), lots=(RoundLot("one", "North"), RoundLot("two", "South", 0)))
    stage.do(
        UseHeights(heights),
        UseOutline(outline),
        EndLots(("one",)),
        PutFenceInForce(FENCE),
        SetDatum(DATUM),
        BeginSurvey(),
        SetVoice(False),
        CountStart(),
        KeepFall(fall),
        Log("warning", "Wind.", "9 m/s"),
        Reply("ana", Ack(id=3, accepted=True)),
        Record("kind", (("a", 1.0),)),
        ShowUserError(UserError.NO_LOT_DETECTED, "No lot."),
    )
    assert stage.topics.heights_pub.value == heights
    over = (replace(outline.lots[0], is_over=True), outline.lots[1])
    assert stage.tools.outlines.outline == replace(outline, lots=over)
    assert stage.topics.fence_pub.value == FENCE
    assert stage.service.datum == DATUM
    assert (stage.surveys, stage.falls, stage.tools.outcomes.starts_in_air) == (1, [fall], 2)
    assert stage.drone.asked("set_voice") == [False]
    (entry,) = stage.tools.log.entries
    assert (entry.level, entry.text, entry.details) == ("warning", "Wind.", "9 m/s")
    assert stage.socket.replies == [("ana", Ack(id=3, accepted=True))]
    assert ("kind", {"a": 1.0}) in stage.records
    outcomes = stage.tools.outcomes
    assert (outcomes.user_error, outcomes.user_error_text) == (UserError.NO_LOT_DETECTED, "No lot.")


async def test_modes_that_were_asked_for_are_forgotten(stage: Stage) -> None:
    await stage.ask(SetMode(CopterMode.RTL))
    assert stage.service.asked_for(CopterMode.RTL)
    stage.do(ForgetAskedModes())
    assert not stage.service.asked_for(CopterMode.RTL)


async def test_of_the_modes_that_were_asked_for_those_before_the_last_are_settled_away_once_it_shows(
    stage: Stage,
) -> None:
    await stage.ask(SetMode(CopterMode.RTL))
    await stage.ask(SetMode(CopterMode.LAND))
    stage.do(SettleMode(CopterMode.LAND))
    assert not stage.service.asked_for(CopterMode.RTL)
    assert stage.service.asked_for(CopterMode.LAND)


async def test_the_fence_that_is_held_is_forgotten(stage: Stage) -> None:
    stage.drone.held_fence = FENCE
    await stage.ask(CompareFence(FENCE))
    stage.do(ForgetHeldFence())
    assert stage.service.held_fence is None


async def test_heights_are_stored(stage: Stage) -> None:
    heights = HeightParameters(16.0, 21.0, 41.0)
    await stage.ask(StoreHeights(heights))
    assert stage.tools.heights.read()[0] == heights


class TestFence:
    async def test_a_stored_fence_is_planned_and_shown_on_the_ground(self, stage: Stage) -> None:
        stage.service.set_datum(PLACE)
        stage.drone.publish()
        await stage.ask(StoreFence(PLAN))
        assert stage.tools.fences.plan == PLAN
        shown = stage.topics.fence_pub.value
        assert shown is not None
        assert (len(shown.polygon), shown.autopilot_ceiling) == (4, 90.0)
        stage.clock.advance(1.0)
        await stage.ask(StoreFence(None))
        assert stage.tools.fences.plan.source == "circle"

    @pytest.mark.parametrize("missing", ["datum", "place"])
    async def test_without_a_datum_or_a_place_it_is_planned_alone(self, stage: Stage, missing: str) -> None:
        if missing == "datum":
            stage.drone.publish()
        else:
            stage.service.set_datum(PLACE)
        await stage.ask(StoreFence(PLAN))
        assert stage.tools.fences.plan == PLAN
        assert stage.topics.fence_pub.value is None
        assert stage.tools.requests.answers()[0].is_done

    async def test_a_drone_that_a_pilot_armed_meanwhile_keeps_the_fence_in_force(self, stage: Stage) -> None:
        stage.fly()
        await stage.ask(StoreFence(PLAN))
        assert stage.tools.fences.plan == PLAN
        assert stage.topics.fence_pub.value is FENCE

    async def test_one_late_disarmed_changes_no_fence_in_flight(self, stage: Stage) -> None:
        stage.fly()
        stage.do(EnterState(StateName.MANUAL, may_send_targets=False, holds=False))
        stage.drone.armed = False
        stage.drone.publish()
        await stage.ask(StoreFence(PLAN))
        assert stage.topics.fence_pub.value is FENCE


async def test_a_fence_that_is_asked_about_is_answered(stage: Stage) -> None:
    corners = [FenceCorner(latitude=latitude, longitude=longitude) for latitude, longitude in SQUARE]
    command = CheckFence(id=8, corners=corners, ceiling=90)
    stage.do(JudgeFence("ana", command, HeightParameters(15.0, 35.0, 60.0), Standpoint(PLACE, PLACE, 15.0)))
    async with asyncio.timeout(10.0):
        await stage.socket.replied.wait()
    ((client, answer),) = stage.socket.replies
    assert isinstance(answer, FenceCheck)
    assert (client, answer.id, answer.problem) == ("ana", 8, "")


class TestFaults:
    async def test_one_stops_no_other_act_and_says_whether_the_autopilot_heard(self, stage: Stage) -> None:
        def fail(*_: object) -> None:
            raise OSError("disk full")

        broken = Performer(replace(stage.tools, record=fail, keep_fall=fail))
        stage.fly()
        faults = broken.perform(
            (KeepFall(None), Record("a", ()), HOVER, SendTarget(Goal(1.0, 2.0, 30.0, 0.5)), Log("info", "After."))
        )
        assert [(str(fault.error), fault.is_vital) for fault in faults] == [
            ("disk full", False),
            ("disk full", False),
            ("disk full", True),  # the target's record
        ]
        assert len(stage.drone.targets) == 1
        assert [entry.text for entry in stage.tools.log.entries] == ["After."]
        await broken.close()

    async def test_an_act_that_is_not_known(self, stage: Stage) -> None:
        (fault,) = stage.performer.perform(("Fly",))  # type: ignore[arg-type]
        assert (str(fault.error), fault.is_vital) == ("str is not known", False)

    async def test_it_ends_once_and_waits_for_its_files(self, stage: Stage) -> None:
        stage.do(Ask(StoreHeights(HeightParameters(16.0, 21.0, 41.0)), 1.0))
        await asyncio.sleep(0)
        await stage.performer.close()
        assert stage.tools.heights.read()[0].minimum == 16.0
        await stage.performer.close()
