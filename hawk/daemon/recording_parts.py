"""The flight's recording as the daemon makes it: its metadata, the schemas of its own topics, and what viewers show."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from datetime import datetime
from functools import cache
from importlib.metadata import version
from typing import Any, Final

from pydantic import TypeAdapter

from hawk.algo.frame import FrameInput
from hawk.algo.vision.network_file import network_name
from hawk.comm.autopilot.vehicle import VehicleTopics
from hawk.comm.protocol.heartbeat import DroneStatus
from hawk.comm.topic import Topic
from hawk.config.sections import Config
from hawk.ddc.facts import Facts
from hawk.ddc.recorder import COMMAND, DECISION, LEAVE, MEMORY, TICK
from hawk.model.known_lot import KnownLot
from hawk.model.lot_map import OccupancyMap
from hawk.model.poses import GlobalPose, VehiclePose
from hawk.sim.launch import SimulationOptions
from hawk.store.frame_codec import FRAME_INPUT, MapStalls, View, Words
from hawk.store.recording import Recording
from hawk.store.replay import KNOWN_LOT, LOTS, MESSAGE, ZERO_UTC

POSE_S: Final = 0.2
"""Seconds between two poses for viewers."""
STALLS_S: Final = 5.0
STALLS_A_SECOND: Final = 100.0
"""Stalls are recorded every `STALLS_S`, of a large lot less often: a second for this number of them."""
_NUMBER: Final[Mapping[str, Any]] = {"type": "integer", "description": "counts ticks, commands and leaves"}


def make_recording(
    config: Config,
    clock: Callable[[], float],
    speed: float,
    simulation: SimulationOptions | None,
    survey: Callable[[], str],
    moment: Callable[[float], datetime | None],
) -> Recording:
    """Return the recording of this run.

    ``speed``: seconds of the clock per real second. ``survey``: returns the name of the journal's survey. ``moment``:
    returns UTC at a time of the clock by the autopilot's GNSS, which a simulation draws; None where it has none.
    """
    metadata = {
        "version": version("hawk-drone"),
        "configuration": config.model_dump_json(),
        "seed": str(simulation.seed) if simulation else "",
        "speed": str(speed),
    }

    def about() -> Mapping[str, str]:
        zero = moment(0.0)
        named = {"survey": survey(), ZERO_UTC: "" if zero is None else zero.isoformat()}
        return {"network": network_name(config.vision.model), **{key: value for key, value in named.items() if value}}

    return Recording(config.store, clock, metadata, json_schemas=json_schemas, about=about)


@cache
def json_schemas() -> Mapping[str, Mapping[str, Any]]:
    """Return the JSON Schema of each topic that has more than "an object"."""
    facts = _finite_or_words(TypeAdapter(Facts).json_schema())
    some = {**facts, "required": [], "description": "those that differ from the record before; all of them each second"}
    definitions = some.pop("$defs", {})
    frame = _finite_or_words(TypeAdapter(FrameInput).json_schema())
    frame["properties"]["picture"] = _object({"topic": {"type": "string"}, "log_time": {"type": "integer"}})
    frame["properties"]["known"] = {
        "type": ["object", "array"], "description": "topic and time of the lots' plans; empty without one"
    }  # fmt: skip
    del frame["properties"]["jpeg"]
    frame["required"] = [name for name in frame["required"] if name != "jpeg"]
    plans = TypeAdapter(tuple[KnownLot, ...]).json_schema()
    held = {"number": _NUMBER, "facts": some}
    cause = _object({"text": {"type": "string"}, "kind": {"type": "string"}, "details": {"type": "string"}})
    acts = {"type": "array", "items": {"type": "object", "required": ["act"]}}
    return {
        TICK: {**_object(held), "$defs": definitions},
        COMMAND: {**_object({**held, "client": {"type": "string"}, "Type": {"type": "string"}}), "$defs": definitions},
        LEAVE: {**_object({**held, "cause": cause}), "$defs": definitions},
        DECISION: _object({"acts": acts, "fault": {"type": "string"}}),
        MEMORY: _object({"format": {"type": "integer"}, "decider": {"type": "array"}}),
        FRAME_INPUT: frame,
        KNOWN_LOT: {"$defs": plans.pop("$defs"), **_object({LOTS: plans})},
    }


def _object(properties: Mapping[str, Any]) -> dict[str, Any]:
    return {"type": "object", "properties": dict(properties), "required": list(properties)}


def _finite_or_words(schema: Any) -> Any:
    """Return a schema whose numbers may be "Infinity", "-Infinity" and "NaN" as well: JSON has no numbers for them."""
    if isinstance(schema, list):
        return [_finite_or_words(each) for each in schema]
    if not isinstance(schema, dict):
        return schema
    changed = {name: _finite_or_words(each) for name, each in schema.items()}
    return {**changed, "type": ["number", "string"]} if changed.get("type") == "number" else changed


class FlightViews:
    """Hands poses, messages and stalls to the recording, at a pace that viewers need."""

    def __init__(
        self,
        show: Callable[[View], None],
        record: Callable[[str, Mapping[str, Any]], None],
        clock: Callable[[], float],
        datum: Callable[[], GlobalPose | None],
    ) -> None:
        """``datum``: origin of the map; None while it has none."""
        self._show, self._record = show, record
        self._clock = clock
        self._datum = datum
        self._pose_due = self._stalls_due = float("-inf")
        self._entry = 0
        self._seen: tuple[str, int] = ("", -1)

    def listen(self, vehicle: VehicleTopics, status: Topic[DroneStatus], occupancy_map: Topic[OccupancyMap]) -> None:
        """Follow these topics from now on."""
        vehicle.pose.listen(self.pose)
        status.listen(self.status)
        occupancy_map.listen(self.map)

    def pose(self, pose: VehiclePose) -> None:
        """Take a pose."""
        if self._clock() >= self._pose_due:
            self._pose_due = self._clock() + POSE_S
            self._show(pose)

    def status(self, status: DroneStatus) -> None:
        """Take the messages that are new."""
        for entry in status.log:
            if entry.number > self._entry:
                self._entry = entry.number
                self._show(Words(entry.level, entry.text, entry.details))
                self._record(MESSAGE, entry.model_dump())

    def map(self, current: OccupancyMap) -> None:
        """Take a map whose stalls may have changed."""
        now, datum = self._clock(), self._datum()
        if datum is None or now < self._stalls_due or self._seen == (current.map_id, current.version):
            return
        self._seen = (current.map_id, current.version)
        self._stalls_due = now + max(STALLS_S, len(current.stalls) / STALLS_A_SECOND)
        self._show(MapStalls(datum, current.stalls))
