"""Behaviour that the states share, by facts alone: limits at their very value, orders that do not fit, lost facts."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hawk.comm.protocol.commands import Disarm, Takeoff
from hawk.ddc.acts import (
    STAY,
    Log,
    SetMode,
)
from hawk.ddc.facts import Facts
from hawk.ddc.fence.outline import OutlineFacts
from hawk.ddc.orders import (
    Cause,
    CauseKind,
    ConfigureOrder,
    FenceOrder,
    ToArm,
    ToConfigure,
    ToExplore,
    ToHover,
    ToIdle,
    ToLand,
    ToManual,
    ToMove,
    ToReturn,
    Transition,
)
from hawk.ddc.states.base import MODE_RETRY_S, ModeKeeper
from hawk.ddc.states.factory import adopted, make_state
from hawk.model.operation import StateName
from hawk.model.vehicle import CopterMode, ForeignWrite
from tests.unit.ddc.by_facts import (
    HEIGHTS,
    IN_THE_AIR,
    MOVE,
    answered,
    at,
    made,
    requests,
    standing,
    texts,
)
from tests.unit.ddc.written_facts import SETTINGS, flying


@pytest.mark.parametrize("transition", IN_THE_AIR, ids=lambda each: type(each).__name__)
def test_orders_of_the_ground_change_no_state_in_the_air(transition: Transition) -> None:
    state = made(transition)
    for order in (Takeoff(), Disarm(), ConfigureOrder(HEIGHTS), FenceOrder(None)):
        assert state.transition_next_state(flying(0.05), order) == STAY


@pytest.mark.parametrize("transition", [ToIdle(), *IN_THE_AIR], ids=lambda each: type(each).__name__)
def test_only_arm_lets_the_drone_take_off(transition: Transition) -> None:
    assert not made(transition).may_take_off
    assert made(ToArm(armed=True)).may_take_off
    assert not made(ToArm()).may_take_off


def test_every_state_says_what_it_does() -> None:
    on_the_ground = (ToIdle(), ToArm(), ToConfigure(ConfigureOrder(HEIGHTS)), ToConfigure(FenceOrder(None)))
    for resting in on_the_ground:
        assert made(resting).detail(standing(0.05)).endswith(".")
    for transition in IN_THE_AIR:
        assert made(transition).detail(flying(0.05))


def test_a_mode_is_asked_for_again_after_two_seconds_and_not_while_an_answer_waits_or_nobody_hears() -> None:
    keeper = ModeKeeper(CopterMode.RTL)
    assert requests(keeper.reach(flying(10.0))) == [SetMode(CopterMode.RTL)]
    done = ("mode RTL", 10.0, "done")
    assert keeper.reach(answered(flying(10.0 + MODE_RETRY_S - 0.01), done)) == ()
    pending = answered(flying(10.0 + MODE_RETRY_S), ("mode RTL", 10.0, "pending"))
    fresh = ModeKeeper(CopterMode.RTL)
    fresh.reach(flying(10.0))
    assert fresh.reach(pending) == ()
    deaf = answered(flying(10.0 + MODE_RETRY_S), done)
    assert keeper.reach(replace(deaf, link=replace(deaf.link, is_up=False))) == ()
    assert requests(keeper.reach(deaf)) == [SetMode(CopterMode.RTL)]
    assert (keeper.attempts, keeper.refusals, keeper.is_reached) == (2, 0, False)


def test_a_refused_mode_is_counted_with_its_words_until_it_is_seen_and_never_asked_for_again() -> None:
    keeper = ModeKeeper(CopterMode.RTL)
    keeper.reach(flying(10.0))
    assert keeper.reach(answered(flying(10.1), ("mode RTL", 10.0, "failed"), words="EKF variance")) == ()
    assert (keeper.refusals, keeper.reason) == (1, "EKF variance")
    assert keeper.reach(flying(12.1, CopterMode.RTL)) == ()
    assert (keeper.is_reached, keeper.reason) == (True, "")
    assert keeper.reach(flying(60.0, CopterMode.LOITER)) == (), "somebody else changed it"


def test_anything_that_no_state_in_the_air_stands_for_is_adopted_as_the_ground() -> None:
    assert adopted(StateName.IDLE, flying(1.0)) == ToIdle()
    assert adopted(StateName.ARM, flying(1.0)) == ToArm(armed=True)


def test_a_move_without_any_position_is_reported_without_a_distance() -> None:
    facts = flying(1.0)
    lost = replace(facts, position=replace(facts.position, pose=None))
    assert make_state(ToMove(MOVE), lost, SETTINGS)[1] == ()
    assert texts(make_state(ToMove(MOVE), facts, SETTINGS)[1]) == ["Moving 40 m north."]


@pytest.mark.parametrize(
    ("north", "east", "words"), [(50.0, 0.0, "Moving 10 m south."), (40.0, 60.0, "Moving 60 m west.")]
)
def test_the_direction_of_a_move_is_that_from_the_drone(north: float, east: float, words: str) -> None:
    assert texts(make_state(ToMove(MOVE), at(flying(1.0), north, east), SETTINGS)[1]) == [words]


def said(transition: Transition, facts: Facts) -> list[tuple[str, str]]:
    return [(act.text, act.details) for act in make_state(transition, facts, SETTINGS)[1] if isinstance(act, Log)]


def test_what_begins_is_reported_with_who_or_what_began_it() -> None:
    facts = flying(1.0)
    outlined = replace(facts, limits=replace(facts.limits, outline=OutlineFacts(900.0, 0.0)))
    assert said(ToExplore(), facts) == [("Lot found. Exploring.", "")]
    assert said(ToExplore(), outlined) == [("Exploring the outline.", "")]
    assert said(ToReturn(), facts) == [("Returning home.", "")]
    assert said(ToLand(by="Ana"), facts) == [("Landing, asked by Ana.", "")]
    cause = Cause("The wind is too strong.", CauseKind.WIND, "gusts")
    assert said(ToReturn(cause), facts) == [("The wind is too strong. Returning home.", "")]
    assert said(ToLand(by_autopilot=True), facts) == [("The autopilot lands by itself.", "")]


WHO = "Another station asked for it, or the autopilot itself began it."


def asked_by_station(facts: Facts, subject: str, ago: float = 1.0) -> Facts:
    writes = (ForeignWrite(facts.now - ago, 255, 190, subject),)
    return replace(facts, link=replace(facts.link, foreign_writes=writes))


@pytest.mark.parametrize(
    ("name", "begun"), [(StateName.RETURN_TO_LAUNCH, "Returning home."), (StateName.LAND, "Landing.")]
)
@pytest.mark.parametrize("subject", ["mode", "mode 6"], ids=["an answer to it", "its command"])
def test_a_mode_that_a_station_asked_for_is_reported_with_the_station(
    name: StateName, begun: str, subject: str
) -> None:
    facts = asked_by_station(flying(9.0, CopterMode.RTL), subject)
    transition = adopted(name, facts)
    who = "Station 255 (component 190) asked for it."
    assert said(transition, facts) == [(f"{begun} {who}", "")]
    state = make_state(transition, facts, SETTINGS)[0]
    assert state.detail(facts) == f"{begun} {who}"
    assert state.hold_refusal(facts) == f"Not while this lasts: {who}"
    assert adopted(StateName.HOVER, facts) == ToHover(who, passive=True, level="warning")
    manual = adopted(StateName.MANUAL, facts)
    assert said(manual, facts) == [("Someone else flies, in RTL.", who)]


@pytest.mark.parametrize(("subject", "ago"), [("mode 9", 1.0), ("mode", 3.1), ("fence", 1.0)])
def test_a_station_that_asked_for_another_thing_or_long_ago_is_not_named(subject: str, ago: float) -> None:
    facts = asked_by_station(flying(9.0, CopterMode.RTL), subject, ago)
    assert said(adopted(StateName.RETURN_TO_LAUNCH, facts), facts) == [(f"Returning home. {WHO}", "")]


def test_a_failsafe_that_the_autopilot_reports_is_its_own() -> None:
    facts = flying(9.0, CopterMode.RTL)
    facts = replace(facts, link=replace(facts.link, words="GCS Failsafe"))
    transition = adopted(StateName.RETURN_TO_LAUNCH, facts)
    assert said(transition, facts) == [("The autopilot returns home by itself.", "GCS Failsafe")]
    state = make_state(transition, facts, SETTINGS)[0]
    assert state.hold_refusal(facts) == "The autopilot does this by itself. GCS Failsafe"


@pytest.mark.parametrize(("mode", "words"), [(CopterMode.LOITER, "LOITER"), (None, "an unknown mode")])
def test_a_mode_that_is_not_known_is_called_unknown(mode: CopterMode | None, words: str) -> None:
    facts = flying(1.0)
    facts = replace(facts, vehicle=replace(facts.vehicle, custom_mode=mode))
    assert texts(make_state(ToManual(), facts, SETTINGS)[1]) == [f"Someone else flies, in {words}."]
    assert made(ToManual()).detail(facts) == f"Someone else flies, in {words}."
    hold = adopted(StateName.HOVER, facts)
    assert hold == ToHover(WHO, passive=True, level="warning")
    warned = replace(facts, link=replace(facts.link, words="GPS Glitch"))
    by_itself = f"The autopilot went to {words} by itself."
    assert adopted(StateName.HOVER, warned) == ToHover(by_itself, passive=True, level="warning")


@pytest.mark.parametrize("name", [StateName.HOVER, StateName.COMMUNICATION_LOST])
def test_adopting_a_hold_sends_nothing(name: StateName) -> None:
    assert made(adopted(name, flying(0.0))).process(flying(0.05)) == ()
