"""Ends a process whose state machine makes no progress, and tells systemd that it does.

MAVSDK's own threads keep talking to the autopilot when the Python loop hangs, so a hung process would hide from the
autopilot's failsafes: it has to die. The timer is `faulthandler`'s, a C thread that needs no GIL.
"""

from __future__ import annotations

import faulthandler
import math
import os
import socket
import time
from collections.abc import Callable, Mapping
from typing import TextIO


class SystemdNotifier:
    """The sd_notify protocol (man 3 sd_notify): datagrams to the socket that systemd names in NOTIFY_SOCKET."""

    def __init__(self, environment: Mapping[str, str] = os.environ) -> None:
        address = environment.get("NOTIFY_SOCKET", "")
        self._address = "\0" + address[1:] if address.startswith("@") else address
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC) if address else None
        if self._socket is not None:
            self._socket.setblocking(False)

    def notify(self, message: str) -> None:
        """Send one assignment such as ``READY=1``; without systemd nothing happens."""
        if self._socket is None:
            return
        try:
            self._socket.sendto(message.encode(), self._address)
        except OSError:
            # systemd's queue may be full for a moment; the next progress repeats it
            return

    def close(self) -> None:
        """Close the socket."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None


PACE = 0.2
"""Share of the timeout after which a sign of progress is passed on again: `faulthandler` ends and starts a thread each
time, which on a busy machine takes the loop up to tens of milliseconds."""


class Watchdog:
    """Ends this process ``timeout_s`` to 1.2 ``timeout_s`` real seconds after the last `progress`.

    Every stack goes to ``stream``.
    """

    def __init__(
        self,
        timeout_s: float,
        notifier: SystemdNotifier,
        stream: TextIO,
        enabled: bool = True,
        monotonic: Callable[[], float] = time.monotonic,
    ) -> None:
        self._timeout = timeout_s * (1 + PACE)
        self._pace = timeout_s * PACE
        self._notifier = notifier
        self._stream = stream
        self._enabled = enabled
        self._monotonic = monotonic
        self._due = -math.inf

    def progress(self) -> None:
        """Say that the state machine has ticked: both watchdogs start anew, as seldom as is safe."""
        now = self._monotonic()
        if now < self._due:
            return
        self._due = now + self._pace
        if self._enabled:
            faulthandler.dump_traceback_later(self._timeout, exit=True, file=self._stream)
        self._notifier.notify("WATCHDOG=1")

    def ready(self) -> None:
        """Tell systemd that the daemon runs."""
        self._notifier.notify("READY=1")

    def stop(self) -> None:
        """Disarm at an orderly end."""
        if self._enabled:
            faulthandler.cancel_dump_traceback_later()
        self._notifier.notify("STOPPING=1")
        self._notifier.close()
