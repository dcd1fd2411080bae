"""Write the page's TypeScript from the messages that drone and operator exchange, the table of commands and the API.

``python packaging/page_protocol.py`` writes ``protocol.ts``, ``command-table.ts`` and ``api.ts`` of
``hawk/web/page/src``; ``--check`` fails when one is out of date.
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

from hawk.comm.protocol.command_table import COMMAND_TABLE
from hawk.comm.protocol.commands import schema
from hawk.web.v1.openapi import document
from hawk.web.v1.table import FEATURES, OPERATIONS

SOURCES = Path(__file__).resolve().parent.parent / "hawk" / "web" / "page" / "src"

_HEADER = (
    "// Written by packaging/page_protocol.py from hawk/comm/protocol/commands.py: change that and run this again.\n"
)
_API_HEADER = (
    "// Written by packaging/page_protocol.py from the models of hawk/web/v1: change these and run this again.\n"
)
_TABLE_HEAD = """\
// Written by packaging/page_protocol.py from hawk/comm/protocol/command_table.py: change that and run this again.

import type { Messages } from "./messages/keys.ts";
import type { Command } from "./protocol.ts";

/** What the page must know of a command. */
export interface CommandRow {
  /** Key of the label of the button that sends it; null where there is none. */
  button: keyof Messages | null;
  /** How it is confirmed on the page; "overruling": by a slide while somebody else flies, and sent as confirmed. */
  confirm: "never" | "slide" | "overruling" | "two_steps";
}

export const COMMAND_TABLE = {
"""
_TABLE_END = """\
} as const satisfies Record<Command["Type"], CommandRow>;

type Table = typeof COMMAND_TABLE;

/** Labels of the buttons that send commands. */
export type CommandButton = Exclude<Table[keyof Table]["button"], null>;

/** The commands that a button sends. */
export type SentBy<Button extends CommandButton> = {
  [T in keyof Table]: Table[T]["button"] extends Button ? T : never;
}[keyof Table];

/** The commands that a slide confirms. */
export type Slid = {
  [T in keyof Table]: Table[T]["confirm"] extends "slide" | "overruling" ? T : never;
}[keyof Table];
"""
_PRIMITIVES = {"string": "string", "integer": "number", "number": "number", "boolean": "boolean", "null": "null"}


def protocol() -> str:
    """Return the TypeScript source of every message's type."""
    messages = schema()
    sent = messages["toDrone"]["$defs"]
    commands = {name: model for name, model in sent.items() if "Type" in model["properties"]}
    models: dict[str, dict[str, Any]] = {}
    models |= {name: model for name, model in sent.items() if name not in commands}
    for model in messages["fromDrone"].values():
        models |= model.get("$defs", {})
        models[model["title"]] = model
    blocks = [_interface(name, model, sending=True) for name, model in sorted(commands.items())]
    blocks.append("export type Command =\n" + "".join(f"  | {_command(name)}\n" for name in sorted(commands)) + ";\n")
    blocks += [_interface(name, model, sending=False) for name, model in sorted(models.items())]
    incoming = sorted(messages["fromDrone"])
    blocks.append("export type Incoming = " + " | ".join(incoming) + ";\n")
    return "\n".join([_HEADER, *blocks]).replace("\n;", ";")


def command_table() -> str:
    """Return the TypeScript source of what the page knows of each command."""
    rows = ""
    for kind, row in COMMAND_TABLE.items():
        button, confirm = json.dumps(row.button or None), json.dumps(row.confirm.name.lower())
        rows += f"  {_key(kind)}: {{ button: {button}, confirm: {confirm} }},\n"
    return f"{_TABLE_HEAD}{rows}{_TABLE_END}"


def api() -> str:
    """Return the TypeScript source of the type of each answer of the API, but those of OGC API Features."""
    shown = tuple(replace(each, body=None) for each in OPERATIONS if each.tag != FEATURES)
    models = document(shown, "http://drone", "1")["components"]["schemas"]
    blocks = [_interface(name, model, sending=False) for name, model in sorted(models.items())]
    return "\n".join([_API_HEADER, *blocks])


def files() -> dict[Path, str]:
    """Return the text of each file that is written."""
    texts = {"protocol.ts": protocol(), "command-table.ts": command_table(), "api.ts": api()}
    return {SOURCES / name: text for name, text in texts.items()}


def _key(text: str) -> str:
    return text if text.isidentifier() else json.dumps(text)


def _command(name: str) -> str:
    return f"{name}Command"


def _interface(name: str, model: dict[str, Any], *, sending: bool) -> str:
    """Return one message's interface.

    What is sent may leave out what has a default; what arrives is complete but for what its schema marks as optional.
    """
    required = set(model.get("required", ()))
    about = " ".join(model.get("description", "").split("\n\n")[0].split())
    lines = [f"/** {about} */"] if about else []
    lines.append(f"export interface {_command(name) if sending else name} {{")
    for key, value in model["properties"].items():
        may_lack = value.get("optional", False) or (sending and key not in required and key != "Type")
        optional = "?" if may_lack else ""
        lines.append(f"  {_key(key)}{optional}: {_type(value)};")
    return "\n".join([*lines, "}\n"])


def _type(value: dict[str, Any]) -> str:
    """Return the TypeScript type of one property of a JSON schema."""
    if "$ref" in value:
        return str(value["$ref"]).rsplit("/", 1)[-1]
    if "const" in value:
        return json.dumps(value["const"])
    if "enum" in value:
        return " | ".join(json.dumps(each) for each in value["enum"])
    if "anyOf" in value:
        return " | ".join(dict.fromkeys(_type(each) for each in value["anyOf"]))
    if "prefixItems" in value:
        return f"[{', '.join(_type(each) for each in value['prefixItems'])}]"
    if value.get("type") == "array" and value.get("minItems") == value.get("maxItems", 0):
        return f"[{', '.join([_type(value['items'])] * value['minItems'])}]"
    if value.get("type") == "array":
        inner = _type(value["items"])
        return f"({inner})[]" if " | " in inner else f"{inner}[]"
    if "additionalProperties" in value and isinstance(value["additionalProperties"], dict):
        return f"Record<string, {_type(value['additionalProperties'])}>"
    if value.get("additionalProperties") is True:
        return "Record<string, unknown>"
    if not value:
        return "unknown"
    return _PRIMITIVES[value["type"]]


def main(arguments: list[str] | None = None) -> int:
    """Write or check; return the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("--check", action="store_true", help="only say whether the files are up to date")
    if not parser.parse_args(arguments).check:
        for path, text in files().items():
            path.write_text(text, "utf-8")
        return 0
    late = [path.name for path, text in files().items() if path.read_text("utf-8") != text]
    if late:
        print(f"out of date, run python packaging/page_protocol.py: {', '.join(late)}", file=sys.stderr)
    return 1 if late else 0


if __name__ == "__main__":
    sys.exit(main())
