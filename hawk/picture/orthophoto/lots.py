"""Surveys of the lots of a picture: each outline has the stalls whose middle it holds, and its own doubts."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray

from hawk.lots.survey.section_counts import AREA_OF_PLACE_M2, interval
from hawk.lots.survey.source import LIMIT_WORDS, Limit
from hawk.model.lot_map import OccupancyMap
from hawk.model.plans import Outline
from hawk.model.vehicles import MapVehicle
from hawk.picture.orthophoto.grid import FloatArray
from hawk.picture.orthophoto.outline import LotOutline
from hawk.picture.orthophoto.survey import Findings, PictureFrame, seen_of, survey_of
from hawk.picture.orthophoto.tile_merger import Stalls
from hawk.picture.orthophoto.windows import AROUND_M, Window
from hawk.picture.values import LotSurvey, PictureSurvey, list_names

UNSEEN_DOUBT: Final = 0.10
"""Share of an outline, or of the `AROUND_M` about it, that was not seen, from which its count is in doubt."""
SHARED_M2: Final = 12.5
"""Ground of a stall: outlines that share less only touch."""
_NEAR_M: Final = 50.0
"""Outlines nearer than this are given to the store: a lot there may be one of them."""


class SurveysByLot:
    """The surveys of several outlines of a picture. They are made one after the other, again each time."""

    def __init__(self, findings: Findings, outline: LotOutline, failed: Sequence[Window] = ()) -> None:
        """Give each stall to its lot.

        Args:
            findings: Those of the picture.
            outline: The lots, each in the picture at least partly.
            failed: Windows without a result.
        """
        self._findings = findings
        self._outline = outline
        self._ground = outline.in_metres(findings.source.grid)
        self._tree = shapely.STRtree(self._ground)
        self._stalls = self._owners(findings.stalls.corners)
        self._suggested = self._owners(findings.stalls.suggested)
        self._vehicles = self._owners(findings.stalls.vehicle_corners)
        self._cores = shapely.STRtree(self._boxes([part.window for part in findings.results]))
        self._failed = shapely.STRtree(self._boxes(failed))

    def __len__(self) -> int:
        """Return the number of lots."""
        return len(self._outline.lots)

    def __iter__(self) -> Iterator[LotSurvey]:
        """Make the surveys, in the order of the outlines."""
        return map(self._survey, range(len(self)))

    def _boxes(self, windows: Sequence[Window]) -> NDArray[np.object_]:
        metres = np.tile(self._findings.source.grid.metres, 2)
        cores = np.array([window.core for window in windows], np.float64).reshape(-1, 4) * metres
        return np.asarray(shapely.box(*cores.T), object)

    def _owners(self, corners: FloatArray) -> NDArray[np.intp]:
        """Return the number of the lot of each quad (N, 4, 2) of (column, row), -1 beside all.

        It is the lot that holds its middle; of several the smallest, and of those that only touch there, the one that
        has most of the quad.
        """
        places = corners * np.array(self._findings.source.grid.metres)
        middles = shapely.points(places.mean(axis=1))
        quads, lots = self._tree.query(middles, predicate="intersects")
        by_quad: dict[int, list[int]] = defaultdict(list)
        for quad, lot in zip(quads.tolist(), lots.tolist(), strict=True):
            by_quad[quad].append(lot)
        owners = np.full(len(corners), -1, np.intp)
        for quad, several in by_quad.items():
            ground = self._ground[several]
            inside = shapely.contains_properly(ground, middles[quad])
            if len(several) == 1:
                best = 0
            elif inside.any():
                best = int(np.where(inside, shapely.area(ground), np.inf).argmin())
            else:
                best = int(shapely.area(shapely.intersection(ground, shapely.polygons(places[quad]))).argmax())
            owners[quad] = several[best]
        return owners

    def _survey(self, number: int) -> LotSurvey:
        lot, ground = self._outline.lots[number], self._ground[number]
        outline = LotOutline((lot,))
        about = ground.buffer(AROUND_M)
        near = np.sort(self._cores.query(about, predicate="intersects")).tolist()
        is_left_out = bool(len(self._failed.query(about, predicate="intersects")))
        findings = replace(
            self._findings,
            results=[self._findings.results[k] for k in near],
            provenance=replace(self._findings.provenance, title=lot.facts.name),
            left_out=(),
        )
        grid = findings.source.grid
        plane = PictureFrame(grid, np.array([ground], object))
        stalls = findings.chosen(self._stalls == number, self._suggested == number, self._vehicles == number)
        mapped = survey_of(findings, plane, stalls, outline)
        around = about.difference(ground)
        ring = PictureFrame(grid, np.array([around], object))
        beside = sum(seen_of(part, ring) for part in findings.results) / max(around.area, 1.0)
        unseen = min(max(1 - mapped.area_m2 / max(ground.area, 1.0), 0.0), 1.0)
        doubts = tuple(self._doubts(number, mapped, stalls, unseen, beside, is_left_out=is_left_out))
        record = replace(
            mapped.survey,
            lot_id=lot.facts.id,
            stalls=tuple(replace(stall, id=f"{lot.facts.id}/{stall.id}") for stall in mapped.survey.stalls),
        )
        landed = replace(mapped.landed, beside=self._beside(number))
        places = lot.facts.capacity or ground.area / AREA_OF_PLACE_M2
        vehicles = _counted(landed.current.vehicles, unseen * places)
        mapped = replace(mapped, survey=record, landed=landed)
        return LotSurvey(lot.facts, mapped, unseen, unsure_of(stalls.score, stalls.taken), doubts, vehicles)

    def _doubts(
        self, number: int, mapped: PictureSurvey, stalls: Stalls, unseen: float, beside: float, *, is_left_out: bool
    ) -> Iterator[str]:
        """Yield why a lot's count may be wrong. ``beside``: share of the ground about it that was seen."""
        limits = () if mapped.survey.pictures is None else mapped.survey.pictures.limits
        if Limit.COARSE in limits:
            yield LIMIT_WORDS[Limit.COARSE]
        if unseen > UNSEEN_DOUBT:
            yield f"{unseen:.0%} of its outline was not seen."
        elif beside < 1 - UNSEEN_DOUBT:
            yield f"The picture ends within {AROUND_M:.0f} m of it: stalls at its edge may be missed."
        if is_left_out:
            yield "A window at it could not be looked at."
        if others := self._overlapping(number):
            yield f"It overlaps {list_names(others)}: the smaller outline has the stalls of both."
        if len(stalls.suggested):
            yield f"Cars stand where no stall is marked: {len(stalls.suggested)} places are not counted."

    def _overlapping(self, number: int) -> list[str]:
        ground = self._ground[number]
        near = np.sort(self._tree.query(ground, predicate="intersects")).tolist()
        return [
            self._outline.lots[k].facts.name
            for k in near
            if k != number and shapely.area(shapely.intersection(ground, self._ground[k])) > SHARED_M2
        ]

    def _beside(self, number: int) -> tuple[Outline, ...]:
        """Return the outlines of the other lots near by."""
        near = np.sort(self._tree.query(self._ground[number], predicate="dwithin", distance=_NEAR_M)).tolist()
        return tuple(LotOutline((self._outline.lots[k],)).outline() for k in near if k != number)


def _counted(vehicles: Mapping[int, MapVehicle] | None, unseen: float) -> tuple[int, int, int] | None:
    """Return the number of vehicles of a lot, with its interval as of sections; ``unseen``: places not seen."""
    if vehicles is None:
        return None
    least, most = interval(np.array([each.probability for each in vehicles.values()], np.float64), unseen)
    return len(vehicles), min(least, len(vehicles)), max(most, len(vehicles))


def unsure_of(score: FloatArray, taken: FloatArray) -> float | None:
    """Return the mean chance, by the network's own probabilities, that a stall is none or has another state.

    ``score`` and ``taken`` (N,) as of `TileDetections`. Ground unlike all that training saw may be judged wrong and
    surely: a small figure is no proof. None without stalls.
    """
    if not len(score):
        return None
    right = score * np.maximum(taken, 1 - taken)
    return float(1 - right.mean())


def without_pictures(survey: LotSurvey) -> LotSurvey:
    """Return a survey of a lot without what is large: its ground, and what the store takes."""
    landed = replace(survey.mapped.landed, current=OccupancyMap(), beside=())
    return replace(survey, mapped=replace(survey.mapped, ground=None, landed=landed))
