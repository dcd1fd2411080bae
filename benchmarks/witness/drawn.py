"""The flights that are drawn: honest receivers over whole flights, and walks in each phase of one."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Final

import numpy as np

from benchmarks.witness.flight import FRAME_TICKS, Leg, Setting, Wander, lanes, poor
from hawk.worlds.generate import generate_world
from hawk.worlds.world import World

WANDER: Final = Wander(2.1, 600.0)
"""u-blox M8's data sheet (UBX-15031086): 2.5 m CEP, static, which is 2.1 m along each axis. Its time: half of that of
the receivers' model in Beard and McLain, Small Unmanned Aircraft (1,100 s): it wanders more in the same minutes."""
WORLDS: Final = 10
SPEEDS: Final = (0.1, 0.15, 0.25, 0.35, 0.5, 0.7, 1.4)
"""Speeds of walks, m/s."""
FAST_M_S: Final = 0.35
GROUNDS: Final = ("lot", "poor", "blind")
"""Over a lot; over ground with little texture; over a lot, every fourth picture without any texture."""
BLIND: Final = 4
FAST_TICKS: Final = 5
"""Four pictures a second, as many as are compared in a flight."""
BESIDE_M: Final = 8.0
LOW_M: Final = (14.0, 38.0)
"""Heights of a survey, metres over ground."""
HIGH_M: Final = (38.0, 100.0)
"""Heights above them, metres."""


_PHASES: Final[Mapping[str, tuple[float, tuple[Leg, ...]]]] = {
    "first hover": (6.0, (Leg((0.0, 0.0), 300.0),)),
    "long hover": (100.0, (Leg((0.0, 0.0), 400.0),)),
    "hover after a tour": (60.0, (Leg((0.0, 0.0), 10.0), *lanes(20.0, 30.0, 10.0), Leg((8.0, 5.0), 300.0))),
}
"""When the walk begins, seconds, and the legs of the flight."""


@dataclass(frozen=True, slots=True)
class Named:
    """A flight: its name, its phase, the world that it is over, and how it is drawn; ``by_roof``: beside a roof."""

    name: str
    phase: str
    world: int
    is_poor: bool
    setting: Setting
    by_roof: bool = False

    def drawn(self) -> tuple[World, Setting]:
        """Return its world and its setting; a world takes seconds."""
        ground = poor_world(self.world) if self.is_poor else world(self.world)
        if not self.by_roof:
            return ground, self.setting
        return ground, replace(self.setting, offset=_beside_roof(ground, self.setting.offset))

    @property
    def speed(self) -> float:
        """Speed of its walk, m/s; 0 without one."""
        return math.hypot(*self.setting.walk)


@lru_cache(maxsize=1)
def world(seed: int) -> World:
    """Return a drawn world."""
    return generate_world(seed)


@lru_cache(maxsize=1)
def poor_world(seed: int) -> World:
    """Return it with little texture."""
    return poor(world(seed))


def honest(count: int, first: int = 1) -> Iterator[Named]:
    """Yield flights without a walk, sorted by worlds: with wind, trucks, roofs, and all errors of an honest drone."""
    flights = [_honest(seed) for seed in range(first, first + count)]
    yield from sorted(flights, key=lambda flight: flight.world)


def walks(repeats: int, first: int = 1) -> Iterator[Named]:
    """Yield flights in which GNSS walks, sorted by worlds."""
    cases = [(phase, ground, speed) for phase in _PHASES for ground in GROUNDS for speed in SPEEDS] * repeats
    flights = [_walk(first + k, *case) for k, case in enumerate(cases)]
    yield from sorted(flights, key=lambda flight: (flight.world, flight.is_poor))


def high_walks(repeats: int, first: int = 1) -> Iterator[Named]:
    """Yield flights in which GNSS walks above the height of a survey, over lots, sorted by worlds."""
    cases = [(phase, speed) for phase in _PHASES for speed in SPEEDS] * repeats
    flights = [_walk(first + k, phase, "lot", speed, is_high=True) for k, (phase, speed) in enumerate(cases)]
    yield from sorted(flights, key=lambda flight: flight.world)


def tasks(repeats: int, first: int = 1) -> Iterator[Named]:
    """Yield flights in which GNSS walks while a survey is flown in lanes, sorted by worlds."""
    for k, speed in enumerate(SPEEDS * repeats):
        base = _errors(first + k, 5000)
        legs = (Leg((0.0, 0.0), 20.0), *lanes(44.0, 60.0, 11.0), *lanes(44.0, 60.0, 11.0))
        setting = replace(base, legs=legs, walk=_walk_of(base.seed, speed), walk_at=35.0, limit_s=200.0)
        yield Named(f"task {speed} m/s {k}", "task", 1 + (first + k) % WORLDS, False, setting)


def _errors(seed: int, kind: int, heights: tuple[float, float] = LOW_M) -> Setting:
    """Return the errors of an honest drone: receiver, height, compass, and the pictures' time; wind and trucks."""
    rng = np.random.default_rng((seed, kind))
    return Setting(
        seed=seed + kind,
        legs=(),
        height_m=float(rng.uniform(*heights)),
        offset=(float(rng.uniform(-15, 15)), float(rng.uniform(-20, 20))),
        wind_m_s=float(rng.uniform(0.0, 9.0)),
        wander=WANDER,
        height_factor=float(1.0 + 0.03 * rng.standard_normal()),
        compass=float(math.radians(2.0) * rng.standard_normal()),
        late_s=float(rng.uniform(0.0, 0.1)),
        truck_s=25.0 if rng.random() < 0.5 else 0.0,
    )


def _honest(seed: int) -> Named:
    base, number = _errors(seed, 1000, HIGH_M if seed % 2 else LOW_M), 1 + seed % WORLDS
    rng = np.random.default_rng((seed, 2))
    by_roof = seed % 5 == 1
    if by_roof:
        base = replace(base, height_m=max(base.height_m, 22.0))
    tour = lanes(float(rng.uniform(20, 50)), float(rng.uniform(30, 70)), float(rng.uniform(8, 14)))
    first, last = float(rng.uniform(20, 80)), float(rng.uniform(20, 80))
    legs = (Leg((0.0, 0.0), first), *tour, Leg((0.0, 10.0), last), Leg((0.0, 0.0), 10.0))
    blind = BLIND if seed % 5 == 2 else 0
    setting = replace(base, legs=legs, blind=blind, limit_s=240.0)
    return Named(f"honest {seed}", "honest", number, seed % 5 == 3, setting, by_roof)


def _walk(seed: int, phase: str, ground: str, speed: float, is_high: bool = False) -> Named:
    base = _errors(seed, 7000, HIGH_M) if is_high else _errors(seed, 3000)
    begins, legs = _PHASES[phase]
    setting = replace(
        base,
        legs=legs,
        walk=_walk_of(seed, speed),
        walk_at=begins,
        blind=BLIND if ground == "blind" else 0,
        limit_s=begins + (30.0 if is_high else 12.0) / speed,
        frame_ticks=FAST_TICKS if speed >= FAST_M_S else FRAME_TICKS,
    )
    return Named(f"{phase}, {ground}, {speed} m/s", phase, 1 + seed % WORLDS, ground == "poor", setting)


def _walk_of(seed: int, speed: float) -> tuple[float, float]:
    heading = float(np.random.default_rng((seed, 4)).uniform(0, math.tau))
    return speed * math.cos(heading), speed * math.sin(heading)


def _beside_roof(drawn: World, usual: tuple[float, float]) -> tuple[float, float]:
    """Return the offset of a place beside the highest roof, which the lanes cross; ``usual`` without one."""
    roofs = [layer for layer in drawn.layers if layer.label == "roof"]
    if not roofs:
        return usual
    corners = max(roofs, key=lambda layer: layer.height).corners
    middle = np.mean([stall.corners.mean(0) for stall in drawn.stalls], 0)
    north, east = float(middle[1] - corners[:, 1].mean()), float(corners[:, 0].mean() - middle[0])
    near = 1.0 - min(1.0, (np.ptp(corners[:, :2], 0).max() / 2 + BESIDE_M) / max(1.0, math.hypot(north, east)))
    return north * near, east * near
