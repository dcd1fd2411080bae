"""Coordinates of a named system as longitude and latitude, by PROJ where they are no degrees of WGS-84 yet."""

from __future__ import annotations

from typing import Final

import numpy as np

from hawk.lots.plan_files.geojson import WGS_84
from hawk.lots.plan_files.values import Floats
from hawk.lots.values import LotInputError
from hawk.runtime.late import load

_MISSING: Final = (
    'are of {}, which is read with pyproj. That is not installed here: pip install "hawk-drone[plans]", or save '
    "the plan in WGS 84 (EPSG:4326)"
)
_SAVE: Final = "save the file in WGS 84 (EPSG:4326), or name its system, as EPSG:25832"


def to_wgs_84(places: Floats, crs: str) -> tuple[Floats, float | None]:
    """Return places (N, 2) of x and y as longitude and latitude, and metres by which the conversion may err.

    Raises LotInputError for a system that is not known, and for places that are not on its part of the Earth.
    """
    if crs == WGS_84:
        check_degrees(places)
        return places, 0.0
    try:
        pyproj = load("pyproj", "exceptions")
    except ImportError:
        raise LotInputError("crs", "of the coordinates: they " + _MISSING.format(crs[:80])) from None
    try:
        system = pyproj.CRS.from_user_input(crs)
        if system.is_geocentric or system.is_vertical or len(system.axis_info) < 2:
            raise LotInputError("crs", f"{crs[:80]} has no two coordinates on a map: {_SAVE}")
        transformer = pyproj.Transformer.from_crs(system, WGS_84, always_xy=True)
        longitude, latitude = transformer.transform(places[:, 0], places[:, 1])
    except (pyproj.exceptions.CRSError, pyproj.exceptions.ProjError) as error:
        reason = str(error).splitlines()[0][:120]
        raise LotInputError("crs", f"{crs[:80]} is no system that is known ({reason}): {_SAVE}") from None
    found = np.column_stack([longitude, latitude])
    if not np.isfinite(found).all():
        raise LotInputError("crs", f"{crs[:80]} does not have the coordinates of the file: name another one")
    check_degrees(found)
    return found, None if transformer.accuracy < 0 else float(transformer.accuracy)


def check_degrees(places: Floats) -> None:
    """Refuse places (N, 2) that are no longitude and latitude. Raises LotInputError, which knows exchanged ones."""
    x, y = np.abs(places).T
    bad = (x > 180) | (y > 90)
    if not bad.any():
        return
    first = "({:.6g}, {:.6g})".format(*places[int(np.flatnonzero(bad)[0])].tolist())
    # a drawing in metres begins near 0, so that not all of it lies beyond 90
    if bool(np.all((x <= 90) & (y > 90) & (y <= 180))):
        reason = f"latitude and longitude are exchanged {first}: write longitude first, as GeoJSON has it"
        raise LotInputError("crs", reason)
    raise LotInputError("crs", f"the coordinates are no degrees {first}: {_SAVE}")
