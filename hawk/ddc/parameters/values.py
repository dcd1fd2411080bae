"""Values of the autopilot's parameters: which ones pass, and what is said of those that do not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

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
