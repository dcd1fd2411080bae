"""A control group that makes a computer small: the processes in it have one core and little memory.

One core of the machine by cpuset, not a share of several: a share lets threads run side by side and then stops all of
them, which no computer of one core does. Both versions of control groups are served (cgroups(7)).
"""

from __future__ import annotations

import contextlib
import os
import re
import signal
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from benchmarks.figures import BenchmarkError

ROOT: Final = Path("/sys/fs/cgroup")
EMPTY_S: Final = 5.0
"""Longest time for the processes of a group to end once they are killed."""
_ENTER: Final = 'for folder in {folders}; do echo $$ > "$folder/cgroup.procs"; done; exec "$@"'


@dataclass(frozen=True, slots=True)
class Box:
    """A control group. ``folders``: one of each hierarchy; ``memory`` the one that counts memory."""

    folders: tuple[Path, ...]
    memory: Path

    @property
    def prefix(self) -> list[str]:
        """The beginning of a command line that runs the rest of it in the group."""
        folders = " ".join(f"'{folder}'" for folder in self.folders)
        return ["sh", "-c", _ENTER.format(folders=folders), "sh"]

    def processes(self) -> list[int]:
        """Return the ids of all processes in the group."""
        return [int(line) for line in (self.memory / "cgroup.procs").read_text().split()]

    def anonymous_bytes(self) -> int:
        """Return the memory that the processes hold themselves: what no file could give back."""
        found = re.search(r"^(?:total_rss|anon) (\d+)$", (self.memory / "memory.stat").read_text(), re.MULTILINE)
        if found is None:
            raise BenchmarkError(f"{self.memory / 'memory.stat'} names no anonymous memory")
        return int(found[1])

    def peak_bytes(self) -> int | None:
        """Return the most memory that the group ever held, files that were read among it; None when not counted."""
        for name in ("memory.peak", "memory.max_usage_in_bytes"):
            with contextlib.suppress(OSError):
                return int((self.memory / name).read_text())
        return None

    def remove(self) -> None:
        """Kill what is left in the group, and take it away."""
        for pid in self.processes():
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        ends = time.monotonic() + EMPTY_S
        while self.processes() and time.monotonic() < ends:
            time.sleep(0.02)
        for folder in self.folders:
            folder.rmdir()


def make_box(core: int, memory_bytes: int, root: Path = ROOT) -> Box:
    """Make a group with this core alone and so much memory. Raises BenchmarkError naming what is needed."""
    name = f"hawk-small-{os.getpid()}"
    try:
        if (root / "cgroup.controllers").is_file():
            return _unified(root, name, core, memory_bytes)
        return _by_controller(root, name, core, memory_bytes)
    except OSError as error:
        raise BenchmarkError(
            f"no control group can be made ({error}): run as root, on a machine with cgroups"
        ) from error


def _unified(root: Path, name: str, core: int, memory_bytes: int) -> Box:
    (root / "cgroup.subtree_control").write_text("+cpuset +memory")
    folder = root / name
    folder.mkdir()
    try:
        (folder / "cpuset.cpus").write_text(str(core))
        (folder / "memory.max").write_text(str(memory_bytes))
        swap = folder / "memory.swap.max"
        if swap.exists():
            swap.write_text("0")
    except OSError:
        folder.rmdir()
        raise
    return Box((folder,), folder)


def _by_controller(root: Path, name: str, core: int, memory_bytes: int) -> Box:
    cpuset, memory = root / "cpuset" / name, root / "memory" / name
    made: list[Path] = []
    try:
        for folder in (cpuset, memory):
            folder.mkdir()
            made.append(folder)
        (cpuset / "cpuset.mems").write_text((cpuset.parent / "cpuset.mems").read_text())
        (cpuset / "cpuset.cpus").write_text(str(core))
        (memory / "memory.limit_in_bytes").write_text(str(memory_bytes))
    except OSError:
        for folder in made:
            folder.rmdir()
        raise
    return Box((cpuset, memory), memory)


def other_cores(core: int, cores: Sequence[int]) -> set[int]:
    """Return the cores for everything else. Raises BenchmarkError on a machine of one core."""
    others = {each for each in cores if each != core}
    if not others:
        raise BenchmarkError("the machine has one core: simulator and daemon would share it")
    return others
