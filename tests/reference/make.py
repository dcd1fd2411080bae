"""Flies the simulated drone, and keeps its recordings as references (`tests.reference.kept`).

``python -m tests.reference.make NAME``: ``survey`` explores a drawn lot for some seconds, with small pictures;
``survey-map`` processes its pictures again and keeps the map; ``faults`` are five faults of one flight;
``battery-swap`` are two flights of one survey, with a battery swap between. The last two keep what decisions are made
of, and no pictures. Each takes one to four minutes. The SHA-256 that it prints belongs into `tests.reference.kept`.
"""

from __future__ import annotations

import argparse
import asyncio
import io
import json
import os
import signal
import sys
import tempfile
from collections.abc import Awaitable, Callable, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

from mcap.exceptions import EndOfFile
from mcap.records import Channel, DataEnd, Message, Metadata, Schema
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, IndexType, Writer

from hawk.comm.protocol.commands import AutonomousExplore
from hawk.ddc.recorder import COMMAND, DECISION, LEAVE, MEMORY, TICK
from hawk.model.operation import StateName
from hawk.replay.flight import RecordedFlight
from hawk.replay.process import Again, process
from hawk.results.survey_map import recorded_geojson
from hawk.sim.launch import SimulationAddress, SimulationError, SimulationOptions, end_process, free_udp_port
from hawk.store.replay import is_whole
from hawk.survey.stack import SimulatedStack
from proving.faults.report import names
from proving.faults.rig import Rig
from proving.faults.run import ALL, SHORT
from tests.integration.daemon_support import Operator, operator, write_settings
from tests.integration.sim_support import small_picture
from tests.reference.kept import FOLDER, MAP, machine, pack, unpack

SETTINGS: Final = """
[heights]
minimum_m = 15.0
desired_m = 20.0
maximum_m = 25.0
"""
EXPLORED_S: Final = 14.0
"""Time of exploring in each flight, the drone's seconds."""
LOW_PERCENT: Final = 20.0
"""Charge with which the drone comes home by itself."""
OVER_LOT: Final = SimulationOptions(seed=3, start="56,49", camera_rate=1.0)
DECIDED: Final = frozenset({TICK, COMMAND, LEAVE, DECISION, MEMORY})
"""Topics that decisions are made of."""
_STOP_S: Final = 12.0


class SmallCamera:
    """hawk-sim with small pictures, as `hawk.survey.stack` takes a drone."""

    def __init__(self, options: SimulationOptions) -> None:
        self._options = options
        self._process: asyncio.subprocess.Process | None = None

    async def start(self, log: int | None = None) -> SimulationAddress:
        """Start it and wait until it is ready. Raises SimulationError."""
        port = free_udp_port()
        self._process = await asyncio.create_subprocess_exec(
            sys.executable, "-m", "tests.reference.small_camera", *self._options.arguments(),
            f"--mavlink=udpout:127.0.0.1:{port}", "--http=127.0.0.1:0", f"--parent-pid={os.getpid()}",
            stdout=asyncio.subprocess.PIPE, stderr=log,
        )  # fmt: skip
        assert self._process.stdout is not None
        async for line in self._process.stdout:
            if line.startswith(b"{"):
                return SimulationAddress(json.loads(line)["http"].rstrip("/"), f"udpin://127.0.0.1:{port}")
        raise SimulationError("hawk-sim ended before it was ready")

    async def stop(self) -> None:
        """End it."""
        if self._process is not None:
            await end_process(self._process, _STOP_S)


async def fly_survey(folder: Path) -> dict[str, bytes]:
    """Explore for some seconds and come home."""
    stack = SimulatedStack(OVER_LOT, folder, write_settings(folder, SETTINGS), None, drone=SmallCamera(OVER_LOT))
    try:
        async with operator((await stack.start()).url) as pilot:
            await explore(pilot)
            await pilot.come_home()
        await end_in_order(stack)
    finally:
        await stack.stop()
    (recording,) = recordings(folder / "store")
    return {"survey": recording.read_bytes()}


async def fly_swap(folder: Path) -> dict[str, bytes]:
    """Explore until the battery is low, swap it, and explore on."""
    stack = SimulatedStack(OVER_LOT, folder, write_settings(folder, SETTINGS), None)
    try:
        async with operator((await stack.start()).url) as pilot:
            await explore(pilot)
            await stack.inject({"battery": LOW_PERCENT})
            await pilot.until_down()
        async with operator((await stack.swap_battery(OVER_LOT)).url) as pilot:
            await explore(pilot)
            await pilot.come_home()
        await end_in_order(stack)
    finally:
        await stack.stop()
    first, second = recordings(folder / "store")
    return {"battery-swap-before": without_pictures(first), "battery-swap-after": without_pictures(second)}


async def fly_faults(folder: Path) -> dict[str, bytes]:
    """Fly through the five faults that `make test` flies through."""
    faults = dict(zip(names(ALL), ALL, strict=True))
    options = SimulationOptions(world=small_picture(folder), metres_per_pixel=0.5, camera_rate=1.0)
    rig = Rig(folder, options)
    try:
        await rig.start()
        outcomes = [await rig.run(faults[name]) for name in SHORT]
    finally:
        await rig.stop()
    if problems := [outcome.problems for outcome in outcomes if not outcome.passed]:
        raise SimulationError(f"a fault did not end as it must: {problems}")
    (recording,) = recordings(rig.store)
    return {"faults": without_pictures(recording)}


async def explore(pilot: Operator) -> None:
    """Take off and explore for some seconds."""
    await pilot.take_off()
    await pilot.hand.offer(AutonomousExplore())
    began = pilot.beat.time
    await pilot.until(lambda b: b.time - began > EXPLORED_S or b.state == StateName.HOVER, 60.0)


async def end_in_order(stack: SimulatedStack) -> None:
    """End the daemon as the service manager does: the recording gets its end."""
    assert stack.daemon is not None
    stack.daemon.send_signal(signal.SIGTERM)
    await stack.daemon.wait()


def recordings(store: Path) -> list[Path]:
    """Return the recordings of a store, oldest first."""
    return sorted((store / "recordings").glob("*.mcap"))


def without_pictures(recording: Path) -> bytes:
    """Return a recording's metadata and what decisions are made of; one without an end stays without."""
    out = io.BytesIO()
    writer = Writer(out, compression=CompressionType.NONE, index_types=IndexType.METADATA, use_chunking=False)
    writer.start(profile="hawk", library="hawk-drone")
    schemas: dict[int, Schema] = {}
    channels: dict[int, int] = {}
    with recording.open("rb") as stream:
        for record in _records(stream):
            if isinstance(record, Metadata):
                writer.add_metadata(record.name, record.metadata)
            elif isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel) and record.topic in DECIDED:
                its = schemas[record.schema_id]
                number = writer.register_schema(its.name, its.encoding, its.data)
                channels[record.id] = writer.register_channel(record.topic, record.message_encoding, schema_id=number)
            elif isinstance(record, Message) and record.channel_id in channels:
                writer.add_message(channels[record.channel_id], record.log_time, record.data, record.publish_time)
    if is_whole(recording):
        writer.finish()  # type: ignore[no-untyped-call]
    return out.getvalue()


def _records(stream: Any) -> Any:
    try:
        for record in StreamReader(stream).records:
            if isinstance(record, DataEnd):
                return
            yield record
    except EndOfFile:
        return


def keep_map() -> None:
    """Process the pictures of the survey, and keep the map with the kind of machine that made it."""
    with tempfile.TemporaryDirectory() as folder:
        flight = RecordedFlight(unpack("survey", Path(folder)))
        made = process(flight, Again(flight.settings(), version("hawk-drone")))
    assert made.datum is not None
    found = {"made_on": machine(), "map": json.loads(recorded_geojson(made.datum, made.final.stalls))}
    (FOLDER / MAP).write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


FLIGHTS: Final[Mapping[str, Callable[[Path], Awaitable[dict[str, bytes]]]]] = {
    "survey": fly_survey,
    "faults": fly_faults,
    "battery-swap": fly_swap,
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Make one reference."""
    parser = argparse.ArgumentParser(prog="python -m tests.reference.make", description=__doc__)
    parser.add_argument("name", choices=(*FLIGHTS, "survey-map"))
    name = parser.parse_args(arguments).name
    if name in FLIGHTS:
        with tempfile.TemporaryDirectory() as folder:
            made = asyncio.run(_of(FLIGHTS[name](Path(folder))))
        for each, recording in made.items():
            digest = pack(recording, each)
            print(f'    "{each}.mcap.xz": "{digest}",')
    if name.startswith("survey"):
        keep_map()
    return 0


async def _of(made: Awaitable[dict[str, bytes]]) -> dict[str, bytes]:
    return await made


if __name__ == "__main__":
    sys.exit(main())
