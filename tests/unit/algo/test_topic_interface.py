from __future__ import annotations

import pytest

from hawk.algo.frame import AlgoError
from hawk.algo.topic_interface import AlgorithmTopicInterface, FrameCamera
from hawk.formats.image import NoImage
from hawk.model.operation import StateName
from hawk.model.plans import DesiredPose
from tests.unit.algo.synthetic import frame_at, pose_at


def test_it_serves_the_frame_that_was_begun() -> None:
    interface = AlgorithmTopicInterface()
    frame = frame_at(pose_at(1, 2), desired=DesiredPose(3, 4.0, 5.0), state=StateName.HOVER)
    interface.begin(frame)
    assert interface.frame is frame


def test_without_a_frame_it_says_so() -> None:
    interface = AlgorithmTopicInterface()
    with pytest.raises(AlgoError, match="no frame"):
        _ = interface.frame
    interface.begin(frame_at(None))
    interface.init()
    with pytest.raises(AlgoError, match="no frame"):
        _ = interface.frame


def test_the_specifications_publishers_are_there_and_begin_unhealthy_and_unsure() -> None:
    interface = AlgorithmTopicInterface()
    assert interface.park_lot_detected_pub.value is False
    assert interface.des_loc_inbound_pub.value is None
    assert interface.occupancy_map_pub.value.counts.total == 0
    assert interface.local_pos_pub.value.target is None
    for health in ("vision_app_health_pub", "mapper_app_health_pub", "path_plan_app_health_pub"):
        assert not getattr(interface, health).value.is_healthy


def test_the_frame_camera_gives_the_frames_picture_or_none() -> None:
    interface = AlgorithmTopicInterface()
    camera = FrameCamera(interface)
    interface.begin(frame_at(None, jpeg=b"picture"))
    assert camera.get_image() == b"picture"
    interface.begin(frame_at(None, jpeg=b""))
    with pytest.raises(NoImage, match="empty"):
        camera.get_image()
