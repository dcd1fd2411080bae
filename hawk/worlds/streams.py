"""Random numbers of a drawing: one stream for everything, or one for each thing."""

from __future__ import annotations

import zlib

import numpy as np


class Streams:
    """One stream for everything, in the order in which things are drawn: one thing less changes all that follow."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng

    def of(self, thing: str, *key: float) -> np.random.Generator:
        """Return the random numbers of a thing; ``key`` states which one of its kind, in metres or whole numbers."""
        del thing, key
        return self._rng


class OwnStreams(Streams):
    """A stream for each thing, by the seed, its kind and its key: whatever is drawn beside it, it looks the same."""

    def __init__(self, seed: int) -> None:
        self._seed = seed

    def of(self, thing: str, *key: float) -> np.random.Generator:
        """Return the random numbers of a thing, the same for its key to a centimetre."""
        numbers = [round(value * 100) % 2**48 for value in key]
        return np.random.default_rng((self._seed, zlib.crc32(thing.encode()), *numbers))
