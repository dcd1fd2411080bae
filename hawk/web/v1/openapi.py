"""The API's definition (OpenAPI 3.1), made of its table of addresses and the pydantic models of parameters, bodies and
answers.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import is_dataclass
from typing import Any, Final

from openapi_pydantic import Info, OpenAPI, PathItem, Reference, Server, Tag
from openapi_pydantic import Operation as Described
from openapi_pydantic.util import PydanticSchema, construct_open_api_with_schema_class
from openapi_pydantic.v3.v3_1 import (
    Components,
    Header,
    MediaType,
    Parameter,
    RequestBody,
    Response,
    SecurityScheme,
)
from pydantic import BaseModel

from hawk.web.v1.answers import PROBLEM
from hawk.web.v1.bodies import Problem
from hawk.web.v1.operations import Operation
from hawk.web.v1.parameters import AGAIN, Query
from hawk.web.v1.unknown import PATTERNS

TITLE: Final = "hawk"
VERSION: Final = "1"
WORDS: Final = """Lots, layouts, stalls, zones, surveys, observations, statistics and recordings of a drone or a desk.

Viewers may read, operators may change; drones send surveys, and read lots. Lists come in parts: `next` of one part is
`after` of the next one. An answer has an ETag: send it as `If-None-Match` to the same address, and 304 says that
nothing has changed. A refusal is a problem (RFC 9457) that names the value and the remedy. Times are UTC, angles
radians, lengths metres, where nothing else is said."""
_FIELDS: Final = {
    "id": "id (UUID)",
    "version": "version of the layout",
    "seq": "number of the change",
    "name": "name of the recording",
    "collection": "name of the collection",
    "survey": "id of a survey (UUID)",
    "token": "token of a link",
    "preview": "token of the preview",
    "kind": "kind of the file; `zip` holds the rasters",
    "feed": "name of the feed",
    "file": "name of the file",
    "number": "number of the picture or map, from 0",
    "row": "row of the tile",
    "column": "column of the tile",
}
"""Fields of paths."""
_SCHEMAS: Final = "#/components/schemas/"
_ANY_FILE: Final = "application/octet-stream"
_TOKEN: Final = "token"  # noqa: S105 - the scheme's name
FOR_DRONES: Final = "For drones."
_ETAG: Final = {"description": "changes with every change of the store", "schema": {"type": "string"}}


def document(operations: tuple[Operation, ...], base: str, version: str) -> dict[str, Any]:
    """Return the definition as JSON values.

    Args:
        operations: Every address.
        base: Address under which all of them lie.
        version: Version of the program.
    """
    paths: dict[str, PathItem] = {}
    for each in operations:
        item = paths.setdefault(each.path, PathItem())
        setattr(item, each.method.lower(), _described(each))
    tags = [Tag(name=tag) for tag in dict.fromkeys(each.tag for each in operations)]
    scheme = SecurityScheme(type="http", scheme="bearer", description="a token of a viewer, an operator or a drone")
    made = OpenAPI(
        openapi="3.1.0",
        info=Info(title=TITLE, version=version, description=WORDS),
        servers=[Server(url=base)],
        tags=tags,
        paths=paths,
        security=[{_TOKEN: []}, {}],
        components=Components(securitySchemes={_TOKEN: scheme}),
    )
    values: list[Any] = [each.answer for each in operations if is_dataclass(each.answer)]
    whole = construct_open_api_with_schema_class(made, values)
    found: dict[str, Any] = json.loads(whole.model_dump_json(by_alias=True, exclude_none=True, exclude_defaults=True))
    return found


def _described(operation: Operation) -> Described:
    answers: dict[str, Response] = {"200": _answer(operation)}
    if _has_tag(operation):
        answers["304"] = Response(description="the client has this answer already, by its ETag")
    answers["4XX"] = _problem("refused: the value that is meant, and the remedy")
    answers["5XX"] = _problem("busy or broken: ask again later")
    return Described(
        operationId=operation.name,
        summary=operation.text,
        description=_for_whom(operation),
        tags=[operation.tag],
        parameters=[*_in_path(operation), *_in_query(operation.query)] or None,
        requestBody=_file()
        if operation.takes_file
        else None
        if operation.body is None
        else _body(operation.body, operation.body_type),
        responses=answers,
        security=[{}] if operation.is_open else None,
    )


def _for_whom(operation: Operation) -> str | None:
    if operation.for_drones:
        return FOR_DRONES
    return "For operators." if operation.is_change or operation.for_operators else None


def _has_tag(operation: Operation) -> bool:
    return operation.has_tag and not operation.is_change


def _answer(operation: Operation) -> Response:
    shown = MediaType()
    if operation.answer is not None:
        shown = MediaType(media_type_schema=_schema(operation.answer))
    content = dict.fromkeys(operation.content_types, shown)
    headers: dict[str, Header | Reference] | None = None
    if _has_tag(operation):
        headers = {"ETag": Header.model_validate(_ETAG)}
    return Response(description=operation.text, headers=headers, content=content)


def _schema(answer: type[Any]) -> PydanticSchema[Any] | Reference:
    """Return the schema of an answer; openapi_pydantic takes a dataclass by its name alone."""
    if is_dataclass(answer):
        return Reference.model_validate({"$ref": f"{_SCHEMAS}{answer.__name__}"})
    return PydanticSchema(schema_class=answer)


def _problem(words: str) -> Response:
    content = {PROBLEM: MediaType(media_type_schema=PydanticSchema(schema_class=Problem))}
    return Response(description=words, content=content)


def _body(model: type[BaseModel], content_type: str) -> RequestBody:
    content = {content_type: MediaType(media_type_schema=PydanticSchema(schema_class=model))}
    is_needed = any(field.is_required() for field in model.model_fields.values())
    return RequestBody(required=is_needed, content=content)


def _file() -> RequestBody:
    return RequestBody(required=True, content={_ANY_FILE: MediaType()}, description="the file, as it is")


def _in_path(operation: Operation) -> Iterator[Parameter]:
    for name in operation.fields:
        values = {"type": "string", "pattern": f"^({PATTERNS[name]})$"}
        facts = {"name": name, "in": "path", "required": True, "description": _FIELDS[name]}
        yield Parameter.model_validate({**facts, "schema": values})


def _in_query(model: type[Query]) -> Iterator[Parameter]:
    for name, values in model.model_json_schema(by_alias=True).get("properties", {}).items():
        shown = _given(values)
        is_again = shown.pop(AGAIN, False)
        form = {"style": "form", "explode": is_again} if shown.get("type") == "array" else {}
        facts = {"name": name, "in": "query", "description": shown.pop("description", None)}
        yield Parameter.model_validate({**facts, **form, "schema": shown})


def _given(values: dict[str, Any]) -> dict[str, Any]:
    """Return the schema of a parameter that is there: null is none."""
    shown = {key: value for key, value in values.items() if key != "title" and not (key == "default" and value is None)}
    kinds = [each for each in shown.get("anyOf", ()) if each != {"type": "null"}]
    shown.pop("anyOf", None)
    return shown | (kinds[0] if len(kinds) == 1 else {"anyOf": kinds} if kinds else {})
