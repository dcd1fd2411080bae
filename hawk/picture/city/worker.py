"""A worker's part: it checks that it sees what the client sees, loads the detector once, and looks at windows.

Dask (`distributed`, the extra ``cluster``) sends the job to each worker, also to those that join later, and the tasks
to whichever is free.
"""

from __future__ import annotations

import socket
from typing import Any, Final

import cv2
from distributed import Worker, WorkerPlugin, get_worker

from hawk.picture.city.job import Job, fitting_detector
from hawk.picture.orthophoto.steps import map_task
from hawk.picture.orthophoto.tile_detector import TileDetector
from hawk.picture.orthophoto.tile_results import Results
from hawk.picture.orthophoto.windows import Task
from hawk.picture.values import PictureError

_PLUGIN: Final = "hawk-city"


class CityWorker(WorkerPlugin):
    """The job on one worker. A worker that does not fit the job raises PictureError in `setup`, and gets no window."""

    def __init__(self, job: Job) -> None:
        """``job``: the run's."""
        self.name = f"{_PLUGIN}-{job.mark}"
        self._job = job
        self._detector: TileDetector | None = None

    def setup(self, worker: Worker) -> None:
        """Check that this worker fits, and load the detector. Raises PictureError, which names the computer."""
        cv2.setNumThreads(1)
        try:
            if worker.state.nthreads != 1:
                raise PictureError(
                    f"it has {worker.state.nthreads} threads, a detector needs a process of one: "
                    "start it by dask worker --nthreads 1 --nworkers -1"
                )
            self._detector = fitting_detector(self._job)
        except PictureError as error:
            raise PictureError(f"the worker {worker.address} on {socket.gethostname()}: {error}") from error

    def look(self, task: Task) -> str:
        """Look at one window; return as `hawk.picture.orthophoto.steps.map_task`."""
        if self._detector is None:
            raise PictureError("the worker has no detector; start it again")
        return map_task(task, self._job.source, self._detector, Results(self._job.folder))


def look_here(task: Task, mark: str) -> str:
    """Look at one window on the worker that runs this; return as `hawk.picture.orthophoto.steps.map_task`."""
    plugin: Any = get_worker().plugins[f"{_PLUGIN}-{mark}"]
    return str(plugin.look(task))
