"""Lots and surveys that last, for page and tools: list, name, merge, split, move, undo.

Names are text: nothing of them is read as HTML, here or on the page. Everybody may read; operators may change. A value
that cannot be used is answered with 422, its field and the remedy (`hawk.web.refusals`).
"""

from __future__ import annotations

from dataclasses import asdict

from aiohttp import web

from hawk.lots.store import LotStore
from hawk.lots.values import LotInputError
from hawk.web.lot_answers import ID, answer, answered, now_of
from hawk.web.refusals import Body, role_of


def add_routes(app: web.Application) -> None:
    """Add every route of this module."""
    app.router.add_get("/api/lots.json", all_lots)
    app.router.add_get(f"/api/lots/{ID}.json", one_lot)
    app.router.add_post(f"/api/lots/{ID}/name", answered(rename))
    app.router.add_post(f"/api/lots/{ID}/merge", answered(merge))
    app.router.add_post(f"/api/lots/{ID}/split", answered(split))
    app.router.add_get(f"/api/lots/{ID}/changes.json", proposed)
    app.router.add_post(f"/api/lots/{ID}/take-over", answered(take_over))
    app.router.add_post(f"/api/lots/{ID}/drop", answered(drop))
    app.router.add_post(f"/api/lots/{ID}/pin", answered(pin))
    app.router.add_post(f"/api/surveys/{ID}/move", answered(move))
    app.router.add_post(f"/api/surveys/{ID}/delete", answered(delete))
    app.router.add_get(f"/api/surveys/{ID}/places.json", places)
    app.router.add_post(f"/api/surveys/{ID}/place", answered(choose))
    app.router.add_post(r"/api/lot-changes/{seq:\d{1,9}}/undo", answered(undo))


async def all_lots(request: web.Request) -> web.StreamResponse:
    """Every lot with its newest survey, the surveys that wait for "which lot is it?", and the last changes."""

    async def work(store: LotStore) -> object:
        from hawk.lots import queries

        return await store.read(queries.lots)

    return await answer(request, work)


async def one_lot(request: web.Request) -> web.StreamResponse:
    """A lot with outline, surveys and stalls."""

    async def work(store: LotStore) -> object:
        from hawk.lots import queries
        from hawk.lots.text import json_text

        return await store.read(lambda connection: json_text(queries.lot(connection, request.match_info["id"])))

    return await answer(request, work)


async def proposed(request: web.Request) -> web.StreamResponse:
    """Stalls that begin and end by what the newest surveys of a lot show, and the surveys that wait for a place."""

    async def work(store: LotStore) -> object:
        from hawk.lots import queries
        from hawk.lots.text import json_text

        return await store.read(lambda connection: json_text(queries.proposed(connection, request.match_info["id"])))

    return await answer(request, work)


async def places(request: web.Request) -> web.StreamResponse:
    """The places where a survey may lie, with its stalls there and those of its lot."""

    async def work(store: LotStore) -> object:
        from hawk.lots import queries
        from hawk.lots.text import json_text

        return await store.read(lambda connection: json_text(queries.places(connection, request.match_info["id"])))

    return await answer(request, work)


async def take_over(store: LotStore, request: web.Request, body: Body) -> object:
    """Take proposals of ``survey`` over: ``begin`` and ``end`` are ids or "all"; ``why`` says the reason."""
    from hawk.lots import commands

    lot, who, now = request.match_info["id"], role_of(request), now_of(request)
    return asdict(await store.write(lambda c: commands.take_over(c, lot, body, who, now)))


async def drop(store: LotStore, request: web.Request, body: Body) -> object:
    """Drop proposals of ``survey``, named as to `take_over`: the same evidence does not propose them again."""
    from hawk.lots import commands

    lot, who, now = request.match_info["id"], role_of(request), now_of(request)
    return asdict(await store.write(lambda c: commands.drop(c, lot, body, who, now)))


async def pin(store: LotStore, request: web.Request, body: Body) -> object:
    """Pin a lot to its place on Earth by one or two ``points``, each ``from`` a place ``to`` another one; [] unpins."""
    from hawk.lots import commands

    lot, who, now = request.match_info["id"], role_of(request), now_of(request)
    return await store.write(lambda c: commands.pin(c, lot, body, who, now))


async def rename(store: LotStore, request: web.Request, body: Body) -> object:
    """Name a lot: ``name``."""
    from hawk.lots import commands

    lot, who, now = request.match_info["id"], role_of(request), now_of(request)
    return asdict(await store.write(lambda c: commands.rename(c, lot, body.get("name"), who, now)))


async def merge(store: LotStore, request: web.Request, body: Body) -> object:
    """Merge the lot ``with`` into this one."""
    from hawk.lots import commands

    lot, who, now = request.match_info["id"], role_of(request), now_of(request)
    return asdict(await store.write(lambda c: commands.merge(c, lot, body.get("with"), who, now)))


async def split(store: LotStore, request: web.Request, body: Body) -> object:
    """Split the stalls within ``outline``, corners [latitude, longitude], off as a lot called ``name``."""
    from hawk.lots import commands

    lot, who, now = request.match_info["id"], role_of(request), now_of(request)
    return asdict(await store.write(lambda c: commands.split(c, lot, body, who, now)))


async def move(store: LotStore, request: web.Request, body: Body) -> object:
    """Move a survey to the lot ``lot``; null: to a new one, called ``name`` where that is given."""
    from hawk.lots import commands

    if "lot" not in body:
        raise LotInputError("lot", "is missing: name a lot, or write null for a new one")
    survey, who, now = request.match_info["id"], role_of(request), now_of(request)
    return asdict(await store.write(lambda c: commands.move(c, survey, body, who, now, store.register)))


async def delete(store: LotStore, request: web.Request, _: Body) -> object:
    """Delete a survey of a lot; undoing brings it back."""
    from hawk.lots import commands

    survey, who, now = request.match_info["id"], role_of(request), now_of(request)
    return asdict(await store.write(lambda c: commands.delete(c, survey, who, now)))


async def choose(store: LotStore, request: web.Request, body: Body) -> object:
    """Register a survey whose place was not certain: ``place``, the number of one of its places, from 0."""
    from hawk.lots import commands

    survey, who, now = request.match_info["id"], role_of(request), now_of(request)
    return asdict(await store.write(lambda c: commands.choose(c, survey, body, who, now)))


async def undo(store: LotStore, request: web.Request, _: Body) -> object:
    """Undo a change, once."""
    from hawk.lots import commands

    seq, now = int(request.match_info["seq"]), now_of(request)
    return {"seq": seq, "kind": await store.write(lambda c: commands.undo(c, seq, now))}
