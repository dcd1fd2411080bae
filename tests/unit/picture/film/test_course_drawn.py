"""All that is read of captions and paths of many kinds, and of lenses and frames: values, notes and refusals."""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from hawk.model.pictures import CameraModel
from hawk.picture.film.captions import Captions, parse_captions, read_captions
from hawk.picture.film.course import Course
from hawk.picture.film.lens import LensChoice, lens_of
from hawk.picture.film.motion import expected
from hawk.picture.film.pace import plan
from hawk.picture.values import PictureError
from tests.golden import check_values
from tests.unit.picture.film.films import LENS
from tests.unit.picture.film.test_captions import AIR_2S, MATRICE_300, MAVIC_3, MAVIC_PRO

HERE = Path(__file__).parent / "drawn"
PHANTOM_4 = """1
00:00:01.5 --> 01:02:03,25
RTK (120.083799, 30.213635, 28), HOME (120.08, 30.21, 5), D 75.36m, H 76.19m, G.PRY (-40.0°, 1.5°, 28.2°)
FrameCnt : 7 2024.02.30 10:00:00 dzoom_ratio: 12500, focal_len: 235

2
00:00:02,000 --> 00:00:03,000
GPS (36.6153, 95.5, 0.0M) [gb_yaw: 10 gb_pitch: -60] 2024-02-28 10:00:00.5 [latitude: 0.0] [longitude: 0.0]

3
00:00:04,000 --> 00:00:05,000
[latitude: 91.0] [longitude: 5.0] [abs_alt: -3.5] dzoom_ratio: 1.50
"""


def plain(value: Any) -> Any:
    """Return a value as JSON with 8 decimals; null for what is not a number."""
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, Course | Captions) or hasattr(value, "__dataclass_fields__"):
        return plain(asdict(value))
    if isinstance(value, dict):
        return {key: plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [plain(each) for each in value]
    if isinstance(value, float):
        return None if math.isnan(value) else round(value, 8) + 0.0
    return bool(value) if isinstance(value, np.bool_) else value


def test_captions_of_every_form() -> None:
    texts = {
        "air 2s": AIR_2S,
        "matrice 300": MATRICE_300,
        "mavic 3": MAVIC_3,
        "mavic pro": MAVIC_PRO,
        "phantom 4": PHANTOM_4,
    }
    check_values(HERE / "captions.json", plain({name: parse_captions(text) for name, text in texts.items()}), digits=8)


def _srt(places: list[tuple[float, float]], each_s: float, more: str = "") -> str:
    blocks = []
    for k, (latitude, longitude) in enumerate(places):
        begin, end = (divmod(round(1000 * each_s * at), 1000) for at in (k, k + 1))
        span = f"00:00:{begin[0]:02d},{begin[1]:03d} --> 00:00:{end[0]:02d},{end[1]:03d}"
        blocks.append(
            f"{k + 1}\n{span}\n{more.format(k + 1)}[latitude: {latitude}] [longitude: {longitude}] [rel_alt: 20.5]"
        )
    return "\n\n".join(blocks)


def test_courses_by_captions(tmp_path: Path) -> None:
    stands = (
        [(46.0, -91.0)] * 4
        + [(46.0 + 1e-5 * k, -91.0) for k in range(4)]
        + [(46.00003, -91.0)] * 8
        + [(46.0001, -91.0)]
    )
    cases = {
        "a caption a second": (_srt(stands, 1.0), 170, 10.0),
        "a frame each": (_srt(stands, 0.1, "FrameCnt: {} "), 17, 10.0),
        "two frames more": (_srt(stands, 0.1, "SrtCnt: {} "), 19, 10.0),
        "three more": (_srt(stands, 1.0, "SrtCnt: {} "), 20, 1.0),
        "another film's": (_srt(stands, 1.0), 206, 10.0),
        "three seconds off": (_srt(stands, 1.0), 200, 10.0),
        "coarse": (MAVIC_PRO, 30, 10.0),
        "no place": (PHANTOM_4.replace("120.", "220."), 50, 10.0),
        "empty": ("", 10, 10.0),
    }
    found: dict[str, Any] = {}
    for name, (text, frames, fps) in cases.items():
        (tmp_path / "film.SRT").write_text(text, "utf-8")
        try:
            found[name] = plain(read_captions(tmp_path / "film.SRT", frames, fps))
        except PictureError as refused:
            found[name] = str(refused).removeprefix(f"{tmp_path}/")
    check_values(HERE / "courses.json", found, digits=8)


def course(epoch: float | None = 5.0) -> Course:
    """Return a flight over the 180th meridian that climbs, stands, turns and misses an attitude."""
    time = np.array([0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 6.0, 6.5, 7.0])
    longitude = np.array(
        [179.9999, 179.99995, 180.0, -179.99995, -179.9999, -179.9999, -179.9999, -179.9998, -179.9997]
    )
    height = np.array([0.0, 1.0, 2.9, 3.1, 20.0, np.nan, 20.0, 21.0, 22.0])
    yaw = np.array([3.0, 3.1, -3.1, -3.0, -2.9, np.nan, -2.0, -1.9, 0.5])
    attitude = np.column_stack([np.linspace(0.0, 0.5, 9), np.linspace(0.0, -0.3, 9), yaw])
    return Course(time, 46.0 + 1e-5 * time, longitude, height + 100.0, height, attitude, (2.0, 3.0), epoch)


def test_what_a_course_says() -> None:
    flown, times = course(), np.array([-0.11, -0.1, 0.25, 1.25, 2.25, 4.0, 6.25, 7.1, 7.11])
    bare = Course(
        flown.time, flown.latitude, flown.longitude, flown.altitude * np.nan, flown.height * np.nan, flown.attitude
    )
    check_values(
        HERE / "course.json",
        plain(
            {
                "at": flown.at(times),
                "covers": flown.covers(times),
                "metres": flown.metres(),
                "velocity": flown.velocity(),
                "about": flown.metres((46.0, 180.0)),
                "turning": flown.turning(),
                "tilt": flown.tilt(),
                "levelled": flown.levelled(),
                "shifted": flown.shifted(2.5).time,
                "epochs": [flown.shifted(2.5).epoch, course(None).shifted(2.5).epoch],
                "heights": [flown.with_heights(height).height for height in (None, 50.0)],
                "by altitude": Course(
                    flown.time, flown.latitude, flown.longitude, flown.altitude, bare.height, flown.attitude
                )
                .with_heights(9.0)
                .height,
                "none known": bare.with_heights(30.0).height,
                "expected": expected(flown, np.array([0.0, 0.6, 1.6, 6.1]), 0.3),
            }
        ),
        digits=8,
    )


def test_frames_that_are_due() -> None:
    time = np.arange(0.0, 20.0, 0.1)
    north = np.concatenate([np.linspace(0, 30, 80), np.full(40, 30.0), np.linspace(30, 90, 80)])
    roll = np.where((time > 3) & (time < 3.6), math.radians(26), 0.0)
    yaw = np.where(time > 9, np.minimum((time - 9) * 1.2, 1.5), 0.0)
    height = np.where(time < 0.7, 2.9, 30.0)
    flown = Course(
        time, 46.0 + north / 111_194.9, np.full(200, -91.0), height, height, np.column_stack([roll, 0 * roll, yaw])
    )
    covered = np.ones(200, np.bool_)
    covered[150:158] = False
    found = {
        name: plan(flown, each, LENS) for name, each in (("flight", covered), ("nothing", ~np.ones(200, np.bool_)))
    }
    check_values(HERE / "due.json", plain(found))


def test_lenses_of_films() -> None:
    size, own = (
        (1920, 1080),
        CameraModel(3840, 2160, 3000.0, 3001.0, 1919.5, 1079.5, (0.1, 0.0, 0.0, 0.0, 0.0), mount_yaw=0.5),
    )
    cases: dict[str, tuple[tuple[int, int], LensChoice, str, float | None, float]] = {
        "calibrated": (size, LensChoice(calibration=own, hfov_deg=70.0), "FC330", 24.0, 2.0),
        "calibrated for another shape": ((1920, 1440), LensChoice(calibration=own), "", None, 1.0),
        **{
            f"hfov {each}": (size, LensChoice(hfov_deg=each, focal35_mm=30.0), "", None, 9.0)
            for each in (4.9, 5.0, 70.0, 160.0, 160.1)
        },
        **{
            f"focal35 {each}": (size, LensChoice(focal35_mm=each), "", None, 9.0)
            for each in (7.9, 8.0, 24.0, 500.0, 501.0)
        },
        "zoomed": (size, LensChoice(), "FC330", 24.0, 1.02),
        "hardly zoomed": (size, LensChoice(), "", 24.0, 1.01),
        "captions": (size, LensChoice(), "", 24.0, 1.0),
        "captions of 7 mm": (size, LensChoice(), "", 7.0, 1.0),
        "captions of 9 mm": (size, LensChoice(), "", 9.0, 1.0),
        "table": (size, LensChoice(), "FC330", 24.0, 1.0),
        "table by its name": (size, LensChoice(model="FC330"), "", None, 1.0),
        "no entry": (size, LensChoice(model="none"), "FC330", 24.0, 1.0),
        "nothing": (size, LensChoice(), "", None, 1.0),
    }
    found: dict[str, Any] = {}
    for name, case in cases.items():
        try:
            found[name] = plain(lens_of("film.mp4", *case))
        except PictureError as refused:
            found[name] = str(refused)
    check_values(HERE / "lenses.json", found, digits=8)
