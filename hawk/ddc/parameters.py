"""Reads the autopilot's parameters that the preflight check needs, and sets its failsafes."""

from __future__ import annotations

from hawk.ddc.acts import Acts, Ask, Log, ReadParameter, SetParameters
from hawk.ddc.facts import Facts, VehicleEvent
from hawk.ddc.failsafes import RETURN_ALTITUDE_NAMES, WATCHED_ID_NAMES, wanted_values, watched_names

REREAD_S = 20.0
"""A parameter is read again after this time on the ground: others may change it, the autopilot may reboot, seconds."""
STALE_S = 60.0
"""An older value is void, seconds."""
RETRY_S = 3.0
"""Pause after a read that failed, seconds."""
_NEWER_NAMES = (WATCHED_ID_NAMES[0], RETURN_ALTITUDE_NAMES[0])
"""Parameters that older autopilots do not have."""


class ParameterReader:
    """Reads one parameter at a time while disarmed. Values do not age in flight, when nothing can be read."""

    def __init__(self, system_id: int) -> None:
        self._system_id = system_id
        self._values: dict[str, float | None] = {}
        self._read_at: dict[str, float] = {}
        self._reading: tuple[str, Ask] | None = None
        self._setting: Ask | None = None
        self._is_wanted = False
        self._not_before = float("-inf")
        self._ground_time = 0.0
        self._last_tick: float | None = None
        self._altitude_set = float("-inf")

    @property
    def is_setting(self) -> bool:
        """True while failsafes are being set."""
        return self._is_wanted or self._setting is not None

    def values(self) -> dict[str, float | None]:
        """Return the values read lately; None: the autopilot does not have that parameter."""
        now = self._ground_time
        return {
            name: value
            for name, value in self._values.items()
            if value is None or now - self._read_at.get(name, now) < STALE_S
        }

    def set_failsafes(self) -> None:
        """Set the parameters that the checks miss, as soon as all of them were read."""
        self._is_wanted = True

    def tick(self, facts: Facts) -> Acts:
        """Look at the answers; return the next request and messages."""
        self._keep_time(facts)
        if VehicleEvent.LINK_LOST in facts.link.events:
            self._values.clear()  # the autopilot may reboot meanwhile
            self._read_at.clear()
        self._follow_return_altitude(facts)
        can_read = facts.link.is_up and not facts.vehicle.armed
        failure = self._take_reading(facts)
        if self._is_wanted and (failure or not can_read):
            self._is_wanted = False
            return (Log("error", "The failsafes were not set.", failure or "The drone is armed, or not heard."),)
        acts = self._finish_setting(facts)
        if self._reading is None and self._setting is None and can_read:
            acts += self._next(facts)
        return acts

    def _keep_time(self, facts: Facts) -> None:
        if not facts.vehicle.armed and self._last_tick is not None:
            self._ground_time += facts.now - self._last_tick
        self._last_tick = facts.now

    def _follow_return_altitude(self, facts: Facts) -> None:
        """Read the return altitude again after it was set."""
        for answer in facts.answers:
            if answer.name != "set return altitude" or not answer.is_done or answer.asked <= self._altitude_set:
                continue
            self._altitude_set = answer.asked
            for name in RETURN_ALTITUDE_NAMES:
                if self._values.get(name) is not None:
                    self._read_at.pop(name, None)

    def _take_reading(self, facts: Facts) -> str:
        """Take the answer to the open read; return the reason when it failed."""
        if self._reading is None:
            return ""
        name, ask = self._reading
        answer = ask.answer(facts)
        if answer.is_pending:
            return ""
        self._reading = None
        is_missing = answer.has_failed and name in _NEWER_NAMES and self._values.get(name) is None
        if answer.is_done or is_missing:
            self._values[name] = answer.value if answer.is_done else None
            self._read_at[name] = self._ground_time
            return ""
        self._not_before = self._ground_time + RETRY_S
        return answer.reason

    def _finish_setting(self, facts: Facts) -> Acts:
        if self._setting is None:
            return ()
        answer = self._setting.answer(facts)
        if answer.is_pending:
            return ()
        self._setting = None
        self._read_at.clear()
        if answer.has_failed:
            return (Log("error", "The failsafes were not set.", answer.reason),)
        return (Log("ok", "Failsafes set and read back."),)

    def _next(self, facts: Facts) -> Acts:
        names = watched_names(self._values)
        unread = [name for name in names if name not in self._values]
        if self._is_wanted and not unread:
            self._is_wanted = False
            wanted = wanted_values(self._values, self._system_id)
            self._setting = Ask(SetParameters(tuple(wanted.items())), facts.now)
            return (self._setting,)
        now = self._ground_time
        due = unread if self._is_wanted else [n for n in names if now - self._read_at.get(n, -1e9) >= REREAD_S]
        if not due or (now < self._not_before and not self._is_wanted):
            return ()
        name = min(due, key=lambda n: self._read_at.get(n, float("-inf")))
        self._reading = (name, Ask(ReadParameter(name), facts.now))
        return (self._reading[1],)
