"""The charge that is believed: the autopilot's counter, compared with the voltage and with the time flown.

The counter subtracts the current from the capacity that was set, and begins at 100 % with each start of the autopilot,
whatever the battery holds. So it is believed only while the voltage of the cells allows it and it falls in flight.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from statistics import median_high

from hawk.ddc.battery.chemistry import LEAST_CELL_V, REST_TOLERANCE_V, SAG_V, Chemistry
from hawk.ddc.battery.energy import ASSUMED_DRAIN
from hawk.ddc.stopwatch import Stopwatch
from hawk.model.sentences import say
from hawk.model.vehicle import BatteryInfo

WINDOW_S = 6.0
"""The voltage is the median of this time, seconds: a dip of less than half of it does not count."""
SPAN_S = 2.5
"""A median needs readings over this time, seconds."""
CLIMB_OUT_S = 4.5
"""After a take-off it needs this time, seconds: a dip of 2 s, when the motors take most, is less than half of it."""
CONTRADICTION_PERCENT = 25.0
"""A counter that says so much more than the voltage allows is wrong."""
STILL_S = 72.0
"""A counter in flight that does not fall for this time stands still, seconds: a drone that flies an hour, as long as
any that carries a camera and a computer, uses 2 % in it."""
SLOWEST_DRAIN = 100.0 / (60 * 60)
"""Percent a second of such a drone."""
SLACK_PERCENT = 2.0
"""Rounding of the counter, and its pauses."""
RISE_PERCENT = 1.0
"""A counter in flight that rises by more did not round."""
DIP_S = 10.0
"""A counter that is back within this time only dipped, as one does that is made from the voltage, seconds."""
HELD_S = 2.0
"""A counter that was low for this time and is back where the flight began, or higher, began again, seconds."""
JUMP_PERCENT = 10.0
"""It rose by more then."""


@dataclass(frozen=True, slots=True)
class ChargeFacts:
    """The battery as it is believed. ``counter`` is the autopilot's word."""

    counter: float | None = None
    believed: float | None = None
    """Percent; the lower one of what counter, voltage and time allow. None while nothing says it."""
    volts: float | None = None
    """Volts a cell: at rest on the ground, under load in flight."""
    cells: int | None = None
    """The cell count that is taken: the largest possible one before a flight, the smallest in it. So an open count
    refuses Arm rather than none, and ends no flight."""
    allowed: float | None = None
    """The most that the voltage allows, percent."""
    doubt: str = ""
    """Why the counter is not believed; empty when it is. In flight it lasts until the landing."""
    doubted_s: float = 0.0
    """Seconds since the doubt began, in flight."""
    flown_s: float = 0.0
    """Seconds in the air, of this flight."""
    low_s: float | None = None
    """Seconds since the voltage sagged below the limit that ends a task, in this flight; None while it did not."""
    critical_s: float | None = None
    """The same for the limit under which it lands."""

    @property
    def is_low(self) -> bool:
        """True when the drone must return: a battery that sagged once does so again."""
        return self.low_s is not None

    @property
    def is_critical(self) -> bool:
        """True when it must land."""
        return self.critical_s is not None

    @property
    def words(self) -> str:
        """Words on what was believed, for the log: voltage, counter and time flown."""
        volts = say("voltage not known") if self.volts is None else cell_words(self.volts, self.cells)
        counter = (
            say("the counter says nothing")
            if self.counter is None
            else say("the counter says {counter:.0f} %", counter=self.counter)
        )
        believed = say("nothing else") if self.believed is None else say("{percent:.0f} %", percent=self.believed)
        return say(
            "{volts}, {counter}, {believed} was believed, {flown_s:.0f} s in the air.",
            volts=volts,
            counter=counter,
            believed=believed,
            flown_s=self.flown_s,
        )


NO_CHARGE = ChargeFacts()
"""Before the first reading."""


class ChargeReading:
    """Follows counter and voltage, reading by reading."""

    def __init__(self, chemistry: Chemistry, return_v: float | None = None, land_v: float | None = None) -> None:
        """``return_v`` and ``land_v``: limits under load, volts a cell, in place of those of the chemistry."""
        self._chemistry = chemistry
        self._return_v = chemistry.return_v if return_v is None else return_v
        self._land_v = min(self._return_v, chemistry.land_v if land_v is None else land_v)
        self._volts: deque[tuple[float, float]] = deque()
        self._is_airborne = False
        self._low, self._critical = Stopwatch(), Stopwatch()
        self._took_off = 0.0
        self._begun: tuple[float, float] | None = None
        self._lowest: tuple[float, float] | None = None
        self._held: float | None = None
        self._settling, self._holding = _Highest(DIP_S), _Highest(HELD_S)
        self._doubt = ""
        self._doubted_at = 0.0
        self._counted: tuple[float, float] = (0.0, 0.0)
        """Charge (percent) and time (seconds) from which the time flown counts, once the counter does not."""

    def update(self, info: BatteryInfo | None, cells: tuple[int, ...], now: float, *, is_airborne: bool) -> ChargeFacts:
        """Return what is believed now.

        Args:
            info: The latest reading, None when it is too old.
            cells: The cell counts that the battery may have; the largest one counts, which is the safe side.
            now: Seconds of the daemon's clock.
            is_airborne: The drone is believed in the air.
        """
        if is_airborne != self._is_airborne:
            self._begin(now, is_airborne=is_airborne)
        counter = None if info is None else _finite(info.percentage)
        count = None if not cells else min(cells) if is_airborne else max(cells)
        volts = self._median(info, count, now)
        allowed = None if volts is None else self._allowed(volts)
        doubt = _contradiction(counter, allowed, volts, is_airborne=is_airborne)
        if is_airborne:
            self._look(counter, now)
            self._look_at_volts(volts, now)
            if doubt and allowed is not None:
                self._disbelieve(doubt, allowed, now, now)
            doubt = self._doubt
        return ChargeFacts(
            counter=counter,
            believed=self._believe(counter, allowed, doubt, now),
            volts=volts,
            cells=count,
            allowed=allowed,
            doubt=doubt,
            doubted_s=now - self._doubted_at if is_airborne and doubt else 0.0,
            flown_s=now - self._took_off if is_airborne else 0.0,
            low_s=self._low.read(now),
            critical_s=self._critical.read(now),
        )

    def _begin(self, now: float, *, is_airborne: bool) -> None:
        """Forget what was measured at rest when it takes off, and what was measured in flight when it lands."""
        self._is_airborne, self._took_off = is_airborne, now
        self._volts.clear()
        self._held = None
        self._settling, self._holding = _Highest(DIP_S), _Highest(HELD_S)
        self._begun, self._lowest, self._doubt = None, None, ""
        self._low, self._critical = Stopwatch(), Stopwatch()

    def _median(self, info: BatteryInfo | None, count: int | None, now: float) -> float | None:
        """Return the median voltage of a cell; None while it is not known."""
        volts = None if info is None or count is None else _finite(info.voltage)
        least = LEAST_CELL_V if self._is_airborne else 0.0
        is_known = volts is not None and count is not None and volts > least * count
        if is_known and info is not None and volts is not None and (not self._volts or info.time > self._volts[-1][0]):
            self._volts.append((info.time, volts))
        while self._volts and now - self._volts[0][0] > WINDOW_S:
            self._volts.popleft()
        if not is_known or count is None or not self._volts:
            return None
        is_short = self._volts[-1][0] - self._volts[0][0] < SPAN_S or now - self._took_off < CLIMB_OUT_S
        if self._is_airborne and is_short:
            return None
        return median_high(volts for _, volts in self._volts) / count

    def _allowed(self, volts: float) -> float:
        return self._chemistry.charge(volts + (SAG_V if self._is_airborne else REST_TOLERANCE_V))

    def _look_at_volts(self, volts: float | None, now: float) -> None:
        """Look whether the voltage sags: a battery that sagged once is low for the whole flight."""
        if volts is not None and volts < self._return_v:
            self._low.update(True, now)
        if volts is not None and volts < self._land_v:
            self._critical.update(True, now)

    def _look(self, counter: float | None, now: float) -> None:
        """Look whether the counter counts."""
        if counter is None:
            return
        if self._begun is None or self._lowest is None:
            self._begun = self._lowest = (counter, now)
        (begun, start), (lowest, since) = self._begun, self._lowest
        used, flown, still = begun - counter, now - start, now - since
        settled, held = self._settling.of(counter, now), self._holding.of(counter, now)
        self._held = held if self._held is None else min(held, self._held)
        if counter >= begun and counter > self._held + JUMP_PERCENT:
            words = _risen(self._held, counter)
            self._disbelieve(words, self._held, now, now)
        elif counter > lowest + RISE_PERCENT:
            self._disbelieve(_risen(lowest, counter), lowest, now, now)
        elif counter > 0.0 and still >= STILL_S:
            words = say("the counter stands still at {counter:.0f} % for {still:.0f} s", counter=counter, still=still)
            self._disbelieve(words, lowest, since, now)
        elif counter > 0.0 and used < flown * SLOWEST_DRAIN - SLACK_PERCENT:
            words = say("the counter fell by {used:.0f} % in {flown:.0f} s in the air", used=used, flown=flown)
            self._disbelieve(words, begun, start, now)
        if settled < lowest:
            self._lowest = (settled, now)

    def _disbelieve(self, doubt: str, charge: float, since: float, now: float) -> None:
        """Believe the counter no more in this flight: ``charge`` (percent) at ``since`` is the last that counts."""
        if not self._doubt:
            self._doubt, self._doubted_at, self._counted = doubt, now, (charge, since)

    def _believe(self, counter: float | None, allowed: float | None, doubt: str, now: float) -> float | None:
        """Return the lowest of counter, voltage and, where the counter is not believed, the time flown.

        The voltage has its say once the counter is doubted: cells differ by some points, and in flight they sag.
        """
        found = [] if counter is None else [counter]
        if self._doubt:
            charge, since = self._counted
            found.append(max(0.0, charge - (now - since) * ASSUMED_DRAIN))
        if found and allowed is not None and doubt:
            found.append(allowed)
        return min(found, default=None)


class _Highest:
    """The highest value of the last seconds."""

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._values: deque[tuple[float, float]] = deque()

    def of(self, value: float, now: float) -> float:
        """Take a value and return the highest one."""
        while self._values and self._values[-1][1] <= value:
            self._values.pop()
        self._values.append((now, value))
        while now - self._values[0][0] > self._seconds:
            self._values.popleft()
        return self._values[0][1]


def _risen(lowest: float, counter: float) -> str:
    return say("the counter rose from {lowest:.0f} to {counter:.0f} % in flight", lowest=lowest, counter=counter)


def _contradiction(counter: float | None, allowed: float | None, volts: float | None, *, is_airborne: bool) -> str:
    if counter is None or allowed is None or volts is None or counter - allowed <= CONTRADICTION_PERCENT:
        return ""
    return say(
        "the counter says {counter:.0f} %, {volts:.2f} V a cell {state} is {allowed:.0f} % at most",
        counter=counter,
        volts=volts,
        state=say("in flight") if is_airborne else say("at rest"),
        allowed=allowed,
    )


def cell_words(volts: float, cells: int | None) -> str:
    """Return the voltage of a cell in words; ``cells``: their number."""
    return say("{volts:.2f} V a cell of {cells}", volts=volts, cells=str(cells) if cells is None else cells)


def _finite(value: float | None) -> float | None:
    """Return a number that may be one."""
    return value if value is not None and math.isfinite(value) and value >= 0.0 else None
