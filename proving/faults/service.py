"""The service manager's part: the daemon is started again when it ends, and killed when it gives no sign of progress.

As `packaging/systemd/hawk-drone.service` says: Restart=always, RestartSec=0, WatchdogSec=3 with SIGKILL.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import socket
from pathlib import Path

from hawk.survey.stack import SimulatedStack

WATCHDOG_S = 3.0
"""Real seconds without WATCHDOG=1 after which the daemon is killed."""
_LOOK_S = 0.02


class Service:
    """Keeps the daemon of a stack running. Use `socket_in` before the stack starts."""

    def __init__(self, stack: SimulatedStack, notify: socket.socket) -> None:
        self._stack = stack
        self._notify = notify
        self._task: asyncio.Task[None] | None = None
        self._fed: float | None = None
        self.exits: list[int] = []
        """Exit statuses of the daemon, oldest first; minus the signal where one ended it."""
        self.starts = 0
        """Starts after an end."""
        self.withheld = False
        """True: the daemon is not started again when it ends."""

    def start(self) -> None:
        """Begin to watch the stack's daemon."""
        self._task = asyncio.create_task(self._run(), name="service")

    async def stop(self) -> None:
        """Stop watching."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)
        self._notify.close()

    async def _run(self) -> None:
        clock = asyncio.get_running_loop().time
        while True:
            await asyncio.sleep(_LOOK_S)
            with contextlib.suppress(BlockingIOError):
                while data := self._notify.recv(4096):
                    if b"WATCHDOG=1" in data or b"READY=1" in data:
                        self._fed = clock()
            daemon = self._stack.daemon
            if daemon is None:
                continue
            if daemon.returncode is not None:
                if len(self.exits) <= self.starts:
                    self.exits.append(daemon.returncode)
                self._fed = None
                if self.withheld:
                    continue
                await self._stack.start_daemon()
                self.starts += 1
            elif self._fed is not None and clock() - self._fed > WATCHDOG_S:
                self._fed = None
                with contextlib.suppress(ProcessLookupError):
                    daemon.send_signal(signal.SIGKILL)


def socket_in(folder: Path) -> socket.socket:
    """Return the socket for sd_notify(3) of programs that are started from now on."""
    folder.mkdir(parents=True, exist_ok=True)
    made = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    path = folder / "notify"
    path.unlink(missing_ok=True)
    made.bind(str(path))
    made.setblocking(False)
    os.environ["NOTIFY_SOCKET"] = str(path)
    return made
