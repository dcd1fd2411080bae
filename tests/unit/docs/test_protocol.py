"""The protocol's page is that of the messages, and its examples are sent: to the parser, and to the web server."""

from __future__ import annotations

import json
import re
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from aiohttp import web

from hawk.comm.protocol.base import Outgoing
from hawk.comm.protocol.commands import Ack, FenceCheck, KillToken, RouteAnswer, Welcome, parse_command, schema
from hawk.comm.protocol.heartbeat import (
    DroneStatus,
    HealthItem,
    Heartbeat,
    OperationStatus,
    PartsStatus,
    PerceptionStatus,
    SiteStatus,
    TravelStatus,
    VehicleStatus,
)
from hawk.model.lot_map import Counts, EncodedTile, OccupancyMap, Stall, StallState
from hawk.model.operation import StateName
from hawk.results.survey_map import Made
from hawk.web.v1.unknown import ROOT as ROOT_OF_API
from tests.sweep import sweep
from tests.unit.docs.scripts import load
from tests.unit.web.rig import Rig, Visitor, browser

ROOT = Path(__file__).parents[3]
protocol_page = load("protocol_page")
PAGE = (ROOT / "docs" / "protocol.md").read_text(encoding="utf-8")
MESSAGES = {
    "toDrone": list(protocol_page.sent_examples().values()),
    "fromDrone": json.loads(protocol_page.MESSAGES.read_text(encoding="utf-8"))["fromDrone"],
}
REQUESTS: list[dict[str, Any]] = json.loads(protocol_page.REQUESTS.read_text(encoding="utf-8"))
INCOMING: dict[str, type[Outgoing]] = {
    "Ack": Ack,
    "Fence Check": FenceCheck,
    "Heartbeat": Heartbeat,
    "Kill Token": KillToken,
    "Route": RouteAnswer,
    "Welcome": Welcome,
}
STALL = Stall(17, 21.4, -3.1, 1.57, 2.5, 5.0, 0.04, StallState.FREE, 0.97, 9, 207.9, 4)
PICTURE = cv2.imencode(".jpg", np.full((256, 256, 3), 90, np.uint8))[1].tobytes()
MAP = OccupancyMap(
    mosaic={(0, -1): EncodedTile(7, PICTURE)},
    stalls={17: STALL},
    counts=Counts(1, 0, 0),
    lot_area_m2=120.0,
    map_id="20260501T092644Z",
)
STATUS = DroneStatus(
    operation=OperationStatus(state=StateName.HOVER),
    vehicle=VehicleStatus(armed=False),
    site=SiteStatus(datum=(60.1693, 24.9393)),
    perception=PerceptionStatus(explored=0.62, free_range=(1, 2)),
    travel=TravelStatus(flight_time=96.2, distance_flown=213.0),
    parts=PartsStatus(health=(HealthItem(name="camera", healthy=False, reason="No picture for 3 s"),)),
)


@pytest.mark.slow
def test_the_page_is_what_the_command_writes() -> None:
    assert protocol_page.page() == PAGE, "run: python packaging/protocol_page.py"


@sweep("example", MESSAGES["toDrone"])
def test_a_command_is_taken_as_it_stands(example: dict[str, Any]) -> None:
    command = parse_command(json.dumps(example))
    assert command.model_dump(by_alias=True, exclude_unset=True) == example


@sweep("example", MESSAGES["fromDrone"])
def test_a_message_of_the_drone_is_whole(example: dict[str, Any]) -> None:
    message = INCOMING[example["Type"]].model_validate_json(json.dumps(example))
    assert json.loads(message.to_json()) == example


def test_every_message_has_an_example_and_its_keys_are_on_the_page() -> None:
    models = schema()
    sent = [model for model in models["toDrone"]["$defs"].values() if "Type" in model["properties"]]
    for direction, found in (("toDrone", sent), ("fromDrone", list(models["fromDrone"].values()))):
        kinds = {model["properties"]["Type"]["const"] for model in found}
        assert kinds == {each["Type"] for each in MESSAGES[direction]}
    to_drone, from_drone = PAGE.split("## From the drone\n")
    for text, found in ((to_drone, sent), (from_drone, list(models["fromDrone"].values()))):
        for model in found:
            kind = model["properties"]["Type"]["const"]
            (section,) = re.findall(rf"^### {re.escape(kind)}\n(.*?)(?=^### |^## |\Z)", text, re.MULTILINE | re.DOTALL)
            keys = set(model["properties"]) - {"Type", "Id"}
            named = " ".join(re.findall(r"^- (`.*?)(?:\. |$)", section, re.MULTILINE))
            if text is from_drone:  # the example has the others: a message of the drone is whole
                texts = protocol_page.field_texts(model["title"])
                keys &= {key for key, text in texts.items() if len(text.split()) > protocol_page.PLAIN}
                keys -= set(protocol_page.ELSEWHERE)
            assert keys <= set(re.findall(r"`([^`]+)`", named)), kind


def test_texts_of_fields_come_from_the_class_and_its_bases() -> None:
    texts = protocol_page.field_texts("CompulsiveMove")
    assert texts["Frame"].startswith("Relative: metres north")
    assert "absent: the present height" in texts["Height"]


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ({"type": "number", "minimum": -10, "maximum": 10}, "number{-10..10}"),
        ({"type": "number", "exclusiveMinimum": 0, "maximum": 1000}, "number{>0..1000}"),
        ({"type": "string", "minLength": 16, "maxLength": 128}, "string{16..128}"),
        ({"anyOf": [{"type": "number"}, {"type": "null"}]}, "number?"),
        ({"type": "array", "minItems": 2, "items": {"$ref": "/Point"}}, "[Point](#point)[]{2..}"),
        ({"enum": ["a", "b"]}, '`"a"|"b"`'),
    ],
)  # fmt: skip
def test_each_type_has_its_words(value: dict[str, Any], words: str) -> None:
    assert protocol_page._type(value) == words


# -- requests ---------------------------------------------------------------------------------------------------------


@pytest.fixture
async def rig() -> AsyncIterator[Rig]:
    made = Rig()
    await made.start()
    made.map.publish(MAP)
    made.publish(STATUS)
    yield made
    assert made.server is not None
    await made.server.close()


@pytest.mark.slow
@pytest.mark.parametrize("example", REQUESTS, ids=lambda each: f"{each['method']} {each['route']}")
async def test_a_request_is_answered_as_the_page_says(
    rig: Rig, example: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Made, "now", lambda survey: Made(survey, "2026-05-01T09:41:31Z", "hawk-drone 0.3.0"))
    assert rig.server is not None
    url = rig.server.make_url(example["path"])
    async with browser() as session, session.request(example["method"], url, allow_redirects=False) as response:
        assert (response.status, response.content_type) == (example["status"], example["type"])
        if "body" in example:
            assert await response.json() == example["body"]
        if "keys" in example:
            assert set(await response.json(content_type=None)) == set(example["keys"])
        lines = set((await response.text()).splitlines()) if "lines" in example else set()
        assert set(example.get("lines", ())) <= lines


async def test_every_address_of_the_server_is_on_the_page(rig: Rig) -> None:
    assert rig.app is not None
    routes = {
        (route.method, re.sub(r"\{(\w+)[^}]*\}", r"{\1}", route.resource.canonical))
        for route in rig.app.router.routes()
        if route.resource is not None and route.method != "HEAD"
    }
    others = {route for route in routes if not route[1].startswith(ROOT_OF_API)}  # docs/api.md has these
    assert others == {(each["method"], each["route"]) for each in REQUESTS}
    assert isinstance(rig.app, web.Application)


async def test_a_conversation_goes_as_the_page_says(rig: Rig) -> None:
    assert rig.server is not None
    examples = {each["Type"]: each for each in MESSAGES["toDrone"]}
    async with browser() as session, session.ws_connect(rig.server.make_url("/ws")) as socket:
        visitor = Visitor(socket)
        await visitor.next("Welcome")
        taken = await ask(visitor, examples["Control"], "Ack")
        assert taken == {"Type": "Ack", "Id": examples["Control"]["Id"], "Accepted": True, "Reason": ""}
        token = await ask(visitor, examples["Kill Request"], "Kill Token")
        assert token["Id"] == examples["Kill Request"]["Id"]
        refused = await ask(visitor, examples["Hold"] | {"Speed": 3}, "Ack")
        assert refused["Reason"] == "Speed: is no key of a Hold; leave it out"


async def ask(visitor: Visitor, message: dict[str, Any], kind: str) -> dict[str, Any]:
    await visitor.send(**message)
    return await visitor.next(kind)
