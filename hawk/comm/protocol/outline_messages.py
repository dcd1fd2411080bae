"""Messages about the outline of a survey: see `hawk.comm.protocol.commands`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationInfo, field_validator

from hawk.comm.protocol.base import Command
from hawk.comm.protocol.corners import LEAST_CORNERS, MOST_CORNERS, Corners
from hawk.comm.protocol.heartbeat import FenceCorner

MOST_OUTLINE_RINGS = 12
"""Polygons, and holes, of an outline."""
MOST_OUTLINE_CORNERS = 200
"""Corners of all polygons and holes of an outline: some 12 kB of a message."""


def outline_problem(polygons: Sequence[int], holes: Sequence[int]) -> str:
    """Return why an outline cannot have rings with these numbers of corners; empty if it can."""
    for name, rings in (("polygons", polygons), ("holes", holes)):
        if len(rings) > MOST_OUTLINE_RINGS:
            return f"an outline has at most {MOST_OUTLINE_RINGS} {name}, this one has {len(rings)}: leave some out"
    count = sum(polygons) + sum(holes)
    if count > MOST_OUTLINE_CORNERS:
        return f"an outline has at most {MOST_OUTLINE_CORNERS} corners, this one has {count}: leave some out"
    return ""


class SetOutline(Command):
    """Survey this area: the next Explore sees every place of it inside the fence, and nothing else.

    Not while it explores. Corners in order, not closed.
    """

    type: Literal["Set Outline"] = "Set Outline"
    polygons: Annotated[list[Corners], Field(min_length=1)]
    """Places in one of them belong to the outline."""
    holes: list[Corners] = Field(default_factory=list, validate_default=True)
    """Places in one of them do not."""

    @field_validator("polygons", "holes", mode="before")
    @classmethod
    def _counted(cls, value: Any, info: ValidationInfo) -> Any:
        for number, ring in enumerate(value if isinstance(value, list) else (), 1):
            if isinstance(ring, list) and not LEAST_CORNERS <= len(ring) <= MOST_CORNERS:
                name = "polygon" if info.field_name == "polygons" else "hole"
                wanted = f"{LEAST_CORNERS} to {MOST_CORNERS}"
                raise ValueError(f"{name} {number} has {len(ring)} corners: draw {wanted}")
        return value

    @field_validator("holes", mode="after")
    @classmethod
    def _together(cls, value: list[list[FenceCorner]], info: ValidationInfo) -> list[list[FenceCorner]]:
        polygons = [len(ring) for ring in info.data.get("polygons", ())]
        problem = outline_problem(polygons, [len(ring) for ring in value])
        if problem:
            raise ValueError(problem)
        return value


class ClearOutline(Command):
    """Drop the outline: the next Explore finds the lot by looking. Not while it explores."""

    type: Literal["Clear Outline"] = "Clear Outline"
