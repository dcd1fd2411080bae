"""Kill: cutting the motors in two steps, and keeping at it until the autopilot shows that they are off."""

from __future__ import annotations

import hmac
import secrets
from collections.abc import Callable
from dataclasses import dataclass

from hawk.comm.status import ClientId, KillState

TOKEN_VALID_S = 10.0
REPEAT_S = 0.2
"""The command is sent this often until disarmed is seen, seconds."""
GIVE_UP_S = 5.0
"""After so many seconds it is "not confirmed" and a new confirmation is needed."""
ARMED_SHOWS_S = 1.0
"""Heartbeats show "armed" up to so many seconds late."""


class KillRefused(Exception):  # noqa: N818 - it is the answer, not a fault
    """A kill that is not confirmed properly; the text tells what to do."""


@dataclass(frozen=True, slots=True)
class _Token:
    text: str
    client: ClientId
    given: float


class KillSwitch:
    """One-use tokens, repetition, and the lock on Arm afterwards. Nothing of it is stored."""

    def __init__(
        self, clock: Callable[[], float], send: Callable[[], None], new_token: Callable[[], str] | None = None
    ) -> None:
        self._clock = clock
        self._send = send
        self._new_token = new_token or (lambda: secrets.token_urlsafe(24))
        self._token: _Token | None = None
        self._started: float | None = None
        self._last_sent = 0.0
        self._state: KillState = "none"
        self._killed = False
        self._was_armed = False

    @property
    def state(self) -> KillState:
        """None, sending, confirmed or not confirmed."""
        return self._state

    @property
    def is_sending(self) -> bool:
        """Whether the command is being repeated."""
        return self._started is not None

    @property
    def is_killed(self) -> bool:
        """Whether Arm is refused until the operator clears it."""
        return self._killed

    def request(self, client: ClientId) -> str:
        """Give a token to this client; any older one is void."""
        self._token = _Token(self._new_token(), client, self._clock())
        return self._token.text

    def kill(self, client: ClientId, token: str, armed: bool) -> None:
        """Begin to cut the motors: the first command goes out in this call. Raises KillRefused on a bad token.

        ``armed``: what the autopilot's last heartbeat says.
        """
        given, self._token = self._token, None
        if given is None or given.client != client or not hmac.compare_digest(given.text.encode(), token.encode()):
            raise KillRefused("Token: not valid, or used already: ask for a new one by Kill Request.")
        if self._clock() - given.given > TOKEN_VALID_S:
            raise KillRefused(f"Token: older than {TOKEN_VALID_S:g} s: ask for a new one by Kill Request.")
        self._killed = True
        self._state = "sending"
        self._started = self._clock()
        self._was_armed = armed
        self._repeat()

    def tick(self, armed: bool, heard: float, connected: bool) -> bool:
        """Repeat the command until disarmed is seen; return whether the sending ended in this tick.

        ``armed`` is what the heartbeat of the time ``heard`` says. A drone that did not seem armed may just be arming,
        which shows late: such a heartbeat confirms only ARMED_SHOWS_S after the beginning.
        """
        if self._started is None:
            return False
        now = self._clock()
        self._was_armed |= armed
        if connected and not armed and (self._was_armed or heard - self._started >= ARMED_SHOWS_S):
            return self._end("confirmed")
        if not connected or now - self._started >= GIVE_UP_S - 1e-6:
            return self._end("not confirmed")
        if now - self._last_sent >= REPEAT_S - 1e-6:
            self._repeat()
        return False

    def clear(self) -> None:
        """The operator, on the ground, lets Arm be asked for again."""
        self._killed = False
        self._state = "none"

    def _repeat(self) -> None:
        self._last_sent = self._clock()
        self._send()

    def _end(self, state: KillState) -> bool:
        self._started = None
        self._state = state
        return True
