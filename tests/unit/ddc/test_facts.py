"""Facts about themselves: ages at their limits, and what is absent is never passed off as known."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest

from hawk.comm.autopilot.terrain import Terrain
from hawk.ddc.battery.battery import BATTERY_UNKNOWN_S, RESERVE_CONFIRM_S, BatteryFacts
from hawk.ddc.facts import Answer, Facts, KeptFacts
from hawk.ddc.readings.belief import GroundFacts
from hawk.ddc.readings.clearance import BelowFacts
from hawk.ddc.readings.home import HOME_TOLERANCE_M, HomeFacts
from hawk.ddc.readings.limits import LimitFacts
from hawk.ddc.readings.link import LinkFacts
from hawk.ddc.readings.position import POSITION_CONFIRM_S, PositionFacts
from hawk.ddc.readings.sight import FAULT_CONFIRM_S, SightFacts
from hawk.ddc.readings.topic_interface import POSE_TIMEOUT_S, TARGET_POSE_AGE_S, VERDICT_AGE_S
from hawk.ddc.readings.wind import WindFacts
from hawk.model.operation import Health
from hawk.model.plans import Inbound, Route, Verdict
from hawk.model.poses import MapPoint, MapPose
from hawk.model.vehicle import CopterMode, LandedState
from tests.unit.ddc.written_facts import DATUM, FENCE, flying, on_ground, pose

NOW = 50.0
PATH = Route((MapPoint(0.0, 0.0), MapPoint(5.0, 0.0)), (0.0, 0.0))


def aged(age: float) -> Facts:
    facts = flying(NOW)
    return replace(facts, position=replace(facts.position, age=age))


def of_vehicle(**changes: Any) -> Facts:
    facts = flying(NOW)
    return replace(facts, vehicle=replace(facts.vehicle, **changes))


def home(**changes: Any) -> Facts:
    facts = flying(NOW)
    return replace(facts, position=replace(facts.position, autopilot_home=HomeFacts(**changes)))


def test_the_limits_of_time_and_place() -> None:
    """Seconds, and metres for home: the specification's and the safety page's figures."""
    assert (TARGET_POSE_AGE_S, POSE_TIMEOUT_S, POSITION_CONFIRM_S) == (0.5, 1.0, 2.0)
    assert (BATTERY_UNKNOWN_S, FAULT_CONFIRM_S, RESERVE_CONFIRM_S) == (30.0, 1.0, 3.0)
    assert (VERDICT_AGE_S, HOME_TOLERANCE_M) == (1.0, 3.0)


def test_before_anything_was_heard_nothing_is_known() -> None:
    facts = Facts(NOW)
    assert not facts.is_airborne
    assert not facts.is_on_ground
    assert not facts.is_unheard
    assert not facts.is_guided
    assert not facts.is_astray
    assert not facts.is_breached
    assert not facts.limits.breached_s
    assert (facts.pose, facts.place, facts.last_place, facts.global_place, facts.height) == (None,) * 5
    assert facts.height_over_ground is None
    assert facts.health("link") == Health.bad("not known")
    assert facts.ceiling(on_ground=False) == 0.0
    assert facts.utc == 0.0
    assert facts == Facts(
        NOW,
        ground=GroundFacts(False, LandedState.UNDEFINED, math.inf, "", 0.0),
        link=LinkFacts(is_up=False, age=math.inf, mode_changed_at=-math.inf),
        position=PositionFacts(age=math.inf, distrusted_s=0.0, jump_m=0.0, estimate_jump_m=0.0),
        battery=BatteryFacts(age=math.inf, unknown_s=0.0),
        wind=WindFacts(None, None),
        limits=LimitFacts(planned_ceiling=0.0),
        sight=SightFacts(plan_time=-math.inf, desired_count=0, fault_s=0.0, lot_area=0.0),
        kept=KeptFacts("", "", math.inf, ()),
    )
    assert HomeFacts(age=math.inf, is_inside=False) == HomeFacts()
    assert LimitFacts().plan.ceiling == 0.0


@pytest.mark.parametrize(
    ("answer", "outcome"),
    [
        (Answer("arm", 1.0, "pending"), (True, False, False)),
        (Answer("arm", 1.0, "done"), (False, True, False)),
        (Answer("arm", 1.0, "failed"), (False, False, True)),
    ],
)
def test_an_answer_is_pending_done_or_failed(answer: Answer, outcome: tuple[bool, bool, bool]) -> None:
    assert (answer.is_pending, answer.is_done, answer.has_failed) == outcome


class TestAnswer:
    def test_it_is_that_of_the_name_and_the_time(self) -> None:
        one, two = Answer("arm", 1.0, "done"), Answer("arm", 2.0, "failed", "no")
        facts = replace(flying(NOW), answers=(one, two, Answer("kill", 3.0, "done")))
        assert facts.answer("arm", 1.0) is one
        assert facts.answer("arm", 2.0) is two

    def test_one_that_is_not_known_any_more_has_failed(self) -> None:
        facts = flying(NOW)
        assert facts.answer("arm", NOW).is_pending, "asked at this very moment"
        assert facts.answer("arm", NOW - 0.05) == Answer("arm", NOW - 0.05, "failed", "no answer")


class TestVehicle:
    @pytest.mark.parametrize(
        ("armed", "landed", "airborne"),
        [
            (True, LandedState.IN_AIR, True),
            (True, LandedState.UNDEFINED, True),
            (True, LandedState.LANDING, True),
            (True, LandedState.ON_GROUND, False),
            (False, LandedState.IN_AIR, False),
        ],
    )
    def test_in_the_air(self, armed: bool, landed: LandedState, airborne: bool) -> None:
        facts = of_vehicle(armed=armed, landed=landed)
        assert facts.is_airborne is airborne
        assert facts.is_on_ground is (landed is LandedState.ON_GROUND)

    def test_unheard_is_armed_without_a_link(self) -> None:
        facts = flying(NOW)
        silent = replace(facts, link=replace(facts.link, is_up=False))
        assert silent.is_unheard
        assert not facts.is_unheard
        assert not on_ground(silent).is_unheard

    def test_guided(self) -> None:
        assert flying(NOW).is_guided
        assert not of_vehicle(custom_mode=int(CopterMode.LOITER)).is_guided


class TestPose:
    @pytest.mark.parametrize(("age", "young", "height"), [(0.5, True, 30.0), (0.51, False, 30.0), (1.0, False, 30.0)])
    def test_a_young_one_is_taken(self, age: float, young: bool, height: float) -> None:
        facts = aged(age)
        assert (facts.pose is not None, facts.place is not None, facts.height) == (young, young, height)
        assert facts.last_place is not None
        assert facts.global_place == DATUM

    def test_the_height_of_an_old_one_is_not_known(self) -> None:
        assert aged(1.01).height is None

    def test_one_that_is_not_whole(self) -> None:
        facts = flying(NOW)
        for place in (None, MapPose(math.nan, 0.0, 30.0, 0.0, 0.0, 0.0)):
            broken = replace(pose(NOW), map=place)
            assert replace(facts, position=replace(facts.position, pose=broken)).pose is None

    def test_the_height_over_ground_needs_both(self) -> None:
        facts = flying(NOW)
        below = BelowFacts(terrain=Terrain(NOW, distance=26.0, ground=4.0, most=50.0))
        over = replace(facts, position=replace(facts.position, below=below))
        assert over.height_over_ground == 26.0
        assert facts.height_over_ground is None
        assert replace(over, position=replace(over.position, age=1.1)).height_over_ground is None


class TestHome:
    def test_it_is_moved_beyond_three_metres(self) -> None:
        assert [home(away=away).is_astray for away in (None, 3.0, 3.1)] == [False, False, True]
        assert not home(away=None, moved_s=1.0).is_astray

    def test_it_misleads_outside_the_fence(self) -> None:
        assert home(away=9.0).position.autopilot_home.misleads
        assert not home(away=9.0, is_inside=True).position.autopilot_home.misleads
        assert not home(away=1.0).position.autopilot_home.misleads

    def test_the_keeper_may_find_that_a_return_ends_elsewhere(self) -> None:
        assert replace(flying(NOW), kept=KeptFacts(astray="RTL_ALT_TYPE 1")).is_astray
        assert not flying(NOW).is_astray


class TestLimits:
    def test_the_ceiling_in_force_counts_in_the_air(self) -> None:
        facts = flying(NOW)
        planned = replace(facts, limits=replace(facts.limits, planned_ceiling=50.0))
        assert planned.ceiling(on_ground=False) == FENCE.ceiling
        assert planned.ceiling(on_ground=True) == 50.0
        assert replace(planned, limits=replace(planned.limits, fence=None)).ceiling(on_ground=False) == 50.0

    def test_a_breach_counts_from_its_first_moment(self) -> None:
        facts = flying(NOW)
        assert not facts.is_breached
        assert replace(facts, limits=replace(facts.limits, breached_s=0.0)).is_breached

    def test_the_health_of_a_part(self) -> None:
        facts = replace(flying(NOW), parts=(("link", Health()), ("camera", Health.bad("dark"))))
        assert facts.health("link").is_healthy
        assert facts.health("camera").reason == "dark"
        assert facts.health("loop") == Health.bad("not known")


class TestVerdict:
    def judged(self, verdict: Verdict | None) -> Facts:
        facts = flying(NOW)
        return replace(facts, sight=replace(facts.sight, verdict=verdict))

    @pytest.mark.parametrize(
        ("verdict", "known", "inside"),
        [
            (Verdict(7, Inbound.INSIDE, PATH), True, True),
            (Verdict(7, Inbound.INSIDE, Route(refused="too narrow")), True, False),
            (Verdict(7, Inbound.OUTSIDE), True, False),
            (Verdict(6, Inbound.INSIDE, PATH), False, False),
            (None, False, False),
        ],
    )
    def test_only_the_one_on_the_number_counts(self, verdict: Verdict | None, known: bool, inside: bool) -> None:
        facts = self.judged(verdict)
        assert (facts.verdict(7) is not None) is known
        assert facts.is_confirmed_inside(7) is inside


def test_a_loss_is_put_into_words_and_none_into_none() -> None:
    assert KeptFacts().lost_words == ""
    assert KeptFacts(lost="its home").lost_words == (
        "Somebody changes the autopilot, and it cannot be put back: its home."
    )
