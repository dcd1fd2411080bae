"""The published index of the map: what changed in the stalls since the last frame, and everything by key."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hawk.algo.mapper.table import STATES, Rows, angle_of, probability, to_stall
from hawk.model import Counts, Stall, StallState

_MOVED_M = 0.05
_TURNED = 0.02
_PROBABILITY = 0.05
_AGED_S = 2.0


class StallIndex:
    """Stalls that count, as they were last shown. A stall is shown anew only when it visibly changed."""

    def __init__(self) -> None:
        self.stalls: dict[int, Stall] = {}

    def update(self, rows: Rows, index: NDArray[np.intp], gone: list[int], version: int) -> NDArray[np.float64]:
        """Bring rows ``index`` up to date and take out those that are gone; their versions are set in ``rows``.

        Returns the corners (N, 4, 2) of everything whose picture on the map changed, before and after.
        """
        corners = [self.stalls.pop(i).corners() for i in gone if i in self.stalls]
        index = index[rows["confirmed"][index]]
        table = rows[index]
        for position, row, values in zip(index, table, _shown(table), strict=True):
            known = self.stalls.get(int(row["id"]))
            if known is not None and not _differs(known, values):
                continue
            rows["version"][position] = version
            self.stalls[int(row["id"])] = fresh = to_stall(rows[position])
            corners.append(fresh.corners())
            if known is not None:
                corners.append(known.corners())
        return np.array(corners).reshape(-1, 4, 2)

    def counts(self) -> Counts:
        """Return how many there are of each state."""
        states = [stall.state for stall in self.stalls.values()]
        return Counts(*(states.count(s) for s in (StallState.FREE, StallState.TAKEN, StallState.UNKNOWN)))


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
    north, east, angle, width, length, taken, state, last_seen = values
    turned = abs((angle - known.angle + np.pi / 2) % np.pi - np.pi / 2)
    return (
        known.state is not STATES[int(state)]
        or max(abs(north - known.north), abs(east - known.east)) > _MOVED_M
        or max(abs(width - known.width), abs(length - known.length)) > _MOVED_M
        or turned > _TURNED
        or abs(taken - known.taken) > _PROBABILITY
        or last_seen - known.last_seen > _AGED_S
    )
