"""Ends a process whose state machine makes no progress, and tells systemd that it does.

MAVSDK's own threads keep talking to the autopilot when the Python loop hangs, so a hung process would hide from the
autopilot's failsafes: it has to die. The timer is `faulthandler`'s, a C thread that needs no GIL.
"""

from __future__ import annotations

import faulthandler
import os
import socket
from collections.abc import Mapping
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


class Watchdog:
    """Ends this process ``timeout_s`` real seconds after the last `progress`; every stack goes to ``stream``."""

    def __init__(self, timeout_s: float, notifier: SystemdNotifier, stream: TextIO, enabled: bool = True) -> None:
        self._timeout = timeout_s
        self._notifier = notifier
        self._stream = stream
        self._enabled = enabled

    def progress(self) -> None:
        """Say that the state machine has ticked: both watchdogs start anew."""
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
