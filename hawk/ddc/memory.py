"""Memory of the decider as JSON: everything that it remembers from one tick to the next, written down and taken back.

A recording holds it at its start and every minute, so that its decisions can be made again from there on. The values
keep their kinds: a tuple comes back as a tuple, and two parts that share an object share it again. Settings and tokens
are not written: they are given, as to a new decider. Only classes of the modules below are written or made, so that a
file of somebody else makes nothing but these.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Hashable, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import cache
from types import ModuleType
from typing import Any, Final, cast

from pydantic import BaseModel, ValidationError

from hawk.comm.protocol import commands, heartbeat
from hawk.ddc import acts, decider, facts, motion, orders, stopwatch
from hawk.ddc.decider import Decider
from hawk.ddc.fence import plan
from hawk.ddc.keeper import effort, fence, keeper, parameters
from hawk.ddc.parameters import reader
from hawk.ddc.rules import command_desk, follower, kill, notices, silence
from hawk.ddc.rules.kill import KillTokens
from hawk.ddc.settings import DdcSettings
from hawk.ddc.states import base, explore, ground, hover, moves, path_home, rtl_and_land
from hawk.model import operation, plans, poses, vehicle
from hawk.store.frame_codec import field_names

FORMAT: Final = 1
"""Number of the memory's form. It grows when a class of the decider remembers other things than before."""
_STATES = (base, explore, ground, hover, moves, path_home, rtl_and_land)
_RULES = (command_desk, follower, kill, notices, silence, effort, fence, keeper, parameters, reader)
_VALUES = (acts, facts, motion, orders, stopwatch, plan, commands, heartbeat, operation, plans, poses, vehicle)
_MODULES: tuple[ModuleType, ...] = (decider, *_STATES, *_RULES, *_VALUES)
_CACHES: Final = {reader.ParameterReader: frozenset({"_lately"})}
"""Attributes that are computed again from the others when they are None."""
_PLAIN = (str, int, bool, type(None))
_Coded = Any  # JSON
_NAMED: Final = ("enum", "model", "value", "object")
"""Tags behind which the name of a class stands."""
_COLLECTIONS: Final[dict[str, type[Any]]] = {"tuple": tuple, "list": list, "set": set, "frozenset": frozenset}


class MemoryFormatError(ValueError):
    """A memory that cannot be taken back; the text says why."""


def remember(decider: Decider, settings: DdcSettings, tokens: KillTokens) -> dict[str, Any]:
    """Return all that a decider remembers, as JSON can keep it.

    ``settings``, ``tokens``: those that it was made with. Raises MemoryFormatError for an object of a foreign class.
    """
    return {"format": FORMAT, "decider": _Writer(_given(settings, tokens)).write(decider)}


def restore(memory: Mapping[str, Any], settings: DdcSettings, tokens: KillTokens) -> Decider:
    """Return a decider that goes on from a memory of `remember`. Raises MemoryFormatError."""
    if memory.get("format") != FORMAT:
        raise MemoryFormatError(
            f"the decider's memory has format {memory.get('format')!r}, this program reads {FORMAT}: "
            "use the version that recorded it"
        )
    try:
        restored = _Reader(_given(settings, tokens)).read(memory["decider"])
    except (KeyError, TypeError, ValueError, IndexError, AttributeError, RecursionError) as error:
        raise MemoryFormatError(f"the decider's memory cannot be read: {error or type(error).__name__}") from error
    if not isinstance(restored, Decider):
        raise MemoryFormatError(f"the memory is not a decider's, but holds {type(restored).__name__}")
    return restored


def is_same(first: Mapping[str, Any], second: Mapping[str, Any]) -> bool:
    """Return whether two memories are equal. An older one names the modules of its classes, which say nothing."""
    return first == second or bool(_without_modules(first) == _without_modules(second))


def _without_modules(coded: _Coded) -> _Coded:
    if isinstance(coded, Mapping):
        return {name: _without_modules(value) for name, value in coded.items()}
    if not isinstance(coded, list):
        return coded
    if len(coded) > 1 and coded[0] in _NAMED and isinstance(coded[1], str):
        return [coded[0], coded[1].rpartition(".")[2], *map(_without_modules, coded[2:])]
    return list(map(_without_modules, coded))


def _given(settings: DdcSettings, tokens: KillTokens) -> dict[str, Any]:
    """Return the objects that are not written, by name."""
    parts = {f"settings.{item.name}": getattr(settings, item.name) for item in fields(settings)}
    shared = {name: part for name, part in parts.items() if isinstance(part, BaseModel)}
    return {"tokens": tokens, "settings": settings, **shared}


@cache
def _kinds() -> Mapping[str, type[Any]]:
    """Return the classes that a memory may hold, by name: a class may move to another module."""
    kinds: dict[str, type[Any]] = {}
    for module in _MODULES:
        for value in vars(module).values():
            if isinstance(value, type) and value.__module__ == module.__name__:
                kinds[value.__name__] = value
    return kinds


class _Writer:
    """Writes one memory; an object that is met again becomes a number."""

    def __init__(self, given: Mapping[str, Any]) -> None:
        self._given = {id(value): name for name, value in given.items()}
        self._met: dict[int, int] = {}

    def write(self, value: Any) -> _Coded:
        if isinstance(value, Enum):
            return ["enum", self._kind(value), value.value]
        if isinstance(value, str):
            return str.__str__(value)  # a sentence is its words
        if isinstance(value, _PLAIN):
            return value
        if isinstance(value, float):
            return value if math.isfinite(value) else ["float", repr(value)]
        name = self._given.get(id(value))
        return ["given", name] if name is not None else self._write_whole(value)

    def _write_whole(self, value: Any) -> _Coded:
        if isinstance(value, dict):
            return ["dict", *([self.write(key), self.write(each)] for key, each in value.items())]
        if isinstance(value, deque):
            return ["deque", value.maxlen, *map(self.write, value)]
        if isinstance(value, set | frozenset):
            return [type(value).__name__, *map(self.write, sorted(value))]
        if isinstance(value, tuple | list):
            return [type(value).__name__, *map(self.write, value)]
        if isinstance(value, BaseModel):
            return ["model", self._kind(value), value.model_dump(mode="json", by_alias=True)]
        if is_dataclass(value) and type(value).__hash__ is not None:  # frozen: a value, not an object of its own
            return ["value", self._kind(value), self._attributes(value)]
        number = self._met.get(id(value))
        if number is not None:
            return ["same", number]
        number = self._met[id(value)] = len(self._met)
        return ["object", self._kind(value), number, self._attributes(value)]

    def _kind(self, value: Any) -> str:
        kind = type(value)
        if _kinds().get(kind.__name__) is not kind:
            raise MemoryFormatError(f"{kind.__qualname__} is no class of the decider's memory")
        return kind.__name__

    def _attributes(self, value: Any) -> dict[str, _Coded]:
        kind = type(value)
        names = field_names(cast("Hashable", kind)) if is_dataclass(kind) else tuple(vars(value))
        caches = _CACHES.get(kind, frozenset())
        return {name: None if name in caches else self.write(getattr(value, name)) for name in names}


class _Reader:
    """Reads one memory."""

    def __init__(self, given: Mapping[str, Any]) -> None:
        self._given = given
        self._met: dict[int, Any] = {}
        self._tags: dict[str, Callable[..., Any]] = {
            "float": float,
            "given": self._given.__getitem__,
            "enum": lambda kind, value: self._kind(kind)(value),
            "dict": lambda *items: {self.read(key): self.read(value) for key, value in items},
            "deque": lambda length, *items: deque(map(self.read, items), maxlen=length),
            "model": self._model,
            "value": lambda kind, values: self._kind(kind)(**self._attributes(values)),
            "same": self._met.__getitem__,
            "object": self._object,
        }

    def read(self, coded: _Coded) -> Any:
        if not isinstance(coded, list):
            return coded
        tag, *content = coded
        if tag in _COLLECTIONS:
            return _COLLECTIONS[tag](map(self.read, content))
        return self._tags[tag](*content)

    def _kind(self, name: str) -> type[Any]:
        kind = _kinds().get(name.rpartition(".")[2])  # a memory may name the module, too
        if kind is None:
            raise MemoryFormatError(f"{name} is no class of the decider's memory")
        return kind

    def _attributes(self, values: Mapping[str, _Coded]) -> dict[str, Any]:
        return {name: self.read(value) for name, value in values.items()}

    def _model(self, kind: str, values: Mapping[str, Any]) -> BaseModel:
        model = cast("type[BaseModel]", self._kind(kind))
        try:
            return model.model_validate(values)
        except ValidationError as error:
            raise MemoryFormatError(f"{kind}: {error}") from error

    def _object(self, kind: str, number: int, values: Mapping[str, _Coded]) -> Any:
        made = self._met[number] = object.__new__(self._kind(kind))
        for name, value in values.items():
            setattr(made, name, self.read(value))
        return made
