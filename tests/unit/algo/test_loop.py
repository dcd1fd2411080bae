from __future__ import annotations

import asyncio
import threading
from collections.abc import AsyncIterator, Callable
from dataclasses import replace

import pytest

from hawk.algo.frame import FrameInput, FrameOutput
from hawk.algo.loop import Aim, AlgorithmLoop, Situation, SunAt, fixed_mount, unknown_sun
from hawk.algo.manager import AlgorithmManagerApp
from hawk.algo.mapper.app import MapperApp
from hawk.algo.path_plan.app import PathPlanApp
from hawk.algo.topic_interface import AlgorithmTopicInterface, AlgorithmTopics, FrameCamera
from hawk.comm.cameras.drone_camera import CameraFrame
from hawk.model.operation import Health, StateName
from hawk.model.pictures import CameraModel
from hawk.model.plans import HeightParameters
from hawk.model.poses import GlobalPose, MapPoint, Ring, VehiclePose
from hawk.model.sun import SunPosition
from tests.unit.algo.synthetic import CAMERA, SyntheticVision, pose_at, rows_lot


class FakeCamera:
    """Gives the newest of the frames that a test puts in, as the Drone Camera does."""

    def __init__(self) -> None:
        self.newest: asyncio.Queue[float | Exception] = asyncio.Queue(1)

    def put(self, captured: float | Exception) -> None:
        if self.newest.full():
            self.newest.get_nowait()
        self.newest.put_nowait(captured)

    async def next_frame(self) -> CameraFrame:
        captured = await self.newest.get()
        if isinstance(captured, Exception):
            raise captured
        return CameraFrame(b"jpeg", captured, 1, captured, 1280, 720)


class Gate(AlgorithmManagerApp):
    """Holds every frame until the test lets it go on, and notes the threads."""

    def __init__(self) -> None:
        super().__init__()
        self.entered = threading.Semaphore(0)
        self.leave = threading.Semaphore(0)
        self.is_open = True
        self.threads: set[str] = set()
        self.ran: list[int] = []
        self.fault: Exception | None = None

    def run(self, frame: FrameInput) -> FrameOutput:
        self.threads.add(threading.current_thread().name)
        self.ran.append(round(frame.captured))
        self.entered.release()
        if not self.is_open:
            assert self.leave.acquire(timeout=5)
        if self.fault is not None:
            fault, self.fault = self.fault, None
            raise fault
        return super().run(frame)


class Rig:
    def __init__(self) -> None:
        interface = AlgorithmTopicInterface()
        self.manager = Gate()
        vision = SyntheticVision(rows_lot())
        self.manager.init(interface, vision, MapperApp(map_id="first"), PathPlanApp(), FrameCamera(interface))
        self.camera = FakeCamera()
        self.topics = AlgorithmTopics.create(lambda: 0.0)
        self.recorded: list[FrameInput] = []
        self.fail_to_record = False
        self.problem = ""
        self.ground = 0.0
        self.private: tuple[Ring, ...] = ()
        self.pose: Callable[[float], VehiclePose | None] = vehicle_pose
        self.aim: Aim = fixed_mount
        self.sun_at: SunAt = unknown_sun
        self.loop = AlgorithmLoop(
            self.manager,
            self.camera.next_frame,
            lambda t: self.pose(t),
            self.situation,
            self.topics,
            self.record,
            aim=lambda camera, time, pose: self.aim(camera, time, pose),
            sun_at=lambda time, pose: self.sun_at(time, pose),
        )

    def situation(self) -> Situation:
        return replace(situation(), map_problem=self.problem, ground=self.ground, private=self.private)

    def record(self, frame: FrameInput) -> None:
        if self.fail_to_record:
            raise OSError("disk full")
        self.recorded.append(frame)

    async def put(self, captured: float) -> FrameOutput:
        waiter = asyncio.ensure_future(self.topics.frame_output.next())
        await asyncio.sleep(0)
        self.camera.put(captured)
        async with asyncio.timeout(5):
            return await waiter


async def until(happens: Callable[[], bool]) -> None:
    """Let the loop run until something happens on it or on the worker, for five seconds at most."""
    async with asyncio.timeout(5):
        while not happens():  # noqa: ASYNC110 - a thread cannot set an asyncio.Event
            await asyncio.sleep(0.001)


def vehicle_pose(time: float) -> VehiclePose | None:
    pose = pose_at(0.0, time)
    return VehiclePose(time, GlobalPose(0, 0, 0), 35.0, None, pose, (3.0, 4.0, 0.0), 0.0, 0.0, 0.0)


def situation() -> Situation:
    return Situation(CAMERA, StateName.HOVER, None, HeightParameters(), None, MapPoint(0, 0))


@pytest.fixture
async def rig() -> AsyncIterator[Rig]:
    rig = Rig()
    rig.loop.start()
    yield rig
    rig.manager.is_open = True
    for _ in range(10):
        rig.manager.leave.release()
    await rig.loop.close()


async def test_a_gimbal_turns_the_camera_of_its_picture(rig: Rig) -> None:
    asked: list[tuple[float, VehiclePose | None]] = []

    def aim(camera: CameraModel, time: float, pose: VehiclePose | None) -> tuple[CameraModel, str]:
        asked.append((time, pose))
        return replace(camera, mount_pitch=0.3), ""

    rig.aim = aim
    await rig.put(2.0)
    assert rig.recorded[0].camera == replace(CAMERA, mount_pitch=0.3)
    assert asked == [(2.0, vehicle_pose(2.0))]
    assert rig.recorded[0].map_problem == ""


@pytest.mark.fault("the attitude of the camera's gimbal does not come, or is older than 0.5 s")
async def test_without_the_gimbal_s_attitude_nothing_is_mapped_and_the_mapper_says_why(rig: Rig) -> None:
    rig.aim = lambda camera, _time, _pose: (camera, "the gimbal's attitude is 3 s old: nothing is mapped")
    output = await rig.put(2.0)
    assert "3 s old" in output.mapper_health.reason
    assert not output.occupancy_map.stalls
    rig.problem = "the position jumped"
    await rig.put(3.0)
    assert rig.recorded[-1].map_problem == "the position jumped"


async def test_a_frame_becomes_topics_and_is_recorded(rig: Rig) -> None:
    output = await rig.put(2.0)
    frame = rig.recorded[0]
    assert (frame.captured, frame.sequence, frame.speed) == (2.0, 1, 5.0)
    assert frame.pose == pose_at(0.0, 2.0)
    assert rig.topics.occupancy_map.value is output.occupancy_map
    assert rig.topics.local_pos.value is output.path_plan
    assert rig.topics.footprint.value == output.footprint
    assert rig.topics.vision_app_health.value == output.vision_health
    assert rig.topics.annotated.value is not None
    assert rig.topics.annotated.value.captured == 2.0
    assert rig.topics.des_loc_inbound.value is None


async def test_a_picture_without_private_ground_is_recorded_in_place_of_the_frame_s_or_none(rig: Rig) -> None:
    rig.private = (((-3.0, -3.0), (-3.0, 3.0), (3.0, 3.0), (3.0, -3.0)),)
    await rig.put(2.0)
    assert rig.recorded[0].private == rig.private
    assert rig.recorded[0].jpeg.startswith(b"\xff\xd8")
    rig.pose = lambda _: None
    await rig.put(3.0)
    assert len(rig.recorded) == 1
    rig.private = ()
    await rig.put(4.0)
    assert rig.recorded[1].jpeg == b"jpeg"


@pytest.mark.nightly
async def test_the_sun_of_the_picture_s_moment_and_place_goes_with_the_frame(rig: Rig) -> None:
    asked: list[tuple[float, VehiclePose]] = []

    def sun_at(time: float, pose: VehiclePose) -> SunPosition:
        asked.append((time, pose))
        return SunPosition(170.0, 40.0)

    await rig.put(1.0)
    rig.sun_at = sun_at
    await rig.put(2.0)
    rig.pose = lambda _time: None
    await rig.put(3.0)
    assert [frame.sun for frame in rig.recorded] == [None, SunPosition(170.0, 40.0), None]
    assert asked == [(2.0, vehicle_pose(2.0))]


@pytest.mark.nightly
async def test_the_height_of_the_ground_goes_with_the_frame(rig: Rig) -> None:
    await rig.put(2.0)
    rig.ground = 5.0
    await rig.put(3.0)
    assert [frame.ground for frame in rig.recorded] == [0.0, 5.0]


async def test_why_nothing_may_be_mapped_goes_with_the_frame(rig: Rig) -> None:
    rig.problem = "the position jumped"
    await rig.put(2.0)
    assert rig.recorded[0].map_problem == "the position jumped"


@pytest.mark.slow
async def test_all_work_is_on_one_thread_that_is_not_the_loops(rig: Rig) -> None:
    for captured in range(3):
        await rig.put(float(captured))
    await rig.loop.changes_since(0)
    assert len(rig.manager.threads) == 1
    assert threading.current_thread().name not in rig.manager.threads


async def test_the_newest_frame_replaces_the_one_that_waits(rig: Rig) -> None:
    rig.manager.is_open = False
    rig.camera.put(0.0)
    await until(lambda: rig.manager.entered.acquire(blocking=False))
    for captured in (1.0, 2.0, 3.0):
        await asyncio.sleep(0.01)
        rig.camera.put(captured)
    done = asyncio.ensure_future(rig.topics.frame_output.next())
    rig.manager.leave.release()
    async with asyncio.timeout(5):
        assert (await done).captured == 0.0
    done = asyncio.ensure_future(rig.topics.frame_output.next())
    rig.manager.leave.release()
    async with asyncio.timeout(5):
        assert (await done).captured == 3.0
    assert rig.manager.ran == [0, 3]


async def test_the_loop_is_free_while_the_worker_works(rig: Rig) -> None:
    rig.manager.is_open = False
    rig.camera.put(0.0)
    await until(lambda: rig.manager.entered.acquire(blocking=False))
    assert rig.topics.frame_output.value is None


async def test_without_a_pose_the_frame_is_still_shown(rig: Rig) -> None:
    rig.pose = lambda _: None
    output = await rig.put(1.0)
    assert rig.recorded[0].pose is None
    assert output.annotated_jpeg


async def test_an_unexpected_fault_costs_one_frame_and_is_seen(rig: Rig) -> None:
    rig.manager.fault = RuntimeError("bug")
    waiter = asyncio.ensure_future(rig.topics.vision_app_health.next())
    await asyncio.sleep(0)
    rig.camera.put(1.0)
    async with asyncio.timeout(5):
        health = await waiter
    assert health.reason == "unexpected RuntimeError: bug"
    assert (await rig.put(2.0)).vision_health.is_healthy


@pytest.mark.slow
async def test_a_camera_that_raises_is_asked_again(rig: Rig) -> None:
    rig.camera.put(OSError("unplugged"))
    assert (await rig.put(2.0)).captured == 2.0


@pytest.mark.slow
async def test_a_recorder_that_fails_does_not_stop_the_frames(rig: Rig) -> None:
    rig.fail_to_record = True
    assert (await rig.put(1.0)).vision_health.is_healthy
    assert (await rig.put(2.0)).captured == 2.0
    assert rig.topics.vision_app_health.value == Health()


@pytest.mark.slow
async def test_the_map_is_read_and_taken_up_between_frames(rig: Rig) -> None:
    for captured in range(5):
        await rig.put(float(captured))
    delta = await rig.loop.changes_since(0)
    assert any(name.startswith("stall/") for name in delta.parts)
    assert await rig.loop.restore_map([]) == []
    assert (await rig.loop.changes_since(0)).version == 0
    assert await rig.loop.restore_map([delta.parts]) == []
    output = await rig.put(6.0)
    assert output.occupancy_map.map_id == "first"
    assert output.occupancy_map.counts.total > 0


async def test_closing_ends_the_thread_and_twice_is_harmless() -> None:
    rig = Rig()
    rig.loop.start()
    rig.loop.start()
    await rig.put(1.0)
    (name,) = rig.manager.threads
    await rig.loop.close()
    await rig.loop.close()
    assert name not in {thread.name for thread in threading.enumerate()}


@pytest.mark.slow
async def test_another_survey_begins_with_an_empty_map_between_two_frames(rig: Rig) -> None:
    before = await rig.put(1.0)
    before = await rig.put(2.0)
    assert before.occupancy_map.counts.total > 0
    await rig.loop.begin_survey("second")
    assert (await rig.loop.changes_since(0)).version == 0
    rig.problem = "not mapped"
    after = await rig.put(3.0)
    assert (before.occupancy_map.map_id, after.occupancy_map.map_id) == ("first", "second")
    assert (after.occupancy_map.counts.total, len(after.occupancy_map.stalls)) == (0, 0)
