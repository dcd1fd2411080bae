"""Worlds that several rooms' tests look at, each drawn once in a process."""

from __future__ import annotations

import functools

from hawk.worlds.generate import generate_world
from hawk.worlds.world import World


@functools.cache
def drawn_world(seed: int) -> World:
    """Return the world of a seed. Drawing takes three seconds of a processor; nobody may change its pixels."""
    world = generate_world(seed)
    world.ground.flags.writeable = False
    return world
