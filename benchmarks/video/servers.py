"""Starts the servers that are compared: hawk's web server, and µStreamer with a made-up camera."""

from __future__ import annotations

import asyncio
import contextlib
import os
import shutil
import socket
import subprocess
import sys
from collections.abc import AsyncIterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from benchmarks.figures import BenchmarkError
from benchmarks.video.pictures import HEIGHT, WIDTH

HOST: Final = "127.0.0.1"
FEEDER: Final = Path(__file__).with_name("fake_camera.c")
USTREAMER: Final = "ustreamer"
INSTALL: Final = "ustreamer is not installed (Debian and Ubuntu: apt-get install ustreamer); hawk is measured alone"
START_S: Final = 60.0
STOP_S: Final = 5.0
_PINNED: Final = (
    "import os,sys;cores=[int(c) for c in sys.argv[1].split(',') if c];"
    "cores and os.sched_setaffinity(0,cores);os.execvp(sys.argv[2],sys.argv[2:])"
)


@dataclass(frozen=True, slots=True)
class Served:
    """A server that runs."""

    pid: int
    port: int


def cores() -> tuple[str, str]:
    """Return the cores of the server and those of the clients, empty where there is one core only."""
    found = sorted(os.sched_getaffinity(0))
    return (str(found[0]), ",".join(map(str, found[1:]))) if len(found) > 1 else ("", "")


async def spawn(
    command: Sequence[str], cores: str, environment: Mapping[str, str] | None = None, log: Path | None = None
) -> asyncio.subprocess.Process:
    """Start a process on these cores, its standard input and output being pipes; ``log`` takes both outputs."""
    output = asyncio.subprocess.PIPE if log is None else log.open("ab")
    try:
        return await asyncio.create_subprocess_exec(
            sys.executable, "-c", _PINNED, cores, *command,
            stdin=asyncio.subprocess.PIPE, stdout=output, stderr=None if log is None else output,
            env={**os.environ, **(environment or {})},
        )  # fmt: skip
    finally:
        if not isinstance(output, int):
            output.close()


@contextlib.asynccontextmanager
async def hawk(pictures: Path, fps: float, cores: str) -> AsyncIterator[Served]:
    """Run hawk's web server. Raises BenchmarkError."""
    process = await spawn((sys.executable, "-m", "benchmarks.video.server", str(pictures), f"{fps:g}"), cores)
    try:
        assert process.stdout is not None
        async with asyncio.timeout(START_S):
            line = (await process.stdout.readline()).split()
        if line[:1] != [b"ready"]:
            raise BenchmarkError("hawk's server did not start; see its message above")
        yield Served(process.pid, int(line[1]))
    finally:
        await _end(process)


@contextlib.asynccontextmanager
async def ustreamer(pictures: Path, fps: float, cores: str, feeder: Path, log: Path) -> AsyncIterator[Served]:
    """Run µStreamer with a preload library as its camera. Raises BenchmarkError."""
    port = _free_port()
    process = await spawn(
        (USTREAMER, "--device=/dev/video0", "-r", f"{WIDTH}x{HEIGHT}", "--format=JPEG", "--encoder=HW",
         "--tcp-nodelay", "--host", HOST, "--port", str(port)),
        cores, {"FRAMES": str(pictures), "FPS": f"{fps:g}", "LD_PRELOAD": str(feeder)}, log,
    )  # fmt: skip
    try:
        await _listening(process, port, log)
        yield Served(process.pid, port)
    finally:
        process.terminate()
        await _end(process)


def is_there() -> bool:
    """Return True when µStreamer is installed."""
    return shutil.which(USTREAMER) is not None


def compiled(source: Path, folder: Path) -> Path:
    """Return the feeder as a library, compiled when it is C. Raises BenchmarkError."""
    if not source.is_file():
        raise BenchmarkError(f"--ustreamer-feeder: {source} is no file; name a preload library or its C source")
    if source.suffix != ".c":
        return source.resolve()
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        raise BenchmarkError("no C compiler for µStreamer's camera: install one (apt-get install gcc libc6-dev)")
    made = folder / "camera.so"
    command = (compiler, "-shared", "-fPIC", "-O2", "-o", str(made), str(source), "-ldl")
    if subprocess.run(command, check=False).returncode != 0:
        raise BenchmarkError(f"{source} could not be compiled; see the message above")
    return made


def _free_port() -> int:
    with socket.socket() as found:
        found.bind((HOST, 0))
        return int(found.getsockname()[1])


async def _listening(process: asyncio.subprocess.Process, port: int, log: Path) -> None:
    loop = asyncio.get_running_loop()
    end = loop.time() + START_S
    while loop.time() < end and process.returncode is None:
        with contextlib.suppress(OSError):
            _, writer = await asyncio.open_connection(HOST, port)
            writer.close()
            return
        await asyncio.sleep(0.05)
    raise BenchmarkError(f"µStreamer did not start: {_end_of(log)}")


def _end_of(log: Path) -> str:
    return log.read_text(errors="replace")[-2000:]


async def _end(process: asyncio.subprocess.Process) -> None:
    """Close its standard input; kill it where that does not end it."""
    if process.stdin is not None:
        process.stdin.close()
    try:
        async with asyncio.timeout(STOP_S):
            await process.wait()
    except TimeoutError:
        process.kill()
        await process.wait()
