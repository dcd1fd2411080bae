"""The drawn fence: kept on the ground, refused in the air, taken up again by a later start, uploaded at Arm."""

from __future__ import annotations

import asyncio
import itertools
import json
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from hawk.comm.protocol.commands import (
    Ack,
    Arm,
    AutonomousExplore,
    AutonomousMove,
    CheckFence,
    ClearFence,
    CompulsiveMove,
    Configure,
    FenceCheck,
    SetFence,
)
from hawk.comm.protocol.heartbeat import FenceCorner
from hawk.config.sections import FenceSettings
from hawk.ddc.fence.geometry import FenceError, contains, ring_from_map, ring_to_map
from hawk.ddc.fence.keepers import FENCE_FILE
from hawk.ddc.fence.plan import check_answer
from hawk.ddc.parameters.reader import REREAD_S
from hawk.ddc.requests import requests
from hawk.ddc.settings import DdcSettings
from hawk.model.operation import StateName
from hawk.model.plans import Fence
from hawk.model.poses import MapPoint
from hawk.model.vehicle import LandedState
from tests.unit.ddc.fakes import PLACE, Rig

SQUARE = ((-60.0, -60.0), (60.0, -60.0), (60.0, 60.0), (-60.0, 60.0))
U_SHAPE = (
    (-20.0, -60.0), (100.0, -60.0), (100.0, -20.0), (20.0, -20.0),
    (20.0, 20.0), (100.0, 20.0), (100.0, 60.0), (-20.0, 60.0),
)  # fmt: skip
"""Two arms to the north with a gap of 40 m between them; the drone stands between their feet."""
BOW_TIE = ((-60.0, -60.0), (60.0, 60.0), (60.0, -60.0), (-60.0, 60.0))
WEST_ARM, EAST_ARM = MapPoint(80.0, -40.0), MapPoint(80.0, 40.0)


def fence(ring: tuple[tuple[float, float], ...] = SQUARE, ceiling: float = 80.0) -> SetFence:
    return SetFence(corners=corners(ring), ceiling=ceiling)


def corners(ring: tuple[tuple[float, float], ...]) -> list[FenceCorner]:
    return [FenceCorner(latitude=lat, longitude=lon) for lat, lon in ring_from_map(PLACE, ring)]


def same(found: Sequence[tuple[float, float]], wanted: Sequence[tuple[float, float]]) -> bool:
    """Return True when two rings have the same corners, to a few centimetres."""
    rounded = sorted((round(north, 1), round(east, 1)) for north, east in found)
    return rounded == sorted(wanted)


async def draw(rig: Rig, command: SetFence) -> None:
    """Order a fence and wait until it is kept: a real thread writes the file."""
    rig.order(command)
    rig.expect(StateName.CONFIGURE)
    await saved(rig)


async def saved(rig: Rig) -> None:
    await rig.manager.requests.finish()
    await rig.tick()
    rig.expect(StateName.IDLE)


@pytest.fixture
async def concave(rig: Rig) -> Rig:
    """A drone in the air, in the west arm of a fence like a U."""
    await draw(rig, fence(U_SHAPE))
    rig.order(Arm())
    await rig.until(StateName.ARM)
    await rig.run(0.5)
    rig.autopilot.put_in_air()
    rig.autopilot.north, rig.autopilot.east = WEST_ARM.north, WEST_ARM.east
    await rig.run(0.5)
    rig.expect(StateName.HOVER)
    return rig


# -- kept -------------------------------------------------------------------------------------------------------------


async def test_a_drawn_fence_is_uploaded_and_enabled_at_arm_with_our_margin_inside(rig: Rig) -> None:
    await draw(rig, fence())
    rig.order(Arm())
    await rig.run(0.5)
    uploaded = rig.autopilot.asked("upload_fence")[-1]
    assert isinstance(uploaded, Fence)
    assert uploaded.autopilot_ceiling == 80
    assert uploaded.ceiling == 77
    assert same(uploaded.autopilot_polygon, sorted(SQUARE))
    assert same(uploaded.polygon, [(-55, -55), (-55, 55), (55, -55), (55, 55)])
    assert rig.fence == uploaded


async def test_a_later_start_over_the_same_place_takes_it_up(rig: Rig, tmp_path: Path) -> None:
    await draw(rig, fence(U_SHAPE, 70))
    again = Rig(tmp_path)
    await again.run(2)
    setup = again.manager.fences.setup
    assert (setup.source, setup.ceiling, setup.problem) == ("drawn", 70, "")
    ring = tuple((each.latitude, each.longitude) for each in setup.corners)
    assert same(ring_to_map(PLACE, ring), sorted(U_SHAPE))
    again.order(Arm())
    await again.run(0.5)
    assert again.fence is not None
    assert not contains(again.fence, MapPoint(80, 0))
    await again.close()


async def test_a_start_in_the_air_flies_in_the_drawn_fence(rig: Rig, tmp_path: Path) -> None:
    await draw(rig, fence(U_SHAPE))
    again = Rig(tmp_path)
    again.autopilot.put_in_air()
    await again.run(0.5)
    assert again.fence is not None
    assert not contains(again.fence, MapPoint(80, 0))
    await again.close()


async def test_it_is_a_file_that_other_programs_read(rig: Rig, tmp_path: Path) -> None:
    await draw(rig, fence(SQUARE, 75))
    feature = json.loads((tmp_path / FENCE_FILE).read_text())
    (ring,) = feature["geometry"]["coordinates"]
    assert ring[0] == ring[-1]
    assert feature["properties"]["ceiling_m"] == 75
    turned = sum((b[0] - a[0]) * (b[1] + a[1]) for a, b in itertools.pairwise(ring))
    assert turned < 0, "RFC 7946: counterclockwise"


async def test_cleared_the_configured_fence_counts_again_and_nothing_is_lost(rig: Rig, tmp_path: Path) -> None:
    await draw(rig, fence())
    rig.order(ClearFence())
    await saved(rig)
    assert rig.manager.fences.setup.source == "circle"
    assert not (tmp_path / FENCE_FILE).exists()
    assert (tmp_path / f"{FENCE_FILE}.former").exists()
    assert rig.command(ClearFence()).reason == "No fence is drawn: the standard one is used."


def test_a_configured_file_that_cannot_be_used_is_named_with_its_setting(tmp_path: Path) -> None:
    path = tmp_path / "fence.geojson"
    path.write_text("{")
    with pytest.raises(FenceError, match=r"^fence\.file: .*fence\.geojson: cannot be read"):
        Rig(tmp_path / "store", settings=DdcSettings(fence=FenceSettings(file=path)))


async def test_drawn_goes_before_the_configured_file(tmp_path: Path) -> None:
    path = tmp_path / "configured.geojson"
    ring = [[lon, lat] for lat, lon in ring_from_map(PLACE, ((-90, -90), (90, -90), (90, 90), (-90, 90)))]
    path.write_text(json.dumps({"type": "Polygon", "coordinates": [[*ring, ring[0]]]}))
    rig = Rig(tmp_path / "store", settings=DdcSettings(fence=FenceSettings(file=path)))
    await rig.run(2)
    sources = [rig.manager.fences.setup.source]
    await draw(rig, fence())
    sources.append(rig.manager.fences.setup.source)
    again = Rig(tmp_path / "store", settings=rig.settings)
    assert "The drawn fence is used, not the settings' file." in again.log
    await again.close()
    rig.order(ClearFence())
    await saved(rig)
    assert [*sources, rig.manager.fences.setup.source] == ["file", "drawn", "file"]
    await rig.close()


async def test_operators_are_sent_another_object_after_each_change_only(rig: Rig) -> None:
    first = rig.manager.fences.setup
    await rig.run(1)
    assert rig.manager.status.value is not None
    assert rig.manager.status.value.fence_setup is first
    await draw(rig, fence())
    await rig.run(0.5)
    assert rig.manager.status.value.fence_setup is not first


# -- refused ----------------------------------------------------------------------------------------------------------

AIRBORNE = sorted(set(StateName) - {StateName.IDLE, StateName.CONFIGURE, StateName.ARM})


@pytest.mark.parametrize("state", AIRBORNE)
@pytest.mark.parametrize("command", [fence(), ClearFence()], ids=lambda c: c.type)
async def test_in_the_air_the_fence_is_not_changed(
    fresh: Rig, state: StateName, command: SetFence | ClearFence, tmp_path: Path
) -> None:
    await fresh.enter(state)
    before, plan = fresh.fence, fresh.manager.fences.plan
    answer = fresh.command(command)
    assert not answer.accepted
    assert answer.reason in ("Flying: land first.", "Someone else flies: Resume first.")
    await fresh.tick(3)
    assert (fresh.fence, fresh.manager.fences.plan) == (before, plan)
    assert not (tmp_path / FENCE_FILE).exists()


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (fence(BOW_TIE), "Corners: the sides 1-2 and 3-4 cross"),
        (fence(((0, 0), (12, 0), (12, 12), (0, 12))), "Corners: the fence holds 144 m²"),
        (fence(((0, 0), (300, 0), (300, 9), (0, 9))), "too narrow"),
        (fence(((0, 0), (4200, 0), (4200, 100))), "Corners: the fence is 4200 m wide"),
        (fence((*SQUARE, SQUARE[-1])), "Corners: 4 and 5 lie at one place"),
        (fence((*SQUARE, SQUARE[0])), "Corners: 5 and 1 lie at one place"),
        (fence(((0, 0), (60, 0), (30, 0), (60, 60))), "Corners: "),
        (fence(SQUARE, 101), "Ceiling: 101 m is above the highest allowed, 100 m"),
        (fence(SQUARE, 62), "Ceiling: 62 m is too low for flying up to 60 m, which needs 63 m"),
    ],
)
async def test_a_fence_that_cannot_be_flown_in_is_refused_with_field_and_remedy(
    rig: Rig, command: SetFence, words: str, tmp_path: Path
) -> None:
    answer = rig.command(command)
    assert not answer.accepted
    assert words in answer.reason
    assert ": " in answer.reason.partition(": ")[2], "a remedy"
    rig.expect(StateName.IDLE)
    assert rig.manager.fences.setup.source == "circle"
    assert not (tmp_path / FENCE_FILE).exists()
    check = await rig.check_fence(CheckFence(corners=command.corners, ceiling=command.ceiling), "eve")
    assert isinstance(check, FenceCheck)
    assert check.problem == answer.reason, "what is said while drawing is what is said when saving"


async def test_someone_without_control_may_ask_but_not_change(rig: Rig) -> None:
    assert rig.command(fence(), client="eve").reason == "Someone else has control."
    assert rig.command(ClearFence(), client="eve").reason == "Someone else has control."
    check = await rig.check_fence(CheckFence(corners=corners(SQUARE), ceiling=80), "eve")
    assert isinstance(check, FenceCheck)
    assert check.problem == ""


async def test_a_full_disk_keeps_the_old_fence(rig: Rig, tmp_path: Path) -> None:
    (tmp_path / f".{FENCE_FILE}.new").mkdir()
    await draw(rig, fence())
    assert "The fence was not saved." in rig.log
    assert "could not be stored" in rig.manager.log.entries[-1].details
    assert rig.manager.fences.setup.source == "circle"


async def test_arm_waits_until_the_fence_is_kept(rig: Rig) -> None:
    rig.order(fence())
    assert rig.command(Arm()).reason == "Saving: wait a moment."
    await saved(rig)
    rig.order(Arm())


async def test_the_end_of_the_program_waits_for_a_fence_that_is_being_saved(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig = Rig(tmp_path)
    await rig.run(2)
    begun, goes_on, store = asyncio.Event(), threading.Event(), rig.manager.fences.store
    loop = asyncio.get_running_loop()

    def slowly(plan: Any) -> None:
        loop.call_soon_threadsafe(begun.set)
        goes_on.wait(10)
        store(plan)

    monkeypatch.setattr(rig.manager.fences, "store", slowly)
    rig.order(fence())
    await rig.tick()
    await begun.wait()
    end = asyncio.create_task(rig.manager.close())
    await asyncio.sleep(0)
    goes_on.set()
    await end
    assert (tmp_path / FENCE_FILE).exists()


async def test_a_pilot_who_arms_while_it_is_saved_flies_in_the_fence_in_force(rig: Rig) -> None:
    rig.order(Arm())
    await rig.run(1)
    before = rig.fence
    rig.autopilot.armed = False
    await rig.until(StateName.IDLE)
    rig.order(fence())
    rig.autopilot.armed, rig.autopilot.landed = True, LandedState.IN_AIR
    await rig.run(1)
    await rig.manager.requests.finish()
    await rig.tick()
    assert rig.fence == before
    assert rig.manager.fences.setup.source == "drawn"


@pytest.mark.parametrize("content", ["{", '{"type": "Point"}', json.dumps({"type": "Polygon", "coordinates": [[]]})])
async def test_a_kept_fence_that_cannot_be_read_keeps_the_drone_on_the_ground(tmp_path: Path, content: str) -> None:
    (tmp_path / FENCE_FILE).write_text(content)
    rig = Rig(tmp_path)
    await rig.run(2)
    failed = rig.first_failed
    assert failed is not None
    assert (failed.name, failed.remedy_command) == ("Fence", "Set Fence")
    assert not rig.command(Arm()).accepted
    assert rig.manager.fences.setup.problem
    rig.order(ClearFence())
    await saved(rig)
    rig.order(Arm())
    await rig.close()


async def test_a_kept_fence_that_is_too_narrow_for_a_wider_margin_is_a_problem_too(rig: Rig, tmp_path: Path) -> None:
    await draw(rig, fence(((-20, -20), (20, -20), (20, 20), (-20, 20))))
    again = Rig(tmp_path, settings=DdcSettings(fence=FenceSettings(margin_m=25)))
    await again.run(2)
    assert "too narrow" in again.manager.fences.problem
    assert not again.command(Arm()).accepted
    await again.close()


# -- heights ----------------------------------------------------------------------------------------------------------


async def test_the_fences_ceiling_bounds_the_heights(rig: Rig) -> None:
    await draw(rig, fence(SQUARE, 70))
    assert "above the ceiling, 67 m" in rig.command(Configure(min=15, des=35, max=68)).reason
    rig.order(Configure(min=15, des=35, max=67))


@pytest.mark.slow
async def test_a_return_above_the_fences_ceiling_fails_before_flight_and_is_reported_while_drawing(rig: Rig) -> None:
    rig.autopilot.values["RTL_ALT"] = 9_000
    await rig.run(REREAD_S + 2)
    check = await rig.check_fence(CheckFence(corners=corners(SQUARE), ceiling=80))
    assert isinstance(check, FenceCheck)
    assert check.notes == ["It returns home at 90 m, above 77 m: change the heights first."]
    await draw(rig, fence(SQUARE, 80))
    failed = rig.first_failed
    assert failed is not None
    assert (failed.name, failed.value) == ("Return height", "90 m, ceiling 77 m")
    assert not rig.command(Arm()).accepted


@pytest.mark.nightly
async def test_what_must_be_changed_is_noted_before_what_must_be_known(rig: Rig) -> None:
    rig.autopilot.values["RTL_ALT"] = 9_000
    await rig.run(REREAD_S + 2)
    check = await rig.check_fence(CheckFence(corners=corners(U_SHAPE), ceiling=80))
    assert isinstance(check, FenceCheck)
    assert [note.split()[0] for note in check.notes] == ["It", "From"]


@pytest.mark.parametrize(
    ("ceiling", "problem"), [(63.0, ""), (62.9, "Ceiling: 62.9 m is too low for flying up to 60 m, which needs 63 m")]
)
async def test_the_ceiling_leaves_our_margin_above_max(rig: Rig, ceiling: float, problem: str) -> None:
    check = await rig.check_fence(CheckFence(corners=corners(SQUARE), ceiling=ceiling))
    assert isinstance(check, FenceCheck)
    assert check.problem.startswith(problem)
    assert bool(check.problem) is bool(problem)


async def test_a_drawn_fence_outranks_no_file_where_none_is_configured(rig: Rig, tmp_path: Path) -> None:
    await draw(rig, fence())
    await rig.close()
    again = Rig(tmp_path, settings=rig.settings)
    assert again.manager.fences.setup.source == "drawn"
    assert not any("not the settings' file" in line for line in again.log)
    await again.close()


# -- what is said while it is drawn -----------------------------------------------------------------------------------


async def test_a_check_shows_our_limit_and_measures(rig: Rig) -> None:
    check = await rig.check_fence(CheckFence(corners=corners(SQUARE), ceiling=80, id="c"))
    assert isinstance(check, FenceCheck)
    inner = ring_to_map(PLACE, tuple((each.latitude, each.longitude) for each in check.inner))
    assert same(inner, [(-55, -55), (-55, 55), (55, -55), (55, 55)])
    assert check.north_south == pytest.approx(120, abs=0.01)
    assert check.area == pytest.approx(14_400, rel=1e-3)
    assert (check.id, check.notes) == ("c", [])


@pytest.mark.parametrize(
    ("ring", "words"),
    [
        (tuple((n + 200, e) for n, e in SQUARE), "The drone stands 145 m outside"),
        (U_SHAPE, "From parts of it the straight path home leaves the fence"),
    ],
)
async def test_a_check_shows_what_would_speak_against_flying(
    rig: Rig, ring: tuple[tuple[float, float], ...], words: str
) -> None:
    check = await rig.check_fence(CheckFence(corners=corners(ring), ceiling=80))
    assert isinstance(check, FenceCheck)
    assert check.problem == ""
    assert words in check.notes[0]


async def test_a_drone_outside_may_keep_the_fence_but_not_arm(rig: Rig) -> None:
    await draw(rig, fence(tuple((n + 200, e) for n, e in SQUARE)))
    assert "drone 145 m outside" in rig.command(Arm()).reason


# -- a path that leaves a concave fence and enters it again -----------------------------------------------------------


@pytest.mark.nightly
async def test_a_move_across_the_gap_is_refused(concave: Rig) -> None:
    across = CompulsiveMove(x=EAST_ARM.north, y=EAST_ARM.east, frame="Map")
    answer = concave.command(across)
    assert answer.reason == "X, Y: the straight path there leaves the fence: go around it in two moves."
    assert concave.manager.handle("ana", AutonomousMove(x=EAST_ARM.north, y=EAST_ARM.east, frame="Map")) is None
    await concave.tick(3)
    _, late = concave.socket.replies[-1]  # the planner's route goes straight, over the gap
    assert isinstance(late, Ack)
    assert not late.accepted
    assert "leaves the fence" in late.reason
    concave.expect(StateName.HOVER)
    concave.order(CompulsiveMove(x=0, y=-40, frame="Map"))


@pytest.mark.nightly
async def test_a_new_target_in_flight_is_checked_from_where_the_drone_is(concave: Rig) -> None:
    concave.order(CompulsiveMove(x=0, y=-40, frame="Map"))
    await concave.run(1)
    assert "straight path" in concave.command(CompulsiveMove(x=80, y=40, frame="Map")).reason
    concave.expect(StateName.COMPULSIVE_MOVE)


@pytest.mark.nightly
async def test_a_planner_that_points_across_the_gap_is_not_followed(concave: Rig) -> None:
    concave.target_plan(EAST_ARM.north, EAST_ARM.east)
    concave.order(AutonomousExplore())
    sent = len(concave.autopilot.targets)
    await concave.run(5)
    assert len(concave.autopilot.targets) == sent
    assert concave.autopilot.east == pytest.approx(WEST_ARM.east, abs=1)
    await concave.until(StateName.HOVER, 20)
    assert any("leaves the fence" in text for text in concave.log)


@pytest.mark.slow
async def test_no_tick_of_a_flight_around_the_gap_sends_a_target_over_it(concave: Rig) -> None:
    for north, east in ((0, -40), (0, 40), (80, 40)):
        concave.order(CompulsiveMove(x=north, y=east, frame="Map"))
        await concave.run(0.2)
        await concave.until(StateName.HOVER, 60)
        assert (concave.autopilot.north, concave.autopilot.east) == pytest.approx((north, east), abs=2)
    fence_in_force = concave.fence
    assert fence_in_force is not None
    assert all(contains(fence_in_force, MapPoint(t.north, t.east)) for t in concave.autopilot.targets)


# -- where it is checked ----------------------------------------------------------------------------------------------


async def test_a_fence_is_checked_on_a_thread_of_its_own(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    threads: list[str] = []

    def noted(*given: Any) -> FenceCheck:
        threads.append(threading.current_thread().name)
        return check_answer(*given)

    monkeypatch.setattr(requests, "check_answer", noted)
    assert isinstance(await rig.check_fence(CheckFence(corners=corners(SQUARE), ceiling=80), "eve"), FenceCheck)
    assert len(threads) == 1
    assert threads[0].startswith("hawk-fence")


@pytest.mark.fault(
    "256 Check Fence of one client",
    "the tick does none of it: a thread answers the newest, the others are refused at once",
)
async def test_of_one_clients_questions_the_newest_is_checked_and_each_is_answered(rig: Rig) -> None:
    asked = [CheckFence(corners=corners(SQUARE), ceiling=80, id=number) for number in range(256)]
    answers = await rig.later("eve", *asked)
    checked = [answer for answer in answers if isinstance(answer, FenceCheck)]
    assert [each.id for each in checked] == [255]
    refused = [answer for answer in answers if isinstance(answer, Ack)]
    assert [each.id for each in refused] == list(range(255))
    assert {(each.accepted, each.reason) for each in refused} == {(False, "You asked about another fence since.")}


async def test_a_check_that_fails_is_answered_and_the_next_one_goes_on(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as broken:
        broken.setattr(requests, "check_answer", lambda *_: 1 / 0)
        answer = await rig.check_fence(CheckFence(corners=corners(SQUARE), ceiling=80))
    assert isinstance(answer, Ack)
    assert "ZeroDivisionError" in answer.reason
    assert isinstance(await rig.check_fence(CheckFence(corners=corners(SQUARE), ceiling=80)), FenceCheck)
