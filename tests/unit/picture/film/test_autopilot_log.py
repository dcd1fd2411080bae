from __future__ import annotations

import math
import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pymavlink import mavutil
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.picture.film.autopilot_log import read_log
from hawk.picture.values import PictureError
from tests.unit.picture.film.conftest import STRAIGHT
from tests.unit.picture.film.films import HEIGHT, LENS, START, write_bin, write_tlog


@pytest.mark.parametrize("kind", ["tlog", "bin"])
def test_places_heights_and_attitudes_are_read_in_unix_time(tmp_path: Path, kind: str) -> None:
    path = tmp_path / f"a.{kind}"
    if kind == "tlog":
        write_tlog(path, STRAIGHT, 0.0, 6.0)
    else:
        write_bin(path, STRAIGHT, 0.0, 6.0)
    found = read_log(path)
    course = found.course
    assert not found.has_gimbal
    assert len(course.time) == 60
    assert course.time[0] == pytest.approx(START.timestamp(), abs=0.02)
    assert course.epoch == 0.0
    latitude, longitude, altitude = STRAIGHT.geodetic(3.0)
    at = course.at(course.time[30:31])
    assert (at.latitude[0], at.longitude[0]) == pytest.approx((latitude, longitude), abs=2e-7)
    assert (at.altitude[0], at.height[0]) == pytest.approx((altitude, HEIGHT), abs=0.02)
    assert at.attitude[0] == pytest.approx((0.0, 0.0, math.pi / 2), abs=1e-4)


@pytest.mark.parametrize("name", ["bin/a.tlog", "tcp:127.0.0.1:9.tlog", "tcp:127.0.0.1:9.bin"])
def test_a_log_is_read_and_neither_run_nor_connected_to(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    def refuse(*_args: object, **_options: object) -> None:
        raise AssertionError("it was opened as no file")

    monkeypatch.setattr(mavutil, "mavchildexec", refuse)
    monkeypatch.setattr(mavutil, "mavtcp", refuse)
    monkeypatch.chdir(tmp_path)
    path = Path(name)
    path.parent.mkdir(exist_ok=True)
    if path.suffix == ".tlog":
        write_tlog(tmp_path / path, STRAIGHT)
        (tmp_path / path).chmod(0o755)
    else:
        write_bin(path, STRAIGHT, 0.0, 8.0)
    for each in (path, tmp_path / path):
        assert len(read_log(each).course.time) == 80


def test_a_mount_turns_the_camera(tmp_path: Path) -> None:
    log = write_tlog(tmp_path / "a.tlog", STRAIGHT)
    found = read_log(log, replace(LENS, mount_yaw=math.pi / 2))
    assert abs(found.course.attitude[0, 2]) == pytest.approx(math.pi, abs=1e-4)


@pytest.mark.parametrize(("flags", "yaw"), [(32, math.pi / 2 + 0.3), (64, 0.3)])
def test_a_gimbals_attitude_counts_before_the_drones(tmp_path: Path, flags: int, yaw: float) -> None:
    log = write_tlog(tmp_path / "a.tlog", STRAIGHT)
    sender = mavlink.MAVLink(None, srcSystem=1, srcComponent=154)
    half = -math.pi / 4  # straight down: -90 degrees of pitch
    down = (math.cos(half), 0.0, math.sin(half), 0.0)
    turned = (math.cos(0.15), 0.0, 0.0, math.sin(0.15))
    w, x, y, z = (
        turned[0] * down[0], -turned[3] * down[2], turned[0] * down[2], turned[3] * down[0],
    )  # fmt: skip
    data = b""
    for k in range(80):
        message = sender.gimbal_device_attitude_status_encode(1, 0, 100 * k, flags, [w, x, y, z], 0, 0, 0, 0)
        data += struct.pack(">Q", round((START.timestamp() + k / 10) * 1e6)) + message.pack(sender)
    log.write_bytes(log.read_bytes() + data)
    found = read_log(log)
    assert found.has_gimbal
    roll, pitch, turn = found.course.attitude[20]
    assert (roll, pitch) == pytest.approx((0.0, 0.0), abs=1e-3)
    assert turn == pytest.approx(yaw, abs=1e-3)


def test_the_drone_with_most_places_is_taken(tmp_path: Path) -> None:
    log = write_tlog(tmp_path / "a.tlog", STRAIGHT)
    other = mavlink.MAVLink(None, srcSystem=7, srcComponent=1)
    message = other.global_position_int_encode(1, 10**7, 10**7, 0, 0, 0, 0, 0, 0).pack(other)
    log.write_bytes(struct.pack(">Q", round(START.timestamp() * 1e6)) + message + log.read_bytes())
    assert read_log(log).course.latitude.min() > 40


@pytest.mark.parametrize(
    ("name", "data", "words"),
    [
        ("a.tlog", b"", "a.tlog: is empty; download it again"),
        ("a.tlog", b"no log at all" * 50, "no places are in it"),
        ("a.bin", b"no log at all" * 50, "no places are in it|is damaged"),
    ],
)
def test_a_log_without_a_flight_is_refused(tmp_path: Path, name: str, data: bytes, words: str) -> None:
    (tmp_path / name).write_bytes(data)
    with pytest.raises(PictureError, match=words):
        read_log(tmp_path / name)


def test_a_torn_log_gives_what_it_has(tmp_path: Path) -> None:
    for path in (write_tlog(tmp_path / "a.tlog", STRAIGHT), write_bin(tmp_path / "a.bin", STRAIGHT, 0.0, 8.0)):
        data = path.read_bytes()
        path.write_bytes(data[: len(data) * 2 // 3 + 5])
        assert 40 <= len(read_log(path).course.time) <= 60


def test_a_log_without_attitudes_is_refused(tmp_path: Path) -> None:
    sender = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
    stamp = struct.pack(">Q", round(START.timestamp() * 1e6))
    data = b"".join(
        stamp[:-1] + bytes([k]) + sender.global_position_int_encode(k, 10**7, 10**7, 0, 0, 0, 0, 0, 0).pack(sender)
        for k in range(5)
    )
    (tmp_path / "a.tlog").write_bytes(data)
    with pytest.raises(PictureError, match="no attitudes are in it"):
        read_log(tmp_path / "a.tlog")


def test_a_gap_of_the_places_stays_one_though_attitudes_go_on(tmp_path: Path) -> None:
    before = write_tlog(tmp_path / "a.tlog", STRAIGHT, 0.0, 2.0).read_bytes()
    after = write_tlog(tmp_path / "b.tlog", STRAIGHT, 7.0, 9.0).read_bytes()
    sender = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
    between = b"".join(
        struct.pack(">Q", round((START.timestamp() + at) * 1e6))
        + sender.attitude_encode(0, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0).pack(sender)
        for at in np.arange(2.0, 7.0, 0.05).tolist()
    )
    (tmp_path / "c.tlog").write_bytes(before + between + after)
    course = read_log(tmp_path / "c.tlog").course
    known = course.covers(START.timestamp() + np.array([1.0, 4.0, 8.0]))
    assert known.tolist() == [True, False, True]


def test_attitudes_between_two_places_are_kept(tmp_path: Path) -> None:
    log = write_tlog(tmp_path / "a.tlog", STRAIGHT, 0.0, 6.0, rate=1.0)
    sender = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
    stamp = struct.pack(">Q", round((START.timestamp() + 2.5) * 1e6))
    sway = sender.attitude_encode(0, 0.2, 0.0, math.pi / 2, 0.0, 0.0, 0.0).pack(sender)
    log.write_bytes(log.read_bytes() + stamp + sway)
    at = read_log(log).course.at(START.timestamp() + np.array([2.5]))
    assert at.attitude[0, 0] == pytest.approx(0.2, abs=1e-3)
    _, longitude, _ = STRAIGHT.geodetic(2.5)
    assert at.longitude[0] == pytest.approx(longitude, abs=2e-7)
