"""Reports in flight that a failsafe of the autopilot changed: by another station, a switch, or a restart."""

from __future__ import annotations

from collections.abc import Sequence

from hawk.ddc.acts import Acts, Log
from hawk.ddc.facts import Facts
from hawk.ddc.parameter_values import FailsafeCheck
from hawk.ddc.words import sentence


class FailsafeWatch:
    """Compares the checks of successive ticks while the drone is armed; the flight goes on."""

    def __init__(self) -> None:
        self._passed: dict[str, bool] = {}

    def tick(self, facts: Facts, checks: Sequence[FailsafeCheck]) -> Acts:
        """Return a message for each failsafe that became wrong, or right again."""
        if not facts.vehicle.armed:
            self._passed.clear()  # the checks before Arm show it
            return ()
        acts: list[Log] = []
        for check in checks:
            if not check.is_read:
                continue
            former = self._passed.get(check.name)
            self._passed[check.name] = check.passed
            if not check.passed and former is not False:
                acts.append(_warning(check))
            elif check.passed and former is False:
                acts.append(Log("ok", f"{check.name} is right again: {sentence(check.value)}"))
        return tuple(acts)


def _warning(check: FailsafeCheck) -> Log:
    remedy = "Return or land, then Set failsafes." if check.can_be_set else check.remedy
    text = f"{check.name}: {sentence(check.value)} No new task until it is right."
    return Log("warning", text, f"{sentence(check.consequence)} {remedy}")
