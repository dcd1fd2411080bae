"""Sources of a survey by pictures: what is given is recognised, and mapped."""

from __future__ import annotations

import contextlib
import re
import time
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
import shapely

from hawk.comm.cameras.calibration import load_calibration
from hawk.config.sections import CameraSettings, ConfigError
from hawk.formats import gdal
from hawk.formats.kind import UNKNOWN, Kind, kind_of_file
from hawk.formats.remote_raster import Hosts, RemoteRaster
from hawk.lots.survey.landing import LandingFacts
from hawk.lots.survey.moments import CaptureTime, MomentSource, has_been
from hawk.lots.survey.source import SourceKind
from hawk.lots.values import LotInputError, checked_name, fitting_name, utc
from hawk.model.lot_map import TILE_M
from hawk.model.pictures import CameraModel
from hawk.picture import webodm
from hawk.picture.city.run import CityWork, map_city
from hawk.picture.city.scheduler import Scheduler
from hawk.picture.film.app import FILMS, read_film
from hawk.picture.film.lens import LensChoice
from hawk.picture.orthophoto.outline import read_private
from hawk.picture.orthophoto.source import Orthophoto
from hawk.picture.photographs.flight import private_ground, survey_shots
from hawk.picture.photographs.folder import read_folder
from hawk.picture.photographs.places import Choice
from hawk.picture.photographs.shot_detections import Files, Pictures
from hawk.picture.private_ground import near_shots, touches, wider
from hawk.picture.values import FlightId, PictureError, PictureSurvey, Progress, Provenance, Shot, ShotSet
from hawk.picture.work_folder import ORTHOPHOTOS, WORK, keep_stored

_UNIT: Final = re.compile("_(mm|m|deg|s)$")
_OF_ORTHOPHOTOS: Final = ("outline", "check", "checked", "allow_host")
_OF_FILMS: Final = ("log", "log_offset_s", "hfov_deg", "focal35_mm")


@dataclass(frozen=True, slots=True)
class MapRequest:
    """A source with the options of the command line.

    ``stored``: private ground of the lots of the store, ``areas``: that of the file ``private``, (longitude, latitude).
    """

    source: Path | RemoteRaster
    out: Path
    model: Path | None = None
    outline: Path | None = None
    private: Path | None = None
    check: int | None = None
    checked: Path | None = None
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
    flight: FlightId | None = None
    allow_host: Hosts | None = None
    areas: tuple[shapely.Polygon, ...] = ()
    stored: tuple[shapely.Polygon, ...] = ()
    now: float = field(default_factory=time.time)

    @property
    def local(self) -> Path:
        """The source on this computer. Raises PictureError for one of a server."""
        if isinstance(self.source, Path):
            return self.source
        raise PictureError(f"{self.source}: only orthophotos are read from servers; copy it here")


def survey_of_source(asked: MapRequest, progress: Progress) -> PictureSurvey:
    """Map a source. Raises PictureError: it cannot be mapped, or an option does not fit it."""
    if asked.name is not None:
        asked = replace(asked, name=_lot_name(asked.name))
    areas = () if asked.private is None else read_private(asked.private)
    mapped = _survey_of(replace(asked, areas=areas), progress)
    return replace(mapped, notes=(*mapped.notes, *_private_notes(asked, areas, mapped.landed)))


def _private_notes(asked: MapRequest, areas: Sequence[shapely.Polygon], landed: LandingFacts) -> Iterator[str]:
    """Yield what became of private ground: a file that has none near the map has a mistake in it, a store has not."""
    if asked.private is not None:
        name = asked.private.name
        if _are_near(areas, landed):
            yield f"No picture shows the areas of {name}, and nothing is counted there."
        else:
            yield f"No area of {name} lies where the pictures are, so that they show everything: look at its places."
    if asked.stored and _are_near(asked.stored, landed):
        yield "No picture shows the private ground of the store's lots, and nothing is counted there."


def _are_near(areas: Sequence[shapely.Polygon], landed: LandingFacts) -> bool:
    """Return whether areas lie on the map; True for one without pictures."""
    rows, columns = np.array([*landed.current.tiles], np.float64).reshape(-1, 2).T * TILE_M
    return not len(rows) or private_ground(areas, landed.datum).intersects(
        shapely.box(-rows.max() - TILE_M, columns.min(), -rows.min(), columns.max() + TILE_M)
    )


def _survey_of(asked: MapRequest, progress: Progress) -> PictureSurvey:
    source = asked.source
    if isinstance(source, RemoteRaster):
        return _orthophoto(asked, progress)
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


def _lot_name(text: str) -> str:
    """Return a name that a lot may have. Raises PictureError."""
    try:
        return checked_name(text, "--name")
    except LotInputError as error:
        raise PictureError(str(error)) from error


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


def _orthophoto(asked: MapRequest, progress: Progress, project: Path | None = None) -> PictureSurvey:
    """Map an orthophoto; that of a ``project`` is called as it: all orthophotos of projects have one name."""
    _refuse(asked, "an orthophoto", "height_m", "lenses", "calibration", "group", "place", *_OF_FILMS)
    picture = asked.source if isinstance(asked.source, RemoteRaster) else asked.source.resolve()
    name, title = (picture.name, "") if project is None else (project.name, fitting_name(project.name))
    stored = [wider(area) for area in asked.stored]
    work = CityWork(
        picture,
        out=asked.out,
        outline=asked.outline,
        private=(*asked.areas, *stored),
        hosts=asked.allow_host or (),
        workers=1 if asked.workers is None else asked.workers,
        scheduler=asked.scheduler,
        crs=asked.crs,
        model=asked.model,
        provenance=_provenance(replace(asked, name=asked.name or title), name, SourceKind.ORTHOPHOTO),
    )

    def accept(picture: Orthophoto) -> None:
        _check_moment(asked, picture.taken)
        pairs = zip(asked.stored, stored, strict=True)
        keep_stored(asked.out, (area for area, wide in pairs if touches(picture, wide)))

    return map_city(work, partial(progress, "map"), accept).mapped


def _photographs(asked: MapRequest, progress: Progress) -> PictureSurvey:
    _refuse(asked, "a folder of photographs", *_OF_ORTHOPHOTOS, "crs", "workers", "scheduler", *_OF_FILMS)
    read = read_folder(
        asked.local,
        lenses=asked.lenses,
        calibration=calibration_of(asked.calibration),
        height_m=asked.height_m,
        group=asked.group,
        place=asked.place,
    )
    _check_times(asked, read.shots, MomentSource.EXIF if read.time_is_sure else MomentSource.CAMERA)
    name = asked.local.resolve().name if asked.flight is None else asked.flight.name
    provenance = _provenance(asked, name, SourceKind.PHOTOGRAPHS, read)
    return _of_shots(asked, provenance, read, Files(), progress)


def _film(asked: MapRequest, progress: Progress) -> PictureSurvey:
    """Map a film, or a recording, which has its own places and lens."""
    _refuse(asked, "a film", *_OF_ORTHOPHOTOS, "crs", "workers", "scheduler", "group", "place")
    if asked.local.suffix.lower() == ".mcap":
        _refuse(asked, "a recording", "lenses", "calibration", *_OF_FILMS)
    film = read_film(
        asked.local,
        log=asked.log,
        log_offset_s=asked.log_offset_s,
        lens=LensChoice(calibration_of(asked.calibration), asked.hfov_deg, asked.focal35_mm, asked.lenses),
        height_m=asked.height_m,
        progress=progress,
    )
    try:
        _check_times(asked, film.shots, MomentSource.GNSS if film.time_is_sure else MomentSource.CAMERA)
        provenance = _provenance(asked, asked.local.name, SourceKind.FILM, film)
        return _of_shots(asked, provenance, film, film, progress)
    finally:
        film.close()


def _project(asked: MapRequest, progress: Progress) -> PictureSurvey:
    """Map a project of OpenDroneMap: its orthophoto, or its photographs where it has none."""
    folder = asked.local.resolve()
    picture = webodm.orthophoto(asked.local)
    if picture is not None:
        return _orthophoto(replace(asked, source=picture), progress, folder)
    no_use = (*_OF_ORTHOPHOTOS, "crs", "workers", "scheduler", "lenses", "calibration", "group", "place")
    _refuse(asked, "a WebODM project", *no_use, *_OF_FILMS)
    read = webodm.read_project(asked.local, height_m=asked.height_m)
    _check_times(asked, read.shots, MomentSource.CAMERA)
    provenance = _provenance(asked, folder.name, SourceKind.PHOTOGRAPHS, read)
    return replace(_of_shots(asked, provenance, read, Files(), progress), crs=webodm.system_of(asked.local))


def _provenance(asked: MapRequest, name: str, kind: SourceKind, read: ShotSet | None = None) -> Provenance:
    is_sure = read is not None and read.time_is_sure
    flight = asked.flight
    title = asked.name or ("" if flight is None else fitting_name(flight.name))
    return Provenance(name, kind, is_sure, asked.height_m, title, asked.taken, flight)


def _of_shots(
    asked: MapRequest, provenance: Provenance, read: ShotSet, pictures: Pictures, progress: Progress
) -> PictureSurvey:
    work = asked.out / WORK
    keep_stored(asked.out, near_shots(asked.stored, read.shots))
    return survey_shots(
        provenance,
        read,
        pictures,
        private=(*asked.areas, *asked.stored),
        model=asked.model,
        work=work,
        progress=progress,
    ).mapped


def _check_times(asked: MapRequest, shots: Sequence[Shot], source: MomentSource) -> None:
    """Refuse shots whose last one has not been, as `_check_moment`. ``source``: of their times."""
    times = [shot.time for shot in shots if shot.time is not None]
    if not times:
        times, source = [shot.path.stat().st_mtime for shot in shots], MomentSource.FILE
    if times:
        _check_moment(asked, CaptureTime.said(max(times), source, asked.now))


def _check_moment(asked: MapRequest, moment: CaptureTime) -> None:
    """Refuse a moment that has not been, unless a person says another one, and that one where the files are sure.

    Raises PictureError.
    """
    if asked.taken is None and not moment.is_possible(asked.now):
        raise PictureError(
            f"{asked.source}: was taken at {utc(moment.value)} by {moment.source}, which is later than now; say when "
            "it was, as --taken 2026-05-04T10:30+02:00, or set this computer's clock"
        )
    if asked.taken is not None and moment.is_sure and has_been(moment.value, asked.now):
        said = utc(moment.value)
        raise PictureError(f"--taken: the files say themselves that the last picture is of {said}; leave it out")


def _refuse(asked: MapRequest, kind: str, *names: str) -> None:
    """Refuse options that a kind of source has no use for. Raises PictureError naming the option."""
    for name in names:
        if getattr(asked, name) is not None:
            option = _UNIT.sub("", name).replace("_", "-")
            raise PictureError(f"--{option}: has no use for {kind}; leave it out")


def calibration_of(path: Path | None) -> CameraModel | None:
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
