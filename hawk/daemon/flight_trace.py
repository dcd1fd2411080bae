"""The trace of a flight in the program's log, and so in journald: who asked for what, what changed, and why.

One line for each event, ``EVENT: words``, of the logger `TRACE`; `hawk.check.doctor` reads them. Calls come on
the loop and only hand lines to the log, which never blocks (`hawk.runtime.program_log`).
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from typing import Any, Final

from hawk.comm.protocol.command_table import COMMAND_TABLE
from hawk.comm.protocol.heartbeat import ClientId, DroneStatus, LogEntry
from hawk.runtime.program_log import NOTICE, TRACE
from hawk.runtime.repeated_log import Repeated

_LOG: Final = logging.getLogger(TRACE)
_LEVELS: Final = {"info": logging.INFO, "ok": logging.INFO, "warning": logging.WARNING, "error": logging.ERROR}


class FlightTrace:
    """Compares each status with the one before, and takes the records of states and answers as they are made."""

    def __init__(
        self,
        names: Callable[[], Mapping[ClientId, str]],
        controller: Callable[[], str | None],
        repeated: Repeated | None = None,
    ) -> None:
        """Keep what is asked.

        Args:
            names: Returns the name of each connection's session.
            controller: Returns the name of the session that has control.
            repeated: Keeps a part whose health changes every second to a line a minute.
        """
        self._names = names
        self._controller = controller
        self._repeated = repeated or Repeated()
        self._changes: list[tuple[str, str]] = []
        self._entry = 0
        self._connected = False
        self._armed: bool | None = None
        self._flown: tuple[float, float] | None = None
        self._in_control: str | None = None
        self._faults: dict[str, str] = {}
        self._has_begun = False
        """False until the first status: what is not there yet at the start is no fault of the flight."""

    def begin(self, words: str) -> None:
        """Note the start of the program."""
        _note(NOTICE, "start", words)

    def end(self, words: str) -> None:
        """Note the end of the program."""
        self._note_changes("", "")
        _note(NOTICE, "end", words)

    def record(self, kind: str, payload: Mapping[str, Any]) -> None:
        """Take a record of the operations manager; those of other kinds are left to the recording."""
        if kind == "state" and payload["from"] != payload["to"]:
            self._changes.append((str(payload["from"]), str(payload["to"])))
        elif kind == "answer to operator":
            self._answer(payload)

    def follow(self, status: DroneStatus) -> None:
        """Note what differs from the status before."""
        vehicle, travel, operation = status.vehicle, status.travel, status.operation
        if vehicle.connected != self._connected:
            self._connected = vehicle.connected
            lost = NOTICE if not vehicle.armed else logging.WARNING
            words = f"the autopilot is heard, mode {vehicle.ardupilot_state}" if vehicle.connected else "lost"
            _note(NOTICE if vehicle.connected else lost, "link", words)
        if vehicle.connected and vehicle.armed is not None and vehicle.armed != (self._armed or False):
            _note(
                NOTICE,
                "arm" if vehicle.armed else "disarm",
                f"motors {'on' if vehicle.armed else 'off'}, {_battery(status)}",
            )
            self._armed = vehicle.armed
        flown = None if travel.flight_time is None else (travel.flight_time, travel.distance_flown or 0.0)
        if (flown is None) != (self._flown is None):
            self._note_air(status)
        self._flown = flown
        self._note_changes(operation.detail, operation.asked_by or "")
        controller = self._controller()
        if controller != self._in_control:
            self._in_control = controller
            _note(NOTICE, "operator", "nobody has control" if controller is None else f"{controller} has control")
        self._note_faults(status)
        for entry in status.log:
            if entry.number > self._entry:
                self._entry = entry.number
                _note(_LEVELS[entry.level], "message", _sentence(entry))

    def _answer(self, payload: Mapping[str, Any]) -> None:
        command, accepted = payload["command"], payload["accepted"]
        if accepted and COMMAND_TABLE[command].only_asks:
            return
        name = self._names().get(payload["client"], "somebody")
        words = f"{name} asked for {command}: " + ("accepted" if accepted else f"refused: {payload['reason']}")
        _note(NOTICE if accepted else logging.INFO, "operator", words)

    def _note_air(self, status: DroneStatus) -> None:
        if self._flown is None:
            _note(NOTICE, "take-off", _battery(status))
        else:
            seconds, metres = self._flown
            _note(NOTICE, "landing", f"after {seconds:.0f} s and {metres:.0f} m, {_battery(status)}")

    def _note_changes(self, detail: str, asked_by: str) -> None:
        for number, (former, following) in enumerate(self._changes, start=1):
            is_newest = number == len(self._changes)
            cause = f": {detail}" if is_newest and detail else ""
            asked = f" (asked for by {asked_by})" if is_newest and asked_by else ""
            _note(NOTICE, "state", f"{former} -> {following}{cause}{asked}")
        self._changes.clear()

    def _note_faults(self, status: DroneStatus) -> None:
        faults = {part.name: part.reason for part in status.parts.health if not part.healthy}
        for name in faults.keys() - self._faults.keys():
            if self._repeated.due(f"fault {name}") is not None:
                _note(logging.WARNING if self._has_begun else logging.INFO, "fault", f"{name}: {faults[name]}")
        for name in self._faults.keys() - faults.keys():
            if self._repeated.due(f"over {name}") is not None:
                _note(logging.INFO, "fault over", name)
        self._faults = faults
        self._has_begun = True


def _note(level: int, event: str, words: str) -> None:
    _LOG.log(level, "%s: %s", event, words)


def _sentence(entry: LogEntry) -> str:
    return f"{entry.text} {entry.details}".strip()


def _battery(status: DroneStatus) -> str:
    vehicle = status.vehicle
    charge = "battery unknown" if vehicle.battery_percentage is None else f"battery {vehicle.battery_percentage:.0f} %"
    return charge if vehicle.voltage is None else f"{charge}, {vehicle.voltage:.1f} V"
