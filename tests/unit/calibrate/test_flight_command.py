"""From rendered pictures in a recording to lines of settings."""

from __future__ import annotations

import asyncio
import json
import math
import tomllib
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from hawk.algo.frame import FrameInput
from hawk.algo.vision.rectify import camera_to_ned
from hawk.calibrate.flight import FlightError, Flown, Track, aligned, newest_recording, read_flight
from hawk.calibrate.pairs import choose_pairs, rotations
from hawk.cli import main
from hawk.config.sections import Config, StoreSettings
from hawk.model.operation import StateName
from hawk.model.pictures import CameraModel
from hawk.model.plans import HeightParameters
from hawk.model.poses import MapPose
from hawk.store.recording import Recording
from hawk.worlds.camera import WorldCamera
from tests.drawn_worlds import drawn_world
from tests.unit.calibrate.flights import CAMERA, Errors, flight, lanes, reported

ERRORS = Errors(late=-0.045, roll=0.8, pitch=-1.2, yaw=3.5)
ATTITUDES_LATE_S = 0.03
LENS = replace(CAMERA, distortion=(-0.12, 0.03, 0.0, 0.0, 0.0))


def draw(world: WorldCamera, pose: NDArray[np.float64], maps: tuple[NDArray[np.float32], NDArray[np.float32]]) -> bytes:
    """A picture of the lens with its distortion, from a body of that pose."""
    body = rotations(pose[None, 3:])[0] @ rotations(ERRORS.mount[None])[0]
    yaw, pitch, roll = Rotation.from_matrix(body).as_euler("ZYX")
    picture = world.render(30 + pose[1], 40 - pose[0], pose[2], roll, pitch, yaw, rng=np.random.default_rng(1))
    seen = cv2.remap(picture, *maps, cv2.INTER_LINEAR)
    return bytes(cv2.imencode(".jpg", seen)[1].tobytes())


def bent() -> tuple[CameraModel, tuple[NDArray[np.float32], NDArray[np.float32]]]:
    """A wider camera to draw with, and the maps from the lens's pixels to its."""
    wide = CameraModel(800, 480, 457.0, 457.0, 399.5, 239.5)
    rows, columns = np.mgrid[0 : LENS.height, 0 : LENS.width].astype(np.float32)
    matrix = np.array([[LENS.fx, 0, LENS.cx], [0, LENS.fy, LENS.cy], [0, 0, 1.0]])
    points = np.stack([columns, rows], -1).reshape(-1, 1, 2)
    rays = cv2.undistortPoints(points, matrix, np.array(LENS.distortion)).reshape(LENS.height, LENS.width, 2)
    return wide, tuple(np.asarray(rays * wide.fx + (wide.cx, wide.cy), np.float32).transpose(2, 0, 1))


async def write(
    folder: Path, track: Track, jpegs: dict[int, bytes], camera: CameraModel = LENS, **settings: object
) -> None:
    """Write a recording as the daemon does; ``settings`` of section ``[camera]``."""
    metadata = {"configuration": Config.model_validate({"camera": settings}).model_dump_json()}
    recording = Recording(StoreSettings(directory=folder, minimum_free_mb=1), lambda: 0.0, metadata)
    recording.begin()
    late = Track(track.times + ATTITUDES_LATE_S, track.poses).at(track.times)
    for k in range(0, len(track.times), 3):
        north, east, height, *_ = (float(value) for value in track.poses[k])
        pose = MapPose(north, east, height, *(float(value) for value in late[k, 3:]))
        recording.record("tick", {"facts": {"position": {"pose": {"time": float(track.times[k]), "map": pose}}}})
    for look in flight(track, camera=camera).looks:
        jpeg, state = jpegs.get(look.index, b""), StateName.AUTONOMOUS_EXPLORE
        recording.record_frame(
            FrameInput(
                look.index, look.captured, jpeg, camera, look.pose, 4.0, state, None, HeightParameters(), None, None
            )
        )
    recording.end()
    await recording.close()


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The store of a daemon with one recorded flight, rendered with `ERRORS`."""
    folder = tmp_path_factory.mktemp("store")
    true = lanes(36, seed=3)
    by_autopilot = reported(true, seed=3, drift=0.02, lean=math.radians(0.05))
    planned = flight(by_autopilot, camera=LENS)
    used = {look.index: look for pair in choose_pairs(planned) for look in (pair.before, pair.now)}
    wide, maps = bent()
    world = WorldCamera(drawn_world(3), wide)
    poses = true.at(np.array([look.captured for look in used.values()]) + ERRORS.late)
    jpegs = {index: draw(world, pose, maps) for index, pose in zip(used, poses, strict=True)}
    asyncio.run(write(folder, by_autopilot, jpegs))
    return folder


@pytest.mark.slow
@pytest.mark.nightly
def test_a_rendered_flight_gives_its_errors_and_apply_writes_them(
    store: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    settings = tmp_path / "config.toml"
    settings.write_text(f'[camera]\nlatency_s = 0.2  # by hand\n[store]\ndirectory = "{store}"\n')
    assert main(["calibrate", "--in-flight", "--config", str(settings), "--json", "--apply"]) == 0
    said = json.loads(capsys.readouterr().out)
    found = {each["setting"].removeprefix("camera."): each for each in said["settings"]}
    assert found["latency_s"]["value"] == pytest.approx(0.08 - ERRORS.late, abs=0.010)
    assert found["mount_yaw_deg"]["value"] == pytest.approx(ERRORS.yaw, abs=0.3)
    assert found["mount_roll_deg"]["value"] == pytest.approx(ERRORS.roll, abs=0.3)
    assert found["mount_pitch_deg"]["value"] == pytest.approx(ERRORS.pitch, abs=0.3)
    assert said["pairs"] > 60
    offered = {key: each["value"] for key, each in found.items() if each["offered"]}
    assert "latency_s" in offered
    assert tomllib.loads(settings.read_text())["camera"] == {"latency_s": 0.2} | offered
    assert "# by hand" in settings.read_text()


def test_the_lag_of_the_ticks_attitudes_is_taken_out() -> None:
    true = lanes(20)
    exact = Track(true.times[50:-50:7], true.poses[50:-50:7])
    late = Track(true.times + 0.043, true.poses).at(true.times)
    dense = Track(true.times, np.column_stack([true.poses[:, :3], late[:, 3:]]))
    found = aligned(dense, exact)
    assert found.lag == pytest.approx(0.043, abs=0.002)
    times = true.times[100:-100]
    assert np.degrees(np.abs(found.at(times) - true.at(times))[:, 3:]).max() < 0.2


def test_attitudes_that_no_lag_explains_are_left_out() -> None:
    true = lanes(20)
    exact = Track(true.times[50:-50:7], true.poses[50:-50:7])
    other = Track(true.times, true.poses + np.random.default_rng(1).normal(0, 0.02, true.poses.shape))
    assert aligned(other, exact) is exact


def test_a_recording_without_pictures_from_the_air_is_refused(tmp_path: Path) -> None:
    low = lanes(5)
    low.poses[:, 2] = 3.0
    asyncio.run(write(tmp_path, low, {}))
    with pytest.raises(FlightError, match="has no pictures from 6 m above the ground"):
        read_flight(newest_recording(tmp_path))


@pytest.mark.slow
def test_a_flight_whose_pictures_cannot_be_read_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asyncio.run(write(tmp_path, lanes(15), {}))
    assert main(["calibrate", "--in-flight", "--store", str(tmp_path)]) == 1
    assert "only 0 pairs of pictures show the same ground, 20 are needed" in capsys.readouterr().err


def test_a_store_without_a_recording_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["calibrate", "--in-flight", "--store", str(tmp_path)]) == 1
    assert "store.directory" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("url", "stamped"), [("v4l2:///dev/video0", True), ("rpicam:0", True), ("rtsp://10.0.0.1/main", False)]
)
def test_the_flight_s_own_settings_are_read(tmp_path: Path, url: str, stamped: bool) -> None:
    asyncio.run(write(tmp_path, lanes(5), {}, url=url, latency_s=0.2))
    assert read_flight(newest_recording(tmp_path)).flown == Flown(0.2, has_kernel_stamps=stamped)


def test_a_gimbal_s_attitude_takes_the_place_of_the_drone_s(tmp_path: Path) -> None:
    """The camera looks where the drone's attitude and the gimbal's mount at that time point."""
    mounted = replace(LENS, mount_roll=0.1, mount_pitch=-0.3, mount_yaw=0.6)
    asyncio.run(write(tmp_path, lanes(5), {}, mounted, gimbal=True))
    found = read_flight(newest_recording(tmp_path))
    assert (found.camera.mount_roll, found.camera.mount_pitch, found.camera.mount_yaw) == (0, 0, 0)
    before = flight(lanes(5), camera=mounted).looks[9].pose
    assert camera_to_ned(found.camera, found.looks[9].pose) == pytest.approx(camera_to_ned(mounted, before))
    assert found.track.lag == 0.0


def test_apply_needs_a_settings_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["calibrate", "--in-flight", "--store", str(tmp_path), "--apply"]) == 2
    assert "--apply: name the settings file" in capsys.readouterr().err
