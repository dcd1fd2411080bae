"""The picture's scale comes from the height above the ground below, where a rangefinder measures that ground.

A lot of known stalls is drawn and seen from 25 m above it, while the drone believes to be 30 m above the arm place: the
lot lies 5 m higher than that. The packaged network looks at both readings of the same picture.
"""

from __future__ import annotations

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest

from hawk.algo.frame import FrameInput
from hawk.algo.vision.app import VisionApp
from hawk.algo.vision.detection import Detection
from hawk.algo.vision.rectify import ground_footprint
from hawk.model.operation import StateName
from hawk.model.plans import HeightParameters
from hawk.model.poses import MapPose
from hawk.sim.camera.camera import default_intrinsics
from hawk.store.frame_codec import decode_frame, encode_frame
from hawk.worlds.camera import WorldCamera
from hawk.worlds.world import World

SCALE_M = 0.05
WIDTH_M, LENGTH_M, COLUMNS = 2.6, 5.2, 9
MIDDLE = (40.0, 30.0)
"""East and south, metres in the world."""
ROWS_SOUTH = (-7.0, 7.0)
"""Middles of the two rows of stalls, metres south of the middle."""
ABOVE_GROUND_M, GROUND_M = 25.0, 5.0
POSE = MapPose(0.0, 0.0, ABOVE_GROUND_M + GROUND_M, 0.0, 0.0, 0.0)


def stalls() -> list[tuple[float, float]]:
    """Middles (north, east) of all stalls, metres from the middle of the world, which is the drone's place."""
    return [(-south, (k - (COLUMNS - 1) / 2) * WIDTH_M) for south in ROWS_SOUTH for k in range(COLUMNS)]


def lot() -> World:
    rng = np.random.default_rng(3)
    ground = np.clip(rng.normal(70, 3, (1200, 1600, 3)), 0, 255).astype(np.uint8)
    for north, east in stalls():
        x, y = (MIDDLE[0] + east) / SCALE_M, (MIDDLE[1] - north) / SCALE_M
        half = (WIDTH_M / 2 / SCALE_M, LENGTH_M / 2 / SCALE_M)
        for side in (-1, 1):
            ends = (round(x + side * half[0]), round(y - half[1])), (round(x + side * half[0]), round(y + half[1]))
            cv2.line(ground, *ends, (235, 235, 235), 3)
    for south in ROWS_SOUTH:  # a line along the heads shows where stalls end
        y = round((MIDDLE[1] + south + math.copysign(LENGTH_M / 2, south)) / SCALE_M)
        left, right = (round((MIDDLE[0] + side * COLUMNS * WIDTH_M / 2) / SCALE_M) for side in (-1, 1))
        cv2.line(ground, (left, y), (right, y), (235, 235, 235), 3)
    return World("rows", SCALE_M, ground)


def over_the_lot(pose: MapPose) -> FrameInput:
    """Return a picture from `ABOVE_GROUND_M` above the lot's middle; ``pose`` is the reported one."""
    camera = default_intrinsics()
    picture = WorldCamera(lot(), camera).render(*MIDDLE, ABOVE_GROUND_M, 0.0, 0.0, 0.0, rng=np.random.default_rng(1))
    jpeg = cv2.imencode(".jpg", picture)[1].tobytes()
    return FrameInput(1, 5.0, jpeg, camera, pose, 0.0, StateName.HOVER, None, HeightParameters(), None, None)


@pytest.fixture(scope="module")
def frame() -> FrameInput:
    return over_the_lot(POSE)


@pytest.fixture(scope="module")
def app() -> VisionApp:
    return VisionApp()


def seen(app: VisionApp, frame: FrameInput) -> list[Detection]:
    ground = app.see(frame).ground
    assert ground is not None
    return [stall for stall in ground.stalls if stall.score >= 0.5]


def in_place(found: list[Detection]) -> int:
    """Return how many stalls were found within half a metre and with their own size, to within 10 %."""
    return sum(
        any(
            math.hypot(stall.north - north, stall.east - east) < 0.5
            and stall.width == pytest.approx(WIDTH_M, rel=0.1)
            and stall.length == pytest.approx(LENGTH_M, rel=0.1)
            for stall in found
        )
        for north, east in stalls()
    )


@pytest.mark.slow
@pytest.mark.fault(
    "the ground is 5 m higher than the arm place, a rangefinder measures it",
    "stalls come out in size and place, also in a recording",
)
def test_with_the_ground_known_stalls_come_out_in_size_and_place(app: VisionApp, frame: FrameInput) -> None:
    found = seen(app, replace(frame, ground=GROUND_M))
    assert in_place(found) >= 0.9 * len(stalls())


@pytest.mark.slow
def test_without_it_they_do_not(app: VisionApp, frame: FrameInput) -> None:
    assert in_place(seen(app, frame)) <= 0.1 * len(stalls())


@pytest.mark.slow
def test_with_the_ground_known_the_map_s_pose_keeps_its_place(app: VisionApp, frame: FrameInput) -> None:
    ground = app.see(replace(frame, ground=GROUND_M)).ground
    assert ground is not None
    assert ground.pose == replace(POSE, height=ABOVE_GROUND_M)


def test_the_footprint_is_that_of_the_height_above_the_ground(frame: FrameInput) -> None:
    over = replace(frame, ground=GROUND_M).over_ground
    assert over is not None
    assert ground_footprint(frame.camera, over)[0].north == pytest.approx(
        ground_footprint(frame.camera, POSE)[0].north * ABOVE_GROUND_M / POSE.height, abs=0.01
    )


def test_a_recorded_frame_keeps_its_ground_and_an_older_recording_has_none(frame: FrameInput) -> None:
    over = replace(frame, ground=GROUND_M)
    assert decode_frame(encode_frame(over), FrameInput) == over
    data = encode_frame(frame)
    assert b',"ground":0.0' in data
    older = data.replace(b',"ground":0.0', b"")
    length = int.from_bytes(data[:4], "little") - len(b',"ground":0.0')
    assert decode_frame(length.to_bytes(4, "little") + older[4:], FrameInput) == frame


def test_without_a_rangefinder_nothing_changes(frame: FrameInput) -> None:
    assert frame.over_ground is frame.pose
    assert replace(frame, pose=None, ground=GROUND_M).over_ground is None


def test_below_the_least_height_above_the_ground_pictures_are_shown_only(app: VisionApp, frame: FrameInput) -> None:
    low = app.see(replace(frame, ground=25.0))
    assert low.ground is None
    assert low.health.reason.endswith("below 6 m")
