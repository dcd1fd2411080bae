"""Results of a city's windows: a file each, whole or not there; failed windows with their reasons.

A result is named by everything that makes it, so that one that is there is never computed again, on any computer that
shares the folder.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from hawk.algo.vision.network import Engine
from hawk.picture.nadir import Eye
from hawk.picture.orthophoto.source import Orthophoto
from hawk.picture.orthophoto.windows import Window, WindowStalls, map_window, task_name
from hawk.picture.values import PictureError, cannot_write
from hawk.picture.work_folder import FAILURES, WINDOWS


class ResultError(PictureError):
    """A result cannot be written: the whole run ends, because the next one could not be written either."""

    def __init__(self, path: Path, error: OSError) -> None:
        """``path``: the file or folder."""
        super().__init__(cannot_write(path, error))
        self._arguments = (path, error)

    def __reduce__(self) -> tuple[type[ResultError], tuple[Path, OSError]]:
        return type(self), self._arguments


@dataclass(frozen=True, slots=True)
class Task:
    """A window to look at. ``name``: that of its result."""

    name: str
    window: Window


def tasks_of(source: Orthophoto, windows: Iterable[Window], model: str, engine: Engine) -> tuple[Task, ...]:
    """Return the tasks of a picture's windows, in their order.

    Args:
        source: The picture.
        windows: Its windows.
        model: SHA-256 of the network's file.
        engine: Runs the network; engines differ in the last digits, so that the result's name has it.
    """
    # a mosaic of thousands of files has a long identity, which would be hashed for each window
    short = replace(source, identity=hashlib.sha256(source.identity.encode()).hexdigest())
    return tuple(Task(f"{task_name(short, window, model)}-{engine}", window) for window in windows)


class Results:
    """The folder of results; any number of processes may use it at once."""

    def __init__(self, folder: Path) -> None:
        """``folder``: of the run; results and failures are below it."""
        self.folder = folder

    def prepare(self) -> None:
        """Make the folders. Raises ResultError."""
        for folder in (self.folder / WINDOWS, self.folder / FAILURES):
            try:
                folder.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise ResultError(folder, error) from error

    def find(self, task: Task) -> WindowStalls | None:
        """Return a task's result; None when there is none that is whole and the task's own."""
        try:
            data = self._result(task).read_bytes()
        except OSError:
            return None
        head = _head(task)
        if not (data.startswith(head) and data.endswith(b"}\n")):
            return None
        with contextlib.suppress(PictureError):
            found = WindowStalls.from_bytes(data[len(head) : -2])
            if found.window == task.window:
                return found
        return None

    def keep(self, task: Task, found: WindowStalls) -> None:
        """Write a task's result, and forget that it failed. Raises ResultError."""
        self._write(self._result(task), _head(task) + found.to_bytes() + b"}\n")
        with contextlib.suppress(OSError):
            self._failure(task).unlink()

    def fail(self, task: Task, window: str, reason: str) -> None:
        """Write why a task has no result. ``window``: its name for a person. Raises ResultError."""
        content = {"task": task.name, "window": window, "reason": reason}
        self._write(self._failure(task), json.dumps(content, ensure_ascii=False).encode() + b"\n")

    def clear(self, tasks: Iterable[Task]) -> None:
        """Remove the results of tasks, and the folders where nothing else is in them."""
        for task in tasks:
            self._result(task).unlink(missing_ok=True)
        for folder in (self.folder / WINDOWS, self.folder / FAILURES, self.folder):
            with contextlib.suppress(OSError):
                folder.rmdir()

    def failures(self) -> Iterator[tuple[str, str]]:
        """Yield window and reason of each failure that stands, by the names of their files."""
        for path in sorted((self.folder / FAILURES).glob("*.json")):
            with contextlib.suppress(OSError, ValueError, KeyError, TypeError):
                content = json.loads(path.read_bytes())
                yield str(content["window"]), str(content["reason"])

    def _result(self, task: Task) -> Path:
        return self.folder / WINDOWS / f"{task.name}.json"

    def _failure(self, task: Task) -> Path:
        return self.folder / FAILURES / f"{task.name}.json"

    def _write(self, path: Path, data: bytes) -> None:
        """Write a file whole or not at all; two processes that write the same one do not meet."""
        temporary = ""
        try:
            handle, temporary = tempfile.mkstemp(prefix=".", suffix=".new", dir=path.parent)
            with os.fdopen(handle, "wb") as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
            os.chmod(temporary, 0o644)  # other users' workers read it
            os.replace(temporary, path)
        except OSError as error:
            if temporary:
                Path(temporary).unlink(missing_ok=True)
            raise ResultError(path, error) from error


def look(task: Task, source: Orthophoto, eye: Eye, results: Results) -> str:
    """Look at a task's window unless its result is there.

    Returns:
        The reason why it could not be looked at, which is written too; "" when the result is there.

    Raises:
        ResultError: The result cannot be written.
    """
    if results.find(task) is not None:
        return ""
    try:
        found = map_window(source, task.window, eye)
    except PictureError as error:
        results.fail(task, task.window.name(source.grid), str(error))
        return str(error)
    results.keep(task, found)
    return ""


def _head(task: Task) -> bytes:
    return b'{"task":' + json.dumps(task.name).encode() + b',"result":'
