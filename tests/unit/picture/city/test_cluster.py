"""A city on the workers of Dask."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from distributed import Client, LocalCluster
from distributed.config import config

from hawk.picture.city import cluster
from hawk.picture.city.cluster import run_on
from hawk.picture.city.results import ResultError, Results
from hawk.picture.city.run import CityProgress, map_city
from hawk.picture.values import PictureError
from tests.unit.picture.city import fakes
from tests.unit.picture.city.fakes import CORE_M, LOOKS, WINDOWS, job_of, kill_once, load_fake, looks, windows

pytestmark = pytest.mark.slow


@pytest.fixture
def client() -> Iterator[Client]:
    """Two workers of one thread each in this process."""
    with (
        LocalCluster(n_workers=2, threads_per_worker=1, processes=False, dashboard_address="127.0.0.1:0") as local,
        Client(local, set_as_default=False) as made,
    ):
        yield made


def test_a_killed_worker_repeats_its_window_alone_and_changes_no_byte(tmp_path: Path) -> None:
    path = fakes.city(tmp_path)
    alone = map_city(path, out=tmp_path / "alone", model=tmp_path / "model", core_m=CORE_M, load=load_fake)
    (tmp_path / LOOKS).unlink()
    kill_once(tmp_path)
    before = set(fakes.spawned())
    steps: list[CityProgress] = []
    run = map_city(
        path, out=tmp_path / "out", model=tmp_path / "model", core_m=CORE_M, load=load_fake, workers=2,
        progress=steps.append,
    )  # fmt: skip
    assert run.mapped.left_out == ()
    assert looks(tmp_path) == WINDOWS + 1
    by, memory = zip(*(line.split() for line in (tmp_path / LOOKS).read_text().splitlines()), strict=True)
    assert str(os.getpid()) not in by
    assert {int(limit) for limit in memory} == {64 << 20}, "Dask's own limit costs a quarter of a worker's time"
    assert run.mapped.survey == alone.mapped.survey
    files = [sorted((tmp_path / name / "windows").iterdir()) for name in ("alone", "out")]
    assert [each.read_bytes() for each in files[0]] == [each.read_bytes() for each in files[1]]
    assert steps[-1].dashboard.startswith("http://127.0.0.1:")
    assert (steps[-1].done, steps[-1].failed) == (WINDOWS, 0)
    assert set(fakes.spawned()) <= before


def test_windows_end_on_workers_and_failures_are_named(tmp_path: Path, client: Client) -> None:
    source, tasks = windows(tmp_path)
    job = job_of(tmp_path, source)
    fakes.break_bright(tmp_path)
    ended = {outcome.task: outcome.reason for outcome in run_on(client, job, tasks)}
    assert set(ended) == set(tasks)
    failed = [task for task in tasks if ended[task]]
    assert {ended[task] for task in failed} == {"it is too bright"}
    assert [task for task in tasks if Results(job.folder).find(task) is None] == failed


def test_a_worker_that_does_not_fit_gets_no_window(tmp_path: Path, client: Client) -> None:
    source, tasks = windows(tmp_path)
    job = job_of(tmp_path, source)
    with pytest.raises(PictureError, match=r"the worker inproc://.* on .*: does not see the folder"):
        list(run_on(client, replace(job, mark=".run-2"), tasks))
    assert looks(tmp_path) == 0
    local: Any = client.cluster
    assert [name for name in local.scheduler.worker_plugins if "hawk" in name] == []
    assert len(list(run_on(client, job, tasks))) == WINDOWS


def test_a_full_disk_ends_the_run(tmp_path: Path, client: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    source, tasks = windows(tmp_path)

    def full(path: Path, data: bytes) -> None:
        raise ResultError(path, OSError(28, "No space left on device"))

    monkeypatch.setattr(Results, "_write", lambda self, path, data: full(path, data))
    with pytest.raises(ResultError, match=r"No space left on device.*--resume"):
        list(run_on(client, job_of(tmp_path, source), tasks))


def test_a_lost_scheduler_ends_the_run_with_the_remedy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(config["distributed"]["comm"]["timeouts"], "connect", "500ms")
    source, tasks = windows(tmp_path)
    with (
        LocalCluster(n_workers=1, threads_per_worker=1, processes=False, dashboard_address="127.0.0.1:0") as local,
        Client(local, set_as_default=False) as client,
    ):
        outcomes = run_on(client, job_of(tmp_path, source), tasks)
        next(outcomes)
        client.sync(local.scheduler.close)
        with pytest.raises(PictureError, match="the scheduler was lost"):
            list(outcomes)


def test_a_scheduler_that_does_not_answer_and_one_without_workers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "_CONNECT_S", 1)
    monkeypatch.setattr(cluster, "_JOIN_S", 0.2)
    with (
        pytest.raises(PictureError, match=r"--scheduler tcp://127.0.0.1:9: does not answer.*dask scheduler"),
        cluster.workers_of("tcp://127.0.0.1:9", 1),
    ):
        pass
    with (
        LocalCluster(n_workers=0, processes=False, dashboard_address="127.0.0.1:0", protocol="tcp") as local,
        pytest.raises(PictureError, match=r"no worker has joined tcp://.*dask worker tcp://"),
        cluster.workers_of(local.scheduler_address, 1),
    ):
        pass
