"""The place of a photograph stands in EXIF and in XMP; where they differ, neighbours or the clock say which is right.

A lost letter of a hemisphere moves a flight from Canada to Kazakhstan. Longitudes of one flight may cross the 180th
meridian, where they jump by 360 degrees.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final, Literal

import numpy as np
import pymap3d
from numpy.typing import NDArray

from hawk.picture.photographs.photograph import Photograph, Place
from hawk.picture.values import PictureError, list_names

Choice = Literal["exif", "xmp"]
FloatArray = NDArray[np.float64]
NEAR_M: Final = 1000.0
"""A photograph of the same flight lies so near to one whose place is sure."""
_ZONE_H: Final = 3.0
"""Hours by which a country's clock may differ from the sun's."""


def resolve_places(photographs: Sequence[Photograph], choice: Choice | None) -> tuple[list[Photograph], list[str]]:
    """Return the photographs with the place that two witnesses say, and a note where their tags differ.

    ``choice``: which tags a person names. Raises PictureError, which asks for it, where nothing else decides.
    """
    doubted = [each for each in photographs if each.other_place is not None]
    sure = [each.shot.latitude_longitude for each in photographs if each.other_place is None]
    found, unclear, moved = [], list[Photograph](), list[str]()
    for each in photographs:
        takes_xmp = None if each.other_place is None else _takes_xmp(each, each.other_place, sure, choice)
        if each.other_place is not None and takes_xmp is None:
            unclear.append(each)
        elif each.other_place is not None and takes_xmp:
            latitude, longitude = each.other_place
            moved.append(each.shot.name)
            each = replace(each, shot=replace(each.shot, latitude=latitude, longitude=longitude))
        found.append(each)
    if unclear:
        raise PictureError(_question(unclear))
    if not doubted:
        return found, []
    names = [each.shot.name for each in doubted]
    used = (
        "XMP" if len(moved) == len(doubted) else "EXIF" if not moved else f"XMP for {list_names(moved)} and else EXIF"
    )
    return found, [
        f"EXIF and XMP say different places: {list_names(names)}; that of {used} is used, as another tag agrees"
    ]


def _takes_xmp(each: Photograph, other: Place, sure: Sequence[Place], choice: Choice | None) -> bool | None:
    """Return whether the place of XMP is right, False for that of EXIF, None where nothing says it."""
    if choice is not None:
        return choice == "xmp"
    own = each.shot.latitude_longitude
    if not each.has_hemisphere:
        return True
    fits = [any(apart_m(place, one) < NEAR_M for one in sure) for place in (own, other)]
    if fits[0] != fits[1]:
        return fits[1]
    if each.zone_h is not None:
        zone = each.zone_h
        by_clock = [abs(math.remainder(place[1] / 15.0 - zone, 24.0)) <= _ZONE_H for place in (own, other)]
        if by_clock[0] != by_clock[1]:
            return by_clock[1]
    return None


def apart_m(one: Place, other: Place) -> float:
    """Return the distance of two places on the ground, metres; infinite where they are far apart."""
    if abs(one[0] - other[0]) > 1.0 or abs(math.remainder(one[1] - other[1], 360.0)) > 10.0:
        return math.inf
    there = pymap3d.geodetic2enu(*other, 0.0, *one, 0.0)
    return math.hypot(*map(float, there[:2]))


def words(place: Place) -> str:
    """Return a place for a sentence."""
    latitude, longitude = place
    return f"{abs(latitude):.5f} {'SN'[latitude >= 0]} {abs(longitude):.5f} {'WE'[longitude >= 0]}"


def _question(unclear: Sequence[Photograph]) -> str:
    first, rest = unclear[0], len(unclear) - 1
    others = f" (and {rest} more)" if rest else ""
    return (
        f"{first.shot.name}{others}: EXIF says {words(first.shot.latitude_longitude)}, XMP "
        f"{words(first.other_place or (0.0, 0.0))}; say which is right: --place exif or --place xmp"
    )


def unwrap_longitudes(longitudes: FloatArray) -> FloatArray:
    """Return longitudes (N,), degrees, within half a turn of the first one, so that they can be averaged."""
    return np.asarray(longitudes + 360.0 * np.rint((longitudes[0] - longitudes) / 360.0), np.float64)


def wrap_longitudes(longitudes: FloatArray) -> FloatArray:
    """Return longitudes (N,), degrees, from -180 to 180."""
    return np.asarray(longitudes - 360.0 * np.rint(longitudes / 360.0), np.float64)
