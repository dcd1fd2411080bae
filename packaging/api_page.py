"""Write the reference of the API from its definition, which is made of `hawk.web.v1.table` and pydantic models.

``python packaging/api_page.py`` writes ``docs/api.md``; ``--check`` fails when that is out of date.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, Final

from hawk.web.v1.openapi import FOR_DRONES, document
from hawk.web.v1.table import FEATURES, OPERATIONS
from hawk.web.v1.unknown import ROOT

TARGET: Final = Path(__file__).resolve().parent.parent / "docs" / "api.md"
_SCHEMAS: Final = "#/components/schemas/"
_HEADER: Final = """# The API

Written by `packaging/api_page.py` from `hawk/web/v1/table.py` and its models: change those and run this again.

Programs read and change lots, plans, surveys, statistics and recordings here. A drone and a
[desk](how-to/correct-the-plan.md#at-a-desk) answer alike. This page has the addresses and all that a JSON request
sends; the definition, OpenAPI 3.1, has every field of answers and documents, too:
`http://DRONE:3000/api/v1/openapi.json`. Addresses of the present flight are in [Protocol](protocol.md#http).

    curl -s -H "Authorization: Bearer TOKEN" "http://DRONE:3000/api/v1/lots?limit=10"
    curl -s "http://127.0.0.1:3000/api/v1/lots/LOT/statistics?from=2026-05-04&to=2026-05-10&by=row"
    curl -s -d '{"name": "North Street"}' http://127.0.0.1:3000/api/v1/lots/LOT/name

- Viewers read, operators change ([roles](access.md)). Where the daemon has tokens, send `Authorization: Bearer TOKEN`.
- In parentheses stands the answer, or the type of the file. `Name[]` is an object with `items` and `next`: a list
  comes in parts, and takes `limit` and `after`. `next` is `after` of the next part, `null` at the end; the header
  `Link` has its address. A part begins behind the last item of the one before.
- An answer has an `ETag`. Send it as `If-None-Match` to the same address: 304 says that nothing has changed.
  `Accept-Encoding: gzip` packs answers.
- A refusal is a `Problem`, `application/problem+json` (RFC 9457): `detail` says what is wrong and the remedy, `field`
  names the value. 400 and 422: a value; 401: no token; 403: the role, or another server's page; 404: an id;
  409: it does not fit what is there; 503: busy, ask again.
- A request takes 10 s at most; no flight waits for it.
- Where nothing else is said, times are UTC (RFC 3339), lengths metres, angles radians, places degrees of WGS-84,
  latitude first, and ids UUIDs. `integer` is 0 or more. Types are written as in TypeScript: `[]` a list, `|` or, `?`
  may be null; braces hold the least and the greatest value, number of characters, or number of items. A field without
  a type is a [shared one](#shared-fields), else a string. The `do` of an operation is its name, as `add_row` of AddRow.
"""
_OF_FEATURES: Final = """The collections `lots`, `stalls` and `surveys` by OGC API Features, Part 1 (Core, GeoJSON),
read only, for QGIS, GDAL and their like: [how QGIS opens them](how-to/open-lots-in-qgis.md). Answers are those of the
standard. A lot has the time of its last survey, a stall that of the last look at it, a survey that of its flight.
"""
_GET: Final = "GET "
_JSON: Final = "application/json"
"""Type of the bodies that are described here: one of another type, or that drones send, is a program's alone."""
_LEAST_CONTAINED: Final = 3
"""Fields of a value that a larger one names as a whole."""
_OFTEN: Final = 4
"""Parameters from which on an address whose query is an earlier one's names that address."""
_LIST: Final = ("limit", "after")
"""Parameters of every list."""


def page() -> str:
    """Return the page (Markdown)."""
    found = document(OPERATIONS, "http://DRONE:3000/api/v1", "1")
    schemas: dict[str, Any] = found["components"]["schemas"]
    operations = [
        (f"{method.upper()} {ROOT}{path}", operation)
        for path, item in found["paths"].items()
        for method, operation in item.items()
    ]
    parameters = _repeated(_parameter(each) for _, operation in operations for each in _in_query(operation))
    by_persons = [each for _, each in operations if "requestBody" in each and each.get("description") != FOR_DRONES]
    sent = _reached([each["requestBody"]["content"].get(_JSON) for each in by_persons], schemas)
    values = {name: _fields(name, each) for name, each in sorted(schemas.items()) if name in sent}
    wider = {name: _contained(name, values) for name in values}
    own = {name: dict(each.items() - values.get(wider[name], {}).items()) for name, each in values.items()}
    fields = _repeated(pair for each in own.values() for pair in each.items() if ". " in pair[1] or "|" in pair[1])
    blocks = [_HEADER, "## Shared parameters\n", *_list(dict(sorted(parameters)))]
    said: dict[str, str] = {}
    for tag in (each["name"] for each in found["tags"]):
        blocks.append(f"## {tag}\n")
        if tag == FEATURES:
            blocks.append(_OF_FEATURES)
        lines = [_operation(*each, schemas, parameters, said) for each in operations if tag in each[1]["tags"]]
        blocks.append("\n".join([*lines, ""]))
    blocks.append("## Shared fields\n")
    blocks += [*_list(dict(sorted(fields))), "## Values\n"]
    for name, found_fields in values.items():
        if found_fields:
            about = _sentence(" ".join(schemas[name].get("description", "").replace("``", "`").split()))
            own_fields = {key: words for key, words in found_fields.items() if key in own[name]}
            rows = "".join(_fields_sent(wider[name], own_fields, fields))
            is_one = rows.count("\n") == 1
            blocks += [f"### {name}\n", *([f"{about} {rows[2:]}"] if is_one else [f"{about}\n", rows])]
    return re.sub(r"\[(\w+)\]\(#\w+\)", lambda each: each[0] if each[1] in sent else f"`{each[1]}`", "\n".join(blocks))


def _reached(given: Any, schemas: Mapping[str, Any]) -> set[str]:
    """Return the names of the values that a part of the definition names, and that these name."""
    found: set[str] = set()
    waiting = [given]
    while waiting:
        match waiting.pop():
            case {"$ref": str(reference)} if (name := reference.removeprefix(_SCHEMAS)) not in found:
                found.add(name)
                waiting.append(schemas[name])
            case dict() as values:
                waiting += values.values()
            case list() as values:
                waiting += values
    return found


def _repeated(pairs: Iterable[tuple[str, str]]) -> set[tuple[str, str]]:
    """Return names with their words that are there several times; of two that share a name, the commonest."""
    found: dict[str, tuple[str, str]] = {}
    for pair, count in Counter(pairs).most_common():
        if count > 1:
            found.setdefault(pair[0], pair)
    return set(found.values())


def _in_query(operation: Mapping[str, Any]) -> list[dict[str, Any]]:
    return [each for each in operation.get("parameters", ()) if each["in"] == "query"]


def _parameter(given: Mapping[str, Any]) -> tuple[str, str]:
    return given["name"], f"{_type(given['schema'])}. {_sentence(given['description'])}"


def _is_list(model: Mapping[str, Any]) -> bool:
    """Return True for one part of a list, which the rules at the top describe."""
    return set(model.get("properties", ())) == {"items", "next"}


def _operation(
    address: str, operation: Mapping[str, Any], schemas: Mapping[str, Any], shared: set[tuple[str, str]],
    said: dict[str, str],
) -> str:  # fmt: skip
    """Return the lines of an address; one that answers, or is asked, as an earlier one (``said``) names that."""
    answers = operation["responses"]["200"]["content"]
    found = [each["schema"] for each in answers.values() if "schema" in each]
    answer = _answer(found[0], schemas) if found else ", ".join(f"`{each}`" for each in answers)
    words = operation["summary"] + ("" if FEATURES in operation["tags"] else f" ({answer})")
    body = operation.get("requestBody")
    if body is not None:
        (content,) = body["content"].values()
        takes = _taken(content["schema"], schemas) if "schema" in content else "the file"
        words += f"; takes {takes}" if takes else ""
    parameters = [_parameter(each) for each in _in_query(operation)]
    is_list = bool(found) and _is_list(schemas.get(_name(found[0]), {}))
    if is_list and not {_LIST[0], _LIST[1]} <= {name for name, _ in parameters}:
        raise ValueError(f"{address}: a list without {' and '.join(_LIST)}")
    left_out = _LIST if is_list else ()
    short = [f"`{name}`" for name, text in parameters if (name, text) in shared and name not in left_out]
    query = ", ".join(short)
    more = "".join(f"  - `{name}`: {text}\n" for name, text in parameters if (name, text) not in shared)
    former = said.setdefault("\n".join([words, query, more]), address)
    if former != address:
        return f"- `{address}`: As `{former.removeprefix(_GET)}`."
    asked = said.setdefault(query, address) if len(short) > _OFTEN else address
    words += f". Query: {query if asked == address else f'as `{asked.removeprefix(_GET)}`'}.\n" if short else ".\n"
    return f"- `{address}`: {words}{more}".rstrip()


def _answer(schema: Mapping[str, Any], schemas: Mapping[str, Any]) -> str:
    model = schemas.get(_name(schema), {})
    return _type(model["properties"]["items"] if _is_list(model) else schema)


def _name(schema: Mapping[str, Any]) -> str:
    return str(schema.get("$ref", "")).removeprefix(_SCHEMAS)


def _taken(schema: Mapping[str, Any], schemas: Mapping[str, Any]) -> str:
    """Return the words for a body; none for one without values."""
    model = schemas.get(_name(schema), {"properties": {"": {}}})
    return _type(schema) if model.get("properties") else ""


def _contained(name: str, values: Mapping[str, Mapping[str, str]]) -> str:
    """Return the value with most fields, three or more, all of which a value has as well; empty when there is none.

    Of values with the same fields it is the first one.
    """
    fields = values[name].items()
    found = [
        other
        for other, each in values.items()
        if len(each) >= _LEAST_CONTAINED and (each.items() < fields or (each.items() == fields and other < name))
    ]
    return max(found, key=lambda other: len(values[other]), default="")


def _described(fields: Mapping[str, str], shared: set[tuple[str, str]]) -> dict[str, str]:
    """Return the fields with words of their own."""
    return {key: words for key, words in fields.items() if (key, words) not in shared and ". " in words}


def _fields_sent(wider: str, fields: Mapping[str, str], shared: set[tuple[str, str]]) -> Iterator[str]:
    """Yield the lines of all fields of a value that a request sends."""
    described, names = _described(fields, shared), {key for key, _ in shared}
    alike: dict[str, list[str]] = {}
    for key, words in fields.items():
        if key not in described:
            is_plain = (key, words) in shared or (words == "string" and key not in names)
            alike.setdefault("" if is_plain else f": {words}", []).append(f"`{key}`")
    short = [f"{', '.join(keys)}{words}" for words, keys in sorted(alike.items(), key=lambda each: each[0] != "")]
    short += [f"all of [{wider}](#{wider.lower()})"] * bool(wider)
    yield "".join([f"- {'; '.join(short)}\n" if short else "", *_list(described)])


def _fields(name: str, model: Mapping[str, Any]) -> dict[str, str]:
    """Return the words of each field of a value. The name of an operation, ``do``, follows from the value's."""
    needed = set(model.get("required", ()))
    found = {}
    for key, value in model.get("properties", {}).items():
        if key == "do" and value.get("const") == re.sub(r"\B([A-Z])", r"_\1", name).lower():
            continue
        default = value.get("default")
        words = (
            f"=`{json.dumps(default, separators=(',', ':'))}`"
            if key not in needed and default not in (None, "", [])
            else ""
        )
        about = f". {_sentence(value['description'])}" if value.get("description", "UTC") != "UTC" else ""
        found[key] = f"{_type(value)}{words}{about}"
    return found


def _list(described: Mapping[str, str]) -> Iterator[str]:
    """Yield names with their words, those of the same words in one line."""
    alike: dict[str, list[str]] = {}
    for name, words in described.items():
        alike.setdefault(words, []).append(f"`{name}`")
    if alike:
        yield "".join(f"- {', '.join(names)}: {words}\n" for words, names in alike.items())


def _type(value: Mapping[str, Any]) -> str:
    """Return the words for the type of a JSON schema, with its bounds; a question mark: it may be null."""
    if "$ref" in value:
        name = str(value["$ref"]).removeprefix(_SCHEMAS)
        return f"[{name}](#{name.lower()})"
    for key in ("anyOf", "oneOf"):
        if key in value and "type" not in value:
            kinds = list(dict.fromkeys(_type(each) for each in value[key]))
            return "|".join(kind for kind in kinds if kind != "null") + ("?" if "null" in kinds else "")
    if "const" in value:
        return f"`{json.dumps(value['const'])}`"
    if "enum" in value:
        return f"`{'|'.join(json.dumps(each) for each in value['enum'])}`"
    if "prefixItems" in value:
        return f"[{','.join(_type(each) for each in value['prefixItems'])}]"
    if value.get("type") == "array":
        return f"{_type(value['items'])}[]{_bounds(value, 'Items')}"
    if isinstance(value.get("additionalProperties"), dict):
        return f"object of {_type(value['additionalProperties'])}"
    kind = value.get("format") or value.get("type", "any value")
    return f"{kind}{_bounds(value, 'Length')}"


def _bounds(value: Mapping[str, Any], kind: str) -> str:
    least, most = value.get(f"min{kind}"), value.get(f"max{kind}")
    if least is None and most is None:
        least, most = value.get("minimum"), value.get("maximum")
    if most is None:
        return f"{{{least:g}..}}" if least else ""
    return f"{{{most:g}}}" if least == most else f"{{{least or 0:g}..{most:g}}}"


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
