from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import AsyncIterator, Callable
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import IO, Any

import pytest
from mcap.reader import make_reader

from hawk.algo.frame import FrameInput
from hawk.config.sections import StoreSettings
from hawk.model.operation import StateName
from hawk.model.poses import MapPoint
from hawk.store.frame_codec import FRAME_INPUT
from hawk.store.recording import NoRecordingError, Recording
from hawk.store.replay import RecordingError, read_frames, read_metadata, read_recording
from tests.manual_clock import ManualClock
from tests.unit.comm.waiting import until
from tests.unit.store.test_frame_codec import FRAME

Make = Callable[..., Recording]
START = datetime(2026, 5, 1, 12, 0, 0, tzinfo=UTC)


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock(10.0)


@pytest.fixture
async def make(tmp_path: Path, clock: ManualClock) -> AsyncIterator[Make]:
    made: list[Recording] = []

    def make_it(record: bool = True, minimum_free_mb: int = 1, **options: Any) -> Recording:
        settings = StoreSettings(directory=tmp_path, record=record, minimum_free_mb=minimum_free_mb)
        options.setdefault("utc", lambda: START)
        options.setdefault("retry_s", 0.05)
        made.append(Recording(settings, clock, {"seed": "5", "version": "0.1.0", "config": "{}"}, **options))
        return made[-1]

    yield make_it
    for recording in made:
        await recording.close()


def written(recording: Recording) -> Path:
    assert recording.path is not None
    return recording.path


async def test_inputs_decisions_and_frames_come_back_in_order(make: Make, clock: ManualClock) -> None:
    recording = make()
    recording.begin()
    recording.record("tick", {"state": StateName.HOVER, "pose": MapPoint(1.0, 2.0)})
    clock.advance(0.125)
    recording.record_frame(FRAME)
    recording.record("request", {"name": "arm"})
    await recording.close()
    found = list(read_recording(written(recording)))
    assert [(one.topic, one.time) for one in found] == [
        ("tick", 10.0),
        ("camera_calibration", 10.125),
        ("camera", 10.125),
        (FRAME_INPUT, 10.125),
        ("request", 10.125),
    ]
    assert found[0].payload() == {"state": "Hover", "pose": {"north": 1.0, "east": 2.0}}
    assert found[3].frame(FrameInput) == FRAME
    with pytest.raises(RecordingError, match="not JSON"):
        found[3].payload()


async def test_frames_alone_can_be_read_for_a_replay(make: Make) -> None:
    recording = make()
    frames = [replace(FRAME, sequence=number, captured=number / 7) for number in range(20)]
    recording.begin()
    for frame in frames:
        recording.record("tick", {"n": frame.sequence})
        recording.record_frame(frame)
    await recording.close()
    assert list(read_frames(written(recording), FrameInput)) == frames


async def test_seed_configuration_and_version_are_in_every_file(make: Make) -> None:
    recording = make()
    recording.begin()
    await until(lambda: recording.recording)
    await recording.close()
    metadata = read_metadata(written(recording))
    epoch_ns = str(int(START.timestamp() - 10) * 1_000_000_000)
    times = {"utc": START.isoformat(), "clock": "10.0", "epoch_ns": epoch_ns}
    assert metadata == {"seed": "5", "version": "0.1.0", "config": "{}", "format": "2", **times}
    assert written(recording).name == "20260501T120000Z.mcap"


async def test_it_is_a_file_for_the_fields_own_tools(make: Make) -> None:
    recording = make()
    recording.begin()
    recording.record("tick", {"n": 1})
    await recording.close()
    with written(recording).open("rb") as stream:
        reader = make_reader(stream)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == 1
        assert [channel.topic for channel in summary.channels.values()] == ["tick"]


async def test_an_end_that_comes_while_it_writes_finishes_the_file(make: Make) -> None:
    def opener(path: Path) -> IO[bytes]:
        recording.end()
        return path.open("xb")

    recording = make(opener=opener)
    recording.begin()
    await until(lambda: recording.path is not None)
    await until(lambda: not recording.recording)


async def test_a_recording_begins_with_the_last_minute_and_ends_with_its_end(make: Make, clock: ManualClock) -> None:
    recording = make()
    recording.record("memory", {"n": 0})
    recording.record("tick", {"n": 1})
    clock.advance(60.0)
    recording.record("memory", {"n": 2})
    recording.record_frame(FRAME)
    recording.record("tick", {"n": 3})
    clock.advance(60.0)
    recording.record("tick", {"n": 4})  # the memory of a minute ago is the entry now
    recording.begin()
    recording.record("tick", {"n": 5})
    recording.end()
    recording.record("tick", {"n": 6})
    await recording.close()
    found = [one for one in read_recording(written(recording)) if not one.topic.startswith("camera")]
    assert [one.topic for one in found] == ["memory", FRAME_INPUT, "tick", "tick", "tick"]
    assert [one.payload()["n"] for one in found if one.topic != FRAME_INPUT] == [2, 3, 4, 5]
    assert [one.time for one in found] == [70.0, 70.0, 70.0, 130.0, 130.0]
    assert recording.dropped == 0


async def test_it_asks_for_a_memory_until_it_has_one_and_after_each_end(make: Make) -> None:
    recording = make()
    assert recording.wants_memory()
    recording.record("memory", {})
    assert not recording.wants_memory()
    recording.begin()
    assert not recording.wants_memory()  # it is in the file
    await until(lambda: recording.recording)
    recording.end()
    assert recording.wants_memory()


async def test_it_asks_for_a_memory_after_lost_messages(make: Make) -> None:
    release = threading.Event()

    def slow(path: Path) -> IO[bytes]:
        release.wait(10)
        return path.open("xb")

    recording = make(opener=slow, queue_bytes=30_000)
    recording.begin()
    recording.record("memory", {})
    assert not recording.wants_memory()
    for _ in range(100):
        recording.record("tick", {})
    assert recording.dropped
    assert recording.wants_memory()
    release.set()
    await until(lambda: not recording.waiting)
    recording.record("memory", {})
    assert not recording.wants_memory()


async def test_switched_off_it_asks_for_nothing(make: Make) -> None:
    assert not make(record=False).wants_memory()


async def test_every_flight_has_a_file_of_its_own(make: Make, tmp_path: Path) -> None:
    recording = make()
    for number in range(3):
        recording.begin()
        recording.record("tick", {"n": number})
        await until(lambda: recording.recording)
        recording.end()
        await until(lambda: not recording.recording)
    names = sorted(path.name for path in (tmp_path / "recordings").iterdir())
    assert names == ["20260501T120000Z-2.mcap", "20260501T120000Z-3.mcap", "20260501T120000Z.mcap"]


async def test_switched_off_it_writes_nothing_and_is_healthy(make: Make, tmp_path: Path) -> None:
    recording = make(record=False)
    recording.begin()
    recording.record("tick", {"n": 1})
    recording.record_frame(FRAME)
    await recording.close()
    assert not (tmp_path / "recordings").exists()
    assert recording.health.is_healthy
    assert recording.path is None


async def test_a_full_queue_drops_counts_and_reports_but_never_waits(make: Make, clock: ManualClock) -> None:
    release = threading.Event()

    def slow(path: Path) -> IO[bytes]:
        release.wait(10)
        return path.open("xb")

    recording = make(opener=slow, queue_bytes=30_000)
    recording.begin()
    before = time.perf_counter()
    for _ in range(1000):
        recording.record("tick", {"n": 1})
    assert time.perf_counter() - before < 9.0, "it waited for the disk"
    assert 900 < recording.dropped < 1000
    assert f"{recording.dropped} messages are missing" in recording.health.reason
    release.set()
    clock.advance(11.0)
    assert recording.health.is_healthy  # it keeps up again; the count stays


async def test_too_little_free_disk_stops_it_with_the_reason_and_room_lets_it_go_on(make: Make) -> None:
    free = [2_000_000]
    recording = make(free_bytes=lambda _: free[0], minimum_free_mb=500)
    recording.begin()
    await until(lambda: not recording.health.is_healthy)
    assert "2 MB are free, store.minimum_free_mb is 500" in recording.health.reason
    assert not recording.recording
    recording.record("tick", {"n": 1})
    free[0] = 900_000_000
    await until(lambda: recording.recording)
    assert recording.health.is_healthy
    recording.record("tick", {"n": 2})
    await recording.close()
    assert [one.payload()["n"] for one in read_recording(written(recording))][-1] == 2


async def test_a_full_disk_is_freed_on_the_ground_from_the_oldest_recording_on(make: Make, tmp_path: Path) -> None:
    folder = tmp_path / "recordings"
    folder.mkdir()
    for day in (1, 2, 3):
        (folder / f"2026040{day}T120000Z.mcap").write_bytes(bytes(1_000_000))
    (folder / "20260401T120000Z.keep").touch()

    def free(path: Path) -> int:
        return 3_000_000 - sum(file.stat().st_size for file in path.iterdir())

    recording = make(free_bytes=free, minimum_free_mb=1)
    recording.end()  # the motors are known to be off
    await until(lambda: len(list(folder.iterdir())) == 2)
    assert sorted(path.name for path in folder.iterdir()) == ["20260401T120000Z.keep", "20260401T120000Z.mcap"]
    assert recording.health.is_healthy


async def test_a_full_disk_stops_a_recording_and_names_what_fills_it_where_nothing_may_go(
    make: Make, tmp_path: Path
) -> None:
    folder = tmp_path / "recordings"
    folder.mkdir()
    (folder / "20260401T120000Z.mcap").write_bytes(bytes(3_000_000))
    (folder / "20260401T120000Z.keep").touch()
    recording = make(free_bytes=lambda _: 2_000_000, minimum_free_mb=500)
    recording.end()
    await until(lambda: not recording.health.is_healthy)
    assert recording.health.reason.startswith(
        "Recording stopped: 2 MB are free, store.minimum_free_mb is 500. Recordings take 3 MB, 3 MB of them are kept; "
        "other files fill the rest: delete some"
    )


async def test_nothing_is_removed_in_flight_nor_before_the_motors_are_known_to_be_off(
    make: Make, tmp_path: Path
) -> None:
    folder = tmp_path / "recordings"
    folder.mkdir()
    old = folder / "20260401T120000Z.mcap"
    old.write_bytes(bytes(3_000_000))
    recording = make(free_bytes=lambda _: 2_000_000, minimum_free_mb=500)
    recording.begin()
    await until(lambda: not recording.health.is_healthy)
    assert old.exists()
    recording.end()
    await until(lambda: not old.exists())


async def test_a_disk_that_fills_while_it_is_written_loses_messages_and_says_so(make: Make) -> None:
    full = threading.Event()

    class Filling:
        def __init__(self, path: Path) -> None:
            self._file = path.open("xb")

        def write(self, data: bytes) -> int:
            if full.is_set():
                raise OSError(errno.ENOSPC, "No space left on device")
            return self._file.write(data)

        def flush(self) -> None:
            self._file.flush()

        def tell(self) -> int:
            return self._file.tell()

        def close(self) -> None:
            self._file.close()

    recording = make(opener=Filling)
    recording.record("memory", {})
    recording.begin()
    await until(lambda: recording.recording and len(list(read_recording(written(recording)))) == 1)
    assert not recording.wants_memory()
    full.set()
    recording.record("tick", {"n": 1})
    await until(lambda: not recording.health.is_healthy)
    assert "No space left on device" in recording.health.reason
    first = written(recording)
    full.clear()
    await until(lambda: recording.recording and recording.path != first)
    assert recording.wants_memory()  # the next file has none yet
    assert [one.topic for one in read_recording(first)] == ["memory"]


async def test_a_disk_that_fails_is_reported_and_what_was_written_stays(make: Make) -> None:
    fail = threading.Event()

    class Failing:
        def __init__(self, path: Path) -> None:
            self._file = path.open("xb")

        def write(self, data: bytes) -> int:
            if fail.is_set():
                raise OSError(errno.EIO, "Input/output error")
            return self._file.write(data)

        def flush(self) -> None:
            self._file.flush()

        def tell(self) -> int:
            return self._file.tell()

        def close(self) -> None:
            self._file.close()

    recording = make(opener=Failing)
    recording.begin()
    recording.record("tick", {"n": 1})
    await until(lambda: recording.recording and len(list(read_recording(written(recording)))) == 1)
    fail.set()
    recording.record("tick", {"n": 2})
    await until(lambda: not recording.health.is_healthy)
    assert "Input/output error" in recording.health.reason
    assert recording.dropped >= 1
    assert [one.payload()["n"] for one in read_recording(written(recording))] == [1]


async def test_a_folder_that_cannot_be_made_is_reported(make: Make, tmp_path: Path) -> None:
    (tmp_path / "recordings").write_text("a file in its place")
    recording = make()
    recording.begin()
    recording.record("tick", {"n": 1})
    await until(lambda: not recording.health.is_healthy)
    assert "recordings" in recording.health.reason


async def test_a_message_that_cannot_be_kept_costs_only_itself(make: Make) -> None:
    recording = make()
    recording.begin()
    recording.record("tick", {("a", "tuple"): 1})  # type: ignore[dict-item]
    recording.record("tick", {"n": 2})
    await recording.close()
    assert [one.payload()["n"] for one in read_recording(written(recording))] == [2]
    assert recording.dropped == 1


@pytest.mark.slow
async def test_a_torn_end_is_passed_over(make: Make, tmp_path: Path) -> None:
    recording = make()
    recording.begin()
    for number in range(10):
        recording.record_frame(replace(FRAME, sequence=number))
    await recording.close()
    whole = written(recording).read_bytes()
    torn = tmp_path / "torn.mcap"
    for length in range(len(whole) // 3, len(whole), 397):
        torn.write_bytes(whole[:length])
        frames = list(read_frames(torn, FrameInput))
        assert frames == [replace(FRAME, sequence=number) for number in range(len(frames))]


def test_what_is_no_recording_is_named(tmp_path: Path) -> None:
    path = tmp_path / "text.mcap"
    path.write_text("this is a text, not a recording")
    with pytest.raises(RecordingError, match=r"text.mcap: is no recording"):
        list(read_recording(path))
    with pytest.raises(RecordingError, match=r"none.mcap: cannot be read"):
        list(read_recording(tmp_path / "none.mcap"))
    (tmp_path / "empty.mcap").write_bytes(b"")
    with pytest.raises(RecordingError, match="no metadata"):
        read_metadata(tmp_path / "empty.mcap")


async def test_closing_twice_is_fine_and_ends_the_thread(make: Make) -> None:
    recording = make()
    recording.begin()
    await recording.close()
    await recording.close()
    assert not recording._thread.is_alive()


_CHILD = """
import sys, time
from pathlib import Path
from hawk.comm.clock import Clock
from hawk.config.sections import StoreSettings
from hawk.store.recording import Recording
recording = Recording(StoreSettings(directory=Path(sys.argv[1]), minimum_free_mb=1), Clock(), {"seed": "1"})
recording.begin()
number = 0
while True:
    number += 1
    recording.record("tick", {"n": number})
    print(number, time.monotonic(), flush=True)
    time.sleep(0.01)
"""


@pytest.mark.slow
def test_a_killed_process_loses_less_than_a_second(tmp_path: Path) -> None:
    child = subprocess.Popen([sys.executable, "-c", _CHILD, str(tmp_path)], stdout=subprocess.PIPE, text=True)
    put: list[tuple[int, float]] = []
    try:
        assert child.stdout is not None
        for _ in range(120):
            number, at = child.stdout.readline().split()
            put.append((int(number), float(at)))
        killed = time.monotonic()
        os.kill(child.pid, signal.SIGKILL)
        child.communicate(timeout=10)
    finally:
        child.kill()
        child.wait()
    (path,) = (tmp_path / "recordings").iterdir()
    kept = [one.payload()["n"] for one in read_recording(path)]
    assert kept == list(range(1, len(kept) + 1))
    assert {number for number, at in put if at < killed - 1.0} <= set(kept)


async def test_the_newest_complete_recording_is_found_after_a_restart_too(make: Make, tmp_path: Path) -> None:
    recording = make()
    with pytest.raises(NoRecordingError, match="no recording yet"):
        recording.newest()
    recording.begin()
    recording.record("tick", {"n": 1})
    await until(lambda: recording.recording)
    with pytest.raises(NoRecordingError, match="not complete yet"):
        recording.newest()
    recording.end()
    await until(lambda: not recording.recording)
    assert recording.newest() == written(recording)
    later = tmp_path / "recordings" / "20260501T130000Z.mcap"
    later.write_bytes(b"later")
    os.utime(later, (4e9, 4e9))
    assert make().newest() == later


async def test_nothing_is_recorded_names_the_setting(make: Make) -> None:
    with pytest.raises(NoRecordingError, match=r"\[store\] record is false"):
        make(record=False).newest()
