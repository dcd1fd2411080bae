"""Which program of this computer holds a port or a device, by ``/proc`` (proc(5)).

Another user's programs hide their files from us; then only the user is known.
"""

from __future__ import annotations

import contextlib
import os
import pwd
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Final, Literal

Kind = Literal["tcp", "udp"]
_LISTEN: Final = "0A"  # TCP_LISTEN
_OTHER_COMMANDS: Final = frozenset({"check", "doctor", "film", "tokens", "make-certificate"})
_SIMULATED: Final = frozenset({"--sim", "--attach-sim", "--url"})
"""With these options a program flies no drone of its own."""


@dataclass(frozen=True, slots=True)
class Processes:
    """The programs that run. ``proc`` is the kernel's folder; ``own`` our process, which is left out."""

    proc: Path = Path("/proc")
    own: int = 0

    def holder_of_port(self, kind: Kind, port: int) -> str:
        """Return words for the program that holds a port; empty when nobody is found."""
        for inode, user in self._sockets(kind, port):
            number = self._with_file(f"socket:[{inode}]")
            return self._words(number) if number is not None else f"a program of the user {_user(user)}"
        return ""

    def holder_of_file(self, path: Path) -> str:
        """Return words for a program that has a device open; empty when nobody is found."""
        number = self._with_file(str(path.resolve()))
        return "" if number is None else self._words(number)

    def daemons(self) -> list[int]:
        """Return the processes that are a hawk-drone which may fly a real drone."""
        return [number for number in self._numbers() if _is_daemon(self._command(number))]

    def _words(self, number: int) -> str:
        words = self._command(number)
        name = next((Path(word).name for word in words[:2] if "python" not in Path(word).name), "a program")
        return f"{name} (process {number})"

    def _numbers(self) -> Iterator[int]:
        with contextlib.suppress(OSError):
            for entry in sorted(self.proc.iterdir()):
                if entry.name.isdigit() and int(entry.name) != (self.own or os.getpid()):
                    yield int(entry.name)

    def _command(self, number: int) -> list[str]:
        try:
            data = (self.proc / str(number) / "cmdline").read_bytes()
        except OSError:
            return []
        return [word.decode("utf-8", "replace") for word in data.split(b"\0") if word]

    def _with_file(self, target: str) -> int | None:
        for number in self._numbers():
            with contextlib.suppress(OSError):
                for descriptor in (self.proc / str(number) / "fd").iterdir():
                    with contextlib.suppress(OSError):
                        if str(descriptor.readlink()) == target:
                            return number
        return None

    def _sockets(self, kind: Kind, port: int) -> Iterator[tuple[str, int]]:
        """Yield inode and user of the sockets that are bound to a port."""
        for name in (kind, f"{kind}6"):
            try:
                lines = (self.proc / "net" / name).read_text().splitlines()[1:]
            except OSError:
                continue
            for line in lines:
                words = line.split()
                if len(words) < 10 or int(words[1].rpartition(":")[2], 16) != port:
                    continue
                if kind == "udp" or words[3] == _LISTEN:
                    yield words[9], int(words[7])


def _is_daemon(words: list[str]) -> bool:
    place = next((place for place, word in enumerate(words[:2]) if Path(word).name == "hawk-drone"), None)
    if place is None:
        return False
    options = words[place + 1 :]
    names = {option.partition("=")[0] for option in options}
    return not names & _SIMULATED and not (options and options[0] in _OTHER_COMMANDS)


def _user(number: int) -> str:
    try:
        return pwd.getpwuid(number).pw_name
    except KeyError:
        return str(number)


def remedy(extra: str) -> str:
    """Return the command that adds an extra, from the wheel."""
    wheel = f"hawk_drone-{version('hawk-drone')}-py3-none-any.whl"
    return f"install it from hawk's wheel: pip install './{wheel}[{extra}]'"
