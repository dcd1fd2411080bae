"""Latest-value topics inside one process, in place of the specification's ROS topics."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

T = TypeVar("T")
T_co = TypeVar("T_co", covariant=True)


@dataclass(frozen=True, slots=True)
class Stamped(Generic[T_co]):
    """A value and the moment it was published, seconds of the daemon's clock."""

    value: T_co
    time: float


class Topic(Generic[T]):
    """One value, published on the loop and read by anyone; a reader sees the newest only.

    Listeners are called in the order of registration, on the loop, at every publication: they must be quick.
    """

    def __init__(self, name: str, clock: Callable[[], float]) -> None:
        self.name = name
        self._clock = clock
        self.latest: Stamped[T] | None = None
        """The last value with its time, None when nothing was published yet."""
        self._listeners: list[Callable[[T], None]] = []
        self._waiters: set[asyncio.Future[T]] = set()

    def publish(self, value: T) -> None:
        """Replace the value; call every listener and wake every waiter."""
        self.latest = Stamped(value, self._clock())
        for listener in tuple(self._listeners):
            listener(value)
        for waiter in tuple(self._waiters):
            if not waiter.done():
                waiter.set_result(value)

    @property
    def value(self) -> T | None:
        """The last value, None when nothing was published yet."""
        return None if self.latest is None else self.latest.value

    @property
    def age(self) -> float:
        """Seconds since the last publication, infinite when there was none."""
        return float("inf") if self.latest is None else self._clock() - self.latest.time

    def fresh(self, within: float) -> T | None:
        """Return the value if it is no older than ``within`` seconds, else None."""
        return self.value if self.age <= within else None

    def listen(self, listener: Callable[[T], None]) -> Callable[[], None]:
        """Call ``listener`` at every publication; the returned function ends it."""
        self._listeners.append(listener)
        return lambda: self._listeners.remove(listener) if listener in self._listeners else None

    async def next(self) -> T:
        """Wait for the next publication and return its value."""
        waiter: asyncio.Future[T] = asyncio.get_running_loop().create_future()
        self._waiters.add(waiter)
        try:
            return await waiter
        finally:
            self._waiters.discard(waiter)
