from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from hawk.formats.image import NoImage
from hawk.picture.film.app import read_film
from hawk.picture.film.recording import read_frames
from hawk.picture.reconstruction.camera_pose import CameraPose
from hawk.picture.values import PictureError
from tests.reference.kept import unpack


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return unpack("survey", tmp_path_factory.mktemp("recording"))


@pytest.mark.nightly
def test_a_recording_is_a_film_with_its_own_poses_and_camera(recording: Path) -> None:
    film, read = read_film(recording), read_frames(recording)
    assert 5 < len(film.shots) < len(read.numbers) / 2
    by_number = {number: row for row, number in enumerate(read.numbers)}
    for shot in film.shots:
        row = by_number[shot.frame or 0]
        assert (shot.latitude, shot.longitude) == (read.course.latitude[row], read.course.longitude[row])
        assert (shot.camera, shot.camera.mount_yaw) == (read.cameras[row], 0.0)
        assert shot.height is not None
        assert 3.0 < shot.height < 100.0
        assert shot.time is not None
        assert film.picture(shot).shape == (shot.camera.height, shot.camera.width, 3)
    assert any(each.reason.startswith("were taken on the ground") for each in film.left_out)


@pytest.mark.slow
def test_neighbours_show_the_same_ground_where_their_poses_say(recording: Path) -> None:
    film = read_film(recording)
    agree = []
    for first, second in pairwise(film.shots):
        scale = 111_194.9
        posed = [
            CameraPose(
                shot.camera, shot.latitude * scale, shot.longitude * scale * math.cos(math.radians(first.latitude)),
                shot.height or 0.0, shot.attitude or (0.0, 0.0, 0.0),
            )
            for shot in (first, second)
        ]  # fmt: skip
        size = np.array([first.camera.width, first.camera.height])
        grid = np.stack(np.meshgrid(*(np.linspace(0.25, 0.75, 25) * side for side in size)), -1).reshape(-1, 2)
        there = posed[1].pixels(posed[0].ground(grid))
        inside = ((there > 4) & (there < size - 5)).all(axis=1)
        pictures = [film.picture(shot).mean(axis=2) for shot in (first, second)]
        values = [
            picture[np.rint(at[inside, 1]).astype(int), np.rint(at[inside, 0]).astype(int)]
            for picture, at in zip(pictures, (grid, there), strict=True)
        ]
        agree.append(np.corrcoef(*values)[0, 1])
    assert np.median(agree) > 0.6


@pytest.mark.slow
def test_pictures_come_alike_in_any_order(recording: Path) -> None:
    film = read_film(recording)
    first, last = film.shots[0], film.shots[-1]
    before = film.picture(first)
    film.picture(last)
    assert np.array_equal(film.picture(first), before)
    film.close()
    with pytest.raises(NoImage, match="not in the recording"):
        read_film(recording).frames.frame(10**6)


def test_a_file_that_is_no_recording_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.mcap").write_bytes(b"nothing")
    with pytest.raises(PictureError, match=r"a\.mcap.*name a recording"):
        read_film(tmp_path / "a.mcap")
    with pytest.raises(PictureError, match="cannot be read"):
        read_film(tmp_path / "b.mcap")


@pytest.mark.nightly
def test_a_recording_that_breaks_off_gives_what_it_has(recording: Path, tmp_path: Path) -> None:
    torn = tmp_path / "torn.mcap"
    torn.write_bytes(recording.read_bytes()[: recording.stat().st_size // 2])
    film, whole = read_film(torn), read_film(recording)
    assert 1 <= len(film.shots) < len(whole.shots)
    assert film.notes
    assert film.notes[0].startswith("The rest of torn.mcap is missing")
