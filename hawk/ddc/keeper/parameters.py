"""Keeps the autopilot's parameters in flight: what another station changes to the worse is reported and put back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from hawk.ddc.acts import Acts, Log, PutBack
from hawk.ddc.facts import Facts
from hawk.ddc.keeper.effort import LATER, Effort, changed_by
from hawk.ddc.keeper.fence import is_inside
from hawk.ddc.parameters.failsafes import FENCE, FENCE_NAMES, PARAMETERS_OF, AutopilotView, check_failsafes
from hawk.ddc.parameters.values import RETURN_HEIGHT, FailsafeCheck, Values
from hawk.ddc.words import named, sentence
from hawk.model.sentences import joined, say

PATIENCE_S = 30.0
"""One request takes up to 12 s on a link that loses datagrams; three of them."""

_Settings = Mapping[str, float]
_BY_LIMITS = frozenset({FENCE, RETURN_HEIGHT})
"""The checks that compare with the limits of the flight."""


class KeptParameters:
    """Compares the checks of successive ticks while the drone is armed, and puts back what was right in this flight.

    The rule is that of the checks before Arm: a value that passes needs no fight. What was never right in this flight
    is reported and keeps tasks off; nobody here knows what it ought to be. Ceiling and return height that were right
    once may be wrong by the limits of now: they are written where the check would pass with them.
    """

    def __init__(self, right: Mapping[str, float] | None = None) -> None:
        """Begin; ``right``: what an earlier run of the program found right in the flight that goes on."""
        self._reset(right or {})

    @property
    def right(self) -> Mapping[str, float]:
        """The parameters that were right in this flight, with their values."""
        return dict(self._before)

    def _reset(self, right: Mapping[str, float]) -> None:
        self._passed: dict[str, bool] = {}
        self._before = dict(right)
        self._efforts: dict[str, Effort] = {}
        self.lost: tuple[str, ...] = ()
        """The parameters that cannot be put back, each with its value."""
        self.restored: frozenset[str] = frozenset()
        """Names of the checks that do not pass now, whose parameters are being put back."""
        self.known: frozenset[str] = frozenset()
        """The same, and those whose parameters are put back once no pilot flies."""

    def tick(self, facts: Facts, values: Values, view: AutopilotView, *, may_write: bool) -> Acts:
        """Return messages and requests.

        Args:
            facts: The facts of this tick.
            values: The parameters that were read lately.
            view: What they are compared with.
            may_write: False while a pilot flies: it is reported, nothing is written.
        """
        if not facts.vehicle.armed:
            if facts.link.is_up:  # before the first HEARTBEAT nothing is known: the flight may go on
                self._reset({})
            return ()
        checks = check_failsafes(values, view)
        self._remember(checks, values)
        wrong = [check for check in checks if check.is_read and not check.passed]
        wanted = _proven({check.name: self._wanted(check, values) for check in wrong}, values, view)
        self.known = frozenset(name for name, found in wanted.items() if found)
        self.restored = self.known if may_write else frozenset()
        reports = self._report(checks, wanted, facts, may_write=may_write)
        return reports + self._put_back(wanted, values, facts, may_write=may_write)

    def _remember(self, checks: Sequence[FailsafeCheck], values: Values) -> None:
        """Keep the last values of this flight with which a check passed: together, and by the limits of now."""
        for check in checks:
            for name in PARAMETERS_OF[check.name] if check.passed else ():
                value = values.get(name)
                if value is not None:
                    self._before[name] = value

    def _wanted(self, check: FailsafeCheck, values: Values) -> dict[str, float]:
        """Return what must be written: parameter -> value."""
        known = ((name, self._before.get(name)) for name in PARAMETERS_OF[check.name])
        return {name: value for name, value in known if value is not None and values.get(name) not in (None, value)}

    def _put_back(self, wanted: Mapping[str, _Settings], values: Values, facts: Facts, *, may_write: bool) -> Acts:
        acts: Acts = ()
        lost = []
        settings = {name: value for each in wanted.values() for name, value in each.items()}
        for name in self._efforts.keys() - settings.keys():
            self._efforts[name].rest(facts)
        for name, value in settings.items():
            effort = self._efforts.setdefault(name, Effort(PATIENCE_S))
            if not may_write or (name in FENCE_NAMES and not is_inside(facts)):
                effort.rest(facts)
                continue
            was_given_up = effort.is_given_up
            acts += effort.put_back(PutBack(name, value), facts)
            if effort.is_given_up:
                lost.append(f"{name} {values[name]:g}")
                acts += () if was_given_up else (_given_up(name, value, effort.reason),)
        self.lost = tuple(lost)
        return acts

    def _report(
        self,
        checks: Sequence[FailsafeCheck],
        wanted: Mapping[str, _Settings],
        facts: Facts,
        *,
        may_write: bool,
    ) -> Acts:
        acts: list[Log] = []
        for check in checks:
            if not check.is_read:
                continue
            former = self._passed.get(check.name)
            self._passed[check.name] = check.passed
            if not check.passed and former is not False:
                acts.append(_warning(check, wanted[check.name], facts, may_write=may_write))
            elif check.passed and former is False:
                words = say("{name} is right again: {value}", name=check.name, value=sentence(check.value))
                acts.append(Log("ok", words))
        return tuple(acts)


def _proven(wanted: Mapping[str, _Settings], values: Values, view: AutopilotView) -> dict[str, _Settings]:
    """Return what is wanted, without what would still be wrong by the limits of this flight.

    A fence that is switched off is switched on apart from its parameters.
    """
    found, on = dict(wanted), replace(view, fence_on=True)
    while asked := _BY_LIMITS.intersection(name for name, settings in found.items() if settings):
        after = dict(values)
        for settings in found.values():
            after.update(settings)
        vain = [check.name for check in check_failsafes(after, on) if check.name in asked and not check.passed]
        if not vain:
            break
        found.update((name, {}) for name in vain)
    return found


def _warning(check: FailsafeCheck, wanted: Mapping[str, float], facts: Facts, *, may_write: bool) -> Log:
    who, is_put_back = changed_by(facts, tuple(wanted)), bool(wanted) or check.is_switched_off
    remedy = joined(say("It is being put back.") if may_write else LATER, who.details)
    text = joined(named(check.name, check.value), who.message, say("No new task until it is right."))
    if not is_put_back:
        remedy = say("Return or land, then Set failsafes.") if check.can_be_set else check.remedy
    return Log("warning", text, joined(sentence(check.consequence), remedy))


def _given_up(name: str, value: float, reason: str) -> Log:
    words = say("{name} cannot be put back to {value:g}.", name=name, value=value)
    return Log("error", words, reason or say("Somebody changes it again and again."))
