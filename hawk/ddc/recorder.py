"""Records what was decided from which facts: the same facts and commands give the same decisions.

The records of one run, in their order: ``memory`` holds what the decider remembers, ``tick``, ``command`` and ``leave``
the facts, ``decision`` the acts that followed. Facts that are as they were one record before are left out. Records of
facts are numbered: where a number is missing, messages were lost, and a reader goes on from the next memory
(`hawk.ddc.replay`).
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from dataclasses import is_dataclass
from typing import Any

from pydantic import BaseModel

from hawk.comm.protocol.commands import Command
from hawk.comm.protocol.heartbeat import ClientId
from hawk.ddc.decider import Decision
from hawk.ddc.facts import Facts
from hawk.ddc.orders import Cause
from hawk.store.frame_codec import field_names, field_values

_LOGGER = logging.getLogger(__name__)

TICK, COMMAND, LEAVE, DECISION, MEMORY = "tick", "command", "leave", "decision", "memory"
MEMORY_S = 60.0
"""The decider's memory is recorded this often, seconds, and where the recording has none."""
LEAST_MEMORY_S = 1.0
"""Not more often than this: a recording that loses messages asks for it again and again, seconds."""
WHOLE_EVERY = 20
"""Every such record holds all facts, so that a reader can begin within a second of any place."""


class Recorder:
    """Hands facts, commands and decisions to the recording."""

    def __init__(
        self,
        record: Callable[[str, dict[str, Any]], None],
        remember: Callable[[], dict[str, Any]],
        wants_memory: Callable[[], bool] = lambda: False,
    ) -> None:
        """Begin.

        Args:
            record: Takes topic and payload.
            remember: Returns the decider's memory of now. Raises ValueError when that cannot be written down.
            wants_memory: Returns True while what was recorded last cannot be entered.
        """
        self._record = record
        self._remember = remember
        self._wants_memory = wants_memory
        self._remembered_at: float | None = None
        self._last: Facts | None = None
        self._count = 0

    def prepare(self, now: float) -> None:
        """Record the decider's memory where it is due: call it before each decision, ``now`` in seconds."""
        passed = math.inf if self._remembered_at is None else now - self._remembered_at
        if passed < (LEAST_MEMORY_S if self._wants_memory() else MEMORY_S):
            return
        self._remembered_at, self._last = now, None
        try:
            memory = self._remember()
        except ValueError as error:  # the flight needs none of it
            _LOGGER.error("the recording goes on without the decider's memory: %s", error)
            return
        self._record(MEMORY, memory)

    def tick(self, facts: Facts, decision: Decision) -> None:
        """Record a tick and its decision."""
        self._facts(TICK, facts, {})
        self._decision(decision)

    def command(self, facts: Facts, client: ClientId, command: Command, decision: Decision) -> None:
        """Record a command, without its token, and its decision."""
        content = command.model_dump(by_alias=True, exclude={"token"})
        self._facts(COMMAND, facts, {"client": client, **content})
        self._decision(decision)

    def leave(self, facts: Facts, cause: Cause, decision: Decision) -> None:
        """Record that the drone left the air because the program ends, or ticks failed, and the decision."""
        self._facts(LEAVE, facts, {"cause": cause})
        self._decision(decision)

    def _facts(self, kind: str, facts: Facts, content: dict[str, Any]) -> None:
        number = self._count
        self._record(kind, {**content, "number": number, "facts": self._changed(facts)})

    def _decision(self, decision: Decision) -> None:
        if decision.acts or decision.fault:
            self._record(DECISION, plain(decision))

    def _changed(self, facts: Facts) -> dict[str, Any]:
        """Return the facts that differ from the last record's; all of them in every WHOLE_EVERYth."""
        whole = self._last is None or self._count % WHOLE_EVERY == 0
        last, self._last = self._last, facts
        self._count += 1
        values = field_values(facts)
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
        return {name: _plain(getattr(value, name)) for name in field_names(type(value))}
    if isinstance(value, tuple):
        return [_plain(each) for each in value]
    return value
