"""A clean Debian root: nothing but what mmdebstrap put there, and no network."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from proving.bare_root import CLEAN

CALM = ("chrt", "--idle", "0") if os.environ.get("DEB_CALM") else ()
"""Set on a machine that measures something else meanwhile."""
ENTER = 'ip link set lo up; mount -t proc proc "$0/proc"; exec chroot "$0" "$@"'


def printed(command: Sequence[str], environment: Mapping[str, str], *, fails: bool, timeout: float) -> str:
    """Run a command; return what it printed. Its status must be 0, or another one if it ``fails``."""
    done = subprocess.run(
        command,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=timeout,
        check=False,
    )
    assert (done.returncode != 0) is fails, f"{' '.join(command)}: status {done.returncode}\n{done.stdout}"
    return done.stdout


@dataclass(frozen=True, slots=True)
class CleanRoot:
    """The root's folder. What `run` starts ends with it."""

    folder: Path

    @classmethod
    def extract(cls, archive: Path, folder: Path) -> CleanRoot:
        """Make it from mmdebstrap's archive."""
        folder.mkdir()
        subprocess.run([*CALM, "tar", "-C", str(folder), "-xf", str(archive)], check=True, timeout=600)
        for name in ("proc", "run"):  # a root that was only unpacked lacks them
            (folder / name).mkdir(exist_ok=True)
        return cls(folder)

    def command(self, *arguments: str) -> list[str]:
        """Return the command that runs another one in it, with a network of its own: loopback alone."""
        spaces = ["unshare", "--net", "--mount", "--pid", "--fork", "--kill-child=SIGKILL"]
        return [*CALM, *spaces, "sh", "-c", ENTER, str(self.folder), *arguments]

    def run(
        self, *arguments: str, fails: bool = False, environment: Mapping[str, str] | None = None, timeout: float = 900
    ) -> str:
        """Run a command in it; return what it printed. Its status must be 0, or another one if it ``fails``."""
        return printed(self.command(*arguments), {**CLEAN, **(environment or {})}, fails=fails, timeout=timeout)

    def path(self, name: str) -> Path:
        """Return a file of it, by its absolute name there."""
        return self.folder / name.lstrip("/")

    def bring(self, file: Path) -> str:
        """Copy a file into it; return its name there."""
        target = self.folder / "root" / file.name
        subprocess.run(["cp", "--reflink=auto", str(file), str(target)], check=True, timeout=300)
        return f"/root/{file.name}"
