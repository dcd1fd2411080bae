"""Base classes of every message, and the numbers in them."""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field


def wire_key(name: str) -> str:
    """Return the JSON key of a field: its words capitalised, "pose_age" → "Pose Age"."""
    return " ".join(word.capitalize() for word in name.split("_"))


def _none_unless_finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


Finite = Annotated[float, Field(allow_inf_nan=False)]
Known = Annotated[float | None, BeforeValidator(_none_unless_finite)]
"""A number, or None when it is not known: NaN and infinity become None."""
Metres = Annotated[float, Field(allow_inf_nan=False, ge=-10_000.0, le=10_000.0)]
Height = Annotated[float, Field(allow_inf_nan=False, gt=0.0, le=1_000.0)]


class Model(BaseModel):
    """Strict base: unknown keys are errors, numbers are numbers, every key is spelled by `wire_key`."""

    model_config = ConfigDict(extra="forbid", strict=True, populate_by_name=True, frozen=True, alias_generator=wire_key)


class Command(Model):
    """Base of the operator's messages; ``Id`` comes back in the Ack."""

    type: str
    id: Annotated[str, Field(max_length=64)] | int | None = None


class Outgoing(Model):
    """Base of the drone's messages."""

    def to_json(self) -> str:
        """Return the message as JSON."""
        return self.model_dump_json(by_alias=True)
