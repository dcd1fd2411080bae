"""Observations of surveys in one piece each, so that statistics read a thousand surveys at once.

The table of observations is the truth; a piece that is not there is made from it.
"""

from __future__ import annotations

import json
import logging
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, cast

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Connection, delete, func, insert, select

from hawk.lots.storage.rows import is_among
from hawk.lots.storage.schema import LOOKS, OBSERVATION, STALL, SURVEY
from hawk.lots.values import LotStoreError
from hawk.model.lot_map import StallState

STATES: Final = (StallState.FREE, StallState.TAKEN, StallState.UNKNOWN)
"""States by their number in a piece."""
_LOOK: Final = np.dtype([("stall", "<u4"), ("taken_probability", "<u2"), ("state", "u1")])
_SCALE: Final = 10_000
_PIECES: Final = select(LOOKS.c.survey, LOOKS.c.at, LOOKS.c.stalls).where(is_among(LOOKS.c.survey))
_HIGHEST: Final = select(func.max(STALL.c.key))
_REMEDY: Final = "Restore a backup: hawk-drone restore FILE"
_LOG = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Looks:
    """Looks of S surveys at stalls, L in all, each survey's together.

    ``surveys``: their numbers; ``at`` (S,): mean moment of each one's looks, UTC, Unix seconds. Of each look (L,):
    ``line``, its survey's place in ``surveys``; ``stall``, the key; ``taken_probability``; ``state``, its number in
    `STATES`.
    """

    surveys: tuple[int, ...]
    at: NDArray[np.float64] = field(repr=False)
    line: NDArray[np.int64] = field(repr=False)
    stall: NDArray[np.int64] = field(repr=False)
    taken_probability: NDArray[np.float32] = field(repr=False)
    state: NDArray[np.int8] = field(repr=False)


def pack_looks(rows: Sequence[tuple[int, float, str]]) -> bytes:
    """Return looks (key of the stall, probability, state) as a table of 7 bytes a look."""
    numbers = {state.value: number for number, state in enumerate(STATES)}
    unknown = numbers[StallState.UNKNOWN.value]
    table = [
        (key, round(min(max(taken, 0.0), 1.0) * _SCALE), numbers.get(state, unknown)) for key, taken, state in rows
    ]
    return np.array(table, _LOOK).tobytes()


def unpack_looks(pieces: Sequence[tuple[int, float, bytes]]) -> Looks:
    """Return the looks of surveys by number, mean moment and `pack_looks`. Raises LotStoreError."""
    counts = [len(data) // _LOOK.itemsize for _, _, data in pieces]
    try:
        table = np.frombuffer(b"".join(data for _, _, data in pieces), _LOOK)
    except ValueError as error:
        raise LotStoreError(f"the looks of surveys cannot be read: {error}. {_REMEDY}") from error
    if len(table) != sum(counts) or (table["state"] >= len(STATES)).any():
        raise LotStoreError(f"the looks of surveys cannot be read: their table is damaged. {_REMEDY}")
    return Looks(
        tuple(number for number, _, _ in pieces),
        np.array([at for _, at, _ in pieces], np.float64),
        np.repeat(np.arange(len(pieces)), counts),
        table["stall"].astype(np.int64),
        (table["taken_probability"] / _SCALE).astype(np.float32),
        table["state"].astype(np.int8),
    )


def keep_looks(connection: Connection, surveys: Iterable[int]) -> None:
    """Store the looks of surveys in one piece each; a survey without looks has none."""
    for survey in surveys:
        connection.execute(delete(LOOKS).where(LOOKS.c.survey == survey))
        found = _read(connection, survey)
        if found is not None:
            at, data = found
            connection.execute(insert(LOOKS).values(survey=survey, at=at, stalls=data))


def looks_of(connection: Connection, surveys: Sequence[int]) -> Looks:
    """Return the looks of surveys, in their order, without those that have none.

    A piece that is missing or damaged is made from the observations, and not kept.
    """
    found: dict[int, tuple[object, object]] = {}
    if surveys:
        among = {"among": json.dumps([*surveys])}
        found = {survey: (at, stalls) for survey, at, stalls in connection.execute(_PIECES, among).all()}
    highest = connection.execute(_HIGHEST).scalar() or 0
    whole = {survey: cast("tuple[float, bytes]", piece) for survey, piece in found.items() if _is_whole(*piece)}
    damaged = found.keys() - whole.keys() | _with_wrong_values(whole, highest)
    if damaged:
        _LOG.warning("the looks of surveys %s are damaged: their observations are read", sorted(damaged))
    pieces = []
    for survey in surveys:
        piece = _read(connection, survey) if survey in damaged or survey not in whole else whole[survey]
        if piece is not None:
            pieces.append((survey, *piece))
    return unpack_looks(pieces)


def _is_whole(at: object, data: object) -> bool:
    """Return True for a moment and a table that can be read; SQLite keeps a value of any type in a column."""
    if not isinstance(at, float | int) or not isinstance(data, bytes):
        return False
    return math.isfinite(at) and len(data) % _LOOK.itemsize == 0


def _with_wrong_values(pieces: Mapping[int, tuple[float, bytes]], highest: int) -> set[int]:
    """Return the surveys whose table has a value that is none. ``highest``: key of the last stall."""
    table = np.frombuffer(b"".join(data for _, data in pieces.values()), _LOOK)
    is_wrong = (table["state"] >= len(STATES)) | (table["taken_probability"] > _SCALE) | (table["stall"] > highest)
    if not is_wrong.any():
        return set()
    line = np.repeat(np.arange(len(pieces)), [len(data) // _LOOK.itemsize for _, data in pieces.values()])
    surveys = list(pieces)
    return {surveys[number] for number in np.unique(line[is_wrong]).tolist()}


def missing_looks(connection: Connection, lot: str) -> list[int]:
    """Return the surveys of a lot with looks that are not in one piece."""
    has = select(OBSERVATION.c.survey).where(OBSERVATION.c.survey == SURVEY.c.seq).exists()
    is_kept = select(LOOKS.c.survey).where(LOOKS.c.survey == SURVEY.c.seq).exists()
    asked = select(SURVEY.c.seq).where(SURVEY.c.lot == lot, ~is_kept, has)
    return [int(seq) for seq in connection.execute(asked).scalars()]


def _read(connection: Connection, survey: int) -> tuple[float, bytes] | None:
    asked = select(OBSERVATION.c.stall, OBSERVATION.c.taken_probability, OBSERVATION.c.state, OBSERVATION.c.looked_at)
    rows = connection.execute(asked.where(OBSERVATION.c.survey == survey).order_by(OBSERVATION.c.stall)).all()
    if not rows:
        return None
    at = sum(row.looked_at for row in rows) / len(rows)
    return at, pack_looks([(row.stall, row.taken_probability, row.state) for row in rows])
