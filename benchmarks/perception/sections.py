"""The sections of the perception benchmark: the network beside the prototype's figures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from benchmarks.figures import Figure, Limit, Reference, Section
from benchmarks.perception.camera_frames import measure_tilted, measure_worlds
from benchmarks.perception.errors import error_section
from benchmarks.perception.eyes import Eye, NetworkEye
from benchmarks.perception.measures import MEASURES, Looked, false_alarms, line, look, measure, pooled
from benchmarks.perception.photos import Photos, photo_section
from benchmarks.perception.places import Place, read_lots, read_pictures, read_tiles
from benchmarks.perception.plans import plan_section
from benchmarks.perception.regions import Regions, region_section
from benchmarks.vision_frame import frame_ms
from hawk.algo.vision.detector import StallDetector
from hawk.algo.vision.network import StallNetwork
from hawk.worlds.conditions import Condition

PROTOTYPE_TILES: Final = {
    "precision": 0.879, "recall": 0.892, "precision_star": 0.917, "recall_whole": 0.927,
    "free_precision_star": 0.908, "free_recall": 0.820, "state_accuracy": 0.949, "lot_iou": 0.769,
}  # fmt: skip
"""The prototype on 48 tiles of 13 other places."""
PROTOTYPE_LOTS: Final = {
    "precision": 0.708, "recall": 0.906, "precision_star": 0.899, "recall_whole": 0.935,
    "free_precision_star": 0.875, "free_recall": 0.835, "state_accuracy": 0.943, "lot_iou": 0.809,
}  # fmt: skip
"""The prototype on 11 other stitched places."""
LIMITS: Final = {
    "precision": Limit(lowest=0.90), "precision_star": Limit(lowest=0.96), "recall_whole": Limit(lowest=0.95),
    "free_precision_star": Limit(lowest=0.95), "free_recall": Limit(lowest=0.90), "state_accuracy": Limit(lowest=0.97),
    "lot_iou": Limit(lowest=0.88),
}  # fmt: skip
SCALES: Final = (0.8, 1.2)
SCALE_LOSS: Final = 0.02
"""Greatest loss of recall by a wrong scale."""
FALSE_PER_NEGATIVE: Final = 0.2
NEGATIVES_SCALE: Final = 0.03
"""Metres per pixel of the pictures without stalls, if nothing else is said."""


@dataclass(frozen=True, slots=True)
class Material:
    """Inputs: folders of places, tiles and pictures without stalls, seeds of drawn worlds, regions, and the
    photographs of a flight.
    """

    lots: Path | None = None
    tiles: Path | None = None
    negatives: Path | None = None
    negatives_scale: float = NEGATIVES_SCALE
    seeds: Sequence[int] = ()
    regions: Regions | None = None
    photos: Photos | None = None


def network_sections(network: StallNetwork, material: Material) -> list[Section]:
    """Measure the network, and votes and rows after it, on all of it."""
    eye, sections = NetworkEye(network), []
    if material.tiles:
        tiles = list(read_tiles(material.tiles))
        looked = look(eye, tiles)
        measured = pooled(looked)
        hard = _hard(eye, network, tiles, measured["recall"])
        sections.append(Section("tiles", [*_figures(measured, "", PROTOTYPE_TILES), *hard]))
        sections.append(error_section("tiles", looked, "errors_tiles_"))
    if material.lots:
        print("places")
        looked = look(eye, read_lots(material.lots), verbose=True)
        sections.append(Section("places", _figures(pooled(looked), "lots_", PROTOTYPE_LOTS)))
        sections.append(error_section("places", looked, "errors_lots_"))
    if material.regions:
        print("regions")
        looked = look_left_out(eye, material.regions)
        sections.append(region_section(material.regions, looked))
        sections.append(error_section("regions", looked, "errors_regions_"))
    if material.photos:
        print("photographs")
        sections.append(photo_section(eye, material.photos))
    sections.extend(_negatives(eye, material))
    if material.seeds:
        sections.append(_drawn(StallDetector(network), material.seeds))
    sections.append(Section("time", [Figure("ms_per_frame", "a frame at 35 m, one core", frame_ms(network), "ms")]))
    return sections


def plan_sections(network: StallNetwork, material: Material) -> list[Section]:
    """Measure places and regions with their labels as the plan."""
    places = [] if material.lots is None else list(read_lots(material.lots))
    if material.regions is not None:
        places += material.regions.read()
    return [plan_section(NetworkEye(network), places)]


def look_left_out(eye: Eye, regions: Regions) -> list[Looked]:
    """Look at every region by the network that was not trained on it, where one is named."""
    places = regions.read()
    models = {place.name: regions.model(place.name) for place in places}
    eyes = {model: eye if model is None else NetworkEye(StallNetwork.load(model)) for model in set(models.values())}
    return [one for place in places for one in look(eyes[models[place.name]], [place], verbose=True)]


def _drawn(finder: StallDetector, seeds: Sequence[int]) -> Section:
    """Return the measures over drawn worlds by day, and what other conditions leave of recall and state accuracy."""
    print("frames over drawn worlds by day")
    day = measure_worlds(finder, seeds, verbose=True)
    print(f"  all: {line(day.measures())} ({day.true} stalls in view)")
    figures = [Figure(f"frames_{name}", name.replace("_", " "), day.measures()[name]) for name in MEASURES]
    for condition in Condition:
        if condition is not Condition.DAY:
            found = measure_worlds(finder, seeds, condition=condition)
            figures += [
                Figure(
                    f"frames_{condition}_{name}", f"{name.replace('_', ' ')}, {condition}", found.measures()[name],
                    reference=Reference("day", day.measures()[name]),
                )
                for name in ("recall", "precision", "state_accuracy")
            ]  # fmt: skip
    return Section("single frames over drawn worlds", figures)


def _hard(eye: Eye, network: StallNetwork, tiles: Sequence[Place], straight: float) -> list[Figure]:
    """Return recall at wrong scales and of tilted frames; ``straight`` is that at the right scale."""
    figures = []
    for scale in SCALES:
        recall = measure(eye, tiles, scale=scale)["recall"]
        figures.append(
            Figure(
                f"recall_scale_{str(scale).replace('.', '_')}", f"recall at scale x{scale}", recall,
                reference=Reference("at x1", straight), limit=Limit(lowest=straight - SCALE_LOSS),
            )
        )  # fmt: skip
    tilted = measure_tilted(StallDetector(network), tiles)
    figures.append(Figure("recall_tilt_10", "recall in frames tilted by 10 degrees, rows not completed", tilted.recall))
    figures.append(Figure("state_accuracy_tilt_10", "state accuracy in tilted frames", tilted.state_accuracy))
    return figures


def _negatives(eye: Eye, material: Material) -> list[Section]:
    if not material.negatives:
        return []
    found = false_alarms(eye, read_pictures(material.negatives), material.negatives_scale, verbose=True)
    limit = Limit(highest=FALSE_PER_NEGATIVE)
    figures = [Figure(key, "false stalls a picture", value, limit=limit) for key, value in found.items()]
    return [Section("pictures without stalls", figures)]


def _figures(measured: dict[str, float], prefix: str, reference: dict[str, float]) -> list[Figure]:
    wanted = LIMITS
    if prefix == "lots_":
        wanted = {name: limit for name, limit in wanted.items() if name != "precision"}
    return [
        Figure(
            f"{prefix}{name}", name.replace("_", " "), None if math.isnan(value) else value,
            reference=Reference("prototype", reference[name]) if name in reference else None, limit=wanted.get(name),
        )
        for name, value in measured.items()
    ]  # fmt: skip
