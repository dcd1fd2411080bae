"""Perception on still pictures and videos, without a flight: network, votes and rows, beside painted lines alone.

``python -m benchmarks.perception --lots DIR --tiles DIR --negatives DIR --seeds 1-5 --json FILE``

``--lots``: pictures ``PLACE.jpg`` with ``PLACE.json`` (metres_per_pixel, stalls with corners_m and state, lots_m).
``--tiles``: ``images/*.jpg`` with ``labels/*.txt`` (class, polygon in fractions; 0 car, 1 lot, 3 stall); tiles with
fewer than five stalls are left out. ``--negatives``: pictures without any stall. ``--seeds``: single frames over drawn
worlds. The measures are those of `hawk.survey.scoring`. In JSON the figures of tiles have no prefix, those of places
``lots_``, those of frames over drawn worlds ``frames_``, and those of lines alone ``classical_`` before all others.

``python -m benchmarks.perception --video FILE --metres-per-pixel X``: a still camera straight above a lot.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import cv2
from rich.console import Console

from benchmarks.figures import Figure, Limit, Reference, Section, flat, print_table, write_json
from benchmarks.perception.camera_frames import measure_tilted, measure_worlds
from benchmarks.perception.eyes import ClassicalEye, Eye, NetworkEye
from benchmarks.perception.measures import MEASURES, false_alarms, line, measure
from benchmarks.perception.places import Place, read_lots, read_pictures, read_tiles
from benchmarks.perception.video import watch
from benchmarks.surveys import parse_seeds
from benchmarks.vision_frame import frame_ms
from hawk.algo.vision.finder import Finder, NetworkFinder
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
"""How much recall a wrong scale may cost."""
FALSE_PER_NEGATIVE: Final = 0.2


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure by command line."""
    options = _parser().parse_args(arguments)
    cv2.setNumThreads(1)
    network = StallNetwork.load(options.model)
    if options.video is not None:
        return _video(network, options.video, options.metres_per_pixel)
    sections = _network_sections(network, options)
    if not options.no_classical:
        sections.append(_classical(options))
    print_table(sections, Console(width=None if sys.stdout.isatty() else 130))
    if options.json:
        write_json(options.json, flat(sections))
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.perception",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--lots", type=Path)
    parser.add_argument("--tiles", type=Path)
    parser.add_argument("--negatives", type=Path)
    parser.add_argument("--negatives-scale", type=float, default=0.03, help="metres per pixel of the negatives (0.03)")
    parser.add_argument("--seeds", type=parse_seeds, default=[], help="drawn worlds to see in single frames, as 1-5")
    parser.add_argument("--model", type=Path, help="an ONNX file in place of the package's")
    parser.add_argument("--no-classical", action="store_true", help="leave out painted lines alone")
    parser.add_argument("--video", type=Path, help="a video of a still camera straight above a lot")
    parser.add_argument("--metres-per-pixel", type=float, default=0.1, help="of the video (0.1)")
    parser.add_argument("--json", type=Path, help="write the figures here")
    return parser


def _network_sections(network: StallNetwork, options: argparse.Namespace) -> list[Section]:
    eye, sections = NetworkEye(network), []
    if options.tiles:
        tiles = list(read_tiles(options.tiles))
        measured = measure(eye, tiles)
        hard = _hard(eye, network, tiles, measured["recall"])
        sections.append(Section("tiles", [*_figures(measured, "", PROTOTYPE_TILES), *hard]))
    if options.lots:
        print("places")
        sections.append(
            Section("places", _figures(measure(eye, read_lots(options.lots), verbose=True), "lots_", PROTOTYPE_LOTS))
        )
    sections.extend(_negatives(eye, options, ""))
    if options.seeds:
        sections.append(_drawn(NetworkFinder(network), options.seeds))
    sections.append(Section("time", [Figure("ms_per_frame", "a frame at 35 m, one core", frame_ms(network), "ms")]))
    return sections


def _drawn(finder: Finder, seeds: Sequence[int]) -> Section:
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
    tilted = measure_tilted(NetworkFinder(network), tiles)
    figures.append(Figure("recall_tilt_10", "recall in frames tilted by 10 degrees, rows not completed", tilted.recall))
    figures.append(Figure("state_accuracy_tilt_10", "state accuracy in tilted frames", tilted.state_accuracy))
    return figures


def _classical(options: argparse.Namespace) -> Section:
    eye, figures = ClassicalEye(), []
    if options.tiles:
        figures += _figures(measure(eye, read_tiles(options.tiles)), "classical_", {}, limits={})
    if options.lots:
        figures += _figures(measure(eye, read_lots(options.lots)), "classical_lots_", {}, limits={})
    for section in _negatives(eye, options, "classical_"):
        figures += section.figures
    return Section("painted lines alone", figures)


def _negatives(eye: Eye, options: argparse.Namespace, prefix: str) -> list[Section]:
    if not options.negatives:
        return []
    found = false_alarms(eye, read_pictures(options.negatives), options.negatives_scale, verbose=not prefix)
    limit = None if prefix else Limit(highest=FALSE_PER_NEGATIVE)
    figures = [Figure(f"{prefix}{key}", "false stalls a picture", value, limit=limit) for key, value in found.items()]
    return [Section("pictures without stalls", figures)]


def _figures(
    measured: dict[str, float],
    prefix: str,
    reference: dict[str, float],
    limits: dict[str, Limit] | None = None,
) -> list[Figure]:
    wanted = LIMITS if limits is None else limits
    if prefix.endswith("lots_"):
        wanted = {name: limit for name, limit in wanted.items() if name != "precision"}
    return [
        Figure(
            f"{prefix}{name}", name.replace("_", " "), None if math.isnan(value) else value,
            reference=Reference("prototype", reference[name]) if name in reference else None, limit=wanted.get(name),
        )
        for name, value in measured.items()
    ]  # fmt: skip


def _video(network: StallNetwork, path: Path, metres_per_pixel: float) -> int:
    try:
        stalls = watch(NetworkFinder(network), path, metres_per_pixel)
    except (FileNotFoundError, ValueError) as error:
        print(f"--video: {error}", file=sys.stderr)
        return 2
    for stall in stalls:
        print(f"stall {stall.id}: {stall.state.value}, counted in {stall.frames} frames, state flipped {stall.flips} x")
    print(f"{len(stalls)} stalls, {sum(stall.flips for stall in stalls)} flips")
    return 0


if __name__ == "__main__":
    sys.exit(main())
