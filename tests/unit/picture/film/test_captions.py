from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from hawk.picture.film.captions import beside, parse_captions, read_captions
from hawk.picture.values import PictureError

MAVIC_3 = """1
00:00:00,000 --> 00:00:00,198
<font size="28">FrameCnt: 1, DiffTime: 198ms
2025-04-09 09:15:02.655
[iso: 170] [shutter: 1/99.77] [fnum: 4.4] [ev: 0] [color_md : default] [ae_meter_md: 1] [focal_len: 24.00] \
[dzoom_ratio: 1.00], [latitude: 53.388452] [longitude: 5.361783] [rel_alt: 55.774 abs_alt: 98.364] \
[gb_yaw: -83.6 gb_pitch: -89.1 gb_roll: 0.0] </font>

2
00:00:00,198 --> 00:00:00,396
<font size="28">FrameCnt: 2, DiffTime: 198ms
2025-04-09 09:15:02.837
[iso: 170] [focal_len: 24.00] [dzoom_ratio: 1.00], [latitude: 53.388462] [longitude: 5.361783] \
[rel_alt: 55.759 abs_alt: 98.349] [gb_yaw: -83.6 gb_pitch: -89.1 gb_roll: 0.0] </font>
"""
AIR_2S = """1
00:00:00,000 --> 00:00:00,033
<font size="36">SrtCnt : 1, DiffTime : 33ms
2022-08-07 13:40:40,774,808
[iso : 100] [shutter : 1/80.0] [fnum : 280] [ev : 0] [ct : 5744] [color_md : default] [focal_len : 240] \
[latitude: 41.424724] [longtitude: 2.234156] [altitude: 117.000000] </font>

2
00:00:00,033 --> 00:00:00,066
<font size="36">SrtCnt : 2, DiffTime : 33ms
2022-08-07 13:40:40,808,164
[focal_len : 240] [latitude: 41.424725] [longtitude: 2.234147] [altitude: 117.000000] </font>
"""
MAVIC_PRO = """1
00:00:01,000 --> 00:00:02,000
HOME(131.1660,-25.2088) 2017.07.29 15:18:50
GPS(131.1660,-25.2088,14) BAROMETER:8.8
ISO:100 Shutter:60 EV: Fnum:2.2

2
00:00:02,000 --> 00:00:03,000
HOME(131.1660,-25.2088) 2017.07.29 15:18:51
GPS(131.1661,-25.2088,14) BAROMETER:8.9
ISO:100 Shutter:60 EV: Fnum:2.2
"""
MATRICE_300 = """1
00:00:58,000 --> 00:00:59,000
2022.06.21 16:07:15
GPS(36.6153,-6.1130,0.0M) BAROMETER:83.3M

2
00:00:59,000 --> 00:00:60,000
2022.06.21 16:07:16
GPS(36.6154,-6.1132,0.0M) BAROMETER:84.0M
"""
PHANTOM_4_RTK = """36
00:00:35,000 --> 00:00:36,000
F/6.3, SS 60, ISO 100, EV 0, RTK (120.083799, 30.213635, 28), HOME (120.084146, 30.214243, 103.55m), D 75.36m, \
H 76.19m, H.S 0.30m/s, V.S 0.00m/s, F.PRY (-5.3\u00b0, 2.1\u00b0, 28.3\u00b0), \
G.PRY (-90.0\u00b0, 0.0\u00b0, 28.2\u00b0)
"""


@pytest.mark.parametrize(
    ("text", "place", "height", "altitude", "focal"),
    [
        (MAVIC_3, (53.388452, 5.361783), 55.774, 98.364, 24.0),
        (AIR_2S, (41.424724, 2.234156), None, 117.0, 24.0),
        (MAVIC_PRO, (-25.2088, 131.1660), 8.8, None, None),
        (MATRICE_300, (36.6153, -6.1130), 83.3, None, None),
        (PHANTOM_4_RTK, (30.213635, 120.083799), 76.19, None, None),
    ],
)
def test_captions_of_each_drone_are_read(
    text: str, place: tuple[float, float], height: float | None, altitude: float | None, focal: float | None
) -> None:
    first = parse_captions(text)[0]
    assert (first.latitude, first.longitude) == place
    assert (first.height, first.altitude, first.focal_mm, first.zoom) == (height, altitude, focal, 1.0)


def test_the_moment_is_that_of_the_drone_and_the_gimbals_angles_are_kept() -> None:
    first, second = parse_captions(MAVIC_3)
    assert first.moment == pytest.approx(1744190102.655)
    assert (first.gimbal, second.begin, second.end) == ((0.0, -89.1, -83.6), 0.198, 0.396)
    assert parse_captions(PHANTOM_4_RTK)[0].gimbal == (0.0, -90.0, 28.2)
    assert parse_captions(AIR_2S)[0].moment == pytest.approx(1659879640.774)


def test_a_camera_that_looks_down_is_level_with_the_yaw_of_its_gimbal(tmp_path: Path) -> None:
    file = tmp_path / "a.SRT"
    file.write_text(MAVIC_3.replace("-89.1", "-90.0"), encoding="utf-8")
    found = read_captions(file, 2, 5.0)
    assert found.course.attitude[0] == pytest.approx((0.0, 0.0, math.radians(-83.6)))
    assert found.focal_mm == 24.0
    assert found.course.epoch == pytest.approx(1744190102.646, abs=0.02)


def test_captions_of_a_frame_each_are_timed_by_their_count_and_others_by_their_span(tmp_path: Path) -> None:
    file = tmp_path / "a.SRT"
    file.write_text(MAVIC_3, encoding="utf-8")
    assert read_captions(file, 2, 30.0).course.time == pytest.approx([0.0, 1 / 30])
    assert read_captions(file, 12, 30.0).course.time == pytest.approx([0.0, 0.198])


def test_places_that_repeat_until_the_next_fix_are_one_and_a_stand_stays_one(tmp_path: Path) -> None:
    east = [0, 0, 0, 1, 1, 1, 2, 2, 2, *[2] * 20, 3, 3, 3]
    blocks = [
        f"{k + 1}\n00:00:{k / 10:06.3f} --> 00:00:{(k + 1) / 10:06.3f}\nFrameCnt: {k + 1}\n".replace(".", ",")
        + f"[latitude: 46.8] [longitude: {(step + 10) / 1e5:.6f}] [rel_alt: 30.0 abs_alt: 90.0]\n"
        for k, step in enumerate(east)
    ]
    file = tmp_path / "a.srt"
    file.write_text("\n".join(blocks), encoding="utf-8")
    course = read_captions(file, len(east), 10.0).course
    assert course.time[:3] == pytest.approx([0.0, 0.3, 0.6])
    assert course.time[-2:] == pytest.approx([2.9, 3.1])
    assert np.diff(course.time).max() < 1.2
    middle = course.at(np.array([0.15, 1.7]))
    assert middle.longitude == pytest.approx([10.5e-5, 12e-5])


@pytest.mark.parametrize(
    ("text", "frames", "words"),
    [
        ("", 60, "no caption is in it; copy it again"),
        (MAVIC_3, 3000, r"last 0 s, the film 100 s: they are another film's; name the right file by --log"),
        (MAVIC_3.replace("53.3884", "0.0000").replace("5.361783", "0.000000").replace("0.000052", "0.000000")
         .replace("0.000062", "0.000000"), 2, "say no place: the drone had no GPS fix.*--log"),
    ],
)  # fmt: skip
def test_captions_that_do_not_help_are_refused(tmp_path: Path, text: str, frames: int, words: str) -> None:
    file = tmp_path / "a.SRT"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(PictureError, match=words):
        read_captions(file, frames, 30.0)


def test_captions_that_cannot_be_read_are_refused(tmp_path: Path) -> None:
    with pytest.raises(PictureError, match="cannot be read"):
        read_captions(tmp_path / "none.SRT", 2, 30.0)


def test_the_file_beside_a_film_has_its_name_in_any_case(tmp_path: Path) -> None:
    (tmp_path / "DJI_1.SRT").touch()
    (tmp_path / "DJI_2.srt").touch()
    assert beside(tmp_path / "DJI_1.MP4", ".srt") == tmp_path / "DJI_1.SRT"
    assert beside(tmp_path / "DJI_2.MP4", ".srt") == tmp_path / "DJI_2.srt"
    assert beside(tmp_path / "DJI_3.MP4", ".srt") is None
    assert beside(tmp_path / "none" / "DJI_3.MP4", ".srt") is None


def test_digital_zoom_is_read_in_both_forms() -> None:
    assert parse_captions(MAVIC_3.replace("dzoom_ratio: 1.00", "dzoom_ratio: 1.77"))[0].zoom == 1.77
    assert parse_captions(AIR_2S.replace("[focal_len : 240]", "[dzoom_ratio: 20000, delta:0]"))[0].zoom == 2.0
