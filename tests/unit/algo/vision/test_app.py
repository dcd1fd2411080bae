from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from hawk.algo.frame import AlgoError, FrameInput
from hawk.algo.topic_interface import AlgorithmTopicInterface, FrameCamera
from hawk.algo.vision import network_file
from hawk.algo.vision.app import VisionApp, VisionSettings
from hawk.algo.vision.detection import Detection, Found, GroundImage
from hawk.algo.vision.detector import StallDetector
from hawk.algo.vision.network_file import VisionModelError
from hawk.formats.image import DamagedImage, NoImage
from hawk.model.operation import StateName
from hawk.model.pictures import CameraModel
from hawk.model.plans import HeightParameters
from hawk.model.poses import MapPose
from hawk.model.sun import SunPosition
from tests.unit.jpegs import jpeg, scene, without

F = 640 / math.tan(math.radians(35))
CAMERA = CameraModel(1280, 720, F, F, 639.5, 359.5)
POSE = MapPose(10, 20, 30, 0, 0, 0)
JPEG = cv2.imencode(".jpg", np.full((720, 1280, 3), 110, np.uint8))[1].tobytes()
STALL = Detection(10, 20, 0.3, 2.62, 5.35, 0.9, 0.1, 1.0)


class SetFinder(StallDetector):
    """Finds what the test says."""

    def __init__(self) -> None:
        self.stalls: tuple[Detection, ...] = ()
        self.lot = 0.0
        self.error: Exception | None = None
        self.shadows: list[tuple[float, float] | None] = []

    def detect(self, picture: GroundImage, shadow: tuple[float, float] | None = None) -> Found:
        self.shadows.append(shadow)
        if self.error:
            raise self.error
        half = GroundImage(
            np.full(picture.valid[::2, ::2].shape, self.lot, np.float32), picture.to_map, picture.valid[::2, ::2]
        )
        return Found(self.stalls, half, half, half, half)


class Rig:
    """An app with its surroundings."""

    def __init__(self, settings: VisionSettings | None = None) -> None:
        self.finder = SetFinder()
        self.topics = AlgorithmTopicInterface()
        self.app = VisionApp(settings, self.finder)
        self.app.init(FrameCamera(self.topics), self.topics)
        self.frame = FrameInput(1, 5.0, JPEG, CAMERA, POSE, 0.0, StateName.HOVER, None, HeightParameters(), None, None)

    def process(self, jpeg: bytes = JPEG, pose: MapPose | None = POSE) -> None:
        self.topics.begin(replace(self.frame, jpeg=jpeg, pose=pose))
        try:
            self.app.process()
        finally:
            self.app.publish()


@pytest.fixture
def rig() -> Rig:
    return Rig()


def test_a_frame_is_rectified_looked_at_and_published(rig: Rig) -> None:
    rig.finder.stalls = (STALL,) * 3
    for _ in range(2):
        rig.process()
    seen = rig.app.seen.ground
    assert seen is not None
    assert (seen.stalls, seen.pose, seen.captured) == ((STALL,) * 3, POSE, 5.0)
    assert seen.picture.metres_per_pixel == pytest.approx(0.1)
    assert rig.topics.park_lot_detected_pub.value is True
    assert rig.topics.vision_app_health_pub.value.is_healthy
    assert rig.app.seen.image is not None
    assert rig.app.seen.image.shape == (720, 1280, 3)


def test_the_finder_gets_the_shadow_of_the_frame_s_sun_and_none_at_night_or_where_it_is_not_known(rig: Rig) -> None:
    for sun in (SunPosition(180.0, 45.0), SunPosition(0.0, -5.0), None):
        rig.frame = replace(rig.frame, sun=sun)
        rig.process()
    first, *others = rig.finder.shadows
    assert first == pytest.approx((1.0, 0.0))
    assert others == [None, None]


def test_the_lot_s_detection_is_steady(rig: Rig) -> None:
    rig.process()
    assert not rig.app.get_park_lot_detected()
    rig.finder.stalls = (STALL,) * 3
    rig.process()
    assert not rig.app.get_park_lot_detected(), "one frame alone is not enough"
    rig.process()
    assert rig.app.get_park_lot_detected()
    rig.finder.stalls = ()
    for _ in range(7):
        rig.process()
    assert rig.app.get_park_lot_detected()
    rig.process()
    assert not rig.app.get_park_lot_detected()


@pytest.mark.parametrize(
    ("stalls", "lot", "detected"),
    [
        ((STALL,) * 2, 0.0, False),
        ((STALL,) * 3, 0.0, True),
        ((replace(STALL, score=0.3),) * 9, 0.9, False),
        ((STALL,), 0.5, True),
        ((), 1.0, False),
    ],
)
def test_a_lot_is_detected_by_its_stalls_or_its_ground(
    rig: Rig, stalls: tuple[Detection, ...], lot: float, detected: bool
) -> None:
    rig.finder.stalls, rig.finder.lot = stalls, lot
    for _ in range(3):
        rig.process()
    assert rig.app.get_park_lot_detected() is detected


@pytest.mark.parametrize(
    ("jpeg", "words"),
    [
        (b"", "empty"),
        (JPEG[:900], "torn"),
        (b"\x00" * 50, "not a JPEG"),
        (cv2.imencode(".jpg", np.zeros((720, 1280, 3), np.uint8))[1].tobytes(), "black"),
        (cv2.imencode(".jpg", np.full((30, 40, 3), 99, np.uint8))[1].tobytes(), "at least 64"),
    ],
)
def test_a_picture_that_cannot_be_used_is_said_so_and_the_next_one_works(rig: Rig, jpeg: bytes, words: str) -> None:
    with pytest.raises(NoImage, match=words):
        rig.process(jpeg)
    assert words in rig.topics.vision_app_health_pub.value.reason
    assert not rig.topics.vision_app_health_pub.value.is_healthy
    assert rig.app.seen.ground is None
    assert rig.app.seen.image is None
    rig.process()
    assert rig.app.get_health().is_healthy
    assert rig.app.seen.ground is not None


@pytest.mark.parametrize(
    ("pose", "words"),
    [
        (replace(POSE, height=math.nan), "not finite"),
        (replace(POSE, yaw=math.inf), "not finite"),
        (replace(POSE, roll=math.pi), "horizon"),
    ],
)
def test_a_pose_that_cannot_be_used_leaves_the_picture(rig: Rig, pose: MapPose, words: str) -> None:
    with pytest.raises(AlgoError, match=words):
        rig.process(pose=pose)
    assert words in rig.app.get_health().reason
    assert rig.app.seen.ground is None
    assert rig.app.seen.image is not None


@pytest.mark.parametrize(("pose", "words"), [(None, "no pose"), (replace(POSE, height=3.0), "below 6 m")])
def test_without_pose_or_height_pictures_are_only_shown(rig: Rig, pose: MapPose | None, words: str) -> None:
    rig.finder.stalls = (STALL,) * 5
    for _ in range(3):
        rig.process(pose=pose)
    assert rig.app.seen.ground is None
    assert not rig.app.get_park_lot_detected()
    assert rig.app.get_health().is_healthy
    assert words in rig.app.get_health().reason
    assert rig.app.seen.image is not None


@pytest.mark.fault("300 B to 3 kB are lost inside a JPEG, with or without restart markers, wherever it is")
def test_a_picture_that_lost_bytes_is_neither_projected_nor_shown_and_is_said_to_be_damaged(rig: Rig) -> None:
    rig.finder.stalls = (STALL,) * 3
    with pytest.raises(DamagedImage):
        rig.process(without(jpeg(scene(640, 480)), 0.4, 3000))
    failed = rig.app.fail("the picture is damaged")
    assert failed.is_damaged
    assert failed.image is None
    assert failed.ground is None
    rig.process()
    assert not rig.app.seen.is_damaged


@pytest.mark.slow
@pytest.mark.fault(
    "one picture in two is bad",
    "the lot stays in sight; Explore is refused only once a fault of perception has lasted 1 s",
)
@pytest.mark.parametrize("bad", [b"", JPEG[:900], without(jpeg(scene(640, 480)), 0.4, 3000)])
def test_single_bad_pictures_do_not_lose_the_lot(rig: Rig, bad: bytes) -> None:
    rig.finder.stalls = (STALL,) * 3
    for _ in range(2):
        rig.process()
    for _ in range(20):
        with pytest.raises(NoImage) as error:
            rig.process(bad)
        assert rig.app.fail(str(error.value)).park_lot_detected
        assert not rig.app.get_health().is_healthy
        rig.process()
        assert rig.app.get_park_lot_detected()


def test_a_finder_that_raises_anything_loses_the_lot_in_the_end(rig: Rig) -> None:
    rig.finder.stalls = (STALL,) * 3
    for _ in range(2):
        rig.process()
    rig.finder.error = RuntimeError("a bug")
    found = []
    for _ in range(8):
        with pytest.raises(RuntimeError):
            rig.process()
        found.append(rig.app.fail("a bug").park_lot_detected)
    assert found == [True] * 7 + [False]


def test_bad_pictures_in_a_row_lose_the_lot(rig: Rig) -> None:
    rig.finder.stalls = (STALL,) * 3
    for _ in range(2):
        rig.process()
    for _ in range(8):
        with pytest.raises(NoImage):
            rig.process(b"")
    assert rig.topics.park_lot_detected_pub.value is False


def test_a_network_that_fails_in_flight_is_an_algorithm_error(rig: Rig) -> None:
    rig.finder.error = VisionModelError("vision.model: x cannot be run")
    with pytest.raises(AlgoError, match=r"vision\.model"):
        rig.process()
    assert not rig.app.get_health().is_healthy


def test_init_forgets(rig: Rig) -> None:
    rig.finder.stalls = (STALL,) * 3
    for _ in range(2):
        rig.process()
    rig.app.init(FrameCamera(rig.topics), rig.topics)
    assert rig.app.seen.ground is None
    assert not rig.app.get_park_lot_detected()


def test_before_init_it_says_so() -> None:
    app = VisionApp(finder=SetFinder())
    with pytest.raises(AlgoError, match="init"):
        app.process()
    with pytest.raises(AlgoError, match="init"):
        app.publish()


def test_the_same_frames_twice_give_the_same_results() -> None:
    one, two = Rig(), Rig()
    for rig in (one, two):
        rig.finder.stalls = (STALL,) * 3
        rig.process()
    assert one.app.seen.ground is not None
    assert two.app.seen.ground is not None
    np.testing.assert_array_equal(one.app.seen.ground.picture.values, two.app.seen.ground.picture.values)
    assert one.app.seen.ground.stalls == two.app.seen.ground.stalls


def test_a_user_s_model_that_is_missing_or_no_network_is_an_error_that_names_the_setting(tmp_path: Path) -> None:
    with pytest.raises(VisionModelError, match=r"vision\.model: .*gone\.onnx"):
        VisionApp(VisionSettings(model=tmp_path / "gone.onnx"))
    broken = tmp_path / "broken.onnx"
    broken.write_bytes(b"this is not a network")
    with pytest.raises(VisionModelError, match=r"vision\.model: .*broken\.onnx"):
        VisionApp(VisionSettings(model=broken))


def test_without_the_package_s_network_pictures_are_shown_and_the_health_says_why(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(network_file, "_WEIGHTS", ("weights", "gone.onnx"))
    app = VisionApp()
    topics = AlgorithmTopicInterface()
    app.init(FrameCamera(topics), topics)
    topics.begin(Rig().frame)
    with pytest.raises(AlgoError, match="missing from the package: install it again"):
        app.process()
    assert app.seen.image is not None
    assert app.seen.ground is None
    assert not app.get_park_lot_detected()
    assert "missing from the package" in app.get_health().reason
    assert not app.get_health().is_healthy
