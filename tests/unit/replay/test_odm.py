"""Pictures for OpenDroneMap: their places, the lens, and the EXIF by which the lens is found."""

from __future__ import annotations

import errno
import json
import math
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from hawk.formats.image import decode
from hawk.model.frames import place_at
from hawk.model.operation import StateName
from hawk.model.pictures import CameraModel
from hawk.model.poses import MapPose
from hawk.replay.flight import RecordedFlight, ReplayError
from hawk.replay.odm import brown, camera_id, with_exif, write_odm
from tests.unit.replay.recordings import CAMERA, DATUM, flight, frame, jpeg, recorded_frame, tick, write


def test_each_picture_in_the_air_is_written_with_its_place(tmp_path: Path) -> None:
    mounted = replace(CAMERA, mount_pitch=0.2)
    items = [
        tick(10.5),
        recorded_frame(frame(1), 11.0),
        recorded_frame(frame(2, camera=mounted, jpeg=jpeg(200)), 12.0),
        recorded_frame(frame(3, pose=None), 13.0),
        recorded_frame(frame(4, state=StateName.ARM), 14.0),
        recorded_frame(frame(5, pose=MapPose(0.0, 0.0, 3.0, 0.0, 0.0, 0.0)), 15.0),
        recorded_frame(frame(6, map_problem="the position leapt"), 16.0),
        recorded_frame(frame(7, jpeg=b"\xff\xd8torn"), 17.0),
        recorded_frame(frame(8, camera=replace(CAMERA, fx=50.0)), 18.0),
    ]
    out = tmp_path / "out"
    done = write_odm(RecordedFlight(write(tmp_path / "a.mcap", items)), out)
    assert (done.pictures, done.left_out, done.unreadable, done.lens_error) == (2, 5, 1, 0.0)
    assert sorted(each.name for each in (out / "images").iterdir()) == ["00001.jpg", "00002.jpg"]
    projection, first, second = (out / "geo.txt").read_text().splitlines()
    assert projection == "EPSG:4326"
    name, *numbers = first.split()
    place = place_at(1.0, 2.0, DATUM)
    assert name == "00001.jpg"
    expected = [place.longitude, place.latitude, 60.0, math.degrees(0.5), math.degrees(0.1), 0.0]
    assert [float(each) for each in numbers] == pytest.approx(expected, abs=1e-3)
    assert [float(numbers[0]), float(numbers[1])] == pytest.approx([place.longitude, place.latitude], abs=2e-8)
    assert float(second.split()[5]) == pytest.approx(math.degrees(0.3), abs=1e-3)
    np.testing.assert_array_equal(decode((out / "images" / "00002.jpg").read_bytes()), decode(jpeg(200)))
    cameras = json.loads((out / "cameras.json").read_text())
    assert list(cameras) == [camera_id(CAMERA)] == ["v2 hawk drone 64 36 brown 0.7222"]


def test_lengths_are_shares_of_the_longer_side_from_the_middle_of_the_picture() -> None:
    model, error = brown(CameraModel(1280, 720, 900.0, 910.0, 659.5, 349.5, (0.1, -0.2, 0.01, -0.02, 0.05)))
    assert error == 0.0
    assert model == {
        "projection_type": "brown", "width": 1280, "height": 720, "focal_x": 900 / 1280, "focal_y": 910 / 1280,
        "c_x": 20 / 1280, "c_y": -10 / 1280, "k1": 0.1, "k2": -0.2, "p1": 0.01, "p2": -0.02, "k3": 0.05,
    }  # fmt: skip


def test_a_lens_of_eight_coefficients_is_fitted_and_the_error_is_that_of_its_pixels() -> None:
    lens = (0.3, -0.1, 0.001, -0.001, 0.01, 0.4, -0.1, 0.02)
    camera = CameraModel(1280, 720, 900.0, 900.0, 639.5, 359.5, lens)
    model, error = brown(camera)
    rows, columns = np.mgrid[0:720:60, 0:1280:80]
    rays = np.column_stack(((columns.ravel() - camera.cx) / 900, (rows.ravel() - camera.cy) / 900, np.ones(rows.size)))
    matrix = np.array([[900.0, 0, camera.cx], [0, 900.0, camera.cy], [0, 0, 1]])
    fitted = np.array([model[name] for name in ("k1", "k2", "p1", "p2", "k3")])
    real, _ = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), matrix, np.array(lens))
    ours, _ = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), matrix, fitted)
    apart = np.hypot(*(real - ours).reshape(-1, 2).T)
    assert 0.0 < apart.max() <= error + 0.05 < 1.0


def test_the_exif_names_the_camera_and_replaces_what_was_there() -> None:
    once = with_exif(jpeg(), CAMERA)
    assert with_exif(once, CAMERA) == once
    assert once.count(b"Exif\x00\x00") == 1
    assert b"hawk\x00drone\x00" in once
    np.testing.assert_array_equal(decode(once), decode(jpeg()))


def test_the_exif_is_tiff_with_the_focal_length_on_film() -> None:
    data = with_exif(jpeg(), CAMERA)
    tiff = data[data.index(b"Exif\x00\x00") + 6 :]
    first = _directory(tiff, int.from_bytes(tiff[4:8], "big"))
    assert tiff[:4] == b"MM\x00*"
    assert [_text(tiff, first[tag]) for tag in (0x010F, 0x0110)] == ["hawk", "drone"]
    inside = _directory(tiff, int.from_bytes(first[0x8769][4:], "big"))
    assert int.from_bytes(inside[0xA405][4:6], "big") == round(36 * CAMERA.fx / CAMERA.width)


def _directory(tiff: bytes, at: int) -> dict[int, bytes]:
    """Return by tag the count and value (8 bytes) of a directory's entries (TIFF 6.0, section 2)."""
    count = int.from_bytes(tiff[at : at + 2], "big")
    entries = (tiff[at + 2 + 12 * k : at + 14 + 12 * k] for k in range(count))
    return {int.from_bytes(each[:2], "big"): each[4:] for each in entries}


def _text(tiff: bytes, entry: bytes) -> str:
    count, at = int.from_bytes(entry[:4], "big"), int.from_bytes(entry[4:], "big")
    return tiff[at : at + count].rstrip(b"\x00").decode()


def test_pictures_up_to_the_damage_are_written_and_the_damage_named(tmp_path: Path) -> None:
    found = RecordedFlight(write(tmp_path / "a.mcap", flight(3), is_closed=False))
    assert write_odm(found, tmp_path / "out").pictures == 3
    assert "the file has no end" in found.damage


def test_a_recording_without_pictures_in_the_air_leaves_nothing(tmp_path: Path) -> None:
    found = RecordedFlight(write(tmp_path / "a.mcap", [tick(10.5), recorded_frame(frame(1, pose=None), 11.0)]))
    with pytest.raises(ReplayError, match=r"holds no pictures from 6 m .*name the recording of a flight that mapped"):
        write_odm(found, tmp_path / "out")
    assert [each.name for each in tmp_path.iterdir()] == ["a.mcap"]


def test_a_full_disk_leaves_nothing_and_says_the_remedy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = RecordedFlight(write(tmp_path / "a.mcap", flight(3)))
    with pytest.raises(ReplayError, match="0 MB are free, 50 are needed: delete old files"):
        write_odm(found, tmp_path / "out", lambda _: 0)

    def full(*_: object) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(ReplayError, match="No space left on device; delete old files"):
        write_odm(found, tmp_path / "out")
    assert [each.name for each in tmp_path.iterdir()] == ["a.mcap"]
