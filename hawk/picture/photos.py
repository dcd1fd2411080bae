"""Photographs of one flight mapped as a survey: poses adjusted together, each photograph levelled, all fused."""

from __future__ import annotations

import hashlib
import json
import math
import uuid
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Final

import numpy as np
import pymap3d

from hawk.algo.vision.decode import NetworkFinder
from hawk.algo.vision.named import network_name
from hawk.algo.vision.network import StallNetwork, VisionModelError
from hawk.exports.ground import ground_of
from hawk.exports.records import found_stalls
from hawk.exports.values import ExportRecord
from hawk.lots.registration.frames import Move
from hawk.lots.survey.landing import LandingFacts, finished
from hawk.lots.survey.source import SourceKind
from hawk.lots.values import FinishedSurvey, fitting_name
from hawk.model.lot_map import CELL_M, Cell, OccupancyMap, StallState
from hawk.model.pictures import CameraModel
from hawk.model.poses import GlobalPose
from hawk.picture.adjust.app import Adjusted, Known, adjust
from hawk.picture.adjust.features import Features
from hawk.picture.adjust.posed import Posed
from hawk.picture.cars import with_lone_cars_suggested
from hawk.picture.kept import Work
from hawk.picture.limits import LOT_M, limits_of, source_of, stretch
from hawk.picture.longitudes import unwrapped, wrapped
from hawk.picture.looked import Files, Looked, Pictures
from hawk.picture.oblique import oblique_of
from hawk.picture.photographs.folder import Folder, read_folder
from hawk.picture.photographs.heights import HIGHEST_M, doubt_of, guessed
from hawk.picture.scale import Reading, Said, Scale, by_height, by_places, by_stalls, decided, grown, middle_height
from hawk.picture.values import (
    COARSE_M,
    COARSEST_M,
    NO_STALLS,
    LeftOut,
    Mapped,
    PictureError,
    Progress,
    Shot,
    named,
    of_model,
)
from hawk.results.survey_map import SurveyMap

TILT: Final = math.radians(1.0)
HEADING: Final = math.radians(6.0)
"""Standard deviations of what a gimbal says of roll and pitch, and of the heading."""
ROUGH_TILT: Final = math.radians(5.0)
ROUGH_HEADING: Final = math.radians(15.0)
"""The same of an aircraft without a gimbal, as measured on one flight (docs/results/perception.md)."""
LEAST_HEIGHT_M: Final = 0.5
BAROMETER_SHARE: Final = 0.01
"""Standard deviation of a barometer's height against those of the same flight: the larger of both."""
ROUGH_HEIGHT_M: Final = 3.0
"""The same of an altitude by GNSS."""
_UNKNOWN: Final = math.pi
_UNSEEN_M: Final = 0.3
"""Error of a lot's length by turn and scale that nobody notes."""


@dataclass(frozen=True, slots=True)
class Taken:
    """Source of shots: the ``name`` of their folder or file, and its kind. Not ``time_is_sure`` by a clock that a
    person set and whose zone is not known. ``height_m``: above the ground, that a person gave.
    """

    name: str
    kind: SourceKind
    time_is_sure: bool = False
    height_m: float | None = None

    @property
    def lot(self) -> str:
        """Name of the lot: that of the folder, or of the film without its ending, as far as it can be shown."""
        name = self.name if self.kind is SourceKind.PHOTOGRAPHS else Path(self.name).stem
        return fitting_name(name) or self.kind.value


@dataclass(frozen=True, slots=True)
class PhotoSurvey:
    """A survey by photographs as the store takes it, and as files have it.

    ``adjusted``: poses in the order of ``shots``; ``residual`` in it is in pixels at a quarter of the size.
    """

    mapped: Mapped
    landed: LandingFacts = field(repr=False)
    shots: tuple[Shot, ...] = field(repr=False)
    adjusted: Adjusted = field(repr=False)

    def beside(self, left_out: Sequence[LeftOut], notes: Sequence[str]) -> PhotoSurvey:
        """Return the survey with what the reader of the pictures left out and noted."""
        every = sorted((*left_out, *self.mapped.left_out), key=lambda each: each.name)
        mapped = replace(self.mapped, left_out=tuple(every), notes=(*notes, *self.mapped.notes))
        return replace(self, mapped=mapped)


def map_photos(
    folder: Path,
    *,
    height_m: float | None = None,
    lenses: Path | None = None,
    calibration: CameraModel | None = None,
    group: int | None = None,
    model: Path | None = None,
    work: Path | None = None,
    progress: Progress = lambda *_: None,
) -> Mapped:
    """Find the stalls that photographs of one flight show, free and taken.

    Args:
        folder: It holds the JPEGs of a drone that looked straight down.
        height_m: Height of the middle photograph above the ground, metres, where the files give none.
        lenses: Table of lenses (docs/photographs.md).
        calibration: Lens of all photographs.
        group: Which flight or camera of a mixed folder, from 1.
        model: The network's ONNX file; None: that of the package.
        work: Folder of the results of each step, by which the same call goes on where it was cut off; None keeps none.
        progress: Is called as the work goes on.

    Returns:
        The survey. Photographs that could not be used are named in ``left_out``, the others are mapped.

    Raises:
        PictureError: Nothing can be mapped; the text has the remedy.
    """
    read = read_folder(folder, lenses=lenses, calibration=calibration, height_m=height_m, group=group)
    return survey_folder(read, model=model, work=work, progress=progress).mapped


def survey_folder(
    read: Folder, *, model: Path | None = None, work: Path | None = None, progress: Progress = lambda *_: None
) -> PhotoSurvey:
    """Return the survey of a folder that was read, with the poses, and as the store takes it.

    Arguments and errors are those of `map_photos`.
    """
    taken = Taken(read.name, SourceKind.PHOTOGRAPHS, read.time_is_sure, read.height_m)
    survey = survey_shots(taken, read.shots, Files(), model=model, work=work, progress=progress)
    return survey.beside(read.left_out, read.notes)


def survey_shots(
    taken: Taken,
    shots: Sequence[Shot],
    pictures: Pictures,
    *,
    model: Path | None = None,
    work: Path | None = None,
    progress: Progress = lambda *_: None,
) -> PhotoSurvey:
    """Adjust and map shots of one flight with one camera.

    Raises PictureError, which asks for the height where what says the scale differs, or nothing says a height.

    Args:
        taken: Where the shots are from.
        shots: In the order of time.
        pictures: Gives their pictures.
        model: The network's ONNX file; None: that of the package.
        work: As of `map_photos`.
        progress: Is called as the work goes on.
    """
    network, name = _network(model), taken.lot
    kept, finder = Work(work, f"{network_name(model)} {network.engine}"), NetworkFinder(network)
    looked = Looked(pictures, kept)
    posed = pose_shots(taken, shots, looked, kept, finder, progress)
    shots, adjusted, scale, datum = posed.shots, posed.adjusted, posed.scale, posed.datum
    pixel = _pixel(adjusted)
    _check_pixel(name, pixel)
    current = looked.mapped(name, shots, adjusted, finder, progress)
    current = with_lone_cars_suggested(current)
    landed = _landed(taken, shots, datum, current, network_name(model))
    survey = finished(landed)
    source = source_of(taken.kind, taken.name, limits_of(shots, adjusted, scale, pixel, survey))
    landed, survey = replace(landed, pictures=source), replace(survey, pictures=source)
    notes = (*_notes(shots, adjusted, scale, current), *_pixel_notes(pixel))
    mapped = _survey(name, shots, survey, current, notes, (*posed.left_out, *looked.lost))
    return PhotoSurvey(mapped, landed, shots, adjusted)


@dataclass(frozen=True, slots=True)
class PosedShots:
    """The shots that can be used, about a ``datum``, with their adjusted poses at the scale that is decided."""

    shots: tuple[Shot, ...]
    datum: GlobalPose
    adjusted: Adjusted
    scale: Scale
    left_out: tuple[LeftOut, ...]


def pose_shots(
    taken: Taken, shots: Sequence[Shot], looked: Looked, kept: Work, finder: NetworkFinder, progress: Progress
) -> PosedShots:
    """Adjust the poses of shots and decide the scale. Arguments and errors are those of `survey_shots`."""
    datum = _middle(shots)
    doubt = "" if taken.height_m is not None else doubt_of(shots)
    is_none = any(shot.height is None or shot.height > HIGHEST_M for shot in shots)
    shots = guessed(shots) if is_none else shots
    known = [known_pose(shot, datum) for shot in shots]
    shots, known, left_out = _usable(taken.lot, shots, known, looked, progress)
    adjusted = _adjusted(kept, shots, known, looked.features_of(shots), progress)
    said = Said(taken.height_m, doubt, is_none)
    scale = _scale(taken.lot, shots, known, adjusted, said, partial(looked.widths, shots, finder=finder))
    return PosedShots(tuple(shots), datum, grown(adjusted, scale.factor), scale, tuple(left_out))


def _usable(
    name: str, shots: Sequence[Shot], known: list[Known], looked: Looked, progress: Progress
) -> tuple[list[Shot], list[Known], list[LeftOut]]:
    """Return the shots that can be read and look down, and the others with the reason. Raises PictureError for none."""
    usable, left_out = looked.read(shots, progress)
    shots, known = [shots[k] for k in usable], [known[k] for k in usable]
    if not shots:
        raise PictureError(f"{name}: no photograph can be read: {left_out[0].name}: {left_out[0].reason}")
    oblique = oblique_of(shots, known, looked)
    down = [k for k, shot in enumerate(shots) if shot.name not in oblique]
    if not down:
        first, reason = next(iter(oblique.items()))
        raise PictureError(f"{name}: no photograph looks straight down: {first} {reason}")
    left_out += [LeftOut(shot, reason) for shot, reason in oblique.items()]
    return looked.only(down, shots), [known[k] for k in down], left_out


def _adjusted(
    kept: Work, shots: Sequence[Shot], known: list[Known], found: Callable[[int], Features], progress: Progress
) -> Adjusted:
    """Adjust shots, or return what an earlier run has kept of it."""

    def make() -> Adjusted:
        return adjust(
            known,
            found,
            lens_is_known=all(shot.lens_is_known for shot in shots),
            progress=progress,
            keep=partial(kept.ties, shots),
            keep_middles=partial(kept.middles, shots),
        )

    return kept.adjusted(shots, known, make)


def _middle(shots: Sequence[Shot]) -> GlobalPose:
    latitude = np.mean([shot.latitude for shot in shots])
    longitude = wrapped(unwrapped(np.array([shot.longitude for shot in shots])).mean())
    return GlobalPose(float(latitude), float(longitude), 0.0)


def known_pose(shot: Shot, datum: GlobalPose) -> Known:
    """Return a shot's pose about a datum as its file says, with how far that is believed. Raises PictureError."""
    if shot.height is None:
        raise PictureError(f"{shot.name}: its height above the ground is not known; give it by --height METRES")
    north, east, _ = pymap3d.geodetic2ned(shot.latitude, shot.longitude, 0.0, datum.latitude, datum.longitude, 0.0)
    attitude = shot.attitude or (0.0, 0.0, 0.0)
    posed = Posed(
        shot.camera, float(north), float(east), shot.height, attitude, velocity=shot.velocity, line_s=shot.line_s
    )
    is_level = shot.attitude is not None and shot.has_gimbal
    heading = HEADING if is_level else ROUGH_HEADING
    return Known(
        posed, shot.sigma[0], max(LEAST_HEIGHT_M, BAROMETER_SHARE * shot.height) if is_level else ROUGH_HEIGHT_M,
        TILT if is_level else ROUGH_TILT,
        heading if shot.attitude is not None and shot.yaw_is_sure else _UNKNOWN,
    )  # fmt: skip


def _network(model: Path | None) -> StallNetwork:
    try:
        return StallNetwork.load(model, "auto", 1)
    except VisionModelError as error:
        raise of_model(error) from error


def _scale(
    name: str,
    shots: Sequence[Shot],
    known: Sequence[Known],
    adjusted: Adjusted,
    said: Said,
    widths: Callable[[Adjusted], list[float]],
) -> Scale:
    """Return the scale on which the witnesses agree. Raises PictureError where they do not."""

    def look(factor: float) -> Reading | None:
        seen = by_stalls(widths(grown(adjusted, factor)))
        return None if seen is None else replace(seen, factor=seen.factor * factor)

    height = by_height(known, adjusted, lens_is_known=all(shot.lens_is_known for shot in shots))
    return decided(name, by_places(shots, known, adjusted), height, said, middle_height(adjusted), look)


def _check_pixel(name: str, metres: float) -> None:
    if metres > COARSEST_M:
        raise PictureError(
            f"{name}: a pixel covers {metres * 100:.0f} cm of the ground; stalls are found up to"
            f" {COARSEST_M * 100:.0f} cm: fly lower"
        )


def _pixel(adjusted: Adjusted) -> float:
    """Return the side of a pixel on the ground, the median, metres."""
    return float(np.median([one.height / one.camera.fx for one in adjusted.posed]))


def _pixel_notes(metres: float) -> Iterator[str]:
    if metres > COARSE_M:
        yield f"A pixel covers {metres * 100:.0f} cm of the ground: more stalls are found from lower."


def _landed(
    taken: Taken, shots: Sequence[Shot], datum: GlobalPose, current: OccupancyMap, network: str
) -> LandingFacts:
    times = [shot.time for shot in shots if shot.time is not None] or [shot.path.stat().st_mtime for shot in shots]
    ended = max(times)
    return LandingFacts(
        name=f"{taken.kind.value} {hashlib.sha256(_identity(shots).encode()).hexdigest()[:16]}",
        datum=datum,
        current=current,
        outline=None,
        seconds=0.0,
        utc=ended,
        time_is_sure=taken.time_is_sure,
        program=f"{version('hawk-drone')}, network {network}",
        flown_s=ended - min(times),
        speed=math.inf,  # every look counts as the last photograph's time
        accuracy=_accuracy(shots),
        title=taken.lot,
    )


def _accuracy(shots: Sequence[Shot]) -> float | None:
    """Return the standard deviation of a place on Earth, the median, metres; None where a file does not say it."""
    if not all(shot.sigma_is_said for shot in shots):
        return None
    return float(np.median([shot.sigma[0] for shot in shots]))


def _identity(shots: Sequence[Shot]) -> str:
    """Return what the same pictures have in common, in whatever folder they lie."""
    return json.dumps([[shot.name, shot.latitude, shot.longitude, shot.time] for shot in shots])


def _survey(
    name: str,
    shots: Sequence[Shot],
    kept: FinishedSurvey,
    current: OccupancyMap,
    notes: tuple[str, ...],
    left_out: Sequence[LeftOut],
) -> Mapped:
    origin = kept.datum.latitude, kept.datum.longitude
    stalls = [stall for stall in kept.stalls if not stall.is_extra]
    survey = ExportRecord(
        lot=name,
        lot_id=str(uuid.uuid5(uuid.NAMESPACE_URL, f"photographs {name}")) if stalls else "",
        survey=str(uuid.uuid5(uuid.NAMESPACE_URL, f"{_identity(shots)} {kept.program}")),
        began=kept.began,
        ended=kept.ended,
        time_is_sure=kept.time_is_sure,
        layout=None,
        software=f"hawk-drone {kept.program}",
        is_simulated=False,
        accuracy=kept.accuracy,
        is_pinned=False,
        origin=origin,
        outline=kept.outline,
        stalls=found_stalls(stalls, origin),
        doubt="" if stalls else NO_STALLS,
        pictures=kept.pictures,
    )
    tiles = {key: tile.data for key, tile in current.mosaic.items()}
    has_ground = bool(tiles) or bool(survey.stalls)
    ground = ground_of(survey, tiles, Move()) if has_ground else None
    cells = SurveyMap.of(kept.datum, current).cells().values
    area = float((cells != Cell.UNKNOWN).sum() * CELL_M**2)
    return Mapped(survey, ground, round(area, 1), "", tuple(left_out), notes, tuple(stall.score for stall in stalls))


def _fit_notes(adjusted: Adjusted, scale: Scale) -> Iterator[str]:
    """Say how far the whole map may be turned and scaled, where that moves stalls of a lot against each other."""
    off = f"its scale is off by less than {100 * scale.off:.1f} %, in nine of ten surveys."
    if not scale.is_by_places:
        yield f"The height alone, {scale.height:.0f} m, gives the map its scale: {off}"
    if stretch(adjusted, scale) * LOT_M > _UNSEEN_M:
        turn = f"{math.degrees(scale.turn):.1f} degrees"
        yield f"By the photographs' GPS the whole map is turned by less than {turn}, and {off}"


def _notes(shots: Sequence[Shot], adjusted: Adjusted, scale: Scale, current: OccupancyMap) -> Iterator[str]:
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
            yield f"Mapped by the places that their files say: {named(alone)}."
    yield from _fit_notes(adjusted, scale)
    if adjusted.turned:
        names = [shots[number].name for number in sorted(adjusted.turned)]
        yield f"Their neighbours show another heading than their files: {named(names)}."
    suggested = sum(stall.state is StallState.SUGGESTED for stall in current.stalls.values())
    if suggested:
        yield f"Cars stand where no stall is marked: {suggested} places are not counted."
