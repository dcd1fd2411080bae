"""Write the reference of the API from its definition, which is made of `hawk.web.v1.table` and pydantic models.

``python packaging/api_page.py`` writes ``docs/api.md``; ``--check`` fails when that is out of date.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any, Final

from hawk.web.v1.openapi import document
from hawk.web.v1.table import FEATURES, OPERATIONS
from hawk.web.v1.unknown import ROOT

TARGET: Final = Path(__file__).resolve().parent.parent / "docs" / "api.md"
_SCHEMAS: Final = "#/components/schemas/"
_HEADER: Final = """# The API

Written by `packaging/api_page.py` from `hawk/web/v1/table.py` and its pydantic models: change those and run this again.
`make api-fuzz` tries every address by this definition for ten minutes.

Other programs read lots, layouts, stalls, zones, surveys, observations, statistics and recordings here, and change
them. A drone and a [desk](how-to/your-lot.md#at-a-desk) answer alike. The definition is OpenAPI 3.1:
`http://DRONE:3000/api/v1/openapi.json`. The page and the commands of `hawk-drone` use the same addresses. What is of
the present flight alone has [addresses of its own](protocol.md#http).

    curl -s -H "Authorization: Bearer TOKEN" "http://DRONE:3000/api/v1/lots?limit=10"
    curl -s "http://127.0.0.1:3000/api/v1/lots/LOT/statistics?from=2026-05-04&to=2026-05-10&by=row"
    curl -s -d '{"name": "North Street"}' http://127.0.0.1:3000/api/v1/lots/LOT/name

- Viewers read, operators change ([roles](access.md)). Where the daemon has tokens, send `Authorization: Bearer TOKEN`.
- A list comes in parts of `limit` items, 1000 at most. `next` is `after` of the next part, and `null` at the end; the
  header `Link` has its address. A part begins behind the last item of the one before, whatever was added meanwhile.
- An answer has an `ETag`. Send it as `If-None-Match` to the same address: 304 says that nothing has
  changed. Answers are packed with gzip where `Accept-Encoding` allows it.
- A refusal is `application/problem+json` (RFC 9457): `detail` says what is wrong and the remedy, `field` names the
  value. 400 and 422: a value; 401: no token; 403: a viewer, or the page of another server; 404: an id; 409: it does not
  fit what is there; 503: busy, ask again.
- A request takes 10 s at most. The store has a thread of its own, which a flight never waits for.
- Times are UTC (RFC 3339), lengths metres, angles radians, places degrees of WGS-84, latitude first. `from` and `to`
  are dates or moments; without an offset they are those of the clock `time_zone`.
"""
_SHARED: Final = 3
"""Addresses with the same parameter, from which it is described once."""
_OF_FEATURES: Final = """The collections `lots`, `stalls` and `surveys` by OGC API Features, Part 1 (Core, GeoJSON),
read only, for QGIS, GDAL and their like: [how QGIS opens them](how-to/open-lots-in-qgis.md). `bbox` is west, south,
east, north; `datetime` is a moment, a date, or a period as `2026-05-01/..`. A lot has the time of its last survey,
a stall that of the last look at it, a survey that of its flight.
"""


def page() -> str:
    """Return the page (Markdown)."""
    found = document(OPERATIONS, "http://DRONE:3000/api/v1", "1")
    every = [operation for item in found["paths"].values() for operation in item.values()]
    count = Counter(line for operation in every for line in _parameters(operation).values())
    shared = {line for line, number in count.items() if number >= _SHARED}
    blocks = [_HEADER, "## Shared parameters\n", "\n".join([*(line for line in count if line in shared), ""])]
    for tag in (each["name"] for each in found["tags"]):
        blocks.append(f"## {tag}\n")
        if tag == FEATURES:
            blocks.append(_OF_FEATURES)
        for path, item in found["paths"].items():
            for method, operation in item.items():
                if tag in operation["tags"]:
                    blocks += _operation(method.upper(), path, operation, shared)
    blocks.append("## Values\n")
    for name, model in sorted(found["components"]["schemas"].items()):
        blocks += _model(name, model)
    return "\n".join(blocks)


def _parameters(operation: Mapping[str, Any]) -> dict[str, str]:
    """Return the line about each parameter of an address by its name, as it is written there."""
    return {
        f"`{each['name']}`": f"- `{each['name']}`: {_type(each['schema'])}. {_sentence(each['description'])}"
        for each in operation.get("parameters", ())
        if each["in"] == "query"
    }


def _operation(
    method: str, path: str, operation: Mapping[str, Any], shared: Collection[str]
) -> Iterator[str]:  # fmt: skip
    answers = operation["responses"]["200"]["content"]
    schemas = [content["schema"] for content in answers.values() if "schema" in content]
    answer = _type(schemas[0]) if schemas else f"a file: {', '.join(f'`{each}`' for each in answers)}"
    lines = [f"`{method} {ROOT}{path}`: {operation['summary']}. Answers {answer}"]
    body = operation.get("requestBody")
    if body is not None:
        (content,) = body["content"].values()
        lines[0] += f"; takes {_type(content['schema']) if 'schema' in content else 'the file'}"
    parameters = _parameters(operation)
    usual = [name for name, line in parameters.items() if line in shared]
    lines[0] += f". Takes {', '.join(usual)}.\n" if usual else ".\n"
    lines += [line for line in parameters.values() if line not in shared]
    yield "\n".join([*lines, *([""] if len(lines) > 1 else [])])


def _model(name: str, model: Mapping[str, Any]) -> Iterator[str]:
    yield f"### {name}\n"
    yield f"{_sentence(' '.join(model.get('description', '').replace('``', '`').split()))}\n"
    needed = set(model.get("required", ()))
    lines = []
    for key, value in model.get("properties", {}).items():
        default = value.get("default")
        words = f", default `{json.dumps(default)}`" if key not in needed and default not in (None, "", []) else ""
        about = f". {_sentence(value['description'])}" if "description" in value else ""
        lines.append(f"- `{key}`: {_type(value)}{words}{about}")
    if lines:
        yield "\n".join([*lines, ""])


def _type(value: Mapping[str, Any]) -> str:
    """Return the words for the type of a JSON schema, with its bounds; a question mark: it may be null."""
    if "$ref" in value:
        name = str(value["$ref"]).removeprefix(_SCHEMAS)
        return f"[{name}](#{name.lower()})"
    for key in ("anyOf", "oneOf"):
        if key in value and "type" not in value:
            kinds = list(dict.fromkeys(_type(each) for each in value[key]))
            return " or ".join(kind for kind in kinds if kind != "null") + ("?" if "null" in kinds else "")
    if "const" in value:
        return f"`{json.dumps(value['const'])}`"
    if "enum" in value:
        return ", ".join(f"`{json.dumps(each)}`" for each in value["enum"])
    if "prefixItems" in value:
        return f"[{', '.join(_type(each) for each in value['prefixItems'])}]"
    if value.get("type") == "array":
        return f"list of {_type(value['items'])}{_bounds(value, 'Items', ' items')}"
    if isinstance(value.get("additionalProperties"), dict):
        return f"object of {_type(value['additionalProperties'])}"
    kind = value.get("format") or value.get("type", "any value")
    return f"{kind}{_bounds(value, 'Length', ' characters')}"


def _bounds(value: Mapping[str, Any], kind: str, noun: str) -> str:
    least, most = value.get(f"min{kind}"), value.get(f"max{kind}")
    if least is None and most is None:
        least, most, noun = value.get("minimum"), value.get("maximum"), ""
    if least is None and most is None:
        return ""
    if least == most:
        return f", {least:g}{noun}"
    if most is None:
        return f", {least:g}{noun} or more"
    return f", {least or 0:g} to {most:g}{noun}"


def _sentence(text: str) -> str:
    """Return a text as a sentence: some begin with a small letter, and have no full stop."""
    text = text.replace("<", "\\<")
    return f"{text[:1].upper()}{text[1:]}{'' if text.endswith(('.', ':')) else '.'}" if text else ""


def main(arguments: list[str] | None = None) -> int:
    """Write the page, or check it; return the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("--check", action="store_true", help="fail when docs/api.md is out of date")
    text = page()
    if not parser.parse_args(arguments).check:
        TARGET.write_text(text, encoding="utf-8")
        return 0
    if not TARGET.is_file() or TARGET.read_text(encoding="utf-8") != text:
        print("docs/api.md is out of date: run python packaging/api_page.py", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
