"""The usual size of the stalls in a picture, and that it shows a height that is wrong. The packaged network looks."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hawk.algo.frame import FrameInput
from hawk.algo.vision.app import VisionApp
from hawk.algo.vision.detection import LEAST_STALLS, WHOLE, Detection, VisionResult, stall_size
from hawk.model.pictures import StallSize
from tests.unit.algo.vision.test_app_ground_height import ABOVE_GROUND_M, POSE, WIDTH_M, over_the_lot

TRUE_M = ABOVE_GROUND_M


@pytest.fixture(scope="module")
def frame() -> FrameInput:
    return over_the_lot(replace(POSE, height=TRUE_M))


@pytest.fixture(scope="module")
def app() -> VisionApp:
    return VisionApp()


@pytest.fixture(scope="module")
def seen(app: VisionApp, frame: FrameInput) -> VisionResult:
    return app.see(frame)


@pytest.mark.slow
@pytest.mark.fault("the barometer drifts by 0.05 m/s, too slowly for the camera's minute")
@pytest.mark.parametrize("share", [0.7, 0.85, 1.0, 1.15, 1.4])
def test_a_height_that_is_reported_too_great_makes_stalls_as_many_times_too_large(
    app: VisionApp, frame: FrameInput, share: float
) -> None:
    assert frame.pose is not None
    wrong = replace(frame, pose=replace(frame.pose, height=share * TRUE_M))
    found = stall_size(wrong, app.see(wrong))
    assert found is not None
    assert (found.time, found.height) == (5.0, share * TRUE_M)
    assert found.width == pytest.approx(share * WIDTH_M, rel=0.09)  # up to 1.085 at 1.4: the network's own error


@pytest.mark.slow
def test_a_picture_whose_scale_a_rangefinder_gives_says_nothing_of_the_reported_height(
    frame: FrameInput, seen: VisionResult
) -> None:
    assert stall_size(replace(frame, ground=3.0), seen) is None
    assert stall_size(frame, replace(seen, ground=None)) is None


def only(seen: VisionResult, *stalls: Detection) -> VisionResult:
    assert seen.ground is not None
    return replace(seen, ground=replace(seen.ground, stalls=stalls))


def test_it_is_the_median_of_the_whole_stalls_and_of_enough(frame: FrameInput, seen: VisionResult) -> None:
    stall = Detection(0.0, 0.0, 0.0, 2.5, 5.0, 0.9, 0.1, WHOLE)
    wide, cut = replace(stall, width=9.0), replace(stall, width=1.0, visible=WHOLE - 0.01)
    whole = [stall] * (LEAST_STALLS - 1)
    assert stall_size(frame, only(seen, *whole, *[cut] * 20)) is None
    assert stall_size(frame, only(seen, *whole, wide, *[cut] * 20)) == StallSize(5.0, 2.5, TRUE_M)
