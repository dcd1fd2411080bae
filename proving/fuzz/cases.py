"""Fuzzed messages. Case N of a seed is always the same, so that a finding can be looked at again."""

from __future__ import annotations

import json
import random
import string
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

from hawk.comm.protocol.commands import MAX_MESSAGE_BYTES, schema

_LITERALS: Final = (
    "NaN", "Infinity", "-Infinity", "1e999", "-1e308", "9" * 400, "-0", "0.1e-400", "true", "null", '""', "\t", "01",
)  # fmt: skip
"""Values as they stand in JSON, or as some programs write them there."""
_STRINGS: Final = (
    "", " ", "Hold", "\x00", "\ud800", "𝔘", "<script>", "%s%n", "../../etc/passwd", "a" * 70, "é" * 2000,
)  # fmt: skip
_NUMBERS: Final = (0, -1, 1, 10_000, -10_001, 2**31, 2**63, -(2**64), 10**40, 0.5, 1e-300, 1e300, 60.0, 43.0)
_DEEPEST: Final = 4000


@dataclass(frozen=True, slots=True)
class Case:
    """A message to ``/ws``, and the names that a refusal of it may blame."""

    message: str | bytes
    blamed: frozenset[str] = frozenset()

    @property
    def is_text(self) -> bool:
        """True for text that can be sent: WebSocket text is UTF-8."""
        if isinstance(self.message, bytes):
            return False
        try:
            self.message.encode()
        except UnicodeEncodeError:
            return False
        return True


class Commands:
    """Valid commands drawn from the JSON schema that the daemon serves."""

    def __init__(self) -> None:
        self._definitions: dict[str, Any] = schema()["toDrone"]["$defs"]
        self._models = [model for model in self._definitions.values() if "Type" in model.get("properties", {})]

    def draw(self, rng: random.Random) -> dict[str, Any]:
        """Return a command as a JSON object, with its Id."""
        model = rng.choice(self._models)
        required = set(model.get("required", ()))
        command = {}
        for name, kind in model["properties"].items():
            if name in required or name == "Type" or rng.random() < 0.5:
                command[name] = self._value(rng, kind)
        command["Id"] = rng.choice([rng.randrange(10**6), f"id-{rng.randrange(10**6)}"])
        return command

    def _value(self, rng: random.Random, kind: dict[str, Any]) -> Any:
        if "$ref" in kind:
            model = self._definitions[kind["$ref"].rsplit("/", 1)[-1]]
            return {name: self._value(rng, each) for name, each in model["properties"].items()}
        if "const" in kind:
            return kind["const"]
        if "enum" in kind:
            return rng.choice(kind["enum"])
        if "anyOf" in kind:
            return self._value(rng, rng.choice(kind["anyOf"]))
        match kind.get("type"):
            case "number" | "integer":
                return self._number(rng, kind)
            case "string":
                return "".join(rng.choices(string.ascii_letters, k=rng.randint(kind.get("minLength", 1), 32)))
            case "boolean":
                return rng.random() < 0.5
            case "array":
                return [self._value(rng, kind["items"]) for _ in range(rng.randint(kind.get("minItems", 0), 8))]
        return None

    def _number(self, rng: random.Random, kind: dict[str, Any]) -> float:
        low = kind.get("minimum", kind.get("exclusiveMinimum", -100.0))
        high = kind.get("maximum", kind.get("exclusiveMaximum", 100.0))
        return round(rng.uniform(low, high), 3)


class Cases:
    """Draws cases. ``at(number)`` depends on seed and number only."""

    def __init__(self, seed: int) -> None:
        self._seed = seed
        self._commands = Commands()
        self._kinds: tuple[tuple[int, Callable[[random.Random], Case]], ...] = (
            (30, self._valid),
            (40, self._mutated),
            (8, self._literal),
            (6, self._cut),
            (5, self._random_json),
            (5, self._noise),
            (2, self._deep),
            (1, self._large),
            (3, self._binary),
        )
        self._weights = [weight for weight, _ in self._kinds]

    def at(self, number: int) -> Case:
        """Return a case whose text, if it is one, can be sent."""
        rng = random.Random(f"{self._seed}:{number}")
        while True:
            ((_, make),) = rng.choices(self._kinds, self._weights)
            case = make(rng)
            if case.is_text or isinstance(case.message, bytes):
                return case

    def _valid(self, rng: random.Random) -> Case:
        return Case(json.dumps(self._commands.draw(rng)))

    def _mutated(self, rng: random.Random) -> Case:
        """A valid command with one to three faults."""
        command = self._commands.draw(rng)
        blamed: set[str] = set()
        for _ in range(rng.choice((1, 1, 1, 2, 3))):
            blamed |= _spoil(rng, command)
        return Case(json.dumps(command, ensure_ascii=rng.random() < 0.5), frozenset(blamed))

    def _literal(self, rng: random.Random) -> Case:
        """A number that JSON cannot hold, or that no field takes, written into the text."""
        command = self._commands.draw(rng)
        name = rng.choice(list(command))
        command[name] = "@here@"
        return Case(json.dumps(command).replace('"@here@"', rng.choice(_LITERALS)), frozenset({name}))

    def _cut(self, rng: random.Random) -> Case:
        """A part of a valid text, or two that run together."""
        text = json.dumps(self._commands.draw(rng))
        begin, end = sorted(rng.choices(range(len(text) + 1), k=2))
        return Case(rng.choice((text[begin:end], text[:end], text + text, text[:begin] + text[end:])))

    def _random_json(self, rng: random.Random) -> Case:
        value = _value(rng, 4)
        names = frozenset(value) if isinstance(value, dict) else frozenset()
        return Case(json.dumps(value, ensure_ascii=rng.random() < 0.5), names)

    def _noise(self, rng: random.Random) -> Case:
        alphabet = rng.choice((string.printable, '{}[]":,0123456789.eE-+ \n', "\x00\x01\x7f\x80ÿ€😀\ufeff\u2028"))
        return Case("".join(rng.choices(alphabet, k=rng.randrange(200))))

    def _deep(self, rng: random.Random) -> Case:
        depth = rng.randint(50, _DEEPEST)
        opened, closed = rng.choice((("[", "]"), ('{"a":', "}"), ('{"Type":"Hold","Id":[', "]}")))
        return Case((opened * depth + "1" + closed * rng.choice((depth, depth - 1, 0)))[: 2 * MAX_MESSAGE_BYTES])

    def _large(self, rng: random.Random) -> Case:
        command = self._commands.draw(rng)
        command["Pad"] = "x" * rng.randint(MAX_MESSAGE_BYTES - 200, 4 * MAX_MESSAGE_BYTES)
        return Case(json.dumps(command), frozenset({"Pad"}))

    def _binary(self, rng: random.Random) -> Case:
        return Case(rng.randbytes(rng.randrange(300)))


def _spoil(rng: random.Random, command: dict[str, Any]) -> set[str]:
    """Spoil one key of the command, or of a corner in it; return the names that may be blamed."""
    name = rng.choice([*command, "Surplus"])
    if name == "Surplus":
        surplus = rng.choice(("Fast", "type", "x", "", "Confirmed ", "__class__", "Id2"))
        command[surplus] = _value(rng, 1)
        return {surplus}
    fault = rng.randrange(4)
    inner = command[name]
    if isinstance(inner, list) and inner and fault < 2:
        corner = rng.choice(inner)
        if isinstance(corner, dict) and corner:
            return _spoil(rng, corner) | {name}
    if fault == 0:
        del command[name]
    elif fault == 1 and isinstance(inner, int | float):
        command[name] = rng.choice(_NUMBERS)
    elif fault == 2:
        command[rng.choice((name.lower(), name.upper(), f" {name}"))] = command.pop(name)
        return {*command, name}
    else:
        command[name] = _value(rng, 2)
    return {name}


def _value(rng: random.Random, depth: int) -> Any:
    kind = rng.randrange(7 if depth else 5)
    match kind:
        case 0:
            return rng.choice(_NUMBERS)
        case 1:
            return rng.choice(_STRINGS)
        case 2:
            return rng.choice((True, False, None))
        case 3:
            return rng.uniform(-1e6, 1e6)
        case 4:
            return "".join(rng.choices(string.printable, k=rng.randrange(20)))
        case 5:
            return [_value(rng, depth - 1) for _ in range(rng.randrange(5))]
    names = ("Type", "Id", "X", "Y", "Token", "Corners", "Action", "Min", "", "a")
    return {rng.choice(names): _value(rng, depth - 1) for _ in range(rng.randrange(5))}
