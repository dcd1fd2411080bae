"""A survey that has ended, made of the map: its stalls with the time of their last look, and the ground of its lot."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from datetime import datetime
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.lots.registration.georeference import LEAST_PIECE_M2
from hawk.lots.survey.moments import CaptureTime, MomentSource
from hawk.lots.survey.source import PictureSource
from hawk.lots.values import Detection, FinishedSurvey, VehicleDetection
from hawk.model.lot_map import Cell, OccupancyMap, StallState
from hawk.model.plans import Outline
from hawk.model.poses import GlobalPose, Ring
from hawk.results.survey_map import SurveyMap, to_global

_STEP: Final = 4
"""Cells of the map on a side of a cell here: 0.4 m."""
JOIN_M: Final = 6.0
"""Islands and drives narrower than this belong to the lot."""
OFF_M: Final = 0.6
"""Distance by which a simplified outline may leave the cells."""
_SEEN_OFF_M: Final = 0.5
"""The same for the ground that was seen."""
_APART_S: Final = 86_400.0
"""Seconds between GNSS's time and a clock that a time server keeps, from which neither is believed."""
_LEAST_HOLE_M2: Final = 4.0
"""A smaller hole in the ground that was seen hides no stall."""


@dataclass(frozen=True, slots=True)
class LandingFacts:
    """The facts at a landing, as the loop knows them.

    ``seconds``: of the daemon's clock now, by which stalls were last seen, at ``speed`` seconds a real second.
    ``utc``: Unix seconds now. ``flown_s``: real seconds since the last take-off. ``outline``: the area that an
    operator asked for; None without one. ``accuracy``: metres, the receiver's own estimate; None where it gives none.
    ``pictures``: the source of a survey that nobody flew. ``title``: name for a new lot; "": by its number.
    ``beside``, ``capacity``: as of `FinishedSurvey`.
    """

    name: str
    datum: GlobalPose
    current: OccupancyMap = field(repr=False)
    outline: Outline | None
    seconds: float
    utc: float
    time_is_sure: bool
    program: str
    flown_s: float = 0.0
    simulated: bool = False
    speed: float = 1.0
    accuracy: float | None = None
    pictures: PictureSource | None = None
    title: str = ""
    beside: tuple[Outline, ...] | None = field(default=None, repr=False)
    capacity: int | None = None

    def at(self, seconds: float) -> float:
        """Return a moment of the daemon's clock as UTC, Unix seconds."""
        return self.utc - (self.seconds - seconds) / self.speed


def at_landing(heard: datetime | None, clock: float, *, is_kept: bool, is_simulated: bool = False) -> CaptureTime:
    """Return the moment of a landing.

    Args:
        heard: Moment by the autopilot's GNSS; None where it has no time.
        clock: Unix seconds by this computer.
        is_kept: A time server or a GNSS receiver keeps this computer's clock: each is the other's witness then.
        is_simulated: The autopilot's day is a drawn one, which no clock here knows.
    """
    if heard is None:
        return CaptureTime(clock, MomentSource.COMPUTER, is_kept)
    is_alone = is_simulated or not is_kept
    moment = heard.timestamp()
    return CaptureTime(moment, MomentSource.AUTOPILOT, is_alone or abs(moment - clock) <= _APART_S)


def finished(landed: LandingFacts) -> FinishedSurvey:
    """Return the survey with its stalls and outline. Takes tens of milliseconds. Raises LotInputError."""
    survey = SurveyMap.of(landed.datum, landed.current)
    return FinishedSurvey(
        name=landed.name,
        datum=landed.datum,
        began=landed.utc - landed.flown_s,
        ended=landed.utc,
        time_is_sure=landed.time_is_sure,
        outline=landed.outline or seen_lot(survey),
        stalls=tuple(
            Detection.of(stall, landed.at(stall.last_seen))
            for _, stall in sorted(landed.current.stalls.items())
            if stall.seen  # others are known, and were not looked at
            and (stall.extra is not None or stall.state is not StallState.SUGGESTED)
        ),
        program=landed.program,
        simulated=landed.simulated,
        seen_ground=seen_ground(survey),
        accuracy=landed.accuracy,
        pictures=landed.pictures,
        title=landed.title,
        beside=landed.beside,
        vehicles=_vehicles(landed),
        capacity=landed.capacity,
    )


def _vehicles(landed: LandingFacts) -> tuple[VehicleDetection, ...] | None:
    known = landed.current.vehicles
    if known is None:
        return None
    return tuple(VehicleDetection.of(one, landed.at(one.last_seen)) for _, one in sorted(known.items()))


def seen_lot(survey: SurveyMap) -> Outline:
    """Return the ground of the lot that was seen, WGS-84: its outer rings, islands and drives closed.

    An outline without polygons when there is none.
    """
    cells = survey.cells()
    mask = np.isin(cells.values, (Cell.LOT, Cell.FREE, Cell.TAKEN)).astype(np.uint8)
    corners = np.array([stall.corners() for stall in survey.marked if _is_finite(stall.corners())])
    if not survey.tiles:
        return _hull_of(survey.datum, corners)
    cv2.fillPoly(mask, [cells.to_pixels(each).astype(np.int32) for each in corners], 1)
    side = cells.cell_m * _STEP
    margin = math.ceil(JOIN_M / side)
    coarse = np.pad(mask[::_STEP, ::_STEP], margin)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (margin | 1, margin | 1))
    closed = cv2.morphologyEx(coarse, cv2.MORPH_CLOSE, disc)
    rings, _ = cv2.findContours(closed, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    polygons = []
    for ring in rings:
        if cv2.contourArea(ring) * side**2 < LEAST_PIECE_M2:
            continue
        kept = cv2.approxPolyDP(ring, OFF_M / side, closed=True).reshape(-1, 2) - margin + 0.5
        if len(kept) >= 3:
            polygons.append(np.column_stack((cells.north - kept[:, 1] * side, cells.east + kept[:, 0] * side)))
    return Outline(tuple(_ring(survey.datum, polygon) for polygon in polygons))


def seen_ground(survey: SurveyMap) -> Outline:
    """Return all ground that was seen, WGS-84, with the holes in it; simplified by less than `OFF_M`.

    An outline without polygons when nothing was seen.
    """
    cells = survey.cells()
    side = cells.cell_m * _STEP
    seen = np.pad((cells.values[::_STEP, ::_STEP] != Cell.UNKNOWN).astype(np.uint8), 1)
    rings, tree = cv2.findContours(seen, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)
    polygons: list[Ring] = []
    holes: list[Ring] = []
    for ring, (*_, parent) in zip(rings, () if tree is None else tree[0].tolist(), strict=True):
        if cv2.contourArea(ring) * side**2 < (LEAST_PIECE_M2 if parent < 0 else _LEAST_HOLE_M2):
            continue
        kept = cv2.approxPolyDP(ring, _SEEN_OFF_M / side, closed=True).reshape(-1, 2) - 0.5
        if len(kept) >= 3:
            places = np.column_stack((cells.north - kept[:, 1] * side, cells.east + kept[:, 0] * side))
            (polygons if parent < 0 else holes).append(_ring(survey.datum, places))
    return Outline(tuple(polygons), tuple(holes))


def _hull_of(datum: GlobalPose, corners: NDArray[np.float64]) -> Outline:
    if not len(corners):
        return Outline()
    hull = cv2.convexHull(corners.reshape(-1, 2).astype(np.float32)).reshape(-1, 2)
    return Outline((_ring(datum, hull.astype(np.float64)),))


def _ring(datum: GlobalPose, points: NDArray[np.float64]) -> tuple[tuple[float, float], ...]:
    return tuple((float(latitude), float(longitude)) for latitude, longitude in to_global(datum, points))


def _is_finite(values: NDArray[np.float64]) -> bool:
    return bool(np.isfinite(values).all())
