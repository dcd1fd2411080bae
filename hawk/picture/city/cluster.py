"""Tasks given to the workers of a Dask cluster, on this computer or on many."""

from __future__ import annotations

import contextlib
import logging
import signal
from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from multiprocessing import resource_tracker
from typing import Any, Final

import dask
from distributed import CancelledError, Client, KilledWorker, LocalCluster, Security, as_completed

from hawk.picture.city.job import Job
from hawk.picture.city.scheduler import START, Scheduler
from hawk.picture.city.worker import CityWorker, look_here
from hawk.picture.orthophoto.tile_results import ResultError
from hawk.picture.orthophoto.windows import Task
from hawk.picture.values import PictureError
from hawk.runtime.late import load
from hawk.runtime.programs import remedy

MEMORY: Final = "2GiB"
"""Memory of a worker on this computer; one that needs more is started again, and its window repeated."""
MOST_KILLS: Final = 2
"""Workers that may die at one window before it counts as failed."""
_MALLOC: Final = {"MALLOC_TRIM_THRESHOLD_": 64 << 20, "MALLOC_MMAP_THRESHOLD_": 32 << 20}
"""Bytes: where glibc's own limits come to rest (mallopt(3)). Dask sets 64 kB, and each picture is mapped and cleared
again: a quarter of a worker's time.
"""
_QUIETER: Final = {
    "worker.profile.interval": "100ms",  # 10 ms
    "admin.tick.interval": "500ms",  # 20 ms
    "admin.system-monitor.interval": "2s",  # 500 ms
}
"""Time between two looks of Dask at itself, for tasks of a tenth of a second and more; beside each, Dask's own."""
_NO_PAGES: Final[dict[str, list[str]]] = {"scheduler.http.routes": [], "worker.http.routes": []}
"""Dask always opens a port for its pages; with these it is of the loopback and has none."""
_AHEAD: Final = 8
"""Windows a worker that the scheduler knows of: it is never without one, and never flooded."""
_JOIN_S: Final = 30
_CONNECT_S: Final = 10
_KIND: Final = "window"
_FILES: Final = " --tls-ca-file CA --tls-cert CERTIFICATE --tls-key KEY"
_LOST: Final = "the scheduler was lost; what is done is kept: start it again, and go on by --resume"


@dataclass(frozen=True, slots=True)
class Outcome:
    """One task that has ended. ``reason``: why it failed, "" for one whose result is there."""

    task: Task
    reason: str


@contextlib.contextmanager
def workers_of(scheduler: Scheduler | None, count: int) -> Iterator[Client]:
    """Connect to a scheduler; without one start workers on this computer, a process of one thread each.

    Args:
        scheduler: One of the user's own.
        count: Workers to start where no scheduler is named.

    Raises:
        PictureError: The scheduler does not answer, or has no worker.
    """
    with contextlib.ExitStack() as stack:
        if scheduler is None:
            local = stack.enter_context(_on_this_computer(count))
            place, security = local.scheduler_address, local.security
        else:
            scheduler.check()
            place, security = scheduler.address, scheduler.security()
        try:
            client = stack.enter_context(Client(place, timeout=_CONNECT_S, set_as_default=False, security=security))
        except (OSError, ValueError) as error:
            raise PictureError(f"--scheduler {place}: does not answer ({error}); {START}") from error
        try:
            client.wait_for_workers(1 if scheduler else count, timeout=_JOIN_S)
        except TimeoutError as error:
            raise PictureError(
                f"no worker has joined {'in time' if scheduler is None else place}; start some on each computer: dask "
                f"worker {place} --nthreads 1 --nworkers -1{_FILES if place.startswith('tls') else ''}"
            ) from error
        yield client


@contextlib.contextmanager
def _on_this_computer(count: int) -> Iterator[LocalCluster]:
    """Start workers that nobody else can use: on the loopback, by TLS with keys that this process and they alone have.

    Ctrl-C, which a terminal sends to all processes, is kept from them: they end with the cluster.
    """
    resource_tracker.ensure_running()  # it would unblock the signal
    with contextlib.ExitStack() as stack:
        ours = {f"nanny.pre-spawn-environ.{name}": value for name, value in _MALLOC.items()} | _QUIETER | _NO_PAGES
        stack.enter_context(dask.config.set({f"distributed.{name}": value for name, value in ours.items()}))
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:  # the cluster's thread, and the processes that it starts now and later, inherit the mask
            local = stack.enter_context(
                LocalCluster(
                    n_workers=count,
                    processes=True,
                    threads_per_worker=1,
                    memory_limit=MEMORY,
                    host="127.0.0.1",
                    security=_own_keys(),
                    dashboard_address="127.0.0.1:0",
                    silence_logs=logging.CRITICAL,
                    # a window that needs too much memory would otherwise end worker after worker
                    scheduler_kwargs={"allowed_failures": MOST_KILLS, "dashboard": False},
                )
            )
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
        yield local


def _own_keys() -> Security:
    """Return keys for this run, which stand in no file. Raises PictureError."""
    try:
        load("cryptography")  # Dask's own import names neither extra nor remedy

        made: Security = Security.temporary()
        return made
    except ImportError as error:
        words = f"cryptography is not installed, which makes the workers' keys: {remedy('cluster')}"
        raise PictureError(words) from error


def run_on(client: Client, job: Job, tasks: Sequence[Task]) -> Generator[Outcome]:
    """Yield tasks as they end, in any order.

    Args:
        client: Of `workers_of`.
        job: That of the tasks.
        tasks: To be done.

    Raises:
        PictureError: A worker does not fit the job, the scheduler is lost, or results cannot be written.
    """
    plugin = CityWorker(job)
    is_lost = False
    try:
        client.register_plugin(plugin)
        yield from _ended(client, job, tasks)
    except (ImportError, AttributeError) as error:
        raise PictureError(
            f"a worker cannot load hawk ({error}); install hawk-drone[cluster] of the same version with each worker"
        ) from error
    except (OSError, CancelledError) as error:  # at any step at which the scheduler is asked
        is_lost = True
        raise PictureError(f"{_LOST} ({type(error).__name__})") from error
    finally:  # workers that join later would be refused by a job that has ended
        if not is_lost:
            with contextlib.suppress(OSError, ValueError, KeyError):
                client.unregister_worker_plugin(plugin.name)


def _ended(client: Client, job: Job, tasks: Sequence[Task]) -> Iterator[Outcome]:
    by_name = {task.name: task for task in tasks}
    waiting = iter(by_name.values())
    ahead = max(_AHEAD, 2 * _AHEAD * len(client.scheduler_info(n_workers=-1)["workers"]))

    def begun(count: int) -> list[Any]:
        # of a tuple Dask takes the first word as the kind of work, by which it learns how long it takes
        return [
            client.submit(look_here, task, job.mark, key=(_KIND, task.name), pure=False)
            for task in islice(waiting, count)
        ]

    running = as_completed(begun(ahead), loop=client.loop)
    for future in running:
        yield Outcome(by_name[future.key[1]], _reason(future))
        for following in begun(1):
            running.add(following)


def _reason(future: Any) -> str:
    """Return why a task that has ended failed, "" for a good one.

    Raises:
        ResultError: Results cannot be written.
        CancelledError: The scheduler is lost.
    """
    if future.cancelled():
        raise CancelledError(str(future.key))
    error = future.exception()
    if error is None:
        return str(future.result())
    if isinstance(error, CancelledError | ResultError):
        raise error
    if isinstance(error, KilledWorker):
        return f"{MOST_KILLS + 1} workers died at it: memory may be short; give each worker more, or start fewer"
    return f"{type(error).__name__}: {error}"
