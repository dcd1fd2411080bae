"""Photographs of one flight mapped as a survey: poses adjusted together, each photograph levelled, all fused."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from importlib.metadata import version
from pathlib import Path
from typing import Final

import numpy as np
from shapely import Polygon, box
from shapely.geometry.base import BaseGeometry

from hawk.algo.vision.detector import StallDetector
from hawk.algo.vision.network import StallNetwork
from hawk.algo.vision.network_file import VisionModelError, network_name
from hawk.exports.ground import ground_of
from hawk.exports.records import found_stalls
from hawk.lots.registration.frames import Move
from hawk.lots.registration.georeference import ground_about
from hawk.lots.survey.landing import LandingFacts, finished
from hawk.lots.survey.private_ground import ERROR_M
from hawk.lots.survey.source import SourceKind
from hawk.lots.values import FinishedSurvey
from hawk.model.lot_map import CELL_M, Cell, OccupancyMap, StallState
from hawk.model.pictures import CameraModel
from hawk.model.plans import Outline
from hawk.model.poses import GlobalPose
from hawk.picture.cars import suggest_lone_cars
from hawk.picture.checkpoints import Checkpoints
from hawk.picture.limits import LOT_M, limits_of, stretch
from hawk.picture.orthophoto.outline import read_private
from hawk.picture.photographs.folder import read_folder
from hawk.picture.photographs.scale import (
    Scale,
)
from hawk.picture.photographs.shot_detections import Files, Pictures, ShotReader
from hawk.picture.photographs.shot_poses import pose_shots
from hawk.picture.private_ground import parts_near
from hawk.picture.reconstruction.alignment import Reconstruction
from hawk.picture.values import (
    COARSE_M,
    COARSEST_M,
    LeftOut,
    PictureError,
    PictureSurvey,
    Progress,
    Provenance,
    Shot,
    ShotSet,
    export_survey,
    id_of,
    list_names,
    of_model,
)
from hawk.results.survey_map import SurveyMap

_NEAR_DEG: Final = 0.1
"""Private ground farther off is in no photograph of a flight."""
_UNSEEN_M: Final = 0.3
"""Error of a lot's length by turn and scale that nobody notes."""


@dataclass(frozen=True, slots=True)
class PhotoSurvey:
    """A survey by photographs. ``adjusted``: poses in the order of ``shots``; ``residual`` in it is in pixels at a
    quarter of the size.
    """

    mapped: PictureSurvey
    shots: tuple[Shot, ...] = field(repr=False)
    adjusted: Reconstruction = field(repr=False)


def map_photos(
    folder: Path,
    *,
    height_m: float | None = None,
    lenses: Path | None = None,
    calibration: CameraModel | None = None,
    group: int | None = None,
    private: Path | None = None,
    model: Path | None = None,
    work: Path | None = None,
    progress: Progress = lambda *_: None,
) -> PictureSurvey:
    """Find the stalls that photographs of one flight show, free and taken.

    Args:
        folder: It holds the JPEGs of a drone that looked straight down.
        height_m: Height of the middle photograph above the ground, metres, where the files give none.
        lenses: Table of lenses (docs/photographs.md).
        calibration: Lens of all photographs.
        group: Which flight or camera of a mixed folder, from 1.
        private: File with areas that nobody may look at.
        model: The network's ONNX file; None: that of the package.
        work: Folder of the results of each step, by which the same call goes on where it was cut off; None keeps none.
        progress: Is called as the work goes on.

    Returns:
        The survey. Photographs that could not be used are named in ``left_out``, the others are mapped.

    Raises:
        PictureError: Nothing can be mapped; the text has the remedy.
    """
    read = read_folder(folder, lenses=lenses, calibration=calibration, height_m=height_m, group=group)
    provenance = Provenance(folder.resolve().name, SourceKind.PHOTOGRAPHS, read.time_is_sure, height_m)
    hidden = () if private is None else read_private(private)
    return survey_shots(provenance, read, Files(), private=hidden, model=model, work=work, progress=progress).mapped


def survey_shots(
    provenance: Provenance,
    read: ShotSet,
    pictures: Pictures,
    *,
    private: Sequence[Polygon] = (),
    model: Path | None = None,
    work: Path | None = None,
    progress: Progress = lambda *_: None,
) -> PhotoSurvey:
    """Adjust and map shots of one flight with one camera.

    Raises PictureError, which asks for the height where what says the scale differs, or nothing says a height.

    Args:
        provenance: Where the shots are from.
        read: The shots.
        pictures: Gives their pictures.
        private: Ground that nobody may look at, (longitude, latitude); it is taken as `ERROR_M` wider.
        model: The network's ONNX file; None: that of the package.
        work: As of `map_photos`.
        progress: Is called as the work goes on.
    """
    network, name = _network(model), provenance.lot
    checkpoints, finder = Checkpoints(work, f"{network_name(model)} {network.engine}"), StallDetector(network)
    reader = ShotReader(pictures, checkpoints, has_private=bool(private))
    posed = pose_shots(provenance, read.shots, reader, checkpoints, finder, progress)
    shots, adjusted, scale = posed.shots, posed.adjusted, posed.scale
    pixel = _pixel(adjusted)
    _check_pixel(name, pixel)
    hidden = private_ground(private, posed.datum)
    current = suggest_lone_cars(reader.mapped(name, shots, adjusted, finder, progress, hidden))
    landed = _landed(provenance, shots, posed.datum, current, network_name(model))
    survey = finished(landed)
    source = provenance.source(limits_of(shots, adjusted, scale, pixel, survey))
    landed, survey = replace(landed, pictures=source), replace(survey, pictures=source)
    left_out = sorted((*read.left_out, *posed.left_out, *reader.lost), key=lambda each: each.name)
    notes = (*read.notes, *_notes(shots, adjusted, scale, current), *_pixel_notes(pixel))
    return PhotoSurvey(_mapped(provenance, shots, landed, survey, tuple(left_out), notes), shots, adjusted)


def private_ground(areas: Sequence[Polygon], datum: GlobalPose) -> BaseGeometry:
    """Return private ground on the map, (north, east) metres: wider, as receivers alone say where the pictures are."""
    x, y = datum.longitude, datum.latitude
    near = box(x - _NEAR_DEG, y - _NEAR_DEG, x + _NEAR_DEG, y + _NEAR_DEG)
    parts = (part for area in areas for part in parts_near(area, near))
    rings = tuple(tuple((y, x) for x, y in part.exterior.coords[:-1]) for part in parts)
    return ground_about((datum.latitude, datum.longitude), Outline(rings)).buffer(ERROR_M, join_style="mitre")


def _network(model: Path | None) -> StallNetwork:
    try:
        return StallNetwork.load(model, "auto", 1)
    except VisionModelError as error:
        raise of_model(error) from error


def _check_pixel(name: str, metres: float) -> None:
    if metres > COARSEST_M:
        raise PictureError(
            f"{name}: a pixel covers {metres * 100:.0f} cm of the ground; stalls are found up to"
            f" {COARSEST_M * 100:.0f} cm: fly lower"
        )


def _pixel(adjusted: Reconstruction) -> float:
    """Return the side of a pixel on the ground, the median, metres."""
    return float(np.median([one.height / one.camera.fx for one in adjusted.posed]))


def _pixel_notes(metres: float) -> Iterator[str]:
    if metres > COARSE_M:
        yield f"A pixel covers {metres * 100:.0f} cm of the ground: more stalls are found from lower."


def _landed(
    provenance: Provenance, shots: Sequence[Shot], datum: GlobalPose, current: OccupancyMap, network: str
) -> LandingFacts:
    times = [shot.time for shot in shots if shot.time is not None] or [shot.path.stat().st_mtime for shot in shots]
    ended, is_sure = provenance.moment(max(times))
    flight = provenance.flight
    own = hashlib.sha256(_identity(shots).encode()).hexdigest()[:16] if flight is None else flight.id
    return LandingFacts(
        name=f"{provenance.kind.value} {own}",
        datum=datum,
        current=current,
        outline=None,
        seconds=0.0,
        utc=ended,
        time_is_sure=is_sure,
        program=f"{version('hawk-drone')}, network {network}",
        flown_s=max(times) - min(times),
        speed=math.inf,  # every look counts as the last photograph's time
        accuracy=_accuracy(shots),
        title=provenance.lot,
    )


def _accuracy(shots: Sequence[Shot]) -> float | None:
    """Return the standard deviation of a place on Earth, the median, metres; None where a file does not say it."""
    if not all(shot.sigma_is_said for shot in shots):
        return None
    return float(np.median([shot.sigma[0] for shot in shots]))


def _identity(shots: Sequence[Shot]) -> str:
    """Return what the same pictures have in common, in whatever folder they lie."""
    return json.dumps([[shot.name, shot.latitude, shot.longitude, shot.time] for shot in shots])


def _mapped(
    provenance: Provenance,
    shots: Sequence[Shot],
    landed: LandingFacts,
    finished_survey: FinishedSurvey,
    left_out: tuple[LeftOut, ...],
    notes: tuple[str, ...],
) -> PictureSurvey:
    """Return a survey, ``landed`` and as `finished`, with what its files have."""
    stalls = [stall for stall in finished_survey.stalls if not stall.is_extra]
    ids = id_of(f"photographs {provenance.own_name}"), id_of(f"{_identity(shots)} {landed.program}")
    origin = landed.datum.latitude, landed.datum.longitude
    survey = export_survey(landed, ids, finished_survey.outline, found_stalls(stalls, origin))
    tiles = {key: tile.data for key, tile in landed.current.mosaic.items()}
    has_ground = bool(tiles) or bool(survey.stalls)
    ground = ground_of(survey, tiles, Move()) if has_ground else None
    cells = SurveyMap.of(landed.datum, landed.current).cells().values
    area = float((cells != Cell.UNKNOWN).sum() * CELL_M**2)
    return PictureSurvey(survey, landed, ground, round(area, 1), "", left_out, notes)


def _fit_notes(adjusted: Reconstruction, scale: Scale) -> Iterator[str]:
    """Say how far the whole map may be turned and scaled, where that moves stalls of a lot against each other."""
    off = f"its scale is off by less than {100 * scale.off:.1f} %, in nine of ten surveys."
    if not scale.is_by_places:
        yield f"The height alone, {scale.height:.0f} m, gives the map its scale: {off}"
    if stretch(adjusted, scale) * LOT_M > _UNSEEN_M:
        turn = f"{math.degrees(scale.turn):.1f} degrees"
        yield f"By the photographs' GPS the whole map is turned by less than {turn}, and {off}"


def _notes(shots: Sequence[Shot], adjusted: Reconstruction, scale: Scale, current: OccupancyMap) -> Iterator[str]:
    count = int(adjusted.is_adjusted.sum())
    if adjusted.residual is None:
        yield "The photographs share too few features: they are mapped by the places that their files say."
    else:
        yield (
            f"{count} of {len(shots)} photographs were adjusted together by {adjusted.ties} ties, which they leave by"
            f" {adjusted.residual:.2f} pixels at a quarter of their size (median)."
        )
        alone = [shot.name for shot, good in zip(shots, adjusted.is_adjusted, strict=True) if not good]
        if alone:
            yield f"Mapped by the places that their files say: {list_names(alone)}."
    yield from _fit_notes(adjusted, scale)
    if adjusted.turned:
        names = [shots[number].name for number in sorted(adjusted.turned)]
        yield f"Their neighbours show another heading than their files: {list_names(names)}."
    suggested = sum(stall.state is StallState.SUGGESTED for stall in current.stalls.values())
    if suggested:
        yield f"Cars stand where no stall is marked: {suggested} places are not counted."
