"""An immutable mapping that is cheap to change and to compare at any size.

It consists of shards: a changed copy shares every unchanged shard, and a comparison of two copies reads only shards
that are not the same object.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping
from typing import Generic, TypeVar

K = TypeVar("K", bound=Hashable)
V = TypeVar("V")


class Sharded(Mapping[K, V], Generic[K, V]):
    """A mapping; ``shard_of`` says to which shard a key belongs."""

    __slots__ = ("_shard_of", "_shards", "_size")

    def __init__(
        self,
        shard_of: Callable[[K], Hashable],
        shards: Mapping[Hashable, Mapping[K, V]] | None = None,
        size: int = 0,
    ) -> None:
        self._shard_of = shard_of
        self._shards = {} if shards is None else shards
        self._size = size

    def __getitem__(self, key: K) -> V:
        return self._shards[self._shard_of(key)][key]

    def __iter__(self) -> Iterator[K]:
        for shard in self._shards.values():
            yield from shard

    def __len__(self) -> int:
        return self._size

    def __repr__(self) -> str:
        return f"{type(self).__name__}({dict(self)!r})"

    def changed(self, news: Mapping[K, V], gone: Iterable[K] = ()) -> Sharded[K, V]:
        """Return a copy with new values and without the keys in ``gone`` (unknown ones are ignored).

        The cost grows with the size of the changed shards and the number of shards.
        """
        fresh: dict[Hashable, dict[K, V]] = {}

        def shard(key: K) -> dict[K, V]:
            name = self._shard_of(key)
            if name not in fresh:
                fresh[name] = dict(self._shards.get(name, {}))
            return fresh[name]

        for key in gone:
            shard(key).pop(key, None)
        for key, value in news.items():
            shard(key)[key] = value
        if not fresh:
            return self
        size = self._size + sum(len(new) - len(self._shards.get(name, ())) for name, new in fresh.items())
        kept = {**self._shards, **fresh}
        return Sharded(self._shard_of, {name: one for name, one in kept.items() if one or name not in fresh}, size)

    def changed_shards(self, before: Sharded[K, V]) -> Iterator[tuple[Mapping[K, V], Mapping[K, V]]]:
        """Yield every shard that is another object than in ``before``, and that one."""
        for name in self._shards.keys() | before._shards.keys():
            mine, theirs = self._shards.get(name, {}), before._shards.get(name, {})
            if mine is not theirs:
                yield mine, theirs


def differing(now: Mapping[K, V], before: Mapping[K, V]) -> Iterator[K]:
    """Yield every key whose value is another object, or that is in one of the two only: fast for two `Sharded`."""
    if isinstance(now, Sharded) and isinstance(before, Sharded):
        for mine, theirs in now.changed_shards(before):
            yield from differing(mine, theirs)
        return
    for key, value in now.items():
        if before.get(key) is not value:
            yield key
    for key in before:
        if key not in now:
            yield key
