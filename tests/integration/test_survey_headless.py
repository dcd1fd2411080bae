"""The headless operator flies the real states over the real web server; autopilot, sight and time are the test's."""

from __future__ import annotations

import asyncio
import contextlib
import math
from collections.abc import AsyncIterator, Awaitable, Callable
from pathlib import Path

import pytest

from hawk.comm.protocol.commands import Ack, Arm, Control, Hold, Kill, KillRequest, KillToken
from hawk.comm.topic import Topic
from hawk.config.sections import OperatorSettings, WebSettings
from hawk.model.lot_map import OccupancyMap
from hawk.model.operation import StateName
from hawk.model.pictures import AnnotatedFrame
from hawk.model.vehicle import CopterMode
from hawk.runtime.performance import LagSummary
from hawk.survey.client import DroneClient
from hawk.survey.handset import SurveyStatus
from hawk.survey.operator import SurveyOperator, SurveyOutcome, SurveyPlan
from hawk.web.app import Page, WebServer
from hawk.web.services import OperatorSide, WebServices
from tests.manual_clock import ManualClock
from tests.pace import PATIENCE_S
from tests.unit.ddc.fakes import DEFAULT_PARAMETERS, Rig

TICKS_A_BEAT = 4
PATIENT = OperatorSettings(operator_timeout_s=60, control_lease_s=300)
"""Time runs hundreds of times faster than the client's signs of life."""

Watch = Callable[[Rig], None]


class Flight:
    """Manager, fake autopilot, web server and client in one loop; time moves when the client has heard."""

    def __init__(self, directory: Path) -> None:
        self.rig = Rig(directory, parameters=DEFAULT_PARAMETERS)
        self.real = ManualClock()
        self.side = OperatorSide.create(self.rig.clock, PATIENT)
        self.side.socket.attach(self.rig.manager.handle_now)
        self.rig.socket.inner = self.side.socket
        for name in ("operator_present", "controller", "controlling_clients", "names", "given_back_by"):
            setattr(self.rig.desk, name, getattr(self.side.desk, name))
        video: Topic[AnnotatedFrame] = Topic("video", self.rig.clock)
        occupancy: Topic[OccupancyMap] = Topic("map", self.rig.clock)
        occupancy.publish(OccupancyMap(map_id="m"))
        self.server = WebServer(
            WebServices(
                clock=self.rig.clock,
                web=WebSettings(port=0),
                operator=PATIENT,
                side=self.side,
                status=self.rig.manager.status,
                occupancy_map=occupancy,
                video=video,
                version="test",
                simulation=True,
                camera_fov_deg=70.0,
                travel_speed_m_s=4.0,
                loop_lag=lambda: LagSummary(0.0, 0.0, 0.0, 1),
                monotonic=self.real,
                reads_per_s=math.inf,  # time passes faster than real
            ),
            Page.load(directory),
        )

    @contextlib.asynccontextmanager
    async def client(self) -> AsyncIterator[DroneClient]:
        async with DroneClient("127.0.0.1", self.server.port) as drone:
            yield drone

    async def pass_time(self, drone: DroneClient, watch: Watch) -> None:
        """For ever: one heartbeat's worth of ticks, then wait until the client has it."""
        while True:
            heard = asyncio.ensure_future(drone.next_heartbeat(10.0))
            watch(self.rig)
            self.real.advance(0.2)
            await self.rig.tick(TICKS_A_BEAT)
            await heard

    async def fly(self, drone: DroneClient, watch: Watch, work: Awaitable[SurveyOutcome]) -> SurveyOutcome:
        """Let time pass while the operator works."""
        time = asyncio.create_task(self.pass_time(drone, watch), name="time")
        try:
            async with asyncio.timeout(PATIENCE_S):
                return await work
        finally:
            time.cancel()
            await asyncio.gather(time, return_exceptions=True)


@pytest.fixture
async def flight(tmp_path: Path) -> AsyncIterator[Flight]:
    made = Flight(tmp_path)
    await made.server.start()
    yield made
    await made.server.close()
    await made.rig.close()


def explored_after(seconds: float) -> Watch:
    """The plan leads north; nothing is left to see after some seconds of exploring."""
    began: list[float] = []

    def watch(rig: Rig) -> None:
        if rig.state is not StateName.AUTONOMOUS_EXPLORE:
            return
        began.append(rig.clock())
        if rig.clock() - began[0] > seconds:
            rig.finish_plan()
        else:
            rig.target_plan(rig.autopilot.north + 10, 0)

    return watch


async def test_a_whole_survey_that_sets_the_failsafes(flight: Flight) -> None:
    async with flight.client() as drone:
        operator = SurveyOperator(drone, SurveyPlan(set_failsafes=True))
        outcome = await flight.fly(drone, explored_after(10.0), operator.run())
    assert outcome.status is SurveyStatus.DONE, outcome
    assert (outcome.landed, outcome.disarmed) == (True, True)
    assert outcome.distance_m is not None
    assert outcome.distance_m > 10
    autopilot = flight.rig.autopilot
    assert autopilot.values["FS_GCS_ENABLE"] != 0
    assert autopilot.values["SYSID_MYGCS"] == 245
    assert not autopilot.armed
    assert autopilot.asked("set_mode")[-1] is CopterMode.RTL
    assert autopilot.targets
    assert all(target.mode == CopterMode.GUIDED for target in autopilot.targets)
    assert not flight.side.desk.controller()


async def test_without_failsafes_it_stays_on_the_ground(flight: Flight) -> None:
    async with flight.client() as drone:
        outcome = await flight.fly(drone, lambda _: None, SurveyOperator(drone, SurveyPlan()).run())
    assert outcome.status is SurveyStatus.FAILED
    assert "--set-failsafes" in outcome.reason
    assert flight.rig.autopilot.count("arm") == 0


async def test_without_a_lot_it_searches_and_comes_home_with_status_3(flight: Flight) -> None:
    flight.rig.sight.lot = False
    async with flight.client() as drone:
        operator = SurveyOperator(drone, SurveyPlan(set_failsafes=True))
        outcome = await flight.fly(drone, lambda _: None, operator.run())
    assert outcome.status is SurveyStatus.NO_LOT, outcome
    assert not flight.rig.autopilot.armed
    norths = [target.north for target in flight.rig.autopilot.targets]
    assert max(norths) - min(norths) > 15, "it looked around"


async def test_ctrl_c_while_exploring_brings_it_home(flight: Flight) -> None:
    async with flight.client() as drone:
        operator = SurveyOperator(drone, SurveyPlan(set_failsafes=True))
        lead = explored_after(1000.0)

        def watch(rig: Rig) -> None:
            lead(rig)
            if rig.autopilot.north > 15:
                operator.interrupt()

        outcome = await flight.fly(drone, watch, operator.run())
    assert outcome.status is SurveyStatus.INTERRUPTED
    assert (outcome.landed, outcome.disarmed) == (True, True)


async def test_hold_by_a_watcher_stops_it_and_the_survey_goes_on(flight: Flight) -> None:
    async with flight.client() as drone, flight.client() as watcher:
        operator = SurveyOperator(drone, SurveyPlan(set_failsafes=True))
        lead = explored_after(12.0)
        holds: list[asyncio.Task[object]] = []

        def watch(rig: Rig) -> None:
            lead(rig)
            if rig.autopilot.north > 15 and not holds:
                holds.append(asyncio.create_task(watcher.ask(Hold())))

        outcome = await flight.fly(drone, watch, operator.run())
        await holds[0]
    assert outcome.status is SurveyStatus.DONE
    assert any("hold" in text.lower() or "holding" in text.lower() for text in flight.rig.log)


async def test_kill_needs_control_and_its_token_and_then_cuts(flight: Flight) -> None:
    rig = flight.rig
    rig.autopilot.put_in_air()
    await rig.run(1.0)
    async with flight.client() as drone, flight.client() as watcher:
        await drone.order(Control(action="Request"))
        refused = await watcher.ask(KillRequest())
        assert isinstance(refused, Ack)
        assert not refused.accepted
        token = await drone.ask(KillRequest())
        assert isinstance(token, KillToken)
        stolen = await watcher.ask(Kill(token=token.token))
        assert isinstance(stolen, Ack)
        assert not stolen.accepted
        assert rig.autopilot.count("kill") == 0
        await drone.order(Kill(token=token.token))
        await rig.tick(2)
        assert rig.autopilot.count("kill") >= 1
        again = await drone.ask(Kill(token=token.token))
        assert isinstance(again, Ack)
        assert not again.accepted, "a token is used once"
        rig.manager.process()
        asking = asyncio.create_task(drone.ask(Arm()))
        while not asking.done():
            await rig.tick()
        refused = asking.result()
        assert isinstance(refused, Ack)
        assert not refused.accepted, "Arm waits until the kill is cleared"
