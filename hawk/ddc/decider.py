"""Decider: judges commands, reacts and decides. It sees facts, returns acts, and does nothing itself.

A tick is a row of steps. Each sees facts and the active state, and returns what it decided. One driver guards each step
and makes the state that follows the active one. The same facts and commands give the same decisions: those that
`hawk.ddc.recorder` records are decided again by `hawk.ddc.replay`.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple, ParamSpec, TypeVar

from hawk.comm.protocol.commands import Ack, Command, Outgoing
from hawk.comm.protocol.heartbeat import ClientId
from hawk.ddc.acts import STAY, Acts, BeginSurvey, EnterState, ForgetAskedModes, Log, Record, Step
from hawk.ddc.facts import Facts, KeptFacts
from hawk.ddc.keeper.keeper import Keeper
from hawk.ddc.orders import Cause, ToHover, ToIdle, ToManual, Transition
from hawk.ddc.rules import guard
from hawk.ddc.rules.command_desk import CommandDesk, Ruling, answer_record
from hawk.ddc.rules.follower import FALLEN, VehicleFollower, forgotten
from hawk.ddc.rules.kill import KillSwitch, KillTokens
from hawk.ddc.rules.needs import Interlocks, Situation
from hawk.ddc.rules.notices import GroundNotices, SurveyNotices, WitnessNotices
from hawk.ddc.rules.silence import SilenceRule
from hawk.ddc.settings import DdcSettings
from hawk.ddc.states.base import State, returning
from hawk.ddc.states.factory import make_state
from hawk.ddc.states.ground import IdleState
from hawk.ddc.words import fault_words
from hawk.model.operation import StateName
from hawk.model.sentences import say, sentence

_LOGGER = logging.getLogger(__name__)
P = ParamSpec("P")
T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Decision:
    """Acts in their order, the answer to a command (None: it follows), and a fault of the program, in words."""

    acts: Acts
    answer: Outgoing | None
    fault: str
    is_sound: bool
    """False for a tick in which a step failed that keeps the drone safe: autopilot's changes, Kill, guard, state."""


Decided = Acts | Step | Ruling
"""Outcome of a step: acts alone; acts and a transition; or those of a command, whose order the state takes."""
Decide = Callable[[Facts, State], Decided]


class TickStep(NamedTuple):
    """One step of a tick. ``is_vital``: the drone's safety depends on it."""

    decide: Decide
    facts: Facts
    is_vital: bool = True


class Outcome(NamedTuple):
    """Outcome of steps: the state that is active after them, their acts in order, and the last fault, in words."""

    state: State
    acts: Acts = ()
    fault: str = ""
    is_sound: bool = True

    def then(self, later: Outcome) -> Outcome:
        """Return the outcome of these steps and those that follow them."""
        is_sound = self.is_sound and later.is_sound
        return Outcome(later.state, self.acts + later.acts, later.fault or self.fault, is_sound)


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
        self._ground = GroundNotices(settings.heights.highest_obstacle_m)
        self._witness = WitnessNotices()
        self._desk = CommandDesk(tokens, self._kill, self._keeper.reader)
        self._follower = VehicleFollower()
        self._silence = SilenceRule()
        self._survey = SurveyNotices(continues_survey=continues_survey)
        self._fault = ""
        self.state: State = IdleState(now, say("Looking for the autopilot."))
        self._entered = _entering(self.state)

    @property
    def right_parameters(self) -> Mapping[str, float]:
        """The autopilot's parameters that were right in this flight."""
        return self._keeper.right_parameters

    @property
    def is_cutting(self) -> bool:
        """True while the motors are being cut."""
        return self._kill.is_sending

    def situation(self, facts: Facts) -> Situation:
        """Return what commands are judged on at this moment."""
        reader, kill = self._keeper.reader, self._kill
        locks = Interlocks(
            kill.state, kill.is_killed, reader.is_setting, self._keeper.fence_problem, kill.fall, kill.killer
        )
        return Situation(self._with_kept(facts), self.state, self._settings, reader.values(), locks)

    def _with_kept(self, facts: Facts) -> Facts:
        """Return the facts with the keeper's word, which guard and states need."""
        return replace(facts, kept=self._kept)

    def command(self, facts: Facts, client: ClientId, command: Command) -> Decision:
        """Decide on a command: the desk rules on it, then its acts are done and the state takes its order.

        A fault refuses it.
        """
        facts = self._with_kept(facts)
        ruling, fault = _attempt(lambda: self._desk.rule(client, command, self.situation(facts)))
        if ruling is None:
            failed = Outcome(self.state, fault=fault, is_sound=False)
            return self._refused(command, self._keep(failed.then(self._end_task(self.state, facts))))
        outcome = self._fold([TickStep(lambda *_: ruling, facts)])
        if not outcome.is_sound:
            return self._refused(command, outcome)  # a Kill goes on
        if ruling.order is not None or ruling.transition is not None:
            replaced = self._kill.replace(command.type, facts.now)
            outcome = outcome._replace(acts=(*replaced, *outcome.acts))
        if any(isinstance(act, BeginSurvey) for act in ruling.acts):
            self._continues_survey, self._survey = False, SurveyNotices(continues_survey=False)
        if isinstance(ruling.answer, Ack):
            outcome = outcome._replace(acts=(*outcome.acts, answer_record(client, command, ruling.answer)))
        return self._decision(outcome, ruling.answer)

    def tick(self, facts: Facts) -> Decision:
        """Decide once a tick: the autopilot's changes, Kill, automatic reactions, the state. No step hides another."""
        return self._decision(self._fold(self._steps(facts)))

    def leave_air(self, facts: Facts, cause: Cause) -> Decision | None:
        """Decide to return home, or to land, because the program ends; None where there is nothing to do."""
        if not facts.is_airborne or self.state.is_left_alone or not facts.link.is_up:
            return None
        return self._at_once(facts, lambda now, _: Step(returning(now, cause)))

    # -- the driver ----------------------------------------------------------------------------------------------

    def _fold(self, steps: Iterable[TickStep]) -> Outcome:
        """Take one step after the other, each with the state that the one before left."""
        outcome = Outcome(self.state)
        for step in steps:
            taken = self._take(step, self.state)
            if taken != Outcome(self.state):
                outcome = outcome.then(self._keep(taken))
        return outcome

    def _keep(self, outcome: Outcome) -> Outcome:
        """Remember the state, what was published of it, and the fault: the one place where they change."""
        self.state = outcome.state
        self._fault = outcome.fault or self._fault
        for act in outcome.acts:
            if isinstance(act, EnterState):
                self._entered = act
        return outcome

    def _take(self, step: TickStep, state: State) -> Outcome:
        """Take one step. A fault ends a task by Hover and is shown; it stops no other step."""
        decided, fault = _attempt(step.decide, step.facts, state)
        if decided is None:
            taken = Outcome(state, fault=fault, is_sound=False)
        else:
            taken = self._carry_out(decided, step.facts, state)
        if taken.is_sound:
            return taken
        ended = self._end_task(taken.state, step.facts)
        return taken.then(ended)._replace(is_sound=ended.is_sound and not step.is_vital)

    def _carry_out(self, decided: Decided, facts: Facts, state: State) -> Outcome:
        """Do what was decided: its acts come first, also where a fault in the state keeps the rest from being done."""
        if isinstance(decided, tuple):
            return Outcome(state, decided)
        if decided is STAY:
            return Outcome(state)
        followed, fault = _attempt(self._follow, decided, facts, state)
        if followed is None:
            followed = Outcome(state, fault=fault, is_sound=False)
        return Outcome(state, decided.acts).then(followed)

    def _follow(self, step: Step | Ruling, facts: Facts, state: State) -> Outcome:
        """Put an order to the state; else restart it, or switch to another one."""
        if isinstance(step, Ruling):
            if step.order is not None:
                return self._carry_out(state.transition_next_state(facts, step.order), facts, state)
        elif step.restarts:
            state.restart()
        return Outcome(state) if step.transition is None else self._switch(step.transition, facts, state)

    def _switch(self, transition: Transition, facts: Facts, former: State) -> Outcome:
        """Leave a state for that of a transition. A fault in leaving or beginning keeps the following one active."""
        following, messages = make_state(transition, facts, self._settings)
        changed = Record("state", (("from", former.get_identity()), ("to", following.get_identity())))
        left, leave_fault = _attempt(former.leave, facts)
        superseded = self._desk.lot_check.supersede()
        self._follower.note(transition, facts.now)
        forgets: Acts = (ForgetAskedModes(),) if isinstance(transition, ToManual) else ()
        begun, fault = _attempt(following.enter, facts)
        acts = (*messages, changed, _entering(following), *(left or ()), *superseded, *forgets, *(begun or ()))
        if begun is None:
            return Outcome(following, acts, fault, is_sound=False)
        return Outcome(following, acts + self._continuing(former, following), leave_fault)

    def _continuing(self, former: State, following: State) -> Acts:
        """Return the message that the survey goes on, when the operator is back after a start in the air."""
        returned = former.identity is StateName.COMMUNICATION_LOST and following.identity is StateName.HOVER
        if returned and self._follower.started_in_air and self._continues_survey:
            return (Log("info", say("Explore continues the survey.")),)
        return ()

    def _end_task(self, state: State, facts: Facts) -> Outcome:
        if not state.is_task:
            return Outcome(state)
        return self._carry_out(Step(ToHover(say("A fault in the program."), level="error")), facts, state)

    def _at_once(self, facts: Facts, decide: Decide) -> Decision:
        return self._decision(self._fold([TickStep(decide, self._with_kept(facts))]))

    def _decision(self, outcome: Outcome, answer: Outgoing | None = None) -> Decision:
        return Decision(outcome.acts, answer, self._fault, outcome.is_sound)

    def _refused(self, command: Command, outcome: Outcome) -> Decision:
        return self._decision(outcome, Ack(id=command.id, accepted=False, reason=sentence(outcome.fault)))

    # -- the steps of a tick -------------------------------------------------------------------------------------

    def _steps(self, facts: Facts) -> Iterator[TickStep]:
        """Give the steps of a tick in their order. One is made after the one before was taken."""
        yield TickStep(lambda now, _: forgotten(now), facts)
        yield TickStep(self._cut_late, facts)
        for event in facts.link.events:
            yield TickStep(partial(self._follower.answer, event), facts)
        is_cutting = self._kill.is_sending
        if not is_cutting:
            yield TickStep(self._follower.follow, facts)
        yield TickStep(self._lock, facts)
        yield TickStep(self._follower.follow_jump, facts)
        yield TickStep(lambda now, _: self._desk.routes.tick(now), facts, is_vital=False)
        if is_cutting:
            yield TickStep(self._cut, facts)
            return
        yield TickStep(self._silence.tick, facts)
        yield TickStep(lambda now, _: guard.notices(now), facts, is_vital=False)
        yield TickStep(lambda now, _: self._ground.tick(now), facts, is_vital=False)
        yield TickStep(self._witness.tick, facts, is_vital=False)
        for is_vital, keep in self._keeper.steps():
            yield TickStep(keep, facts, is_vital)
        yield TickStep(self._note_kept, facts)
        facts = self._with_kept(facts)
        yield TickStep(self._survey.tick, facts, is_vital=False)
        yield TickStep(self._check_lot, facts, is_vital=False)
        yield TickStep(_react, facts)
        if not facts.link.is_up and not self.state.on_ground:
            return  # nothing that is decided now would reach the autopilot
        yield TickStep(self._process, facts)
        yield TickStep(lambda now, state: state.transition_next_state(now), facts)

    def _lock(self, facts: Facts, state: State) -> Step:
        """Lock Arm after a fall. One from a small height shows a moment after "disarmed"."""
        known = self._kill.fall
        acts = self._kill.follow(facts)
        is_new = known is None and self._kill.fall is not None and facts.link.is_up
        falls = is_new and state.identity is StateName.IDLE and not self._kill.was_cut
        return Step(FALLEN.transition, acts + FALLEN.acts) if falls else Step(acts=acts)

    def _cut(self, facts: Facts, state: State) -> Step:
        """Go on cutting the motors; at the end say whether they are off."""
        acts = self._kill.tick(facts)
        if self._kill.is_sending:
            return Step(acts=acts)
        if self._kill.state == "confirmed":
            return _cut_off(state, acts)
        again = Log("error", say("Cutting the motors was not confirmed. Confirm again if it must be."))
        adopted = self._follower.adopt(facts, state)
        return replace(adopted, acts=(*acts, again, *adopted.acts))

    def _cut_late(self, facts: Facts, state: State) -> Step:
        """Say that a Kill cut the motors although another command replaced it."""
        return _cut_off(state) if self._kill.is_late(facts) else STAY

    def _note_kept(self, facts: Facts, _: State) -> Acts:
        """Take the keeper's word, which the steps that follow need."""
        self._kept = self._keeper.kept(facts)
        return ()

    def _check_lot(self, facts: Facts, _: State) -> Ruling | Acts:
        return self._desk.lot_check.tick(self.situation(facts)) if self._desk.lot_check.is_open else ()

    def _process(self, facts: Facts, state: State) -> Acts:
        """Return the state's acts. What the gate lets it send follows its trait, which may just have changed."""
        acts = state.process(facts)
        entered = _entering(state)
        return acts if entered == self._entered else (entered, *acts)


def _cut_off(state: State, acts: Acts = ()) -> Step:
    off = Log("error", say("Motors cut. Arm is locked until you clear it."))
    return Step(None if state.identity is StateName.IDLE else ToIdle(say("Motors cut.")), (*acts, off))


def _react(facts: Facts, state: State) -> Step:
    """Return the automatic reaction to the facts."""
    reaction = guard.reaction(facts, state) if facts.link.is_up else None
    if reaction is None:
        return STAY
    record = Record("reaction", (("rank", reaction.rank.name), ("state", state.get_identity())))
    return Step(reaction.transition, (record,))


def _attempt(call: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> tuple[T | None, str]:
    """Return what a call returns and no words; None and words on its fault where it fails."""
    try:
        return call(*args, **kwargs), ""
    except Exception as error:
        _LOGGER.exception("unexpected")
        return None, fault_words(error)


def _entering(state: State) -> EnterState:
    return EnterState(state.identity, state.may_send_targets, state.holds)
