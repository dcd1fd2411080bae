"""Vision, mapper and planner once more over a recording's pictures, beside the map that the recording holds.

A recording holds no whole map, but the stalls as the page showed them, as GeoJSON about every five seconds
(`hawk.daemon.recording_parts.FlightViews`). Each stands before the frame that made it: the daemon publishes a result
before it records its input. So each recorded map has one that is made again after the same frame.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

from hawk.algo.frame import AlgoError, FrameInput
from hawk.algo.manager import AlgorithmManagerApp, Perception
from hawk.algo.mapper.app import MapperApp
from hawk.algo.path_plan.app import PathPlanApp
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.algo.topic_interface import AlgorithmTopicInterface, FrameCamera
from hawk.algo.vision.app import VisionApp, VisionSettings
from hawk.algo.vision.camera_check import CameraCheck
from hawk.algo.vision.network_file import VisionModelError, network_name
from hawk.config.sections import Config
from hawk.ddc.recorder import TICK
from hawk.model.lot_map import OccupancyMap
from hawk.model.plans import PathPlan
from hawk.model.poses import GlobalPose
from hawk.replay.flight import Maker, Origin, RecordedFlight, ReplayError, in_a_line
from hawk.results.survey_map import recorded_geojson
from hawk.store.frame_codec import FRAME_INPUT, FrameFormatError, to_json
from hawk.store.replay import STALLS_ON_EARTH, Recorded, RecordingError, text_of_geojson

_SIGHT: Final = b'"sight":{'
_KEPT: Final = ("known", "tours", "fence", "asked_ground")
"""Fields of a frame that last over frames: the mapper takes another object for another plan."""


@dataclass(frozen=True, slots=True)
class Shown:
    """A map as it was recorded and as it is made again, both as `recorded_geojson` writes them.

    ``at``: seconds of the recording's clock.
    """

    at: float
    recorded: str = field(repr=False)
    again: str = field(repr=False)

    @property
    def is_equal(self) -> bool:
        """True when both are equal, byte for byte."""
        return self.recorded == self.again


@dataclass(frozen=True, slots=True)
class Processed:
    """Outcome of a recording that was processed again.

    ``frames`` were processed, ``failed`` of them made vision, mapper or planner fail (``failure``: the first reason),
    ``missing`` lack in the recording. ``compared`` maps were recorded, ``equal`` of them are equal byte for byte;
    ``last`` is the last one, None where none was recorded. Of ``planned`` plans that a tick recorded, ``planned_equal``
    are equal. ``earlier``: ids of stalls that the flight began with, of
    which the recording holds no pictures. ``took_s``: seconds of this computer, ``seconds`` of the flight.
    """

    frames: int
    failed: int
    failure: str
    missing: int
    compared: int
    equal: int
    planned: int
    planned_equal: int
    last: Shown | None
    earlier: frozenset[int]
    final: OccupancyMap = field(repr=False)
    datum: GlobalPose | None
    seconds: float
    took_s: float


class Again:
    """Vision, mapper and planner by the settings of a flight, with an empty map."""

    def __init__(self, config: Config, version: str, model: Path | None = None) -> None:
        """Load the network: ``model``, or the one that the settings name. Raises ReplayError."""
        self._asked = model
        self._settings = VisionSettings(
            model=model or config.vision.model,
            engine=config.vision.engine,
            threads=config.vision.threads,
            minimum_height_m=config.vision.minimum_height_m,
            minimum_stalls=config.vision.minimum_stalls,
        )
        self._planning = PathPlanSettings(
            cm_per_pixel=config.flight.explore_cm_per_pixel, exposure_s=config.camera.exposure_s
        )
        try:
            self._vision = VisionApp(self._settings)
        except VisionModelError as error:
            raise ReplayError(self._words(str(error))) from error
        self.maker = Maker(version, network_name(self._settings.model))
        self._topics = AlgorithmTopicInterface()
        self._begin()

    def look(self, frame: FrameInput) -> Perception:
        """See a frame's picture; a thread may look at the next one while another goes on with the one before."""
        return self._manager.look(frame)

    def go_on(self, frame: FrameInput, looked: Perception) -> None:
        """Map and plan. Raises AlgoError when vision, mapper or planner failed; the others did their work."""
        self._manager.go_on(frame, looked)

    def begin_survey(self) -> None:
        """Begin an empty map, as the daemon does for another survey."""
        self._manager.begin_survey("again")

    def is_high(self, frame: FrameInput) -> bool:
        """Return True for a frame that is taken so high that it is mapped."""
        pose = frame.over_ground
        return pose is not None and pose.height >= self._settings.minimum_height_m

    @property
    def plan(self) -> PathPlan:
        """The plan after the last frame."""
        return self._topics.local_pos_pub.value

    @property
    def map(self) -> OccupancyMap:
        """The map after the last frame."""
        return self._topics.occupancy_map_pub.value

    def _begin(self) -> None:
        self._manager = AlgorithmManagerApp(camera_check=CameraCheck(self._settings.minimum_height_m))
        camera = FrameCamera(self._topics)
        self._manager.init(self._topics, self._vision, MapperApp(map_id="again"), PathPlanApp(self._planning), camera)

    def _words(self, reason: str) -> str:
        if self._asked is not None:
            return f"{reason.replace('vision.model', '--model', 1)}; name a network as vision.model has it"
        if self._settings.model is not None:
            return f"the recording's settings: {reason}; or give that network by --model FILE"
        return reason


class _Frames:
    """Gives the frames of messages, and counts those that lack."""

    def __init__(self) -> None:
        self._kept: dict[str, Any] = {}
        self._sequence: int | None = None
        self.missing = 0

    def of(self, message: Recorded) -> FrameInput:
        """Return a message's frame, with the same object for what has not changed. Raises ReplayError."""
        try:
            frame = message.frame(FrameInput)
        except FrameFormatError as error:
            raise ReplayError(f"the picture at {message.time:.2f} s cannot be read: {in_a_line(error)}") from error
        if self._sequence is not None:
            self.missing += max(0, frame.sequence - self._sequence - 1)
        self._sequence = frame.sequence
        for name in _KEPT:
            if getattr(frame, name) != self._kept.get(name):
                self._kept[name] = getattr(frame, name)
        return replace(frame, **self._kept)


class _Maps:
    """Follows the recorded maps beside those that are made again."""

    def __init__(self) -> None:
        self.compared = self.equal = 0
        self.last: Shown | None = None
        self.earlier: frozenset[int] = frozenset()
        self._before: frozenset[int] = frozenset()

    def begins_another(self, recorded: str) -> bool:
        """Return True for the empty map of another survey."""
        return bool(self._before) and not _looks(recorded)

    def compare(self, at: float, recorded: str, made: str, frames: int) -> None:
        """Compare a recorded map with the one that was made; ``frames`` were mapped so far."""
        self.last = Shown(at, recorded, made)
        looks = _looks(recorded)
        if not looks or (not self._before and max(looks.values()) > frames):
            self.earlier = frozenset(looks)  # no stall is looked at by more frames than there were
        self._before = frozenset(looks)
        self.compared += 1
        self.equal += self.last.is_equal


@dataclass(frozen=True, slots=True)
class _Step:
    """A frame that is looked at, and the map that was recorded with it, with its time; None: none was."""

    frame: FrameInput
    looked: Future[Perception]
    recorded: tuple[float, str] | None
    datum: GlobalPose | None


class _Run:
    """Takes the messages of one recording: a thread looks at a frame while the one before is mapped."""

    def __init__(self, again: Again, looking: Executor, show: Callable[[int], None]) -> None:
        self._again, self._looking, self._show = again, looking, show
        self.origin, self.inputs, self.maps = Origin(), _Frames(), _Maps()
        self.frames = self.failed = self._mapped = 0
        self.failure = ""
        self.planned = self.planned_equal = 0
        self._recorded: tuple[float, str] | None = None
        self._plan: Any = None
        self._step: _Step | None = None

    def take(self, message: Recorded) -> bool:
        """Take a message; return True for a frame. Raises ReplayError, RecordingError for one that cannot be read."""
        self.origin.look(message)
        if message.topic == STALLS_ON_EARTH:
            self._recorded = message.time, text_of_geojson(message.data)
        if message.topic == TICK and self._step is not None and self._plan is None and _SIGHT in message.data:
            self._plan = _plan_of(message)
        if message.topic != FRAME_INPUT:
            return False
        frame = self.inputs.of(message)
        looked = self._looking.submit(self._again.look, frame)
        self.finish(_Step(frame, looked, self._recorded, self.origin.datum))
        self._recorded = None
        return True

    def finish(self, following: _Step | None = None) -> None:
        """Map and plan the frame that was looked at; ``following`` is looked at meanwhile. Raises ReplayError."""
        step, self._step = self._step, following
        plan, self._plan = self._plan, None
        if step is None:
            return
        frame, recorded = step.frame, step.recorded
        if recorded is not None and self.maps.begins_another(recorded[1]):
            self._again.begin_survey()
        self.frames += 1
        self._mapped += frame.pose is not None and not frame.map_problem and self._again.is_high(frame)
        try:
            self._again.go_on(frame, step.looked.result())
        except AlgoError as error:
            self.failed, self.failure = self.failed + 1, self.failure or str(error)
        if recorded is not None and step.datum is not None:
            self.maps.compare(*recorded, _geojson(step.datum, self._again.map), self._mapped)
        if plan is not None:
            self.planned += 1
            self.planned_equal += plan == json.loads(to_json(self._again.plan))
        self._show(self.frames)


def _plan_of(tick: Recorded) -> Any:
    """Return the plan among a tick's facts, None where it has none. Raises ReplayError.

    The first tick behind a frame knows the plan of that frame: the loop publishes it and records the frame at once.
    """
    try:
        return tick.payload()["facts"]["sight"]["plan"]
    except (RecordingError, LookupError, TypeError) as error:
        raise ReplayError(f"the plan at {tick.time:.2f} s cannot be read: {error!r}") from error


def _geojson(datum: GlobalPose, made: OccupancyMap) -> str:
    """Return the stalls as a recording has them (`hawk.store.views`)."""
    return recorded_geojson(datum, made.stalls)


def process(flight: RecordedFlight, again: Again, show: Callable[[int], None] = lambda _: None) -> Processed:
    """Process a recording's pictures again, up to its damage.

    ``show`` is called with the number of frames after each. Raises ReplayError for a recording without pictures, or
    with pictures of a version that cannot be read.
    """
    began = time.perf_counter()
    with ThreadPoolExecutor(1, "looking") as looking:
        run = _Run(again, looking, show)
        flight.follow(run.take)
        run.finish()
    if run.frames == 0:
        cut = f" ({flight.damage})" if flight.damage else ""
        raise ReplayError(f"{flight.path}: holds no pictures{cut}; name the recording of a flight with a camera")
    maps = run.maps
    return Processed(
        run.frames, run.failed, run.failure, run.inputs.missing, maps.compared, maps.equal, run.planned,
        run.planned_equal, maps.last, maps.earlier,
        again.map, run.origin.datum, flight.seconds, time.perf_counter() - began,
    )  # fmt: skip


def _looks(recorded: str) -> Mapping[int, int]:
    """Return by id how many frames a recorded map's stalls were seen in. Raises ReplayError."""
    try:
        return {int(each["id"]): int(each["properties"]["seen"]) for each in json.loads(recorded)["features"]}
    except (ValueError, LookupError, TypeError) as error:
        raise ReplayError(f"a recorded map is of another version: {error!r}") from error
