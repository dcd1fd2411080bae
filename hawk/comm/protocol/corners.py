"""Rings of corners in messages: their length, as the autopilot's fence allows it."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from hawk.comm.protocol.heartbeat import FenceCorner

LEAST_CORNERS = 3
MOST_CORNERS = 69
"""Corners of a fence without zones that ArduCopter stores on boards with 16 kB for parameters."""

Corners = Annotated[list[FenceCorner], Field(min_length=LEAST_CORNERS, max_length=MOST_CORNERS)]
"""Corners in order, not closed."""
