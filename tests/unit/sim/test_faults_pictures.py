from __future__ import annotations

import cv2
import numpy as np
import pytest

from hawk.sim.camera.camera import Frame
from hawk.sim.faults import EVERY, LOST_BYTES, CameraFaults, damage, orient

NOISE = np.random.default_rng(1).integers(0, 255, (240, 320, 3), np.uint8)
JPEG = cv2.imencode(".jpg", NOISE)[1].tobytes()


def test_one_picture_in_ten_lacks_its_middle() -> None:
    lengths = [len(damage(JPEG, number)) for number in range(20)]
    assert lengths.count(len(JPEG) - LOST_BYTES) == 2
    assert lengths.count(len(JPEG)) == 18
    broken = damage(JPEG, EVERY)
    assert broken[:2] == b"\xff\xd8"
    assert broken[-2:] == b"\xff\xd9"


@pytest.mark.parametrize(("orientation", "shape"), [(1, (240, 320)), (3, (240, 320)), (6, (320, 240)), (8, (320, 240))])
def test_a_decoder_that_reads_the_orientation_turns_the_picture(orientation: int, shape: tuple[int, int]) -> None:
    picture = cv2.imdecode(np.frombuffer(orient(JPEG, orientation), np.uint8), cv2.IMREAD_COLOR)
    assert picture is not None
    assert picture.shape[:2] == shape


def test_stamps_and_tail_are_off_as_asked_for() -> None:
    faults = CameraFaults()
    frame = Frame(3, 12.0, JPEG)
    assert faults.picture(frame) == JPEG
    assert faults.stamp(frame) == 12.0
    faults.tail_bytes, faults.stamp_step_s = 80, -0.5
    assert faults.picture(frame) == JPEG + bytes(80)
    assert faults.stamp(frame) == 11.5
