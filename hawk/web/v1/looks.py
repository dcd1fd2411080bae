"""Looks of surveys that an earlier version stored, put in one piece a survey before statistics read them."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING, Any, Final

from hawk.lots.store import LotStore
from hawk.lots.values import LotStoreError
from hawk.runtime.late import late_functions
from hawk.web.v1.parameters import Request

if TYPE_CHECKING:
    from hawk.lots.survey import observations
else:
    observations = late_functions("hawk.lots.survey.observations")

_AT_ONCE: Final = 20
"""Surveys whose looks are put in one piece in one transaction: 0.1 s, after which a flight's survey may be stored."""


async def keep_missing_looks(store: LotStore, asked: Request[Any]) -> None:
    """Put the looks of a lot's archive in one piece a survey, once.

    A store of a newer version is only read: each question then takes longer.
    """
    found = await store.read(lambda connection: observations.missing_looks(connection, asked.id))
    with contextlib.suppress(LotStoreError):
        for first in range(0, len(found), _AT_ONCE):
            some = found[first : first + _AT_ONCE]
            await store.write(lambda connection, some=some: observations.keep_looks(connection, some))  # type: ignore[misc]
