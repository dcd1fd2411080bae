"""Keys in the order of their last change: what changed since a version is found without looking at the rest."""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from typing import Generic, TypeVar

K = TypeVar("K", bound=Hashable)


class Recent(Generic[K]):
    """Keys with the version of their last change; versions never fall."""

    def __init__(self) -> None:
        self._versions: dict[K, int] = {}

    def __contains__(self, key: K) -> bool:
        return key in self._versions

    def __len__(self) -> int:
        return len(self._versions)

    def note(self, key: K, version: int) -> None:
        """The key changed with this version."""
        self._versions.pop(key, None)
        self._versions[key] = version

    def forget(self, key: K) -> None:
        """The key is not known any more."""
        self._versions.pop(key, None)

    def since(self, version: int) -> Iterator[K]:
        """Yield the keys that changed after a version, the newest first."""
        for key, changed in reversed(self._versions.items()):
            if changed <= version:
                return
            yield key
