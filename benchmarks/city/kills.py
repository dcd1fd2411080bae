"""A worker and then the scheduler killed with -9 while a city is mapped."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from benchmarks.city.eyes import LOOKS
from benchmarks.city.runs import Run, finished, started
from benchmarks.figures import BenchmarkError

_START_S: Final = 60.0
_LOST: Final = "the scheduler was lost"
_RUN_S: Final = 600.0
_LOOK_S: Final = 0.05


@dataclass(frozen=True, slots=True)
class Killed:
    """Looks that were repeated after a worker was killed, and after the scheduler was; the last run of each."""

    by_worker: int
    by_scheduler: int
    after_worker: Run
    after_scheduler: Run
    said: str
    """The client's line when the scheduler was killed."""


class Cluster:
    """A scheduler and its workers, each a process that can be killed."""

    def __init__(self, folder: Path, environment: dict[str, str]) -> None:
        """``folder``: of their logs."""
        self._folder = folder
        self._environment = environment
        self._file = folder / f"scheduler-{time.monotonic_ns()}.json"
        ports = ["--host", "127.0.0.1", "--port", "0", "--dashboard-address", "127.0.0.1:0"]
        self.scheduler = self._start("scheduler", *ports, "--scheduler-file", str(self._file))
        self.workers: list[subprocess.Popen[bytes]] = []
        self._await(self._file.exists, "the scheduler did not start")

    @property
    def address(self) -> str:
        """Address of the scheduler."""
        return str(json.loads(self._file.read_text())["address"])

    def add_worker(self) -> None:
        """Start a worker that is not started again when it dies."""
        options = ["--nthreads", "1", "--no-nanny", "--no-dashboard", "--death-timeout", "30"]
        self.workers.append(self._start("worker", self.address, *options))

    def end(self) -> None:
        """Kill everything that still runs."""
        for process in (*self.workers, self.scheduler):
            process.kill()
            process.wait()

    def _start(self, kind: str, *options: str) -> subprocess.Popen[bytes]:
        with (self._folder / f"{kind}.log").open("ab") as log:
            return subprocess.Popen(
                [sys.executable, "-m", "distributed.cli.dask_" + kind, *options],
                stdout=log, stderr=log, env=self._environment,
            )  # fmt: skip

    @staticmethod
    def _await(is_there: Callable[[], bool], problem: str) -> None:
        until = time.monotonic() + _START_S
        while not is_there():
            if time.monotonic() > until:
                raise BenchmarkError(problem)
            time.sleep(_LOOK_S)


def kill_both(picture: Path, core_m: float, folder: Path, windows: int) -> Killed:
    """Map a picture twice: once a worker is killed, once the scheduler. Raises BenchmarkError.

    Args:
        picture: The mosaic.
        core_m: Side of its windows, metres.
        folder: For results and logs.
        windows: Of the mosaic.
    """
    looks = folder / "looks-worker"
    with _cluster(folder, looks) as cluster:
        run = started(picture, folder / "worker-killed", core_m, scheduler=cluster.address)
        _await_looks(looks, windows // 5, run)
        _kill(cluster.workers[0])
        cluster.add_worker()
        first = finished(run)
    by_worker = _count(looks) - windows
    looks = folder / "looks-scheduler"
    with _cluster(folder, looks) as cluster:
        run = started(picture, folder / "scheduler-killed", core_m, scheduler=cluster.address)
        _await_looks(looks, windows // 2, run)
        _kill(cluster.scheduler)
        _, said = run.communicate(timeout=_RUN_S)
        lost = [line for line in said.splitlines() if _LOST in line]
        if run.returncode != 1 or not lost:
            raise BenchmarkError(
                f"the client ended with {run.returncode} after its scheduler was killed: {said[-400:]}"
            )
    with _cluster(folder, looks) as cluster:
        second = finished(started(picture, folder / "scheduler-killed", core_m, scheduler=cluster.address))
    return Killed(by_worker, _count(looks) - windows, first, second, lost[0])


@contextlib.contextmanager
def _cluster(folder: Path, looks: Path) -> Iterator[Cluster]:
    cluster = Cluster(folder, {**os.environ, LOOKS: str(looks), "OMP_NUM_THREADS": "1"})
    try:
        cluster.add_worker()
        cluster.add_worker()
        yield cluster
    finally:
        cluster.end()


def _await_looks(looks: Path, count: int, run: subprocess.Popen[str]) -> None:
    until = time.monotonic() + _RUN_S
    while _count(looks) < count:
        if run.poll() is not None or time.monotonic() > until:
            raise BenchmarkError(f"the run ended before {count} windows were looked at: {run.communicate()[1][-400:]}")
        time.sleep(_LOOK_S)


def _count(looks: Path) -> int:
    return len(looks.read_text().splitlines()) if looks.exists() else 0


def _kill(process: subprocess.Popen[bytes]) -> None:
    process.send_signal(signal.SIGKILL)
    process.wait()
