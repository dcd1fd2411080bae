"""Reads the autopilot's parameters that the checks need, watches them in flight, and sets its failsafes."""

from __future__ import annotations

from dataclasses import dataclass

from hawk.ddc.acts import Acts, Ask, Log, ReadParameter, SetParameters
from hawk.ddc.facts import Answer, Facts
from hawk.ddc.parameters.failsafes import MAY_BE_MISSING, wanted_values, watched_names
from hawk.ddc.parameters.values import RETURN_ALTITUDE_NAMES, Values
from hawk.ddc.readings.link import VehicleEvent
from hawk.ddc.readings.remote_control import SWITCH_NAMES
from hawk.model.sentences import say

REREAD_S = 20.0
"""A parameter is read again after this time on the ground: others may change it, the autopilot may reboot, seconds."""
WATCH_S = 8.0
"""A parameter is read again after this time in flight, seconds: its answer is there within ten.

Some 28 parameters are 3.5 requests and answers a second, about 240 bytes a second, 4 % of a radio of 57,600 baud.
"""
STALE_S = 60.0
"""An older value is void, seconds. In flight those of the mode switch do not age."""
RETRY_S = 3.0
"""Pause after a read that failed, seconds."""
AT_ONCE = 6
"""Reads under way at a time: ArduPilot queues 20 requests and answers some ten a second."""
MISSES = 2
"""The number of reads in a row without an answer, while others are answered, after which a parameter is missing."""


@dataclass(frozen=True, slots=True)
class _Stamp:
    """Time of a read: seconds of the clock, and seconds on the ground."""

    now: float
    ground: float


class ParameterReader:
    """Reads a few parameters at a time; a flight that was taken up reads what it does not know, once."""

    def __init__(self, system_id: int, *, needs_remote_control: bool = True) -> None:
        self._system_id = system_id
        self._needs_remote_control = needs_remote_control
        self._values: dict[str, float | None] = {}
        self._lately: dict[str, float | None] | None = None
        self._read_at: dict[str, _Stamp] = {}
        self._open: dict[str, Ask] = {}
        self._not_before: dict[str, float] = {}
        self._misses: dict[str, int] = {}
        self._answered_at = float("-inf")
        self._setting: Ask | None = None
        self._is_wanted = False
        self._time = _Stamp(float("-inf"), 0.0)
        self._altitude_set = float("-inf")

    @property
    def is_setting(self) -> bool:
        """True while failsafes are being set."""
        return self._is_wanted or self._setting is not None

    def values(self) -> Values:
        """Return the values read lately; None: the autopilot does not have that parameter."""
        if self._lately is None:  # asked for several times a tick
            self._lately = {name: value for name, value in self._values.items() if self._age(name) < STALE_S}
        return self._lately

    def set_failsafes(self) -> None:
        """Set the parameters that the checks miss, as soon as all of them were read."""
        self._is_wanted = True

    def tick(self, facts: Facts) -> Acts:
        """Look at the answers; return the next requests and messages."""
        self._keep_time(facts)
        if VehicleEvent.LINK_LOST in facts.link.events:
            self._forget()  # the autopilot may reboot meanwhile
            self._open.clear()
        self._follow_return_altitude(facts)
        failure = self._take_answers(facts)
        self._take_broadcasts(facts)
        can_set = facts.link.is_up and not facts.vehicle.armed
        if self._is_wanted and (failure or not can_set):
            self._is_wanted = False
            return (
                Log("error", say("The failsafes were not set."), failure or say("The drone is armed, or not heard.")),
            )
        acts = self._finish_setting(facts)
        if self._setting is None and facts.link.is_up:
            acts += self._next(facts)
        return acts

    def _keep_time(self, facts: Facts) -> None:
        on_ground = not facts.vehicle.armed and self._time.now > float("-inf")
        passed = facts.now - self._time.now if on_ground else 0.0
        self._time = _Stamp(facts.now, self._time.ground + passed)
        self._lately = None

    def _age(self, name: str) -> float:
        """Return the seconds since a parameter was read: in flight those of the mode switch are not read again."""
        stamp = self._read_at.get(name)
        if stamp is None:
            return float("inf")
        return self._time.ground - stamp.ground if name in SWITCH_NAMES else self._time.now - stamp.now

    def _forget(self) -> None:
        self._lately = None
        self._values.clear()
        self._read_at.clear()
        self._misses.clear()
        self._not_before.clear()

    def _follow_return_altitude(self, facts: Facts) -> None:
        """Read the return altitude again after it was set."""
        for answer in facts.answers:
            if answer.name != "set return altitude" or not answer.is_done or answer.asked <= self._altitude_set:
                continue
            self._altitude_set = answer.asked
            self._lately = None
            for name in RETURN_ALTITUDE_NAMES:
                self._values.pop(name, None)
                self._read_at.pop(name, None)

    # -- answers -------------------------------------------------------------------------------------------------

    def _take_answers(self, facts: Facts) -> str:
        """Take the answers to the open reads; return the reason when one that is needed has failed."""
        ended = [(name, answer) for name, ask in self._open.items() if not (answer := ask.answer(facts)).is_pending]
        for name, answer in ended:
            del self._open[name]
            if answer.is_done and answer.value is not None:
                self._keep(name, answer.value)
                self._answered_at = facts.now
        needed = watched_names(self._values)
        failures = [self._take_failure(name, answer) for name, answer in ended if answer.has_failed and name in needed]
        return next(filter(None, failures), "")

    def _take_failure(self, name: str, answer: Answer) -> str:
        """Return the reason of a failed read; empty when the autopilot may lack the parameter."""
        heard = self._answered_at > answer.asked
        if name in MAY_BE_MISSING and heard and self._values.get(name) is None:
            self._misses[name] = self._misses.get(name, 0) + 1
            if self._misses[name] >= MISSES:
                self._keep(name, None)
            return ""
        self._not_before[name] = self._time.now + RETRY_S
        return answer.reason

    def _keep(self, name: str, value: float | None) -> None:
        self._lately = None
        self._values[name] = value
        self._read_at[name] = self._time
        if value is not None:
            self._misses.pop(name, None)

    def _take_broadcasts(self, facts: Facts) -> None:
        """Take a value that the autopilot sent to all because another station set it."""
        for name, value in facts.parameters:
            if self._values.get(name, value) != value:
                self._keep(name, value)

    # -- requests ------------------------------------------------------------------------------------------------

    def _finish_setting(self, facts: Facts) -> Acts:
        if self._setting is None:
            return ()
        answer = self._setting.answer(facts)
        if answer.is_pending:
            return ()
        self._setting = None
        if answer.has_failed:
            return (Log("error", say("The failsafes were not set."), answer.reason),)
        return (Log("ok", say("Failsafes set and read back.")),)

    def _next(self, facts: Facts) -> Acts:
        names = watched_names(self._values)
        if self._is_wanted and all(self._age(name) < STALE_S and name not in self._open for name in names):
            return self._begin_setting(facts)
        due = [name for name in names if name not in self._open and self._is_due(name, facts)]
        due.sort(key=lambda name: -self._age(name))
        if due and MAY_BE_MISSING.issuperset(due):
            due.append(names[0])  # its answer distinguishes a missing parameter from a silent autopilot
        asks = [Ask(ReadParameter(name), facts.now) for name in due[: AT_ONCE - len(self._open)]]
        self._open.update(zip(due, asks, strict=False))
        return tuple(asks)

    def _is_due(self, name: str, facts: Facts) -> bool:
        age, waits = self._age(name), facts.now < self._not_before.get(name, float("-inf"))
        if self._is_wanted:
            return age >= STALE_S
        if name not in self._values or not facts.vehicle.armed:
            return age >= REREAD_S and not waits
        return name not in SWITCH_NAMES and age >= WATCH_S and not waits

    def _begin_setting(self, facts: Facts) -> Acts:
        self._is_wanted = False
        wanted = wanted_values(self._values, self._system_id, needs_remote_control=self._needs_remote_control)
        missing = {name: value for name, value in self._values.items() if value is None}
        self._forget()  # what was read before the setting decides nothing any more
        self._values, self._read_at = dict(missing), dict.fromkeys(missing, self._time)
        self._setting = Ask(SetParameters(tuple(wanted.items())), facts.now)
        return (self._setting,)
