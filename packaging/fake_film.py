"""The recording of a flight over the made-up lot of ``packaging/fake_drone.py``, by the recorder's own writer."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict
from datetime import timedelta
from itertools import pairwise
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from fake_lot import DATUM, FIELD_M, FLOWN, FakeStall, Picture, draw_ground, to_pixel

from hawk.algo.frame import FrameInput
from hawk.config.sections import Config
from hawk.daemon.recording_parts import json_schemas
from hawk.model.known_lot import KnownLot, KnownStall
from hawk.model.lot_map import Stall, StallState
from hawk.model.operation import StateName
from hawk.model.pictures import CameraModel
from hawk.model.plans import Fence, HeightParameters
from hawk.model.poses import MapPoint, MapPose, VehiclePose
from hawk.model.sentences import Sentence, say
from hawk.store.frame_codec import FRAME_INPUT, MapStalls
from hawk.store.recording_file import RecordingFile, start_metadata
from hawk.store.replay import ZERO_UTC
from hawk.store.ring_buffer import Item

LEGS = ((-38, -12), (-34, 22), (-12, 30), (-8, -34), (12, -38), (16, 24), (34, 14), (32, -20), (-38, -12))
SPEED_M_S, CLIMB_M_S, HEIGHT_M = 4.0, 2.5, 35.0
TICK_S, FRAME_S, MAP_S = 0.5, 2.0, 5.0
BEGIN_S = 10.0
"""Of the drone's clock."""
CAMERA = CameraModel(480, 270, 336.0, 336.0, 239.5, 134.5)
FENCE = ((62.0, -60.0), (62.0, 64.0), (-20.0, 64.0), (-62.0, 30.0), (-62.0, -30.0), (-30.0, -60.0))
NS = 1_000_000_000
Place = tuple[float, float, float, float]
"""North, east, height, yaw."""


def record(folder: Path, stalls: list[FakeStall]) -> None:
    """Write the recording of the newest survey of `fake_lot.FLOWN`, unless it is there."""
    folder.mkdir(parents=True, exist_ok=True)
    began = FLOWN[-1] - timedelta(seconds=60)
    path = folder / f"{began:%Y%m%dT%H%M%SZ}.mcap"
    if path.exists():
        return
    about = {
        "version": "0.4.0", "network": "made up", "configuration": Config().model_dump_json(),
        "survey": f"{len(FLOWN):06d}-{FLOWN[-1]:%Y%m%dT%H%M%SZ}",
        ZERO_UTC: (began - timedelta(seconds=BEGIN_S)).isoformat(),
    }  # fmt: skip
    file = RecordingFile(path.open("wb"), start_metadata(about, began, BEGIN_S), json_schemas)
    for item in Flight(stalls).items():
        file.write(item)
    file.close()


class Flight:
    """Flight over all legs, as it is recorded."""

    def __init__(self, stalls: list[FakeStall]) -> None:
        self._stalls = [each.stall for each in stalls]
        self._ground, _ = draw_ground(stalls, np.random.default_rng(4))
        self._seen: dict[int, Stall] = {}
        self._known = KnownLot("lot", tuple(_known(each) for each in self._stalls), ())
        self._path = list(_path())

    def items(self) -> Iterator[Item]:
        """Give the recorder's items by time."""
        starts = dict(self._said())
        for number, (north, east, height, yaw) in enumerate(self._path):
            now = BEGIN_S + TICK_S * number
            footprint = _footprint(north, east, height, yaw)
            self._see(footprint)
            if number in starts:
                state, words = starts[number]
                yield _item("decision", {"acts": [{"act": "EnterState", "name": state}], "fault": ""}, "json", now)
                yield _item("message", _message(words), "json", now)
            yield _item("tick", {"number": number, "facts": self._facts(number, footprint)}, "json", now)
            if number % round(MAP_S / TICK_S) == 0:
                yield _item("", MapStalls(DATUM, dict(self._seen)), "view", now)
            if number % round(FRAME_S / TICK_S) == 0:
                yield _item(FRAME_INPUT, self._frame(number, now, footprint), "frame", now)

    def _said(self) -> Iterator[tuple[int, tuple[str, Sentence]]]:
        """Give the tick at which a state begins, the state, and what is said."""
        climb = round(HEIGHT_M / CLIMB_M_S / TICK_S)
        last = len(self._path) - climb
        yield 0, (StateName.TAKEOFF, say("Took off."))
        yield climb, (StateName.HOVER, say("Holding at {height}.", height="35 m"))
        yield climb + 6, (StateName.AUTONOMOUS_EXPLORE, say("Lot found. Exploring."))
        yield last - 20, (StateName.RETURN_TO_LAUNCH, say("It was seen whole."))
        yield last, (StateName.LAND, say("Landing."))
        yield len(self._path) - 1, (StateName.IDLE, say("Landed. Motors off."))

    def _see(self, footprint: list[MapPoint]) -> None:
        outline = np.array([(each.north, each.east) for each in footprint], np.float32)
        for stall in self._stalls:
            if cv2.pointPolygonTest(outline, (stall.north, stall.east), measureDist=False) > 0:
                self._seen[stall.id] = stall

    def _facts(self, number: int, footprint: list[MapPoint]) -> dict[str, Any]:
        north, east, height, yaw = self._path[number]
        place = MapPose(north, east, height, 0.0, 0.0, yaw)
        now = BEGIN_S + TICK_S * number
        pose = VehiclePose(now, DATUM, height, None, place, (0.0, 0.0, 0.0), 0.0, 0.0, yaw)
        states = [each.state for each in self._seen.values()]
        counts = {state.value: states.count(state) for state in (StallState.FREE, StallState.TAKEN, StallState.UNKNOWN)}
        charge = 96 - 40 * number / len(self._path)
        return {
            "position": {"pose": asdict(pose), "datum": asdict(DATUM), "home": {"north": -38.0, "east": -12.0}},
            "battery": {"info": {"percentage": charge}, "reserve": {"time_left": 9.0 * charge}},
            "sight": {"counts": counts, "footprint": [{"north": p.north, "east": p.east} for p in footprint]},
            "limits": {"fence": {"polygon": FENCE}},
        }

    def _frame(self, number: int, now: float, footprint: list[MapPoint]) -> FrameInput:
        north, east, height, yaw = self._path[number]
        return FrameInput(
            number, now, _picture(self._ground, footprint), CAMERA, MapPose(north, east, height, 0.0, 0.0, yaw),
            SPEED_M_S, StateName.AUTONOMOUS_EXPLORE, None, HeightParameters(), Fence(FENCE, FENCE, 120.0, 120.0),
            MapPoint(-38.0, -12.0), known=(self._known,),
        )  # fmt: skip


def _path() -> Iterator[Place]:
    """Give the drone's place at each tick: up, along the legs, and down."""
    north, east = LEGS[0]
    steps = round(HEIGHT_M / CLIMB_M_S / TICK_S)
    for step in range(steps):
        yield north, east, HEIGHT_M * step / steps, 0.4
    for here, there in pairwise(LEGS):
        yaw = math.atan2(there[1] - here[1], there[0] - here[0])
        count = round(math.dist(here, there) / SPEED_M_S / TICK_S)
        for step in range(count):
            share = step / count
            yield here[0] + share * (there[0] - here[0]), here[1] + share * (there[1] - here[1]), HEIGHT_M, yaw
    for step in range(steps + 1):
        yield north, east, HEIGHT_M * (1 - step / steps), 0.4


def _footprint(north: float, east: float, height: float, yaw: float) -> list[MapPoint]:
    scale = max(height, 3.0) / HEIGHT_M
    found = []
    for a, b in ((1, -1), (1, 1), (-1, 1), (-1, -1)):
        up, right = a * FIELD_M[1] / 2 * scale, b * FIELD_M[0] / 2 * scale
        found.append(
            MapPoint(
                north + up * math.cos(yaw) - right * math.sin(yaw), east + up * math.sin(yaw) + right * math.cos(yaw)
            )
        )
    return found


def _picture(ground: Picture, footprint: list[MapPoint]) -> bytes:
    corners = np.array([to_pixel(p.north, p.east) for p in footprint], np.float32)
    size = (CAMERA.width, CAMERA.height)
    onto = np.array([(0, 0), (size[0], 0), size, (0, size[1])], np.float32)
    view = cv2.warpPerspective(ground, cv2.getPerspectiveTransform(corners, onto), size, borderMode=cv2.BORDER_REFLECT)
    return cv2.imencode(".jpg", view, [cv2.IMWRITE_JPEG_QUALITY, 70])[1].tobytes()


def _known(stall: Stall) -> KnownStall:
    return KnownStall(str(stall.id), stall.north, stall.east, stall.angle, stall.width, stall.length)


def _message(words: Sentence) -> dict[str, Any]:
    sentences = [{"text": str(words), "code": words.code, "values": dict(words.values)}]
    return {"number": 1, "time": "", "level": "ok", "text": str(words), "details": "", "sentences": sentences}


def _item(topic: str, payload: Any, kind: Any, now: float) -> Item:
    return Item(topic, payload, kind, round(now * NS), 1)
