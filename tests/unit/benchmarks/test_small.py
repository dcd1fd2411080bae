"""The small box: control groups of both versions, in a made-up folder of them, and what a flight in it shows."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.figures import BenchmarkError, Figure
from benchmarks.small.__main__ import main, processor
from benchmarks.small.box import Box, make_box, other_cores
from benchmarks.small.lot import HECTARES, DrawnLot
from benchmarks.small.measure import Readings, figures, problem

LOT = DrawnLot(Path("lot.png"), Path("lot.json"), 2.9, 1081)
MIB = 2**20


def first_version(root: Path) -> Path:
    for controller in ("cpuset", "memory"):
        (root / controller).mkdir()
    (root / "cpuset" / "cpuset.mems").write_text("0-1\n")
    return root


def second_version(root: Path) -> Path:
    (root / "cgroup.controllers").write_text("cpuset cpu memory")
    (root / "cgroup.subtree_control").write_text("")
    return root


def test_the_older_groups_have_a_folder_for_each_controller(tmp_path: Path) -> None:
    box = make_box(1, 512 * MIB, first_version(tmp_path))
    cpuset, memory = box.folders
    assert (cpuset / "cpuset.cpus").read_text() == "1"
    assert (cpuset / "cpuset.mems").read_text() == "0-1\n", "without it no process can enter"
    assert (memory / "memory.limit_in_bytes").read_text() == str(512 * MIB)
    assert box.memory == memory


def test_the_newer_groups_have_one_folder(tmp_path: Path) -> None:
    box = make_box(3, MIB, second_version(tmp_path))
    (folder,) = box.folders
    assert (tmp_path / "cgroup.subtree_control").read_text() == "+cpuset +memory"
    assert ((folder / "cpuset.cpus").read_text(), (folder / "memory.max").read_text()) == ("3", str(MIB))


def test_without_control_groups_it_is_said_what_is_needed(tmp_path: Path) -> None:
    with pytest.raises(BenchmarkError, match="run as root"):
        make_box(0, MIB, tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_program_enters_every_folder_before_it_begins(tmp_path: Path) -> None:
    folders = tuple(tmp_path / name for name in ("a b", "c"))
    for folder in folders:
        folder.mkdir()
    command = [*Box(folders, folders[1]).prefix, sys.executable, "-c", "import os, sys; print(os.getpid(), *sys.argv)"]
    said = subprocess.run([*command, "x y"], capture_output=True, text=True, check=True).stdout.split(maxsplit=1)
    assert said[1] == "-c x y\n"
    for folder in folders:
        assert (folder / "cgroup.procs").read_text() == f"{said[0]}\n"


@pytest.mark.parametrize(
    ("text", "found"), [("cache 7\nrss 3\ntotal_rss 5\n", 5), ("anon 9\nfile 4\n", 9)], ids=["older", "newer"]
)
def test_memory_of_the_processes_is_without_files(tmp_path: Path, text: str, found: int) -> None:
    (tmp_path / "memory.stat").write_text(text)
    box = Box((tmp_path,), tmp_path)
    assert box.anonymous_bytes() == found
    assert box.peak_bytes() is None
    (tmp_path / "memory.peak").write_text("11\n")
    assert box.peak_bytes() == 11


def test_memory_that_is_not_counted_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "memory.stat").write_text("file 4\n")
    with pytest.raises(BenchmarkError, match="no anonymous memory"):
        Box((tmp_path,), tmp_path).anonymous_bytes()


def test_removing_ends_what_is_left(tmp_path: Path) -> None:
    folder = tmp_path / "box"
    folder.mkdir()
    child = subprocess.Popen(["sleep", "60"])
    procs = folder / "cgroup.procs"
    procs.write_text(f"{child.pid}\n")
    box = Box((folder,), folder)
    assert box.processes() == [child.pid]

    class Emptied(Box):
        def processes(self) -> list[int]:
            if child.poll() is not None:
                procs.unlink(missing_ok=True)
                return []
            return [child.pid]

    Emptied((folder,), folder).remove()
    assert child.wait(5) == -9
    assert not folder.exists()


def test_simulator_and_daemon_need_a_core_each() -> None:
    assert other_cores(3, [0, 1, 3]) == {0, 1}
    with pytest.raises(BenchmarkError, match="one core"):
        other_cores(0, [0])


def by_key(read: Readings) -> dict[str, Figure]:
    return {figure.key: figure for figure in figures(read, LOT)}


def good() -> Readings:
    return Readings(
        page_s=2.0,
        lags_ms=[8.0, 19.0],
        anonymous=[100 * MIB, 399 * MIB, 380 * MIB],
        peak=600 * MIB,
        vision_fps=[7.0, 4.0],
        camera_fps=15.0,
        late_frames=0.0,
        idle={"jitter_p99_ms": 1.0, "lag_p99_ms": 0.5},
        heartbeats={"rate_hz": 5.0, "jitter_p99_ms": 20.9},
        is_done=True,
    )


@pytest.mark.slow
def test_the_worst_minute_and_the_most_memory_count() -> None:
    found = by_key(good())
    assert all(figure.passed is not False for figure in found.values())
    assert (found["small_lag_p99_ms"].value, found["small_memory_mib"].value) == (19.0, 399.0)
    assert found["small_vision_fps"].value == 4.0
    assert problem(good()) == ""


@pytest.mark.parametrize(
    ("key", "change"),
    [
        ("small_start_s", {"page_s": 3.1}),
        ("small_lag_p99_ms", {"lags_ms": [1.0, 20.1, 1.0]}),
        ("small_lag_p99_ms", {"lags_ms": []}),
        ("small_heartbeat_hz", {"heartbeats": {"rate_hz": 4.8, "jitter_p99_ms": 1.0}}),
        ("small_heartbeat_jitter_p99_ms", {"heartbeats": {"rate_hz": 5.0, "jitter_p99_ms": 21.1}}),
        ("small_memory_mib", {"anonymous": [401 * MIB]}),
        ("small_survey_done", {"is_done": False, "outcome": "late"}),
    ],
)
def test_each_limit_is_missed_alone(key: str, change: dict[str, object]) -> None:
    read = good()
    for name, value in change.items():
        setattr(read, name, value)
    assert [name for name, figure in by_key(read).items() if figure.passed is False] == [key]


def test_a_flight_with_late_pictures_is_void_and_one_that_was_given_up_says_why() -> None:
    late = good()
    late.late_frames = 0.02
    assert "VOID" in problem(late)
    given_up = good()
    given_up.is_done, given_up.outcome = False, "No lot in sight"
    assert problem(given_up) == "the survey was not done: No lot in sight"


def test_the_processor_has_the_kernels_name(tmp_path: Path) -> None:
    file = tmp_path / "cpuinfo"
    file.write_text("processor\t: 0\nmodel name\t: Small CPU @ 1 GHz\n")
    assert processor(file) == "Small CPU @ 1 GHz"
    assert processor(tmp_path / "none") == ""


def test_a_box_that_cannot_be_made_leaves_the_cores_as_they_were(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = os.sched_getaffinity(0)

    def refuse(core: int, memory_bytes: int) -> Box:
        raise BenchmarkError("run as root")

    monkeypatch.setattr("benchmarks.small.__main__.draw_lot", lambda seed, folder: LOT)
    monkeypatch.setattr("benchmarks.small.__main__.make_box", refuse)
    monkeypatch.setattr("benchmarks.small.__main__.other_cores", lambda core, cores: set(cores))
    assert main(["--out", str(tmp_path)]) == 1
    assert "run as root" in capsys.readouterr().err
    assert os.sched_getaffinity(0) == before


def test_three_hectares_are_near_three() -> None:
    assert HECTARES[0] < 3.0 < HECTARES[1]
