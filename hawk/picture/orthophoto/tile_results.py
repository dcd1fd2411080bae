"""Results of a picture's windows: a file each, whole or not there; failed windows with their reasons.

One that is there is never computed again, on any computer that shares the folder.
"""

from __future__ import annotations

import contextlib
import json
import os
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path

from hawk.picture.orthophoto.windows import Task, WindowStalls
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


def _head(task: Task) -> bytes:
    return b'{"task":' + json.dumps(task.name).encode() + b',"result":'
