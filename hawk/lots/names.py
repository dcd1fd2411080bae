"""Lots by their name or id, and surveys by their id or its beginning, as a person writes them in a command."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from typing import Final

from sqlalchemy import ColumnElement, Connection, func, select

from hawk.lots.storage.rows import is_among
from hawk.lots.storage.schema import LOT
from hawk.lots.values import NotFoundError, utc

SHOWN: Final = 10
"""Surveys that an error lists, the newest ones; lots, by name."""
_LIKE: Final = 0.5
"""Likeness of two names, `difflib.SequenceMatcher.ratio`."""
_BEGINNING: Final = 8
"""Characters of an id that an error shows: enough to choose one by."""


def lot_named(connection: Connection, given: str) -> str:
    """Return the id of the lot with this id, or this name where no other lot has it; an id goes before a name.

    Raises NotFoundError.
    """
    rows = connection.execute(select(LOT.c.id, LOT.c.name).where(LOT.c.merged_into.is_(None))).all()
    found = [row.id for row in rows if row.id == given] or [row.id for row in rows if row.name == given]
    if len(found) == 1:
        return str(found[0])
    if found:
        raise NotFoundError(f"LOT: {len(found)} lots are called {given!r}; give the id of one: {', '.join(found)}")
    raise NotFoundError(f"LOT: no lot is called {given!r}; there are {_names([row.name for row in rows], given)}")


def _names(names: Sequence[str], given: str) -> str:
    """Return lots' names by their letters; of many those that are most like the one that was given."""
    if len(names) <= SHOWN:
        return ", ".join(map(repr, sorted(names))) or "none"
    near = get_close_matches(given, names, SHOWN, _LIKE)
    return f"{len(names)}, most like it {', '.join(map(repr, near))}" if near else f"{len(names)}, none like it"


def names_of(connection: Connection, lots: Sequence[str]) -> dict[str, str]:
    """Return the names of lots by their ids; one that is not there is left out."""
    among = {"among": json.dumps(list(lots))}
    rows = connection.execute(select(LOT.c.id, LOT.c.name).where(is_among(LOT.c.id)), among)
    return {str(row.id): str(row.name) for row in rows}


def schedule_names(connection: Connection, names: Iterable[object]) -> dict[object, str]:
    """Return by which name a schedule means the lot of each name: "" where several lots have it, another lot has it as
    its id, or it is damaged.
    """
    given = list(names)
    found = [name for name in given if isinstance(name, str)]
    asked = select(LOT.c.name).where(LOT.c.merged_into.is_(None), is_among(LOT.c.name, found))
    shared = asked.group_by(LOT.c.name).having(func.count() > 1)
    of_several = {*connection.execute(shared).scalars()}
    of_several |= {*connection.execute(select(LOT.c.id).where(is_among(LOT.c.id, found))).scalars()}
    return {name: name if isinstance(name, str) and name not in of_several else "" for name in given}


def lots_by_name(connection: Connection, *of: ColumnElement[bool]) -> list[str]:
    """Return the ids of the lots that were not merged into another one, by their names; ``of``: conditions."""
    rows = connection.execute(select(LOT.c.id).where(LOT.c.merged_into.is_(None), *of).order_by(LOT.c.name, LOT.c.id))
    return [str(each) for each in rows.scalars()]


def chosen_survey(surveys: Sequence[tuple[str, float]], given: str, of: str = "") -> str:
    """Return the id of the only survey whose id begins with a text. Raises NotFoundError, which lists surveys.

    Args:
        surveys: Id and end (UTC, Unix seconds) of each, the oldest first.
        given: The id, or its beginning.
        of: Words for what has the surveys, as "of this lot".
    """
    found = [each for each in surveys if each[0].startswith(given)]
    if len(found) == 1:
        return found[0][0]
    of = f" {of}" if of else ""
    if found:
        words = f"{len(found)} surveys{of} begin with {given!r}: write more of the id; they are"
        raise NotFoundError(f"--survey: {words} {_listed(found, len(given) + _BEGINNING)}")
    raise NotFoundError(f"--survey: there is no survey {given!r}{of}; {_words(len(surveys))} {_listed(surveys)}")


def _words(number: int) -> str:
    return "there are" if number <= SHOWN else f"the last {SHOWN} of {number} are"


def _listed(surveys: Sequence[tuple[str, float]], length: int = _BEGINNING) -> str:
    return ", ".join(f"{survey[:length]} of {utc(ended)}" for survey, ended in surveys[: -SHOWN - 1 : -1]) or "none"


def unclear_lots(connection: Connection, given: Sequence[str]) -> tuple[dict[str, list[str]], list[str]]:
    """Return those of some names and ids that are not one lot's, and the names that there are, in their order: of lots
    that share one their ids.

    Each has the ids of the lots that share the name, none where no lot has it; 10 of ids and of names at most.
    """
    is_there = LOT.c.merged_into.is_(None)
    rows = connection.execute(select(LOT.c.id, LOT.c.name).where(is_there).order_by(LOT.c.name, LOT.c.id)).all()
    lots: dict[str, list[str]] = {}
    for row in rows:
        for value in {row.id, row.name}:
            lots.setdefault(value, []).append(row.id)
    unclear = {each: lots.get(each, [])[:SHOWN] for each in given if len(lots.get(each, ())) != 1}
    return unclear, [str(row.name if len(lots[row.name]) == 1 else row.id) for row in rows[:SHOWN]]
