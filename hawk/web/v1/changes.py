"""Handlers of changes: for operators, with a JSON object that a model checks first.

What the store refuses itself is a problem of the same form.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

from aiohttp import hdrs, web
from aiohttp.typedefs import Handler

from hawk.comm.protocol.authority import Role
from hawk.lots.plan.operations import NAMES
from hawk.lots.values import LotInputError, Register
from hawk.web.access.access import ACCESS, BOOK
from hawk.web.v1.answers import JSON, answered, in_time, now_of, opened, text_of
from hawk.web.v1.bodies import Given
from hawk.web.v1.parameters import Query, query_of, validated
from hawk.web.v1.refusals import check_operator

if TYPE_CHECKING:  # loaded on the store's thread
    from sqlalchemy import Connection

    from hawk.lots.shares import LotsOf

READ_S: Final = 20.0
"""Real seconds in which the whole request must be there."""
FOR_OPERATORS: Final = "Lots are changed by operators: log in as operator."
UNSURE: Final = "The store of lots is busy, and the change may have been made: look before it is sent again."
Body = Mapping[str, Any]
Work = Callable[[web.Request, Body], Awaitable[object]]
"""Does what a request asks for; it returns the content of an `Answer`."""


@dataclass(frozen=True, slots=True)
class Command:
    """A change without its connection: ``path`` holds the values of the address's fields, ``who`` is the ``person``
    whose token it is, else the role, ``now`` the time, UTC, Unix seconds; ``register`` finds a survey's stalls among
    those of a lot; ``lots_of`` says for which lots a person's role is.
    """

    path: Mapping[str, str]
    body: Body
    who: str
    now: float
    register: Register | None = field(repr=False)
    lots_of: LotsOf = field(repr=False)
    person: str = ""

    @property
    def id(self) -> str:
        """The id in the address."""
        return self.path["id"]


Change = Callable[["Connection", Command], object]
"""Makes a change on a thread of the store; it returns the content of an `Answer`."""


def changer(model: type[Given], change: Change) -> Handler:
    """Return the handler of a change of lots."""

    async def work(request: web.Request, body: Body) -> str:
        store = await opened(request)
        command = Command(
            dict(request.match_info), body, who_of(request), now_of(request), store.register, request.app[BOOK].lots_of,
            person_of(request),
        )  # fmt: skip
        return await store.write(lambda connection: text_of(change(connection, command)))

    return poster(model, work)


def poster(model: type[Given], work: Work, for_operators: str = FOR_OPERATORS, late: str = UNSURE) -> Handler:
    """Return the handler of work that operators ask for; ``for_operators``: the refusal of others, ``late``: that of
    work that takes too long.
    """

    async def handle(request: web.Request) -> web.StreamResponse:
        check_operator(request, for_operators)
        query_of(request, Query)
        body = await body_of(request, model)
        async with in_time(late):
            return changed(await work(request, body))

    return answered(handle)


def changed(found: object) -> web.Response:
    """Return the answer to a change."""
    return web.Response(text=text_of(found), content_type=JSON, headers={hdrs.CACHE_CONTROL: "no-store"})


def who_of(request: web.Request) -> str:
    """Return who asks, as the store keeps it: the person whose token it is, else the role."""
    access = request.get(ACCESS)
    return person_of(request) or (Role.OPERATOR.value if access is None else access.role.value)


def person_of(request: web.Request) -> str:
    """Return the name of the person whose token it is; empty for the token of a role."""
    access = request.get(ACCESS)
    return "" if access is None else access.person


async def body_of(request: web.Request, model: type[Given]) -> Body:
    """Return the JSON object that was sent, which the model takes; none is an empty one.

    Raises LotInputError, HTTPRequestTimeout, HTTPRequestEntityTooLarge.
    """
    try:
        async with asyncio.timeout(READ_S):
            data = await request.read()
    except TimeoutError:
        raise web.HTTPRequestTimeout(text="The request did not come.") from None
    try:
        body = json.loads(data or b"{}")
        json.dumps(body, ensure_ascii=False).encode()  # SQLite takes no half character
    except UnicodeEncodeError:
        raise LotInputError("body", "holds half a character: send text as UTF-8") from None
    except (ValueError, RecursionError) as error:
        raise LotInputError("body", f"is no JSON: {error}") from error
    if not isinstance(body, dict):
        raise LotInputError("body", "must be a JSON object")
    validated(model, body, NAMES)
    return body
