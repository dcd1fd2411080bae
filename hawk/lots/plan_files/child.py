"""Reads a stranger's file in a process of its own, with bounds on its memory and time: a flight feels none of it.

The file goes in as bytes; stalls come back as lines of JSON. A file that takes too much ends that process alone.
"""

from __future__ import annotations

import asyncio
import json
import os
import sys
from dataclasses import asdict
from typing import Any, Final

from hawk.lots.plan_files.values import Asked, FileStall, LeftOut, PlanFile
from hawk.lots.values import LotInputError

MODULE: Final = "hawk.lots.plan_files"
MEMORY_BYTES: Final = 1_200_000_000
"""Of the process's own data. A DXF of 6 MB takes 130 MB while it is read, the worst JSON of 32 MB 900 MB."""
CPU_S: Final = 120
LONGEST_S: Final = 180.0
"""Real seconds for a file on a computer that does other work."""
REFUSED: Final = 3
"""Exit status of a file that cannot be used; the output says the field and the reason."""
TOO_MUCH: Final = "takes more memory or time than a plan does: leave other layers out"
NICENESS: Final = 15


async def read_apart(data: bytes, asked: Asked, longest_s: float = LONGEST_S) -> bytes:
    """Return the stalls of a file as `packed` makes them. Raises LotInputError."""
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-m", MODULE, json.dumps(asdict(asked)),
        stdin=asyncio.subprocess.PIPE,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.DEVNULL,
        env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "PROJ_NETWORK": "OFF"},
        start_new_session=True,
    )  # fmt: skip
    try:
        async with asyncio.timeout(longest_s):
            said, _ = await process.communicate(data)
    except TimeoutError:
        raise LotInputError("file", f"takes more than {longest_s:.0f} s to read: leave other layers out") from None
    finally:
        if process.returncode is None:
            process.kill()
            await process.wait()
    if process.returncode == REFUSED:
        refusal = json.loads(said)
        raise LotInputError(refusal["field"], refusal["reason"])
    if process.returncode != 0:
        raise LotInputError("file", TOO_MUCH)
    return said


def packed(plan: PlanFile) -> bytes:
    """Return a plan as lines of JSON: the facts, then a line for each stall."""
    facts = {name: getattr(plan, name) for name in _FACTS}
    facts["left_out"] = [[each.name, each.reason] for each in plan.left_out]
    lines = [json.dumps(facts, allow_nan=False)]
    lines += [
        json.dumps([s.name, s.label, s.kind, s.north, s.east, s.angle, s.width, s.length], allow_nan=False)
        for s in plan.stalls
    ]
    return "\n".join(lines).encode()


def unpacked(data: bytes) -> PlanFile:
    """Return the plan of `packed`. Line by line: one call for all of them would hold the interpreter."""
    first, *lines = data.split(b"\n")
    facts: dict[str, Any] = json.loads(first)
    stalls = tuple(FileStall(*json.loads(line)) for line in lines)
    pairs = {name: tuple(facts[name]) for name in ("origin",)}
    datum = facts["datum"]
    return PlanFile(
        **{
            **facts,
            **pairs,
            "stalls": stalls,
            "datum": None if datum is None else (datum[0], datum[1]),
            "layers": tuple((str(name), int(count)) for name, count in facts["layers"]),
            "left_out": tuple(LeftOut(*each) for each in facts["left_out"]),
        }
    )


_FACTS: Final = ("format", "crs", "datum", "origin", "metres", "layers", "left_out_count", "accuracy")
