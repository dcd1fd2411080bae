"""The box in which strangers' files are read: bounds on memory and time, and no network.

`read_apart` reads in a process of its own, whose end is all that a file can bring about: for a program that flies or
serves. `enter` puts the running process into the box: for a command that does nothing but read such files. A reader is
named as "module:function"; it takes the file's bytes and what is asked of it, and returns bytes.
"""

from __future__ import annotations

import asyncio
import contextlib
import ctypes
import importlib
import json
import os
import sys
import warnings
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final, Protocol

from hawk.runtime.process import set_session_niceness

MODULE: Final = "hawk.formats.box"
REFUSED: Final = 3
"""Exit status of a file that cannot be used; the output says the field and the reason."""
COMMAND_TOO_MUCH: Final = (
    "takes more memory than is free here: close other programs, or give a smaller part of the pictures"
)
TOO_MUCH: Final = "takes more memory or time than such a file does: leave other layers out"
NICENESS: Final = 15
_CLONE_NEWUSER, _CLONE_NEWNET = 0x1000_0000, 0x4000_0000
"""unshare(2)."""
_LEAST_MEMORY: Final = 2_000_000_000
_SHARE: Final = 0.8
"""Share of the memory that is free which a command may take."""
_SAFE: Final[Mapping[str, str]] = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "PROJ_NETWORK": "OFF",
    "OPENCV_FFMPEG_CAPTURE_OPTIONS": "protocol_whitelist;file",
}


@dataclass(frozen=True, slots=True)
class Limits:
    """Of a process: bytes of its own data, seconds of the processor, real seconds on a computer that does more."""

    memory_bytes: int = 1_000_000_000
    cpu_s: int = 120
    longest_s: float = 180.0


PLANS: Final = Limits()
"""A DXF of 6 MB takes 130 MB while it is read, the worst JSON of 32 MB 900 MB."""


class RefusedError(ValueError):
    """A file cannot be used. ``field``: "file", or a choice of the one who asked; ``reason``: with the remedy."""

    def __init__(self, field: str, reason: str) -> None:
        super().__init__(f"{field}: {reason}")
        self.field = field
        self.reason = reason


class Reader(Protocol):
    """A function that the box calls. Raises errors with ``field`` and ``reason`` for a file that cannot be used."""

    def __call__(self, data: bytes, asked: dict[str, Any]) -> bytes:
        """Return what becomes of a file."""
        ...


# -- the process that asks --------------------------------------------------------------------------------------------


async def read_apart(reader: str, data: bytes, asked: Mapping[str, Any], limits: Limits = PLANS) -> bytes:
    """Return what a reader makes of a file, in a process of its own. Raises RefusedError."""
    process = await asyncio.create_subprocess_exec(
        *_command(reader, asked, limits),
        stdin=asyncio.subprocess.PIPE,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.DEVNULL,
        env={**os.environ, **_SAFE},
        start_new_session=True,
    )
    try:
        async with asyncio.timeout(limits.longest_s):
            said, _ = await process.communicate(data)
    except TimeoutError:
        words = f"takes more than {limits.longest_s:.0f} s to read: leave other layers out"
        raise RefusedError("file", words) from None
    finally:
        if process.returncode is None:
            process.kill()
            await process.wait()
    return _taken(process.returncode, said)


def read_and_wait(reader: str, data: bytes, asked: Mapping[str, Any], limits: Limits = PLANS) -> bytes:
    """Return as `read_apart`, for a thread without a loop. Raises RefusedError."""
    return asyncio.run(read_apart(reader, data, asked, limits))


def _command(reader: str, asked: Mapping[str, Any], limits: Limits) -> list[str]:
    return [sys.executable, "-m", MODULE, reader, json.dumps(asked), json.dumps(asdict(limits))]


def _taken(status: int | None, said: bytes) -> bytes:
    """Return the output of a process that has ended. Raises RefusedError."""
    if status == REFUSED:
        refusal = json.loads(said)
        raise RefusedError(refusal["field"], refusal["reason"])
    if status != 0:
        raise RefusedError("file", TOO_MUCH)
    return said


# -- the process in the box -------------------------------------------------------------------------------------------


def enter(limits: Limits, *, needs_network: bool = False) -> None:
    """Put this process into the box, before it has threads. What a system does not have is left out."""
    os.environ.update(_SAFE)
    if not needs_network:
        cut_network()
    try:
        import resource
    except ImportError:  # no POSIX system
        return
    for kind, count in ((resource.RLIMIT_DATA, limits.memory_bytes), (resource.RLIMIT_CPU, limits.cpu_s)):
        highest = resource.getrlimit(kind)[1]
        with contextlib.suppress(OSError, ValueError):
            resource.setrlimit(kind, (min(count, highest) if 0 <= highest < count else count, highest))


def enter_command(*, needs_network: bool, memory_bytes: int | None = None) -> None:
    """Put a command of the terminal into the box, before its work has threads: its process does nothing else.

    ``memory_bytes``: that it may take; None: most of what is free.
    """
    limit = memory_for_command() if memory_bytes is None else memory_bytes
    enter(Limits(limit, -1), needs_network=needs_network)


def memory_for_command() -> int:
    """Return the bytes that a command may take: most of those that are free, where the system says them."""
    with contextlib.suppress(OSError, ValueError, StopIteration):
        lines = Path("/proc/meminfo").read_text("ascii").splitlines()
        free = next(int(line.split()[1]) for line in lines if line.startswith("MemAvailable:"))
        return max(_LEAST_MEMORY, int(free * 1024 * _SHARE))
    return -1


def cut_network() -> bool:
    """Leave the network for an empty one of this process; return whether the system let it (Linux alone does).

    root needs no user namespace for it, which would take its rights to files. Others keep their id in theirs.
    """
    try:
        unshare = ctypes.CDLL(None, use_errno=True).unshare
    except (OSError, AttributeError):
        return False
    if unshare(_CLONE_NEWNET) == 0:
        return True
    user, group = os.getuid(), os.getgid()
    if unshare(_CLONE_NEWUSER | _CLONE_NEWNET) != 0:
        return False
    with contextlib.suppress(OSError):
        Path("/proc/self/setgroups").write_text("deny", "ascii")
        Path("/proc/self/uid_map").write_text(f"{user} {user} 1", "ascii")
        Path("/proc/self/gid_map").write_text(f"{group} {group} 1", "ascii")
    return True


def main(reader: str, asked: str, limits: str) -> int:
    """Read a file from the input and write what becomes of it; return the exit status."""
    with contextlib.suppress(OSError):
        os.nice(NICENESS)
        Path("/proc/self/oom_score_adj").write_text("1000", "ascii")  # where memory is short, this process ends first
    set_session_niceness(NICENESS)  # it is of a session of its own
    enter(Limits(**json.loads(limits)))
    warnings.simplefilter("ignore")  # of packages about a stranger's file: nobody reads them here
    try:
        sys.stdout.buffer.write(named(reader)(sys.stdin.buffer.read(), json.loads(asked)))
    except MemoryError:
        return _refuse("file", TOO_MUCH)
    except Exception as error:  # a stranger's file, and packages that expect whole ones
        return _refuse(*words_of_error(error))
    return 0


def words_of_error(error: Exception) -> tuple[str, str]:
    """Return field and reason of an error by which a reader ended."""
    field, reason = getattr(error, "field", None), getattr(error, "reason", None)
    if isinstance(field, str) and isinstance(reason, str):
        return field, reason
    return "file", f"cannot be read ({type(error).__name__}): export it again, or in another form"


def named(reader: str) -> Reader:
    """Return a reader by its name."""
    module, _, function = reader.partition(":")
    found: Reader = getattr(importlib.import_module(module), function)
    return found


def _refuse(field: str, reason: str) -> int:
    sys.stdout.write(json.dumps({"field": field, "reason": reason}))
    return REFUSED


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
