"""End of the autopilot's own return: parameters that lead RTL elsewhere, above the ceiling, or let it never land.

The values and their meaning are those of ArduPilot's parameter documentation (ArduCopter/Parameters.cpp,
ArduCopter/mode_rtl.cpp, AP_Rally/AP_Rally.cpp). ArduPilot 4.7 counts in metres under new names.
"""

from __future__ import annotations

from dataclasses import dataclass

from hawk.ddc.parameters.values import NOT_READ, FailsafeCheck, Values, setting_words
from hawk.model.sentences import say

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
