"""A bare Debian 12 in a folder, as mmdebstrap makes it, with the network of this machine. Needs root."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from benchmarks.figures import BenchmarkError

MIRROR: Final = "http://deb.debian.org/debian"
_MAKE: Final = ("mmdebstrap", "--quiet", "--variant=minbase", "bookworm")
_ENTER: Final = (
    'mount -t proc proc "$0/proc" && mount --rbind /dev "$0/dev" && '
    'exec chroot "$0" /bin/sh -c \'cd "$0" && eval "$1"\' "$1" "$2"'
)
"""Of sh: the root's folder, the folder in it to begin in, the line to run."""
CLEAN: Final = {
    "PATH": "/usr/sbin:/usr/bin:/sbin:/bin",
    "HOME": "/root",
    "LC_ALL": "C.UTF-8",
    "DEBIAN_FRONTEND": "noninteractive",
}
"""Environment of a Debian that nobody has set up."""
_NETWORK: Final = ("PIP_INDEX_URL", "http_proxy", "https_proxy", "no_proxy")
_CERTIFICATES: Final = ("PIP_CERT", "SSL_CERT_FILE", "NODE_EXTRA_CA_CERTS")
_NETWORK_FILES: Final = ("/etc/resolv.conf", "/etc/hosts")
_MAKE_S: Final = 1800
_END_S: Final = 20


@dataclass(frozen=True, slots=True)
class BareRoot:
    """The root's folder, and the environment of its lines."""

    folder: Path
    environment: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def make(cls, folder: Path, mirror: str = MIRROR, ours: Mapping[str, str] = os.environ) -> BareRoot:
        """Make it in a new folder.

        What apt, pip and npm need of this machine's network goes along: resolv.conf, hosts and, of the environment
        ``ours``, PIP_INDEX_URL, the proxies and the files that PIP_CERT, SSL_CERT_FILE and NODE_EXTRA_CA_CERTS name.

        Raises BenchmarkError when it cannot be made here.
        """
        if os.geteuid() != 0:
            raise BenchmarkError("a bare Debian root needs root: run it as root")
        if shutil.which(_MAKE[0]) is None:
            raise BenchmarkError("mmdebstrap is not installed: sudo apt-get install mmdebstrap")
        done = subprocess.run(
            [*_MAKE, str(folder), mirror], capture_output=True, text=True, timeout=_MAKE_S, check=False
        )
        if done.returncode != 0:
            raise BenchmarkError(f"mmdebstrap: {done.stderr.strip()}")
        for name in _NETWORK_FILES:
            shutil.copyfile(name, folder / name.lstrip("/"))
        environment = {**CLEAN, **{name: ours[name] for name in _NETWORK if name in ours}}
        for name in _CERTIFICATES:
            if name in ours:
                environment[name] = f"/root/{name.lower()}.crt"
                shutil.copyfile(ours[name], folder / environment[name].lstrip("/"))
        return cls(folder, environment)

    def start(self, line: str, within: str, log: Path) -> subprocess.Popen[bytes]:
        """Start a shell's line in the folder ``within``; `end` ends it with all that it starts."""
        spaces = ["unshare", "--mount", "--pid", "--fork", "--kill-child=SIGKILL"]
        command = [*spaces, "sh", "-c", _ENTER, str(self.folder), within, line]
        with log.open("ab") as out:
            return subprocess.Popen(
                command, env=dict(self.environment), stdin=subprocess.DEVNULL, stdout=out, stderr=subprocess.STDOUT
            )

    def run(self, line: str, within: str, log: Path, timeout: float) -> None:
        """Run a shell's line to its end. Raises BenchmarkError with the log's end when it fails or takes longer."""
        process = self.start(line, within, log)
        try:
            status = process.wait(timeout)
        except subprocess.TimeoutExpired:
            raise BenchmarkError(f"{line}: no end within {timeout:.0f} s\n{tail(log)}") from None
        finally:
            end(process)
        if status != 0:
            raise BenchmarkError(f"{line}: status {status}\n{tail(log)}")


def end(process: subprocess.Popen[bytes]) -> None:
    """End what `BareRoot.start` started: the root's processes end with the first of them."""
    if process.poll() is None:
        process.send_signal(signal.SIGKILL)
        process.wait(_END_S)


def tail(log: Path, lines: int = 20) -> str:
    """Return the last lines of a log."""
    return "\n".join(log.read_text(encoding="utf-8", errors="replace").splitlines()[-lines:])
