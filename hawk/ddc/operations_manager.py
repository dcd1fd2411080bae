"""Operations Manager (specification section 18): the tick. Gather facts, decide, act, report.

`process` runs once a tick and never waits. `hawk.ddc.senses` gathers, `hawk.ddc.decider` decides, `hawk.ddc.performer`
acts, `hawk.ddc.status` reports; facts, commands and decisions are recorded.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from typing import Any

from hawk.comm.protocol.command_table import COMMAND_TABLE
from hawk.comm.protocol.commands import Ack, Command, Outgoing
from hawk.comm.protocol.heartbeat import ClientId, CommandOption, CommandSocket, DroneStatus
from hawk.comm.topic import Topic
from hawk.ddc.acts import Ask, ReadParameter
from hawk.ddc.battery.survey import Battery, SurveyReading
from hawk.ddc.decider import Decider, Decision
from hawk.ddc.facts import Facts
from hawk.ddc.fence.keepers import FenceKeeper, OutlineKeeper
from hawk.ddc.memory import remember
from hawk.ddc.orders import Cause, CauseKind
from hawk.ddc.parameters.failsafes import NOT_IN_EVERY_VERSION
from hawk.ddc.parameters.heights import ParameterStore
from hawk.ddc.performer import Performer, Tools
from hawk.ddc.readings.topic_interface import DdcTopicInterface
from hawk.ddc.recorder import Recorder
from hawk.ddc.requests.flight_log import FlightLog, Trail
from hawk.ddc.requests.requests import FenceChecks, Outcomes, Requests
from hawk.ddc.requests.service_interface import DdcServiceInterface, ReqFailed
from hawk.ddc.rules.failed_ticks import FailingTicks, holds_in_air
from hawk.ddc.rules.follower import flight_goes_on
from hawk.ddc.rules.judge import options
from hawk.ddc.rules.kill import KillTokens
from hawk.ddc.rules.needs import Situation
from hawk.ddc.senses import Senses, Sources
from hawk.ddc.settings import ManagerSetup
from hawk.ddc.states.base import State
from hawk.ddc.status import Reporter
from hawk.ddc.words import fault_words
from hawk.model.operation import FlightSoFar, Health, StateName
from hawk.model.plans import HeightParameters
from hawk.model.sentences import say, sentence, words_of
from hawk.model.vehicle import CopterMode, LandedState

SHUTDOWN_WAIT_S = 3.0
"""Longest wait for RTL at the end of the program, real seconds."""

_LOGGER = logging.getLogger(__name__)
_MAY_FAIL = frozenset(Ask(ReadParameter(name), 0.0).name for name in NOT_IN_EVERY_VERSION)
"""Requests that fail with an autopilot of another version: nobody need look."""


class OperationsManager:
    """Complete when constructed; `init` begins."""

    def __init__(
        self,
        setup: ManagerSetup,
        message_socket: CommandSocket,
        ddc_topic_interface: DdcTopicInterface,
        ddc_service_interface: DdcServiceInterface,
    ) -> None:
        """Build the parts and read the stored heights and fence.

        Raises:
            FenceError: The configured fence file cannot be used.
        """
        self._setup = setup
        self._socket = message_socket
        self._topics = ddc_topic_interface
        self._service = ddc_service_interface
        self._tick_s = 1.0 / setup.settings.flight.tick_hz
        self._failing = FailingTicks(setup.speed)
        self._returns: set[asyncio.Task[None]] = set()
        self._trail = Trail(self._keep_flight)
        self.fences = FenceKeeper(setup.settings, setup.directory)
        self.outlines = OutlineKeeper(setup.settings.flight.outline_file, setup.survey)
        self.outcomes = Outcomes()
        self.log = FlightLog(setup.clock, setup.utc)
        self.requests = Requests(setup.clock, self._request_ended)
        self.status: Topic[DroneStatus] = Topic("status", setup.clock)
        self.own_health = Health()
        self.ticks = 0
        """Ticks that are progress for the watchdog: see `hawk.ddc.rules.failed_ticks`."""
        self._store, self._heights, self._heights_problem = _read_heights(setup)
        self._performer = Performer(self._tools())
        self._reporter = Reporter(
            self.log, self._trail, self.outcomes, lambda: (self.fences.setup, self.outlines.setup), self.status
        )
        self._survey = SurveyReading(setup.settings, setup.survey, continues_survey=setup.continues_survey)
        self._senses = Senses(self._sources())
        tokens = KillTokens(setup.new_token)
        goes_on = flight_goes_on(setup.flight, setup.moment(), setup.speed) is not None
        self._decider = Decider(
            setup.settings,
            tokens,
            setup.clock(),
            continues_survey=setup.continues_survey,
            right_parameters=setup.flight.parameters if setup.flight is not None and goes_on else None,
        )
        self._recorder = Recorder(
            setup.record, lambda: remember(self._decider, setup.settings, tokens), setup.wants_memory
        )
        self._stop_hearing: Callable[[], None] = lambda: None

    # -- the specification's access programs ---------------------------------------------------------------------

    def init(self) -> None:
        """Publish the first state, heights and nothing desired; listen to the autopilot's messages."""
        self._topics.init()
        self._service.init()
        self._topics.heights_pub.publish(self._heights)
        self._topics.curr_state_pub.publish(self.state.identity)
        if self._heights_problem:
            self.log.add(
                "warning", say("Stored heights cannot be used; the configured ones are."), self._heights_problem
            )
        for notice in (self.fences.notice, self.outlines.notice):
            if notice is not None:
                self.log.add(*notice)
        self._stop_hearing = self._topics.vehicle.status_text.listen(self.log.hear)

    def process(self) -> None:
        """Run one tick: commands, facts, decisions, acts, the status."""
        self._guarded(self._take_commands)
        facts = self._gather()
        is_sound = facts is not None and self._decide(facts)
        self._guarded(lambda: self._follow_faults(facts, is_sound))
        if facts is not None:
            self._guarded(lambda: self._report(facts))

    # -- for the web server and the composition root -------------------------------------------------------------

    def handle(self, client: ClientId, command: Command) -> Outgoing | None:
        """Decide on a command, act on it, and return the answer; None: the answer follows through the socket."""
        try:
            facts = self._senses.look()
        except Exception as error:
            self._note_fault(error)
            return Ack(id=command.id, accepted=False, reason=sentence(self.own_health.reason))
        if COMMAND_TABLE[command.type].begins_flight and self._failing.is_failing:
            reason = say("{fault}: wait until it starts again.", fault=self.own_health.reason)
            return Ack(id=command.id, accepted=False, reason=reason)
        self._guarded(lambda: self._recorder.prepare(facts.now))
        decision = self._decider.command(facts, client, command)
        self._guarded(lambda: self._recorder.command(facts, client, command, decision))
        self._perform(decision)
        return decision.answer

    def handle_now(self, client: ClientId, command: Command) -> Outgoing:
        """Act at once on a command that passes every queue: Hold, Return To Launch, Land, Kill Request, Kill.

        Raises:
            ValueError: The command is another one.
        """
        answer = self.handle(client, command)
        if answer is None:
            raise ValueError(f"{command.type} is not a command that passes the queue")
        return answer

    @property
    def state(self) -> State:
        """The active state."""
        return self._decider.state

    def situation(self) -> Situation:
        """Return what commands are judged on at this moment."""
        return self._decider.situation(self._senses.look())

    def options(self) -> tuple[CommandOption, ...]:
        """Return for every command whether it would be accepted now, and the reason if not."""
        return options(self.situation())

    async def shutdown_in_air(self) -> bool:
        """Ask for Return To Launch in the air before the program ends (not in Manual, RTL, Land).

        Where home was moved out of the fence it asks for Land.

        Waits a few real seconds for the answer, no longer.

        Returns:
            True if there was something to do.
        """
        facts = self._senses.look()
        decision = self._leave_air(facts, Cause(say("The program ends."), CauseKind.ALWAYS))
        if decision is None:
            return False
        self._perform(decision)
        try:
            async with asyncio.timeout(SHUTDOWN_WAIT_S):
                lands = self.state.identity is StateName.LAND
                await self._service.set_mode(CopterMode.LAND if lands else CopterMode.RTL)
        except (TimeoutError, ReqFailed) as error:
            _LOGGER.error("return home at the end of the program: %s", error)
        return True

    async def close(self) -> None:
        """Cancel requests under way and end the thread."""
        self._stop_hearing()
        self._senses.close()
        for request in self._returns:
            request.cancel()
        await self.requests.close()
        await self._performer.close()

    def full_battery(self, utc: float) -> Battery:
        """Return a full battery with the drain of the last flights; ``utc`` is now, Unix seconds."""
        return self._survey.full_battery(utc)

    # -- steps of a tick -----------------------------------------------------------------------------------------

    def _take_commands(self) -> None:
        for client, command in self._socket.receive():
            answer = self.handle(client, command)
            if answer is not None:
                self._socket.reply(client, answer)

    def _gather(self) -> Facts | None:
        """Return this tick's facts; None after a fault."""
        try:
            return self._senses.tick()
        except Exception as error:
            self._note_fault(error)
            return None

    def _decide(self, facts: Facts) -> bool:
        """Decide and act; return False when the drone's safety was not looked after."""
        self._guarded(lambda: self._recorder.prepare(facts.now))
        try:
            decision = self._decider.tick(facts)
        except Exception as error:
            self._note_fault(error)
            return False
        self._guarded(lambda: self._recorder.tick(facts, decision))
        return self._perform(decision) and decision.is_sound

    def _perform(self, decision: Decision) -> bool:
        """Act; return False when the autopilot did not hear of an act."""
        if decision.fault:
            self.own_health = Health.bad(decision.fault)
        faults = self._performer.perform(decision.acts)
        for fault in faults:
            self._note_fault(fault.error)
        return not any(fault.is_vital for fault in faults)

    def _follow_faults(self, facts: Facts | None, is_sound: bool) -> None:
        vehicle = self._topics.get_state() if facts is None else facts.vehicle
        is_airborne = vehicle.armed and vehicle.landed is not LandedState.ON_GROUND
        verdict = self._failing.note(self._setup.clock(), is_sound=is_sound, is_airborne=is_airborne)
        if verdict.is_progress:
            self.ticks += 1
        if verdict.goes_home and holds_in_air(vehicle) and not self._decider.is_cutting:
            self._go_home(facts)

    def _go_home(self, facts: Facts | None) -> None:
        """Ask for Return To Launch past decider and performer, which may be what fails; then switch the state too."""
        request = asyncio.get_running_loop().create_task(self._ask_for_return(), name="ddc: return after a fault")
        self._returns.add(request)
        request.add_done_callback(self._returns.discard)
        cause = Cause(say("A fault in the program."), CauseKind.ALWAYS)
        self.log.add("error", say("A fault in the program: returning home."), self.own_health.reason)
        decision = None if facts is None else self._leave_air(facts, cause)
        if decision is not None:
            self._perform(decision)

    def _leave_air(self, facts: Facts, cause: Cause) -> Decision | None:
        self._guarded(lambda: self._recorder.prepare(facts.now))
        decision = self._decider.leave_air(facts, cause)
        if decision is not None:
            self._guarded(lambda: self._recorder.leave(facts, cause, decision))
        return decision

    async def _ask_for_return(self) -> None:
        try:
            await self._service.set_mode(CopterMode.RTL)
        except Exception as error:  # refused, or the service itself is what fails: it is asked again
            self.log.add("error", say("Returning home was refused."), words_of(error))

    def _report(self, facts: Facts) -> None:
        if facts.position.home is not None and facts.position.home != self._topics.home_pub.value:
            self._topics.home_pub.publish(facts.position.home)
        if facts.witness.doubt != (self._topics.doubt_pub.value or ""):
            self._topics.doubt_pub.publish(facts.witness.doubt)
        self._reporter.follow(facts)
        if self._reporter.is_due(facts.now, self._tick_s):
            self._reporter.report(self._decider.situation(facts), self.own_health)

    def _guarded(self, step: Callable[[], None]) -> None:
        """An unexpected exception makes us unhealthy and visible; it never stops the ticks."""
        try:
            step()
        except Exception as error:
            self._note_fault(error)

    def _note_fault(self, error: Exception) -> None:
        _LOGGER.error("unexpected", exc_info=error)
        self.own_health = Health.bad(fault_words(error))

    # -- parts ---------------------------------------------------------------------------------------------------

    def _tools(self) -> Tools:
        return Tools(
            topics=self._topics,
            service=self._service,
            socket=self._socket,
            requests=self.requests,
            log=self.log,
            heights=self._store,
            fences=self.fences,
            fence_checks=FenceChecks(self._setup.settings, self._socket.reply),
            outlines=self.outlines,
            record=self._record,
            count_start=self._begin_in_air,
            begin_survey=self._begin_survey,
            keep_fall=self._setup.keep_fall,
            outcomes=self.outcomes,
        )

    def _sources(self) -> Sources:
        return Sources(
            clock=self._setup.clock,
            utc=self._setup.utc,
            topics=self._topics,
            service=self._service,
            desk=self._setup.desk,
            fences=self.fences,
            outlines=self.outlines,
            log=self.log,
            requests=self.requests,
            outcomes=self.outcomes,
            settings=self._setup.settings,
            survey=self._survey,
            fall=self._setup.fall,
        )

    def _begin_in_air(self) -> int:
        known = flight_goes_on(self._setup.flight, self._setup.moment(), self._setup.speed)
        if known is not None:
            self._trail.resume(*known, self._setup.clock())
        return self._setup.count_start()

    def _begin_survey(self) -> None:
        self._service.set_datum(None)
        self._survey.begin()
        self._setup.begin_survey()

    def _keep_flight(self, flown: tuple[float, float] | None) -> None:
        flight = None if flown is None else FlightSoFar(*flown, self._setup.moment(), self._decider.right_parameters)
        self._setup.keep_flight(flight)

    def _record(self, kind: str, payload: dict[str, Any]) -> None:
        """Record; a recording that fails is shown, and keeps no act from being performed."""
        self._guarded(lambda: self._setup.record(kind, payload))

    def _request_ended(self, name: str, failure: str) -> None:
        self._record("request ended", {"name": name, "failure": failure})
        if failure:
            _LOGGER.log(logging.DEBUG if name in _MAY_FAIL else logging.WARNING, "%s: %s", name, failure)


def _read_heights(setup: ManagerSetup) -> tuple[ParameterStore, HeightParameters, str]:
    limits = setup.settings.heights
    defaults = HeightParameters(limits.minimum_m, limits.desired_m, limits.maximum_m)
    store = ParameterStore(setup.directory, defaults, setup.settings.ceiling, setup.settings.floor)
    return store, *store.read()
