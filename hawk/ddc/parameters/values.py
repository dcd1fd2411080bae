"""Values of the autopilot's parameters: which ones pass, and what is said of those that do not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from hawk.ddc.battery.chemistry import LIPO, Chemistry
from hawk.model.sentences import say

NOT_READ = say("not read yet")
_UNKNOWN = say("not known to be safe")

Values = Mapping[str, float | None]
"""Parameter -> value; None: the autopilot does not have it. A parameter that was not read yet is missing."""


@dataclass(frozen=True, slots=True)
class FailsafeCheck:
    """One failsafe: whether it is well, what was found, what follows if it is not, and what to do.

    ``can_be_set``: Set Failsafes is the remedy. ``is_switched_off``: a command or a switch turned it off, while every
    parameter is right.
    """

    name: str
    passed: bool
    value: str
    consequence: str = ""
    remedy: str = ""
    can_be_set: bool = False
    is_switched_off: bool = False

    @property
    def is_read(self) -> bool:
        """True when everything that decides it was read."""
        return self.value != NOT_READ


@dataclass(frozen=True, slots=True)
class Choice:
    """A parameter with few values. ``right`` and ``wrong``: value -> what the autopilot does."""

    name: str
    right: Mapping[int, str]
    wrong: Mapping[int, str]
    wanted: float

    def problem(self, value: float) -> str:
        """Return what is wrong with a value; empty when it is right."""
        if value in self.right:
            return ""
        words = self.wrong.get(int(value), _UNKNOWN) if value == int(value) else _UNKNOWN
        return setting_words(words, self.name, value)


@dataclass(frozen=True, slots=True)
class Span:
    """A parameter with bounds."""

    name: str
    low: float
    high: float
    wanted: float
    unit: str = ""

    def problem(self, value: float) -> str:
        """Return what is wrong with a value; empty when it is right."""
        if self.low <= value <= self.high:
            return ""
        return say(
            "{name} is {value:g}{unit}, must be {low:g} to {high:g}{unit}",
            name=self.name,
            value=value,
            unit=self.unit,
            low=self.low,
            high=self.high,
        )


def setting_words(words: str, name: str, value: float) -> str:
    """Return what the autopilot does, with the parameter that says so and its value."""
    return say("{does} ({parameter} {value:g})", does=words, parameter=name, value=value)


def names_to_read(names: tuple[str, ...], values: Values) -> tuple[str, ...]:
    """Return the one of a parameter's names that the autopilot has; all while none has answered.

    Silence proves nothing: a name without an answer may be the right one.
    """
    found = next((name for name in names if values.get(name) is not None), None)
    return names if found is None else (found,)


def present_name(names: tuple[str, ...], values: Values) -> str:
    """Return the name that the autopilot has; the first, the newest, while none has answered."""
    return names_to_read(names, values)[0]


def problem_of(values: Values, *settings: Choice | Span) -> str:
    """Return the first problem; `NOT_READ` while a parameter was not read; empty when all are right."""
    for setting in settings:
        value = values.get(setting.name)
        problem = NOT_READ if value is None else setting.problem(value)
        if problem:
            return problem
    return ""


RETURN_CHECK = say("Autopilot's return")
RETURN_HEIGHT = say("Return height")
"""Names of the checks that say where RTL ends."""
RALLY_NAME = "RALLY_TOTAL"
"""Number of rally points. With one, RTL flies to the nearest of home and rally points (ModeRTL::build_path). An
autopilot that was built without rally points lacks it."""
CLIMB_M = 3.0
"""RTL may climb by this much from where it begins, metres: our ceiling lies as far below the autopilot's."""

LOITER_NAME = "RTL_LOIT_TIME"
"""Milliseconds that RTL waits above home before it descends; ArduPilot's documentation allows up to 60,000."""
SPEED_NAMES = ("RTL_SPEED_MS", "RTL_SPEED")
"""Speed of RTL, m/s and cm/s; 0: that of waypoints. ArduPilot's documentation allows up to 20 m/s."""
RETURN_ALTITUDE_NAMES = ("RTL_ALT_M", "RTL_ALT")
"""Metres since ArduPilot 4.7, centimetres before. Its other parameters of RTL were renamed with it."""


@dataclass(frozen=True, slots=True)
class ReturnSetting:
    """A parameter that must be 0, or lie between ``lowest`` and ``highest``. ``words``: what RTL does otherwise.

    ``in_metres`` is its name since ArduPilot 4.7, ``in_centimetres`` the name before, with values a hundred times as
    large where the names differ. An autopilot may lack one that is ``optional``.
    """

    in_metres: str
    in_centimetres: str
    highest: float
    words: str
    lowest: float = 0.0
    optional: bool = False

    def name(self, values: Values) -> str:
        """Return the name that belongs to the return altitude's; empty while that was not read."""
        if values.get(RETURN_ALTITUDE_NAMES[0]) is not None:
            return self.in_metres
        return self.in_centimetres if values.get(RETURN_ALTITUDE_NAMES[1]) is not None else ""

    def problem(self, values: Values) -> str:
        """Return what is wrong; `NOT_READ` while it was not read; empty when it is right."""
        name = self.name(values)
        value = values.get(name)
        if value is None:
            return "" if self.optional and name in values else NOT_READ
        scale = 1.0 if name == self.in_metres else 100.0
        is_right = value == 0.0 or self.lowest * scale <= value <= self.highest * scale
        return "" if is_right else setting_words(self.words, name, value)


RETURN_SETTINGS = (
    ReturnSetting("RTL_ALT_FINAL_M", "RTL_ALT_FINAL", 0.0, say("stays in the air above home")),
    ReturnSetting("RTL_CLIMB_MIN_M", "RTL_CLIMB_MIN", CLIMB_M, say("climbs first, above the ceiling")),
    ReturnSetting("RTL_ALT_TYPE", "RTL_ALT_TYPE", 0.0, say("follows a terrain that it may not know")),
    ReturnSetting(LOITER_NAME, LOITER_NAME, 60_000.0, say("waits above home for too long"), optional=True),
    ReturnSetting(*SPEED_NAMES, 20.0, say("flies too slowly or too fast"), lowest=1.0, optional=True),
)
OPTIONAL_RETURN_NAMES = frozenset({LOITER_NAME, *SPEED_NAMES})
ALL_RETURN_NAMES = frozenset(
    {RALLY_NAME, *(name for setting in RETURN_SETTINGS for name in (setting.in_metres, setting.in_centimetres))}
)


def return_names(values: Values) -> tuple[str, ...]:
    """Return the parameters that must be read, given what was read so far: their names follow the return altitude's."""
    return (RALLY_NAME, *filter(None, (setting.name(values) for setting in RETURN_SETTINGS)))


def wanted_returns(values: Values) -> dict[str, float]:
    """Return what must be written: parameter -> value, the right ones left out."""
    return {name: 0.0 for each in RETURN_SETTINGS if (name := each.name(values)) and each.problem(values)}


def return_check(values: Values) -> FailsafeCheck:
    """Return the check of where the autopilot's return ends; what was not read yet has not passed."""
    name = RETURN_CHECK
    consequence = say("The autopilot's own return would not end on the ground where the drone took off.")
    problems = [setting.problem(values) for setting in RETURN_SETTINGS]
    problem = NOT_READ if RALLY_NAME not in values or NOT_READ in problems else next(filter(None, problems), "")
    if problem:
        return FailsafeCheck(name, False, problem, consequence, say("Set failsafes."), can_be_set=True)
    if rally := values[RALLY_NAME]:
        words = setting_words(say("to a rally point where one is nearer"), RALLY_NAME, rally)
        return FailsafeCheck(name, False, words, consequence, say("Delete the rally points with the other station."))
    return FailsafeCheck(name, True, say("to home, and lands"))


THRESHOLD_NAMES = ("BATT_LOW_VOLT", "BATT_LOW_MAH", "BATT_LOW_TIMER", "BATT_CAPACITY")
"""Volts (0: off), milliampere-hours left (0: off), seconds below the voltage (0: never), milliampere-hours when full.

Source: ArduPilot, AP_BattMonitor_Params.cpp, Copter 4.5 to 4.7.
"""
LOW_SHARE = 0.6
"""The largest BATT_LOW_MAH as a share of the capacity; ArduPilot's documentation recommends 0.2."""
LOW_TIMER_S = (1.0, 30.0)
"""ArduPilot's default is 10 s."""


@dataclass(frozen=True, slots=True)
class Problem:
    """A threshold that is wrong: what was found, and what to do."""

    value: str
    remedy: str


def threshold_problem(
    values: Mapping[str, float], cells: tuple[int, ...], chemistry: Chemistry = LIPO
) -> Problem | None:
    """Return what is wrong; None when the voltage triggers in time, and neither voltage nor charge triggers at once.

    A charge alone is not enough: it is the counter's, which begins at 100 % with any battery.

    Args:
        values: Each of `THRESHOLD_NAMES` -> its value.
        cells: The cell counts that the battery may have; the thresholds must fit each of them.
        chemistry: The kind of its cells.
    """
    volts, charge, timer, capacity = (values[name] for name in THRESHOLD_NAMES)
    if volts <= 0:
        remedy = _voltage_remedy(cells, chemistry)
        if charge <= 0:
            return Problem(say("off: BATT_LOW_VOLT and BATT_LOW_MAH are 0"), remedy)
        return Problem(say("no voltage: BATT_LOW_VOLT is 0, and BATT_LOW_MAH believes the counter"), remedy)
    if charge > 0 and capacity > 0 and charge / capacity > LOW_SHARE:
        value = say(
            "BATT_LOW_MAH is {charge:g} of BATT_CAPACITY {capacity:g}: it would return at once",
            charge=charge,
            capacity=capacity,
        )
        return Problem(value, say("Set BATT_LOW_MAH to {fifth:.0f}, a fifth of the battery.", fifth=0.2 * capacity))
    return _voltage_problem(volts, timer, cells, chemistry)


def threshold_words(values: Mapping[str, float], cells: tuple[int, ...]) -> str:
    """Return thresholds that are right, in words."""
    volts, charge, timer, _ = (values[name] for name in THRESHOLD_NAMES)
    by_voltage = say("below {volts:g} V for {timer:g} s", volts=volts, timer=timer)
    if len(cells) == 1:
        each = volts / cells[0]
        by_voltage = say("below {volts:g} V ({each:.2f} V a cell) for {timer:g} s", volts=volts, each=each, timer=timer)
    return say("{time} or below {charge:g} mAh", time=by_voltage, charge=charge) if charge > 0 else by_voltage


def _voltage_problem(volts: float, timer: float, cells: tuple[int, ...], chemistry: Chemistry) -> Problem | None:
    low, high = chemistry.low
    if not LOW_TIMER_S[0] <= timer <= LOW_TIMER_S[1]:
        return Problem(
            say(
                "BATT_LOW_TIMER is {timer:g} s, must be {low:g} to {high:g} s",
                timer=timer,
                low=LOW_TIMER_S[0],
                high=LOW_TIMER_S[1],
            ),
            say("Set BATT_LOW_TIMER to 10 s in the autopilot."),
        )
    if not cells:
        return Problem(say("the battery's cells are not known"), say("Set flight.battery_cells in the settings."))
    for count in cells:
        if not low <= volts / count <= high:
            sure = len(cells) == 1
            each = volts / count
            value = say(
                "BATT_LOW_VOLT {volts:g} V is {each:.2f} V a cell of {count}", volts=volts, each=each, count=count
            )
            remedy = say("Set flight.battery_cells in the settings.")
            return Problem(value, _voltage_remedy(cells, chemistry) if sure else remedy)
    return None


def _voltage_remedy(cells: tuple[int, ...], chemistry: Chemistry) -> str:
    usual = chemistry.low_usual
    if len(cells) != 1:
        return say("Set BATT_LOW_VOLT in the autopilot to {usual:g} V for each cell of the battery.", usual=usual)
    return say(
        "Set BATT_LOW_VOLT in the autopilot to {whole:.1f} V, {usual:g} V for each of {cells} cells.",
        whole=usual * cells[0],
        usual=usual,
        cells=cells[0],
    )
