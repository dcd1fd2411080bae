"""Small recordings of a flight over a few stalls, written by the recording's own writer, and vision that sees them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, cast

import cv2
import numpy as np

from hawk.algo.frame import AlgoError, FrameInput
from hawk.config.sections import Config
from hawk.daemon.recording_parts import json_schemas
from hawk.model.known_lot import KnownLot
from hawk.model.lot_map import OccupancyMap, Stall, StallState
from hawk.model.operation import StateName
from hawk.model.pictures import CameraModel
from hawk.model.plans import HeightParameters, PathPlan
from hawk.model.poses import GlobalPose, MapPose, VehiclePose
from hawk.replay.process import Again
from hawk.store.frame_codec import FRAME_INPUT, MapStalls
from hawk.store.recording_file import RecordingFile, start_metadata
from hawk.store.ring_buffer import Item

DATUM = GlobalPose(52.0, 5.0, 40.0)
CAMERA = CameraModel(64, 36, 46.0, 46.0, 31.5, 17.5)
S = 1_000_000_000
KNOWN = KnownLot("lot", (), ())


def jpeg(grey: int = 100) -> bytes:
    done, data = cv2.imencode(".jpg", np.full((CAMERA.height, CAMERA.width, 3), grey, np.uint8))
    assert done
    return bytes(data)


def frame(number: int, **changes: Any) -> FrameInput:
    values: dict[str, Any] = {
        "sequence": number,
        "captured": 10.0 + number,
        "jpeg": jpeg(),
        "camera": CAMERA,
        "pose": MapPose(float(number), 2.0 * number, 20.0, 0.0, 0.1, 0.5),
        "speed": 1.0,
        "state": StateName.AUTONOMOUS_EXPLORE,
        "desired": None,
        "heights": HeightParameters(),
        "fence": None,
        "home": None,
    }
    return FrameInput(**{**values, **changes})


def stall(number: int, **changes: Any) -> Stall:
    """Return a stall of a row, 2.5 m beside the one before."""
    plain = Stall(number, 2.5 * number, 0.0, 0.1, 2.5, 5.0, 0.9, StallState.TAKEN, 0.95, 1, 11.0, 1)
    return replace(plain, **changes)


def stalls(count: int, **changes: Any) -> dict[int, Stall]:
    return {number: stall(number, **changes) for number in range(1, count + 1)}


def tick(now: float, plan: PathPlan | None = None) -> Item:
    pose = VehiclePose(now, DATUM, 20.0, None, MapPose(0.0, 0.0, 20.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0, 0.0, 0.0)
    pose = replace(pose, global_=replace(DATUM, altitude=60.0))
    facts: dict[str, Any] = {"position": {"pose": asdict(pose), "datum": asdict(DATUM)}}
    if plan is not None:
        facts["sight"] = {"lot": True, "plan": plan}
    return Item("tick", {"number": 1, "facts": facts}, "json", round(now * S), 1)


def recorded_frame(one: FrameInput, now: float) -> Item:
    return Item(FRAME_INPUT, one, "frame", round(now * S), 1)


def recorded_map(shown: dict[int, Stall], now: float) -> Item:
    return Item("", MapStalls(DATUM, shown), "view", round(now * S), 1)


def flight(frames: int = 4, shown: int = 3) -> list[Item]:
    """Return a tick, and frames with a map before each, of as many stalls as there are frames up to ``shown``."""
    items = [tick(10.5)]
    for number in range(1, frames + 1):
        items.append(recorded_map(stalls(min(number, shown)), 10.9 + number))
        items.append(recorded_frame(frame(number), 11.0 + number))
    return items


def write(path: Path, items: Sequence[Item], *, is_closed: bool = True, **metadata: str) -> Path:
    about = {"version": "0.2.9", "network": "0123abcd", "configuration": Config().model_dump_json(), **metadata}
    head = {**start_metadata(about, datetime(2026, 5, 4, tzinfo=UTC), 10.0), **metadata}
    file = RecordingFile(path.open("wb"), head, json_schemas)
    for item in items:
        file.write(item)
    if is_closed:
        file.close()
    else:
        file.abandon()
    return path


class FakeAgain:
    """Vision that finds one stall more with every frame, up to ``most``."""

    def __init__(self, most: int = 3, **changes: Any) -> None:
        self.frames: list[FrameInput] = []
        self.begun = 0
        self._most, self._changes = most, changes
        self._since = 0

    def look(self, one: FrameInput) -> FrameInput:
        return one

    def go_on(self, one: FrameInput, looked: FrameInput) -> None:
        assert looked is one
        self.frames.append(one)
        if one.map_problem:
            raise AlgoError(one.map_problem)

    def begin_survey(self) -> None:
        self.begun += 1
        self._since = len(self.frames)

    def is_high(self, one: FrameInput) -> bool:
        return one.pose is not None and one.pose.height > 6.0

    @property
    def plan(self) -> PathPlan:
        return PathPlan(height=20.0 + len(self.frames))

    @property
    def map(self) -> OccupancyMap:
        found = stalls(min(len(self.frames) - self._since, self._most), **self._changes)
        return OccupancyMap(stalls=found)


def fake(most: int = 3, **changes: Any) -> tuple[Again, FakeAgain]:
    """Return the same object twice: as the program takes it, and as a test looks at it."""
    again = FakeAgain(most, **changes)
    return cast("Again", again), again


def plain(text: str) -> Any:
    return json.loads(text)
