"""Things on the ground by id and by square of ground, with what changed lately."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Generic, Protocol, TypeVar

from hawk.algo.mapper.delta import Recent
from hawk.algo.mapper.table import Square, square_of, squares_about


class Thing(Protocol):
    """Something with an id at a place; ``version`` of the map when it was last looked at."""

    @property
    def id(self) -> int: ...  # noqa: D102 - as above

    @property
    def north(self) -> float: ...  # noqa: D102

    @property
    def east(self) -> float: ...  # noqa: D102

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
