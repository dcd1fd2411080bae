"""The three steps of mapping an orthophoto: `start` names windows, `map_task` fills a store, `merge_results` ends it.

A window's result is named by everything that makes it, so that a store which keeps results never asks for one again.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from shapely import Polygon

from hawk.algo.vision.detector import one_thread
from hawk.algo.vision.network import Engine
from hawk.formats.remote_raster import Hosts, RemoteRaster
from hawk.picture.orthophoto.lots import SurveysByLot
from hawk.picture.orthophoto.outline import LotOutline, read_outline
from hawk.picture.orthophoto.sample import PictureSample
from hawk.picture.orthophoto.source import Orthophoto, open_orthophoto
from hawk.picture.orthophoto.survey import Findings, PictureFrame, check_ground, to_survey, without_obstacles
from hawk.picture.orthophoto.tile_detector import TileDetector
from hawk.picture.orthophoto.tile_results import Results
from hawk.picture.orthophoto.windows import CORE_M, Task, Window, WindowStalls, map_window, task_name, windows_of
from hawk.picture.private_ground import rings_in
from hawk.picture.values import LeftOut, PictureError, PictureSurvey, Provenance

_GONE: Final = "its result is gone; go on by --resume"


@dataclass(frozen=True, slots=True)
class MappingPlan:
    """A picture that is ready: ``lots`` near it (None: all ground counts), the detector, all its tasks."""

    source: Orthophoto
    lots: LotOutline | None = field(repr=False)
    detector: TileDetector = field(repr=False)
    tasks: tuple[Task, ...] = field(repr=False)

    def missing(self, store: Results) -> tuple[Task, ...]:
        """Return the tasks that have no result yet."""
        return tuple(task for task in self.tasks if store.find(task) is None)


def start(
    path: Path | RemoteRaster,
    *,
    outline: Path | LotOutline | None,
    crs: str | None,
    load: Callable[[], TileDetector],
    core_m: float = CORE_M,
    private: Sequence[Polygon] = (),
    hosts: Hosts = (),
) -> MappingPlan:
    """Open a picture and name its windows.

    Args:
        path: The picture.
        outline: Outlines of lots, or a file with them; nothing else is mapped. None: the whole picture.
        crs: The picture's system of coordinates, where its file does not say it.
        load: Loads the detector.
        core_m: Side of a window's core, metres.
        private: Areas that nobody may look at, (longitude, latitude).
        hosts: Those that may be asked for it.

    Raises:
        PictureError: The picture, the outlines or the network cannot be used; the text has the remedy.
    """
    source = open_orthophoto(path, crs, hosts)
    if private:
        source = replace(source, private=rings_in(source.grid, private))
    lots = _near(source, outline)
    detector = load()
    tasks = tasks_of(source, windows_of(source, lots, core_m=core_m), detector.model, detector.engine)
    return MappingPlan(source, lots, detector, tasks)


def _near(source: Orthophoto, outline: Path | LotOutline | None) -> LotOutline | None:
    """Return the outlines that lie in a picture. Raises PictureError, which names the option and their file."""
    if not isinstance(outline, Path):
        return None if outline is None else outline.near(source.grid)
    try:
        lots = read_outline(outline)
    except PictureError as error:
        raise PictureError(f"--outline: {error}") from error
    try:
        return lots.near(source.grid)
    except PictureError as error:
        raise PictureError(f"--outline: {outline}: {error}") from error


def tasks_of(source: Orthophoto, windows: Iterable[Window], model: str, engine: Engine) -> tuple[Task, ...]:
    """Return the tasks of a picture's windows, in their order.

    Args:
        source: The picture.
        windows: Its windows.
        model: SHA-256 of the network's file.
        engine: Runs the network; engines differ in the last digits, so that the result's name has it.
    """
    # a mosaic of thousands of files has a long identity, which would be hashed for each window
    short = replace(source, identity=hashlib.sha256(source.identity.encode()).hexdigest())
    return tuple(Task(f"{task_name(short, window, model)}-{engine}", window) for window in windows)


def map_task(task: Task, source: Orthophoto, detector: TileDetector, store: Results) -> str:
    """Look at a task's window unless its result is there.

    Returns:
        The reason why it could not be looked at, which the store takes too; "" when the result is there.

    Raises:
        PictureError: The store cannot be written.
    """
    if store.find(task) is not None:
        return ""
    try:
        found = map_window(source, task.window, detector)
    except PictureError as error:
        reason = str(error)
    except (cv2.error, MemoryError) as error:  # one window that is too large for the memory ends no run
        said = " ".join(f"{type(error).__name__} {error}".split())[:160]
        reason = f"memory may be short ({said}); close other programs, or start fewer --workers"
    else:
        store.keep(task, found)
        return ""
    store.fail(task, task.window.name(source.grid), reason)
    return reason


def map_tasks(
    tasks: Sequence[Task], source: Orthophoto, detector: TileDetector, store: Results
) -> Generator[tuple[Task, str]]:
    """Yield each task after `map_task` at it in this process, with the reason that this returned."""
    with one_thread():
        for task in tasks:
            yield task, map_task(task, source, detector, store)


def merge_results(
    started: MappingPlan, store: Results, failures: Mapping[str, str], provenance: Provenance | None = None
) -> PictureSurvey:
    """Return the survey of the results in a store. Windows without one are named in its ``left_out``.

    Args:
        started: The picture.
        store: Its results.
        failures: By the names of tasks, why they failed.
        provenance: Name of the picture, and what a person says of it; None: that of its file.

    Raises:
        PictureError: No window has a result, or none shows ground; the results are removed then.
    """
    source, has_lots = started.source, started.lots is not None
    found = [(task, _slim(store.find(task), has_lots)) for task in started.tasks]
    left_out = [
        LeftOut(task.window.name(source.grid), failures.get(task.name, _GONE)) for task, part in found if part is None
    ]
    if len(left_out) == len(found) > 0:
        raise PictureError(left_out[0].reason)
    findings = Findings.of(
        source,
        [part for _, part in found if part is not None],
        provenance=provenance,
        model=started.detector.model,
        left_out=left_out,
    )
    findings, notes = without_obstacles(findings, started.lots)
    mapped = to_survey(findings, started.lots)
    plane = PictureFrame(source.grid, None if started.lots is None else started.lots.in_metres(source.grid))
    mapped = replace(mapped, notes=(*mapped.notes, *notes), sample=PictureSample(findings, plane))
    if started.lots is not None and len(started.lots.lots) > 1:
        failed = [task.window for task, part in found if part is None]
        mapped = replace(mapped, lots=SurveysByLot(findings, started.lots, failed))
    try:
        check_ground(mapped, source, has_lots=has_lots)
    except PictureError:
        store.clear(started.tasks)
        raise
    return mapped


def _slim(part: WindowStalls | None, is_on_lots: bool) -> WindowStalls | None:
    """Return a result with masks that need no memory where they say the same everywhere: a city has thousands.

    ``is_on_lots``: outlines say where the lots are, so that the lot which was found is not asked for.
    """
    if part is None:
        return None
    seen = part.seen
    if seen.all() or not seen.any():
        seen = np.broadcast_to(seen[0, 0], seen.shape)
    lot = np.broadcast_to(np.False_, seen.shape) if is_on_lots or not part.lot.any() else part.lot
    return replace(part, lot=lot, seen=seen)
