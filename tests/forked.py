"""Programs of hawk that tests start hundreds of times, forked from a process that has loaded their modules.

Loading them costs two seconds of a processor for a daemon and its simulator, which is a third of what such a test
costs. They behave the same: a session, an environment, files and an end of their own. A test of the start itself starts
a program as a person does.
"""

from __future__ import annotations

import asyncio
import functools
import importlib
import json
import os
import runpy
import signal
import socket
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO, Any, Final, cast

_LOADED: Final = (
    "hawk.cli", "hawk.daemon.start", "hawk.daemon.algorithms", "hawk.daemon.desk", "hawk.lots.store",
    "hawk.lots.storage.database", "hawk.lots.known_lot", "hawk.store.recording_file", "hawk.sim.cli", "hawk.sim.runner",
)  # fmt: skip
"""ONNX Runtime is not among them: it starts a thread when it is loaded, and a fork takes none along."""
_MESSAGE: Final = 1 << 20


class Program:
    """A forked program, as `asyncio.subprocess.Process` has it."""

    def __init__(self, pid: int, reader: asyncio.StreamReader | None) -> None:
        """The program runs. ``reader``: its standard output, where that is a pipe."""
        self.pid = pid
        self.stdout = reader
        self.returncode: int | None = None
        self._loop = asyncio.get_running_loop()
        self._ended = asyncio.Event()
        self._end = os.pidfd_open(pid)
        self._loop.add_reader(self._end, self._reap)

    def _reap(self) -> None:
        self._loop.remove_reader(self._end)
        os.close(self._end)
        self.returncode = os.waitstatus_to_exitcode(_nursery().ask({"reap": self.pid})["status"])
        self._ended.set()

    async def wait(self) -> int:
        """Return the exit status, a signal's number below zero."""
        await self._ended.wait()
        assert self.returncode is not None
        return self.returncode

    def send_signal(self, number: int) -> None:
        """Send a signal. Raises ProcessLookupError."""
        if self.returncode is not None:
            raise ProcessLookupError
        os.kill(self.pid, number)

    def terminate(self) -> None:
        """Send SIGTERM. Raises ProcessLookupError."""
        self.send_signal(signal.SIGTERM)

    def kill(self) -> None:
        """Send SIGKILL. Raises ProcessLookupError."""
        self.send_signal(signal.SIGKILL)


async def start_program(
    *command: str,
    stdin: int | None = None,
    stdout: int | IO[Any] | None = None,
    stderr: int | IO[Any] | None = None,
    env: Mapping[str, str] | None = None,
    start_new_session: bool = False,
) -> asyncio.subprocess.Process:
    """Start ``python -m MODULE …`` or ``python FILE …`` as `asyncio.create_subprocess_exec` does."""
    assert command[0] == sys.executable
    assert stdin in (None, asyncio.subprocess.DEVNULL), "it has none"
    asked = {
        "argv": command[1:], "env": dict(os.environ if env is None else env), "cwd": str(Path.cwd()),
        "session": start_new_session,
    }  # fmt: skip
    files, reader = [stdout or 1, stderr or 2], None
    if stdout == asyncio.subprocess.PIPE:
        ours, files[0] = os.pipe()
        reader = await _reading(ours)
    numbers = [each if isinstance(each, int) else each.fileno() for each in files]
    pid = _nursery().ask(asked, numbers)["pid"]
    if reader is not None:
        os.close(numbers[0])
    return cast("asyncio.subprocess.Process", Program(pid, reader))


async def _reading(end: int) -> asyncio.StreamReader:
    reader = asyncio.StreamReader()
    pipe = os.fdopen(end, "rb", 0)
    await asyncio.get_running_loop().connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), pipe)
    return reader


class _Nursery:
    """The process that forks, and the socket to it; it ends with this one."""

    def __init__(self) -> None:
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._socket = ours
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, "-m", __name__, str(theirs.fileno())],
                stdin=subprocess.DEVNULL,
                pass_fds=[theirs.fileno()],
            )

    def ask(self, what: Mapping[str, Any], files: Sequence[int] = ()) -> dict[str, int]:
        """Return the answer to a request, which takes ``files`` along."""
        socket.send_fds(self._socket, [json.dumps(what).encode()], files)
        return dict(json.loads(self._socket.recv(_MESSAGE)))


@functools.cache
def _nursery() -> _Nursery:
    return _Nursery()


def serve(line: socket.socket) -> dict[str, Any]:
    """Fork for each request until the other side ends; return the request in the process that was forked for it."""
    while True:
        data, files, _, _ = socket.recv_fds(line, _MESSAGE, 2)
        if not data:
            raise SystemExit(0)
        asked = json.loads(data)
        if "reap" in asked:
            answer = {"status": os.waitpid(asked["reap"], 0)[1]}
        else:
            pid = os.fork()
            if pid == 0:
                line.close()
                _take_on(asked, files)
                return dict(asked)
            answer = {"pid": pid}
        for file in files:
            os.close(file)
        line.send(json.dumps(answer).encode())


def _take_on(asked: Mapping[str, Any], files: Sequence[int]) -> None:
    if asked["session"]:
        os.setsid()
    for number, file in enumerate(files, 1):
        os.dup2(file, number)
    for file in files:
        os.close(file)
    os.chdir(asked["cwd"])
    os.environ.clear()
    os.environ.update(asked["env"])
    sys.path[0] = asked["cwd"]
    if os.environ.get("PYTHONUNBUFFERED"):
        sys.stdout.reconfigure(write_through=True)  # type: ignore[union-attr]


if __name__ == "__main__":
    for name in _LOADED:
        importlib.import_module(name)
    request = serve(socket.socket(fileno=int(sys.argv[1])))
    first, *rest = sys.argv = request["argv"]
    if first == "-m":
        sys.argv = rest
        runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)
    else:
        sys.path[0] = str(Path(first).parent)
        runpy.run_path(first, run_name="__main__")
