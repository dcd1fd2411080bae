"""Reads a stranger's plan in the box (`hawk.formats.box`): a flight feels none of it.

The file goes in as bytes; stalls come back as lines of JSON. A file that takes too much ends that process alone.
"""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from hawk.formats.box import PLANS, Limits, RefusedError
from hawk.formats.box import read_apart as apart
from hawk.lots.plan_files.values import Asked, FileFeature, FileSection, LeftOut, PlanFile, SectionFacts
from hawk.lots.values import LotInputError
from hawk.runtime.late import late

if TYPE_CHECKING:  # half of the start of the process that reads
    from hawk.lots.plan_files import formats
else:
    formats = late("hawk.lots.plan_files.formats")

READER: Final = "hawk.lots.plan_files.child:read"


async def read_apart(data: bytes, asked: Asked, limits: Limits = PLANS, *, log: Path | None = None) -> bytes:
    """Return the stalls of a file as `packed` makes them. Raises LotInputError.

    ``log``: the file beside a GeoPackage in which a program that has it open keeps its newest stalls.
    """
    try:
        return await apart(READER, data, {"asked": asdict(asked), "log": None if log is None else str(log)}, limits)
    except RefusedError as error:
        raise LotInputError(error.field, error.reason) from None


def read(data: bytes, asked: dict[str, Any]) -> bytes:
    """Return the stalls of a file, in the box. Raises LotInputError, OSError."""
    log = b"" if asked["log"] is None else Path(asked["log"]).read_bytes()
    return packed(formats.read_plan(data, Asked(**asked["asked"]), log))


def packed(plan: PlanFile) -> bytes:
    """Return a plan as lines of JSON: the facts, then a line for each stall and each section."""
    facts = {name: getattr(plan, name) for name in _FACTS}
    facts["left_out"] = [[each.name, each.reason] for each in plan.left_out]
    lines = [json.dumps(facts, allow_nan=False)]
    lines += [
        json.dumps([s.name, s.label, s.kind, s.north, s.east, s.angle, s.width, s.length], allow_nan=False)
        for s in plan.stalls
    ]
    lines += [json.dumps(asdict(each), allow_nan=False) for each in plan.sections]
    return "\n".join(lines).encode()


def unpacked(data: bytes) -> PlanFile:
    """Return the plan of `packed`. Line by line: one call for all of them would hold the interpreter."""
    first, *lines = data.split(b"\n")
    facts: dict[str, Any] = json.loads(first)
    parts = [json.loads(line) for line in lines]
    pairs = {name: tuple(facts[name]) for name in ("origin",)}
    datum = facts["datum"]
    return PlanFile(
        **{
            **facts,
            **pairs,
            "stalls": tuple(FileFeature(*each) for each in parts if isinstance(each, list)),
            "sections": tuple(_section(each) for each in parts if isinstance(each, dict)),
            "datum": None if datum is None else (datum[0], datum[1]),
            "layers": tuple((str(name), int(count)) for name, count in facts["layers"]),
            "left_out": tuple(LeftOut(*each) for each in facts["left_out"]),
            "assumed": tuple(facts["assumed"]),
        }
    )


def _section(said: dict[str, Any]) -> FileSection:
    ring = tuple((float(north), float(east)) for north, east in said["ring"])
    return FileSection(said["name"], ring, said["length_m"], SectionFacts(**said["facts"]))


_FACTS: Final = ("format", "crs", "datum", "origin", "metres", "layers", "left_out_count", "accuracy", "assumed")
