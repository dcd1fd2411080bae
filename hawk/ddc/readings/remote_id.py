"""Remote ID: whether the transmitter says that the drone may fly, before Arm and in flight."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from hawk.comm.autopilot.remote_id import RemoteIdReport
from hawk.comm.protocol.heartbeat import CheckItem
from hawk.comm.topic import Topic
from hawk.config.sections import RemoteIdSettings
from hawk.ddc.readings.instant import Instant, Parts, Reading
from hawk.ddc.words import sentence
from hawk.model.operation import Health
from hawk.model.sentences import say

AGE_S: Final = 3.0
"""An older OPEN_DRONE_ID_ARM_STATUS (1 Hz) says nothing, seconds, as in ArduPilot's own check."""
_NAME: Final = say("Remote ID")
_UNIDENTIFIED: Final = say("The drone would fly without an identification.")


@dataclass(frozen=True, slots=True)
class RemoteIdFacts:
    """The transmitter's word: ``good`` to arm, else ``error``; None before the first. ``age`` in seconds."""

    good: bool | None = None
    error: str = ""
    age: float = math.inf

    @property
    def problem(self) -> str:
        """Reason why the drone would not be identified; empty when it would be."""
        if self.good is None:
            return say("no word of a transmitter")
        if self.age > AGE_S:
            return say("no word of the transmitter for {age:.0f} s", age=self.age)
        return "" if self.good else self.error or say("the transmitter is not ready, and does not say why")


NO_REMOTE_ID: Final = RemoteIdFacts()
"""Nothing was heard of a transmitter."""


def remote_id_facts(report: RemoteIdReport | None, now: float) -> RemoteIdFacts:
    """Return what was heard as of ``now``, seconds."""
    return NO_REMOTE_ID if report is None else RemoteIdFacts(report.good, report.error, now - report.time)


def remote_id_checks(facts: RemoteIdFacts, settings: RemoteIdSettings) -> tuple[CheckItem, ...]:
    """Return the check before Arm; none where Remote ID is off."""
    if not settings.enabled:
        return ()
    problem = facts.problem
    if not problem:
        value = say("good to arm, operator {operator}", operator=str(settings.operator_id))
        return (CheckItem(name=_NAME, passed=True, value=value),)
    if facts.good is False and facts.age <= AGE_S:
        remedy = say("Wait a moment; then check [remote_id] and the transmitter's own settings.")
    else:
        remedy = say("Check the transmitter, DID_ENABLE and DID_MAVPORT (or DID_CANDRIVER).")
    return (CheckItem(name=_NAME, passed=False, value=problem, consequence=_UNIDENTIFIED, remedy=remedy),)


def remote_id_health(facts: RemoteIdFacts, settings: RemoteIdSettings, *, is_armed: bool) -> Health:
    """Return the health in flight; before it the preflight check shows it."""
    problem = facts.problem if settings.enabled and is_armed else ""
    return Health.bad(say("Remote ID: {problem}", problem=sentence(problem))) if problem else Health()


class RemoteIdReading(Reading):
    """Reads the transmitter's last word."""

    def __init__(self, report: Topic[RemoteIdReport], settings: RemoteIdSettings) -> None:
        self._report = report
        self._settings = settings

    def facts(self, instant: Instant) -> RemoteIdFacts:
        """Return what is known."""
        return remote_id_facts(self._report.value, instant.now)

    def parts(self, instant: Instant) -> Parts:
        """Return the transmitter's health."""
        health = remote_id_health(self.facts(instant), self._settings, is_armed=instant.is_armed_and_heard)
        return (("remote id", health),)
