"""The API's definition: every address is in it, it is OpenAPI 3.1 by the standard's own schema, and answers keep it."""

from __future__ import annotations

import json
from typing import Any

import jsonschema
import pytest
from openapi_pydantic import OpenAPI

from hawk.web.v1.operations import Operation
from hawk.web.v1.table import OPERATIONS
from hawk.web.v1.unknown import ROOT
from tests.sweep import sweep
from tests.unit.web.v1.archive import Archive


async def defined(archive: Archive) -> dict[str, Any]:
    response = await archive.ask("/openapi.json")
    assert response.content_type == "application/vnd.oai.openapi+json"
    found: dict[str, Any] = await response.json(content_type=None)
    return found


@pytest.mark.nightly
async def test_every_address_is_defined_with_its_server(archive: Archive) -> None:
    found = await defined(archive)
    OpenAPI.model_validate(found)
    assert found["openapi"] == "3.1.0"
    assert found["servers"] == [{"url": str(archive.address("/lots")).removesuffix("/lots")}]
    named = {(method.upper(), path) for path, item in found["paths"].items() for method in item}
    assert named == {(each.method, each.path) for each in OPERATIONS}
    assert archive.stand.rig.app is not None
    routes = {
        (route.method, route.resource.canonical)
        for route in archive.stand.rig.app.router.routes()
        if route.resource is not None and route.method not in ("HEAD", "*")
        if route.resource.canonical.startswith(ROOT)
    }
    assert routes == {(each.method, f"{ROOT}{each.path}") for each in OPERATIONS} | {("GET", f"{ROOT}/openapi.json")}
    ids = [operation["operationId"] for item in found["paths"].values() for operation in item.values()]
    assert len(ids) == len(set(ids))


@pytest.mark.slow
async def test_the_definition_is_sent_once(archive: Archive) -> None:
    tag = (await archive.ask("/openapi.json")).headers["ETag"]
    assert (await archive.ask("/openapi.json", If_None_Match=tag)).status == 304
    assert (await archive.refused("/openapi.json?colour=red"))[0] == 422


@pytest.mark.nightly
def test_the_schemas_are_valid_and_every_reference_leads_somewhere() -> None:
    from hawk.web.v1.openapi import document

    found = document(OPERATIONS, "http://drone", "1")
    schemas = found["components"]["schemas"]
    for schema in schemas.values():
        jsonschema.Draft202012Validator.check_schema(schema)
    text = json.dumps(found)
    for part in text.split('"#/components/schemas/')[1:]:
        assert part.partition('"')[0] in schemas


@pytest.mark.nightly
@sweep("operation", OPERATIONS)
def test_every_address_says_what_it_takes_and_answers(operation: Operation) -> None:
    from hawk.web.v1.openapi import document

    described = document((operation,), "http://drone", "1")["paths"][operation.path][operation.method.lower()]
    assert described["summary"]
    has_tag = operation.has_tag and not operation.is_change
    assert set(described["responses"]) == {"200", "4XX", "5XX"} | ({"304"} if has_tag else set())
    assert set(operation.content_types) == set(described["responses"]["200"]["content"])
    for each in described.get("parameters", ()):
        assert each["description"], each["name"]
        assert each["schema"] != {}, each["name"]
    assert ("requestBody" in described) is operation.is_change
    assert (described.get("security") == [{}]) is ("{token}" in operation.path)
