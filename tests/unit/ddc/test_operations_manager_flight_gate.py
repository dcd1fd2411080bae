"""The flight gate: no Takeoff, Explore, Move or Resume without valid failsafes and our fence in the autopilot."""

from __future__ import annotations

from collections.abc import AsyncIterator
from dataclasses import replace
from pathlib import Path

import pytest

from hawk.comm.protocol.commands import (
    Arm,
    AutonomousExplore,
    AutonomousMove,
    Command,
    CompulsiveMove,
    Hold,
    Land,
    Resume,
    ReturnToLaunch,
    Takeoff,
)
from hawk.ddc.acts import Ask, CompareFence, Log, PutFenceInForce, UploadFence
from hawk.ddc.facts import Answer, Facts
from hawk.ddc.fence.plan import FencePlan
from hawk.ddc.keeper.fence import RETRY_S, KeptFence
from hawk.ddc.states.hover import HoverState, ManualState
from hawk.model.operation import StateName
from hawk.model.poses import ArmPlace
from hawk.model.vehicle import CopterMode, LandedState
from tests.unit.ddc.fakes import DEFAULT_PARAMETERS, SAFE_PARAMETERS, Rig
from tests.unit.ddc.written_facts import DATUM, FENCE, SETTINGS, flying, on_ground, pose

S = StateName
LOST_S = 2.9
"""The link is lost, and the drone is not sent home yet, seconds."""
TASKS: list[Command] = [
    AutonomousExplore(),
    AutonomousMove(x=20.0, y=0.0),
    CompulsiveMove(x=20.0, y=0.0),
]
EXITS: list[Command] = [Hold(), ReturnToLaunch(), Land()]


def by_somebody_else(rig: Rig) -> None:
    """Another station arms the drone on the ground, in GUIDED."""
    rig.autopilot.change_mode(CopterMode.GUIDED)
    rig.autopilot.armed = True
    rig.autopilot._project_arm_place()


@pytest.fixture
async def unsafe(tmp_path: Path) -> AsyncIterator[Rig]:
    """A drone as it comes from the shop, on the ground, looked at."""
    rig = Rig(tmp_path, parameters=DEFAULT_PARAMETERS)
    await rig.run(2)
    yield rig
    await rig.close()


def possible(rig: Rig, command: str) -> bool:
    return next(option.possible for option in rig.manager.options() if option.command == command)


# -- armed by another station -----------------------------------------------------------------------------------------


@pytest.mark.fault("armed by another station, failsafes off", "Takeoff is refused with the failsafe and its remedy")
async def test_armed_by_another_station_without_failsafes_it_does_not_take_off(unsafe: Rig) -> None:
    by_somebody_else(unsafe)
    await unsafe.run(2)
    unsafe.expect(S.ARM)
    refused = unsafe.command(Takeoff())
    assert not refused.accepted
    assert refused.reason == "Ground-station failsafe: off (FS_GCS_ENABLE 0). Disarm, then Set failsafes."
    assert not possible(unsafe, "Takeoff")
    assert unsafe.autopilot.count("takeoff") == 0


@pytest.mark.slow
@pytest.mark.fault(
    "armed by another station, no fence in the autopilot",
    "fence compared, uploaded and read back (0.4 + 0.6 s on the real one), then Takeoff is accepted",
)
async def test_armed_by_another_station_it_takes_off_once_the_fence_is_up_and_read_back(rig: Rig) -> None:
    rig.autopilot.silent.add("compare_fence")
    by_somebody_else(rig)
    await rig.run(1)
    rig.expect(S.ARM)
    assert rig.command(Takeoff()).reason == "The fence of this flight is being set: wait a moment."
    rig.autopilot.silent.clear()
    rig.autopilot.armed = False
    await rig.run(0.5)
    by_somebody_else(rig)
    await rig.run(0.5)
    assert rig.autopilot.held_fence == rig.fence
    rig.order(Takeoff())
    await rig.until(S.HOVER)


@pytest.mark.slow
@pytest.mark.fault(
    "the autopilot refuses the fence",
    "no task; reported once, tried again every 5 s; Hold, RTL, Land open",
)
async def test_a_fence_that_is_not_taken_keeps_it_on_the_ground_and_is_tried_again(rig: Rig) -> None:
    rig.autopilot.refuse["upload_fence"] = "no space"
    by_somebody_else(rig)
    await rig.run(1)
    assert rig.command(Takeoff()).reason == "The fence of this flight was not taken by the autopilot. no space."
    assert rig.log.count("The fence of this flight was not taken by the autopilot.") == 1
    rig.autopilot.refuse.clear()
    await rig.run(RETRY_S + 0.5)
    rig.order(Takeoff())


@pytest.mark.fault("another station replaced the fence between two flights", "uploaded again at the next arming")
async def test_a_fence_that_was_replaced_since_the_last_flight_is_uploaded_again(rig: Rig) -> None:
    by_somebody_else(rig)
    await rig.run(1)
    rig.autopilot.armed = False
    await rig.run(0.5)
    rig.expect(S.IDLE)
    rig.autopilot.held_fence = None  # another station cleared it
    by_somebody_else(rig)
    await rig.run(1)
    assert rig.autopilot.count("upload_fence") == 2
    assert rig.autopilot.held_fence == rig.fence


@pytest.mark.nightly
async def test_the_takeoff_after_our_own_arm_uploads_nothing_twice(rig: Rig) -> None:
    rig.order(Arm())
    await rig.run(0.5)
    rig.order(Takeoff())
    await rig.until(S.HOVER)
    assert rig.autopilot.count("upload_fence") == 1


# -- taken up in the air ----------------------------------------------------------------------------------------------


@pytest.mark.fault(
    "flight taken up in the air without failsafes",
    "no Explore, Move or Resume; Hold, RTL, Land accepted",
)
@pytest.mark.parametrize("command", TASKS, ids=lambda command: type(command).__name__)
async def test_in_the_air_without_failsafes_no_task_begins_and_every_return_is_open(
    tmp_path: Path, command: Command
) -> None:
    rig = Rig(tmp_path, parameters=DEFAULT_PARAMETERS)
    await rig.enter(S.HOVER)
    await rig.run(2)
    refused = rig.command(command)
    assert not refused.accepted
    assert refused.reason == "Ground-station failsafe: off (FS_GCS_ENABLE 0). Return or land, then Set failsafes."
    rig.expect(S.HOVER)
    for exit_place in EXITS:
        rig.order(exit_place)
    await rig.close()


@pytest.mark.fault("the autopilot refuses the fence")
@pytest.mark.parametrize("command", TASKS, ids=lambda command: type(command).__name__)
async def test_in_the_air_no_task_begins_before_the_fence_is_up(flying: Rig, command: Command) -> None:
    flying.autopilot.held_fence = None
    flying.autopilot.refuse["upload_fence"] = "busy"
    flying.autopilot.connected = False
    await flying.run(LOST_S)
    flying.autopilot.connected = True
    await flying.run(2)
    flying.expect(S.HOVER)
    refused = flying.command(command)
    assert refused.reason == "The fence of this flight was not taken by the autopilot. busy."
    for exit_place in EXITS[:2]:
        flying.order(exit_place)
    flying.order(Hold())
    flying.autopilot.refuse.clear()
    await flying.run(RETRY_S + 1)
    flying.target_plan(20, 0)
    assert flying.manager.handle("ana", command) is None or flying.state is not S.HOVER


@pytest.mark.fault(
    "restart in the air",
    "fence compared, nothing written when it is ours; tasks after that and the reading of parameters (4.4 s "
    "on the real one)",
)
async def test_a_restart_in_the_air_compares_the_fence_and_writes_nothing_when_it_is_ours(fresh: Rig) -> None:
    fresh.autopilot.put_in_air()
    fresh.autopilot.held_fence = fresh.manager.fences.build(*[fresh.autopilot.datum] * 2)  # type: ignore[arg-type]
    await fresh.run(2)
    assert fresh.autopilot.count("compare_fence") == 1
    assert fresh.autopilot.count("upload_fence") == 0
    fresh.order(CompulsiveMove(x=20.0, y=0.0))


@pytest.mark.fault("link lost and back in flight", "fence and parameters are looked at again before any task")
async def test_the_fence_is_compared_again_after_a_lost_link(flying: Rig) -> None:
    await flying.run(1)
    flying.autopilot.calls.clear()
    flying.autopilot.connected = False
    await flying.run(LOST_S)
    flying.autopilot.connected = True
    await flying.run(2)
    assert flying.autopilot.count("compare_fence") == 1
    assert flying.autopilot.count("upload_fence") == 0
    flying.order(CompulsiveMove(x=20.0, y=0.0))


@pytest.mark.slow
@pytest.mark.fault("a pilot flies", "nothing is written to the autopilot")
async def test_under_a_pilot_nothing_is_written_and_resume_needs_the_failsafes(unsafe: Rig) -> None:
    by_somebody_else(unsafe)
    unsafe.autopilot.change_mode(CopterMode.LOITER)
    unsafe.autopilot.height, unsafe.autopilot.landed = 30.0, LandedState.IN_AIR
    await unsafe.run(6)
    unsafe.expect(S.MANUAL)
    assert {name for name, _ in unsafe.autopilot.calls} == {"get_parameter"}
    refused = unsafe.command(Resume(confirmed=True))
    assert refused.reason.startswith("Ground-station failsafe: off")
    for name, value in SAFE_PARAMETERS.items():
        unsafe.autopilot.report(name, value)
    await unsafe.run(0.5)
    unsafe.order(Resume(confirmed=True))
    assert unsafe.command(CompulsiveMove(x=20.0, y=0.0)).reason.startswith("The fence of this flight is being set")
    await unsafe.run(2)
    assert unsafe.autopilot.held_fence == unsafe.fence
    unsafe.order(CompulsiveMove(x=20.0, y=0.0))


@pytest.mark.slow
@pytest.mark.fault(
    "another station changes what was right while a pilot flies",
    "reported; Resume is accepted, and it is put back before any task",
)
async def test_what_is_put_back_once_no_pilot_flies_keeps_nobody_from_taking_the_drone(holding: Rig) -> None:
    await holding.run(2)
    holding.autopilot.change_mode(CopterMode.LOITER)
    await holding.run(4)
    holding.expect(S.MANUAL)
    holding.autopilot.report("BATT_FS_LOW_ACT", 5)
    holding.autopilot.report("FENCE_ENABLE", 0)
    await holding.run(5)
    assert holding.autopilot.asked("set_parameter") == []
    holding.order(Resume(confirmed=True))
    assert holding.command(CompulsiveMove(x=20.0, y=0.0)).reason.startswith("Fence in the autopilot: off")
    await holding.run(5)
    assert holding.autopilot.values["BATT_FS_LOW_ACT"] == 2
    assert holding.autopilot.values["FENCE_ENABLE"] == 1
    await holding.run(5)
    holding.order(CompulsiveMove(x=20.0, y=0.0))


@pytest.mark.nightly
async def test_a_fence_that_is_switched_off_under_a_pilot_keeps_nobody_from_taking_the_drone(holding: Rig) -> None:
    await holding.run(2)
    holding.autopilot.change_mode(CopterMode.LOITER)
    await holding.run(4)
    holding.autopilot.fence_on = False
    await holding.run(4)
    holding.expect(S.MANUAL)
    assert holding.autopilot.count("enable_fence") == 0
    holding.order(Resume(confirmed=True))
    assert "switched off" in holding.command(CompulsiveMove(x=20.0, y=0.0)).reason
    await holding.run(4)
    assert holding.autopilot.count("enable_fence") == 1
    holding.order(CompulsiveMove(x=20.0, y=0.0))


# -- the fence is that of this arm place ------------------------------------------------------------------------------


async def flown_once(rig: Rig) -> None:
    rig.order(Arm())
    await rig.run(0.5)
    rig.autopilot.armed = False
    await rig.run(0.5)
    rig.expect(S.IDLE)


@pytest.mark.slow
@pytest.mark.fault(
    "armed at B with A's fence in force, by us or by another station",
    "B's fence in force, uploaded and read back",
)
@pytest.mark.parametrize("ours", [True, False], ids=["by us", "by another station"])
async def test_armed_at_b_the_fence_is_never_that_of_a(rig: Rig, ours: bool) -> None:
    await flown_once(rig)
    fence_of_a = rig.fence
    rig.autopilot.north, rig.autopilot.east = 120.0, 40.0  # carried, still inside A's fence
    await rig.run(1)
    if ours:
        rig.order(Arm())
    else:
        by_somebody_else(rig)
    await rig.run(1)
    rig.expect(S.ARM)
    held = rig.autopilot.held_fence
    assert held == rig.fence != fence_of_a
    assert held is not None
    middle = [sum(corner[axis] for corner in held.autopilot_polygon) / len(held.autopilot_polygon) for axis in (0, 1)]
    assert middle == pytest.approx([120.0, 40.0], abs=0.5)
    rig.order(Takeoff())


@pytest.mark.slow
@pytest.mark.fault("another station clears or replaces the fence in flight, by as many corners")
@pytest.mark.parametrize("held", ["cleared", "replaced"])
async def test_a_fence_that_another_station_clears_in_flight_is_put_back(flying: Rig, held: str) -> None:
    await flying.run(1)
    flying.order(CompulsiveMove(x=60.0, y=0.0))
    assert flying.fence is not None
    flying.autopilot.held_fence = None if held == "cleared" else replace(flying.fence, autopilot_polygon=((0, 0),) * 3)
    flying.autopilot.refuse["upload_fence"] = "busy"
    await flying.run(9)
    assert "The fence in the autopilot was changed. Putting it back." in flying.log
    assert flying.command(CompulsiveMove(x=20.0, y=0.0)).reason.startswith("The fence of this flight was not taken")
    assert flying.state in (S.COMPULSIVE_MOVE, S.HOVER)
    flying.autopilot.refuse.clear()
    await flying.run(RETRY_S + 0.5)
    assert flying.autopilot.held_fence == flying.fence
    assert "The fence of this flight is in the autopilot again." in flying.log
    flying.order(CompulsiveMove(x=20.0, y=0.0))


def arm_place(north: float) -> ArmPlace:
    return ArmPlace(DATUM.latitude + north / 111_113, DATUM.longitude, DATUM.altitude, 0.0, 0.0, 0.0)


def test_the_arm_place_of_an_earlier_flight_is_not_believed_on_the_ground() -> None:
    holder = KeptFence(SETTINGS)
    stands = replace(flying(1.0), vehicle=replace(flying(1.0).vehicle, landed=LandedState.ON_GROUND))
    elsewhere = replace(stands, position=replace(stands.position, arm_place=arm_place(60.0)))
    state = HoverState(1.0, SETTINGS)
    assert holder.tick(elsewhere, state, {}) == ()
    assert holder.problem
    assert holder.tick(stands, state, {}) == ()
    assert holder.problem == ""


def test_disarmed_everything_is_forgotten() -> None:
    holder = KeptFence(SETTINGS)
    holder.tick(flying(1.0), HoverState(1.0, SETTINGS), {})
    assert holder.problem == ""
    holder.tick(on_ground(flying(2.0)), HoverState(1.0, SETTINGS), {})
    assert holder.problem


def test_a_small_wander_of_the_position_is_not_another_place() -> None:
    holder = KeptFence(SETTINGS)
    facts = flying(1.0)
    near = replace(facts, position=replace(facts.position, arm_place=arm_place(2.0)))
    assert holder.tick(near, HoverState(1.0, SETTINGS), {}) == ()
    assert holder.problem == ""


def without_fence(now: float, north: float = 0.0, answers: tuple[Answer, ...] = ()) -> Facts:
    facts = flying(now)
    return replace(
        facts,
        limits=replace(facts.limits, held=None),
        position=replace(facts.position, pose=pose(now, north)),
        answers=answers,
    )


def test_it_compares_first_and_uploads_where_another_fence_is_held() -> None:
    holder, state = KeptFence(SETTINGS), HoverState(1.0, SETTINGS)
    first = holder.tick(without_fence(1.0), state, {})
    assert first == (Ask(CompareFence(FENCE), 1.0),)
    other = (Answer("compare fence", 1.0, "failed", "another one"),)
    assert holder.tick(without_fence(1.1, answers=other), state, {}) == (Ask(UploadFence(FENCE), 1.1),)
    pending = (Answer("upload fence", 1.1, "pending"),)
    assert holder.tick(without_fence(1.2, answers=pending), state, {}) == ()
    refused = (Answer("upload fence", 1.1, "failed", "no"),)
    (messages,) = holder.tick(without_fence(1.3, answers=refused), state, {})
    assert isinstance(messages, Log)
    assert holder.tick(without_fence(1.3 + RETRY_S - 0.1), state, {}) == ()
    again = holder.tick(without_fence(1.3 + RETRY_S), state, {})
    assert again == (Ask(UploadFence(FENCE), 1.3 + RETRY_S),)


@pytest.mark.fault(
    "taken up outside the fence of its arm place",
    "nothing is uploaded (the autopilot would act at once); no task; led back, then uploaded",
)
def test_outside_the_fence_it_is_not_uploaded_because_the_autopilot_would_act_at_once() -> None:
    holder, state = KeptFence(SETTINGS), HoverState(1.0, SETTINGS)
    holder.tick(without_fence(1.0, 160.0), state, {})
    other = (Answer("compare fence", 1.0, "failed", "another one"),)
    assert holder.tick(without_fence(1.1, 160.0, other), state, {}) == ()
    assert holder.problem == "Outside the fence of this flight: Return To Launch, or Land."
    assert holder.tick(without_fence(1.2, 100.0), state, {}) == (Ask(UploadFence(FENCE), 1.2),)


def test_under_a_pilot_it_asks_nothing() -> None:
    holder = KeptFence(SETTINGS)
    assert holder.tick(without_fence(1.0), ManualState(1.0), {}) == ()
    assert holder.problem


def test_without_a_fence_in_force_that_of_the_arm_place_is_put_in_force() -> None:
    holder = KeptFence(SETTINGS)
    facts = flying(1.0)
    bare = replace(facts, limits=replace(facts.limits, fence=None, held=None))
    acts = holder.tick(bare, ManualState(1.0), {})
    assert [type(act) for act in acts] == [PutFenceInForce]
    assert holder.tick(replace(bare, now=1.1), ManualState(1.0), {}) == ()


def test_a_drawn_fence_that_cannot_be_read_keeps_every_task_off() -> None:
    holder, state = KeptFence(SETTINGS), HoverState(1.0, SETTINGS)
    facts = without_fence(1.0)
    holder.tick(replace(facts, limits=replace(facts.limits, plan_problem="The drawn fence cannot be used")), state, {})
    assert holder.problem == "The drawn fence cannot be used."


def test_a_plan_that_makes_no_fence_is_reported() -> None:
    holder = KeptFence(SETTINGS)
    side = 4e-5  # nothing is left inside the margin
    ring = tuple((DATUM.latitude + a * side, DATUM.longitude + b * side) for a, b in ((0, 0), (0, 1), (1, 1), (1, 0)))
    facts = without_fence(1.0)
    narrow = replace(facts, limits=replace(facts.limits, plan=FencePlan("drawn", ring, 100.0)))
    assert holder.tick(narrow, HoverState(1.0, SETTINGS), {}) == ()
    assert "too narrow" in holder.problem


def test_on_the_ground_without_a_place_the_arm_place_is_not_believed() -> None:
    holder = KeptFence(SETTINGS)
    stands = replace(flying(1.0), vehicle=replace(flying(1.0).vehicle, landed=LandedState.ON_GROUND))
    lost = replace(stands, position=replace(stands.position, pose=None))
    assert holder.tick(lost, HoverState(1.0, SETTINGS), {}) == ()
    assert holder.problem
