"""Causes of a return or a landing: how long each lasts, which is how long Hold is refused."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any

import pytest

from hawk.ddc.battery.charge import ChargeFacts
from hawk.ddc.battery.energy import Reserve
from hawk.ddc.facts import Facts, KeptFacts
from hawk.ddc.motion import Goal
from hawk.ddc.orders import (
    Cause,
    CauseKind,
    MoveOrder,
    Rank,
    ToArm,
    ToCommunicationLost,
    ToHover,
    ToIdle,
    ToLand,
    ToReturn,
)
from hawk.model.poses import MapPoint
from tests.unit.ddc.written_facts import flying


def battery(**changes: Any) -> Callable[[Facts], Facts]:
    return lambda facts: replace(facts, battery=replace(facts.battery, **changes))


def reserve(percentage: float) -> Callable[[Facts], Facts]:
    return battery(reserve=Reserve(percentage, 30.0, 0.0))


def breached(facts: Facts) -> Facts:
    return replace(facts, limits=replace(facts.limits, breached_s=0.0))


def windy(facts: Facts) -> Facts:
    return replace(facts, wind=replace(facts.wind, strong_s=0.0))


def lost(facts: Facts) -> Facts:
    return replace(facts, operator=replace(facts.operator, is_present=False))


def well(facts: Facts) -> Facts:
    return facts


@pytest.mark.parametrize(
    ("kind", "change", "lasts"),
    [
        (CauseKind.RESERVE, reserve(30.0), True),
        (CauseKind.RESERVE, reserve(30.1), False),
        (CauseKind.RESERVE, well, False),
        (CauseKind.BATTERY_UNKNOWN, battery(info=None), True),
        (CauseKind.BATTERY_UNKNOWN, well, False),
        (CauseKind.VOLTAGE, battery(charge=ChargeFacts(low_s=0.0)), True),
        (CauseKind.VOLTAGE, well, False),
        (CauseKind.FENCE, breached, True),
        (CauseKind.FENCE, well, False),
        (CauseKind.WIND, windy, True),
        (CauseKind.WIND, well, False),
        (CauseKind.KEPT, lambda facts: replace(facts, kept=KeptFacts(lost="home")), True),
        (CauseKind.KEPT, well, False),
        (CauseKind.OPERATOR, lost, True),
        (CauseKind.OPERATOR, well, False),
        (CauseKind.ALWAYS, well, True),
        (CauseKind.NEVER, breached, False),
    ],
)
def test_a_cause_lasts_as_long_as_its_condition(kind: CauseKind, change: Callable[[Facts], Facts], lasts: bool) -> None:
    assert Cause("words", kind).lasts(change(flying(1.0))) is lasts


def test_the_order_of_rank() -> None:
    rising = (
        Rank.TASK,
        Rank.PERCEPTION,
        Rank.FENCE,
        Rank.COMMUNICATION_LOST,
        Rank.RETURN_TO_LAUNCH,
        Rank.LAND,
        Rank.AUTOPILOT,
        Rank.PILOT,
        Rank.KILL,
    )
    assert set(rising) == set(Rank)
    assert all(low < high for low, high in pairwise(rising))


def test_a_move_has_its_place_as_goal() -> None:
    order = MoveOrder(MapPoint(1.0, 2.0), 30.0, 0.5, autonomous=False, number=0)
    assert order.goal == Goal(1.0, 2.0, 30.0, 0.5)
    assert order.route.points == ()


def test_what_nobody_says_is_the_plain_case() -> None:
    """Nothing is passive, flown by the autopilot, or armed already, unless it is said."""
    assert (ToHover().passive, ToHover().goal, ToHover().level) == (False, None, "info")
    assert (ToReturn().by_autopilot, ToReturn().straight, ToReturn().cause) == (False, "", None)
    assert (ToLand().by_autopilot, ToLand().cause) == (False, None)
    assert (ToArm().armed, ToArm().checks) == (False, 0)
    assert ToIdle().gave_up_arming is False
    assert ToCommunicationLost().passive is False
