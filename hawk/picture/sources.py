"""Sources of a survey by pictures: what is given is recognised, and mapped."""

from __future__ import annotations

import contextlib
import re
import time
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

from hawk.comm.cameras.calibration import load_calibration
from hawk.config.sections import CameraSettings, ConfigError
from hawk.formats import gdal
from hawk.formats.kind import UNKNOWN, Kind, kind_of_file
from hawk.lots.survey.landing import LandingFacts
from hawk.lots.survey.moments import CaptureTime, MomentSource, has_been
from hawk.lots.survey.source import SourceKind
from hawk.lots.values import LotInputError, checked_name, fitting_name, utc
from hawk.model.pictures import CameraModel
from hawk.picture import webodm
from hawk.picture.city.scheduler import Scheduler
from hawk.picture.film.app import FILMS, read_film
from hawk.picture.film.lens import LensChoice
from hawk.picture.limits import source_of
from hawk.picture.looked import Files
from hawk.picture.photographs.folder import read_folder
from hawk.picture.photographs.places import Choice
from hawk.picture.photos import PhotoSurvey, Taken, survey_folder, survey_shots
from hawk.picture.stored import landed_of
from hawk.picture.values import Mapped, PictureError, Progress, Shot
from hawk.picture.work_folder import ORTHOPHOTOS, WORK

_UNIT: Final = re.compile("_(mm|m|deg|s)$")
_OF_FILMS: Final = ("log", "log_offset_s", "hfov_deg", "focal35_mm")


@dataclass(frozen=True, slots=True)
class Asked:
    """A source with the options of the command line."""

    source: Path
    out: Path
    model: Path | None = None
    outline: Path | None = None
    crs: str | None = None
    workers: int | None = None
    scheduler: Scheduler | None = None
    height_m: float | None = None
    lenses: Path | None = None
    calibration: Path | None = None
    group: int | None = None
    place: Choice | None = None
    log: Path | None = None
    log_offset_s: float | None = None
    hfov_deg: float | None = None
    focal35_mm: float | None = None
    name: str | None = None
    taken: float | None = None
    now: float = field(default_factory=time.time)


@dataclass(frozen=True, slots=True)
class Surveyed:
    """A survey, and what the store takes of it."""

    mapped: Mapped
    landed: Callable[[], LandingFacts] = field(repr=False)


def survey_of_source(asked: Asked, progress: Progress) -> Surveyed:
    """Map a source. Raises PictureError: it cannot be mapped, or an option does not fit it."""
    name = None if asked.name is None else _lot_name(asked.name)
    surveyed = _survey(asked, progress)
    if name is not None:
        surveyed = _named(surveyed, name)
    if asked.taken is None:
        return surveyed
    survey = surveyed.mapped.survey
    if survey.time_is_sure and has_been(survey.ended, asked.now):
        said = utc(survey.ended)
        raise PictureError(f"--taken: the files say themselves that the last picture is of {said}; leave it out")
    return _at(surveyed, asked.taken)


def _lot_name(text: str) -> str:
    """Return a name that a lot may have. Raises PictureError."""
    try:
        return checked_name(text, "--name")
    except LotInputError as error:
        raise PictureError(str(error)) from error


def _survey(asked: Asked, progress: Progress) -> Surveyed:
    source = asked.source
    if source.is_dir():
        if webodm.is_project(source):
            return _project(asked, progress)
        _refuse_tiles(source)
        return _photographs(asked, progress)
    kind, suffix = _kind(source), source.suffix.lower()
    if kind.remedy:
        raise PictureError(f"{source}: {kind.words}; {kind.remedy}")
    if suffix in FILMS:
        return _film(asked, progress)
    if suffix in ORTHOPHOTOS or kind.name in gdal.DRIVERS:
        return _orthophoto(asked, progress)
    every = ", ".join((*ORTHOPHOTOS, *FILMS))
    raise PictureError(f"{source}: {kind.words}; name one that ends in {every}")


def _kind(source: Path) -> Kind:
    """Return what a file is by its first bytes; `UNKNOWN` where it cannot be opened, as its reader says."""
    try:
        return kind_of_file(source)
    except OSError:
        return UNKNOWN


def _refuse_tiles(folder: Path) -> None:
    """Refuse a folder without JPEGs by what lies in it. Raises PictureError with the remedy of that kind."""
    by_ending = {entry.suffix.lower(): entry for entry in sorted(folder.iterdir(), reverse=True) if entry.is_file()}
    if by_ending.keys() & {".jpg", ".jpeg"}:
        return
    for first in by_ending.values():
        kind = _kind(first)
        if kind.name == "TIFF" and _is_placed(first):
            raise PictureError(
                f"{folder}: holds GeoTIFFs and no photographs; make one picture of its tiles, and map that: "
                f"gdalbuildvrt {folder.name}.vrt {folder}/*{first.suffix}"
            )
        if kind.name == "TIFF":
            raise PictureError(
                f"{folder}: holds photographs as TIFF ({first.name}); save them as JPEGs beside, and copy their tags: "
                f"exiftool -tagsFromFile %d%f{first.suffix} -ext jpg -overwrite_original {folder}"
            )
        if kind.name in ("HEIC", "DNG", "zip"):
            raise PictureError(f"{folder}: no JPEG photograph is in it; {first.name} {kind}")


def _is_placed(path: Path) -> bool:
    """Return whether a TIFF has a place on Earth by its pixels, as a tile of an orthophoto has."""
    with contextlib.suppress(Exception), warnings.catch_warnings():  # whatever it is, it is none then
        warnings.simplefilter("ignore")
        with gdal.open_picture(path) as opened:
            return not opened.transform.is_identity
    return False


def _orthophoto(asked: Asked, progress: Progress) -> Surveyed:
    _refuse(asked, "an orthophoto", "height_m", "lenses", "calibration", "group", "place", *_OF_FILMS)
    from hawk.picture.city.run import CityProgress, map_city

    def show(city: CityProgress) -> None:
        progress("map", city.done, city.count)

    mapped = map_city(
        asked.source,
        out=asked.out,
        outline=asked.outline,
        workers=1 if asked.workers is None else asked.workers,
        scheduler=asked.scheduler,
        crs=asked.crs,
        model=asked.model,
        progress=show,
        accept=lambda source: _check_moment(asked, source.taken),
    ).mapped
    return Surveyed(mapped, lambda: landed_of(mapped))


def _photographs(asked: Asked, progress: Progress) -> Surveyed:
    _refuse(asked, "a folder of photographs", "outline", "crs", "workers", "scheduler", *_OF_FILMS)
    lens = _calibration(asked.calibration)
    read = read_folder(
        asked.source,
        lenses=asked.lenses,
        calibration=lens,
        height_m=asked.height_m,
        group=asked.group,
        place=asked.place,
    )
    _check_times(asked, read.shots, MomentSource.EXIF if read.time_is_sure else MomentSource.CAMERA)
    return _surveyed(survey_folder(read, model=asked.model, work=asked.out / WORK, progress=progress))


def _film(asked: Asked, progress: Progress) -> Surveyed:
    """Map a film, or a recording, which has its own places and lens."""
    _refuse(asked, "a film", "outline", "crs", "workers", "scheduler", "group", "place")
    if asked.source.suffix.lower() == ".mcap":
        _refuse(asked, "a recording", "lenses", "calibration", *_OF_FILMS)
    film = read_film(
        asked.source,
        log=asked.log,
        log_offset_s=asked.log_offset_s,
        lens=LensChoice(_calibration(asked.calibration), asked.hfov_deg, asked.focal35_mm, asked.lenses),
        height_m=asked.height_m,
        progress=progress,
    )
    try:
        _check_times(asked, film.shots, MomentSource.GNSS if film.time_is_sure else MomentSource.CAMERA)
        work = asked.out / WORK
        taken = Taken(asked.source.name, SourceKind.FILM, film.time_is_sure, asked.height_m)
        survey = survey_shots(taken, film.shots, film, model=asked.model, work=work, progress=progress)
    finally:
        film.close()
    return _surveyed(survey.beside(film.left_out, film.notes))


def _project(asked: Asked, progress: Progress) -> Surveyed:
    """Map a project of OpenDroneMap: its orthophoto, or its photographs where it has none."""
    picture = webodm.orthophoto(asked.source)
    if picture is not None:
        return _called(_orthophoto(replace(asked, source=picture), progress), asked.source.resolve().name)
    _refuse(
        asked,
        "a WebODM project",
        "outline",
        "crs",
        "workers",
        "scheduler",
        "lenses",
        "calibration",
        "group",
        "place",
        *_OF_FILMS,
    )
    read = webodm.read_project(asked.source, height_m=asked.height_m)
    _check_times(asked, read.shots, MomentSource.CAMERA)
    taken = Taken(asked.source.resolve().name, SourceKind.PHOTOGRAPHS, height_m=asked.height_m)
    survey = survey_shots(taken, read.shots, Files(), model=asked.model, work=asked.out / WORK, progress=progress)
    survey = survey.beside(read.left_out, read.notes)
    mapped = replace(survey.mapped, crs=webodm.system_of(asked.source))
    return Surveyed(mapped, lambda: survey.landed)


def _check_times(asked: Asked, shots: Sequence[Shot], source: MomentSource) -> None:
    """Refuse shots whose last one has not been, as `_check_moment`. ``source``: of their times."""
    times = [shot.time for shot in shots if shot.time is not None]
    if not times:
        times, source = [shot.path.stat().st_mtime for shot in shots], MomentSource.FILE
    if times:
        _check_moment(asked, CaptureTime.said(max(times), source, asked.now))


def _check_moment(asked: Asked, moment: CaptureTime) -> None:
    """Refuse a moment that has not been, unless a person says another one. Raises PictureError."""
    if asked.taken is None and not moment.is_possible(asked.now):
        raise PictureError(
            f"{asked.source}: was taken at {utc(moment.value)} by {moment.source}, which is later than now; say when "
            "it was, as --taken 2026-05-04T10:30+02:00, or set this computer's clock"
        )


def _named(surveyed: Surveyed, name: str) -> Surveyed:
    """Return a survey of a lot with another name; it stays the same survey in the store."""
    mapped = replace(surveyed.mapped, survey=replace(surveyed.mapped.survey, lot=name))
    return Surveyed(mapped, lambda: replace(surveyed.landed(), title=name))


def _at(surveyed: Surveyed, taken: float) -> Surveyed:
    """Return a survey whose last picture was taken at a moment, Unix seconds, that a person says; it is sure then."""
    survey = surveyed.mapped.survey
    later = taken - survey.ended
    stalls = tuple(
        stall if stall.looked is None else replace(stall, looked=stall.looked + later) for stall in survey.stalls
    )
    moved = replace(survey, began=survey.began + later, ended=taken, time_is_sure=True, stalls=stalls)
    mapped = replace(surveyed.mapped, survey=moved)
    return Surveyed(mapped, lambda: replace(surveyed.landed(), utc=taken, time_is_sure=True))


def _called(surveyed: Surveyed, project: str) -> Surveyed:
    """Return a survey by a project's orthophoto, called as the project: all orthophotos of projects have one name."""
    survey = surveyed.mapped.survey
    limits = () if survey.pictures is None else survey.pictures.limits
    pictures = source_of(SourceKind.ORTHOPHOTO, project, limits)
    named = _named(surveyed, fitting_name(project) or survey.lot)
    mapped = replace(named.mapped, survey=replace(named.mapped.survey, pictures=pictures))
    return Surveyed(mapped, lambda: replace(named.landed(), pictures=pictures))


def _surveyed(survey: PhotoSurvey) -> Surveyed:
    return Surveyed(survey.mapped, lambda: survey.landed)


def _refuse(asked: Asked, kind: str, *names: str) -> None:
    """Refuse options that a kind of source has no use for. Raises PictureError naming the option."""
    for name in names:
        if getattr(asked, name) is not None:
            option = _UNIT.sub("", name).replace("_", "-")
            raise PictureError(f"--{option}: has no use for {kind}; leave it out")


def _calibration(path: Path | None) -> CameraModel | None:
    """Return the lens of a file as ROS writes it. Raises PictureError."""
    if path is None:
        return None
    try:
        found = load_calibration(CameraSettings(calibration=path))
    except ConfigError as error:
        raise PictureError(str(error).replace("camera.calibration", "--calibration")) from error
    if found.at is None:
        raise PictureError(f"--calibration: {path} has no camera_matrix; write one by hawk-drone calibrate")
    return found.for_size(found.at.image_width, found.at.image_height)
