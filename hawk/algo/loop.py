"""The algorithms' part on the loop: gives the newest camera frame to the worker thread and publishes the results."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeVar

from hawk.algo.frame import FrameInput
from hawk.algo.topic_interface import AlgorithmTopics
from hawk.comm.cameras.drone_camera import CameraFrame
from hawk.model.known_lot import KnownLot, LotTour
from hawk.model.operation import Health, StateName
from hawk.model.pictures import CameraModel
from hawk.model.plans import AskedGround, DesiredPose, Fence, HeightParameters
from hawk.model.poses import MapPoint, Ring, VehiclePose
from hawk.model.sentences import say
from hawk.model.sun import SunPosition
from hawk.runtime.process import WORKER_NICENESS, set_niceness
from hawk.runtime.supervision import Supervisor, end_tasks

if TYPE_CHECKING:  # their libraries take half of the time in which a daemon that starts in the air must act
    from hawk.algo.manager import AlgorithmManagerApp
    from hawk.algo.mapper.delta import MapDelta

T = TypeVar("T")
_LOG = logging.getLogger(__name__)

_CAMERA_RETRY_S = 0.2


@dataclass(frozen=True, slots=True)
class Situation:
    """Inputs of a frame beside picture and pose, at the time the worker takes it."""

    camera: CameraModel
    state: StateName
    desired: DesiredPose | None
    heights: HeightParameters
    fence: Fence | None
    home: MapPoint | None
    asked: DesiredPose | None = None
    asked_ground: AskedGround | None = None
    map_problem: str = ""
    ground: float = 0.0
    known: tuple[KnownLot, ...] = ()
    tours: tuple[LotTour, ...] = ()
    private: tuple[Ring, ...] = ()


Aim = Callable[[CameraModel, float, VehiclePose | None], tuple[CameraModel, str]]
"""Returns the camera as it was mounted at a time, and why nothing can be mapped by it, else ""."""


SunAt = Callable[[float, VehiclePose], SunPosition | None]
"""Returns where the sun stands at a time, over a vehicle; None where it is not known."""


def unknown_sun(_time: float, _pose: VehiclePose) -> None:
    """Return that nothing is known of the sun."""


def fixed_mount(camera: CameraModel, _time: float, _pose: VehiclePose | None) -> tuple[CameraModel, str]:
    """Return the camera as it is: its mount does not move."""
    return camera, ""


class AlgorithmLoop:
    """Owns the worker thread and the task that feeds it.

    Frames wait in one place only, the camera: while the worker is busy, its newest picture replaces the one before.
    """

    def __init__(
        self,
        manager: AlgorithmManagerApp,
        next_frame: Callable[[], Awaitable[CameraFrame]],
        pose_at: Callable[[float], VehiclePose | None],
        situation: Callable[[], Situation],
        topics: AlgorithmTopics,
        record: Callable[[FrameInput], None] = lambda _: None,
        supervisor: Supervisor | None = None,
        aim: Aim = fixed_mount,
        sun_at: SunAt = unknown_sun,
    ) -> None:
        """Take the parts; nothing runs before `start`.

        Args:
            manager: Runs on the worker thread.
            next_frame: Waits for a picture newer than the last one, see `DroneCamera.next_frame`.
            pose_at: Returns the vehicle's pose at a time (daemon's clock, seconds).
            situation: Asked on the loop for each frame.
            topics: Where results are published.
            record: Called on the loop with each frame that was processed.
            supervisor: Keeps the task running.
            aim: Turns the camera by its gimbal, see `hawk.comm.autopilot.gimbal.GimbalAttitudes.aim`.
            sun_at: Where the sun stands, see `hawk.comm.autopilot.telemetry.Telemetry.sun_at`.
        """
        self._manager = manager
        self._next_frame = next_frame
        self._pose_at = pose_at
        self._situation = situation
        self._topics = topics
        self._record = record
        self._supervisor = supervisor or Supervisor()
        self._aim = aim
        self._sun_at = sun_at
        self._executor = ThreadPoolExecutor(
            1, thread_name_prefix="hawk-vision", initializer=set_niceness, initargs=(WORKER_NICENESS,)
        )
        self._task: asyncio.Task[None] | None = None
        self._sequence = 0

    def start(self) -> None:
        """Begin to take frames."""
        if self._task is None:
            self._task = self._supervisor.start("algorithm worker", self._run)

    async def close(self) -> None:
        """Stop taking frames, let the present one finish, and end the worker thread."""
        task, self._task = self._task, None
        if task is not None:
            await end_tasks(task)
        self._executor.shutdown(wait=True, cancel_futures=True)

    async def changes_since(self, version: int) -> MapDelta:
        """Return the map's changes after a version (0: everything), between two frames."""
        return await self._on_worker(lambda: self._manager.mapper_app.changes_since(version))

    async def restore_map(self, deltas: Iterable[Mapping[str, bytes]], *, has_same_cars: bool = True) -> list[str]:
        """Restore the map of an earlier run, oldest delta first; return the parts that cannot be read, in words.

        ``has_same_cars``: the map is so young that its cars are still there.
        """
        kept = list(deltas)
        return await self._on_worker(lambda: self._manager.mapper_app.restore(kept, has_same_cars=has_same_cars))

    async def begin_survey(self, map_id: str) -> None:
        """Begin an empty map under another id, between two frames."""
        await self._on_worker(lambda: self._manager.begin_survey(map_id))

    async def _on_worker(self, work: Callable[[], T]) -> T:
        return await asyncio.get_running_loop().run_in_executor(self._executor, work)

    async def _run(self) -> None:
        while True:
            try:
                captured = await self._next_frame()
            except Exception as error:
                _LOG.exception("the camera failed")
                self._topics.vision_app_health.publish(
                    Health.bad(say("camera: {name}: {error}", name=type(error).__name__, error=str(error)))
                )
                await asyncio.sleep(_CAMERA_RETRY_S)
                continue
            try:
                await self._process(captured)
            except Exception as error:
                _LOG.exception("the algorithms failed on a frame")
                self._topics.vision_app_health.publish(
                    Health.bad(say("unexpected {name}: {error}", name=type(error).__name__, error=str(error)))
                )

    async def _process(self, captured: CameraFrame) -> None:
        frame = self._input(captured)
        output = await self._on_worker(lambda: self._manager.run(frame))
        self._topics.publish(output)
        recorded = frame if output.recorded_jpeg is None else replace(frame, jpeg=output.recorded_jpeg)
        if not recorded.jpeg and frame.jpeg:
            return
        try:
            self._record(recorded)
        except Exception:
            _LOG.exception("a frame could not be recorded")

    def _input(self, captured: CameraFrame) -> FrameInput:
        self._sequence += 1
        pose = self._pose_at(captured.captured)
        situation = self._situation()
        camera, aim_problem = self._aim(situation.camera, captured.captured, pose)
        return FrameInput(
            sequence=self._sequence,
            captured=captured.captured,
            jpeg=captured.jpeg,
            camera=camera,
            pose=None if pose is None else pose.map,
            speed=0.0 if pose is None else (pose.velocity[0] ** 2 + pose.velocity[1] ** 2) ** 0.5,
            state=situation.state,
            desired=situation.desired,
            heights=situation.heights,
            fence=situation.fence,
            home=situation.home,
            asked=situation.asked,
            asked_ground=situation.asked_ground,
            map_problem=situation.map_problem or aim_problem,
            ground=situation.ground,
            mount_problem=aim_problem,
            sun=None if pose is None else self._sun_at(captured.captured, pose),
            known=situation.known,
            tours=situation.tours,
            private=situation.private,
        )
