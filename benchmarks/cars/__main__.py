"""Vehicles of real pictures: recall and precision within 1.5 m, one to one, beside boxes about the car channel.

``python -m benchmarks.cars --regions DIR --tiles DIR --crossings DIR --json FILE``

``--regions``: ``REGION.jpg`` at 0.1 m a pixel, whose vehicles ``benchmarks/cars/labels`` have; ``--left-out
FILE=PATTERN`` names the network that was not trained on some of them. ``--tiles``: ``images/*.jpg`` with
``labels/*.txt`` (class 0 is a car). ``--crossings``: frames with boxes of cars; no stall is there, so each that is
found is invented; ``--drawn-crossings 1-24`` draws such pictures. ``--metres`` averages the others to coarser pixels
besides.

In JSON the figures of regions begin with ``cars_regions``, those of tiles with ``cars_tiles``, those of crossings with
``cars_crossings``.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

import cv2

from benchmarks.cars.eyes import ChannelEye, VehicleEye, maps_of
from benchmarks.cars.labels import LabelError
from benchmarks.cars.measures import CarTally, LotSection, figures, flicker, measure, read_sections
from benchmarks.cars.scenes import CarScene, at_metres, draw_crossing, read_car_tiles, read_crossings, read_regions
from benchmarks.figures import Figure, Section, print_and_write, share
from benchmarks.options import folder_option, make_parser, seeds_option
from benchmarks.perception.regions import left_out_option, model_for
from hawk.algo.vision.network import StallNetwork
from hawk.picture.orthophoto.tile_detector import found_in


class CarBenchmark:
    """Looks at pictures with each network that is named, and with the car channel beside it."""

    def __init__(self, model: Path | None, left_out: Sequence[tuple[Path, str]]) -> None:
        self._left_out = tuple(left_out)
        self._networks = {path: StallNetwork.load(path) for path in {model, *(path for path, _ in left_out)}}
        self._model = model

    def network(self, name: str) -> StallNetwork:
        """Return the network that was not trained on a picture."""
        return self._networks[model_for(self._left_out, name) or self._model]

    def sections(self, key: str, scenes: Iterable[CarScene], parts: Sequence[LotSection] = ()) -> list[Section]:
        """Return the table of some pictures: all together, and recall and precision of each region."""
        found, former, rows = CarTally(), CarTally(), []
        for scene in scenes:
            network = self.network(scene.name)
            one = measure(VehicleEye(network), scene, parts)
            found, former = found + one, former + measure(ChannelEye(network), scene, parts)
            if not parts:
                continue
            rows += [
                row for row in figures(one, f"{key}_{scene.name}") if row.text in ("labels", "recall", "precision")
            ]
            print(f"  {scene.name:28s} {one.labels:4d} labels, {one.matched} found, {one.found - one.matched} false")
        return [Section(key, [*figures(found, key, former), *rows])] if found.labels else []

    def flickering(self, scenes: Iterable[CarScene]) -> Section:
        """Return the share of the vehicles found that some shifts of the picture by a few pixels lose."""
        counts = [flicker(VehicleEye(self.network(scene.name)), scene) for scene in scenes]
        lost, found = (sum(each) for each in zip(*counts, strict=True))
        rows = [Figure("cars_flicker", "lost by some of eight shifts, of those found", share(lost, found))]
        return Section("shifted by some pixels", rows)


def invented(benchmark: CarBenchmark, scenes: Iterable[CarScene], key: str, text: str) -> Figure:
    """Return how many stalls are found where no stall is."""
    counts = [len(found_in(maps_of(benchmark.network(one.name), one)).stalls) for one in scenes]
    return Figure(key, text, sum(counts) / len(counts) if counts else None)


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure by command line."""
    options = _parser().parse_args(arguments)
    cv2.setNumThreads(1)
    try:
        benchmark = CarBenchmark(options.model, options.left_out)
        return print_and_write(_tables(benchmark, options), options.json)
    except (LabelError, OSError, ValueError) as error:
        print(f"benchmarks.cars: {error}", file=sys.stderr)
        return 2


def _tables(benchmark: CarBenchmark, options: argparse.Namespace) -> list[Section]:
    parts = read_sections()
    given: list[tuple[str, list[CarScene], Sequence[LotSection]]] = []
    if options.regions:
        given.append(("cars_regions", list(read_regions(options.regions)), parts))
    if options.tiles:
        given.append(("cars_tiles", list(read_car_tiles(options.tiles)), ()))
    crossings = list(read_crossings(options.crossings)) if options.crossings else []
    if crossings:
        given.append(("cars_crossings", crossings, ()))
    tables = [benchmark.flickering(given[0][1])] if options.shifts and given else []
    tables += [table for key, scenes, these in given for table in benchmark.sections(key, scenes, these)]
    for metres in options.metres:
        for key, scenes, these in given:
            coarse = [scene for one in scenes if (scene := at_metres(one, metres)) is not None]
            tables += benchmark.sections(f"{key}_at_{round(100 * metres)}_cm", coarse, these)
    drawn = map(draw_crossing, options.drawn_crossings)
    rows = [
        invented(benchmark, crossings, "cars_invented_a_picture", "stalls invented a picture"),
        invented(benchmark, drawn, "cars_invented_a_drawn_picture", "stalls invented a drawn picture"),
    ]
    return [*tables, Section("crossings without stalls", [row for row in rows if row.value is not None])]


def _parser() -> argparse.ArgumentParser:
    parser = make_parser("benchmarks.cars", __doc__)
    parser.add_argument("--regions", type=folder_option)
    parser.add_argument("--tiles", type=folder_option)
    parser.add_argument("--crossings", type=folder_option)
    parser.add_argument(
        "--drawn-crossings", type=seeds_option, default=[], metavar="SEEDS", help="crossings to draw, as 1-24"
    )
    parser.add_argument("--metres", type=float, nargs="+", default=[], help="of coarser pixels, as 0.12 0.15")
    parser.add_argument(
        "--left-out", action="append", default=[], type=left_out_option, metavar="FILE=PATTERN",
        help="a network that was not trained on the regions of these names looks at them",
    )  # fmt: skip
    parser.add_argument("--shifts", action="store_true", help="look at the first of these in eight shifts, too")
    parser.add_argument("--model", type=Path, help="an ONNX file in place of the package's")
    return parser


if __name__ == "__main__":
    sys.exit(main())
