"""Speed of a recorded flight that is decided again, and of one whose pictures are processed again.

Decided: a reference recording of a simulated survey (`tests.reference.kept`), after one run that loads libraries.
Processed: `SECONDS` of a flight to and fro over a drawn lot, `HEIGHT_M` high, with `PICTURES_S` pictures a second of
1280 x 720 pixels. The processor time of all threads counts: what one core would take. A drone records as many pictures
as its computer sees: twice as many a second are processed half as many times as fast.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Final

import numpy as np

from benchmarks.frames import drawn_frames
from hawk.config.sections import Config
from hawk.daemon.recording_parts import json_schemas
from hawk.ddc.replay import compare_recording
from hawk.replay.flight import RecordedFlight
from hawk.replay.process import Again, process
from hawk.store.frame_codec import FRAME_INPUT
from hawk.store.recording_file import RecordingFile, start_metadata
from hawk.store.ring_buffer import Item
from hawk.worlds.generate import generate_world
from hawk.worlds.world import World
from tests.reference.kept import unpack

DECIDED: Final = "battery-swap-after"
"""Reference whose decisions are made again."""
SECONDS: Final = 40
PICTURES_S: Final = 5
HEIGHT_M: Final = 35.0
SPEED_M_S: Final = 4.0
SEED: Final = 3
_LANE_M: Final = 20.0


@dataclass(frozen=True, slots=True)
class Replayed:
    """Seconds of the flight by seconds of one core, decided and processed; decisions that differ, stalls found.

    ``picture_ms``: milliseconds of one core a picture. ``waited_x``: seconds of the flight by seconds of waiting, on
    all cores of this computer: the next picture is seen while one is mapped.
    """

    decided_x: float
    differences: int
    processed_x: float
    picture_ms: float
    waited_x: float
    stalls: int


def measure(folder: Path, seconds: int = SECONDS) -> Replayed:
    """Decide a reference again, and process a drawn flight of some seconds."""
    decided = unpack(DECIDED, folder)
    flight = RecordedFlight(decided)
    for _ in flight.messages():
        pass
    compare_recording(decided)
    began = time.process_time()
    found = compare_recording(decided)
    deciding = time.process_time() - began
    drawn = RecordedFlight(draw(folder / "drawn.mcap", seconds))
    again = Again(drawn.settings(), version("hawk-drone"))
    began = time.process_time()
    done = process(drawn, again)
    processing = time.process_time() - began
    return Replayed(
        flight.seconds / deciding, len(found.differences), seconds / processing, processing / done.frames * 1e3,
        seconds / done.took_s, len(done.final.stalls),
    )  # fmt: skip


def draw(path: Path, seconds: int) -> Path:
    """Write the recording of a flight over a drawn lot; return its path."""
    head = {"version": version("hawk-drone"), "configuration": Config().model_dump_json()}
    file = RecordingFile(path.open("wb"), start_metadata(head, datetime.now(UTC), 0.0), json_schemas)
    world = generate_world(SEED)
    rng = np.random.default_rng(SEED)
    poses = _poses(world, seconds * PICTURES_S, rng)
    for frame in drawn_frames(world, poses, HEIGHT_M, rng, pictures_s=PICTURES_S):
        file.write(Item(FRAME_INPUT, frame, "frame", round(frame.captured * 1e9), len(frame.jpeg)))
    file.close()
    return path


def _poses(world: World, count: int, rng: np.random.Generator) -> Iterator[tuple[float, float, float, float, float]]:
    """Give poses to and fro over the stalls."""
    corners = np.concatenate([stall.corners for stall in world.stalls])
    (left, top), (right, bottom) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
    for number in range(count):
        lane, along = divmod(SPEED_M_S * number / PICTURES_S, max(right - left, 1.0))
        x = left + along if lane % 2 == 0 else right - along
        y = top + (lane * _LANE_M) % max(bottom - top, 1.0)
        roll, pitch = rng.normal(0, 0.03, 2).tolist()
        yield x, y, roll, pitch, math.pi / 2 if lane % 2 == 0 else -math.pi / 2
