"""Records what was decided from which facts, and decides a recorded flight again.

The records of one run, in their order: ``tick`` and ``command`` hold the facts, ``decision`` the acts that followed.
Facts that are as they were one record before are left out.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

from pydantic import BaseModel, TypeAdapter

from hawk.comm.protocol.commands import Command, Kill, parse_command
from hawk.comm.protocol.heartbeat import ClientId
from hawk.ddc.decider import Decider, Decision
from hawk.ddc.facts import Facts
from hawk.ddc.rules.kill import KillTokens
from hawk.ddc.settings import DdcSettings

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


@dataclass(frozen=True, slots=True)
class Moment:
    """One recorded moment: its facts, its command (None: a tick), and its decision as it was recorded."""

    facts: Facts
    client: ClientId = ""
    command: Command | None = None
    decision: Mapping[str, Any] | None = None
    """None: nothing was done."""

    @property
    def kill_problem(self) -> str:
        """The recorded outcome of the token of a Kill."""
        for act in () if self.decision is None else self.decision["acts"]:
            if act["act"] == "Record" and act["kind"] == "kill token":
                return str(act["payload"][0][1])
        return ""


def moments(records: Iterable[tuple[str, Mapping[str, Any]]]) -> Iterator[Moment]:
    """Give the recorded moments in order, from the first whole facts on.

    Args:
        records: Topic and payload (plain JSON) of each record; other topics are ignored.
    """
    facts_type = TypeAdapter(Facts)  # made here: a start in the air has no time for it
    known: dict[str, Any] = {}
    open_: Moment | None = None
    for kind, payload in records:
        if kind in (TICK, COMMAND):
            known |= payload["facts"]
            if len(known) < len(fields(Facts)):
                continue
            if open_ is not None:
                yield open_
            open_ = _moment(kind, payload, facts_type.validate_python(known))
        elif kind == DECISION and open_ is not None:
            yield Moment(open_.facts, open_.client, open_.command, payload)
            open_ = None
    if open_ is not None:
        yield open_


def _moment(kind: str, payload: Mapping[str, Any], facts: Facts) -> Moment:
    if kind == TICK:
        return Moment(facts)
    content = {name: value for name, value in payload.items() if name not in ("facts", "client")}
    if content["Type"] == Kill.model_fields["type"].default:
        content["Token"] = "token-never-recorded"  # noqa: S105 - it stands for the real one
    return Moment(facts, payload["client"], parse_command(json.dumps(content)))


class _RecordedTokens(KillTokens):
    """Confirms a Kill where the recorded flight did."""

    problem = ""

    def redeem(self, client: ClientId, token: str, now: float) -> str:  # noqa: ARG002 - decided already
        """Return the recorded outcome."""
        return self.problem


def decide_again(
    flight: Iterable[Moment], settings: DdcSettings, *, continues_survey: bool = False
) -> Iterator[tuple[Moment, Decision]]:
    """Give each moment of a flight, from the start of the program, with the decision that its facts cause now."""
    tokens = _RecordedTokens()
    decider: Decider | None = None
    for moment in flight:
        if decider is None:
            decider = Decider(settings, tokens, moment.facts.now, continues_survey=continues_survey)
        tokens.problem = moment.kill_problem
        if moment.command is None:
            yield moment, decider.tick(moment.facts)
        else:
            yield moment, decider.command(moment.facts, moment.client, moment.command)
