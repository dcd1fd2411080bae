"""A gate between MAVSDK and a UDP port: it passes the autopilot's datagrams and nobody else's.

MAVSDK 4.1 believes every sender that reaches its port, and answers all of them; its ``udpout`` listens on every
interface. So MAVSDK gets a port of the loopback, and the port that the settings name is opened here, twice: the *line*
is connected to the kept sender, so the kernel itself drops every other one; the *hall* gets the others, in a buffer of
its own, and is read slowly, so that a flood costs the autopilot's datagrams neither room nor time. The thread needs
neither the event loop nor another thread of hawk, so Kill passes while they hang.
"""

from __future__ import annotations

import contextlib
import functools
import logging
import math
import select
import socket
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final, TypeVar
from urllib.parse import urlsplit

from hawk.comm.mavlink.frames import is_heartbeat, is_mavlink_1
from hawk.comm.mavlink.peer import PeerKeeper, address_text

_LOG = logging.getLogger(__name__)
_LOOPBACK: Final = "127.0.0.1"
_LARGEST: Final = 65535
_BATCH: Final = 64
"""Datagrams of one socket that are passed before the others are looked at."""
_HALL_S: Final = 0.05
"""Real seconds in which at most a batch is taken from the hall: 1280 strange datagrams a second."""
_GREET_S: Final = 1.0
_JOIN_S: Final = 2.0
_ATTEMPTS: Final = 5
T = TypeVar("T")
_KINDS: Final = ("udpin", "udpout")


@dataclass(frozen=True, slots=True)
class Hearing:
    """Senders on the link. Addresses are empty where no gate is needed (serial, TCP)."""

    sender: str = ""
    """Address of the kept sender."""
    second_sender: str = ""
    """Words for another sender while it is heard."""
    refused: int = 0
    """Datagrams that were not passed; those that the kernel dropped are not counted."""
    is_mavlink_1: bool | None = None
    """The autopilot sends MAVLink 1; None where that is not known."""
    heard: str = ""
    """Systems that give signs of life, in words."""
    other_vehicles: str = ""
    """Other copters on the link, in words; their messages are dropped."""


NOBODY: Final = Hearing()


class UdpGate:
    """One UDP port (``udpin``) or one UDP address (``udpout``), and MAVSDK's port of the loopback."""

    def __init__(
        self,
        url: str,
        keeper: PeerKeeper,
        greeting: bytes,
        monotonic: Callable[[], float] = time.monotonic,
        overhear: Callable[[bytes], object] = len,
    ) -> None:
        """Open the port and start the thread. Raises OSError, and ValueError for a URL without host and port.

        ``greeting``: a MAVLink frame that is no autopilot's. MAVSDK sends to those it heard in the last 10 s. It gets
        the greeting while nobody else speaks, so that a command can go out on a link that hears nothing. ``overhear``
        gets each datagram of the kept sender, on the gate's thread, once it was passed.
        """
        self._keeper = keeper
        self.speaks = True
        """False: our heartbeats are held back, so that the autopilot misses them; everything else still goes out."""
        self.held_back = 0
        """Heartbeats that were held back."""
        self._greeting = greeting
        self._monotonic = monotonic
        self._overhear = overhear
        scheme, self._family, self._place = _resolve(url)
        self._inside = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._inside.setblocking(False)
        self._inside.bind((_LOOPBACK, 0))
        self._hall: socket.socket | None = None
        self._line: socket.socket | None = None
        try:
            if scheme == "udpin":
                self._hall = self._socket()
                self._hall.bind(self._place)
            else:
                self._line = self._socket()
                self._line.connect(self._place)
                self._keeper.kept = self._place[:2]
        except OSError:
            self._close_sockets()
            raise
        self._period, self._in_period = -math.inf, 0
        self._hall_from = -math.inf
        self._fed_at = -math.inf
        self._is_mavlink_1: bool | None = None
        self._kept: Any = None  # socket address of the kept sender
        self._ending, self._end = socket.socketpair()
        self._thread = threading.Thread(target=self._run, name="autopilot-gate", daemon=True)
        self._thread.start()

    def attach(self, add_connection: Callable[[str], T]) -> T:
        """Open a connection of MAVSDK to this gate; raises what ``add_connection`` (URL) raises."""
        for attempts_left in reversed(range(_ATTEMPTS)):
            port = _free_port()
            try:
                connection = add_connection(f"udpin://{_LOOPBACK}:{port}")
            except Exception:
                if not attempts_left:
                    raise
                continue  # another program took the port meanwhile
            self._inside.connect((_LOOPBACK, port))
            _send(self._inside, self._greeting)
            return connection
        raise AssertionError

    @property
    def system_id(self) -> int | None:
        """The autopilot's system id; None before it is heard, and where any is taken."""
        return self._keeper.system_id

    @property
    def hearing(self) -> Hearing:
        """Senders now. Callable on any thread."""
        kept = self._keeper.kept
        return Hearing(
            "" if kept is None else address_text(kept),
            self._keeper.second_sender(self._monotonic()),
            self._keeper.refused,
            self._is_mavlink_1,
        )

    def close(self) -> None:
        """End the thread and close the port. Closing twice is no error."""
        with contextlib.suppress(OSError):
            self._end.send(b"\0")
        self._thread.join(_JOIN_S)
        self._close_sockets()
        self._ending.close()
        self._end.close()

    # --- the thread ------------------------------------------------------------------------------------------------

    def _run(self) -> None:
        while True:
            try:
                ready = self._wait()
                if self._ending.fileno() in ready:
                    return
                if self._line is not None and self._line.fileno() in ready:
                    self._pass(self._line, self._from_line)
                if self._inside.fileno() in ready:
                    self._pass(self._inside, self._from_mavsdk)
                if self._hall is not None and self._hall.fileno() in ready:
                    self._look_into(self._hall)
            except Exception:  # the next datagram must get through
                _LOG.exception("A datagram was not passed")
                time.sleep(_HALL_S)  # a lasting fault must not take the processor

    def _wait(self) -> set[int]:
        """Wait for datagrams; return the sockets that have some."""
        now = self._monotonic()
        if now - self._fed_at >= _GREET_S:
            self._feed(self._greeting)
        rests = self._hall_from > now
        poll = select.poll()
        for item in (self._ending, self._inside, self._line, None if rests else self._hall):
            if item is not None:
                poll.register(item, select.POLLIN)
        due = min(self._fed_at + _GREET_S, self._hall_from if rests else math.inf)
        return {number for number, _ in poll.poll((due - now) * 1000 + 1)}

    def _pass(self, source: socket.socket, take: Callable[[bytes, Any], None], most: int = _BATCH) -> int:
        """Take the datagrams that wait, a batch at most; return their number."""
        for count in range(most):
            try:
                data, sender = source.recvfrom(_LARGEST)
            except BlockingIOError:
                return count
            except OSError:  # "port unreachable" for a datagram that was sent before
                continue
            take(data, sender)
        return most

    def _from_line(self, data: bytes, sender: Any) -> None:
        if sender[:2] != self._keeper.kept:  # it came before the socket was connected
            if self._hall is not None:
                self._from_hall(self._hall, data, sender)
            return
        self._keeper.heard(self._monotonic())
        self._take(data)

    def _from_mavsdk(self, data: bytes, _: Any) -> None:
        if not self.speaks and is_heartbeat(data):
            self.held_back += 1
            return
        if self._line is not None:
            _send(self._line, data)
        elif self._hall is not None and self._kept is not None:
            with contextlib.suppress(OSError):
                self._hall.sendto(data, self._kept)

    def _look_into(self, hall: socket.socket) -> None:
        now = self._monotonic()
        if now - self._period >= _HALL_S:
            self._period, self._in_period = now, 0
        self._in_period += self._pass(hall, functools.partial(self._from_hall, hall), _BATCH - self._in_period)
        if self._in_period >= _BATCH:
            self._hall_from = self._period + _HALL_S

    def _from_hall(self, hall: socket.socket, data: bytes, sender: Any) -> None:
        before = self._keeper.kept
        if not self._keeper.admit(sender[:2], data, self._monotonic()):
            return
        if self._keeper.kept != before:
            if before is not None:
                _LOG.warning("The autopilot is heard from %s, no longer from %s", sender, before)
            self._kept = sender
            self._connect(hall)
        self._take(data)

    def _take(self, data: bytes) -> None:
        self._note_version(data)
        self._feed(data)
        self._overhear(data)

    def _note_version(self, data: bytes) -> None:
        system = self._keeper.system_id
        found = None if system is None else is_mavlink_1(data, system)
        if found is not None:
            self._is_mavlink_1 = found

    def _connect(self, hall: socket.socket) -> None:
        """Make the line to the kept sender. Without one (another kernel than Linux) the hall serves for it, too."""
        if self._line is not None:
            self._line.close()
            self._line = None
        try:
            self._line = self._line_to_kept(hall)
        except OSError as error:
            _LOG.warning("The autopilot's datagrams have no buffer of their own: %s", error)

    def _line_to_kept(self, hall: socket.socket) -> socket.socket:
        line = self._socket()
        try:
            # the port is shared for this moment only: no other program can open it beside us
            hall.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
            line.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
            line.bind(self._place)
            line.connect(self._kept)
            line.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 0)
        except OSError:
            line.close()
            raise
        finally:
            hall.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 0)
        return line

    def _feed(self, data: bytes) -> None:
        _send(self._inside, data)
        self._fed_at = self._monotonic()

    def _socket(self) -> socket.socket:
        opened = socket.socket(self._family, socket.SOCK_DGRAM)
        opened.setblocking(False)
        return opened

    def _close_sockets(self) -> None:
        for item in (self._inside, self._hall, self._line):
            if item is not None:
                item.close()


def _send(target: socket.socket, data: bytes) -> None:
    with contextlib.suppress(OSError):  # nobody listens there now, or its buffer is full: UDP loses datagrams
        try:
            target.send(data)
        except ConnectionRefusedError:  # the answer to an earlier datagram; this one was not sent
            target.send(data)


def serves(url: str) -> bool:
    """Return True for a URL that a gate serves; serial lines and TCP connections have one sender."""
    return urlsplit(url).scheme in _KINDS


def _resolve(url: str) -> tuple[str, socket.AddressFamily, Any]:
    """Return scheme, family and socket address of a UDP URL. Raises ValueError, OSError."""
    place = urlsplit(url)
    if place.scheme not in _KINDS or not place.port or not place.hostname:
        raise ValueError(f"must be {' or '.join(f'{kind}://HOST:PORT' for kind in _KINDS)}")
    found = socket.getaddrinfo(place.hostname, place.port, type=socket.SOCK_DGRAM)
    family, _, _, _, address = min(found, key=lambda entry: entry[0] != socket.AF_INET)
    return place.scheme, family, address


def _free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind((_LOOPBACK, 0))
        return int(probe.getsockname()[1])
