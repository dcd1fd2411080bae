"""An orthophoto or a city mapped: windows that have no result yet go to workers, then all results are merged.

With one worker and no scheduler everything runs in this process; the files are the same.
"""

from __future__ import annotations

import contextlib
import tempfile
import time
import uuid
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from pathlib import Path

from shapely import Polygon

from hawk.algo.vision.network import EngineChoice
from hawk.formats.remote_raster import Hosts, RemoteRaster
from hawk.lots.survey.source import SourceKind
from hawk.picture.city.job import Job, LoadDetector
from hawk.picture.city.scheduler import Scheduler
from hawk.picture.orthophoto.grid import PixelGrid
from hawk.picture.orthophoto.outline import LotOutline
from hawk.picture.orthophoto.source import Orthophoto
from hawk.picture.orthophoto.steps import MappingPlan, map_tasks, merge_results, start
from hawk.picture.orthophoto.tile_detector import TileDetector, program_name
from hawk.picture.orthophoto.tile_results import ResultError, Results
from hawk.picture.orthophoto.windows import CORE_M, Task
from hawk.picture.values import PictureError, PictureSurvey, Provenance
from hawk.runtime.programs import remedy


@dataclass(frozen=True, slots=True)
class CityWork:
    """A picture to map by many workers, and how.

    Attributes:
        path: The picture, as for `map_orthophoto`; a VRT for many files.
        out: Folder of the results, a file a window.
        outline: Outlines of lots, or a file with them; nothing else is mapped. None: the whole picture.
        workers: Processes on this computer.
        scheduler: A Dask scheduler, whose workers are used instead; they share the disk at the same paths.
        crs: The picture's system of coordinates, where its file does not say it.
        model: The network's ONNX file; None: that of the package.
        engine: Runs the network on all workers; "auto": the fastest that this computer has.
        core_m: Side of a window's core, metres.
        load: Loads the detector; workers import it by its name.
        provenance: Name of the picture, and what a person says of it; None: that of its file.
        private: Areas that nobody may look at, (longitude, latitude): no window and no picture shows them.
        hosts: Those that may be asked for the picture, or for what it names.
    """

    path: Path | RemoteRaster
    _: KW_ONLY
    out: Path
    outline: Path | LotOutline | None = None
    workers: int = 1
    scheduler: Scheduler | None = None
    crs: str | None = None
    model: Path | None = None
    engine: EngineChoice = "auto"
    core_m: float = CORE_M
    load: LoadDetector = TileDetector.load
    provenance: Provenance | None = None
    private: tuple[Polygon, ...] = ()
    hosts: Hosts = ()

    def check(self) -> None:
        """Raise PictureError where its workers cannot be had."""
        if self.workers < 1:
            raise PictureError(f"--workers: {self.workers} is no number of processes; give 1 or more")
        if self.scheduler is not None:
            self.scheduler.check()
            self.scheduler.check_reached()


@dataclass(frozen=True, slots=True)
class CityRun:
    """A city's survey, with what its run did: windows in all, windows found from earlier runs, seconds of the looking.

    Failed windows are ``mapped.left_out``; the next run tries them again.
    """

    mapped: PictureSurvey
    windows: int
    reused: int
    seconds: float = field(compare=False)


Progress = Callable[[int, int], None]
"""Takes the number of windows that are done, found ones of earlier runs among them, and of all."""


def map_orthophoto(
    path: Path,
    *,
    outline: Path | LotOutline | None = None,
    crs: str | None = None,
    model: Path | None = None,
    progress: Progress = lambda *_: None,
) -> PictureSurvey:
    """Find the stalls of an orthophoto, free and taken, in this process.

    Args:
        path: A GeoTIFF, a VRT, or a JPEG or PNG with its world file.
        outline: Outlines of lots, or a file with them; nothing else is mapped. None: the whole picture.
        crs: The picture's system of coordinates, as ``EPSG:25832``, where its file does not say it.
        model: The network's ONNX file; None: that of the package.
        progress: Is called before the first window and after each one.

    Returns:
        The survey. A window that could not be read is named in ``left_out``, the others are mapped.

    Raises:
        PictureError: The picture or the outlines cannot be used, or no window can be read; the text has the remedy.
    """
    provenance = Provenance(path.name, SourceKind.ORTHOPHOTO)
    with tempfile.TemporaryDirectory(prefix="hawk-windows-") as folder:
        work = CityWork(path, out=Path(folder), outline=outline, crs=crs, model=model, provenance=provenance)
        return map_city(work, progress).mapped


def map_city(
    work: CityWork, progress: Progress = lambda *_: None, accept: Callable[[Orthophoto], None] = lambda _: None
) -> CityRun:
    """Find the stalls of a large picture by many workers. The same call goes on where an earlier one was cut off.

    Workers are started as new processes of Python: a program that calls this has its own work under
    ``if __name__ == "__main__":``.

    Args:
        work: The picture, and how it is mapped.
        progress: Is called before the first window and after each one.
        accept: Is called before the work with the picture; what it raises goes on.

    Raises:
        PictureError: Picture, outlines, folder, scheduler or a worker cannot be used, or no window can be looked at;
            the text has the remedy. Results that are done stay.
    """
    work.check()
    started = start(
        work.path if isinstance(work.path, RemoteRaster) else work.path.resolve(),
        outline=work.outline,
        crs=work.crs,
        load=lambda: work.load(work.model, work.engine),
        core_m=work.core_m,
        private=work.private,
        hosts=work.hosts,
    )
    accept(started.source)
    results = Results(work.out.resolve())
    results.prepare()
    missing, count = started.missing(results), len(started.tasks)
    done = count - len(missing)
    with _ended(_job(started, work, results.folder), started.detector, results, missing, work) as ended:
        began = time.monotonic()  # starting the workers is no looking
        progress(done, count)
        failures = _failures(enumerate(ended, done + 1), count, progress, results, started.source.grid)
    seconds = time.monotonic() - began
    return CityRun(merge_results(started, results, failures, work.provenance), count, done, seconds)


def _job(plan: MappingPlan, work: CityWork, folder: Path) -> Job:
    return Job(
        source=plan.source,
        crs=work.crs,
        model=None if work.model is None else work.model.resolve(),
        sha=plan.detector.model,
        program=program_name(plan.detector.model),
        engine=plan.detector.engine,
        folder=folder,
        load=work.load,
    )


def _failures(
    ended: Iterable[tuple[int, tuple[Task, str]]], count: int, progress: Progress, results: Results, grid: PixelGrid
) -> dict[str, str]:
    """Take all tasks with their numbers; return, by their names, why some failed, and write it: dead workers cannot."""
    failures = {}
    for done, (task, reason) in ended:
        if reason:
            failures[task.name] = reason
            if results.find(task) is None:  # a worker may die just after it has written
                results.fail(task, task.window.name(grid), reason)
        progress(done, count)
    return failures


@contextlib.contextmanager
def _ended(
    job: Job, detector: TileDetector, results: Results, tasks: Sequence[Task], work: CityWork
) -> Iterator[Iterator[tuple[Task, str]]]:
    """Give the tasks as they end, with why they failed, once the workers are there. Raises PictureError."""
    if not tasks or (work.workers == 1 and work.scheduler is None):
        with contextlib.closing(map_tasks(tasks, job.source, detector, results)) as ended:
            yield ended
        return
    try:
        from hawk.picture.city.cluster import run_on, workers_of
    except ImportError as error:
        raise PictureError(f"distributed is not installed, which runs workers: {remedy('cluster')}") from error
    with (
        workers_of(work.scheduler, min(work.workers, len(tasks))) as client,
        _marked(job) as marked,
        contextlib.closing(run_on(client, marked, tasks)) as outcomes,
    ):
        yield ((outcome.task, outcome.reason) for outcome in outcomes)


@contextlib.contextmanager
def _marked(job: Job) -> Iterator[Job]:
    """Write a file into the folder, by which a worker finds that it sees the same one. Raises ResultError."""
    mark = job.folder / f".run-{uuid.uuid4().hex}"
    try:
        mark.touch()
    except OSError as error:
        raise ResultError(mark, error) from error
    try:
        yield replace(job, mark=mark.name)
    finally:
        mark.unlink(missing_ok=True)
