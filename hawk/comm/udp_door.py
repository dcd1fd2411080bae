"""The UDP socket of a MAVLink link: bytes between MAVSDK's ``raw://`` connection and the autopilot.

MAVSDK's own UDP connections forget a peer that is silent for 10 s, and send heartbeats as they like. Here the address
of an autopilot is kept, so that commands still go out when nothing comes in, and heartbeats can be held back.
"""

from __future__ import annotations

import logging
import socket
import threading
from collections.abc import Callable, Mapping
from typing import Any, Final
from urllib.parse import urlsplit

from hawk.comm.passive_listener import heartbeats

_LOG = logging.getLogger(__name__)

PEERS: Final = 4
"""Autopilots' addresses that are kept, the newest ones."""
_WAKE_S: Final = 0.2
_JOIN_S: Final = 2.0
_DATAGRAM: Final = 65536
_NOT_AN_AUTOPILOT: Final = 8  # MAV_AUTOPILOT_INVALID: ground stations, cameras
_HEARTBEAT: Final = 0  # message id
_IDS: Final[Mapping[int, slice]] = {0xFE: slice(5, 6), 0xFD: slice(7, 10)}
"""Bytes of the message id in a frame, by its first byte (MAVLink 1 and 2)."""

Address = tuple[Any, ...]


def is_udp(url: str) -> bool:
    """Return True for the URLs that a door can open."""
    return urlsplit(url).scheme in ("udpin", "udpout")


def is_heartbeat(frame: bytes) -> bool:
    """Return True when one whole MAVLink frame is a HEARTBEAT."""
    place = _IDS.get(frame[0]) if frame else None
    return place is not None and int.from_bytes(frame[place], "little") == _HEARTBEAT


class UdpDoor:
    """``udpin://HOST:PORT`` listens there and answers every autopilot heard; ``udpout://HOST:PORT`` talks to one."""

    def __init__(self, url: str, deliver: Callable[[bytes], None]) -> None:
        """Open the socket and begin to receive.

        Args:
            url: ``udpin://`` or ``udpout://`` with host and port.
            deliver: Receives each datagram, on the door's thread.

        Raises:
            OSError: The address cannot be resolved, or is in use.
        """
        place = urlsplit(url)
        self._deliver = deliver
        self._listens = place.scheme == "udpin"
        found = socket.getaddrinfo(place.hostname or "0.0.0.0", place.port, type=socket.SOCK_DGRAM)  # noqa: S104
        family, *_, address = found[0]
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        self._socket.settimeout(_WAKE_S)
        self._peers: tuple[Address, ...] = () if self._listens else (address,)
        try:
            if self._listens:
                self._socket.bind(address)
        except OSError:
            self._socket.close()
            raise
        self.speaks = True
        """False: our heartbeats are held back; everything else still goes out."""
        self.held_back = 0
        """Heartbeats that were held back."""
        self._closed = False
        self._complained = False
        self._thread = threading.Thread(target=self._receive, name="autopilot-udp", daemon=True)
        if not self._listens:
            self._socket.bind(("::" if family == socket.AF_INET6 else "0.0.0.0", 0))  # noqa: S104 - any free port
        self._thread.start()

    def send(self, frame: bytes) -> None:
        """Send one frame to the autopilot. Never blocks; a frame that the system does not take is dropped."""
        if self._closed:
            return
        if not self.speaks and is_heartbeat(frame):
            self.held_back += 1
            return
        for peer in self._peers:
            try:
                self._socket.sendto(frame, socket.MSG_DONTWAIT, peer)
            except OSError as error:
                if not self._complained:
                    _LOG.warning("A message to %s was not sent: %s", peer, error)
                self._complained = True

    def close(self) -> bool:
        """Stop receiving; return False when the thread does not end, because `deliver` does not return."""
        self._closed = True
        self._thread.join(_JOIN_S)
        if self._thread.is_alive():
            return False
        self._socket.close()
        return True

    def _receive(self) -> None:
        while not self._closed:
            try:
                data, sender = self._socket.recvfrom(_DATAGRAM)
            except TimeoutError:
                continue
            except OSError:  # an earlier message met a closed port
                continue
            if self._listens and sender not in self._peers:
                self._meet(sender, data)
            try:
                self._deliver(data)
            except Exception:  # the next one may be better
                _LOG.exception("A datagram of %s could not be handled", sender)

    def _meet(self, sender: Address, data: bytes) -> None:
        """Answer a sender from now on, once it has said that it is an autopilot."""
        if any(autopilot != _NOT_AN_AUTOPILOT for autopilot, _ in heartbeats(data)):
            self._peers = (*self._peers, sender)[-PEERS:]
            self._complained = False
