"""The newcomer's commands in a made-up root: a folder of this machine in place of a Debian root."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from benchmarks.figures import BenchmarkError, Figure
from proving import newcomer
from proving.bare_root import BareRoot, end
from proving.newcomer import from_package, from_sources, newest_package, see_page

SERVER = """
import http.server, socketserver
class Page(http.server.BaseHTTPRequestHandler):
    def do_GET(self):
        self.send_response(200); self.end_headers()
with socketserver.TCPServer(("127.0.0.1", 0), Page) as server:
    print(f"hawk: open http://127.0.0.1:{server.server_address[1]}/  (SIMULATION)", flush=True)
    server.serve_forever()
"""


@dataclass(frozen=True, slots=True)
class Folder(BareRoot):
    """A folder of this machine that lines run in, with programs of its own first. Each line is a group of processes."""

    started: list[subprocess.Popen[bytes]] = field(default_factory=list)

    def start(self, line: str, within: str, log: Path) -> subprocess.Popen[bytes]:
        place = self.folder / within.lstrip("/")
        path = {**os.environ, "PATH": f"{self.folder / 'bin'}:{os.environ['PATH']}"}
        with log.open("ab") as out:
            process = subprocess.Popen(
                ["sh", "-c", line], cwd=place, env=path, stdout=out, stderr=subprocess.STDOUT, start_new_session=True
            )
        self.started.append(process)
        return process


@pytest.fixture
def root(tmp_path: Path) -> Iterator[Folder]:
    """A folder with apt-get, make and hawk-drone that do their part at once."""
    folder = tmp_path / "debian"
    sources = folder / "root" / "hawk"
    (sources / ".venv" / "bin").mkdir(parents=True)
    (folder / "bin").mkdir()
    serve = f"exec {sys.executable} -c '{SERVER}'"
    survey = """mkdir -p survey-1 && echo '{"stall_f1": 0.97}' > survey-1/report.json"""
    write_program(folder / "bin" / "apt-get", "echo apt-get $*")
    write_program(folder / "bin" / "make", serve)
    write_program(folder / "bin" / "hawk-drone", f'case "$1" in survey) {survey} ;; *) {serve} ;; esac')
    write_program(sources / ".venv" / "bin" / "hawk-drone", survey)
    made = Folder(folder)
    yield made
    for process in made.started:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)


def write_program(path: Path, text: str) -> None:
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)


def by_key(figures: list[Figure]) -> dict[str, Figure]:
    return {figure.key: figure for figure in figures}


def test_the_sources_are_set_up_seen_and_flown(root: Folder, tmp_path: Path) -> None:
    log = tmp_path / "log"
    found = by_key(from_sources(root, log, seed=1))
    assert "apt-get install -qq python3 make" in log.read_text()
    steps = [found[f"sources_{step}_s"].value or 0.0 for step in ("needs", "page", "survey")]
    assert all(step > 0 for step in steps)
    assert found["sources_s"].value == pytest.approx(sum(steps))
    assert found["sources_s"].passed is True
    assert (found["sources_f1"].value, found["sources_f1"].passed) == (0.97, True)


def test_the_package_is_installed_seen_and_flown(root: Folder, tmp_path: Path) -> None:
    log = tmp_path / "log"
    found = by_key(from_package(root, "hawk-drone_1_amd64.deb", log, seed=1))
    assert "apt-get install -qq ./hawk-drone_1_amd64.deb" in log.read_text()
    assert set(found) == {"package_install_s", "package_page_s", "package_survey_s", "package_f1", "package_s"}


def test_a_poor_survey_misses_its_limit(root: Folder, tmp_path: Path) -> None:
    poor = """mkdir survey-1 && echo '{"stall_f1": 0.5}' > survey-1/report.json"""
    write_program(root.folder / "root" / "hawk" / ".venv" / "bin" / "hawk-drone", poor)
    assert by_key(from_sources(root, tmp_path / "log", seed=1))["sources_f1"].passed is False


def test_a_line_that_fails_is_named_with_its_last_words(root: Folder, tmp_path: Path) -> None:
    with pytest.raises(BenchmarkError, match=r"exit 3: status 3\nno such package"):
        root.run("echo no such package; exit 3", "/root", tmp_path / "log", 60)


def test_a_line_that_does_not_end_is_ended(root: Folder, tmp_path: Path) -> None:
    with pytest.raises(BenchmarkError, match="no end within 0 s"):
        root.run("exec sleep 60", "/root", tmp_path / "log", 0.05)


def test_a_daemon_that_ends_before_its_page_is_named(root: Folder, tmp_path: Path) -> None:
    with pytest.raises(BenchmarkError, match="no page\nthe port is in use"):
        see_page(root, "echo the port is in use; exit 2", "/root", tmp_path / "log")


def test_an_address_of_an_earlier_step_is_not_taken_for_the_page(root: Folder, tmp_path: Path) -> None:
    log = tmp_path / "log"
    log.write_text("hawk: open http://127.0.0.1:1/\n")
    see_page(root, "make run", "/root", log)


def made_by(program: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Put a made-up mmdebstrap first on the path; this is root."""
    write_program(tmp_path / "mmdebstrap", program)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    monkeypatch.setattr(os, "geteuid", lambda: 0)


def test_the_root_gets_the_network_of_this_machine(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    made_by('eval "root=\\${$(($# - 1))}"; mkdir -p "$root/etc" "$root/root"', monkeypatch, tmp_path)
    certificates = tmp_path / "ours.crt"
    certificates.write_text("certificate")
    ours = {"PIP_CERT": str(certificates), "https_proxy": "http://proxy:1", "SECRET": "x"}
    root = BareRoot.make(tmp_path / "debian", ours=ours)
    assert root.environment["https_proxy"] == "http://proxy:1"
    assert (root.folder / root.environment["PIP_CERT"].lstrip("/")).read_text() == "certificate"
    assert (root.folder / "etc" / "hosts").read_bytes() == Path("/etc/hosts").read_bytes()
    assert "SECRET" not in root.environment


def test_mmdebstraps_own_words_are_given(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    made_by("echo E: no mirror >&2; exit 1", monkeypatch, tmp_path)
    with pytest.raises(BenchmarkError, match="mmdebstrap: E: no mirror"):
        BareRoot.make(tmp_path / "debian")


def test_without_root_or_mmdebstrap_it_is_said_what_is_needed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    with pytest.raises(BenchmarkError, match="run it as root"):
        BareRoot.make(tmp_path / "debian")
    monkeypatch.setattr(os, "geteuid", lambda: 0)
    monkeypatch.setattr("shutil.which", lambda _: None)
    with pytest.raises(BenchmarkError, match="apt-get install mmdebstrap"):
        BareRoot.make(tmp_path / "debian")


def test_the_newest_package_is_tried(tmp_path: Path) -> None:
    assert newest_package(tmp_path) is None
    for age, name in enumerate(
        (
            "hawk-drone_4+deb13_amd64.deb",
            "hawk-drone_2+deb12_amd64.deb",
            "hawk-drone_1+deb12_amd64.deb",
            "hawk-drone_3+deb12_arm64.deb",
        )
    ):
        (tmp_path / name).touch()
        os.utime(tmp_path / name, (100 - age, 100 - age))
    assert newest_package(tmp_path) == tmp_path / "hawk-drone_2+deb12_amd64.deb"


def test_a_failed_step_gives_status_1(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    assert newcomer.main([]) == newcomer.EXIT_FAILED
    assert "newcomer: a bare Debian root needs root" in capsys.readouterr().err


@pytest.mark.slow
def test_the_clone_is_of_this_commit(tmp_path: Path) -> None:
    (tmp_path / "root").mkdir()
    newcomer.fetch_sources(BareRoot(tmp_path))
    assert (tmp_path / "root" / "hawk" / "Makefile").exists()


def test_an_end_is_asked_for_once(root: Folder, tmp_path: Path) -> None:
    process = root.start("exec sleep 60", "/root", tmp_path / "log")
    end(process)
    assert process.returncode == -9
    end(process)
