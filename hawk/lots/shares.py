"""Links by which others read one lot: each ends at a time, and can be taken back before.

That of a person with a role for some lots opens as long as the role is for its lot.
A link holds a random token of 128 bits; the store keeps its SHA-256 alone, so that a copy of the store opens nothing.
"""

from __future__ import annotations

import hashlib
import math
import secrets
from collections.abc import Callable, Collection, Mapping
from functools import cache
from typing import Any, Final

from sqlalchemy import Connection, RowMapping, insert, select, update

from hawk.lots import reach
from hawk.lots.answers import ListedLink, SharedLink, SharedLinks, TakenBack
from hawk.lots.queries import lot_row
from hawk.lots.storage.schema import LOT, SHARE
from hawk.lots.values import LotInputError, LotStoreError, NotFoundError, moment, new_id

TOKEN_BYTES: Final = 16
DAY_S: Final = 86_400.0
LONGEST_DAYS: Final = 366
"""Days that a link opens at most."""
LARGEST: Final = 50
"""Open links of a lot at most."""
LotsOf = Callable[[str], Collection[str]]
"""Says for which lots the role of a person is, by their ids: for none once the person has no token."""


def of_nobody(_: str) -> Collection[str]:
    """Return no lot: nobody has a role for some lots."""
    return ()


def share(
    connection: Connection, lot: str, asked: Mapping[str, Any], now: float, who: str = "", lots_of: LotsOf = of_nobody
) -> SharedLink:
    """Make a link to a lot for ``days``; return it with its ``token``, which is not kept.

    ``who``: the person with a role for some lots who makes it; "": a role for all lots does.

    Raises LotInputError, NotFoundError, and LotStoreError with too many open links.
    """
    days = _days(asked.get("days"))
    lot_row(connection, lot)
    if sum(link.open for link in shares(connection, lot, now, lots_of).shares) >= LARGEST:
        raise LotStoreError(f"shares: this lot has {LARGEST} open links; take one back first")
    token = secrets.token_urlsafe(TOKEN_BYTES)
    row = {"id": new_id(), "lot": lot, "digest": _digest(token), "made": now, "ends": now + days * DAY_S}
    row["who"] = who or None
    connection.execute(insert(SHARE).values(row))
    return SharedLink(id=row["id"], token=token, ends=moment(now + days * DAY_S))


def shares(connection: Connection, lot: str, now: float, lots_of: LotsOf = of_nobody) -> SharedLinks:
    """Return the links of a lot, the newest first. Raises NotFoundError."""
    lot_row(connection, lot)
    rows = connection.execute(select(SHARE).where(SHARE.c.lot == lot).order_by(SHARE.c.made.desc())).mappings()
    reaches = cache(lambda who: _reaches(connection, who, lot, lots_of))
    return SharedLinks(shares=[_shown(row, now, reaches(row["who"])) for row in rows])


def _reaches(connection: Connection, who: str | None, lot: str, lots_of: LotsOf) -> bool:
    """Return True while the maker of a link may read its lot."""
    return who is None or lot in reach.lots_within(connection, lots_of(who))


def take_back(connection: Connection, share_id: str, now: float) -> TakenBack:
    """Let a link open nothing from now on; one that was taken back stays so. Raises NotFoundError."""
    found = connection.execute(select(SHARE).where(SHARE.c.id == share_id)).mappings().one_or_none()
    if found is None:
        raise NotFoundError("share: there is no link with this id; reload the list")
    if found["taken_back"] is None:
        connection.execute(update(SHARE).where(SHARE.c.id == share_id).values(taken_back=now))
    return TakenBack(id=share_id, taken_back=True)


def lot_of(connection: Connection, token: str, now: float, lots_of: LotsOf = of_nobody) -> str | None:
    """Return the lot that a link's token opens now.

    None for one that is unknown, has ended, was taken back, or whose maker may not read the lot any more.
    """
    found = connection.execute(
        select(SHARE.c.lot, SHARE.c.who)
        .join(LOT, LOT.c.id == SHARE.c.lot)
        .where(SHARE.c.digest == _digest(token), SHARE.c.ends > now, SHARE.c.taken_back.is_(None))
        .where(LOT.c.merged_into.is_(None))
    ).one_or_none()
    return None if found is None or not _reaches(connection, found.who, found.lot, lots_of) else str(found.lot)


def was_link(connection: Connection, token: str) -> bool:
    """Return True for a token that opens a lot or has opened one: it was made here, and is no guess."""
    return connection.execute(select(SHARE.c.id).where(SHARE.c.digest == _digest(token))).first() is not None


def _days(given: object) -> float:
    is_number = isinstance(given, int | float) and not isinstance(given, bool)
    days = float(given) if is_number else math.nan  # type: ignore[arg-type]
    if not 0 < days <= LONGEST_DAYS:
        raise LotInputError("days", f"must be a number of days above 0 and at most {LONGEST_DAYS}, not {given!r:.40}")
    return days


def _shown(row: RowMapping, now: float, reaches: bool) -> ListedLink:
    is_open = reaches and row["taken_back"] is None and row["ends"] > now
    back = None if row["taken_back"] is None else moment(row["taken_back"])
    made, ends = moment(row["made"]), moment(row["ends"])
    return ListedLink(id=row["id"], who=row["who"], made=made, ends=ends, open=is_open, taken_back=back)


def _digest(token: str) -> str:
    return hashlib.sha256(token.encode("utf-8", "replace")).hexdigest()
