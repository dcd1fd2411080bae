"""Heights of a flight's photographs above the ground, by their files or by the person who gives one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from statistics import median
from typing import Final

from hawk.picture.values import LeftOut, PictureError, Shot

HIGHEST_M: Final = 500.0
"""No height above the ground: a pixel of a common drone then covers 12 cm, and aviation laws end at 120 m."""
GUESS_M: Final = 60.0
"""Height at which the look at pictures begins that say none: a usual one."""
_LEAST_M: Final = 3.0
_SAME_M: Final = 0.015
"""Two altitudes that agree to the last digit that drones write are one number."""
_FAR_M: Final = 10.0
"""Altitudes of one flight that are farther from 0 make one of 0 a number that was not known."""
_NEAR_M: Final = 3.0
_OTHER: Final = 2.0
"""Factor by which a height must differ from the files' before it is looked at closer."""
REMEDY: Final = "give the flight's height above the ground by --height METRES"


def assign_heights(shots: list[Shot], height_m: float | None) -> tuple[list[Shot], list[LeftOut]]:
    """Return the shots with a height each, and those left out because they were taken on the ground.

    ``height_m``: height above the ground of the middle photograph, metres; the others keep their difference from it,
    and one that gives neither height nor altitude is left out where others do. Where nothing says a height, or it is an
    altitude above the sea, the shots stay as they are (`doubt_of`): the pictures may say one.
    Raises PictureError for a height that a person gives and that cannot be one.
    """
    shots = _without_zeros(shots)
    if height_m is not None:
        _check_against(shots, height_m)
        shots, left = _moved(shots, height_m)
        return _aloft(shots, left, f"above the ground by --height {height_m:g} and the others")
    shots, left = _filled(shots)
    if doubt_of(shots):
        return shots, left
    return _aloft(shots, left, f"above the take-off place; else {REMEDY}")


def _without_zeros(shots: list[Shot]) -> list[Shot]:
    """Return the shots without heights and altitudes of exactly 0 that the others contradict: no number was known.

    A height of 0 beside an altitude as high as the others' is none, and so is an altitude of 0 beside a height, or
    beside others' altitudes far off it: metres above the sea change little within a flight.
    """
    altitudes = [shot.altitude for shot in shots if shot.altitude]
    aloft = [shot.altitude - shot.height for shot in shots if shot.altitude and shot.height]
    ground = median(aloft) if aloft else None
    found = []
    for shot in shots:
        if shot.altitude == 0.0 and altitudes and abs(median(altitudes)) > _FAR_M:
            shot = replace(shot, altitude=None)
        if (
            shot.height == 0.0
            and shot.altitude is not None
            and ground is not None
            and shot.altitude - ground > _LEAST_M
        ):
            shot = replace(shot, height=None)
        found.append(shot)
    return found


def doubt_of(shots: Sequence[Shot]) -> str:
    """Return why the heights of shots' files say nothing, or nothing alone; "" where they do."""
    if not any(shot.height is not None for shot in shots):
        others = f" and {len(shots) - 1} others give" if len(shots) > 1 else " gives"
        return f"{shots[0].name}{others} no height above the ground"
    highest = max(shots, key=lambda shot: shot.height or 0.0)
    if (highest.height or 0.0) > HIGHEST_M:
        return (
            f"{highest.name} gives {highest.height:.0f} m above the take-off place, more than {HIGHEST_M:.0f}: it is "
            "an altitude above the sea"
        )
    if all(_is_altitude(shot) for shot in shots):
        return f"{highest.name}'s height {highest.height:.2f} m is its altitude above the sea, as in all others"
    return ""


def guess_heights(shots: Sequence[Shot]) -> list[Shot]:
    """Return shots about a common height, `GUESS_M`, by their differences: pictures then say how high they are."""
    levels = [shot.altitude if shot.altitude is not None else shot.height for shot in shots]
    known = [level for level in levels if level is not None]
    middle = median(known) if known else 0.0
    steps = [0.0 if level is None else level - middle for level in levels]
    low = min(steps)
    return [replace(shot, height=max(GUESS_M, _LEAST_M - low) + step) for shot, step in zip(shots, steps, strict=True)]


def _aloft(shots: list[Shot], left: list[LeftOut], words: str) -> tuple[list[Shot], list[LeftOut]]:
    """Return the shots that were not taken on the ground, and those left out. ``words``: above which level."""
    low = [shot for shot in shots if (shot.height or 0.0) < _LEAST_M]
    reasons = [LeftOut(shot.name, f"was taken on the ground: {shot.height:.1f} m {words}") for shot in low]
    return [shot for shot in shots if shot not in low], [*left, *reasons]


def check_given(height_m: float) -> None:
    """Raise PictureError where a height that a person gives, metres, is none above the ground."""
    if not 0.0 < height_m <= HIGHEST_M:
        raise PictureError(
            f"--height {height_m:g}: must be above 0 and at most {HIGHEST_M:.0f} m above the ground, not above the sea"
        )


def _check_against(shots: list[Shot], height_m: float) -> None:
    check_given(height_m)
    heights = [shot.height for shot in shots if shot.height is not None]
    altitudes = [shot.altitude for shot in shots if shot.altitude is not None]
    if not heights or not altitudes:
        return
    own, altitude = median(heights), median(altitudes)
    if abs(height_m - altitude) <= _NEAR_M and height_m > _OTHER * own > 0.0:
        raise PictureError(
            f"--height {height_m:g}: is the altitude above the sea; the files give {own:.0f} m above the take-off "
            "place: leave --height out, or give the height above the ground"
        )


def _moved(shots: list[Shot], height_m: float) -> tuple[list[Shot], list[LeftOut]]:
    """Return the shots about this height by their differences, and those of which nothing says a difference."""
    has_heights = any(shot.height is not None for shot in shots)
    levels = _heights(shots) if has_heights else [shot.altitude for shot in shots]
    known = [level for level in levels if level is not None]
    if not known:
        return [replace(shot, height=height_m) for shot in shots], []
    middle = median(known)
    moved, left = [], []
    for shot, level in zip(shots, levels, strict=True):
        if level is None:
            left.append(LeftOut(shot.name, "gives no height, the others do; use the drone's own file, or take it away"))
        else:
            moved.append(replace(shot, height=height_m + level - middle))
    return moved, left


def _heights(shots: list[Shot]) -> list[float | None]:
    """Return each shot's own height, else by its altitude where others give both."""
    grounds = [s.altitude - s.height for s in shots if s.altitude is not None and s.height is not None]
    ground = median(grounds) if grounds else None
    return [
        shot.height if shot.height is not None or shot.altitude is None or ground is None else shot.altitude - ground
        for shot in shots
    ]


def _filled(shots: list[Shot]) -> tuple[list[Shot], list[LeftOut]]:
    """Return the shots that have a height, or get it from their altitude, and the others."""
    known, left = [], []
    for shot, height in zip(shots, _heights(shots), strict=True):
        if height is None:
            left.append(LeftOut(shot.name, f"gives no height, the others do; {REMEDY}"))
        else:
            known.append(replace(shot, height=height))
    if not known:
        return shots, []
    return known, left


def _is_altitude(shot: Shot) -> bool:
    return shot.altitude is not None and shot.height is not None and abs(shot.altitude - shot.height) < _SAME_M
