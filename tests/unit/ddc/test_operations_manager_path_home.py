"""RTL ends where we think it does: rally points and RTL_* before and during a return."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from hawk.comm.protocol.commands import CompulsiveMove, ReturnToLaunch
from hawk.ddc.facts import Facts, KeptFacts
from hawk.ddc.orders import Cause, CauseKind, ToHover, ToLand, ToReturn
from hawk.ddc.states.base import returning
from hawk.model.operation import StateName
from hawk.model.vehicle import CopterMode
from tests.examples import nightly
from tests.unit.ddc.by_facts import made, requests, texts
from tests.unit.ddc.fakes import Rig
from tests.unit.ddc.written_facts import flying as facts_at

S = StateName
RALLY = "Autopilot's return: to a rally point where one is nearer (RALLY_TOTAL 1)."
OWN = Cause("", CauseKind.ALWAYS, "Battery failsafe")


async def away(rig: Rig, north: float = 60.0) -> None:
    rig.order(CompulsiveMove(x=north, y=0.0))
    await rig.until(S.HOVER)


def from_home(rig: Rig) -> float:
    return math.hypot(rig.autopilot.north, rig.autopilot.east)


@pytest.mark.slow
@pytest.mark.fault("a rally point is set in flight, the operator returns", "cleared before RTL is asked for")
async def test_a_rally_point_is_cleared_before_the_return_begins(flying: Rig) -> None:
    await away(flying)
    flying.autopilot.report("RALLY_TOTAL", 1)
    flying.order(ReturnToLaunch())
    await flying.run(1)
    assert flying.autopilot.values["RALLY_TOTAL"] == 0
    assert flying.autopilot.mode == CopterMode.RTL


@pytest.mark.slow
@pytest.mark.fault(
    "a rally point, RTL_ALT 300 m or RTL_ALT_FINAL 10 m that cannot be put back",
    "within 3 s led home by targets, Land there",
)
@pytest.mark.parametrize(
    ("name", "value"), [("RALLY_TOTAL", 1), *nightly(("RTL_ALT", 30_000), ("RTL_ALT_FINAL", 1000))]
)
async def test_where_the_return_cannot_be_put_right_the_drone_is_led_home_and_lands_there(
    flying: Rig, name: str, value: float
) -> None:
    await away(flying)
    flying.autopilot.refuse |= {"clear_rally_points": "no", "set_parameter": "no"}
    flying.autopilot.report(name, value)
    flying.order(ReturnToLaunch())
    await flying.run(2)
    assert flying.detail == "Returning home: the autopilot's return is put right first."
    await flying.run(2)
    assert flying.autopilot.mode == CopterMode.GUIDED
    assert "The autopilot's return would not end at home: leading it there." in flying.log
    await flying.until(S.LAND, 60)
    assert from_home(flying) < 3.0
    assert any(text.startswith("Above home.") for text in flying.log)
    await flying.until(S.IDLE, 90)
    assert CopterMode.RTL not in flying.autopilot.asked("set_mode")


@pytest.mark.slow
async def test_led_home_it_returns_by_rtl_as_soon_as_the_return_is_right(flying: Rig) -> None:
    await away(flying, 90.0)
    flying.autopilot.refuse["clear_rally_points"] = "no"
    flying.autopilot.report("RALLY_TOTAL", 1)
    flying.order(ReturnToLaunch())
    await flying.run(4)
    assert flying.autopilot.mode == CopterMode.GUIDED
    flying.autopilot.report("RALLY_TOTAL", 0)
    await flying.run(1)
    assert flying.autopilot.mode == CopterMode.RTL
    await flying.until(S.IDLE, 90)


@pytest.mark.slow
@pytest.mark.fault(
    "the autopilot's own failsafe begins RTL to a rally point",
    "cleared, BRAKE, RTL again; led home where it cannot be cleared",
)
async def test_an_rtl_of_the_autopilot_to_a_rally_point_begins_again_once_it_is_cleared(flying: Rig) -> None:
    await away(flying)
    flying.autopilot.report("RALLY_TOTAL", 1)
    flying.autopilot.change_mode(CopterMode.RTL)
    await flying.run(2)
    flying.expect(S.RETURN_TO_LAUNCH)
    assert flying.autopilot.asked("set_mode")[-2:] == [CopterMode.BRAKE, CopterMode.RTL]
    assert "The autopilot's return is right again: it begins again." in flying.log


@pytest.mark.fault(
    "the autopilot's own failsafe begins RTL within 3 s after a rally point was cleared",
    "BRAKE, RTL again: it may fly there still",
)
async def test_one_that_began_just_after_it_was_cleared_is_not_trusted_either(flying: Rig) -> None:
    await away(flying)
    flying.autopilot.report("RALLY_TOTAL", 1)
    await flying.run(0.3)
    assert flying.autopilot.values["RALLY_TOTAL"] == 0
    flying.autopilot.change_mode(CopterMode.RTL)
    await flying.run(2)
    assert flying.autopilot.asked("set_mode")[-2:] == [CopterMode.BRAKE, CopterMode.RTL]


@pytest.mark.slow
@pytest.mark.fault("the autopilot's own failsafe begins RTL to a rally point")
async def test_an_rtl_of_the_autopilot_to_a_rally_point_that_stays_is_led_home(flying: Rig) -> None:
    await away(flying)
    flying.autopilot.refuse["clear_rally_points"] = "no"
    flying.autopilot.report("RALLY_TOTAL", 1)
    flying.autopilot.change_mode(CopterMode.RTL)
    await flying.run(4)
    assert flying.autopilot.mode == CopterMode.GUIDED
    await flying.until(S.LAND, 60)
    assert from_home(flying) < 3.0


@pytest.mark.nightly
async def test_rally_points_during_rtl_are_cleared_and_rtl_goes_on(flying: Rig) -> None:
    await away(flying, 90.0)
    flying.order(ReturnToLaunch())
    await flying.run(5)
    flying.autopilot.report("RALLY_TOTAL", 1)
    await flying.run(2)
    assert flying.autopilot.values["RALLY_TOTAL"] == 0
    assert flying.autopilot.asked("set_mode").count(CopterMode.RTL) == 1
    await flying.until(S.IDLE, 90)


# -- by facts ---------------------------------------------------------------------------------------------------------


def astray(facts: Facts, words: str = RALLY) -> Facts:
    return replace(facts, kept=KeptFacts(astray=words, astray_ago=0.0))


@pytest.mark.fault("home cannot be set back, and the drone cannot be led (no position, no charge)")
def test_where_it_cannot_be_led_the_operators_return_holds_and_any_other_lands() -> None:
    for cause, following in ((None, ToHover), (Cause("The wind is too strong.", CauseKind.WIND), ToLand)):
        state = made(ToReturn(cause))
        assert state.process(astray(facts_at(2.99))) == ()
        assert texts(state.process(astray(facts_at(3.0)))) == ["It cannot be led home: the charge is not known."]
        transition = state.transition_next_state(astray(facts_at(3.0))).transition
        assert isinstance(transition, following)
        words = transition.reason if isinstance(transition, ToHover) else transition.cause and transition.cause.text
        assert RALLY in str(words)


def test_a_return_that_the_program_must_not_lead_lands() -> None:
    state = made(ToReturn(Cause("The program stopped twice in a minute.", CauseKind.NEVER), straight="it may stop"))
    assert state.process(astray(facts_at(3.0))) == ()
    assert isinstance(state.transition_next_state(astray(facts_at(3.0))).transition, ToLand)


def test_the_autopilots_own_return_that_is_long_under_way_is_left_alone() -> None:
    state = made(ToReturn(OWN, by_autopilot=True))
    long_ago = replace(facts_at(1.0, CopterMode.RTL), kept=KeptFacts(astray_ago=3.01))
    assert state.process(long_ago) == ()
    lately = replace(facts_at(1.0, CopterMode.RTL), kept=KeptFacts(astray_ago=3.0))
    assert requests(made(ToReturn(OWN, by_autopilot=True)).process(lately))[-1:]


@pytest.mark.fault("the program ends in the air while RTL would not end at home", "Land")
def test_a_return_that_cannot_wait_lands_where_rtl_would_not_end_at_home() -> None:
    cause = Cause("The program ends.", CauseKind.ALWAYS)
    landing = returning(astray(facts_at(1.0)), cause)
    assert isinstance(landing, ToLand)
    assert landing.cause is not None
    assert landing.cause.text == f"The program ends. {RALLY}"
    assert isinstance(returning(facts_at(1.0), cause), ToReturn)
