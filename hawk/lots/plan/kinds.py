"""Kinds of stalls: OpenStreetMap's values of ``parking_space`` (https://wiki.openstreetmap.org/wiki/Key:parking_space)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Final

from pydantic import AfterValidator, WithJsonSchema

KINDS: Final[Mapping[str, str]] = {
    "": "normal",
    "disabled": "disabled persons",
    "charging": "electric vehicles that charge",
    "parent": "parents with children",
    "delivery": "loading and unloading",
    "private": "reserved",
    "motorcycle": "motorcycles",
    "staff": "staff",
    "bus": "buses",
    "hgv": "lorries",
    "taxi": "taxis that wait",
}
"""OSM's value -> whom the stall is for. OSM's ``normal`` is "" here, and ``trailer`` has no clear meaning there."""
MEANT: Final = {"electric": "charging", "ev": "charging", "loading": "delivery", "reserved": "private"} | {
    "handicapped": "disabled",
    "family": "parent",
    "truck": "hgv",
}
"""Words that people write -> OSM's value."""


def _known(kind: str) -> str:
    if kind in KINDS:
        return kind
    meant = '""' if kind.lower() == "normal" else MEANT.get(kind.lower())
    if meant is not None:
        raise ValueError(f"is called {meant} in OpenStreetMap: write that")
    raise ValueError(f'is no kind: write one of {", ".join(filter(None, KINDS))}, or "" for a normal stall')


Kind = Annotated[str, AfterValidator(_known), WithJsonSchema({"type": "string", "enum": list(KINDS)})]
"""A kind of `KINDS`."""
