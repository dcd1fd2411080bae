from __future__ import annotations

import os
from pathlib import Path

import pytest

from benchmarks.processes import CpuTime, cpu_time, part_of

TICKS = os.sysconf("SC_CLK_TCK")


def process(proc: Path, pid: int, parent: int, command: str, seconds: float) -> None:
    folder = proc / str(pid)
    folder.mkdir()
    fields = ["S", str(parent), *["0"] * 9, str(round(seconds * TICKS)), "0", *["0"] * 20]
    (folder / "stat").write_text(f"{pid} (a name) with) brackets) {' '.join(fields)}\n")
    (folder / "cmdline").write_bytes(command.replace(" ", "\0").encode() + b"\0")


@pytest.fixture
def proc(tmp_path: Path) -> Path:
    (tmp_path / "stat").write_text(f"cpu  {40 * TICKS} 0 {2 * TICKS} {999 * TICKS} 0 0 0 0 0 0\ncpu0 0\n")
    (tmp_path / "self").mkdir()
    process(tmp_path, 1, 0, "init", 3.0)
    process(tmp_path, 10, 1, "python -m benchmarks", 1.0)
    process(tmp_path, 11, 10, "python -m hawk.cli run", 5.0)
    process(tmp_path, 12, 10, "python -m hawk.sim.cli --seed=1", 6.0)
    process(tmp_path, 13, 10, "node driver", 0.5)
    process(tmp_path, 14, 13, "/usr/lib/chromium/chromium --headless", 2.0)
    process(tmp_path, 20, 1, "python -m hawk.cli run", 7.0)
    return tmp_path


def test_processor_time_goes_to_the_part_that_used_it(proc: Path) -> None:
    found = cpu_time(proc, root=10)
    assert found.parts == pytest.approx({"benchmark": 1.5, "daemon": 5.0, "simulator": 6.0, "browser": 2.0})
    assert found.machine == pytest.approx(42.0)


def test_cores_are_seconds_used_by_seconds_passed_and_the_rest_is_of_others() -> None:
    before = CpuTime(100.0, {"daemon": 1.0}, 10.0)
    after = CpuTime(110.0, {"daemon": 6.0, "browser": 2.0}, 20.0)
    assert after.cores_since(before) == pytest.approx({"daemon": 0.5, "browser": 0.2, "others": 0.3})


def test_a_process_that_ends_meanwhile_is_left_out(proc: Path) -> None:
    (proc / "11" / "stat").unlink()
    assert "daemon" not in cpu_time(proc, root=10).parts


@pytest.mark.parametrize(
    ("command", "part"),
    [("python -m hawk.sim.cli", "simulator"), ("python -m hawk.cli survey", "daemon"), ("sleep 1", "benchmark")],
)
def test_a_command_line_names_the_part(command: str, part: str) -> None:
    assert part_of(command) == part


def test_this_very_process_has_used_time() -> None:
    assert cpu_time().parts["benchmark"] > 0
