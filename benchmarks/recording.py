"""Cost of recording a flight: the share of a core at 20 ticks and 10 pictures a second.

Ticks, pictures of 1280 x 720 pixels, poses, messages and a map of 300 stalls go through the daemon's recorder and
recording into a file, as fast as the disk takes them; the processor time of all threads counts, less that of making
the values.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np

from benchmarks.frames import encoded, frame_of
from hawk.algo.frame import FrameInput
from hawk.config.sections import StoreSettings
from hawk.daemon.recording_parts import json_schemas
from hawk.ddc.acts import Acts, Ask, ReadParameter, SendTarget
from hawk.ddc.decider import Decider, Decision
from hawk.ddc.facts import Facts
from hawk.ddc.memory import remember
from hawk.ddc.motion import Goal
from hawk.ddc.recorder import Recorder
from hawk.ddc.rules.kill import KillTokens
from hawk.ddc.settings import DdcSettings
from hawk.model.lot_map import Stall, StallState
from hawk.model.operation import Health
from hawk.model.pictures import CameraModel
from hawk.model.plans import Fence
from hawk.model.poses import GlobalPose, MapPoint, MapPose, VehiclePose
from hawk.store.frame_codec import MapStalls, View, Words
from hawk.store.recording import Recording

SECONDS: Final = 60
TICKS_S: Final = 20
PICTURES_S: Final = 10
STALLS: Final = 300
PART_S: Final = 5
"""The file is waited for after each such part, so that the queue drops nothing."""
_DATUM: Final = GlobalPose(52.0, 5.0, 0.0)
_PARTS: Final = ("link", "position", "camera", "vision", "mapper", "planner", "recording", "tasks", "loop", "home")
Take = Callable[[Any], None]


@dataclass(frozen=True, slots=True)
class Recorded:
    """Share of a core (1: a whole one), bytes a second of the flight, and messages that were lost."""

    cpu: float
    bytes_s: float
    lost: int


def _pose(now: float) -> VehiclePose:
    place = MapPose(now * 3, now, 30.0, 0.01, 0.02, now % 3)
    return VehiclePose(
        now, GlobalPose(52.0 + now * 1e-5, 5.0, 30.0), 30.0, None, place, (3.0, 1.0, 0.0), 0.01, 0.02, now % 3
    )


def _frame(now: float, number: int, jpeg: bytes) -> FrameInput:
    corners = tuple((100.0 * np.cos(angle), 100.0 * np.sin(angle)) for angle in np.linspace(0, 6, 12).tolist())
    fence = Fence(corners, corners, 97.0, 100.0)
    place = _pose(now).map
    return frame_of(
        number, now, CameraModel(1280, 720, 914.1, 914.2, 640.0, 360.0), place, jpeg=jpeg, speed=3.0, fence=fence,
        home=MapPoint(0.0, 0.0),
    )  # fmt: skip


def _stalls(version: int) -> dict[int, Stall]:
    return {
        k: Stall(k, k % 20 * 2.5, k // 20 * 9.0, 0.1, 2.5, 5.0, 0.5, StallState.TAKEN, 0.9, 4, 1.0, version)
        for k in range(STALLS)
    }


def _pictures() -> list[bytes]:
    """Return pictures with the detail of a photograph: some 100 kB each."""
    rng = np.random.default_rng(1)
    found = []
    for _ in range(PICTURES_S):
        rough = cv2.resize(rng.integers(0, 255, (24, 42, 3), np.uint8), (1280, 720), interpolation=cv2.INTER_CUBIC)
        found.append(encoded(np.asarray(rough, np.uint8)))
    return found


def _fly(
    seconds: range, pictures: list[bytes], tick: Callable[[Facts, Decision], None], frame: Take, show: Take
) -> None:
    parts = tuple((name, Health()) for name in _PARTS)
    for step in range(seconds.start * TICKS_S, seconds.stop * TICKS_S):
        now = 100.0 + step / TICKS_S
        facts = Facts(now, utc=1.7e9 + now, parts=parts)
        facts = replace(facts, position=replace(facts.position, pose=_pose(now), age=0.02))
        acts: Acts = (SendTarget(Goal(now, now, 30.0, 0.0)),)
        if step % 4 == 0:
            acts += (Ask(ReadParameter("RTL_ALT"), now),)
        tick(facts, Decision(acts, None, "", is_sound=True))
        if step % (TICKS_S // PICTURES_S) == 0:
            frame(_frame(now, step, pictures[step % len(pictures)]))
        if step % (TICKS_S // 5) == 0:
            show(_pose(now))
        if step % (TICKS_S * 5) == 0:
            show(MapStalls(_DATUM, _stalls(step)))
            show(Words("info", "New target: 12 m ahead."))


async def measure(folder: Path, seconds: int = SECONDS) -> Recorded:
    """Record a flight into a folder and return what it costs."""
    settings, tokens, pictures = DdcSettings(), KillTokens(), _pictures()
    decider = Decider(settings, tokens, 100.0)
    now = [100.0]
    spent = _cpu(lambda: _fly(range(seconds), pictures, _drop_two, _drop, _drop))
    recording = Recording(
        StoreSettings(directory=folder, minimum_free_mb=1), lambda: now[0], {}, json_schemas=json_schemas
    )
    recorder = Recorder(recording.record, lambda: remember(decider, settings, tokens), recording.wants_memory)

    def tick(facts: Facts, decision: Decision) -> None:
        now[0] = facts.now
        recorder.prepare(facts.now)
        recorder.tick(facts, decision)

    recording.begin()
    begun = time.process_time()
    for part in range(0, seconds, PART_S):
        _fly(range(part, part + PART_S), pictures, tick, recording.record_frame, _shown(recording.show))
        while recording.waiting:  # noqa: ASYNC110 - the thread sends no event
            await asyncio.sleep(0.01)
    cost = time.process_time() - begun - spent
    await recording.close()
    size = 0 if recording.path is None else recording.path.stat().st_size
    return Recorded(cost / seconds, size / seconds, recording.dropped)


def _cpu(run: Callable[[], None]) -> float:
    begun = time.process_time()
    run()
    return time.process_time() - begun


def _shown(show: Callable[[View], None]) -> Take:
    return lambda value: show(value)


def _drop(_: object) -> None:
    """Keep nothing."""


def _drop_two(_: object, __: object) -> None:
    """Keep nothing."""
