"""The sections of the perception benchmark."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from benchmarks.figures import Figure, Limit, Reference, Section
from benchmarks.perception.camera_frames import measure_worlds
from benchmarks.perception.eyes import Eye, NetworkEye
from benchmarks.perception.measures import MEASURES, Looked, false_alarms, line, look, measure
from benchmarks.perception.places import Place, coarser, read_lots, read_pictures, read_tiles
from benchmarks.perception.regions import Regions, region_section
from benchmarks.vision_frame import frame_ms
from hawk.algo.vision.detector import StallDetector
from hawk.algo.vision.network import StallNetwork
from hawk.worlds.moment import Condition

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
_OF_COARSER: Final = ("recall", "recall_whole", "precision", "precision_star", "state_accuracy")


@dataclass(frozen=True, slots=True)
class Material:
    """Inputs: folders of places, tiles and pictures without stalls, seeds of drawn worlds, and regions.

    ``coarser``: metres a pixel to which places are averaged, besides as they are.
    """

    lots: Path | None = None
    tiles: Path | None = None
    negatives: Path | None = None
    negatives_scale: float = NEGATIVES_SCALE
    seeds: Sequence[int] = ()
    regions: Regions | None = None
    coarser: Sequence[float] = ()


def network_sections(network: StallNetwork, material: Material) -> list[Section]:
    """Measure the network, and votes and rows after it, on all of it."""
    eye, sections = NetworkEye(network), []
    if material.tiles:
        tiles = list(read_tiles(material.tiles))
        measured = measure(eye, tiles)
        figures = [*_figures(measured, ""), *_wrong_scales(eye, tiles, measured["recall"])]
        sections.append(Section("tiles", figures))
    if material.lots:
        print("places")
        measured = measure(eye, read_lots(material.lots), verbose=True)
        sections.append(Section("places", _figures(measured, "lots_")))
        sections.extend(_coarser(eye, material.lots, metres, measured) for metres in material.coarser)
    if material.regions:
        print("regions")
        sections.append(region_section(material.regions, look_left_out(eye, material.regions)))
    sections.extend(_negatives(eye, material))
    if material.seeds:
        sections.append(_drawn(StallDetector(network), material.seeds))
    sections.append(Section("time", [Figure("ms_per_frame", "a frame at 35 m, one core", frame_ms(network), "ms")]))
    return sections


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


def _wrong_scales(eye: Eye, tiles: Sequence[Place], straight: float) -> list[Figure]:
    """Return recall at wrong scales; ``straight`` is that at the right one."""
    return [
        Figure(
            f"recall_scale_{str(scale).replace('.', '_')}", f"recall at scale x{scale}",
            measure(eye, tiles, scale=scale)["recall"],
            reference=Reference("at x1", straight), limit=Limit(lowest=straight - SCALE_LOSS),
        )
        for scale in SCALES
    ]  # fmt: skip


def _coarser(eye: Eye, lots: Path, metres: float, as_they_are: dict[str, float]) -> Section:
    """Return the measures of places that are averaged to these metres a pixel."""
    found = measure(eye, (coarser(place, metres) for place in read_lots(lots)))
    figures = [
        Figure(
            f"lots_at_{round(100 * metres)}_cm_{name}", name.replace("_", " "), found[name],
            reference=Reference("as they are", as_they_are[name]),
        )
        for name in _OF_COARSER
    ]  # fmt: skip
    return Section(f"places at {metres:g} m a pixel", figures)


def _negatives(eye: Eye, material: Material) -> list[Section]:
    if not material.negatives:
        return []
    found = false_alarms(eye, read_pictures(material.negatives), material.negatives_scale, verbose=True)
    limit = Limit(highest=FALSE_PER_NEGATIVE)
    figures = [Figure(key, "false stalls a picture", value, limit=limit) for key, value in found.items()]
    return [Section("pictures without stalls", figures)]


def _figures(measured: dict[str, float], prefix: str) -> list[Figure]:
    wanted = LIMITS
    if prefix == "lots_":
        wanted = {name: limit for name, limit in wanted.items() if name != "precision"}
    return [
        Figure(f"{prefix}{name}", name.replace("_", " "), None if math.isnan(value) else value, limit=wanted.get(name))
        for name, value in measured.items()
    ]
