"""One survey with everything that may happen to it: killed while exploring, landed and armed again elsewhere, its
operator lost, brought home. It is flown once; each test looks at a part of it."""

from __future__ import annotations

import math
import statistics
from collections.abc import AsyncIterator, Callable, Set
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pytest_asyncio
from numpy.typing import NDArray
from scipy.spatial import KDTree

from hawk.algo.frame import FrameInput, FrameOutput
from hawk.algo.manager import AlgorithmManagerApp
from hawk.algo.mapper.app import MapperApp
from hawk.algo.path_plan.app import PathPlanApp
from hawk.algo.topic_interface import AlgorithmTopicInterface, FrameCamera
from hawk.algo.vision.app import VisionApp, VisionSettings
from hawk.comm.protocol.commands import AutonomousExplore, CompulsiveMove, Hold, Land
from hawk.comm.protocol.heartbeat import Heartbeat
from hawk.model.lot_map import Stall
from hawk.model.operation import StateName
from hawk.model.poses import GlobalPose
from hawk.sim.launch import SimulationOptions
from hawk.store.replay import read_frames, read_metadata, read_recording
from hawk.survey.report import map_offset
from hawk.survey.stack import SimulatedStack
from hawk.survey.truth import GroundTruth
from tests.integration.daemon_support import (
    Operator,
    PatientStack,
    kill_daemon,
    newest_journal,
    operator,
    write_settings,
)
from tests.pace import speed_here

pytestmark = [pytest.mark.integration, pytest.mark.alone, pytest.mark.asyncio(loop_scope="module")]

SETTINGS = """
[heights]
minimum_m = 15.0
desired_m = 25.0
maximum_m = 30.0
[operator]
operator_timeout_s = 4.0
operator_hold_s = 30.0
control_lease_s = 8.0
"""
STALLS = 15
"""Number of stalls known when the daemon is killed."""
LOST_S = 1.0
"""Age in real seconds from which changes survive a kill."""
STILL_M = 0.3
"""The map as a whole moves less, and so does what is not seen again; a stall that is seen again may be placed better
by more, and worse by no more than twice that."""
FROM_HOME_M = 5.0
FRAMES = 30
SPEED = speed_here(3.0)
CAMERA_HZ = 5.0
"""Pictures in a simulated second: vision keeps up with them."""
EXPLORE_ATTEMPTS = 5


@dataclass(frozen=True)
class Look:
    """A client's knowledge at a moment."""

    beat: Heartbeat
    map_id: str | None
    stalls: dict[int, Stall]

    @property
    def place(self) -> tuple[float, float]:
        assert self.beat.north is not None
        assert self.beat.east is not None
        return self.beat.north, self.beat.east

    @property
    def home(self) -> tuple[float, float]:
        assert self.beat.home is not None
        return self.beat.home.north, self.beat.home.east


@dataclass(frozen=True)
class Survey:
    """Sightings, in the order of flight."""

    a_second_before_the_kill: Look
    at_the_kill: Look
    on_disk: dict[int, Stall]
    taken_up: Look
    going_on: Look
    landed_elsewhere: Look
    armed_elsewhere: Look
    flying_again: Look
    operator_lost: Look
    operator_back: Look
    home: Look
    truth: GroundTruth
    truth_of_the_end: dict[str, Any]
    recordings: list[Path]


@pytest_asyncio.fixture(loop_scope="module", scope="module")
async def survey(tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[Survey]:
    folder = tmp_path_factory.mktemp("survey")
    options = SimulationOptions(seed=1, speed=SPEED, camera_rate=CAMERA_HZ)
    stack = PatientStack(options, folder, write_settings(folder, SETTINGS), None)
    try:
        url = (await stack.start()).url
        killed = await until_killed(stack, url)
        on_disk = restored(folder / "store")
        await stack.start_daemon()
        gone_on = await until_landed_elsewhere(url)
        ended = await until_home(url)
        status = await stack.status()
        truth = stack.truth
    finally:
        await stack.stop()
    assert truth is not None
    recordings = sorted((folder / "store" / "recordings").glob("*.mcap"))
    yield Survey(*killed, on_disk, *gone_on, *ended, truth=truth, truth_of_the_end=status, recordings=recordings)


def restored(store: Path) -> dict[int, Stall]:
    """Return the stalls that the newest survey's journal restores, before any picture is seen."""
    mapper = MapperApp()
    assert mapper.restore([newest_journal(store).map_parts]) == []
    return dict(mapper.get_occupancy_map().stalls)


async def look(pilot: Operator) -> Look:
    """Wait until nothing of the map is outstanding and return what is known."""
    await pilot.drone.whole_map()
    known = pilot.drone.map
    return Look(pilot.beat, known.map_id, dict(known.stalls))


async def explore(pilot: Operator, reached: Callable[[Heartbeat], bool]) -> None:
    """Explore until something holds while it explores; begin again when a machine too busy to see ended it."""
    for _ in range(EXPLORE_ATTEMPTS):
        if pilot.beat.state == StateName.HOVER:
            await pilot.hand.offer(AutonomousExplore())
        beat = await pilot.until(lambda b: b.state == StateName.HOVER or reached(b), 120)
        if beat.state == StateName.AUTONOMOUS_EXPLORE:
            return
    pytest.fail(f"exploring ended {EXPLORE_ATTEMPTS} times: {pilot.beat.detail}")


async def until_killed(stack: SimulatedStack, url: str) -> tuple[Look, Look]:
    async with operator(url) as pilot:
        await pilot.take_off()
        await explore(pilot, lambda _: len(pilot.drone.map.stalls) >= STALLS)
        early = await look(pilot)
        since = early.beat.time
        await explore(pilot, lambda b: b.time - since > 1.5 * LOST_S * SPEED)
        late = await look(pilot)
        await kill_daemon(stack)
    return early, late


async def until_landed_elsewhere(url: str) -> tuple[Look, Look, Look]:
    async with operator(url) as pilot:
        await pilot.until_state(StateName.COMMUNICATION_LOST)
        await pilot.until(lambda _: pilot.drone.map.map_id is not None)
        taken_up = await look(pilot)
        await pilot.take_control()
        await pilot.until_state(StateName.HOVER)
        await explore(pilot, lambda b: True)
        going_on = await look(pilot)
        await pilot.order(Hold())
        north, east = taken_up.home
        await pilot.order(CompulsiveMove(x=north, y=east + FROM_HOME_M, frame="Map"))
        await pilot.until_state(StateName.HOVER)
        await pilot.order(Land())
        await pilot.until_down()
        return taken_up, going_on, await look(pilot)


async def until_home(url: str) -> tuple[Look, Look, Look, Look, Look]:
    async with operator(url) as watcher:
        async with operator(url) as pilot:
            await pilot.arm()
            armed = await look(pilot)
            await pilot.climb()
            flying = await look(pilot)
            await explore(pilot, lambda _: True)
        await watcher.until_state(StateName.COMMUNICATION_LOST)
        lost = await look(watcher)
        await watcher.take_control()
        await watcher.until_state(StateName.HOVER)
        await watcher.hand.pause(2)
        back = await look(watcher)
        await watcher.come_home()
        return armed, flying, lost, back, await look(watcher)


def apart(one: Stall | tuple[float, float], other: Stall | tuple[float, float]) -> float:
    """Return the metres between two places."""
    return math.dist(*((p.north, p.east) if isinstance(p, Stall) else p for p in (one, other)))


def moves(before: Look, after: Look, kept: Set[int]) -> tuple[list[float], list[float]]:
    """Return how far stalls moved between two looks, metres: those that were not seen in between, and all."""
    moved = {i: apart(before.stalls[i], after.stalls[i]) for i in kept}
    unseen = [metres for i, metres in moved.items() if after.stalls[i].last_seen == before.stalls[i].last_seen]
    return unseen, list(moved.values())


def worse_by(before: Look, after: Look, kept: Set[int], truth: GroundTruth) -> list[float]:
    """Return how much farther from its true place each stall lies, metres; the true one is the nearest one before.

    An id that became another stall's is worse by the metres between the two.
    """
    true = np.array([corners.mean(axis=0) for corners in truth.stalls])
    old, new = (truth_places(look, sorted(kept), truth) for look in (before, after))
    shift = map_offset(old, true)
    off, nearest = KDTree(true).query(old + shift)
    return [float(metres) for metres in np.hypot(*(new + shift - true[nearest]).T) - off]


def truth_places(look: Look, ids: list[int], truth: GroundTruth) -> NDArray[np.float64]:
    """Return the centres of stalls as the truth's (x, y) metres, (N, 2)."""
    assert look.beat.datum is not None
    places = np.array([(look.stalls[i].north, look.stalls[i].east) for i in ids])
    latitude, longitude = look.beat.datum
    return truth.to_world(places, GlobalPose(latitude, longitude, 0.0))


async def test_a_kill_while_exploring_loses_no_stall(survey: Survey) -> None:
    before, after = survey.at_the_kill, survey.taken_up
    kept = survey.a_second_before_the_kill.stalls.keys() & before.stalls.keys()
    assert len(kept) >= STALLS // 2
    assert kept <= survey.on_disk.keys()
    assert all(apart(before.stalls[i], survey.on_disk[i]) < 2 * STILL_M for i in kept)
    taken_back = kept - after.stalls.keys()
    assert len(taken_back) <= 1  # more looks may take back a doubtful stall; a lost map would take them all
    kept -= taken_back
    unseen, moved = moves(before, after, kept)
    assert statistics.median(moved) < STILL_M
    assert all(metres < STILL_M for metres in unseen)
    assert max(worse_by(before, after, kept, survey.truth)) < 2 * STILL_M


async def test_the_flight_is_taken_up_where_it_was(survey: Survey) -> None:
    before, after = survey.at_the_kill, survey.taken_up
    assert after.beat.state == StateName.COMMUNICATION_LOST
    assert (after.map_id, after.beat.datum) == (before.map_id, before.beat.datum)
    assert apart(after.home, before.home) < STILL_M
    assert after.beat.fence == before.beat.fence
    assert survey.going_on.beat.state == StateName.AUTONOMOUS_EXPLORE
    assert survey.going_on.map_id == before.map_id


async def test_armed_again_elsewhere_no_stall_moves(survey: Survey) -> None:
    before, armed, flying = survey.landed_elsewhere, survey.armed_elsewhere, survey.flying_again
    assert apart(armed.home, before.home) == pytest.approx(FROM_HOME_M, abs=2.0)
    assert (armed.map_id, armed.beat.datum) == (before.map_id, before.beat.datum)
    assert (flying.map_id, flying.beat.datum) == (before.map_id, before.beat.datum)
    assert armed.stalls == before.stalls
    assert before.stalls.keys() <= flying.stalls.keys()
    unseen, _ = moves(before, flying, before.stalls.keys())
    assert all(metres < STILL_M for metres in unseen)
    assert max(worse_by(before, flying, before.stalls.keys(), survey.truth)) < 2 * STILL_M


async def test_an_operator_who_goes_while_it_explores_finds_it_holding(survey: Survey) -> None:
    lost, back = survey.operator_lost, survey.operator_back
    assert lost.beat.state == StateName.COMMUNICATION_LOST
    assert lost.beat.ardupilot_state == "GUIDED"
    assert back.beat.state == StateName.HOVER
    assert apart(lost.place, back.place) < 10.0
    assert back.beat.speed is not None
    assert back.beat.speed < 1.0


async def test_it_came_home_whole(survey: Survey) -> None:
    assert survey.home.beat.state == StateName.IDLE
    assert survey.home.beat.armed is False
    assert survey.truth_of_the_end["landed"]
    assert survey.truth_of_the_end["disarmed"]
    assert not survey.truth_of_the_end["crashed"]
    assert apart(survey.home.place, survey.home.home) < 2.5
    gone = survey.flying_again.stalls.keys() - survey.home.stalls.keys()
    assert len(gone) <= 1  # more looks may take back a doubtful stall; a lost map would take them all


async def test_every_flight_was_recorded_also_the_killed_one(survey: Survey) -> None:
    assert len(survey.recordings) == 3
    for path in survey.recordings:
        assert read_metadata(path)["version"]
        topics = {recorded.topic for recorded in read_recording(path)}
        assert {"frame_input", "tick", "command", "state", "target"} <= topics


async def test_the_same_recorded_frames_twice_give_equal_results(survey: Survey) -> None:
    recorded = read_frames(survey.recordings[-1], FrameInput)
    high = [f for f in recorded if f.pose is not None and f.pose.height > 15]
    assert len(high) >= FRAMES
    frames = high[:: len(high) // FRAMES]  # from the whole flight: its first seconds may show the lot's edge alone
    once, twice = run_again(frames), run_again(frames)
    assert any(output.occupancy_map.stalls for output in once)
    for one, other in zip(once, twice, strict=True):
        assert replace(one, timings=()) == replace(other, timings=())


def run_again(frames: list[FrameInput]) -> list[FrameOutput]:
    """Run recorded frames through algorithms that know nothing yet."""
    interface = AlgorithmTopicInterface()
    manager = AlgorithmManagerApp()
    camera = FrameCamera(interface)
    manager.init(interface, VisionApp(VisionSettings()), MapperApp(map_id="again"), PathPlanApp(), camera)
    return [manager.run(frame) for frame in frames]
