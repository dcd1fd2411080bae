"""A city mapped: windows that have no result yet go to workers, then all results are merged.

With one worker and no scheduler everything runs in this process; the files are the same.
"""

from __future__ import annotations

import contextlib
import time
import uuid
from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from hawk.algo.vision.network import EngineChoice
from hawk.picture.city.job import Job, LoadEye
from hawk.picture.city.results import ResultError, Results
from hawk.picture.city.scheduler import Scheduler
from hawk.picture.nadir import Eye, program_name
from hawk.picture.orthophoto.grid import PixelGrid
from hawk.picture.orthophoto.outline import LotOutline
from hawk.picture.orthophoto.source import Orthophoto
from hawk.picture.orthophoto.steps import Task, looked, settle, start
from hawk.picture.orthophoto.windows import CORE_M
from hawk.picture.values import Mapped, PictureError, Provenance
from hawk.runtime.programs import remedy


@dataclass(frozen=True, slots=True)
class CityProgress:
    """Windows of a run: all of it, those that are done, of these ones found from earlier runs, and failed ones.

    ``left_s``: seconds left by the pace up to now, None before the first window.
    """

    count: int
    done: int
    reused: int
    failed: int
    left_s: float | None


@dataclass(frozen=True, slots=True)
class CityRun:
    """A city's survey, with what its run did: windows in all, windows found from earlier runs, seconds of the looking.

    Failed windows are ``mapped.left_out``; the next run tries them again.
    """

    mapped: Mapped
    windows: int
    reused: int
    seconds: float = field(compare=False)


Progress = Callable[[CityProgress], None]


def map_city(
    path: Path,
    *,
    out: Path,
    outline: Path | LotOutline | None = None,
    workers: int = 1,
    scheduler: Scheduler | None = None,
    crs: str | None = None,
    model: Path | None = None,
    engine: EngineChoice = "auto",
    progress: Progress = lambda _: None,
    core_m: float = CORE_M,
    load: LoadEye = Eye.load,
    accept: Callable[[Orthophoto], None] = lambda _: None,
    provenance: Provenance | None = None,
) -> CityRun:
    """Find the stalls of a large picture by many workers. The same call goes on where an earlier one was cut off.

    Workers are started as new processes of Python: a program that calls this has its own work under
    ``if __name__ == "__main__":``.

    Args:
        path: The picture, as for `hawk.picture.orthophoto.app.map_orthophoto`; a VRT for many files.
        out: Folder of the results, a file a window.
        outline: Outlines of lots, or a file with them; nothing else is mapped. None: the whole picture.
        workers: Processes on this computer.
        scheduler: A Dask scheduler, whose workers are used instead; they share the disk at the same paths.
        crs: The picture's system of coordinates, where its file does not say it.
        model: The network's ONNX file; None: that of the package.
        engine: Runs the network on all workers; "auto": the fastest that this computer has.
        progress: Is called before the first window and after each one.
        core_m: Side of a window's core, metres.
        load: Loads the eye; workers import it by its name.
        accept: Is called before the work with the picture; what it raises goes on.
        provenance: Name of the picture, and what a person says of it; None: that of its file.

    Raises:
        PictureError: Picture, outlines, folder, scheduler or a worker cannot be used, or no window can be looked at;
            the text has the remedy. Results that are done stay.
    """
    if workers < 1:
        raise PictureError(f"--workers: {workers} is no number of processes; give 1 or more")
    if scheduler is not None:
        scheduler.check()
        scheduler.check_reached()
    started = start(path.resolve(), outline=outline, crs=crs, load=lambda: load(model, engine), core_m=core_m)
    accept(started.source)
    eye, results = started.eye, Results(out.resolve())
    results.prepare()
    missing, count = started.missing(results), len(started.tasks)
    named = None if model is None else model.resolve()
    job = Job(started.source, crs, named, eye.model, program_name(eye.model), eye.engine, results.folder, load)
    pace = _Pace(count, count - len(missing), progress)
    failures = _failures(_ended(job, eye, missing, workers, scheduler), pace, results, started.source.grid)
    return CityRun(settle(started, results, failures, provenance), count, count - len(missing), pace.seconds)


def _failures(
    ended: Generator[tuple[Task | None, str]], pace: _Pace, results: Results, grid: PixelGrid
) -> dict[str, str]:
    """Take all tasks of `_ended`; return, by their names, why some failed, and write it: a dead worker cannot."""
    failures = {}
    with contextlib.closing(ended):
        for task, reason in ended:
            if task is not None and reason:
                failures[task.name] = reason
                if results.find(task) is None:  # a worker may die just after it has written
                    results.fail(task, task.window.name(grid), reason)
            pace.step(0 if task is None else 1, bool(reason))
    return failures


class _Pace:
    """Counts windows and says how far the run is."""

    def __init__(self, count: int, reused: int, progress: Progress) -> None:
        self._count = count
        self._reused = reused
        self._progress = progress
        self._done = 0
        self._failed = 0
        self._began = time.monotonic()

    def step(self, done: int, is_failed: bool) -> None:
        """Count windows that have ended."""
        if not done:
            self._began = time.monotonic()  # starting the workers is no looking
        self._done += done
        self._failed += is_failed
        left = self._count - self._reused - self._done
        left_s = self.seconds / self._done * left if self._done else None
        self._progress(CityProgress(self._count, self._reused + self._done, self._reused, self._failed, left_s))

    @property
    def seconds(self) -> float:
        """Seconds of looking."""
        return time.monotonic() - self._began


def _ended(
    job: Job, eye: Eye, tasks: Sequence[Task], workers: int, scheduler: Scheduler | None
) -> Generator[tuple[Task | None, str]]:
    """Yield a task that has ended, and why it failed; first once without a task."""
    if not tasks or (workers == 1 and scheduler is None):
        yield None, ""
        yield from looked(tasks, job.source, eye, Results(job.folder))
        return
    try:
        from hawk.picture.city.cluster import run_on, workers_of
    except ImportError as error:
        raise PictureError(f"distributed is not installed, which runs workers: {remedy('cluster')}") from error
    with workers_of(scheduler, min(workers, len(tasks))) as client, _marked(job) as marked:
        yield None, ""
        for outcome in run_on(client, marked, tasks):
            yield outcome.task, outcome.reason


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
