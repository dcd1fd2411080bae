"""Datagrams as MAVLink messages."""

from __future__ import annotations

import logging
from typing import Any

from pymavlink.dialects.v20 import ardupilotmega as mavlink

log = logging.getLogger(__name__)


class Datagrams:
    """Reads what one peer sends; what is not MAVLink is passed over."""

    def __init__(self) -> None:
        self._decoder = mavlink.MAVLink(None)
        self._decoder.robust_parsing = True

    def read(self, data: bytes) -> list[Any]:
        """Return the messages of a datagram; part of one is kept until its rest comes."""
        try:
            return self._decoder.parse_buffer(data) or []
        except mavlink.MAVError as error:
            log.debug("not MAVLink: %s", error)
            return []
