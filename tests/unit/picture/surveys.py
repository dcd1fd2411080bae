"""Surveys by pictures for tests."""

from __future__ import annotations

import numpy as np

from hawk.exports.ground import Ground
from hawk.exports.values import ExportRecord, Observation
from hawk.lots.survey.landing import LandingFacts
from hawk.model.lot_map import OccupancyMap, Stall, StallState
from hawk.model.plans import Outline
from hawk.model.poses import GlobalPose
from hawk.picture.orthophoto.mosaic import tiles_of
from hawk.picture.values import LeftOut, PictureSurvey
from hawk.results.survey_map import to_global

ORIGIN = (52.0, 5.0)


def _earth(north: float, east: float) -> tuple[float, float]:
    latitude, longitude = to_global(GlobalPose(*ORIGIN, 0.0), np.array([(north, east)]))[0].tolist()
    return latitude, longitude


def stall(number: int, state: str, taken: float | None, score: float | None = 0.95) -> Observation:
    """Return a stall of a row to the east, 2.5 m x 5 m, long side to the north."""
    east = 2.5 * number
    corners = tuple(_earth(n, east + e) for n, e in ((2.5, 1.25), (2.5, -1.25), (-2.5, -1.25), (-2.5, 1.25)))
    return Observation(
        str(number), "", "", state, taken, 1e9, 2, _earth(0.0, east), corners, 2.5, 5.0, 0.0, is_confirmed=False,
        score=score,
    )  # fmt: skip


def mapped(*, crs: str = "", left_out: tuple[LeftOut, ...] = (), with_scores: bool = True) -> PictureSurvey:
    """Return a survey of eight stalls: five free, two taken, one unclear; 40 m x 40 m were seen."""
    states = [("free", 0.05)] * 5 + [("taken", 0.97)] * 2 + [("unknown", 0.5)]
    stalls = tuple(stall(k, state, taken, 0.95 if with_scores else None) for k, (state, taken) in enumerate(states))
    ring = tuple(_earth(n, e) for n, e in ((-10, -10), (10, -10), (10, 28), (-10, 28)))
    survey = ExportRecord(
        "yard", "lot-1", "0123456789abcdef", 1e9, 1e9 + 60, False, None, "hawk-drone 1.0, network 12345678", False,
        2.0, False, ORIGIN, Outline((ring,)), stalls,
    )  # fmt: skip
    image = np.full((400, 400, 3), 120, np.uint8)
    ground = Ground(image, np.full((400, 400), 255, np.uint8), 20.0, -12.0, 0.1)
    on_map = {
        k + 1: Stall(k + 1, 0.0, 2.5 * k, 0.0, 2.5, 5.0, taken, StallState(state), 0.95, 2, 0.0, 1)
        for k, (state, taken) in enumerate(states)
    }
    tiles, mosaic = tiles_of(ground, survey.outline, ORIGIN)
    current = OccupancyMap(tiles=tiles, mosaic=mosaic, stalls=on_map, version=1, map_id=survey.survey)
    landed = LandingFacts(
        "orthophoto yard", GlobalPose(*ORIGIN, 0.0), current, survey.outline, 0.0, survey.ended, False,
        "1.0, network 12345678", title="yard",
    )  # fmt: skip
    return PictureSurvey(survey, landed, ground, 1600.0, crs, left_out, ("A note.",))
