"""Things on the ground by id and by square of ground, what changed lately, and which of them a look shows again."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from hawk.algo.ground import Floats
from hawk.algo.mapper.delta import Recent
from hawk.algo.mapper.table import Square, square_of, squares_about
from hawk.algo.vision import quads

InPicture = Callable[[Floats], NDArray[np.bool_]]
"""Takes places (N, 2) of (north, east) and returns which the usable picture shows."""


class Thing(Protocol):
    """Something with an id at a place; ``born_m``: metres flown when it was first found; ``version`` of the map when it
    was last looked at.
    """

    @property
    def id(self) -> int: ...  # noqa: D102 - as above

    @property
    def north(self) -> float: ...  # noqa: D102

    @property
    def east(self) -> float: ...  # noqa: D102

    @property
    def born_m(self) -> float: ...  # noqa: D102

    @property
    def version(self) -> int: ...  # noqa: D102


T = TypeVar("T", bound=Thing)


class SpatialIndex(Generic[T]):
    """Things by id and by square of ground."""

    def __init__(self) -> None:
        self.known: dict[int, T] = {}
        self.recent: Recent[int] = Recent()
        """Those that were looked at or went, by map version."""
        self._squares: dict[Square, set[int]] = {}

    def about(self, north: float, east: float, reach: float) -> list[T]:
        """Return the things on the squares within reach (metres) of a place."""
        ids = [number for square in squares_about(north, east, reach) for number in self._squares.get(square, ())]
        return [self.known[number] for number in ids]

    def put(self, one: T) -> None:
        """Put a thing in, or at its new place."""
        before = self.known.get(one.id)
        if before is not None:
            self._squares[square_of(before.north, before.east)].discard(one.id)
        self.known[one.id] = one
        self._squares.setdefault(square_of(one.north, one.east), set()).add(one.id)
        self.recent.note(one.id, one.version)

    def remove(self, number: int, version: int) -> None:
        """Take a thing out."""
        one = self.known.pop(number)
        self._squares[square_of(one.north, one.east)].discard(number)
        self.recent.note(number, version)

    def changed_since(self, version: int) -> Iterator[tuple[int, T | None]]:
        """Yield those that were looked at after a version, None for those that went."""
        for number in self.recent.since(version):
            yield number, self.known.get(number)

    def forget_younger(self, born_m: float, version: int) -> None:
        """Forget what was found after this distance flown: its place on the map was not known."""
        for one in [one for one in self.known.values() if one.born_m > born_m]:
            self.remove(one.id, version)


def nearest_pairs(
    there: Floats, here: Floats, angles: tuple[Floats, Floats], reach: float, turn: float
) -> dict[int, int]:
    """Return which of the known places (N, 2) is which of those found (M, 2), by index, the nearest first.

    ``angles`` (N,), (M,): their undirected directions. None is farther than ``reach``, nor turned by ``turn`` or more.
    """
    i, j = quads.near_pairs(there, here, reach)
    apart = np.hypot(*(there[i] - here[j]).T)
    turns = quads.angle_between(angles[0][i], angles[1][j])
    found: dict[int, int] = {}
    given: set[int] = set()
    for k in np.argsort(apart, kind="stable").tolist():
        one, other = int(i[k]), int(j[k])
        if turns[k] < turn and one not in found and other not in given:
            found[one] = other
            given.add(other)
    return found


def whole_in(in_picture: InPicture, corners: Floats) -> NDArray[np.bool_]:
    """Return which quads (N, 4, 2) lie in the picture as a whole, (N,)."""
    return np.asarray(in_picture(corners.reshape(-1, 2)).reshape(-1, 4).all(1))
