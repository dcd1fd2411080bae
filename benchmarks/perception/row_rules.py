"""Other rules about rows, on the same maps of the network: what would they find, and what would they make up?

``python -m benchmarks.perception.row_rules --lots DIR --tiles DIR --regions DIR [--model FILE] [--json FILE]``

Rules: the least score of a vote, the least evidence for a stall past a row's end and in a hole of a row, and a prior:
votes down to `WEAK_SCORE` count where angle, width and length agree with those of the surest stalls around.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from benchmarks.figures import MISSING, write_json
from benchmarks.perception.eyes import MINIMUM_SCORE, MapsOfPictures, NetworkEye
from benchmarks.perception.measures import Looked, look, pooled
from benchmarks.perception.places import Place, folder_option, read_lots, read_tiles
from hawk.algo.vision import quads
from hawk.algo.vision.network import NetworkMaps, StallNetwork
from hawk.algo.vision.rows import Evidence, RowOptions, RowStalls, complete_rows

SHOWN: Final = {
    "precision": "precision",
    "recall": "recall",
    "precision_star": "P*",
    "recall_whole": "R-whole",
    "free_recall": "free recall",
    "state_accuracy": "state",
}
WEAK_SCORE: Final = 0.2
NEVER: Final = 2.0
"""More evidence than there can be."""
_NEIGHBOURS = 12
_LEAST_SURE = 3
_TURNED = 0.12
_LEAST_TURNED_ALIKE = 0.6


@dataclass(frozen=True, slots=True)
class RowRule:
    """One set of rules. ``agree``: greatest difference of width and length, as a share, of a vote below
    ``minimum_score`` that counts by the prior; None: no such vote counts.
    """

    name: str
    minimum_score: float = MINIMUM_SCORE
    options: RowOptions = field(default_factory=RowOptions)
    agree: float | None = None

    def eye(self, maps: MapsOfPictures) -> NetworkEye:
        """Return the eye that looks by these rules."""
        return NetworkEye(maps, self.complete, self.minimum_score if self.agree is None else WEAK_SCORE)

    def complete(self, stalls: RowStalls, evidence: Evidence) -> RowStalls:
        """Complete the rows of what counts."""
        if self.agree is not None and len(stalls):
            sure = stalls.score >= self.minimum_score
            stalls = stalls[sure | agrees(stalls, sure, self.agree)]
        return complete_rows(stalls, evidence, self.options)


RULES: Final = (
    RowRule("as it flies"),
    RowRule("score 0.4", minimum_score=0.4),
    RowRule("score 0.3", minimum_score=0.3),
    RowRule("score 0.6", minimum_score=0.6),
    RowRule("ends from 0.4", options=RowOptions(end=0.4)),
    RowRule("ends from 0.65", options=RowOptions(end=0.65)),
    RowRule("no ends", options=RowOptions(end=NEVER)),
    RowRule("holes from 0.1", options=RowOptions(gap=0.1)),
    RowRule("holes from 0.3", options=RowOptions(gap=0.3)),
    RowRule("prior within 10 %", agree=0.10),
    RowRule("prior within 15 %", agree=0.15),
)


def agrees(stalls: RowStalls, sure: NDArray[np.bool_], share: float) -> NDArray[np.bool_]:
    """Return which stalls (N,) are like the surest ones around: in width and length within ``share`` of the median of
    the nearest `_NEIGHBOURS`, turned like most of these or square to them.
    """
    if int(sure.sum()) < _LEAST_SURE:
        return np.zeros(len(stalls), np.bool_)
    known = stalls[sure]
    number = min(_NEIGHBOURS, len(known))
    nearest = cKDTree(known.centres).query(stalls.centres, number)[1].reshape(len(stalls), number)
    width, length = np.median(known.width[nearest], axis=1), np.median(known.length[nearest], axis=1)
    turned = quads.angle_between(stalls.angle[:, None], known.angle[nearest])
    alike = np.minimum(turned, np.abs(np.pi / 2 - turned)) < _TURNED
    return np.asarray(
        (np.abs(stalls.width / width - 1) < share)
        & (np.abs(stalls.length / length - 1) < share)
        & (alike.mean(axis=1) > _LEAST_TURNED_ALIKE)
    )


class Once:
    """Runs the network for one picture once, however many rules look at it."""

    def __init__(self, network: MapsOfPictures) -> None:
        self._network = network
        self._maps: NetworkMaps | None = None

    def run(self, picture: NDArray[np.uint8], /) -> NetworkMaps:
        """Return the maps of the first picture that is asked for."""
        if self._maps is None:
            self._maps = self._network.run(picture)
        return self._maps


def measure_rules(
    network: MapsOfPictures, places: Iterable[Place], rules: Sequence[RowRule] = RULES
) -> dict[str, dict[str, float]]:
    """Return the measures of each rule by its name."""
    looked: dict[str, list[Looked]] = {rule.name: [] for rule in rules}
    for place in places:
        maps = Once(network)
        for rule in rules:
            looked[rule.name] += look(rule.eye(maps), [place])
    return {name: pooled(those) for name, those in looked.items()}


def table(kind: str, measured: dict[str, dict[str, float]]) -> str:
    """Return the measures as a table in Markdown."""
    lines = [f"| {kind} | " + " | ".join(SHOWN.values()) + " |", "|---" * (len(SHOWN) + 1) + "|"]
    for name, values in measured.items():
        figures = [values.get(key, np.nan) for key in SHOWN]
        lines.append(f"| {name} | " + " | ".join(MISSING if np.isnan(v) else f"{v:.3f}" for v in figures) + " |")
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure by command line."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.perception.row_rules",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--lots", type=folder_option, metavar="DIR")
    parser.add_argument("--tiles", type=folder_option, metavar="DIR")
    parser.add_argument("--regions", type=folder_option, metavar="DIR")
    parser.add_argument("--model", type=Path, metavar="FILE", help="other weights (default: those that ship)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures here")
    options = parser.parse_args(arguments)
    cv2.setNumThreads(1)
    asked = {"places": options.lots, "tiles": options.tiles, "regions": options.regions}
    if not any(asked.values()):
        parser.error("name --lots, --tiles or --regions")
    network = StallNetwork.load(options.model)
    figures: dict[str, float | None] = {}
    for kind, folder in asked.items():
        if folder is None:
            continue
        measured = measure_rules(network, (read_tiles if kind == "tiles" else read_lots)(folder))
        print(table(kind, measured), end="\n\n", flush=True)
        figures |= {
            f"{kind}_{rule}_{key}": None if np.isnan(value) else value
            for rule, values in measured.items()
            for key, value in values.items()
        }
    if options.json is not None:
        write_json(options.json, figures)
    return 0


if __name__ == "__main__":
    sys.exit(main())
