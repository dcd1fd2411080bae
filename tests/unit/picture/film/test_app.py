from __future__ import annotations

import math
import shlex
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hawk.formats.image import NoImage
from hawk.model.pictures import CameraModel
from hawk.picture.film.app import Film, read_film
from hawk.picture.film.lens import LensChoice
from hawk.picture.photographs.heights import doubt_of
from hawk.picture.reconstruction.camera_pose import CameraPose
from hawk.picture.values import PictureError
from tests.unit.picture.film.conftest import STOPPED, STRAIGHT
from tests.unit.picture.film.films import (
    FPS,
    HEIGHT,
    LENS,
    SIZE,
    START,
    Flight,
    captions,
    write_bin,
    write_film,
    write_tlog,
)

CHOICE = LensChoice(calibration=LENS)


def _with_captions(folder: Path, film: Path, text: str) -> Path:
    copy = folder / film.name
    copy.hardlink_to(film)
    copy.with_suffix(".SRT").write_text(text, encoding="utf-8")
    return copy


def _spacing(film: Film) -> np.ndarray:
    assert film.shots
    longitude = np.array([shot.longitude for shot in film.shots])
    return np.diff(longitude) * 111_320 * math.cos(math.radians(film.shots[0].latitude))


@pytest.mark.slow
def test_frames_follow_the_ground_with_the_places_of_their_captions(tmp_path: Path, straight_film: Path) -> None:
    film = read_film(_with_captions(tmp_path, straight_film, captions(STRAIGHT)), lens=CHOICE)
    quarter = 0.25 * HEIGHT * SIZE[1] / LENS.fx
    assert (_spacing(film) > 0.75 * quarter).all()
    assert (_spacing(film)[:-1] < 1.5 * quarter).all()
    assert not film.left_out
    for shot in film.shots:
        assert shot.frame is not None
        latitude, longitude, altitude = STRAIGHT.geodetic(shot.frame / FPS)
        assert (shot.latitude, shot.longitude) == pytest.approx((latitude, longitude), abs=2e-7)
        assert (shot.altitude, shot.height) == pytest.approx((altitude, HEIGHT), abs=0.01)
        assert shot.attitude == pytest.approx((0.0, 0.0, math.pi / 2))
        assert shot.time == pytest.approx(START.timestamp() + shot.frame / FPS, abs=0.002)
        assert shot.velocity == pytest.approx((0.0, 5.0), abs=0.3)
        assert shot.name == f"DJI_0001.MP4, frame {shot.frame}"


def test_pictures_show_where_their_shots_were_taken(tmp_path: Path, straight_film: Path) -> None:
    film = read_film(_with_captions(tmp_path, straight_film, captions(STRAIGHT)), lens=CHOICE)
    first, last = film.shots[0], film.shots[2]
    east = float(_spacing(film)[:2].sum())
    before, after = film.picture(first), film.picture(last)
    posed = [
        CameraPose(shot.camera, 0.0, at, HEIGHT, shot.attitude or (0, 0, 0)) for shot, at in ((first, 0), (last, east))
    ]
    ground = posed[0].ground(np.array([[160.0, 30.0]]))
    here, there = (np.rint(each.pixels(ground)[0]).astype(int) for each in posed)
    patches = [
        picture[y - 8 : y + 9, x - 8 : x + 9].astype(float) for picture, (x, y) in ((before, here), (after, there))
    ]
    assert np.abs(patches[0] - patches[1]).mean() < 12.0
    elsewhere = after[there[1] - 40 : there[1] - 23, there[0] - 8 : there[0] + 9].astype(float)
    assert np.abs(patches[0] - elsewhere).mean() > 15.0


def test_pictures_come_alike_forward_and_back(tmp_path: Path, straight_film: Path) -> None:
    film = read_film(_with_captions(tmp_path, straight_film, captions(STRAIGHT)), lens=CHOICE)
    forward = [film.picture(shot) for shot in film.shots]
    back = [film.picture(shot) for shot in reversed(film.shots)][::-1]
    for one, other in zip(forward, back, strict=True):
        assert np.abs(one.astype(int) - other).mean() < 0.5
    film.close()


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["tlog", "bin"])
def test_the_clock_is_fitted_to_a_log_by_the_motion(tmp_path: Path, stopped_film: Path, kind: str) -> None:
    log = tmp_path / f"flight.{kind}"
    if kind == "tlog":
        write_tlog(log, STOPPED, -13.37, 25.0)
    else:
        write_bin(log, STOPPED, -7.77, 25.0)
    film = read_film(stopped_film, log=log, lens=CHOICE)
    begin = 13.37 if kind == "tlog" else 7.77
    said = float(film.notes[0].split("begins ")[1].split(" s")[0])
    assert said == pytest.approx(begin, abs=0.06)
    assert any("taken as fixed" in note for note in film.notes)
    for shot in film.shots:
        assert shot.frame is not None
        latitude, longitude, _ = STOPPED.geodetic(shot.frame / FPS)
        off = (shot.longitude - longitude) * 111_320 * math.cos(math.radians(latitude))
        assert abs(off) < 0.4
        assert not shot.has_gimbal
        assert shot.time == pytest.approx(START.timestamp() + shot.frame / FPS, abs=0.08)
    stands = [shot.frame for shot in film.shots if shot.frame is not None and 3.3 < shot.frame / FPS < 4.9]
    assert not stands


@pytest.mark.slow
def test_a_log_beside_the_film_is_found(tmp_path: Path, stopped_film: Path) -> None:
    copy = tmp_path / "film.MP4"
    copy.hardlink_to(stopped_film)
    write_tlog(tmp_path / "film.tlog", STOPPED, -4.0, 20.0)
    assert len(read_film(copy, lens=CHOICE).shots) > 6


@pytest.mark.slow
def test_frames_that_the_log_does_not_cover_are_left_out_and_counted(tmp_path: Path, stopped_film: Path) -> None:
    film = read_film(stopped_film, log=write_tlog(tmp_path / "a.tlog", STOPPED, -3.0, 8.0), lens=CHOICE)
    (left,) = film.left_out
    assert left.name.endswith(f"frames of {stopped_film.name}")
    assert int(left.name.split()[0]) == pytest.approx(21, abs=2)
    assert "do not cover them" in left.reason


@pytest.mark.slow
def test_an_offset_that_is_given_is_refined_near_it_only(tmp_path: Path, stopped_film: Path) -> None:
    log = write_tlog(tmp_path / "a.tlog", STOPPED, -20.0, 30.0)
    film = read_film(stopped_film, log=log, log_offset_s=18.0, lens=CHOICE)
    assert "begins 20.0" in film.notes[0]
    with pytest.raises(PictureError, match="agrees with the log nowhere near --log-offset"):
        read_film(stopped_film, log=log, log_offset_s=38.0, lens=CHOICE)
    with pytest.raises(PictureError, match=r"--log-offset 400: the log ends after 50 s.*does not cover it"):
        read_film(stopped_film, log=log, log_offset_s=400.0, lens=CHOICE)


@pytest.mark.slow
def test_a_log_of_another_flight_is_refused(tmp_path: Path, stopped_film: Path) -> None:
    log = write_tlog(tmp_path / "a.tlog", STOPPED, 10.5, 40.0)
    with pytest.raises(PictureError, match=r"agrees with (the log nowhere|several parts).*--log-offset"):
        read_film(stopped_film, log=log, lens=CHOICE)
    with pytest.raises(PictureError, match="the log covers 3 s, the film 10 s; name the log of the whole flight"):
        read_film(stopped_film, log=write_tlog(tmp_path / "b.tlog", STOPPED, 1.0, 4.0), lens=CHOICE)


@pytest.mark.slow
def test_steady_flight_fits_at_several_places_and_is_asked_for(tmp_path: Path, straight_film: Path) -> None:
    log = write_tlog(tmp_path / "a.tlog", STRAIGHT, -30.0, 40.0)
    with pytest.raises(PictureError, match="agrees with several parts of the log; give the second"):
        read_film(straight_film, log=log, lens=CHOICE)


def test_a_film_without_a_log_is_refused(straight_film: Path) -> None:
    with pytest.raises(PictureError, match=r"no captions \(DJI_0001.SRT\) and no log.*--log"):
        read_film(straight_film, lens=CHOICE)


def test_a_film_with_its_captions_in_a_track_is_refused_with_the_command_that_writes_them(
    tmp_path: Path, straight_film: Path
) -> None:
    if shutil.which("ffmpeg") is None:
        pytest.skip("ffmpeg is not installed; test_container sees the track")
    given, film = tmp_path / "given.srt", tmp_path / "DJI_0001.MP4"
    given.write_text(captions(STRAIGHT), encoding="utf-8")
    both = ["-i", str(straight_film), "-i", str(given), "-c:v", "copy", "-c:s", "mov_text", str(film)]
    subprocess.run(["ffmpeg", "-v", "error", *both], check=True)
    with pytest.raises(PictureError, match="its captions are a track of the film itself") as refused:
        read_film(film, lens=CHOICE)
    words = str(refused.value)
    subprocess.run(shlex.split(words[words.index("ffmpeg -i") :]), check=True, capture_output=True)
    assert read_film(film, lens=CHOICE).shots


def test_logs_of_other_kinds_and_lost_ones_are_refused(tmp_path: Path, straight_film: Path) -> None:
    with pytest.raises(PictureError, match=r"--log .*a.csv: must be DJI's captions"):
        read_film(straight_film, log=tmp_path / "a.csv", lens=CHOICE)
    with pytest.raises(PictureError, match=r"a.tlog: is not there"):
        read_film(straight_film, log=tmp_path / "a.tlog", lens=CHOICE)


def test_captions_without_heights_ask_for_one(tmp_path: Path, straight_film: Path) -> None:
    text = captions(STRAIGHT).replace("rel_alt", "none")
    film = _with_captions(tmp_path, straight_film, text)
    with pytest.raises(PictureError, match=r"gives no height above the ground; give the flight's height.*--height"):
        read_film(film, lens=CHOICE)
    shots = read_film(film, lens=CHOICE, height_m=30.0).shots
    assert [shot.height for shot in shots] == pytest.approx([30.0] * len(shots), abs=0.01)
    with pytest.raises(PictureError, match="--height 900: must be above 0"):
        read_film(film, lens=CHOICE, height_m=900.0)


def test_an_altitude_above_the_sea_is_no_height(tmp_path: Path, straight_film: Path) -> None:
    film = _with_captions(tmp_path, straight_film, captions(STRAIGHT).replace("rel_alt: 30.000", "rel_alt: 230.000"))
    assert "is its altitude above the sea" in doubt_of(read_film(film, lens=CHOICE).shots)


def test_frames_that_look_ahead_or_stand_on_the_ground_are_refused(tmp_path: Path, straight_film: Path) -> None:
    film = _with_captions(tmp_path, straight_film, captions(STRAIGHT, pitch=-45.0))
    with pytest.raises(PictureError, match=r"no frame of it can be used: 80 frames.*more than 25 degrees"):
        read_film(film, lens=CHOICE)
    film.with_suffix(".SRT").write_text(captions(STRAIGHT).replace("rel_alt: 30", "rel_alt: 1"), encoding="utf-8")
    with pytest.raises(PictureError, match=r"80 frames .* were taken below 3 m"):
        read_film(film, lens=CHOICE)


def test_captions_without_a_gimbal_leave_the_attitude_open(tmp_path: Path, straight_film: Path) -> None:
    film = read_film(_with_captions(tmp_path, straight_film, captions(STRAIGHT, gimbal=False)), lens=CHOICE)
    assert {shot.attitude for shot in film.shots} == {None}
    assert any("its yaw is not known" in note for note in film.notes)


@pytest.mark.slow
def test_a_film_that_breaks_off_gives_what_it_has(tmp_path: Path) -> None:
    whole = write_film(tmp_path / "DJI_1.avi", STRAIGHT, fourcc="MJPG")
    data = whole.read_bytes()
    whole.write_bytes(data[: len(data) // 2])
    whole.with_suffix(".srt").write_text(captions(STRAIGHT), encoding="utf-8")
    film = read_film(whole, lens=CHOICE)
    assert 2 <= len(film.shots) <= 5
    assert any("damaged or torn off" in each.reason for each in film.left_out) or film.shots[-1].frame is not None
    lost = [shot for shot in film.shots if (shot.frame or 0) > 50]
    assert not lost


def test_a_film_that_is_none_is_refused(tmp_path: Path) -> None:
    bad = tmp_path / "a.MP4"
    bad.write_bytes(b"no film" * 100)
    bad.with_suffix(".SRT").write_text(captions(STRAIGHT), encoding="utf-8")
    with pytest.raises(PictureError, match="cannot be read as a film: it is of no kind that is known; copy it again"):
        read_film(bad)
    with pytest.raises(PictureError, match=r"is no film that is read: .mp4"):
        read_film(tmp_path / "a.doc")


def test_a_shot_without_a_frame_has_no_picture(tmp_path: Path, straight_film: Path) -> None:
    film = read_film(_with_captions(tmp_path, straight_film, captions(STRAIGHT)), lens=CHOICE)
    with pytest.raises(ValueError, match="is no frame of a film"):
        film.picture(replace(film.shots[0], frame=None))
    with pytest.raises(NoImage, match="torn"):
        film.picture(replace(film.shots[0], frame=9000))


def test_without_pymavlink_a_log_is_refused_with_the_remedy(
    tmp_path: Path, straight_film: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = write_tlog(tmp_path / "a.tlog", STRAIGHT)
    monkeypatch.setitem(sys.modules, "pymavlink", None)
    with pytest.raises(PictureError, match=r"pymavlink is not installed, which reads .tlog logs"):
        read_film(straight_film, log=log, lens=CHOICE)


@pytest.mark.slow
@pytest.mark.parametrize(("turn", "side"), [(0.5, "left"), (1.0, "tail"), (-0.5, "right")])
def test_a_camera_whose_top_is_to_another_side_is_found_by_the_motion(
    tmp_path: Path, stopped_film: Path, turn: float, side: str
) -> None:
    """The film's picture has its top ahead; a log whose drone heads elsewhere is that of a turned camera."""
    drone = Flight(lambda at: (*STOPPED.place(at)[:2], STOPPED.place(at)[2] + turn * math.pi), STOPPED.seconds)
    log = write_tlog(tmp_path / "a.tlog", drone, -13.37, 25.0)
    film = read_film(stopped_film, log=log, lens=CHOICE)
    assert film.notes[1].endswith(f"its picture's top to the {side}")
    assert film.shots[0].attitude == pytest.approx((0.0, 0.0, math.pi / 2), abs=1e-3)


@pytest.mark.slow
def test_a_mount_that_is_given_turns_the_camera_of_a_log(tmp_path: Path, stopped_film: Path) -> None:
    turned = CameraModel(*SIZE, LENS.fx, LENS.fy, LENS.cx, LENS.cy, mount_yaw=-math.pi / 4)
    drone = Flight(lambda at: (*STOPPED.place(at)[:2], STOPPED.place(at)[2] + math.pi / 4), STOPPED.seconds)
    log = write_tlog(tmp_path / "a.tlog", drone, -13.37, 25.0)
    film = read_film(stopped_film, log=log, lens=LensChoice(calibration=turned))
    assert film.shots[0].attitude == pytest.approx((0.0, 0.0, math.pi / 2), abs=1e-3)
    assert film.shots[0].camera == LENS


def test_a_film_copied_without_its_end_is_refused(tmp_path: Path, straight_film: Path) -> None:
    torn = tmp_path / "DJI_0001.MP4"
    shutil.copyfile(straight_film, torn)
    with torn.open("r+b") as stream:
        stream.truncate(torn.stat().st_size // 2)
    torn.with_suffix(".SRT").write_text(captions(STRAIGHT), encoding="utf-8")
    with pytest.raises(PictureError, match="torn"):
        read_film(torn, lens=CHOICE)


def test_a_film_that_the_disk_loses_while_it_is_read_is_refused(
    tmp_path: Path, straight_film: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    film = _with_captions(tmp_path, straight_film, captions(STRAIGHT))

    def lost(path: Path) -> None:
        raise OSError(5, "Input/output error", str(path))

    monkeypatch.setattr("hawk.picture.film.app.read_made", lost)
    with pytest.raises(PictureError, match=r"cannot be read \(Input/output error\); copy it again"):
        read_film(film, lens=CHOICE)
