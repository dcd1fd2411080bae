from __future__ import annotations

import asyncio
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from proving.faults.disk import DiskError, OwnDisk
from proving.faults.second import SecondProcess

WALL_CLOCK = Path(__file__).parents[4] / "proving" / "faults" / "wall_clock"


async def test_a_disk_of_one_s_own_is_filled_and_emptied(tmp_path: Path) -> None:
    disk = OwnDisk(tmp_path / "store")
    try:
        await disk.begin()
    except DiskError as error:
        assert "unshare -Urm" in str(error)  # noqa: PT017
        pytest.skip("no right to mount here")
    try:
        assert disk.takes_a_byte()
        await disk.fill()
        assert not disk.takes_a_byte()
        await disk.empty()
        assert disk.takes_a_byte()
    finally:
        await disk.end()
    assert not (tmp_path / "store" / "filler").exists()


async def test_a_disk_that_cannot_be_mounted_says_what_to_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(DiskError, match="unshare -Urm"):
        await OwnDisk(tmp_path / "store").begin()


async def test_a_second_process_shows_its_status_and_its_words(tmp_path: Path) -> None:
    second = SecondProcess(tmp_path / "log")
    before = second.seen
    assert before is None
    await second.start([sys.executable, "-c", "import sys; print('taken'); sys.exit(2)"])
    async with asyncio.timeout(20):
        await second.wait()
    assert second.seen == (2, "taken\n")
    await second.stop()


@pytest.mark.parametrize("step", [1860.0, -3600.0, None])
def test_a_program_s_wall_clock_is_off_by_what_the_file_says(tmp_path: Path, step: float | None) -> None:
    file = tmp_path / "step"
    if step is not None:
        file.write_text(f"{step}")
    environment = {**os.environ, "PYTHONPATH": str(WALL_CLOCK), "FAULTS_WALL_CLOCK": str(file)}
    command = [sys.executable, "-c", "import time; print(time.time())"]
    said = float(subprocess.run(command, env=environment, check=True, capture_output=True).stdout)
    assert said - time.time() == pytest.approx(step or 0.0, abs=20.0)


async def test_a_disk_that_cannot_be_made_smaller_is_no_full_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def refuses(*_: str) -> int:
        return 32

    monkeypatch.setattr("proving.faults.disk._run", refuses)
    with pytest.raises(DiskError, match="cannot be made smaller"):
        await OwnDisk(tmp_path).fill()
    assert os.listdir(tmp_path) == []
