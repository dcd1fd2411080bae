"""Vision, mapper and planner once more over a recording's pictures, beside the map that the recording holds.

A recording holds no whole map, but the stalls as the page showed them, as GeoJSON about every five seconds
(`hawk.daemon.recording_parts.FlightViews`). Each stands before the frame that made it: the daemon publishes a result
before it records its input. So each recorded map has one that is made again after the same frame.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

from hawk.algo.frame import AlgoError, FrameInput
from hawk.algo.manager import AlgorithmManagerApp
from hawk.algo.mapper.app import MapperApp
from hawk.algo.path_plan.app import PathPlanApp
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.algo.topic_interface import AlgorithmTopicInterface, FrameCamera
from hawk.algo.vision.app import VisionApp, VisionSettings
from hawk.algo.vision.camera_check import CameraCheck
from hawk.algo.vision.named import network_name
from hawk.algo.vision.network import VisionModelError
from hawk.config.sections import Config
from hawk.model.lot_map import OccupancyMap
from hawk.model.poses import GlobalPose
from hawk.replay.flight import Maker, Origin, RecordedFlight, ReplayError, in_a_line
from hawk.results.survey_map import stalls_geojson
from hawk.store.frame_codec import FRAME_INPUT, FrameFormatError
from hawk.store.replay import Recorded, text_of_geojson

STALLS_ON_EARTH: Final = "stalls_on_earth"
"""Topic of the recorded stalls (`hawk.store.views`)."""
_KEPT: Final = ("known", "tour", "fence", "asked_ground")
"""Fields of a frame that last over frames: the mapper takes another object for another plan."""


@dataclass(frozen=True, slots=True)
class Shown:
    """A map as it was recorded and as it is made again, both as `stalls_geojson` writes them.

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
    ``last`` is the last one, None where none was recorded. ``earlier``: ids of stalls that the flight began with, of
    which the recording holds no pictures. ``took_s``: seconds of this computer, ``seconds`` of the flight.
    """

    frames: int
    failed: int
    failure: str
    missing: int
    compared: int
    equal: int
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

    def frame(self, frame: FrameInput) -> None:
        """Process a frame. Raises AlgoError when vision, mapper or planner fails on it; the others did their work."""
        self._topics.begin(frame)
        self._manager.process()

    def begin_survey(self) -> None:
        """Begin an empty map, as the daemon does for another survey."""
        self._manager.begin_survey("again")

    def is_high(self, frame: FrameInput) -> bool:
        """Return True for a frame that is taken so high that it is mapped."""
        pose = frame.over_ground
        return pose is not None and pose.height >= self._settings.minimum_height_m

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
            return reason.replace("vision.model", "--model", 1)
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
        self._waiting: Recorded | None = None
        self._before: frozenset[int] = frozenset()

    def look(self, message: Recorded) -> None:
        """Take a recorded map: it waits for its frame."""
        self._waiting = message

    def begins_another(self) -> bool:
        """Return True when the recorded map that waits is the empty one of another survey."""
        return self._waiting is not None and bool(self._before) and not _looks(text_of_geojson(self._waiting.data))

    def compare(self, made: OccupancyMap, datum: GlobalPose | None, frames: int) -> None:
        """Compare the recorded map that waits, if one does, with the present one; ``frames`` were mapped so far."""
        waiting, self._waiting = self._waiting, None
        if waiting is None or datum is None:
            return
        recorded = text_of_geojson(waiting.data)
        labels = {key: stall.label for key, stall in made.stalls.items() if stall.label}
        self.last = Shown(waiting.time, recorded, stalls_geojson(datum, made.stalls, labels=labels))
        looks = _looks(recorded)
        if not looks or (not self._before and max(looks.values()) > frames):
            self.earlier = frozenset(looks)  # no stall is looked at by more frames than there were
        self._before = frozenset(looks)
        self.compared += 1
        self.equal += self.last.is_equal


class _Run:
    """Takes the messages of one recording."""

    def __init__(self, again: Again, show: Callable[[int], None]) -> None:
        self._again, self._show = again, show
        self.origin, self.inputs, self.maps = Origin(), _Frames(), _Maps()
        self.frames = self.failed = self._mapped = 0
        self.failure = ""

    def take(self, message: Recorded) -> bool:
        """Take a message; return True for a frame. Raises ReplayError, RecordingError for one that cannot be read."""
        self.origin.look(message)
        if message.topic == STALLS_ON_EARTH:
            self.maps.look(message)
        if message.topic != FRAME_INPUT:
            return False
        frame = self.inputs.of(message)
        if self.maps.begins_another():
            self._again.begin_survey()
        self.frames += 1
        self._mapped += frame.pose is not None and not frame.map_problem and self._again.is_high(frame)
        try:
            self._again.frame(frame)
        except AlgoError as error:
            self.failed, self.failure = self.failed + 1, self.failure or str(error)
        self.maps.compare(self._again.map, self.origin.datum, self._mapped)
        self._show(self.frames)
        return True


def process(flight: RecordedFlight, again: Again, show: Callable[[int], None] = lambda _: None) -> Processed:
    """Process a recording's pictures again, up to its damage.

    ``show`` is called with the number of frames after each. Raises ReplayError for a recording without pictures, or
    with pictures of a version that cannot be read.
    """
    began = time.perf_counter()
    run = _Run(again, show)
    flight.follow(run.take)
    if run.frames == 0:
        cut = f" ({flight.damage})" if flight.damage else ""
        raise ReplayError(f"{flight.path}: holds no pictures{cut}; name the recording of a flight with a camera")
    maps = run.maps
    return Processed(
        run.frames, run.failed, run.failure, run.inputs.missing, maps.compared, maps.equal, maps.last, maps.earlier,
        again.map, run.origin.datum, flight.seconds, time.perf_counter() - began,
    )  # fmt: skip


def _looks(recorded: str) -> Mapping[int, int]:
    """Return by id how many frames a recorded map's stalls were seen in. Raises ReplayError."""
    try:
        return {int(each["id"]): int(each["properties"]["seen"]) for each in json.loads(recorded)["features"]}
    except (ValueError, LookupError, TypeError) as error:
        raise ReplayError(f"a recorded map is of another version: {error!r}") from error
