"""The surveys of one lot that are made one after the other, and the worlds that they see."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from benchmarks.world_lots import place_world
from hawk.worlds.generate import WorldOptions, generate_world
from hawk.worlds.moved_cars import move_cars
from hawk.worlds.world import World, WorldError

FIRST: Final = datetime(2026, 5, 4, 10, 30, tzinfo=UTC)
HOURS: Final = (0.0, 26.5, 46.25, 73.0, 101.5, 148.0)
"""Hours after the first survey: other hours of other days, all in daylight."""
BIAS_M: Final = 3.0
COMPASS: Final = math.radians(2.0)
NEXT_DOOR: Final = 500
"""The lot next door is the world of a seed that is higher by this."""
APART_M: Final = 160.0
"""Distance from a lot to the one next door, eastwards."""
DARKENED: Final = 0.7
"""Brightness of every second survey of a picture."""


@dataclass(frozen=True, slots=True)
class Visit:
    """One survey: its number from 1, hours after the first one, the receiver's bias (metres, north and east) and the
    compass's error (radians, clockwise). ``part``: the share of the lot, from its western edge, that is seen.
    ``is_next_door``: it is a survey of the other lot.
    """

    number: int
    hours: float
    bias: tuple[float, float]
    compass: float
    repaint: int = 0
    part: float = 1.0
    is_next_door: bool = False

    @property
    def at(self) -> datetime:
        """Moment of the survey."""
        return FIRST + timedelta(hours=self.hours)


def visits(seed: int) -> list[Visit]:
    """Return the six surveys of a lot: the third sees half of it, the fourth the lot next door, and it is repainted
    before the fifth.
    """
    rng = np.random.default_rng((seed, 38))
    return [
        Visit(
            number,
            hours,
            bias=drawn_bias(rng),
            compass=float(rng.uniform(-COMPASS, COMPASS)),
            repaint=int(number >= 5),
            part=0.5 if number == 3 else 1.0,
            is_next_door=number == 4,
        )
        for number, hours in enumerate(HOURS, 1)
    ]


def drawn_bias(rng: np.random.Generator) -> tuple[float, float]:
    """Return a receiver's bias, metres north and east."""
    radius, towards = BIAS_M * math.sqrt(rng.random()), rng.uniform(0, 2 * math.pi)
    return float(radius * math.cos(towards)), float(radius * math.sin(towards))


@dataclass(frozen=True, slots=True)
class DrawnLot:
    """The lot of a seed."""

    seed: int

    @property
    def name(self) -> str:
        """Name of the lot."""
        return f"seed {self.seed}"

    def visits(self) -> list[Visit]:
        """Return its surveys."""
        return visits(self.seed)

    def world(self, visit: Visit) -> World:
        """Return what a survey sees."""
        seed = self.seed + NEXT_DOOR if visit.is_next_door else self.seed
        return generate_world(seed, WorldOptions(at=visit.at, repaint=visit.repaint, place=(43.26, -79.92)))


@dataclass(frozen=True, slots=True)
class PictureLot:
    """A real place by its picture: the cars of a survey are those of the picture, moved."""

    path: Path

    @property
    def name(self) -> str:
        """Name of the lot."""
        return self.path.stem

    def visits(self) -> list[Visit]:
        """Return its surveys: no paint is changed, and no other place lies next door."""
        drawn = visits(sum(map(ord, self.name)))
        return [replace(visit, repaint=0) for visit in drawn if not visit.is_next_door]

    def world(self, visit: Visit) -> World:
        """Return what a survey sees: the first one the picture as it is, the others with its cars moved."""
        world = place_world(self.path)
        world = replace(world, stalls=tuple(replace(stall, id=k) for k, stall in enumerate(world.stalls)))
        if visit.number > 1:
            with contextlib.suppress(WorldError):  # its labels name no states: the cars stay, the light changes
                world = move_cars(world, visit.number)
        if visit.number % 2 == 0:
            world = replace(world, ground=np.asarray(cv2.convertScaleAbs(world.ground, alpha=DARKENED), np.uint8))
        return world


def pictures(folder: Path) -> Iterator[PictureLot]:
    """Yield the places of a folder of PLACE.jpg and PLACE.json."""
    for path in sorted(folder.glob("*.json")):
        yield PictureLot(path)
