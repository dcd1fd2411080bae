"""Silence: the autopilot is not heard while the drone flies. It may still hear us, so messages go out unanswered.

Our heartbeats would keep its ground-station failsafe quiet for ever, so they are held back until it is heard again.
"""

from __future__ import annotations

from dataclasses import dataclass

from hawk.ddc.acts import STAY, Acts, Ask, Log, SendMode, SetVoice, Step
from hawk.ddc.facts import Facts
from hawk.ddc.orders import Cause, CauseKind, Rank, ToReturn
from hawk.ddc.states.base import State
from hawk.model.sentences import say

UNHEARD = say("the autopilot is not heard")
"""Why no path is flown."""
SILENCE_S = 3.0
"""Without a HEARTBEAT for this time Return To Launch is sent, and our heartbeats are held back, seconds."""
REPEAT_S = 0.5
"""Pause between two messages with the same mode, seconds."""
SENDINGS = 6
"""Number of messages with the same mode: one datagram may be lost."""


@dataclass(slots=True)
class _Repetition:
    """The messages with a state's mode: how many were sent, and when the last one, seconds."""

    state: State
    sent: int = 0
    sent_at: float = float("-inf")


class SilenceRule:
    """Sends the mode of the state to an autopilot that is not heard, and holds our heartbeats back."""

    def __init__(self) -> None:
        self._is_silent = False
        self._repetition: _Repetition | None = None

    def tick(self, facts: Facts, state: State) -> Step:
        """Return what the silence causes: messages without an answer, our own silence, Return To Launch."""
        if facts.link.is_up:
            return self._hear()
        if not facts.is_unheard or state.on_ground:
            return STAY
        acts: Acts = ()
        if facts.link.age >= SILENCE_S:
            acts = self._fall_silent()
            if state.rank < Rank.RETURN_TO_LAUNCH or state.may_send_targets:
                cause = Cause(say("The autopilot was not heard."), CauseKind.NEVER)
                return Step(ToReturn(cause, straight=UNHEARD), acts)
        return Step(acts=acts + self._send(facts, state))

    def _hear(self) -> Step:
        self._repetition = None
        if not self._is_silent:
            return STAY
        self._is_silent = False
        return Step(acts=(SetVoice(True),))

    def _fall_silent(self) -> Acts:
        if self._is_silent:
            return ()
        self._is_silent = True
        words = say("Our heartbeats are held back, so that the autopilot's own failsafe brings the drone home.")
        return SetVoice(False), Log("error", words)

    def _send(self, facts: Facts, state: State) -> Acts:
        """Return the state's mode as a message, every REPEAT_S from the state's beginning or the silence's."""
        if self._repetition is None or state is not self._repetition.state:
            self._repetition = _Repetition(state)
        repetition, mode = self._repetition, state.autopilot_mode
        if mode is None or repetition.sent >= SENDINGS or facts.now - repetition.sent_at < REPEAT_S - 1e-6:
            return ()
        repetition.sent += 1
        repetition.sent_at = facts.now
        return (Ask(SendMode(mode), facts.now),)
