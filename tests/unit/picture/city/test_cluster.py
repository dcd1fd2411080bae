"""A city on the workers of Dask."""

from __future__ import annotations

import contextlib
import http.client
import os
import shlex
import socket
import ssl
import subprocess
import sys
import tempfile
import urllib.request
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from distributed import Client, LocalCluster, Security
from distributed.config import config

from hawk.picture.city import cluster
from hawk.picture.city.cluster import run_on
from hawk.picture.city.run import CityWork, map_city
from hawk.picture.city.scheduler import Scheduler
from hawk.picture.orthophoto.tile_results import ResultError, Results
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


@pytest.mark.nightly
def test_a_killed_worker_repeats_its_window_alone_and_changes_no_byte(tmp_path: Path) -> None:
    path = fakes.city(tmp_path)
    work = CityWork(path, out=tmp_path / "alone", model=tmp_path / "model", core_m=CORE_M, load=load_fake)
    alone = map_city(work)
    (tmp_path / LOOKS).unlink()
    kill_once(tmp_path)
    before = set(fakes.spawned())
    steps: list[tuple[int, int]] = []
    run = map_city(replace(work, out=tmp_path / "out", workers=2), lambda *step: steps.append(step))
    assert run.mapped.left_out == ()
    assert looks(tmp_path) == WINDOWS + 1
    by, memory = zip(*(line.split() for line in (tmp_path / LOOKS).read_text().splitlines()), strict=True)
    assert str(os.getpid()) not in by
    assert {int(limit) for limit in memory} == {64 << 20}, "Dask's own limit costs a quarter of a worker's time"
    assert run.mapped.survey == alone.mapped.survey
    files = [sorted((tmp_path / name / "windows").iterdir()) for name in ("alone", "out")]
    assert [each.read_bytes() for each in files[0]] == [each.read_bytes() for each in files[1]]
    assert steps[-1] == (WINDOWS, WINDOWS)
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
        cluster.workers_of(Scheduler("tcp://127.0.0.1:9"), 1),
    ):
        pass
    with (
        LocalCluster(n_workers=0, processes=False, dashboard_address="127.0.0.1:0", protocol="tcp") as local,
        pytest.raises(PictureError, match=r"no worker has joined tcp://.*dask worker tcp://"),
        cluster.workers_of(Scheduler(local.scheduler_address), 1),
    ):
        pass


def sockets_of(pids: Iterable[int]) -> list[tuple[str, int]]:
    """Return the addresses (IPv4) on which processes listen, by proc_pid_net(5)."""
    inodes = set()
    for pid in pids:
        for entry in Path(f"/proc/{pid}/fd").iterdir():
            with contextlib.suppress(OSError):
                inodes.add(os.readlink(entry))
    found = []
    for line in Path("/proc/net/tcp").read_text().splitlines()[1:]:
        _, local, _, state, *_, inode = line.split()[:10]
        if state == "0A" and f"socket:[{inode}]" in inodes:
            host, port = local.split(":")
            found.append((socket.inet_ntoa(bytes.fromhex(host)[::-1]), int(port, 16)))
    assert not [
        line for line in Path("/proc/net/tcp6").read_text().splitlines()[1:] if f"socket:[{line.split()[9]}]" in inodes
    ]
    return found


def is_closed_to_strangers(port: int) -> bool:
    """Return True when neither a client without TLS, without a certificate, nor with one of its own is answered."""
    nobody = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    nobody.check_hostname, nobody.verify_mode = False, ssl.CERT_NONE
    other = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    other.check_hostname, other.verify_mode = False, ssl.CERT_NONE
    keys = Security.temporary()
    with tempfile.NamedTemporaryFile("w", suffix=".pem") as file:
        file.write(f"{keys.tls_client_key}\n{keys.tls_client_cert}")
        file.flush()
        other.load_cert_chain(file.name)
    said = []
    for context in (None, nobody, other):
        with socket.create_connection(("127.0.0.1", port), timeout=10) as plain:
            try:
                with contextlib.nullcontext(plain) if context is None else context.wrap_socket(plain) as line:
                    line.sendall(b"GET / HTTP/1.1\r\n\r\n")
                    said.append(line.recv(100))
            except (ssl.SSLError, ConnectionError):
                said.append(b"")
    return all(not each or each.startswith(b"\x15") for each in said)  # an alert of TLS


def test_workers_on_this_computer_are_used_by_this_run_alone() -> None:
    before, others = set(sockets_of([os.getpid()])), set(fakes.spawned())
    with cluster.workers_of(None, 1) as client:
        assert client.submit(sum, (1, 2)).result(timeout=30) == 3
        workers = set(fakes.spawned()) - others
        assert workers
        listened = set(sockets_of([os.getpid(), *workers])) - before
        assert listened, "they were looked at"
        assert {host for host, _ in listened} == {"127.0.0.1"}
        address = client.scheduler_info()["address"]
        assert address.startswith("tls://")
        assert is_closed_to_strangers(int(address.rpartition(":")[2]))
        for host, port in listened:
            for path in ("status", "health", "info/main/workers.html", "json/identity.json", "metrics"):
                with pytest.raises((OSError, http.client.HTTPException)):
                    urllib.request.urlopen(f"http://{host}:{port}/{path}", timeout=2)
        assert client.submit(sum, (1, 2)).result(timeout=30) == 3, "and it works on"


@pytest.fixture
def files(tmp_path: Path) -> dict[str, Path]:
    """Keys of a cluster in files, as `openssl` writes them."""
    keys = Security.temporary()
    found = {}
    for name, text in (("ca_file", keys.tls_ca_file), ("cert", keys.tls_client_cert), ("key", keys.tls_client_key)):
        found[name] = tmp_path / f"{name}.pem"
        found[name].write_text(str(text))
    return found


def test_a_scheduler_with_tls_is_used_by_those_who_have_its_keys(tmp_path: Path, files: dict[str, Path]) -> None:
    keys = Security(
        require_encryption=True,
        tls_ca_file=str(files["ca_file"]),
        **{
            f"tls_{role}_{kind}": str(files[kind])
            for role in ("scheduler", "worker", "client")
            for kind in ("cert", "key")
        },
    )
    with LocalCluster(
        n_workers=1,
        threads_per_worker=1,
        processes=False,
        dashboard_address="127.0.0.1:0",
        protocol="tls",
        security=keys,
    ) as local:
        path = fakes.city(tmp_path)
        scheduler = Scheduler(local.scheduler_address, **files)
        run = map_city(
            CityWork(
                path, out=tmp_path / "out", model=tmp_path / "model", core_m=CORE_M, load=load_fake,
                scheduler=scheduler,
            )
        )  # fmt: skip
    assert looks(tmp_path) == run.windows == WINDOWS


def test_the_documented_scheduler_opens_its_own_port_alone_and_asks_for_a_certificate(
    tmp_path: Path, unused_tcp_port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "_JOIN_S", 0.2)
    text = (Path(__file__).parents[4] / "docs/how-to/count-a-city.md").read_text()
    lines = [line.strip() for line in text.splitlines() if line.startswith("    ")]
    made, started = (
        next(line for line in lines if line.startswith(word)) for word in ("openssl req", "dask scheduler")
    )
    subprocess.run(shlex.split(made), cwd=tmp_path, check=True, capture_output=True)
    command = [*shlex.split(started.replace("10.0.0.1", "127.0.0.1")), "--port", str(unused_tcp_port)]
    command[0] = str(Path(sys.executable).with_name("dask"))
    running = subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True)
    address = f"tls://127.0.0.1:{unused_tcp_port}"
    try:
        assert running.stderr is not None
        assert any(address in line for line in running.stderr), "it started"
        assert {host for host, _ in sockets_of([running.pid])} == {"127.0.0.1"}
        with (
            pytest.raises(PictureError, match="no worker has joined"),
            cluster.workers_of(
                Scheduler(address, *(tmp_path / name for name in ("city.pem", "city.pem", "city-key.pem"))), 1
            ),
        ):
            pass
        assert is_closed_to_strangers(unused_tcp_port)
    finally:
        running.terminate()
        running.communicate(timeout=30)


def test_a_scheduler_that_others_can_use_is_refused(tmp_path: Path, files: dict[str, Path]) -> None:
    path = fakes.city(tmp_path)
    wrong = tmp_path / "wrong.pem"
    wrong.write_text("no PEM")
    for scheduler, words in (
        (Scheduler("tcp://10.0.0.1:8786"), r"--scheduler tcp://10.0.0.1:8786: everybody.*--tls-cert.*--no-dashboard"),
        (Scheduler("tcp://drone.local:8786"), "everybody on that network"),
        (Scheduler("tcp://[2001:db8::1]:8786"), "everybody on that network"),
        (Scheduler("tls://10.0.0.1:8786"), "--tls-ca-file is missing"),
        (Scheduler("tls://10.0.0.1:8786", files["ca_file"], files["cert"]), "--tls-key is missing"),
        (Scheduler("tls://10.0.0.1:8786", files["ca_file"], files["cert"], wrong), "--tls-key: cannot be used"),
        (
            Scheduler("tcp://127.0.0.1:8786", files["ca_file"]),
            "--tls-ca-file: only together with a scheduler at tls://",
        ),
    ):
        with pytest.raises(PictureError, match=words):
            map_city(
                CityWork(path, out=tmp_path / "out", model=tmp_path / "model", load=load_fake, scheduler=scheduler)
            )
        assert not (tmp_path / "out").exists()
