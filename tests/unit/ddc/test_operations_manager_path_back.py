"""A drone outside the fence, however far, is led straight back: each target passes the gate."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from hawk.ddc.acts import SendTarget
from hawk.ddc.facts import Facts
from hawk.ddc.fence.geometry import FenceError, circle, contains, inside_point, outside_by, polygon_fence
from hawk.ddc.motion import Goal, maximum_target_distance
from hawk.ddc.requests.service_interface import Limits, target_refusal
from hawk.ddc.states.hover import Holding
from hawk.model.plans import Fence, HeightParameters
from hawk.model.poses import MapPoint, MapPose, VehiclePose
from tests.examples import examples
from tests.unit.ddc.written_facts import FENCE, SETTINGS, flying, pose

SPEED = SETTINGS.flight.speed_m_s
HEIGHTS = HeightParameters()
TICK_S = 0.4
U_SHAPE = polygon_fence(
    ((-20, -40), (90, -40), (90, -16), (30, -16), (30, 16), (90, 16), (90, 40), (-20, 40)), 2, 100, 3
)


def place(north: float, east: float, height: float) -> MapPose:
    return MapPose(north, east, height, 0.0, 0.0, 0.0)


def outside(fence: Fence, at: MapPose, now: float, fence_on: bool | None) -> Facts:
    beyond = outside_by(fence, at.point) > 0.0 or at.height > fence.ceiling
    facts = flying(now)
    here: VehiclePose = pose(now, at.north, at.east, at.height)
    return replace(
        facts,
        position=replace(facts.position, pose=here),
        limits=replace(facts.limits, fence=fence, breached_s=0.1 if beyond else None),
        diagnostics=replace(facts.diagnostics, fence_on=fence_on),
    )


def moved(at: MapPose, target: Goal, wind: tuple[float, float]) -> MapPose:
    """Fly a tick towards the target, faster than the carrot, while the wind shifts the drone."""
    away = math.hypot(target.north - at.north, target.east - at.east)
    share = min(1.0, 1.25 * SPEED * TICK_S / away) if away > 0 else 1.0
    rise = max(-2.0 * TICK_S, min(2.0 * TICK_S, target.height - at.height))
    north = at.north + (target.north - at.north) * share + wind[0] * TICK_S
    east = at.east + (target.east - at.east) * share + wind[1] * TICK_S
    return place(north, east, at.height + rise)


def fly_back(
    fence: Fence, start: MapPose, fence_on: bool | None = None, wind: tuple[float, float] = (0.0, 0.0)
) -> list[tuple[MapPose, Goal]]:
    """Lead a drone back; each target must pass the gate. Returns every place with its target."""
    holding, limits = Holding(SETTINGS), Limits(fence, HEIGHTS, SPEED, holds=True)
    at, now = start, 100.0
    flown: list[tuple[MapPose, Goal]] = []
    for _ in range(600):
        facts = outside(fence, at, now, fence_on)
        if not facts.is_breached:
            return flown
        sent = [act.goal for act in holding.process(facts) if isinstance(act, SendTarget)]
        assert len(sent) == 1, "a drone outside gets a target every tick"
        refusal = target_refusal(sent[0], at, limits)
        assert not refusal, f"{refusal} at {at}"
        flown.append((at, sent[0]))
        at, now = moved(at, sent[0], wind), now + TICK_S
    raise AssertionError(f"still outside at {at}")


@st.composite
def fences(draw: st.DrawFn) -> Fence:
    """Star-shaped polygons, mostly concave."""
    radii = draw(st.lists(st.floats(25.0, 200.0), min_size=4, max_size=12))
    angles = [2 * math.pi * index / len(radii) for index in range(len(radii))]
    ring = [(r * math.cos(a), r * math.sin(a)) for r, a in zip(radii, angles, strict=True)]
    try:
        return polygon_fence(ring, 5.0, 100.0, 3.0)
    except FenceError:
        assume(False)
        raise


@pytest.mark.fault(
    "drone up to 300 m outside any fence",
    "a target every tick, never farther out, back inside by the shortest line",
)
@pytest.mark.slow
@settings(max_examples=examples(100))
@given(fences(), st.floats(0, 2 * math.pi), st.floats(0.6, 300.0), st.floats(16.0, 130.0), st.booleans())
def test_from_anywhere_outside_successive_targets_lead_inside(
    fence: Fence, angle: float, away: float, height: float, fence_on: bool
) -> None:
    start = place(math.cos(angle) * 210.0, math.sin(angle) * 210.0, height)
    edge = inside_point(fence, start.point, 0.0)
    far = MapPoint(edge.north + math.cos(angle) * away, edge.east + math.sin(angle) * away)
    assume(0.5 < outside_by(fence, far) <= 300.0)
    flown = fly_back(fence, place(far.north, far.east, height), fence_on)
    distances = [outside_by(fence, at.point) for at, _ in flown]
    assert all(later <= before + 1e-6 for before, later in pairwise(distances))
    for at, target in flown:
        assert outside_by(fence, target.point) <= outside_by(fence, at.point) + 1e-9


@pytest.mark.parametrize("away", [18.0, 60.0, 300.0])
def test_the_path_back_is_the_shortest(away: float) -> None:
    flown = fly_back(FENCE, place(0.0, 145.0 + away, 30.0))
    length = sum(one.point.distance(other.point) for (one, _), (other, _) in pairwise(flown))
    assert length <= away + 3.0


def test_each_step_is_within_reach_while_the_autopilots_fence_is_off() -> None:
    for at, target in fly_back(FENCE, place(0.0, 345.0, 30.0), fence_on=False):
        assert at.point.distance(target.point) <= maximum_target_distance(SPEED)


@pytest.mark.fault(
    "outside the autopilot's own fence, which takes no target out there",
    "the nearest place inside is sent, however far",
)
def test_outside_the_autopilots_fence_that_is_on_every_target_lies_inside() -> None:
    """ArduPilot takes no target outside its own fence, and stands where it is."""
    flown = fly_back(FENCE, place(0.0, 245.0, 30.0), fence_on=True)
    for at, target in flown:
        if outside_by(FENCE, at.point) > 5.5:
            assert contains(FENCE, target.point)


def test_wind_that_carries_it_along_the_fence_changes_the_place_that_it_is_led_to() -> None:
    holding, square = Holding(SETTINGS), polygon_fence(((-90, -90), (90, -90), (90, 90), (-90, 90)), 5, 100, 3)
    for north, led_to in ((0.0, 0.0), (0.9, 0.0), (60.0, 60.0)):
        acts = holding.process(outside(square, place(north, 200.0, 30.0), 100.0 + north, fence_on=True))
        (target,) = [act.goal for act in acts if isinstance(act, SendTarget)]
        assert (target.north, target.east) == pytest.approx((led_to, 83.0), abs=0.1)
    assert fly_back(FENCE, place(0.0, 245.0, 30.0), wind=(3.0, 0.0))


@pytest.mark.fault("40 m above the ceiling", "straight down, a target every tick")
def test_far_above_the_ceiling_it_descends_straight() -> None:
    flown = fly_back(FENCE, place(10.0, 0.0, 140.0))
    assert all(at.point.distance(MapPoint(10.0, 0.0)) <= 2.0 for at, _ in flown)
    heights = [at.height for at, _ in flown]
    assert heights == sorted(heights, reverse=True)


# -- the gate ---------------------------------------------------------------------------------------------------------

AT = place(0.0, 195.0, 30.0)
"""50 m outside."""


@pytest.mark.parametrize(
    ("east", "holds", "words"),
    [
        (190.0, True, ""),
        (195.0, True, ""),
        (195.1, True, "outside the fence"),
        (190.0, False, "outside the fence"),
        (170.0, True, "25.0 m away"),
        (143.0, True, ""),
        (143.0, False, "52.0 m away"),
        (140.0, True, "55.0 m away"),
    ],
)
def test_a_step_back_may_lie_outside_but_never_farther_out(east: float, holds: bool, words: str) -> None:
    found = target_refusal(Goal(0.0, east, 30.0, 0.0), AT, Limits(FENCE, HEIGHTS, SPEED, holds))
    assert words in found
    assert bool(words) is bool(found)


@pytest.mark.parametrize(
    ("height", "aside", "holds", "words"),
    [
        (139.0, 0.0, True, ""),
        (140.5, 0.0, True, "ceiling"),
        (139.0, 3.0, True, "ceiling"),
        (139.0, 0.0, False, "ceiling"),
        (120.0, 0.0, True, "20.0 m away"),
    ],
)
def test_above_the_ceiling_only_straight_down(height: float, aside: float, holds: bool, words: str) -> None:
    high = place(0.0, 0.0, 140.0)
    found = target_refusal(Goal(0.0, aside, height, 0.0), high, Limits(FENCE, HEIGHTS, SPEED, holds))
    assert words in found
    assert bool(words) is bool(found)


def test_between_two_arms_it_goes_into_the_nearer_one() -> None:
    flown = fly_back(U_SHAPE, place(85.0, 3.0, 30.0))
    assert flown[-1][0].east > 3.0


def test_a_small_fence_is_found_again_from_far() -> None:
    small = polygon_fence(circle(MapPoint(0.0, 0.0), 12.0), 5.0, 100.0, 3.0)
    assert fly_back(small, place(-200.0, 210.0, 30.0))
