"""A child process that writes pictures on its standard output: started, watched, ended.

A hanging child is a camera that hangs: one that gives no picture for some seconds is killed, and its source ends, so
that the camera is opened again. A child has a session of its own: a key pressed in the daemon's terminal ends the
daemon alone, and the daemon ends the child with all that it started.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import re
import shutil
import signal
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass
from types import TracebackType
from typing import Final, TypeVar

from hawk.comm.cameras.sources.source import CameraError
from hawk.config.secrets import without
from hawk.runtime.supervision import end_tasks

T = TypeVar("T")

READ: Final = 1 << 16
"""Bytes of one read: Linux's pipe holds as many."""
_LEAST_WAIT_S: Final = 0.1
"""A loop that was late must not take a child for silent whose pictures wait in the pipe."""
_LONGEST_LINE: Final = 4096
_LONGEST_WORDS: Final = 300
_STAMP: Final = re.compile(r"^\[[\d:.]+\]\s+\[\d+\]\s+")
"""libcamera's time and thread before a message: the same error must read the same each time."""


@dataclass(frozen=True, slots=True)
class ChildTimeouts:
    """Real seconds that a child may take: to its first picture, between two, and to end when it is asked to."""

    first_s: float = 10.0
    silence_s: float = 3.0
    end_s: float = 2.0


CHILD_TIMEOUTS: Final = ChildTimeouts()


class Words:
    """Keeps of the child's standard error the first error; without one, the first warning, else the last line."""

    def __init__(self, is_error: Callable[[str], bool] = lambda line: "ERROR" in line) -> None:
        self._is_error = is_error
        self._rest = b""
        self._error = self._warning = self._last = ""

    def feed(self, data: bytes) -> None:
        """Take bytes of standard error."""
        *lines, self._rest = (self._rest + data).split(b"\n")
        self._rest = self._rest[:_LONGEST_LINE]
        for line in lines:
            self._take(line)

    def end(self) -> None:
        """Take the last line, which may lack its end."""
        self._take(self._rest)
        self._rest = b""

    @property
    def reason(self) -> str:
        """One line, without passwords; empty when the child said nothing."""
        return self._error or self._warning or self._last

    def _take(self, raw: bytes) -> None:
        line = without(_STAMP.sub("", raw.decode("utf-8", "replace").strip()))[:_LONGEST_WORDS]
        if not line:
            return
        self._last = line
        if self._is_error(line):
            self._error = self._error or line
        elif "WARN" in line:
            self._warning = self._warning or line


class Child:
    """One run of a program. Use it as an asynchronous context: on leaving, nothing of it runs any more."""

    def __init__(
        self, command: Sequence[str], timeouts: ChildTimeouts, words: Words | None = None, pass_fds: Sequence[int] = ()
    ) -> None:
        """``command``: the program and its arguments; no shell sees them."""
        self._command = tuple(command)
        self._timeouts = timeouts
        self._pass_fds = tuple(pass_fds)
        self._process: asyncio.subprocess.Process | None = None
        self._listener: asyncio.Task[None] | None = None
        self._limit_s = timeouts.first_s
        self._deadline = 0.0
        self.words = words or Words()

    @property
    def pid(self) -> int:
        """The process's number, which is that of its group and session, too."""
        return self._running().pid

    async def __aenter__(self) -> Child:
        """Start the program. Raises CameraError when it is not installed or cannot be run."""
        if shutil.which(self._command[0]) is None:
            raise CameraError(f"{self._command[0]} is not installed")
        pipe = asyncio.subprocess.PIPE
        try:
            self._process = await asyncio.create_subprocess_exec(
                *self._command,
                stdin=asyncio.subprocess.DEVNULL,
                stdout=pipe,
                stderr=pipe,
                start_new_session=True,
                pass_fds=self._pass_fds,
            )
        except OSError as error:
            raise CameraError(f"{self._command[0]} cannot be run: {error.strerror}") from error
        self._listener = asyncio.create_task(self._listen(), name="camera-child-words")
        self._deadline = asyncio.get_running_loop().time() + self._limit_s
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the program and all of its session's group."""
        process, listener = self._running(), self._listener
        try:
            if process.returncode is None:
                self._signal(signal.SIGTERM)
                with contextlib.suppress(TimeoutError):
                    async with asyncio.timeout(self._timeouts.end_s):
                        await process.wait()
        finally:
            self._signal(signal.SIGKILL)  # what the program started may have outlived it
            await process.wait()
            if listener is not None:
                await end_tasks(listener)

    async def read(self) -> bytes:
        """Return the next bytes of standard output, none at its end. Raises CameraError after too long a silence."""
        output = self._running().stdout
        assert output is not None  # noqa: S101
        return await self.within(output.read(READ))

    async def within(self, wanted: Awaitable[T]) -> T:
        """Await something that the child gives. Raises CameraError when it takes longer than a picture may."""
        left = self._deadline - asyncio.get_running_loop().time()
        try:
            async with asyncio.timeout(max(left, _LEAST_WAIT_S)):
                return await wanted
        except TimeoutError:
            said = f" ({self.words.reason})" if self.words.reason else ""
            raise CameraError(f"no picture for {self._limit_s:g} s; {self._command[0]} was ended{said}") from None

    def heard(self) -> None:
        """Note that a picture came: the next may take its time from now on."""
        self._limit_s = self._timeouts.silence_s
        self._deadline = asyncio.get_running_loop().time() + self._limit_s

    async def last_words(self) -> str:
        """Return why the program ended, after the end of its output."""
        if self._listener is not None:
            await asyncio.wait((self._listener,), timeout=self._timeouts.end_s)
        return self.words.reason

    def _running(self) -> asyncio.subprocess.Process:
        assert self._process is not None  # noqa: S101 - the context was entered
        return self._process

    def _signal(self, number: signal.Signals) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._running().pid, number)

    async def _listen(self) -> None:
        errors = self._running().stderr
        assert errors is not None  # noqa: S101
        while data := await errors.read(READ):
            self.words.feed(data)
        self.words.end()
