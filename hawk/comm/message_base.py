"""What all messages between drone and operator are made of."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

Finite = Annotated[float, Field(allow_inf_nan=False)]
Metres = Annotated[float, Field(allow_inf_nan=False, ge=-10_000.0, le=10_000.0)]
Height = Annotated[float, Field(allow_inf_nan=False, gt=0.0, le=1_000.0)]


class Model(BaseModel):
    """Strict base: unknown keys are errors, numbers are numbers."""

    model_config = ConfigDict(extra="forbid", strict=True, populate_by_name=True, frozen=True)


class Command(Model):
    """Common part of everything an operator sends; ``Id`` comes back in the Ack."""

    id: Annotated[str, Field(max_length=64)] | int | None = Field(default=None, alias="Id")


class Outgoing(Model):
    """Base of what the drone sends."""

    def to_json(self) -> str:
        """Return the message as JSON with the specification's keys."""
        return self.model_dump_json(by_alias=True)
