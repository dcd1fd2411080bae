"""Decider: judges commands, reacts and decides. It sees facts, returns acts, and does nothing itself.

The same facts and commands give the same decisions: `hawk.ddc.replay` decides a recorded flight again.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial

from hawk.comm.protocol.commands import Ack, Command, Outgoing
from hawk.comm.protocol.heartbeat import ClientId
from hawk.ddc.acts import Acts, BeginSurvey, EnterState, ForgetAskedModes, Log, Record, Step
from hawk.ddc.facts import Facts, KeptFacts
from hawk.ddc.keeping.keeper import Keeper
from hawk.ddc.orders import Cause, Order, ToHover, ToIdle, ToManual, Transition
from hawk.ddc.readings.link import VehicleEvent
from hawk.ddc.rules import guard
from hawk.ddc.rules.command_desk import CommandDesk, Ruling, answer_record
from hawk.ddc.rules.follower import FALLEN, VehicleFollower, forgotten
from hawk.ddc.rules.judge import Bench, Case
from hawk.ddc.rules.kill import KillSwitch, KillTokens
from hawk.ddc.rules.notices import GroundReports, SurveyNotice, WitnessReports
from hawk.ddc.rules.silence import SilenceRule
from hawk.ddc.settings import DdcSettings
from hawk.ddc.states.base import State
from hawk.ddc.states.factory import make_state
from hawk.ddc.states.ground import Idle
from hawk.ddc.states.returning import returning
from hawk.ddc.words import fault_words
from hawk.model.operation import StateName
from hawk.model.sentences import say, sentence

_LOGGER = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Decision:
    """Acts in their order, the answer to a command (None: it follows), and a fault of the program, in words."""

    acts: Acts
    answer: Outgoing | None
    fault: str
    is_sound: bool
    """False for a tick in which a step failed that keeps the drone safe: autopilot's changes, Kill, guard, state."""


class Decider:
    """Holds the operation state, and is the only one to switch it."""

    def __init__(
        self,
        settings: DdcSettings,
        tokens: KillTokens,
        now: float,
        *,
        continues_survey: bool = False,
        right_parameters: Mapping[str, float] | None = None,
    ) -> None:
        """Begin in Idle.

        ``continues_survey``: the map of an earlier run was restored. ``right_parameters``: those of the autopilot that
        were right in the flight that goes on.
        """
        self._settings = settings
        self._continues_survey = continues_survey
        self._kill = KillSwitch()
        self._keeper = Keeper(settings, right_parameters)
        self._kept = KeptFacts()
        self._ground = GroundReports(settings.heights.highest_obstacle_m)
        self._witness = WitnessReports()
        self._desk = CommandDesk(tokens, self._kill, self._keeper.reader)
        self._follower = VehicleFollower()
        self._silence = SilenceRule()
        self._survey = SurveyNotice(continues_survey=continues_survey)
        self._acts: Acts = ()
        self._fault = ""
        self._is_sound = True
        self.state: State = Idle(now, say("Looking for the autopilot."))
        self._entered = _entering(self.state)

    @property
    def right_parameters(self) -> Mapping[str, float]:
        """The autopilot's parameters that were right in this flight."""
        return self._keeper.right_parameters

    @property
    def is_cutting(self) -> bool:
        """True while the motors are being cut."""
        return self._kill.is_sending

    def case(self, facts: Facts) -> Case:
        """Return what commands are judged on at this moment."""
        reader, kill = self._keeper.reader, self._kill
        bench = Bench(kill.state, kill.is_killed, reader.is_setting, self._keeper.fence_problem, kill.fall)
        return Case(self._with_kept(facts), self.state, self._settings, reader.values(), bench)

    def _with_kept(self, facts: Facts) -> Facts:
        """Return the facts with the keeper's word, which guard and states need."""
        return replace(facts, kept=self._kept)

    def command(self, facts: Facts, client: ClientId, command: Command) -> Decision:
        """Decide on a command. A fault refuses it."""
        facts = self._with_kept(facts)
        rulings: list[Ruling] = []
        self._guarded(facts, lambda: rulings.append(self._rule(facts, client, command)))
        if rulings:
            return self._taken(rulings[0].answer)
        return self._taken(Ack(id=command.id, accepted=False, reason=sentence(self._fault)))

    def tick(self, facts: Facts) -> Decision:
        """Decide once a tick: the autopilot's changes, Kill, automatic reactions, the state. No step hides another."""
        self._is_sound = True
        for is_vital, step in self._steps(facts):
            if not self._guarded(facts, step) and is_vital:
                self._is_sound = False
        return self._taken(None)

    def leave_air(self, facts: Facts, cause: Cause) -> Decision | None:
        """Decide to return home, or to land, because the program ends; None where there is nothing to do."""
        if not facts.is_airborne or self.state.is_left_alone or not facts.link.is_up:
            return None
        facts = self._with_kept(facts)
        self._guarded(facts, lambda: self._switch(returning(facts, cause), facts))
        return self._taken(None)

    # -- steps ---------------------------------------------------------------------------------------------------

    def _rule(self, facts: Facts, client: ClientId, command: Command) -> Ruling:
        ruling = self._desk.rule(client, command, self.case(facts))
        self._carry_out(ruling, facts)
        if any(isinstance(act, BeginSurvey) for act in ruling.acts):
            self._continues_survey, self._survey = False, SurveyNotice(continues_survey=False)
        if isinstance(ruling.answer, Ack):
            self._do((answer_record(client, command, ruling.answer),))
        return ruling

    def _steps(self, facts: Facts) -> Iterator[tuple[bool, Callable[[], None]]]:
        """Give the steps of a tick in their order, each with True when the drone's safety depends on it."""
        yield True, lambda: self._do(forgotten(facts))
        for event in facts.link.events:
            yield True, partial(self._hear, event, facts)
        if not self._kill.is_sending:
            yield True, lambda: self._step(self._follower.watch(facts, self.state), facts)
        yield True, lambda: self._lock(facts)
        yield True, lambda: self._step(self._follower.watch_jump(facts, self.state), facts)
        yield False, lambda: self._do(self._desk.routes.tick(facts))
        if self._kill.is_sending:
            yield True, lambda: self._cut(facts)
            return
        yield True, lambda: self._step(self._silence.tick(facts, self.state), facts)
        yield False, lambda: self._do(guard.notices(facts))
        yield False, lambda: self._do(self._ground.tick(facts))
        yield False, lambda: self._do(self._witness.tick(facts, self.state))
        for is_vital, keep in self._keeper.steps(facts, self.state):
            yield is_vital, lambda: self._do(keep())  # noqa: B023 - it is called before the next one
        yield True, lambda: self._note_kept(facts)
        facts = self._with_kept(facts)
        yield False, lambda: self._do(self._survey.tick(facts, self.state))
        yield False, lambda: self._inquire(facts)
        yield True, lambda: self._react(facts)
        if not facts.link.is_up and not self.state.on_ground:
            return  # nothing that is decided now would reach the autopilot
        yield True, lambda: self._process(facts)
        yield True, lambda: self._advance(facts, None)

    def _note_kept(self, facts: Facts) -> None:
        self._kept = self._keeper.kept(facts)

    def _hear(self, event: VehicleEvent, facts: Facts) -> None:
        self._step(self._follower.answer(event, facts, self.state), facts)

    def _lock(self, facts: Facts) -> None:
        """Lock Arm after a fall. One from a small height shows a moment after "disarmed"."""
        known = self._kill.fall
        self._do(self._kill.follow(facts))
        is_new = known is None and self._kill.fall is not None and facts.link.is_up
        if is_new and self.state.identity is StateName.IDLE and not self._kill.was_cut:
            self._step(FALLEN, facts)

    def _cut(self, facts: Facts) -> None:
        self._do(self._kill.tick(facts))
        if self._kill.is_sending:
            return
        if self._kill.state == "confirmed":
            self._do((Log("error", say("Motors cut. Arm is locked until you clear it.")),))
            if self.state.identity is not StateName.IDLE:
                self._switch(ToIdle(say("Motors cut.")), facts)
            return
        self._do((Log("error", say("Cutting the motors was not confirmed. Confirm again if it must be.")),))
        self._step(self._follower.adopt(facts, self.state), facts)

    def _inquire(self, facts: Facts) -> None:
        if self._desk.inquiries.is_open:
            self._carry_out(self._desk.inquiries.tick(self.case(facts)), facts)

    def _react(self, facts: Facts) -> None:
        reaction = guard.reaction(facts, self.state) if facts.link.is_up else None
        if reaction is not None:
            self._do((Record("reaction", (("rank", reaction.rank.name), ("state", self.state.get_identity()))),))
            self._switch(reaction.transition, facts)

    # -- the state -----------------------------------------------------------------------------------------------

    def _carry_out(self, ruling: Ruling, facts: Facts) -> None:
        self._do(ruling.acts)
        if ruling.order is not None:
            self._advance(facts, ruling.order)
        if ruling.transition is not None:
            self._switch(ruling.transition, facts)

    def _advance(self, facts: Facts, order: Order | None) -> None:
        self._step(self.state.transition_next_state(facts, order), facts)

    def _step(self, step: Step, facts: Facts) -> None:
        self._do(step.acts)
        if step.restarts:
            self.state.restart()
        if step.transition is not None:
            self._switch(step.transition, facts)

    def _switch(self, transition: Transition, facts: Facts) -> None:
        """Make the state of a transition the active one."""
        following, messages = make_state(transition, facts, self._settings)
        former, self.state = self.state, following
        changed = (("from", former.get_identity()), ("to", following.get_identity()))
        self._entered = _entering(following)
        self._do((*messages, Record("state", changed), self._entered))
        self._do(self._left(former, facts))
        self._do(self._desk.inquiries.supersede())
        if isinstance(transition, ToIdle) and transition.gave_up_arming:
            self._follower.abandon_arming(facts.now)
        if isinstance(transition, ToManual):
            self._do((ForgetAskedModes(),))
        if following.identity is StateName.ARM:
            self._follower.begin_arming()
        self._do(following.enter(facts))
        returned = former.identity is StateName.COMMUNICATION_LOST and following.identity is StateName.HOVER
        if returned and self._follower.started_in_air and self._continues_survey:
            self._do((Log("info", say("Explore continues the survey.")),))

    def _process(self, facts: Facts) -> None:
        """Do the state's acts. What the gate lets it send follows its trait, which may just have changed."""
        acts = self.state.process(facts)
        entered = _entering(self.state)
        if entered != self._entered:
            self._entered = entered
            self._do((entered,))
        self._do(acts)

    def _left(self, former: State, facts: Facts) -> Acts:
        """Return the former state's last acts; a fault in it must not keep the next one from beginning."""
        try:
            return former.leave(facts)
        except Exception as error:
            self._note_fault(error)
            return ()

    def _do(self, acts: Acts) -> None:
        self._acts += acts

    def _taken(self, answer: Outgoing | None) -> Decision:
        acts, self._acts = self._acts, ()
        return Decision(acts, answer, self._fault, self._is_sound)

    def _guarded(self, facts: Facts, step: Callable[[], object]) -> bool:
        """Return False for a step that failed. A fault ends a task by Hover and is shown; it stops no other step."""
        try:
            step()
        except Exception as error:
            self._note_fault(error)
            self._end_task(facts)
            return False
        return True

    def _end_task(self, facts: Facts) -> None:
        if not self.state.is_task:
            return
        try:
            self._switch(ToHover(say("A fault in the program."), level="error"), facts)
        except Exception as error:
            self._is_sound = False
            self._note_fault(error)

    def _note_fault(self, error: Exception) -> None:
        _LOGGER.exception("unexpected")
        self._fault = fault_words(error)


def _entering(state: State) -> EnterState:
    return EnterState(state.identity, state.may_send_targets, state.holds)
