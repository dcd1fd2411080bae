"""The algorithms' part on the loop: takes camera frames, gives them to the worker thread, publishes what comes back."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, TypeVar

from hawk.algo.frame import FrameInput
from hawk.algo.topics import AlgorithmTopics
from hawk.model import (
    CameraModel,
    DesiredPose,
    Fence,
    Health,
    HeightParameters,
    MapPoint,
    StateName,
    VehiclePose,
)
from hawk.priority import WORKER_NICENESS, set_niceness

if TYPE_CHECKING:  # their libraries take half of the time in which a daemon that starts in the air must act
    from hawk.algo.manager import AlgorithmManagerApp
    from hawk.algo.mapper.delta import MapDelta

T = TypeVar("T")
_LOG = logging.getLogger(__name__)

_CAMERA_RETRY_S = 0.2


class CapturedFrame(Protocol):
    """A frame as the camera gives it; ``captured`` is seconds of the daemon's clock."""

    @property
    def jpeg(self) -> bytes:
        """The picture."""
        ...

    @property
    def captured(self) -> float:
        """When the light was caught."""
        ...


class FrameSource(Protocol):
    """The Drone Camera as it is used here."""

    async def next_frame(self) -> CapturedFrame:
        """Wait for the next frame."""
        ...


@dataclass(frozen=True, slots=True)
class Situation:
    """What the algorithms may know beside picture and pose, at the time a frame is taken up."""

    camera: CameraModel
    state: StateName
    desired: DesiredPose | None
    heights: HeightParameters
    fence: Fence | None
    home: MapPoint | None
    asked: DesiredPose | None = None


class AlgorithmLoop:
    """Owns the worker thread and the task that feeds it. The newest frame replaces the one that waits."""

    def __init__(
        self,
        manager: AlgorithmManagerApp,
        camera: FrameSource,
        pose_at: Callable[[float], VehiclePose | None],
        situation: Callable[[], Situation],
        topics: AlgorithmTopics,
        record: Callable[[FrameInput], None] = lambda _: None,
    ) -> None:
        """``record`` is given each frame that was processed, on the loop; ``situation`` is asked on the loop."""
        self._manager = manager
        self._camera = camera
        self._pose_at = pose_at
        self._situation = situation
        self._topics = topics
        self._record = record
        self._executor = ThreadPoolExecutor(
            1, thread_name_prefix="hawk-vision", initializer=set_niceness, initargs=(WORKER_NICENESS,)
        )
        self._waiting: CapturedFrame | None = None
        self._arrived = asyncio.Event()
        self._tasks: list[asyncio.Task[None]] = []
        self._sequence = 0
        self.dropped = 0
        """Frames that were replaced before the worker was free."""

    def start(self) -> None:
        """Begin to take frames."""
        if not self._tasks:
            self._tasks = [
                asyncio.create_task(self._receive(), name="algorithm frames"),
                asyncio.create_task(self._work(), name="algorithm worker"),
            ]

    async def close(self) -> None:
        """Stop taking frames, let the one being worked on finish, and end the worker thread."""
        for task in self._tasks:
            task.cancel()
        for task in self._tasks:
            with contextlib.suppress(asyncio.CancelledError):
                await task
        self._tasks = []
        self._executor.shutdown(wait=True, cancel_futures=True)

    async def changes_since(self, version: int) -> MapDelta:
        """Return what changed in the map after a version (0: everything), between two frames."""
        return await self._on_worker(lambda: self._manager.mapper_app.changes_since(version))

    async def restore_map(self, deltas: Iterable[Mapping[str, bytes]]) -> list[str]:
        """Take up the map of an earlier run, oldest delta first; return what could not be read, in words."""
        kept = list(deltas)
        return await self._on_worker(lambda: self._manager.mapper_app.restore(kept))

    async def start_map_anew(self, map_id: str) -> None:
        """Forget the map: a new survey."""
        await self._on_worker(lambda: self._manager.mapper_app.start_anew(map_id))

    async def _on_worker(self, work: Callable[[], T]) -> T:
        return await asyncio.get_running_loop().run_in_executor(self._executor, work)

    async def _receive(self) -> None:
        while True:
            try:
                frame = await self._camera.next_frame()
            except Exception as error:
                _LOG.exception("the camera failed")
                self._topics.vision_app_health.publish(Health.bad(f"camera: {type(error).__name__}: {error}"))
                await asyncio.sleep(_CAMERA_RETRY_S)
                continue
            if self._waiting is not None:
                self.dropped += 1
            self._waiting = frame
            self._arrived.set()

    async def _work(self) -> None:
        while True:
            await self._arrived.wait()
            self._arrived.clear()
            captured, self._waiting = self._waiting, None
            if captured is None:
                continue
            try:
                await self._process(captured)
            except Exception as error:
                _LOG.exception("the algorithms failed on a frame")
                self._topics.vision_app_health.publish(Health.bad(f"unexpected {type(error).__name__}: {error}"))

    async def _process(self, captured: CapturedFrame) -> None:
        frame = self._input(captured)
        output = await self._on_worker(lambda: self._manager.run(frame))
        self._topics.publish(output)
        try:
            self._record(frame)
        except Exception:
            _LOG.exception("a frame could not be recorded")

    def _input(self, captured: CapturedFrame) -> FrameInput:
        self._sequence += 1
        pose = self._pose_at(captured.captured)
        situation = self._situation()
        return FrameInput(
            sequence=self._sequence,
            captured=captured.captured,
            jpeg=captured.jpeg,
            camera=situation.camera,
            pose=None if pose is None else pose.map,
            speed=0.0 if pose is None else (pose.velocity[0] ** 2 + pose.velocity[1] ** 2) ** 0.5,
            state=situation.state,
            desired=situation.desired,
            heights=situation.heights,
            fence=situation.fence,
            home=situation.home,
            asked=situation.asked,
        )
