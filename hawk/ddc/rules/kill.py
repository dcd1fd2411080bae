"""Kill: cutting the motors in two steps, and repeating the command until the autopilot shows that they are off.

The lock on Arm afterwards holds for motors that went off in the air without a Kill, too.
"""

from __future__ import annotations

import hmac
import secrets
from collections.abc import Callable
from dataclasses import dataclass

from hawk.comm.protocol.heartbeat import ClientId, KillState
from hawk.ddc.acts import Acts, Ask, CutMotors, KeepFall, Log, Record
from hawk.ddc.facts import Facts
from hawk.ddc.readings.fall import fall_words
from hawk.model.operation import Fall
from hawk.model.sentences import say

TOKEN_VALID_S = 10.0
REPEAT_S = 0.2
"""The command is sent this often until disarmed is seen, seconds."""
GIVE_UP_S = 5.0
"""After this time it is "not confirmed" and a new confirmation is needed, seconds."""
ARMED_SHOWS_S = 1.0
"""A HEARTBEAT shows "armed" up to this late, seconds."""
LATE_S = 3.0
"""Motors that the autopilot says are off so soon after a Kill was replaced, seconds, went off by it: the command may
have been under way, and its HEARTBEAT comes a second late."""


@dataclass(frozen=True, slots=True)
class _Token:
    text: str
    client: ClientId
    given: float


class KillTokens:
    """One-use tokens: a Kill needs the newest one, given to the same client a moment ago. Nothing is stored."""

    def __init__(self, new_token: Callable[[], str] | None = None) -> None:
        self._new_token = new_token or (lambda: secrets.token_urlsafe(24))
        self._token: _Token | None = None

    def issue(self, client: ClientId, now: float) -> str:
        """Return a token for this client; any older one is void."""
        self._token = _Token(self._new_token(), client, now)
        return self._token.text

    def redeem(self, client: ClientId, token: str, now: float) -> str:
        """Use up the token; return the reason why it does not confirm a Kill, empty when it does."""
        given, self._token = self._token, None
        if given is None or given.client != client or not hmac.compare_digest(given.text.encode(), token.encode()):
            return say("Token: not valid, or used already: ask for a new one by Kill Request.")
        if now - given.given > TOKEN_VALID_S:
            return say("Token: older than {seconds:g} s: ask for a new one by Kill Request.", seconds=TOKEN_VALID_S)
        return ""


@dataclass(slots=True)
class _Sending:
    """A Kill that is repeated: when it began and went out last (seconds), and whether the drone was armed since."""

    started: float
    last_sent: float
    was_armed: bool


class KillSwitch:
    """Repetition of the command, and the lock on Arm afterwards. Of it a fall is journalled, nothing else."""

    killer: ClientId = ""
    """Client that began the Kill which is being sent."""
    _replaced: float | None = None
    """Time at which a Kill was replaced, seconds; its motors may go off yet."""

    def __init__(self) -> None:
        self._sending: _Sending | None = None
        self.was_cut = False
        """An operator cut them, and nobody cleared it."""
        self._cleared: Fall | None = None
        self.state: KillState = "none"
        self.fall: Fall | None = None
        """Motors that went off in the air, until the operator clears it."""

    @property
    def is_killed(self) -> bool:
        """True until the operator clears it: Arm is refused."""
        return self.was_cut or self.fall is not None

    @property
    def is_sending(self) -> bool:
        """True while the command is repeated."""
        return self._sending is not None

    def begin(self, facts: Facts, client: ClientId) -> Acts:
        """Begin to cut the motors; return the first command. One that goes on stays that of its first client."""
        if self._sending is None:
            self.killer = client
        self._replaced = None
        self.was_cut = True
        self.state = "sending"
        self._sending = _Sending(facts.now, facts.now, facts.vehicle.armed)
        return (Ask(CutMotors(), facts.now),)

    def tick(self, facts: Facts) -> Acts:
        """Return the command when it is due; `is_sending` ends when disarmed is seen, or after GIVE_UP_S.

        It is sent on a link that seems dead too: the autopilot may hear without being heard.

        A drone that did not seem armed may just be arming, which shows late: such a HEARTBEAT confirms only
        ARMED_SHOWS_S after the beginning.
        """
        sending = self._sending
        if sending is None:
            return ()
        now, vehicle, is_up = facts.now, facts.vehicle, facts.link.is_up
        sending.was_armed |= vehicle.armed
        if is_up and not vehicle.armed and (sending.was_armed or vehicle.time - sending.started >= ARMED_SHOWS_S):
            self._end("confirmed")
        elif now - sending.started >= GIVE_UP_S - 1e-6:
            self._end("not confirmed")
        elif now - sending.last_sent >= REPEAT_S - 1e-6:
            sending.last_sent = now
            return (Ask(CutMotors(), now),)
        return ()

    def replace(self, command: str, now: float) -> Acts:
        """End the repetition: who may cut the motors wants another thing by now. Arm stays locked.

        A command that is under way, or that the autopilot has taken, cannot be taken back: `is_late`.
        """
        if self._sending is None:
            return ()
        self._end("none")
        self._replaced = now
        return (Log("warning", say("{command} came first: the motors are cut no more.", command=command)),)

    def is_late(self, facts: Facts) -> bool:
        """Return True in the tick in which a Kill that was replaced turns out to have cut the motors."""
        if self._replaced is None:
            return False
        if facts.ground.armed_said:
            if facts.now - self._replaced > LATE_S:
                self._replaced = None
            return False
        if facts.vehicle.armed or not facts.link.is_up:
            return False
        self._end("confirmed")
        return True

    def follow(self, facts: Facts) -> Acts:
        """Lock Arm after a fall; return the acts that report and journal it: its place follows the drone at first."""
        fall, known = facts.fall, self.fall
        if fall is None or fall == known or (self._cleared is not None and fall.at == self._cleared.at):
            return ()
        self.fall = fall
        if known is not None and known.at == fall.at:
            return (KeepFall(fall),)
        words = say("Motors off in the air {where}. Arm is locked until you clear it.", where=fall_words(fall))
        place = (("latitude", fall.latitude), ("longitude", fall.longitude), ("height", fall.height))
        record = Record("motors off in the air", (("at", fall.at), *place))
        return (KeepFall(fall), Log("error", words, facts.link.words), record)

    def clear(self) -> Acts:
        """Let Arm be asked for again: the operator confirmed it on the ground. Return what must be forgotten."""
        self.was_cut = False
        self._end("none")
        self._cleared, self.fall = self.fall, None
        return () if self._cleared is None else (KeepFall(None),)

    def _end(self, state: KillState) -> None:
        self._sending = self._replaced = None
        self.state = state
