"""Decides a recorded flight again: the same memory, facts and commands give the same decisions.

A recording can be entered at each ``memory``. Where records are missing, nothing is decided until the next one.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any, Final, get_type_hints

from pydantic import BaseModel, TypeAdapter, ValidationError, create_model

from hawk.comm.protocol.commands import BadMessageError, Command, Kill, parse_command
from hawk.comm.protocol.heartbeat import ClientId
from hawk.config.sections import Config, ConfigError
from hawk.ddc.decider import Decider, Decision
from hawk.ddc.facts import Facts
from hawk.ddc.memory import MemoryFormatError, is_same, remember, restore
from hawk.ddc.orders import Cause
from hawk.ddc.recorder import COMMAND, DECISION, LEAVE, MEMORY, TICK, plain
from hawk.ddc.rules.kill import KillTokens
from hawk.ddc.settings import DdcSettings
from hawk.store.frame_codec import field_names, to_json
from hawk.store.replay import NO_END, is_whole, read_metadata, read_recording

NO_MEMORY: Final = "the recording holds no memory of the decider: a version before that kept none"
_NOTHING: Final[Mapping[str, Any]] = {"acts": [], "fault": ""}
_MASKED: Final = frozenset({"web", "webhooks"})
"""Sections that a recording has without their secrets; they decide nothing."""
_TOPICS: Final = frozenset({TICK, COMMAND, LEAVE, DECISION, MEMORY})
_OURS: Final = frozenset({"number", "facts", "client"})


class ReplayError(ValueError):
    """A recording that cannot be decided again; the text says why."""


@dataclass(frozen=True, slots=True)
class Moment:
    """One recorded moment: facts, the command or cause (both None: a tick), and the decision as it was recorded.

    ``memory``: what the decider remembered just before; None where it was not recorded.
    """

    facts: Facts
    number: int
    client: ClientId = ""
    command: Command | None = None
    cause: Cause | None = None
    memory: Mapping[str, Any] | None = field(default=None, repr=False)
    decision: Mapping[str, Any] = field(default_factory=lambda: _NOTHING)

    @property
    def kill_problem(self) -> str:
        """The recorded outcome of the token of a Kill."""
        for act in self.decision["acts"]:
            if act["act"] == "Record" and act["kind"] == "kill token":
                return str(act["payload"][0][1])
        return ""


@dataclass(frozen=True, slots=True)
class Difference:
    """A decision that is another one now, both as a recording keeps them. ``at``: seconds of the recording's clock."""

    at: float
    command: str
    recorded: Any
    again: Any


@dataclass(frozen=True, slots=True)
class Comparison:
    """Number of moments that were decided again, of memories entered, of moments that no memory leads to.

    ``damage``: why moments are missing at the end, else empty. ``seconds``: length of what was read, of the flight.
    """

    decided: int = 0
    entered: int = 0
    left_out: int = 0
    differences: tuple[Difference, ...] = ()
    damage: str = ""
    seconds: float = 0.0


def moments(records: Iterable[tuple[str, Mapping[str, Any]]], *, is_whole: bool = True) -> Iterator[Moment]:
    """Give the recorded moments in order, from the first whole facts on.

    Args:
        records: Topic and payload (plain JSON) of each record; other topics are ignored.
        is_whole: False for a recording that a crash ended: a decision may have followed its last facts.

    Raises:
        ReplayError: A record that this version cannot read.
    """
    known: dict[str, Any] = {}
    changed: dict[str, Any] = {}
    memory: Mapping[str, Any] | None = None
    open_: Moment | None = None
    for kind, payload in records:
        if kind in (TICK, COMMAND, LEAVE):
            changed |= _facts_in(kind, payload)
            if not known and len(changed) < len(field_names(Facts)):
                continue
            if open_ is not None:
                yield open_
            with _another_version(kind):
                known |= _read(changed)
                open_, memory = replace(_moment(kind, payload, Facts(**known)), memory=memory), None
            changed = {}
        elif kind == MEMORY:
            memory = payload
        elif kind == DECISION and open_ is not None:
            yield replace(open_, decision=payload)
            open_ = None
    if open_ is not None and is_whole:
        yield open_


def _facts_in(kind: str, payload: Mapping[str, Any]) -> Mapping[str, Any]:
    found = payload.get("facts")
    if not isinstance(found, Mapping):
        raise ReplayError(f"a record of {kind} is of another version, or damaged: it has no facts")
    return found


@cache
def _fields() -> type[BaseModel]:
    kinds = get_type_hints(Facts)
    definitions: dict[str, Any] = {name: (kinds[name], None) for name in field_names(Facts)}
    model: type[BaseModel] = create_model("Facts", **definitions)
    return model


def _read(changed: Mapping[str, Any]) -> dict[str, Any]:
    """Return recorded fields of `Facts` as it holds them: those alone that changed, since the others cost as much."""
    read = _fields().model_validate(changed)
    return {name: getattr(read, name) for name in read.model_fields_set}


@contextmanager
def _another_version(kind: str) -> Iterator[None]:
    try:
        yield
    except (ValidationError, BadMessageError, LookupError, TypeError, ValueError, OverflowError) as error:
        raise ReplayError(f"a record of {kind} is of another version, or damaged: {error}") from error


def _moment(kind: str, payload: Mapping[str, Any], facts: Facts) -> Moment:
    number = int(payload["number"])
    if kind == TICK:
        return Moment(facts, number)
    if kind == LEAVE:
        return Moment(facts, number, cause=TypeAdapter(Cause).validate_python(payload["cause"]))
    content = {name: value for name, value in payload.items() if name not in _OURS}
    if content["Type"] == Kill.model_fields["type"].default:
        content["Token"] = "never recorded: this stands for it"  # noqa: S105
    return Moment(facts, number, payload["client"], parse_command(json.dumps(content)))


class _RecordedTokens(KillTokens):
    """Confirms a Kill where the recorded flight did."""

    problem = ""

    def redeem(self, client: ClientId, token: str, now: float) -> str:  # noqa: ARG002 - it was judged in flight
        """Return the recorded outcome."""
        return self.problem


def decide_again(flight: Iterable[Moment], settings: DdcSettings) -> Iterator[tuple[Moment, Decision]]:
    """Give each moment with the decision that its facts cause now, from the first memory on.

    At each memory the decider goes on from there. Moments after missing ones are left out. Raises ReplayError.
    """
    for moment, decision, _ in _decided(flight, settings):
        if decision is not None:
            yield moment, decision


def compare(
    records: Iterable[tuple[str, Mapping[str, Any]]], settings: DdcSettings, *, is_whole: bool = True
) -> Comparison:
    """Decide a recording again and compare; what the decider remembers is compared at each memory.

    Args:
        records: Topic and payload (plain JSON) of each record.
        settings: Those of the recorded run.
        is_whole: As in `moments`.

    Raises:
        ReplayError: No memory, or records of another version.
    """
    decided = entered = left_out = 0
    differences: list[Difference] = []
    for moment, decision, remembered in _decided(moments(records, is_whole=is_whole), settings):
        entered += moment.memory is not None
        if decision is None:
            left_out += 1
            continue
        decided += 1
        now, command = moment.facts.now, "" if moment.command is None else moment.command.type
        if remembered is not None and moment.memory is not None and not is_same(remembered, moment.memory):
            differences.append(Difference(now, MEMORY, moment.memory, remembered))
        again = _as_recorded(decision)
        if again != moment.decision:
            differences.append(Difference(now, command, moment.decision, again))
    if entered == 0 and (is_whole or left_out):  # a file that was cut at its first moment holds none
        raise ReplayError(NO_MEMORY)
    return Comparison(decided, entered, left_out, tuple(differences))


def _as_recorded(decision: Decision) -> Any:
    return json.loads(to_json(plain(decision)))


def _decided(
    flight: Iterable[Moment], settings: DdcSettings
) -> Iterator[tuple[Moment, Decision | None, dict[str, Any] | None]]:
    """Give each moment, its decision (None: no memory leads to it), and what the decider remembered before a memory."""
    tokens = _RecordedTokens()
    decider: Decider | None = None
    number = 0
    for moment in flight:
        if moment.number != number:
            decider = None
        number = moment.number + 1
        remembered = None
        if moment.memory is not None:
            remembered = None if decider is None else remember(decider, settings, tokens)
            decider = _entered(moment.memory, settings, tokens)
        yield moment, None if decider is None else _decide(decider, tokens, moment), remembered


def _entered(memory: Mapping[str, Any], settings: DdcSettings, tokens: KillTokens) -> Decider:
    try:
        return restore(memory, settings, tokens)
    except MemoryFormatError as error:
        raise ReplayError(str(error)) from error


def _decide(decider: Decider, tokens: _RecordedTokens, moment: Moment) -> Decision | None:
    tokens.problem = moment.kill_problem
    if moment.command is not None:
        return decider.command(moment.facts, moment.client, moment.command)
    if moment.cause is not None:
        return decider.leave_air(moment.facts, moment.cause)
    return decider.tick(moment.facts)


def compare_recording(path: Path) -> Comparison:
    """Decide a recording again by the settings that it holds, and compare.

    Raises:
        ReplayError: Records of another version, settings that cannot be read, or no memory.
        hawk.store.replay.RecordingError: The file is no recording, or damaged.
    """
    metadata = read_metadata(path)
    remedy = f"use hawk-drone {metadata.get('version', 'of an earlier version')}, which recorded it"
    try:
        values = json.loads(metadata.get("configuration", ""))
        decides = {name: value for name, value in values.items() if name not in _MASKED}
        settings = DdcSettings.from_config(Config.model_validate(decides))
    except (ValueError, AttributeError, ConfigError) as error:  # of JSON and of pydantic
        raise ReplayError(f"{path}: its settings cannot be used: {error}; {remedy}") from error
    records, whole = _Records(path), is_whole(path)
    try:
        found = compare(records, settings, is_whole=whole)
    except ReplayError as error:
        raise ReplayError(f"{path}: {error}; {remedy}") from error
    return replace(found, damage="" if whole else NO_END, seconds=records.seconds)


class _Records:
    """The records of a recording that decisions need; ``seconds`` is the time of the flight that was read so far."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.seconds = 0.0

    def __iter__(self) -> Iterator[tuple[str, Any]]:
        first: float | None = None
        for one in read_recording(self._path):
            first = one.time if first is None else first
            self.seconds = max(self.seconds, one.time - first)
            if one.topic in _TOPICS:
                yield one.topic, one.payload()
