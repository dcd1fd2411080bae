"""Sentences are all that operators read of the program: the page has words for their codes in its language."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import replace

import pytest

from hawk.comm.protocol.commands import Ack
from hawk.ddc.acts import Acts, Log, ShowUserError
from hawk.ddc.battery.charge import NO_CHARGE, ChargeFacts
from hawk.ddc.facts import Facts, KeptFacts
from hawk.ddc.fence.plan import FencePlan
from hawk.ddc.orders import ToIdle
from hawk.ddc.parameters.values import Values
from hawk.ddc.readings.clearance import BelowFacts
from hawk.ddc.readings.home import HomeFacts
from hawk.ddc.rules import guard
from hawk.ddc.rules.judge import options
from hawk.ddc.rules.needs import Interlocks, Situation
from hawk.ddc.rules.preflight import preflight_items
from hawk.ddc.states.factory import make_state
from hawk.model.operation import Fall, Health, StateName
from hawk.model.poses import GlobalPose
from hawk.model.sentences import Sentence, parts_of, say
from hawk.model.vehicle import BatteryInfo, Diagnostics
from tests.sweep import sweep
from tests.unit.ddc.fakes import DEFAULT_PARAMETERS, SAFE_PARAMETERS
from tests.unit.ddc.state_table import COLUMNS, EVENTS, LATER, Column, Event, Program
from tests.unit.ddc.written_facts import DATUM, PARTS, SETTINGS, flying, on_ground

OTHERS = {"Not now.", "Vision: no answer."}
"""Words that the facts of the tests quote: the autopilot's, and those of a part of another room."""

_ENGLISH = re.compile(r"^[a-z]{2,}|[a-z]{2,} | [a-z]{2,}")


def unsaid(text: str) -> list[str]:
    """Return what has no words in another language: the text, or English among the values of its sentences."""
    if not text or text in OTHERS:
        return []
    if not isinstance(text, Sentence):
        return [text]
    values = [value for part in parts_of(text) for value in part.values.values() if isinstance(value, str)]
    plain = [value for value in values if not isinstance(value, Sentence) and value not in OTHERS]
    return [f"{value!r} in {text!r}" for value in plain if _ENGLISH.search(value)]


class Reports(Program):
    """A program of the table of states that keeps what it says."""

    def __init__(self, column: Column) -> None:
        self.said: list[str] = []
        super().__init__(column)

    def _keep(self, acts: Acts) -> None:
        super()._keep(acts)
        for act in acts:
            match act:
                case Log():
                    self.said += [act.text, act.details]
                case ShowUserError():
                    self.said.append(act.text)

    def look(self, facts: Facts) -> None:
        """Keep what the state says of itself."""
        state = self._decider.state
        self.said += [state.detail(facts), state.hold_refusal(facts)]

    def look_at_commands(self, facts: Facts) -> None:
        """Keep why commands are not possible."""
        self.said += [option.reason for option in options(self._decider.situation(facts))]


@pytest.mark.slow
@sweep("column", COLUMNS)
def test_every_message_and_refusal_of_a_state_is_a_sentence(column: Column) -> None:
    found: dict[str, str] = {}
    for event in EVENTS:
        for text in _reported(column, event):
            found |= dict.fromkeys(unsaid(text), event.name)
    assert found == {}


def _reported(column: Column, event: Event) -> list[str]:
    program = Reports.begun(column)
    if event.command is not None:
        answer = program.command(event, event.command).answer
        program.said += [answer.reason] if isinstance(answer, Ack) else []
    looked_at: StateName | None = None
    for moment in event.steps:
        program.tick(moment, event)
        facts = program.facts(moment, event)
        program.look(facts)
        if program.state is not looked_at or moment == event.steps[-1]:
            looked_at = program.state
            program.look_at_commands(facts)
    program.look(program.facts(LATER, event))
    program.look_at_commands(program.facts(LATER, event))
    return program.said


# -- checks and warnings of facts that no event of the table has -------------------------------------------------------


def _diagnostics(**values: object) -> Callable[[Facts], Facts]:
    return lambda facts: replace(facts, diagnostics=replace(facts.diagnostics, **values))  # type: ignore[arg-type]


def _battery(info: BatteryInfo | None, charge: ChargeFacts = NO_CHARGE) -> Callable[[Facts], Facts]:
    return lambda facts: replace(facts, battery=replace(facts.battery, info=info, charge=charge))


def _home(home: HomeFacts) -> Callable[[Facts], Facts]:
    return lambda facts: replace(facts, position=replace(facts.position, autopilot_home=home))


def _limits(**values: object) -> Callable[[Facts], Facts]:
    return lambda facts: replace(facts, limits=replace(facts.limits, **values))  # type: ignore[arg-type]


def _ill(facts: Facts) -> Facts:
    return replace(facts, parts=tuple((name, Health.bad(say("not known"))) for name in PARTS))


FAR = GlobalPose(DATUM.latitude + 0.01, DATUM.longitude, DATUM.altitude)
FULL = BatteryInfo(80.0, 12.0, 10.0, 1.0)
SQUARE = tuple((DATUM.latitude + n, DATUM.longitude + e) for n, e in ((0, 0.01), (0, 0.02), (0.01, 0.02), (0.01, 0.01)))
CHANGES: dict[str, Callable[[Facts], Facts]] = {
    "all is well": lambda facts: facts,
    "every part is ill": _ill,
    "nothing is known": lambda facts: Facts(now=facts.now, vehicle=facts.vehicle),
    "no compass": _diagnostics(compass_ok=False),
    "sensors": _diagnostics(all_ok=False),
    "no fix": _diagnostics(gps_fix=1, horizontal_accuracy=None, is_mavlink_1=True),
    "estimator": _diagnostics(horizontal_accuracy=3.0, estimator_fault=say("no absolute position")),
    "no diagnostics": lambda facts: replace(facts, diagnostics=Diagnostics()),
    "no battery": _battery(None),
    "no voltage": _battery(BatteryInfo(80.0, None, 10.0, 1.0)),
    "low battery": _battery(BatteryInfo(12.0, 11.0, 10.0, 1.0), ChargeFacts(volts=3.66, cells=3, allowed=9.0)),
    "too high a voltage": _battery(FULL, ChargeFacts(volts=6.0, cells=2)),
    "sagging": _battery(FULL, ChargeFacts(volts=3.1, cells=3, low_s=0.0)),
    "home unknown": _home(HomeFacts()),
    "home far away": _home(HomeFacts(FAR, 0.1, 1100.0, 4.0)),
    "home moved": _home(HomeFacts(FAR, 0.1, 1100.0, 4.0, is_inside=False)),
    "no fence": _limits(fence=None, plan_problem=say("lies outside the fence")),
    "fence elsewhere": _limits(plan=FencePlan("drawn", SQUARE, 100.0)),
    "not kept": lambda facts: replace(facts, kept=KeptFacts(say("the fence"), say("the fence"), 0.0)),
    "too close": lambda facts: replace(
        facts, position=replace(facts.position, below=BelowFacts(None, 0.5, 3.0), distrusted_s=9.0)
    ),
}
PARAMETERS: dict[str, Values] = {
    "safe": dict(SAFE_PARAMETERS),
    "not read": {},
    "defaults": dict(DEFAULT_PARAMETERS),
    "elsewhere": {**SAFE_PARAMETERS, "RALLY_TOTAL": 1, "RTL_ALT": 12_000, "SYSID_MYGCS": 12, "FENCE_ALT_MAX": 500},
    "bad": {
        **SAFE_PARAMETERS,
        "FS_GCS_ENABLE": 2,
        "FS_GCS_TIMEOUT": 99,
        "FS_THR_ENABLE": 0,
        "FS_EKF_THRESH": 0,
        "FENCE_TYPE": 0,
        "BATT_FS_LOW_ACT": 5,
        "BATT_FS_CRT_ACT": 7,
        "BATT_LOW_VOLT": 2.0,
        "RTL_LOIT_TIME": 90_000,
    },
}
FALL = Fall(0.0, DATUM.latitude, DATUM.longitude, 12.0)


@sweep("what", CHANGES)
@sweep("stands", [True, False])
@pytest.mark.nightly
def test_every_check_and_warning_is_made_of_sentences(what: str, stands: bool) -> None:
    facts = CHANGES[what](on_ground(flying(1.0)) if stands else flying(1.0))
    said = list(_checked(facts))
    said += [text for act in guard.notices(facts) if isinstance(act, Log) for text in (act.text, act.details)]
    for column in COLUMNS:
        state = make_state(column.transition, column.facts(0.0), SETTINGS)[0]
        reaction = guard.reaction(facts, state)
        if reaction is not None:
            _, acts = make_state(reaction.transition, facts, SETTINGS)
            said += [text for act in acts if isinstance(act, Log) for text in (act.text, act.details)]
    assert [each for text in said for each in unsaid(text)] == []


def _checked(facts: Facts) -> Iterator[str]:
    for values in PARAMETERS.values():
        for fall in (None, FALL):
            for check in preflight_items(facts, values, SETTINGS, is_killed=fall is not None, fall=fall):
                yield from (check.name, check.value, check.consequence, check.remedy)
            state, locks = make_state(ToIdle(), facts, SETTINGS)[0], Interlocks(fall=fall)
            situation = Situation(facts, state, SETTINGS, values, locks)
            yield from (option.reason for option in options(situation))


def test_a_text_without_a_code_is_found() -> None:
    assert unsaid("The wind is too strong.") == ["The wind is too strong."]
    assert unsaid(say("{text}.", text="too strong")) == ["'too strong' in 'too strong.'"]
    assert unsaid(say("Returning home, asked by {by}.", by="Ana")) == []
