"""Flies many worlds."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from fnmatch import fnmatch
from pathlib import Path

import cv2

from benchmarks.chain_flight.flight import Errors, fly, lot_of
from benchmarks.chain_flight.measure import ORIGIN, Result, SingleFrames, figures, judge, line, survey_of
from benchmarks.chain_flight.pairs import pair_of
from benchmarks.figures import BenchmarkError, Figure
from benchmarks.world_lots import kinematic_flight, place_world
from hawk.algo.vision.app import VisionApp, VisionSettings
from hawk.results.map_picture import map_picture
from hawk.survey.truth import parse_truth
from hawk.worlds.generate import generate_world
from hawk.worlds.world import World

Named = tuple[str, World]


def measure(chosen: Sequence[int]) -> list[Figure]:
    """Return the figures of drawn worlds, for the table of all benchmarks."""
    cv2.setNumThreads(1)
    return measure_worlds(seeds(chosen), Errors(), None, None)


def measure_worlds(worlds: Iterable[Named], errors: Errors, model: Path | None, pictures: Path | None) -> list[Figure]:
    """Fly over every world and report on each; ``pictures`` is a folder for their maps.

    Raises BenchmarkError when there is none.
    """
    results = [fly_one(name, world, errors, model, pictures) for name, world in worlds]
    if not results:
        raise BenchmarkError("no world to fly over: name seeds, or a folder that holds PLACE.jpg with PLACE.json")
    return figures(results)


def fly_one(name: str, world: World, errors: Errors, model: Path | None, pictures: Path | None) -> Result:
    """Fly over one world."""
    truth = parse_truth(world.truth_json())
    truth = replace(truth, origin=truth.origin or ORIGIN)
    single = SingleFrames(world)
    vision = VisionApp(VisionSettings(model=model))
    lot = lot_of(truth, world.start())
    flown = fly(world, lot, vision, errors, seed=world.seed or 0, watch=single.watch)
    result = judge(name, world, truth, flown, single, kinematic_flight(lot).whole_distance_m)
    print(line(result), file=sys.stderr, flush=True)
    if pictures is not None:
        pictures.mkdir(parents=True, exist_ok=True)
        cv2.imwrite(str(pictures / f"{name.replace(' ', '-')}.png"), map_picture(survey_of(world, flown)))
    return result


def seeds(chosen: Sequence[int]) -> Iterator[Named]:
    """Yield drawn worlds."""
    for seed in chosen:
        yield f"seed {seed}", generate_world(seed)


def lots(folder: Path, pattern: str = "*") -> Iterator[Named]:
    """Yield pictures of places, each with its truth beside it; ``pattern`` is one of names, as in a shell."""
    for path in sorted(folder.glob(f"{pattern}.json")):
        yield path.stem, place_world(path)


def pairs(folder: Path, count: int, pattern: str = "*") -> Iterator[Named]:
    """Yield pairs of those places with a drive between them (`pairs.pair_of`); ``pattern`` is one of the pairs' names.

    Raises BenchmarkError when there are no two places.
    """
    places = [world for _, world in lots(folder)]
    if len(places) < 2:
        raise BenchmarkError("no pair to fly over: name a folder that holds two places, PLACE.jpg with PLACE.json")
    for seed in range(1, count + 1):
        world = pair_of(places, seed)
        if fnmatch(world.name, pattern):
            yield world.name, world
