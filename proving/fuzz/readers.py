"""Readers of strangers' files, as their commands call them: each takes a path, and refuses in words of its own."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from proving.fuzz import bases
from proving.fuzz.damage import Base

Bases = Callable[[Path], Iterator[Base]]


@dataclass(frozen=True, slots=True)
class FileReader:
    """``prepare`` returns the call that reads a path, and the errors by which it refuses. ``bases``: sound files."""

    name: str
    bases: Bases
    prepare: Callable[[], tuple[Callable[[Path], object], tuple[type[Exception], ...]]]


Prepared = tuple[Callable[[Path], object], tuple[type[Exception], ...]]


def _plan() -> Prepared:
    from hawk.lots.plan_files.formats import read_plan
    from hawk.lots.plan_files.values import Asked
    from hawk.lots.values import LotInputError

    return lambda path: read_plan(path.read_bytes(), Asked()), (LotInputError,)


def _outline() -> Prepared:
    from hawk.formats.box import RefusedError, named, words_of_error
    from hawk.picture.orthophoto import outline
    from hawk.picture.values import PictureError

    def here(reader: str, data: bytes, asked: dict[str, Any]) -> bytes:
        """Read in this process, which is a box of its own."""
        try:
            return named(reader)(data, asked)
        except ValueError as error:
            raise RefusedError(*words_of_error(error)) from error

    vars(outline)["read_and_wait"] = here
    return outline.read_outline, (PictureError,)


def _fence() -> Prepared:
    from hawk.ddc.fence.geojson import read_fence, read_survey_outline
    from hawk.ddc.fence.geometry import FenceError

    def read(path: Path) -> None:
        try:
            read_fence(path)
        except FenceError:
            read_survey_outline(path)

    return read, (FenceError,)


def _picture() -> Prepared:
    from hawk.picture.orthophoto.source import open_orthophoto
    from hawk.picture.values import PictureError

    def read(path: Path) -> None:
        tiles = path.parent / "a.tif"
        if not tiles.exists():
            shutil.copyfile(path.parent.parent / "bases" / "a.tif", tiles)
        path.with_suffix(".wld").write_text("0.1\n0\n0\n-0.1\n155000\n463000\n")
        source = open_orthophoto(path, "EPSG:28992")
        source.read((0, 0, min(source.grid.columns, 512), min(source.grid.rows, 512)))
        source.ground(512)

    return read, (PictureError,)


def _background() -> Prepared:
    from hawk.background.tiles import PictureError, open_picture

    def read(path: Path) -> None:
        with open_picture(path):
            pass

    return read, (PictureError,)


def _photograph() -> Prepared:
    from hawk.formats.image import NoImage, decode
    from hawk.picture.photographs.lenses import Lenses
    from hawk.picture.photographs.photograph import UnusableError, read_photograph
    from hawk.picture.values import PictureError

    table = Lenses()

    def read(path: Path) -> None:
        read_photograph(path, table)
        decode(path.read_bytes())

    return read, (UnusableError, PictureError, NoImage)


def _recording() -> Prepared:
    from hawk.picture.film.recording import read_frames
    from hawk.picture.values import PictureError

    return read_frames, (PictureError,)


def _replay() -> Prepared:
    from hawk.ddc.replay import ReplayError, compare_recording
    from hawk.store.replay import RecordingError

    return compare_recording, (ReplayError, RecordingError)


def _film() -> Prepared:
    from hawk.picture.film.container import read_made
    from hawk.picture.film.video import Video
    from hawk.picture.values import PictureError

    def read(path: Path) -> None:
        read_made(path)
        video = Video(path)
        for _ in video.frames_of(range(min(video.frames, 6))):
            pass
        video.close()

    return read, (PictureError,)


def _captions() -> Prepared:
    from hawk.picture.film.captions import read_captions
    from hawk.picture.values import PictureError

    return lambda path: read_captions(path, 12, 10.0), (PictureError,)


def _log() -> Prepared:
    from hawk.picture.film.autopilot_log import read_log
    from hawk.picture.values import PictureError

    return read_log, (PictureError,)


def _table() -> Prepared:
    from hawk.comm.cameras.calibration import load_calibration
    from hawk.config.loader import load_config
    from hawk.config.sections import CameraSettings, ConfigError
    from hawk.picture.photographs.lenses import Lenses
    from hawk.picture.values import PictureError

    def read(path: Path) -> None:
        if path.suffix == ".yaml":
            load_calibration(CameraSettings(calibration=path))
            return
        try:
            Lenses(path)
        except PictureError:
            load_config(path, {})

    return read, (ConfigError, PictureError)


def _project() -> Prepared:
    from hawk.picture.values import PictureError
    from hawk.picture.webodm import SHOTS, is_project, read_project

    def read(path: Path) -> None:
        shots = path.parent / SHOTS
        shots.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, shots)
        (path.parent / "images").mkdir(exist_ok=True)
        shutil.copyfile(path.parent.parent / "bases" / "given.jpg", path.parent / "images" / "given.jpg")
        if is_project(path.parent):
            read_project(path.parent, height_m=40.0)

    return read, (PictureError,)


def _store() -> Prepared:
    from hawk.lots.storage.backup import restore
    from hawk.lots.values import LotStoreError

    return lambda path: restore(path.parent / "store" / "lots.sqlite", path), (LotStoreError,)


READERS: Final = tuple(
    FileReader(name, made, prepare)
    for name, made, prepare in (
        ("plan", bases.plans, _plan),
        ("outline", bases.areas, _outline),
        ("fence", bases.fences, _fence),
        ("picture", bases.pictures, _picture),
        ("background", bases.pictures, _background),
        ("photograph", bases.photographs, _photograph),
        ("recording", bases.flown, _recording),
        ("replay", bases.decided, _replay),
        ("film", bases.films, _film),
        ("captions", bases.captions, _captions),
        ("log", bases.logs, _log),
        ("table", bases.tables, _table),
        ("project", bases.projects, _project),
        ("restore", bases.stores, _store),
    )
)
