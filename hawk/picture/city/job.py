"""The job of a run: everything that its workers share, and the check that a computer fits it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from hawk.algo.vision.network import Engine, EngineChoice
from hawk.picture.orthophoto.source import Orthophoto, open_orthophoto
from hawk.picture.orthophoto.tile_detector import TileDetector, program_name
from hawk.picture.orthophoto.tile_results import Results
from hawk.picture.values import PictureError

LoadDetector = Callable[[Path | None, EngineChoice], TileDetector]


@dataclass(frozen=True, slots=True)
class Job:
    """Everything that the workers of one run share.

    ``source``: the picture as the client sees it, ``crs`` what a person said of it. ``model``: the network's file, None
    for that of the package; ``sha``: its SHA-256; ``program``: name of program and network. ``folder``: of the results.
    ``mark``: a file in it that the client has written. ``load``: loads the detector.
    """

    source: Orthophoto = field(repr=False)
    crs: str | None
    model: Path | None
    sha: str
    program: str
    engine: Engine
    folder: Path
    load: LoadDetector = field(repr=False)
    mark: str = ""


def fitting_detector(job: Job) -> TileDetector:
    """Return the detector of a job after a check that this computer sees what the client sees. Raises PictureError."""
    results = Results(job.folder)
    if not (results.folder / job.mark).is_file():
        raise PictureError(f"does not see the folder {job.folder}; share it with this computer, at the same path")
    results.prepare()
    try:
        seen = open_orthophoto(job.source.path, job.crs, job.source.hosts)
    except PictureError as error:
        raise PictureError(f"{error} (share the picture with this computer, at the same path)") from error
    if seen.identity != job.source.identity:
        raise PictureError(
            f"{job.source.path}: is another file here, by size or time of change; share the disk, do not copy"
        )
    detector = job.load(job.model, job.engine)
    if program_name(detector.model) != job.program or detector.model != job.sha:
        raise PictureError(
            f"runs {program_name(detector.model)}, the client {job.program}; install the same version and name one "
            "model"
        )
    return detector
