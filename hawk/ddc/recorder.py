"""Records what was decided from which facts: the same facts and commands give the same decisions.

The records of one run, in their order: ``tick`` and ``command`` hold the facts, ``decision`` the acts that followed.
Facts that are as they were one record before are left out.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, is_dataclass
from typing import Any

from pydantic import BaseModel

from hawk.comm.protocol.commands import Command
from hawk.comm.protocol.heartbeat import ClientId
from hawk.ddc.decider import Decision
from hawk.ddc.facts import Facts

TICK, COMMAND, DECISION = "tick", "command", "decision"
WHOLE_EVERY = 20
"""Every such record holds all facts, so that a reader can begin within a second of any place."""


class Recorder:
    """Hands facts, commands and decisions to the recording."""

    def __init__(self, record: Callable[[str, dict[str, Any]], None]) -> None:
        self._record = record
        self._last: Facts | None = None
        self._count = 0

    def tick(self, facts: Facts, decision: Decision) -> None:
        """Record a tick and its decision."""
        self._record(TICK, {"facts": self._changed(facts)})
        self._decision(decision)

    def command(self, facts: Facts, client: ClientId, command: Command, decision: Decision) -> None:
        """Record a command, without its token, and its decision."""
        content = command.model_dump(by_alias=True, exclude={"token"})
        self._record(COMMAND, {"client": client, **content, "facts": self._changed(facts)})
        self._decision(decision)

    def _decision(self, decision: Decision) -> None:
        if decision.acts or decision.fault:
            self._record(DECISION, plain(decision))

    def _changed(self, facts: Facts) -> dict[str, Any]:
        """Return the facts that differ from the last record's; all of them in every WHOLE_EVERYth."""
        whole = self._last is None or self._count % WHOLE_EVERY == 0
        last, self._last = self._last, facts
        self._count += 1
        values = {item.name: getattr(facts, item.name) for item in fields(facts)}
        return values if whole else {name: value for name, value in values.items() if value != getattr(last, name)}


def plain(decision: Decision) -> dict[str, Any]:
    """Return a decision as the recording keeps it: the acts with their names."""
    acts = [{"act": type(act).__name__, **_plain(act)} for act in decision.acts]
    return {"acts": acts, "fault": decision.fault}


def _plain(value: Any) -> Any:
    if isinstance(value, float | int | str):  # nearly all of it
        return value
    if isinstance(value, BaseModel):
        return value.model_dump(by_alias=True)
    if is_dataclass(value) and not isinstance(value, type):
        return {item.name: _plain(getattr(value, item.name)) for item in fields(value)}
    if isinstance(value, tuple):
        return [_plain(each) for each in value]
    return value
