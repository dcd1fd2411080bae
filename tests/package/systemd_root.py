"""A clean Debian root in which systemd runs, in process, mount and network spaces of its own."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from proving.bare_root import CLEAN
from tests.package.clean_root import CALM, CleanRoot, printed

BOOT_S = 300.0
"""Real seconds, on a busy machine."""
BOOT = """
set -e
ip link set lo up
mount --bind "$0" "$0"
mount --bind "$0/dev" "$0/dev"  # else systemd mounts devtmpfs, which is the same everywhere: this machine's
mount -t proc proc "$0/proc"
mount -t sysfs -o ro sysfs "$0/sys"
mount -t cgroup2 cgroup2 "$0/sys/fs/cgroup"
mount -t tmpfs -o mode=0755 tmpfs "$0/run"
cd "$0"
mkdir -p old
pivot_root . old  # a process in a chroot may make no user namespace, as PrivateUsers= does
exec chroot . sh -c 'umount -l /old; exec env container=hawk-test /lib/systemd/systemd --unit=multi-user.target'
"""
SPACES = ("--mount", "--pid", "--net", "--uts", "--ipc", "--cgroup")
LOOK = """\
#!/usr/bin/python3
# May this unit open a serial port of the group dialout, and not one of root's?
import os, sys

def may_open(name):
    try:
        os.close(os.open(name, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK))
    except PermissionError:
        return False
    except OSError:  # there is no such hardware
        pass
    return True

sys.exit(not may_open("/dev/ttyS0") or may_open("/dev/ttyS1"))
"""
UNTIMED = """\
[Service]
ExecStartPre=/usr/local/bin/look
# A machine that others share may stop for seconds; here nothing flies.
WatchdogSec=0
TimeoutStartSec=300
Environment=HAWK_WATCHDOG__ENABLED=false
"""


class NoSystemdError(Exception):
    """systemd does not run here; the text has the reason."""


@dataclass(frozen=True, slots=True)
class SystemdRoot:
    """A booted root; ``init`` is its systemd's process as it is known here."""

    root: CleanRoot
    init: int

    def run(self, *arguments: str, fails: bool = False, timeout: float = 900) -> str:
        """Run a command under its systemd; return what it printed. Its status must be 0, or another if it ``fails``."""
        enter = ["nsenter", f"--target={self.init}", *SPACES]
        return printed([*CALM, *enter, *arguments], CLEAN, fails=fails, timeout=timeout)

    def shown(self, name: str) -> str:
        """Return a property of the unit (systemctl show)."""
        return self.run("systemctl", "show", f"--property={name}", "--value", "hawk-drone").strip()


@contextmanager
def booted(root: CleanRoot) -> Iterator[SystemdRoot]:
    """Boot a root; it ends with the block. Raises NoSystemdError where the machine does not allow it."""
    drop_in = root.path("/etc/systemd/system/hawk-drone.service.d/untimed.conf")
    drop_in.parent.mkdir(parents=True)
    drop_in.write_text(UNTIMED)
    look = root.path("/usr/local/bin/look")
    look.write_text(LOOK)
    look.chmod(0o755)
    for minor, group in ((64, "dialout"), (65, "root")):
        root.run("mknod", "--mode=0660", f"/dev/ttyS{minor - 64}", "c", "4", str(minor))
        root.run("chgrp", group, f"/dev/ttyS{minor - 64}")
    command = [*CALM, "unshare", *SPACES, "--fork", "--kill-child=SIGKILL", "sh", "-c", BOOT, str(root.folder)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    try:
        yield SystemdRoot(root, _wait_until_it_runs(process, root.folder))
    finally:
        process.kill()
        process.communicate(timeout=60)


def _wait_until_it_runs(process: subprocess.Popen[str], folder: Path) -> int:
    until = time.monotonic() + BOOT_S
    while time.monotonic() < until:
        if process.poll() is not None:
            raise NoSystemdError(f"it ended: {process.communicate()[0].strip()}")
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
        if children:
            looked = SystemdRoot(CleanRoot(folder), int(children[0]))
            try:
                looked.run("systemctl", "is-active", "multi-user.target", timeout=30)
            except (AssertionError, subprocess.TimeoutExpired):
                pass
            else:
                return looked.init
        time.sleep(0.5)
    raise NoSystemdError(f"it was not up within {BOOT_S:g} s")
