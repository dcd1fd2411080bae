"""The published index of the map: what changed in the stalls since the last frame, and everything by key."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hawk.algo.mapper.table import STATES, Rows, angle_of, probability, to_stall
from hawk.model import Counts, Stall, StallState
from hawk.sharded import Sharded

_MOVED_M = 0.05
_TURNED = 0.02
_PROBABILITY = 0.05
_AGED_S = 2.0
_SHARD = 128  # ids


class StallIndex:
    """Stalls that count, as they were last shown. A stall is shown anew only when it visibly changed."""

    def __init__(self) -> None:
        self.stalls: Sharded[int, Stall] = Sharded(lambda stall_id: stall_id // _SHARD)
        self.unclear: dict[int, Stall] = {}
        """Those whose state is not known."""
        self._counts = dict.fromkeys(StallState, 0)

    def update(self, rows: Rows, index: NDArray[np.intp], gone: list[int], version: int) -> NDArray[np.float64]:
        """Bring rows ``index`` up to date and take out those that are gone; their versions are set in ``rows``.

        Returns the corners (N, 4, 2) of everything whose picture on the map changed, before and after.
        """
        lost = {i: self.stalls[i] for i in gone if i in self.stalls}
        news: dict[int, Stall] = {}
        redrawn = list(lost.values())
        index = index[rows["confirmed"][index]]
        table = rows[index]
        for position, stall_id, values in zip(index, table["id"].tolist(), _shown(table), strict=True):
            known = None if stall_id in lost else self.stalls.get(stall_id)
            if known is not None and not _differs(known, values):
                continue
            rows["version"][position] = version
            news[stall_id] = fresh = to_stall(rows[position])
            if known is None or _is_drawn_anew(known, values):
                redrawn += [fresh] if known is None else [fresh, known]
        self._count(lost, news)
        self.stalls = self.stalls.changed(news, lost)
        return np.array([stall.corners() for stall in redrawn]).reshape(-1, 4, 2)

    def counts(self) -> Counts:
        """Return how many there are of each state."""
        return Counts(*(self._counts[s] for s in (StallState.FREE, StallState.TAKEN, StallState.UNKNOWN)))

    def _count(self, lost: dict[int, Stall], news: dict[int, Stall]) -> None:
        for stall_id in lost.keys() | news.keys():
            known = self.stalls.get(stall_id)
            if known is not None:
                self._counts[known.state] -= 1
                self.unclear.pop(stall_id, None)
        for stall_id, stall in news.items():
            self._counts[stall.state] += 1
            if stall.state is StallState.UNKNOWN:
                self.unclear[stall_id] = stall


def _shown(rows: Rows) -> list[tuple[float, ...]]:
    columns = (
        rows["north"],
        rows["east"],
        angle_of(rows),
        rows["width"],
        rows["length"],
        probability(rows["taken"]),
        rows["state"],
        rows["last_seen"],
    )
    return list(zip(*(column.tolist() for column in columns), strict=True))


def _differs(known: Stall, values: tuple[float, ...]) -> bool:
    taken, last_seen = values[5], values[7]
    return (
        _is_drawn_anew(known, values)
        or abs(taken - known.taken) > _PROBABILITY
        or last_seen - known.last_seen > _AGED_S
    )


def _is_drawn_anew(known: Stall, values: tuple[float, ...]) -> bool:
    """Whether the stall's picture on the map is another one."""
    north, east, angle, width, length, _, state, _ = values
    turned = abs((angle - known.angle + math.pi / 2) % math.pi - math.pi / 2)
    return (
        known.state is not STATES[int(state)]
        or max(abs(north - known.north), abs(east - known.east)) > _MOVED_M
        or max(abs(width - known.width), abs(length - known.length)) > _MOVED_M
        or turned > _TURNED
    )
