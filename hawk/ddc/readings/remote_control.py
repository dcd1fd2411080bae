"""The pilot's remote control: who could take over by hand, and by which position of the mode switch.

A pilot takes over by the mode switch, so it is judged before Arm: the receiver is heard, its switch has a valid pulse,
and one of its positions commands a mode that is flown by hand. Thresholds are those of ArduPilot (RC_Channel.cpp,
``read_6pos_switch``); modes of FLTMODE1 to FLTMODE6 are numbers of ArduCopter.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from hawk.comm.autopilot.remote_control import RemoteControl
from hawk.comm.protocol.heartbeat import CheckItem
from hawk.comm.topic import Topic
from hawk.config.sections import RemoteControlSettings
from hawk.ddc.readings.instant import Instant, Parts, Reading
from hawk.ddc.stopwatch import Stopwatch
from hawk.model.operation import Health
from hawk.model.sentences import say
from hawk.model.vehicle import CopterMode, mode_name

SWITCH_CHANNEL: Final = "FLTMODE_CH"
MODE_NAMES: Final = tuple(f"FLTMODE{position}" for position in range(1, 7))
SWITCH_NAMES: Final = (SWITCH_CHANNEL, *MODE_NAMES)
"""The parameters that decide what the mode switch does."""
_LAST_PULSES: Final = (1230, 1360, 1490, 1620, 1749)
"""Longest pulse of positions 1 to 5, microseconds."""
PULSE_RANGE: Final = (900, 2100)
"""Other pulses are no position, microseconds."""
HAND_FLOWN: Final = frozenset(
    {
        CopterMode.STABILIZE,
        CopterMode.ACRO,
        CopterMode.ALT_HOLD,
        CopterMode.LOITER,
        CopterMode.DRIFT,
        CopterMode.SPORT,
        CopterMode.POSHOLD,
        CopterMode.FLOWHOLD,
    }
)
"""Modes in which the sticks fly the drone."""
AGE_S: Final = 3.0
"""An older RC_CHANNELS (5 Hz) or SYS_STATUS (2 Hz) says nothing, seconds."""
SEEN_S: Final = 1.5
"""A position was seen when it has held for this time with the receiver heard: a dying receiver invents pulses for the
second until the autopilot notices, seconds."""
LOST_CONFIRM_S: Final = 2.0
"""Seconds for which the remote control must be lost in flight before it is shown."""
_NAME: Final = say("Remote control")
_NO_PILOT: Final = say("No pilot could take over by hand.")

Values = Mapping[str, float | None]


@dataclass(frozen=True, slots=True)
class RemoteControlFacts:
    """The remote control as it is believed."""

    age: float = math.inf
    """Seconds since the last RC_CHANNELS."""
    channels: int = 0
    """Number of channels that the receiver gives."""
    receiver: bool | None = None
    """The autopilot hears its receiver; None while SYS_STATUS does not say so."""
    channel: int | None = None
    """The mode switch's channel, to which ``pulse`` belongs; None before FLTMODE_CH was read."""
    pulse: int = 0
    """Its pulse, microseconds; 0: none."""
    has_moved: bool = False
    """Two of its positions were seen since the autopilot booted."""
    lost_s: float | None = None
    """Seconds in flight since the loss was certain; None while the remote control is heard, or is not required."""

    @property
    def is_fresh(self) -> bool:
        """True while RC_CHANNELS comes."""
        return self.age <= AGE_S

    @property
    def is_heard(self) -> bool:
        """True by both witnesses: RC_CHANNELS comes, and the autopilot hears its receiver."""
        return self.is_fresh and self.receiver is True


NO_REMOTE_CONTROL: Final = RemoteControlFacts()
"""Nothing was heard of it."""


def switch_position(pulse: int) -> int | None:
    """Return the position, 1 to 6, of a pulse in microseconds; None for one that is not valid."""
    low, high = PULSE_RANGE
    return bisect_left(_LAST_PULSES, pulse) + 1 if low <= pulse <= high else None


class RemoteControlReading(Reading):
    """Times what must last: a position of the switch, and a loss in flight."""

    def __init__(self, radio: Topic[RemoteControl], settings: RemoteControlSettings) -> None:
        """``radio``: the remote control as the autopilot hears it."""
        self._radio = radio
        self._required = settings.required
        self._heard: RemoteControl | None = None
        self._channel: int | None = None
        self._seen: set[int] = set()
        self._position: tuple[int, float] | None = None  # and since when
        self._missing, self._lost = Stopwatch(), Stopwatch()

    def update(self, instant: Instant) -> None:
        """Take what was heard, and the value of FLTMODE_CH where it was read."""
        heard, channel = self._radio.value, instant.parameters.get(SWITCH_CHANNEL)
        number = None if channel is None else int(channel)
        booted = heard is not None and self._heard is not None and heard.boots != self._heard.boots
        if booted or number != self._channel:
            self._seen.clear()
            self._position = None
        self._heard, self._channel = heard, number
        facts = self.facts(instant)
        self._follow_switch(facts, instant.now)
        is_missing = self._required and instant.is_armed_and_heard and not facts.is_heard
        missing_s = self._missing.update(is_missing, instant.now)
        self._lost.update(missing_s is not None and missing_s >= LOST_CONFIRM_S, instant.now)

    def facts(self, instant: Instant) -> RemoteControlFacts:
        """Return what was heard by the last tick, at this instant."""
        heard, channel, now = self._heard or RemoteControl(), self._channel, instant.now
        return RemoteControlFacts(
            age=now - heard.time,
            channels=heard.channels,
            receiver=heard.receiver if now - heard.receiver_time <= AGE_S else None,
            channel=channel,
            pulse=0 if channel is None else heard.pulse(channel),
            has_moved=len(self._seen) > 1,
            lost_s=self._lost.read(now),
        )

    def parts(self, instant: Instant) -> Parts:
        """Return the health of the remote control in flight."""
        return (("remote control", remote_control_health(self.facts(instant))),)

    def _follow_switch(self, facts: RemoteControlFacts, now: float) -> None:
        position = switch_position(facts.pulse) if facts.is_heard else None
        if position is None:
            self._position = None
        elif self._position is None or self._position[0] != position:
            self._position = (position, now)
        elif now - self._position[1] >= SEEN_S:
            self._seen.add(position)


def remote_control_health(facts: RemoteControlFacts) -> Health:
    """Return the health in flight; before it the preflight check shows more."""
    if facts.lost_s is None:
        return Health()
    return Health.bad(say("The remote control is lost: nobody can take over by hand."))


def remote_control_check(facts: RemoteControlFacts, values: Values, settings: RemoteControlSettings) -> CheckItem:
    """Return the check before Arm. ``values``: parameters that were read lately."""
    if not settings.required:
        return CheckItem(name=_NAME, passed=True, value=_words_without(facts))
    problem = _receiver_problem(facts) or _switch_problem(facts, values)
    if problem is not None:
        return problem
    position, count = switch_position(facts.pulse), say("{channels} channels", channels=facts.channels)
    switch = say("switch at {mode} (position {position})", mode=str(_mode(values, position)), position=str(position))
    if settings.switch_must_move and not facts.has_moved:
        return _failed(
            say("{switch}, not moved yet", switch=switch),
            say("The pilot's switch may not work."),
            say("Move it, and leave it for 2 s in each position."),
        )
    return CheckItem(name=_NAME, passed=True, value=say("{switch}, {count}", switch=switch, count=count))


def _receiver_problem(facts: RemoteControlFacts) -> CheckItem | None:
    if not facts.is_fresh:
        value = say("no word of it") if math.isinf(facts.age) else say("no word of it for {age:.0f} s", age=facts.age)
        return _failed(value, _NO_PILOT, say("Wait a moment; then check the link to the autopilot."))
    if facts.receiver is None:
        return _failed(say("the autopilot does not report its receiver's health"), _NO_PILOT, say("Wait a moment."))
    if not facts.receiver:
        return _failed(say("not heard by the autopilot"), _NO_PILOT, say("Switch it on, check receiver and binding."))
    return None


def _switch_problem(facts: RemoteControlFacts, values: Values) -> CheckItem | None:
    """Return the failed check of the switch; None when a pilot can take over by it."""
    channel = values.get(SWITCH_CHANNEL)
    if channel is None or facts.channel is None or any(values.get(name) is None for name in MODE_NAMES):
        return _failed(say("mode switch not read yet"), _NO_PILOT, say("Wait."))
    if channel == 0:
        return _failed(say("no mode switch (FLTMODE_CH 0)"), _NO_PILOT, say("Set FLTMODE_CH to the switch's channel."))
    if channel != facts.channel:
        return _failed(say("mode switch not read yet"), _NO_PILOT, say("Wait."))
    if switch_position(facts.pulse) is None:
        pulse = f"{facts.pulse} µs" if facts.pulse else say("no pulse")
        value = say("mode switch, channel {channel:g}: {pulse}", channel=channel, pulse=pulse)
        return _failed(
            value, say("The mode switch would do nothing."), say("Check FLTMODE_CH and the switch's channel.")
        )
    modes = [int(values[name] or 0) for name in MODE_NAMES]
    if not HAND_FLOWN.intersection(modes):
        names = ", ".join(dict.fromkeys(mode_name(mode) or "" for mode in modes))
        return _failed(
            say("its switch has only {names}", names=names),
            _NO_PILOT,
            say("Set one of FLTMODE1 to FLTMODE6 to LOITER (5)."),
        )
    return None


def _words_without(facts: RemoteControlFacts) -> str:
    if facts.is_heard:
        return say("not required, heard")
    return say("not required, none is heard: nobody can take over by hand")


def _mode(values: Values, position: int | None) -> str | None:
    number = None if position is None else values.get(MODE_NAMES[position - 1])
    return mode_name(None if number is None else int(number))


def _failed(value: str, consequence: str, remedy: str) -> CheckItem:
    return CheckItem(name=_NAME, passed=False, value=value, consequence=consequence, remedy=remedy)
