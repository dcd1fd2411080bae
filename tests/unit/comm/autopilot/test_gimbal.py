from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from hawk.algo.vision.rectify import camera_to_ned
from hawk.comm.autopilot.gimbal import FRESH_S, GimbalAttitudes, yaw_counts_from_north
from hawk.comm.autopilot.streams import wanted_streams
from hawk.model.pictures import CameraModel
from hawk.model.poses import GlobalPose, MapPose, VehiclePose
from tests.unit.comm.autopilot.telemetry_rig import Rig

CAMERA = CameraModel(640, 480, 500.0, 500.0, 320.0, 240.0)
NOSE, NORTH = 4 | 8 | 32, 4 | 8 | 64
"""Roll and pitch locked to the horizon; yaw from the nose, yaw from north."""
DOWN = -math.pi / 2
FORWARD, TOP = (0.0, 0.0, 1.0), (0.0, -1.0, 0.0)
"""Vectors of the camera: along the optical axis, towards the picture's top."""


def quaternion(pitch: float, yaw: float = 0.0) -> list[float]:
    """Return the rotation about y by ``pitch``, then about the vertical by ``yaw``: w, x, y, z."""
    cp, sp, cy, sy = math.cos(pitch / 2), math.sin(pitch / 2), math.cos(yaw / 2), math.sin(yaw / 2)
    return [cy * cp, -sy * sp, cy * sp, sy * cp]


def status(pitch: float = DOWN, yaw: float = 0.0, flags: int = NOSE, **fields: Any) -> dict[str, Any]:
    return {"q": quaternion(pitch, yaw), "flags": flags, "gimbal_device_id": 1, **fields}


def leaning(yaw: float = 1.0) -> VehiclePose:
    roll, pitch = 0.2, -0.15
    here = MapPose(0.0, 0.0, 30.0, roll, pitch, yaw)
    return VehiclePose(10.0, GlobalPose(0, 0, 0), 30.0, None, here, (0.0, 0.0, 0.0), roll, pitch, yaw)


def seen(
    watch: GimbalAttitudes, vector: tuple[float, float, float], camera: CameraModel = CAMERA, time: float = 10.0
) -> NDArray[np.float64]:
    """Return a vector of the camera in NED, by the projection's own rule."""
    pose = leaning()
    assert pose.map is not None
    aimed, problem = watch.aim(camera, time, pose)
    assert problem == ""
    return np.asarray(camera_to_ned(aimed, pose.map) @ np.array(vector))


def watching(*samples: tuple[float, dict[str, Any]]) -> GimbalAttitudes:
    watch = GimbalAttitudes()
    for time, fields in samples:
        watch.take(fields, time)
    return watch


def test_a_gimbal_that_points_down_does_so_while_the_drone_leans() -> None:
    watch = watching((10.0, status()))
    assert seen(watch, FORWARD) == pytest.approx([0, 0, 1], abs=1e-9)
    assert seen(watch, TOP) == pytest.approx([math.cos(1.0), math.sin(1.0), 0], abs=1e-9)  # to the nose


@pytest.mark.parametrize(("flags", "heading"), [(NOSE, 1.0 + 0.4), (NORTH, 0.4), (4 | 8, 1.0 + 0.4), (4 | 8 | 16, 0.4)])
def test_yaw_counts_from_where_the_flags_say(flags: int, heading: float) -> None:
    watch = watching((10.0, status(yaw=0.4, flags=flags)))
    assert seen(watch, TOP) == pytest.approx([math.cos(heading), math.sin(heading), 0], abs=1e-9)
    assert seen(watch, FORWARD) == pytest.approx([0, 0, 1], abs=1e-9)


def test_a_pitched_gimbal_looks_ahead() -> None:
    watch = watching((10.0, status(pitch=math.radians(-60))))
    ahead = math.cos(math.radians(60))
    expected = [ahead * math.cos(1.0), ahead * math.sin(1.0), math.sin(math.radians(60))]
    assert seen(watch, FORWARD) == pytest.approx(expected, abs=1e-9)


def test_the_camera_may_sit_turned_on_the_gimbal() -> None:
    turned = CameraModel(640, 480, 500.0, 500.0, 320.0, 240.0, (), 0.0, 0.0, math.pi / 2)
    top = seen(watching((10.0, status())), TOP, turned)
    assert top == pytest.approx([math.cos(1.0 + math.pi / 2), math.sin(1.0 + math.pi / 2), 0], abs=1e-9)


def test_between_two_reports_it_moves_evenly_and_signs_of_a_quaternion_do_not_matter() -> None:
    later = status(pitch=DOWN + 0.2)
    later["q"] = [-each for each in later["q"]]
    watch = watching((9.9, status()), (10.1, later))
    down = seen(watch, FORWARD)[2]
    assert down == pytest.approx(math.cos(0.1), abs=1e-4)


def test_before_a_report_nothing_can_be_mapped() -> None:
    aimed, problem = GimbalAttitudes().aim(CAMERA, 10.0, leaning())
    assert aimed is CAMERA
    assert "the gimbal's attitude is not reported" in problem


@pytest.mark.fault(
    "the attitude of the camera's gimbal does not come, or is older than 0.5 s",
    "nothing is mapped; the mapper's health names the age",
)
def test_an_old_report_is_none_and_its_age_is_named() -> None:
    watch = watching((10.0, status()))
    assert watch.aim(CAMERA, 10.0 + FRESH_S, leaning())[1] == ""
    assert watch.aim(CAMERA, 13.0, leaning()) == (CAMERA, "the gimbal's attitude is 3 s old: nothing is mapped")
    assert "not known" in watch.aim(CAMERA, 10.0 - FRESH_S - 0.1, leaning())[1]


def test_over_a_gap_nothing_is_made_up() -> None:
    watch = watching((8.0, status()), (12.0, status(pitch=0.0)))
    assert "not known" in watch.aim(CAMERA, 10.0, leaning())[1]


def test_without_a_pose_the_camera_is_left_as_it_is() -> None:
    assert watching((10.0, status())).aim(CAMERA, 10.0, None) == (CAMERA, "")


def test_another_mount_and_an_overtaken_report_are_not_taken() -> None:
    watch = watching((10.0, status()), (10.0, status(pitch=0.0)), (9.0, status(pitch=0.0)))
    watch.take(status(pitch=0.0, gimbal_device_id=2), 10.05)
    assert seen(watch, FORWARD) == pytest.approx([0, 0, 1], abs=1e-9)


@pytest.mark.parametrize("q", [[0.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [math.nan] * 4, [None] * 4])
def test_a_report_without_sense_is_refused(q: list[Any]) -> None:
    with pytest.raises((TypeError, ValueError)):
        GimbalAttitudes().take(status(q=q), 10.0)


def test_the_frame_s_flags_rank_before_the_lock() -> None:
    assert not yaw_counts_from_north(16 | 32)  # as ArduPilot sends it: locked, and yet from the nose
    assert yaw_counts_from_north(64)


def test_the_autopilot_s_report_is_taken_at_its_own_time_and_forgotten_with_a_boot() -> None:
    rig = Rig()
    rig.take(rig.said.heartbeat())
    rig.fly(0.3)
    sent = rig.said.ms
    rig.fly(0.2)
    rig.take(("GIMBAL_DEVICE_ATTITUDE_STATUS", {**status(), "time_boot_ms": sent}))
    now = rig.clock()
    aim = rig.telemetry.gimbal.aim
    assert aim(CAMERA, now - 0.2 - FRESH_S + 0.01, leaning())[1] == ""
    assert aim(CAMERA, now - 0.2 + FRESH_S + 0.01, leaning())[1] != ""
    rig.said.boot = 0.0
    rig.fly(2.0)
    assert rig.boots == 1
    assert "not reported" in aim(CAMERA, now - 0.2, leaning())[1]


def test_its_attitude_is_asked_for_only_where_there_is_one() -> None:
    assert "GIMBAL_DEVICE_ATTITUDE_STATUS" not in wanted_streams(20.0)
    assert wanted_streams(20.0, has_gimbal=True)["GIMBAL_DEVICE_ATTITUDE_STATUS"].message_id == 285


@pytest.mark.parametrize("yaw", [0.0, 2.0])
def test_the_angle_off_straight_down_is_that_of_the_optical_axis(yaw: float) -> None:
    watch = GimbalAttitudes()
    assert watch.off_down(10.0) is None
    watch.take(status(pitch=DOWN + 0.3, yaw=yaw), 10.0)
    assert watch.off_down(10.0) == pytest.approx(0.3)
    assert watch.off_down(10.0 + FRESH_S + 0.1) is None
