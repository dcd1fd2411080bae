"""Messages about the fence. Its corners are WGS-84: a fence outlives the map in which it was drawn."""

from __future__ import annotations

from typing import Annotated, Any, Final, Literal

from pydantic import Field, field_validator

from hawk.comm.message_base import Command, Finite, Height, Model, Outgoing

LEAST_CORNERS: Final = 3
MOST_CORNERS: Final = 70
"""ArduPilot keeps at least so many corners of a polygon on every board."""


class FenceCorner(Model):
    """A corner of a fence, WGS-84 degrees."""

    latitude: Annotated[float, Field(allow_inf_nan=False, ge=-90.0, le=90.0)] = Field(alias="Latitude")
    longitude: Annotated[float, Field(allow_inf_nan=False, ge=-180.0, le=180.0)] = Field(alias="Longitude")


Corners = Annotated[list[FenceCorner], Field(min_length=LEAST_CORNERS, max_length=MOST_CORNERS)]


class _Fence(Command):
    corners: Corners = Field(alias="Corners")
    """In order around the fence, not closed: the autopilot's limit, ours lies inside it by the margin."""
    ceiling: Height = Field(alias="Ceiling")
    """The autopilot's, metres above the arm place; ours lies below it by the margin."""

    @field_validator("corners", mode="before")
    @classmethod
    def _counted(cls, value: Any) -> Any:
        if isinstance(value, list) and not LEAST_CORNERS <= len(value) <= MOST_CORNERS:
            wanted = f"{LEAST_CORNERS} to {MOST_CORNERS} corners"
            raise ValueError(f"a fence has {wanted}, this one has {len(value)}: add some or leave some out")
        return value


class SetFence(_Fence):
    """Keep this fence: the next Arm uploads it and puts it in force. On the ground only."""

    type: Literal["Set Fence"] = Field(default="Set Fence", alias="Type")


class ClearFence(Command):
    """Put the drawn fence aside: the configured file or circle counts again. On the ground only."""

    type: Literal["Clear Fence"] = Field(default="Clear Fence", alias="Type")


class CheckFence(_Fence):
    """Ask what would be said about this fence (answered by FenceCheck); changes nothing and needs no control."""

    type: Literal["Check Fence"] = Field(default="Check Fence", alias="Type")


class FenceCheck(Outgoing):
    """What speaks against a fence, and what the drone would make of it."""

    type: Literal["Fence Check"] = Field(default="Fence Check", alias="Type")
    id: str | int | None = Field(alias="Id")
    problem: str = Field(alias="Problem")
    """Why it cannot be kept; empty when it can."""
    notes: list[str] = Field(alias="Notes")
    """What would speak against flying in it from where the drone stands."""
    inner: list[FenceCorner] = Field(alias="Inner")
    """Our own limit; empty when there is none."""
    north_south: Finite | None = Field(alias="North South")
    east_west: Finite | None = Field(alias="East West")
    """Extent, metres."""
    area: Finite | None = Field(alias="Area")
    """Square metres inside the autopilot's limit."""


class FenceSetup(Outgoing):
    """Which fence the next Arm puts in force."""

    source: Literal["drawn", "file", "circle"] = Field(alias="Source")
    """Drawn or imported by an operator; the configured file; the configured circle around the arm place."""
    corners: list[FenceCorner] = Field(alias="Corners")
    """The autopilot's limit; empty for a circle."""
    inner: list[FenceCorner] = Field(alias="Inner")
    """Our own limit; empty for a circle."""
    radius: Finite | None = Field(alias="Radius")
    """Of a circle, metres."""
    ceiling: Finite = Field(alias="Ceiling")
    """The autopilot's, metres above the arm place."""
    margin: Finite = Field(alias="Margin")
    """So far ours lies inside, metres."""
    ceiling_margin: Finite = Field(alias="Ceiling Margin")
    highest_ceiling: Finite = Field(alias="Highest Ceiling")
    """No fence may be higher, metres."""
    problem: str = Field(alias="Problem")
    """Why the fence that was kept cannot be used: no Arm until it is drawn again or put aside; else empty."""
