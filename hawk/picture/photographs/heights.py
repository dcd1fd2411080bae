"""Heights of a flight's photographs above the ground, by their files or by the person who gives one."""

from __future__ import annotations

from dataclasses import replace
from statistics import median
from typing import Final

from hawk.picture.values import LeftOut, PictureError, Shot

HIGHEST_M: Final = 500.0
"""No height above the ground: a pixel of a common drone then covers 12 cm, and aviation laws end at 120 m."""
_LEAST_M: Final = 3.0
_SAME_M: Final = 0.015
"""Two altitudes that agree to the last digit that drones write are one number."""
_NEAR_M: Final = 3.0
_OTHER: Final = 2.0
"""Factor by which a height must differ from the files' before it is looked at closer."""
REMEDY: Final = "give the flight's height above the ground by --height METRES"


def with_heights(shots: list[Shot], height_m: float | None) -> tuple[list[Shot], list[LeftOut]]:
    """Return the shots with a height each, and those left out because they were taken on the ground.

    ``height_m``: height above the ground of the middle photograph, metres; the others keep their difference from it.
    Raises PictureError where nothing says a height, or where it is an altitude above the sea.
    """
    if height_m is not None:
        _check_against(shots, height_m)
        return _moved(shots, height_m), []
    shots, left = _filled(shots)
    highest = max(shots, key=lambda shot: shot.height or 0.0)
    if (highest.height or 0.0) > HIGHEST_M:
        raise PictureError(
            f"{highest.name}: its height above the take-off place is {highest.height:.0f} m, more than "
            f"{HIGHEST_M:.0f}: it is an altitude above the sea; {REMEDY}"
        )
    if all(_is_altitude(shot) for shot in shots):
        raise PictureError(
            f"{highest.name}: its height {highest.height:.2f} m is its altitude above the sea, as in all others; "
            f"{REMEDY}"
        )
    low = [shot for shot in shots if (shot.height or 0.0) < _LEAST_M]
    left += [
        LeftOut(shot.name, f"was taken {shot.height:.1f} m above the take-off place: on the ground; else {REMEDY}")
        for shot in low
    ]
    return [shot for shot in shots if shot not in low], left


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


def _moved(shots: list[Shot], height_m: float) -> list[Shot]:
    """Return the shots about this height: their differences are those of their heights, else of their altitudes."""
    for levels in ([shot.height for shot in shots], [shot.altitude for shot in shots]):
        known = [level for level in levels if level is not None]
        if len(known) == len(shots):
            middle = median(known)
            return [replace(shot, height=height_m + level - middle) for shot, level in zip(shots, known, strict=True)]
    return [replace(shot, height=height_m) for shot in shots]


def _filled(shots: list[Shot]) -> tuple[list[Shot], list[LeftOut]]:
    """Return the shots that have a height, or get it from their altitude, and the others."""
    grounds = [s.altitude - s.height for s in shots if s.altitude is not None and s.height is not None]
    known, left = [], []
    for shot in shots:
        if shot.height is not None:
            known.append(shot)
        elif shot.altitude is not None and grounds:
            known.append(replace(shot, height=shot.altitude - median(grounds)))
        else:
            left.append(LeftOut(shot.name, f"gives no height, the others do; {REMEDY}"))
    if not known:
        words = f"{shots[0].name} and {len(shots) - 1} others give" if len(shots) > 1 else f"{shots[0].name} gives"
        raise PictureError(f"{words} no height above the ground; {REMEDY}")
    return known, left


def _is_altitude(shot: Shot) -> bool:
    return shot.altitude is not None and shot.height is not None and abs(shot.altitude - shot.height) < _SAME_M
