"""Write the reference of the protocol from the messages, the table of commands and the examples of ``docs/examples``.

``python packaging/protocol_page.py`` writes ``docs/protocol.md``; ``--check`` fails when that is out of date. Tests
send the examples: a command to the parser, a request to the web server.
"""

from __future__ import annotations

import argparse
import ast
import inspect
import json
import sys
import textwrap
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any, Final

from hawk.comm.protocol.authority import Sender
from hawk.comm.protocol.base import Model, Outgoing, wire_key
from hawk.comm.protocol.command_table import COMMAND_TABLE, TO_MOVE, CommandRow, Need
from hawk.comm.protocol.commands import schema

DOCS: Final = Path(__file__).resolve().parent.parent / "docs"
TARGET: Final = DOCS / "protocol.md"
MESSAGES: Final = DOCS / "examples" / "messages.json"
REQUESTS: Final = DOCS / "examples" / "http.json"
PARTS: Final = "Parts of messages"
_USUAL: Final = Sender.CONTROL
_OFTEN: Final = 4
"""Commands from which on a need of them is said once, above all of them."""
ELSEWHERE: Final = {"Sentences": ""}
"""Texts on this page of keys that several messages have; the rules above the messages describe them."""

_HEADER: Final = """# Protocol

Written by `packaging/protocol_page.py` from the pydantic models of `hawk/comm/protocol/commands.py`, the rows of
`hawk/comm/protocol/command_table.py` and the examples in `docs/examples`: change those and run this again.

The operator's page, [the Python client](python-client.md) and other programs use the same addresses. Where the daemon
has tokens, a program sends `Authorization: Bearer TOKEN` with each request, also with that for a WebSocket
([roles](access.md)). JSON schema of all messages: `/api/schema.json`; examples:
[http.json](examples/http.json), [messages.json](examples/messages.json). Lots, surveys, recordings and
statistics have [an API of their own](api.md).
"""
_RULES: Final = """## WebSocket

`ws://DRONE:3000/ws` (`wss:` with a certificate) carries one JSON object a message, in both directions.

- The drone sends **Welcome** first, then a **Heartbeat** five times a second.
- A client sends commands. Each is answered once, by **Ack** or by an answer of its own kind, with the command's `Id`
  (a string of 64 characters at most, or a whole number; any value of yours).
- A client without a sign of life (any command, or `Heartbeat` once a second) for `operator.operator_timeout_s` loses
  control, and the drone holds, then returns home.
- Unknown keys, numbers as text, NaN and infinity are errors. A refusal names the key and the remedy.
- A message has 16 kB at most. 50 messages a second are read; a client that sends faster for 2 s is disconnected.
- Units: metres, seconds, radians, metres a second, percent; degrees for latitude and longitude (WGS-84). `North` and
  `East` are in the map frame, heights above the arm place ([frames](architecture.md#frames-of-reference)). `null` is a
  value that is not known.
- Types are written as in [the API](api.md). A key without a type is a string; one whose words were said is named alone.
- `Sentences` lists the sentences among a message's texts, each once, where there are some. Texts that others worded,
  such as the autopilot's, are not listed.
- Close code 4401: the login or its token has ended. 1008: messages came too fast. 1001: the drone's server stops.

Live pictures have WebSockets and addresses of their own: [video.md](video.md).
"""
PLAIN: Final = 3
"""Words of a text that says no more than unit or frame, which the rules above the messages give."""
_SHORT: Final = 6
"""Keys of a message that is shown whole."""
_RECEIVED: Final = """Of long messages those keys that need words.
[messages.json](examples/messages.json) has an example of each message with all keys, `/api/schema.json` their types.
"""
_ID: Final = {"Id": 7}


def page() -> str:
    """Return the page (Markdown)."""
    messages = schema()
    sent = messages["toDrone"]["$defs"]
    commands = {name: model for name, model in sent.items() if "Type" in model["properties"]}
    received = messages["fromDrone"]
    said: set[tuple[str, str]] = set()
    parts = {name: model for name, model in sent.items() if name not in commands}
    for model in received.values():
        parts |= model.get("$defs", {})
    blocks = [_HEADER, *_http(json.loads(REQUESTS.read_text(encoding="utf-8"))), _RULES]
    blocks += [
        "## To the drone\n",
        f"`Id` may be left out of every command. Where nothing else is said below, it is taken from {_USUAL.value}. "
        f"A command looks like `{json.dumps(sent_examples()['Autonomous Move'])}`. One that is refused changes "
        "nothing; its answer has the reason. [States and events](states.md#commands) lists the states that take each. "
        f"A move needs: {'; '.join(need.value for need in TO_MOVE)}.\n",
        *_groups(),
    ]
    for kind, example in sorted(sent_examples().items()):
        row = COMMAND_TABLE[kind]
        name = type(row.example).__name__
        blocks += _message(name, commands[name], example, [f"{_plain(row.help)}\n", *_needs(row)], said)
    blocks.append("## From the drone\n")
    blocks.append(_RECEIVED)
    for name, model in sorted(received.items(), key=lambda each: _type_of(each[1])):
        blocks += _message(name, model, {}, [f"{_summary(model)}\n"], said)
    blocks.append(f"## {PARTS}\n")
    for name, model in sorted(parts.items()):
        blocks += [f"### {name}\n", f"{_summary(model)}\n", *_keys(name, model, said, all_of_them=name in sent)]
    return "\n".join(blocks)


def _http(requests: list[dict[str, Any]]) -> Iterator[str]:
    yield "## HTTP\n"
    yield "For viewers and operators, where nothing else is said.\n"
    for each in requests:
        who = "" if each["for"] == "viewer, operator" else f" ({each['for']})"
        yield f"- `{each['method']} {each['route']}`{who}: {each['text']}"
    yield ""


def sent_examples() -> dict[str, dict[str, Any]]:
    """Return an example of each command by its type, in the order of the table, as JSON values."""
    found = {}
    for kind, row in COMMAND_TABLE.items():
        values = row.example.model_dump(mode="json", by_alias=True, exclude_unset=True)
        found[kind] = {"Type": kind, **({} if row.sender is Sender.EVERYBODY else _ID), **_shortest(values)}
    return found


def _shortest(value: Any) -> Any:
    """Return a JSON value in which whole numbers have no decimals."""
    match value:
        case float():
            return int(value) if value.is_integer() else value
        case list():
            return [_shortest(each) for each in value]
        case dict():
            return {key: _shortest(each) for key, each in value.items()}
    return value


def _groups() -> Iterator[str]:
    """Yield what the table says of several commands: who may send them, how they are confirmed, in which order."""
    said: dict[str, list[str]] = {}
    for kind, row in sorted(COMMAND_TABLE.items()):
        sender = "" if row.sender is _USUAL else f"From {row.sender.value}"
        confirmed = f"Confirmed {row.confirm.value}" if row.confirm.value else ""
        order = f"{row.urgency.value[:1].upper()}{row.urgency.value[1:]}"
        move = "Need what a move needs" if _is_move(row) else ""
        for words in filter(None, (sender, confirmed, order, move)):
            said.setdefault(words, []).append(kind)
    said |= {f"Need {need.value}": kinds for need, kinds in _shared_needs().items()}
    yield "\n".join([*(f"- {words}: {', '.join(kinds)}." for words, kinds in sorted(said.items())), ""])


def _shared_needs() -> dict[Need, list[str]]:
    """Return the needs of several commands with these, but for the needs of a move."""
    found: dict[Need, list[str]] = {}
    for kind, row in sorted(COMMAND_TABLE.items()):
        for need in _own_needs(row):
            found.setdefault(need, []).append(kind)
    return {need: kinds for need, kinds in found.items() if len(kinds) >= _OFTEN}


def _own_needs(row: CommandRow) -> tuple[Need, ...]:
    """Return what a command needs besides the needs of a move."""
    return row.needs[len(TO_MOVE) :] if _is_move(row) else row.needs


def _is_move(row: CommandRow) -> bool:
    return row.needs[: len(TO_MOVE)] == TO_MOVE


def _needs(row: CommandRow) -> Iterator[str]:
    """Yield what a command needs, and the others do not."""
    needs = [need.value for need in _own_needs(row) if need not in _shared_needs()]
    if needs:
        yield f"Needs: {'; '.join(needs)}.\n"


def _message(
    name: str, model: Mapping[str, Any], example: Mapping[str, Any], texts: Iterable[str], said: set[tuple[str, str]]
) -> Iterator[str]:
    yield f"### {_type_of(model)}\n"
    yield from texts
    yield from _keys(name, model, said, all_of_them=bool(example))


def _keys(name: str, model: Mapping[str, Any], said: set[tuple[str, str]], *, all_of_them: bool) -> Iterator[str]:
    """Yield a line with the keys without words of their own, then one for each other; ``said``: keys of before.

    ``all_of_them`` False leaves out those without words of a long message: the schema and the example have them.
    """
    texts, needed = field_texts(name) | ELSEWHERE, set(model.get("required", ()))
    is_sent = "Id" in model["properties"] and "Id" not in needed
    needed |= set(model["properties"]) if issubclass(_models()[name], Outgoing) else set()  # it is always there
    short: dict[str, list[str]] = {}
    lines = []
    for key, value in model["properties"].items():
        if key == "Type" or (is_sent and key == "Id"):
            continue
        kind = f"{_type(value)}{_default(value) if key not in needed else ''}"
        text = texts.get(key, "")
        words = _words(text) if all_of_them or len(text.split()) > PLAIN else ""
        row = (key, f"{kind}{words}")
        if not words or row in said:
            short.setdefault("" if kind == "string" or row in said else f": {kind}", []).append(f"`{key}`")
        else:
            said.add(row)
            lines.append(f"- `{key}`: {kind}{words}")
    if not all_of_them and len(model["properties"]) > _SHORT:
        short = {}
    alike = [f"{', '.join(keys)}{kind}" for kind, keys in sorted(short.items(), key=lambda each: each[0] != "")]
    if alike or lines:
        yield "\n".join([*[f"- {'; '.join(alike)}"] * bool(alike), *lines, ""])


def _default(value: Mapping[str, Any]) -> str:
    default = value.get("default")
    return f"=`{json.dumps(default)}`" if default not in (None, "", [], {}) else ""


def _type(value: Mapping[str, Any]) -> str:
    """Return the words for the type of a property of a JSON schema, with its bounds."""
    if "$ref" in value:
        name = str(value["$ref"]).rsplit("/", 1)[-1]
        return f"[{name}](#{name.lower()})"
    if "enum" in value:
        return f"`{'|'.join(json.dumps(each) for each in value['enum'])}`"
    if "anyOf" in value:
        kinds = dict.fromkeys(_type(each) for each in value["anyOf"])
        others = [kind for kind in kinds if kind != "null"]
        return "|".join(others) + ("?" if "null" in kinds else "")
    if "prefixItems" in value:
        return f"[{','.join(_type(each) for each in value['prefixItems'])}]"
    if value.get("type") == "array":
        return f"{_type(value['items'])}[]{_bounds(value, 'Items')}"
    return f"{value['type']}{_bounds(value, 'Length')}"


def _bounds(value: Mapping[str, Any], kind: str) -> str:
    least, most = value.get(f"min{kind}"), value.get(f"max{kind}")
    if least is None and most is None:
        least, most, above = value.get("minimum"), value.get("maximum"), value.get("exclusiveMinimum")
        least = least if above is None else f">{above:g}"
    if least is None and most is None:
        return ""
    ends = [each if isinstance(each, str) else f"{each:g}" for each in (least or 0, most) if each is not None]
    return f"{{{'..'.join(ends)}{'' if most is not None else '..'}}}"


@cache
def _models() -> dict[str, type[Model]]:
    """Return every class of messages by its name."""
    found: dict[str, type[Model]] = {}
    waiting: list[type[Model]] = [Model]
    while waiting:
        below = waiting.pop().__subclasses__()
        found |= {each.__name__: each for each in below}
        waiting += below
    return found


def field_texts(name: str) -> dict[str, str]:
    """Return the texts below the fields of a message's class and its bases, by key."""
    found: dict[str, str] = {}
    for owner in reversed(_models()[name].__mro__):
        if owner is Model or not issubclass(owner, Model):
            continue
        body = ast.parse(textwrap.dedent(inspect.getsource(owner))).body[0]
        assert isinstance(body, ast.ClassDef)  # noqa: S101 - narrows for the type checker
        for node, after in zip(body.body, body.body[1:], strict=False):
            if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
                is_text = isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant)
                if is_text and isinstance(after.value.value, str):  # type: ignore[attr-defined]
                    found[wire_key(node.target.id)] = " ".join(after.value.value.split())  # type: ignore[attr-defined]
    return found


def _type_of(model: Mapping[str, Any]) -> str:
    return str(model["properties"]["Type"]["const"])


def _summary(model: Mapping[str, Any]) -> str:
    return _plain(str(model.get("description", "")))


def _plain(text: str) -> str:
    return " ".join(text.replace("``", "`").split())


def _words(text: str) -> str:
    return f". {text}".replace("<", "\\<").replace("``", "`") if text else ""


def main(arguments: list[str] | None = None) -> int:
    """Write the page, or check it; return the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("--check", action="store_true", help="fail when docs/protocol.md is out of date")
    text = page()
    if not parser.parse_args(arguments).check:
        TARGET.write_text(text, encoding="utf-8")
        return 0
    if not TARGET.is_file() or TARGET.read_text(encoding="utf-8") != text:
        print("docs/protocol.md is out of date: run python packaging/protocol_page.py", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
