from __future__ import annotations

import asyncio
import os
import signal
import sys

import pytest

from hawk.comm.cameras.sources.child import Child, ChildTimeouts, Words
from hawk.comm.cameras.sources.source import CameraError
from hawk.config.secrets import without
from tests.unit.comm.cameras.sources.children import SHORT

STUBBORN = "import os, signal, time; signal.signal(signal.SIGTERM, signal.SIG_IGN); os.write(1, b'1'); time.sleep(600)"


def python(lines: str) -> tuple[str, ...]:
    return sys.executable, "-c", lines


async def test_output_is_read_to_its_end() -> None:
    async with Child(python("import os; os.write(1, b'picture')"), SHORT) as child:
        assert await child.read() == b"picture"
        assert await child.read() == b""


@pytest.mark.slow
async def test_a_child_that_ignores_the_request_to_end_is_killed() -> None:
    async with Child(python(STUBBORN), SHORT) as child:
        assert await child.read() == b"1"
    with pytest.raises(ProcessLookupError):
        os.kill(child.pid, 0)


async def test_what_the_child_started_ends_with_it() -> None:
    grandchild = "import subprocess, sys; p = subprocess.Popen(['sleep', '600']); print(p.pid, flush=True)"
    async with Child(python(grandchild), SHORT) as child:
        number = int(await child.read())
        os.kill(number, 0)  # it runs
    async with asyncio.timeout(10):
        while _state(number) not in ("", "Z"):  # noqa: ASYNC110 - init takes it over
            await asyncio.sleep(0.01)


def _state(pid: int) -> str:
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rsplit(")", 1)[1].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return ""


async def test_it_runs_in_a_session_of_its_own() -> None:
    async with Child(python(STUBBORN), SHORT) as child:
        assert os.getsid(child.pid) == child.pid
        assert os.getpgid(child.pid) != os.getpgid(0)


async def test_a_cancellation_is_kept_when_a_picture_comes_with_it() -> None:
    async with Child(python(STUBBORN), SHORT) as child:
        picture = asyncio.get_running_loop().create_future()
        reader = asyncio.ensure_future(child.within(picture))
        await asyncio.sleep(0)
        picture.set_result(b"picture")
        reader.cancel()
        with pytest.raises(asyncio.CancelledError):
            await reader


@pytest.mark.slow
async def test_silence_is_an_error_that_names_the_first_error() -> None:
    lines = (
        "import os, sys, time; sys.stderr.write('ERROR: first\\nERROR: second\\n'); os.write(1, b'1'); time.sleep(600)"
    )
    async with Child(python(lines), SHORT) as child:
        await child.read()
        child.heard()
        with pytest.raises(CameraError, match=r"no picture for 0.3 s; .* was ended \(ERROR: first\)"):
            await child.read()


@pytest.mark.slow
async def test_the_first_picture_may_take_longer() -> None:
    lines = "import os, time; time.sleep(0.8); os.write(1, b'1')"
    async with Child(python(lines), ChildTimeouts(first_s=30.0, silence_s=0.1, end_s=0.3)) as child:
        assert await child.read() == b"1"


async def test_a_program_that_is_not_there_is_an_error() -> None:
    with pytest.raises(CameraError, match="no-such-program is not installed"):
        async with Child(("no-such-program",), SHORT):
            pass


@pytest.mark.slow
async def test_a_child_of_a_cancelled_task_ends() -> None:
    started: asyncio.Future[int] = asyncio.get_running_loop().create_future()

    async def run() -> None:
        async with Child(python(STUBBORN), SHORT) as child:
            await child.read()
            started.set_result(child.pid)
            await child.read()

    task = asyncio.create_task(run())
    number = await started
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task
    with pytest.raises(ProcessLookupError):
        os.kill(number, signal.SIGCONT)


@pytest.mark.parametrize(
    ("said", "reason"),
    [
        (b"", ""),
        (b"a line\nanother", "another"),
        (b"WARN: one\nline\nWARN: two\n", "WARN: one"),
        (b"WARN: one\nERROR: the cause\nERROR: what follows\nmore\n", "ERROR: the cause"),
        (b"[0:12:33.4567] [1234] ERROR V4L2 v4l2.cpp:1 no camera\n", "ERROR V4L2 v4l2.cpp:1 no camera"),
        (b"ERROR: rtsp://me:word@cam/s refused\n", "ERROR: rtsp://***@cam/*** refused"),
        (b"ERROR: " + b"x" * 10_000, "ERROR: " + "x" * 293),
    ],
)
def test_the_first_error_is_the_reason(said: bytes, reason: str) -> None:
    words = Words()
    for at in range(0, len(said), 7):  # it comes in pieces
        words.feed(said[at : at + 7])
    words.end()
    assert words.reason == reason


def test_passwords_are_not_shown() -> None:
    text = 'rtspsrc location=rtsp://me:word@cam/live user-id=admin user-pw="a b" token=abc ! decodebin'
    assert without(text) == ("rtspsrc location=*** user-id=admin user-pw=*** token=*** ! decodebin")
