"""A role for some lots: of everything else each operation says nothing, and changes nothing."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Final

import aiohttp
import pytest
from aiohttp import web
from aiohttp.test_utils import make_mocked_request
from sqlalchemy import Connection, select, update

from hawk.comm.protocol.authority import Role
from hawk.exports.formats import FEEDS
from hawk.lots import reach
from hawk.lots.storage.schema import LOT, STALL, SURVEY
from hawk.web.access.access import ACCESS, Access
from hawk.web.access.tokens import TOKEN_FILE, remove_person, rotate_person
from hawk.web.v1.bounds import FOR_ALL_LOTS, bounded, ids_asked
from hawk.web.v1.operations import Bound, Operation
from hawk.web.v1.table import OPERATIONS
from tests.sweep import sweep
from tests.unit.lots.surveys import box
from tests.unit.web.v1.archive import Archive

OURS: Final = "The lot of Ada"
THEIRS: Final = "Nobody else's lot"
UNKNOWN: Final = "f" * 36
REFUSED: Final = {
    "merge", "split", "move_survey", "preview_lot", "begin_lot", "due_rounds", "day_plan", "arrivals", "put_document",
    "put_lot_document", "changed_lots", "put_picture", "recordings", "recording", "film", "film_picture", "film_map",
    "keep_recording", "delete_recording", "recordings_of_survey", "ask_recordings", "offer_recordings",
    "put_recording_part",
}  # fmt: skip
"""Operations that no role for some lots may do. Who adds one says its bound, or names it here."""
NAMED: Final = (Bound.LOT, Bound.SURVEY, Bound.STALL, Bound.SHARE, Bound.CHANGE)
READ: Final = [
    each for each in OPERATIONS
    if each.method == "GET" and each.bound not in (None, Bound.LINK) and not each.path.endswith((".pdf", ".xlsx"))
]  # fmt: skip
"""Reads that have a bound; PDF and workbook are made of what the document is made of, and packed."""


@dataclass
class Parted:
    """An archive of two lots on the same ground, and the programs of Ada, whose tokens are for the first one."""

    archive: Archive
    viewer: aiohttp.ClientSession
    operator: aiohttp.ClientSession
    ours: dict[str, str]
    theirs: dict[str, str]

    async def ask(self, path: str, role: str = "viewer", method: str = "GET", **given: Any) -> tuple[int, bytes]:
        session = self.operator if role == "operator" else self.viewer
        async with session.request(method, self.archive.address(path), **given) as response:
            return response.status, await response.read()


@pytest.fixture
async def parted(archive: Archive, tmp_path: Path) -> Parted:
    """Both lots have a name, a change and a link of their own."""
    ids = []
    for lot, name in ((archive.lot, OURS), (archive.far, THEIRS)):
        seq = (await archive.done(f"/lots/{lot}/name", name=name))["seq"]
        share = (await archive.done(f"/lots/{lot}/shares", days=1))["id"]
        found = await archive.store.read(partial(_of_lot, lot=lot))
        ids.append({"lot": lot, **found, "seq": str(seq), "share": share})
    await archive.store.write(lambda connection: _on_same_ground(connection, archive.lot, archive.far))
    path = tmp_path / TOKEN_FILE
    made = {role: rotate_person(path, f"Ada {role}", role, [archive.lot]) for role in Role}
    await archive.stand.look()
    viewer, operator = [
        await archive.stand.browser(headers={"Authorization": f"Bearer {made[role]}", "Accept-Encoding": "identity"})
        for role in (Role.VIEWER, Role.OPERATOR)
    ]
    return Parted(archive, viewer, operator, *ids)


def _of_lot(connection: Connection, lot: str) -> dict[str, str]:
    survey = connection.execute(select(SURVEY.c.id).where(SURVEY.c.lot == lot).order_by(SURVEY.c.seq)).scalars().first()
    stall = connection.execute(select(STALL.c.id).where(STALL.c.lot == lot).order_by(STALL.c.key)).scalars().first()
    return {"survey": str(survey), "stall": str(stall)}


def _on_same_ground(connection: Connection, lot: str, other: str) -> None:
    names = ("outline", "latitude", "longitude")
    row = connection.execute(select(LOT).where(LOT.c.id == lot)).mappings().one()
    connection.execute(update(LOT).where(LOT.c.id == other).values({name: row[name] for name in names}))


def path_of(operation: Operation, ids: dict[str, str], **chosen: str) -> str:
    """Return the path of an operation that names what some ids are of."""
    kind = operation.bound.value if operation.bound in NAMED else "lot"
    if operation.bound is None and operation.path.startswith("/surveys"):
        kind = "survey"
    values = {**ids, "id": ids.get(kind, ""), "version": "1", "kind": "geojson", "row": "0", "column": "0",
              "feed": next(iter(FEEDS)), "collection": "lots", "preview": "0" * 32, "name": "20260101T000000Z.mcap",
              "number": "1", "file": "a.jpg", **chosen}  # fmt: skip
    path = operation.path
    for field in operation.fields:
        path = path.replace(f"{{{field}}}", values[field])
    return path


def asked_of(operation: Operation, ids: dict[str, str]) -> dict[str, str]:
    """Return the parameters of an operation that must be there."""
    return {"before": ids["survey"], "after": ids["survey"]} if operation.name == "between" else {}


def test_each_operation_says_its_bound_or_is_refused() -> None:
    assert {each.name for each in OPERATIONS if each.bound is None} == REFUSED
    for each in OPERATIONS:
        assert (each.bound is Bound.LINK) == each.is_open, each.name
        if each.bound in NAMED:
            assert ("seq" if each.bound is Bound.CHANGE else "id") in each.fields, each.name
            begin = {Bound.LOT: "/lots/", Bound.SURVEY: "/surveys/", Bound.STALL: "/stalls/", Bound.SHARE: "/shares/"}
            assert each.path.startswith(begin.get(each.bound, "/changes/")), f"{each.name}: another thing is named"
        ids_asked(each.query)  # KeyError: who adds a parameter with an id says the kind of what it names


@pytest.mark.fault(
    "an operation is added without a bound, and a person with a role for some lots asks for it",
    "403; its handler is not called",
)
async def test_an_operation_without_a_bound_is_refused() -> None:
    async def handler(_: web.Request) -> web.StreamResponse:
        raise AssertionError("it was called")

    request = make_mocked_request("GET", "/api/v1/new")
    request[ACCESS] = Access(Role.OPERATOR, person="Ada", lots=frozenset({UNKNOWN}))
    with pytest.raises(web.HTTPForbidden) as refused:
        await bounded(replace(OPERATIONS[0], handler=handler, bound=None))(request)
    assert refused.value.text == FOR_ALL_LOTS
    request[ACCESS] = Access(Role.VIEWER)
    with pytest.raises(AssertionError):
        await bounded(replace(OPERATIONS[0], handler=handler, bound=None))(request)


@pytest.mark.fault(
    "a person with a role for some lots asks for another one, its surveys, stalls, changes, links, by each operation",
    "the answer is that to an id that is nowhere; nothing is changed",
)
@pytest.mark.slow
@sweep("operation", [each for each in OPERATIONS if each.bound in (None, *NAMED)])
async def test_what_is_not_theirs_is_answered_as_what_is_not_there(parted: Parted, operation: Operation) -> None:
    nothing = {**dict.fromkeys(parted.ours, UNKNOWN), "seq": "999"}
    tag = (await parted.archive.ask("/lots")).headers["ETag"]
    for role in ("viewer", "operator"):
        answers = []
        for ids in (parted.theirs, nothing):
            given: dict[str, Any] = {"params": asked_of(operation, parted.ours)}
            given |= {} if operation.method == "GET" else {"json": {}}
            answers.append(await parted.ask(path_of(operation, ids), role, operation.method, **given))
        (status, data), unknown = answers
        assert status == (403 if operation.bound is None else 404), (status, data)
        assert (status, data) == unknown, "an id is not confirmed"
        assert (FOR_ALL_LOTS.encode() in data) == (operation.bound is None)
    if operation.method == "GET":
        assert (await parted.ask(path_of(operation, parted.theirs), method="HEAD"))[0] == status
    assert (await parted.archive.ask("/lots", If_None_Match=tag)).status == 304


@pytest.mark.nightly
@sweep("operation", [each for each in READ if ids_asked(each.query)])
async def test_an_id_in_a_parameter_is_not_confirmed_either(parted: Parted, operation: Operation) -> None:
    for name, kind in ids_asked(operation.query).items():
        given = asked_of(operation, parted.ours)
        path = path_of(operation, parted.ours)
        theirs = await parted.ask(path, params={**given, name: parted.theirs[kind]})
        assert theirs[0] == 404, (name, theirs)
        assert theirs == await parted.ask(path, params={**given, name: UNKNOWN})
        if name != "after" and operation.name != "lots_report_html":
            status, data = await parted.ask(path, params={**given, name: parted.ours[kind]})
            assert status in (200, 204), (name, data)


@pytest.mark.slow
@sweep("operation", READ)
async def test_an_answer_holds_nothing_of_another_lot(parted: Parted, operation: Operation) -> None:
    choices: list[dict[str, str]] = [{}]
    if "feed" in operation.fields:
        choices = [{"feed": name} for name in FEEDS]
    elif "collection" in operation.fields:
        names = {"lots": "lot", "stalls": "stall", "surveys": "survey", "sections": "lot"}
        choices = [{"collection": name, "id": parted.ours[of]} for name, of in names.items()]
    held = 0
    for chosen in choices:
        path = path_of(operation, parted.ours, **chosen)
        status, data = await parted.ask(path, params=asked_of(operation, parted.ours))
        assert status < 500, (path, data)
        held += status in (200, 204)
        for name, value in parted.theirs.items():
            assert name == "seq" or value.encode() not in data, (path, name)
        assert THEIRS.encode() not in data, path
        assert THEIRS.replace("'", "&#39;").encode() not in data, path
        if "collection" in operation.fields:
            other = path_of(operation, parted.ours, **{**chosen, "id": parted.theirs.get("lot", "")})
            assert "{id}" not in operation.path or (await parted.ask(other))[0] == 404
    assert held or operation.name in ("survey_places", "survey_tile"), "nothing was answered"
    if operation.bound is Bound.LISTED and operation.name not in ("collection", "collections"):
        whole = (await parted.archive.ask(path_of(operation, parted.ours))).status
        assert whole == 200


async def test_lists_have_our_lot_alone_and_a_place_in_a_list_confirms_nothing(parted: Parted) -> None:
    archive, ours = parted.archive, parted.ours
    found = {}
    stalls, extent = "/features/collections/stalls/items", "/features/collections/lots"
    for path in ("/lots", "/lots/places", "/surveys", "/changes", stalls, extent):
        async with parted.viewer.get(archive.address(path)) as response:
            found[path] = await response.json(content_type=None)
    assert [each["id"] for each in found["/lots"]["items"]] == found["/lots/places"]["ids"] == [ours["lot"]]
    assert {each["lot"] for each in found["/surveys"]["items"]} == {ours["lot"]}
    assert [each["lot"] for each in found["/changes"]["items"]] == [ours["lot"]]
    assert found[stalls]["numberMatched"] == 40
    end = found[extent]["extent"]["temporal"]["interval"][0][1]
    assert end == max(each["ended"] for each in found["/surveys"]["items"]), "the other lot was surveyed later"
    behind = await parted.ask(f"/lots?after={parted.theirs['lot']}")
    assert (behind[0], behind) == (422, await parted.ask(f"/lots?after={UNKNOWN}"))


@pytest.mark.fault(
    "an answer was kept for one who may read all lots, and a person with a role for some asks for the same",
    "it is made for that person; the tag of the other answer is not known",
)
async def test_an_answer_that_is_kept_for_one_is_never_given_to_another(parted: Parted, tmp_path: Path) -> None:
    archive = parted.archive
    token = rotate_person(tmp_path / TOKEN_FILE, "Ben", Role.VIEWER, [archive.far])
    await archive.stand.look()
    ben = await archive.stand.browser(headers={"Authorization": f"Bearer {token}"})
    clients = {"all": archive.viewer, "Ada": parted.viewer, "Ben": ben}
    seen: dict[str, set[str]] = {"all": {archive.lot, archive.far}, "Ada": {archive.lot}, "Ben": {archive.far}}
    tags: dict[str, str] = {}
    for path in ("/lots", f"/lots/{archive.lot}/proposals"):
        for _ in range(2):  # the second one is kept
            for name, session in clients.items():
                for known in (None, *(tag for other, tag in tags.items() if other != name)):
                    asked = {} if known is None else {"If-None-Match": known}
                    async with session.get(archive.address(path), headers=asked) as response:
                        text = await response.text()
                        if path == "/lots":
                            assert response.status == 200, (name, known)
                            assert {each for each in seen["all"] if each in text} == seen[name]
                        elif name == "Ada":
                            assert (response.status, archive.far in text) == (200, False)
                        elif name == "Ben":
                            assert (response.status, archive.lot in text) == (404, False)
                        tags[name] = response.headers.get("ETag", "none")
        tags.clear()


async def test_an_operator_of_a_lot_changes_it_under_their_own_name(parted: Parted) -> None:
    archive, lot = parted.archive, parted.ours["lot"]

    async def done(path: str, role: str = "operator", **body: object) -> Any:
        session = parted.operator if role == "operator" else parted.viewer
        async with session.post(archive.address(path), json=body) as response:
            return response.status, await response.json(content_type=None)

    assert (await done(f"/lots/{lot}/name", "viewer", name="Mine"))[0] == 403
    status, renamed = await done(f"/lots/{lot}/name", name="North")
    assert status == 200
    status, edit = await done(f"/lots/{lot}/edit", who="operator")
    assert (status, edit["who"]) == (200, "Ada operator"), "whose token it is"
    assert (await done(f"/lots/{lot}/edit/close", edit=edit["edit"]))[0] == 200
    assert next(each["who"] for each in await archive.items("/changes")) == "Ada operator"
    assert (await done(f"/changes/{renamed['seq']}/undo"))[0] == 200
    assert (await done(f"/shares/{parted.ours['share']}/take-back"))[0] == 200
    deleted = await done(f"/surveys/{parted.ours['survey']}/delete")
    assert (deleted[0], (await done(f"/changes/{deleted[1]['seq']}/undo"))[0]) == (200, 200)


async def test_a_change_of_two_lots_is_not_undone_by_an_operator_of_one(parted: Parted) -> None:
    moved = await parted.archive.done(f"/surveys/{parted.ours['survey']}/move", lot=None, name="Alone")
    back = await parted.archive.done(f"/surveys/{parted.ours['survey']}/move", lot=parted.ours["lot"])
    for seq in (moved["seq"], back["seq"]):
        assert (await parted.ask(f"/changes/{seq}/undo", "operator", "POST", json={}))[0] == 404
    async with parted.operator.get(parted.archive.address("/changes")) as response:
        kept = {each["seq"]: each["kept"] for each in (await response.json(content_type=None))["items"]}
    assert kept[back["seq"]] == f"change: {back['seq']} is about more than one lot", "the page offers no undo"
    assert kept[int(parted.ours["seq"])] is None


async def test_a_lot_that_was_merged_counts_as_the_one_that_it_is_part_of(parted: Parted, tmp_path: Path) -> None:
    archive, ours, theirs = parted.archive, parted.ours["lot"], parted.theirs["lot"]

    def merge(connection: Connection, lot: str, into: str | None) -> frozenset[str]:
        connection.execute(update(LOT).where(LOT.c.id == lot).values(merged_into=into))
        return reach.lots_within(connection, [theirs])

    assert await archive.store.read(lambda connection: reach.lots_within(connection, [theirs])) == {theirs}
    token = rotate_person(tmp_path / TOKEN_FILE, "Ben", Role.VIEWER, [theirs])
    await archive.stand.look()
    ben = await archive.stand.browser(headers={"Authorization": f"Bearer {token}"})
    for into, status in ((None, 404), (ours, 200), (None, 404)):
        within = await archive.store.write(partial(merge, lot=theirs, into=into))
        assert within == ({theirs} if into is None else {theirs, ours})
        async with ben.get(archive.address(f"/lots/{ours}")) as response:
            assert response.status == status
    await archive.store.write(lambda connection: merge(connection, ours, theirs))
    assert theirs in await archive.store.write(lambda connection: merge(connection, theirs, ours)), "a round ends"


@pytest.mark.fault(
    "a part of a lot becomes another lot, and one who may read the first alone asks for looks at stalls",
    "looks at stalls of the first lot, by the role and by a link; at all of them once both are one lot again",
)
async def test_looks_at_what_was_split_off_are_not_theirs_any_more(parted: Parted) -> None:
    archive, lot, survey = parted.archive, parted.ours["lot"], parted.ours["survey"]
    token = (await archive.done(f"/lots/{lot}/shares", days=1))["token"]
    paths = f"/surveys/{survey}/observations", f"/lots/{lot}/observations", f"/shared/{token}/observations"

    async def seen() -> list[set[str]]:
        found = [json.loads((await parted.ask(f"{path}?limit=500"))[1])["items"] for path in paths]
        return [{each["label"][0] for each in items} for items in found]

    assert await seen() == [{"A", "B"}] * 3
    part = [list(corner) for corner in box(-13, -5, 8.5, 60).polygons[0]]
    await archive.done(f"/lots/{lot}/split", outline=part, name="Part")
    assert await seen() == [{"A"}] * 3
    whole = await archive.items(f"/lots/{lot}/observations")
    assert {each["label"][0] for each in whole} == {"A", "B"}, "a role for all lots reads what was"
    is_part = LOT.c.name == "Part"
    await archive.store.write(lambda c: c.execute(update(LOT).where(is_part).values(merged_into=lot)))
    assert await seen() == [{"A", "B"}] * 3


@pytest.mark.fault(
    "a person makes a link to the lot that hers was merged into; the merge is undone, or her token is removed",
    "the link opens nothing from then on, and the list names her; that of a role for all lots opens",
)
async def test_a_link_ends_with_the_right_of_the_person_who_made_it(parted: Parted, tmp_path: Path) -> None:
    archive, far, near = parted.archive, parted.theirs["lot"], parted.ours["lot"]

    async def merge(into: str | None) -> None:
        merged = update(LOT).where(LOT.c.id == near).values(merged_into=into)
        await archive.store.write(lambda connection: connection.execute(merged))

    async def opened(token: str) -> list[int]:
        return [(await parted.ask(f"/shared/{each}/observations"))[0] for each in (token, whole)]

    async def made(lot: str) -> str:
        async with parted.operator.post(archive.address(f"/lots/{lot}/shares"), json={"days": 30}) as response:
            assert response.status == 200
            return str((await response.json())["token"])

    whole = (await archive.done(f"/lots/{far}/shares", days=1))["token"]
    await merge(far)
    hers = await made(far)
    assert await opened(hers) == [200, 200]
    await merge(None)
    assert await opened(hers) == [404, 200]
    listed = (await archive.get(f"/lots/{far}/shares"))["shares"]
    assert {(each["who"], each["open"]) for each in listed} == {("Ada operator", False), (None, True)}
    hers = await made(near)
    assert await opened(hers) == [200, 200]
    remove_person(tmp_path / TOKEN_FILE, "Ada operator")
    await archive.stand.look()
    assert await opened(hers) == [404, 200]
