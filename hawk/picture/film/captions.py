"""DJI's captions beside a film (.SRT): the drone's path by the film's frames.

DJI has no specification; the forms are those of real files:

- a frame each, in brackets: ``[latitude: 53.388452] [longitude: 5.361783] [rel_alt: 55.774 abs_alt: 98.364] [gb_yaw:
  -83.6 gb_pitch: -9.1 gb_roll: 0.0]`` behind ``FrameCnt: 1`` or ``SrtCnt : 1``, which begins at 0 or 1; older ones have
  ``[altitude: 117.0]`` above the sea alone, or ``longtitude`` (github.com/JuanIrache/DJI_SRT_Parser, samples/air2s.srt;
  github.com/OpenDroneMap/ODM, opendm/video/srtparser.py)
- a second each: ``GPS(131.1660,-25.2088,14) BAROMETER:8.8`` beside ``HOME(131.1660,-25.2088)``, longitude first
  (samples/sample2.SRT, Mavic Pro); ``GPS(36.6146,-6.1120,0.0M) BAROMETER:8.4M``, latitude first
  (samples/matrice_300.srt)
- a second each: ``RTK (120.083799, 30.213635, 28), HOME (...), D 75.36m, H 76.19m, ... G.PRY (-40.0°, 0.0°, 28.2°)``,
  longitude first, the gimbal's pitch, roll, yaw (Phantom 4 RTK; ODM's srtparser.py)
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from itertools import pairwise
from pathlib import Path
from typing import Final

import numpy as np

from hawk.picture.film.course import Course, FloatArray
from hawk.picture.photographs.tags import looking_down
from hawk.picture.values import PictureError

_NUMBER: Final = r"([+-]?\d+(?:\.\d+)?)"
_SPAN: Final = re.compile(r"(\d+):(\d\d):(\d\d)[,.](\d{1,3})\s*-->\s*(\d+):(\d\d):(\d\d)[,.](\d{1,3})")
_COUNT: Final = re.compile(r"(?:FrameCnt|SrtCnt)\s*:\s*(\d+)")
_MOMENT: Final = re.compile(r"(\d{4})[-.](\d\d)[-.](\d\d) (\d\d):(\d\d):(\d\d)(?:[.,](\d{1,3}))?")
_TUPLE: Final = re.compile(rf"(?:GPS|RTK)\s*\(\s*{_NUMBER}\s*,\s*{_NUMBER}\s*,\s*{_NUMBER}\s*(M?)\s*\)")
_GIMBAL: Final = re.compile(rf"G\.PRY\s*\(\s*{_NUMBER}°?\s*,\s*{_NUMBER}°?\s*,\s*{_NUMBER}°?\s*\)")
_HEIGHT: Final = re.compile(rf"(?:BAROMETER\s*:\s*|\bH\s){_NUMBER}\s*[mM]?")
_FOCAL: Final = re.compile(r"focal_len\s*:\s*(\d+)(\.\d+)?")
_ZOOM: Final = re.compile(r"dzoom_ratio\s*:\s*(\d+)(\.\d+)?")
_MOST_BYTES: Final = 1 << 28
_SAME_COUNT: Final = 0.02
"""Share by which the captions of a film with one a frame may differ in number from its frames."""
_OTHER_S, _OTHER_SHARE = 3.0, 0.05
_STANDS_S: Final = 0.5
"""DJI writes a place several times until the next one comes, within this; longer, the drone stood."""
_ANYWAY_S: Final = 1.0
_COARSE_M: Final = 8.0
"""Standard deviation of a place of four decimals."""
_FINE_M: Final = 2.0
_REMEDY: Final = (
    "switch on the captions (Video Subtitles) in DJI's app before the flight, or name an ArduPilot log by --log"
)


@dataclass(frozen=True, slots=True)
class Caption:
    """One caption: seconds of the film at its begin and end, the number that it gives itself, and what it says.

    ``gimbal``: roll, pitch, yaw, degrees, as DJI has them. ``moment``: Unix seconds by the drone's clock, taken as UTC.
    ``focal_mm``: on 35 mm film. ``zoom``: digital, 1.0 without. None: it does not say.
    """

    begin: float
    end: float
    count: int | None
    latitude: float | None
    longitude: float | None
    altitude: float | None
    height: float | None
    gimbal: tuple[float, float, float] | None
    moment: float | None
    focal_mm: float | None
    zoom: float
    is_coarse: bool


@dataclass(frozen=True, slots=True)
class Captions:
    """A film's path by its captions. ``focal_mm``: on 35 mm film, None where they do not say; ``zoom``: the largest."""

    course: Course
    focal_mm: float | None
    zoom: float


def beside(film: Path, suffix: str) -> Path | None:
    """Return the file with this ending that lies beside a film under its name, None without any."""
    try:
        names = sorted(film.parent.iterdir())
    except OSError:
        return None
    return next((each for each in names if each.suffix.lower() == suffix and each.stem == film.stem), None)


def read_captions(file: Path, frames: int, fps: float) -> Captions:
    """Read the captions of a film of this number of frames.

    Raises PictureError where they are damaged, of another film, or say no place.
    """
    captions = parse_captions(_text(file))
    if not captions:
        raise PictureError(f"{file}: no caption is in it; copy it again from the drone's card")
    has_each = abs(len(captions) - frames) <= max(2, _SAME_COUNT * frames)
    seconds, length = captions[-1].end, frames / fps
    if not has_each and abs(seconds - length) > max(_OTHER_S, _OTHER_SHARE * length):
        raise PictureError(
            f"{file}: its captions last {seconds:.0f} s, the film {length:.0f} s: they are another film's; name the "
            "right file by --log"
        )
    if has_each and all(each.count is not None for each in captions):
        first = captions[0].count or 0
        captions = [replace(each, begin=((each.count or 0) - first) / fps) for each in captions]
    placed = [each for each in captions if each.latitude is not None]
    if len(placed) < 2:
        raise PictureError(f"{file}: its captions say no place: the drone had no GPS fix, or wrote none; {_REMEDY}")
    focal = [each.focal_mm for each in captions if each.focal_mm is not None]
    return Captions(
        _course(_thinned(placed)), float(np.median(focal)) if focal else None, max(each.zoom for each in captions)
    )


def parse_captions(text: str) -> list[Caption]:
    """Return the captions of a file's text in order of time; blocks without a time are passed over."""
    starts = [match.start() for match in _SPAN.finditer(text)]
    blocks = [text[at:end] for at, end in pairwise((*starts, len(text)))]
    found = [_caption(re.sub(r"<[^<>]*>", "", block)) for block in blocks]
    return sorted(found, key=lambda each: each.begin)


def _text(file: Path) -> str:
    try:
        if file.stat().st_size > _MOST_BYTES:
            raise PictureError(f"{file}: larger than captions are; name the film's .SRT by --log")
        return file.read_text(encoding="utf-8-sig", errors="replace")
    except OSError as error:
        raise PictureError(
            f"{file} cannot be read ({error.strerror or error}); copy it from the drone's card"
        ) from None


def _caption(block: str) -> Caption:
    span = _SPAN.search(block)
    times = [int(part) for part in span.groups()] if span else [0] * 8
    count = _COUNT.search(block)
    latitude, longitude, is_coarse = _place(block)
    focal, zoom = _FOCAL.search(block), _ZOOM.search(block)
    height = _HEIGHT.search(block)
    return Caption(
        begin=_seconds(times[:4]),
        end=_seconds(times[4:]),
        count=int(count[1]) if count else None,
        latitude=latitude,
        longitude=longitude,
        altitude=_bracketed(block, "abs_alt", "altitude"),
        height=float(height[1]) if height else _bracketed(block, "rel_alt"),
        gimbal=_gimbal(block),
        moment=_moment(block),
        focal_mm=_decimal(focal, 10.0),  # without a point: tenths
        zoom=_decimal(zoom, 10_000.0) or 1.0,
        is_coarse=is_coarse,
    )


def _seconds(parts: list[int]) -> float:
    hours, minutes, seconds, thousandths = parts
    return 3600.0 * hours + 60.0 * minutes + seconds + thousandths / 1000.0


def _decimal(match: re.Match[str] | None, parts: float) -> float | None:
    if match is None:
        return None
    return float(f"{match[1]}{match[2]}") if match[2] else int(match[1]) / parts


def _bracketed(block: str, *names: str) -> float | None:
    for name in names:
        found = re.search(rf"\b{name}\s*:\s*{_NUMBER}", block)
        if found:
            return float(found[1])
    return None


def _place(block: str) -> tuple[float | None, float | None, bool]:
    """Return latitude and longitude, and whether they have four decimals or fewer."""
    latitude, longitude = _bracketed(block, "latitude"), _bracketed(block, "longt?itude")
    is_coarse = False
    if latitude is None or longitude is None:
        found = _TUPLE.search(block)
        if found is None:
            return None, None, False
        first, second = float(found[1]), float(found[2])
        is_latitude_first = bool(found[4]) and abs(first) <= 90.0
        latitude, longitude = (first, second) if is_latitude_first else (second, first)
        is_coarse = len(found[1].partition(".")[2]) <= 4
    if (latitude, longitude) == (0.0, 0.0) or not (abs(latitude) <= 90.0 and abs(longitude) <= 180.0):
        return None, None, False
    return latitude, longitude, is_coarse


def _gimbal(block: str) -> tuple[float, float, float] | None:
    yaw, pitch, roll = (_bracketed(block, f"gb_{name}") for name in ("yaw", "pitch", "roll"))
    if yaw is not None and pitch is not None:
        return roll or 0.0, pitch, yaw
    found = _GIMBAL.search(block)
    return None if found is None else (float(found[2]), float(found[1]), float(found[3]))


def _moment(block: str) -> float | None:
    found = _MOMENT.search(block)
    if found is None:
        return None
    year, month, day, hour, minute, second = (int(part) for part in found.groups()[:6])
    try:
        moment = datetime(year, month, day, hour, minute, second, tzinfo=UTC)
    except ValueError:
        return None
    return moment.timestamp() + float(f"0.{found[7] or 0}")


def _thinned(captions: list[Caption]) -> list[Caption]:
    """Return the captions at which the place changed, and the last one of a stand: between those the drone moved."""
    kept = [captions[0]]
    for before, each in pairwise(captions):
        if (each.latitude, each.longitude) != (before.latitude, before.longitude):
            if before.begin - kept[-1].begin > _STANDS_S:
                kept.append(before)
            kept.append(each)
        elif each.begin - kept[-1].begin >= _ANYWAY_S:
            kept.append(each)
    if captions[-1].begin > kept[-1].begin:
        kept.append(captions[-1])
    return kept


def _course(captions: list[Caption]) -> Course:
    attitude = np.array([_attitude(each) for each in captions], np.float64)
    moments = [each.moment - each.begin for each in captions if each.moment is not None]
    across = _COARSE_M if captions[0].is_coarse else _FINE_M
    return Course(
        _column([each.begin for each in captions]),
        _column([each.latitude for each in captions]),
        _column([each.longitude for each in captions]),
        _column([each.altitude for each in captions]),
        _column([each.height for each in captions]),
        attitude,
        (across, 3.0),
        float(np.median(moments)) if moments else None,
    )


def _column(values: list[float] | list[float | None]) -> FloatArray:
    return np.array([math.nan if value is None else value for value in values], np.float64)


def _attitude(caption: Caption) -> tuple[float, float, float]:
    if caption.gimbal is None:
        return (math.nan,) * 3
    roll, pitch, yaw = (math.radians(angle) for angle in caption.gimbal)
    return looking_down(roll, pitch, math.remainder(yaw, math.tau))
