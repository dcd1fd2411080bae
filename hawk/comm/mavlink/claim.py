"""One daemon an autopilot: the first says who it is to the next one on this computer.

A serial line can be opened twice, and a TCP or UDP router serves many: two daemons would then command one drone. The
first holds an abstract Unix socket (unix(7)) that is named after the autopilot's address. The kernel ends it with the
process, however that ends; it needs no file, and every user of this computer finds it.
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import json
import logging
import os
import re
import socket
import struct
import threading
from importlib.metadata import version
from typing import Any, Final
from urllib.parse import urlsplit

_LOG = logging.getLogger(__name__)

_SERIAL: Final = re.compile(r"serial(?:_flowcontrol)?://(?P<device>[^:]+)(?::\d+)?")
_ANSWER_S: Final = 0.5
"""Real seconds for the first one's answer."""
_LONGEST: Final = 1000
_CREDENTIALS: Final = struct.Struct("3i")  # struct ucred: process, user, group


class ClaimedError(Exception):
    """Another program of this computer has the autopilot; the text names it."""


class Claim:
    """A claim on the autopilot of an address, from `take` to `release`."""

    def __init__(self, url: str) -> None:
        """``url``: MAVSDK's connection URL."""
        digest = hashlib.sha256(place_of(url).encode()).hexdigest()
        self._name = f"\0hawk-drone/autopilot/{digest[:32]}"
        self._socket: socket.socket | None = None
        self._thread: threading.Thread | None = None
        self._answer = json.dumps({"version": version("hawk-drone")}).encode()

    def take(self) -> None:
        """Claim it; taken twice is no error. Raises ClaimedError. Without such sockets nothing is claimed."""
        if self._socket is not None:
            return
        made = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            made.bind(self._name)
            made.listen()
        except OSError as error:
            made.close()
            if error.errno == errno.EADDRINUSE:
                raise ClaimedError(f"in use by {self._first()}") from error
            _LOG.warning("The autopilot's address cannot be claimed: %s", error)
            return
        self._socket = made
        self._thread = threading.Thread(target=self._serve, args=(made,), name="autopilot-claim", daemon=True)
        self._thread.start()

    def release(self) -> None:
        """Release it. Released twice is no error."""
        made, self._socket = self._socket, None
        if made is not None and self._thread is not None:
            with contextlib.suppress(OSError):
                made.shutdown(socket.SHUT_RDWR)  # wakes the thread
            self._thread.join(_ANSWER_S)  # while it waits in the kernel, the name is in use
            made.close()

    def _serve(self, made: socket.socket) -> None:
        """Answer everybody who asks, until the socket is closed."""
        while True:
            try:
                asker, _ = made.accept()
            except OSError:
                return
            with asker, contextlib.suppress(OSError):
                asker.settimeout(_ANSWER_S)
                asker.sendall(self._answer)

    def _first(self) -> str:
        """Return words for the one that has it: by its answer, else by the kernel's word on the socket."""
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as asked:
            asked.settimeout(_ANSWER_S)
            try:
                asked.connect(self._name)
                size = _CREDENTIALS.size
                process, _, _ = _CREDENTIALS.unpack(asked.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, size))
            except OSError:
                return "another hawk-drone"
            try:
                said: Any = json.loads(asked.recv(_LONGEST))
                number = str(said["version"])
            except (OSError, ValueError, KeyError, TypeError):
                return f"another hawk-drone (process {process})"
        return f"another hawk-drone (process {process}, version {number})"


def device_of(url: str) -> str | None:
    """Return the device of a serial URL, links followed; None for another kind."""
    found = _SERIAL.fullmatch(url)
    return None if found is None else os.path.realpath(found["device"])


def place_of(url: str) -> str:
    """Return one name for all spellings of an autopilot's address."""
    device = device_of(url)
    if device is not None:
        return device
    parts = urlsplit(url)
    return f"{parts.scheme}://{(parts.hostname or '').lower()}:{url.rpartition(':')[2]}"
