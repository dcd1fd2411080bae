"""Return To Launch and Land by facts alone: refusals, a moved home, and a return that starts over."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hawk.comm.protocol.commands import Disarm
from hawk.ddc.acts import (
    STAY,
    Log,
    SetArmed,
    SetMode,
)
from hawk.ddc.facts import Facts
from hawk.ddc.orders import (
    Cause,
    CauseKind,
    ToHover,
    ToLand,
    ToReturn,
)
from hawk.ddc.readings.home import HomeFacts
from hawk.model.vehicle import CopterMode, LandedState
from tests.unit.ddc.by_facts import (
    answered,
    made,
    requests,
    texts,
    without_operator,
)
from tests.unit.ddc.written_facts import flying


def test_a_refused_disarm_in_land_is_reported_once() -> None:
    state = made(ToLand())
    landed = replace(
        flying(5.0, CopterMode.LAND), vehicle=replace(flying(5.0).vehicle, landed=LandedState.ON_GROUND, custom_mode=9)
    )
    assert requests(state.transition_next_state(landed, Disarm()).acts) == [SetArmed(False)]
    refused = answered(replace(landed, now=5.1), ("disarm", 5.0, "failed"), words="not landed")
    assert state.process(refused) == (Log("error", "Disarm was refused.", "not landed"),)
    assert state.process(replace(refused, now=5.2)) == ()


def test_hold_is_refused_while_the_cause_lasts_and_when_the_autopilot_returns_by_itself() -> None:
    cause = Cause("The operator is lost.", CauseKind.OPERATOR)
    assert made(ToReturn(cause)).hold_refusal(flying(1.0)) == ""
    assert "The operator is lost." in made(ToReturn(cause)).hold_refusal(without_operator(flying(1.0)))
    own = Cause("", CauseKind.ALWAYS, "Battery failsafe")
    assert made(ToReturn(own, by_autopilot=True)).hold_refusal(flying(1.0)).endswith("Battery failsafe")


def home_at(facts: Facts, away: float, moved_s: float | None, inside: bool = True) -> Facts:
    home = HomeFacts(facts.position.datum, 0.1, away, moved_s, is_inside=inside)
    return replace(facts, position=replace(facts.position, autopilot_home=home))


def test_a_return_that_began_with_home_in_its_place_goes_on_when_home_is_moved_and_set_back() -> None:
    state = made(ToReturn())
    state.process(flying(0.05))
    for now, away in ((1.0, 0.0), (1.05, 60.0), (1.1, 60.0), (1.15, 0.0), (1.2, 0.0)):
        moved = None if away == 0.0 and now < 1.1 else 0.1
        assert state.process(home_at(flying(now, CopterMode.RTL), away, moved)) == ()


def test_a_return_that_began_with_a_moved_home_begins_again_when_home_is_back() -> None:
    state = made(ToReturn(Cause("", CauseKind.ALWAYS), by_autopilot=True))
    assert state.process(home_at(flying(1.0, CopterMode.RTL), 60.0, 0.5)) == ()
    acts = state.process(home_at(flying(2.0, CopterMode.RTL), 0.0, 1.5))
    assert texts(acts) == ["The autopilot's return is right again: it begins again."]
    assert requests(acts) == [SetMode(CopterMode.BRAKE)]
    assert "set back first" in state.detail(flying(2.0))
    state.process(home_at(flying(2.5, CopterMode.BRAKE), 0.0, 2.0))
    again = state.process(home_at(flying(2.55, CopterMode.BRAKE), 0.0, 2.05))
    assert requests(again) == [SetMode(CopterMode.RTL)]


def test_our_own_return_that_began_with_a_moved_home_begins_again_too() -> None:
    state = made(ToReturn())
    state.process(home_at(flying(1.0, CopterMode.RTL), 60.0, 0.5))
    acts = state.process(home_at(flying(2.0, CopterMode.RTL), 0.0, 1.5))
    assert texts(acts) == ["The autopilot's return is right again: it begins again."]


def test_a_return_waits_three_seconds_for_a_moved_home_and_then_flies_to_it_inside_the_fence() -> None:
    state = made(ToReturn())
    assert state.process(home_at(flying(0.05), 60.0, 0.05)) == ()
    assert "set back first" in state.detail(home_at(flying(0.05), 60.0, 0.05))
    assert state.process(home_at(flying(2.99), 60.0, 2.99)) == ()
    assert texts(state.process(home_at(flying(3.0), 60.0, 3.0))) == ["It cannot be led home: the charge is not known."]
    assert requests(state.process(home_at(flying(3.05), 60.0, 3.05))) == [SetMode(CopterMode.RTL)]


@pytest.mark.parametrize(
    ("cause", "following"),
    [(None, ToHover), (Cause("The wind is too strong.", CauseKind.WIND), ToLand)],
    ids=["asked for", "by itself"],
)
def test_a_return_to_a_home_that_stays_outside_holds_or_lands(cause: Cause | None, following: type) -> None:
    state = made(ToReturn(cause))
    early = home_at(flying(2.99), 300.0, 2.99, inside=False)
    assert state.process(early) == ()
    assert state.transition_next_state(early) == STAY
    late = home_at(flying(3.0), 300.0, 3.0, inside=False)
    assert texts(state.process(late)) == ["It cannot be led home: the charge is not known."]
    assert isinstance(state.transition_next_state(late).transition, following)


def test_a_return_that_starts_over_reports_no_refusal_that_there_was_not() -> None:
    state = made(ToReturn())
    state.process(flying(0.05))
    state.restart()
    acts = state.process(flying(5.0))
    assert texts(acts) == []
    assert requests(acts) == [SetMode(CopterMode.RTL)]
    refused = state.process(answered(flying(5.1), ("mode RTL", 5.0, "failed"), words="EKF variance"))
    assert refused == (Log("error", "Returning home was refused. Trying again.", "EKF variance"),)
    assert "EKF variance" in state.detail(flying(5.1))
