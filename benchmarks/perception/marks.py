"""Recall over drawn lots without paint, by what parts their stalls and by how full they are.

``python -m benchmarks.perception.marks --scenes 14`` draws scenes as for a training (`training.paved`), of each kind of
marks once nearly empty and once well filled. No weights were trained on these seeds. Every stall in sight counts, free
ones between which there is nothing too: in an empty lot no recall near 1 is to be expected of those.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from benchmarks.figures import write_json
from benchmarks.perception.eyes import Eye, NetworkEye
from hawk.algo.vision.network import StallNetwork
from hawk.survey.accuracy import match
from hawk.worlds.plan import SitePlan
from hawk.worlds.style import LotStyle, Marks
from training.paved import MARKS, plan_paved_site
from training.scenes import SITES, Scene, SceneStall, draw_scene

KINDS: Final[dict[str, tuple[Marks, bool]]] = {**{marks: (marks, False) for marks in MARKS}, "nothing": ("lines", True)}
"""Marks, and whether nothing parts the stalls after all (`hawk.worlds.style.LotStyle`)."""
OCCUPANCIES: Final = {"nearly empty": 0.1, "well filled": 0.8}
SCENES: Final = 14
SIDE_PX: Final = 448
_SEED: Final = 77
_COVERED: Final = 0.3
"""Stalls of which more than this is under crowns and roofs are left out."""
_EDGE_PX: Final = 2


@dataclass(frozen=True, slots=True)
class Count:
    """Stalls in scenes, and how many of them were found."""

    stalls: int = 0
    found: int = 0

    @property
    def recall(self) -> float:
        """Share that was found; not a number without stalls."""
        return self.found / self.stalls if self.stalls else float("nan")


def lots(kind: str, occupancy: float, count: int = SCENES) -> Iterator[Scene]:
    """Yield drawn scenes of a kind of marks. Raises KeyError for an unknown kind."""
    marks, is_unmarked = KINDS[kind]

    def change(style: LotStyle) -> LotStyle:
        return replace(style, marks=marks, unpainted=is_unmarked, occupancy=occupancy)

    def plan(rng: np.random.Generator) -> SitePlan:
        return plan_paved_site(rng, (0.0, 0.0), SITES[0], change)

    for number in range(count):
        yield draw_scene(np.random.default_rng((_SEED, number)), SIDE_PX, plan_site=plan)


def measure(eye: Eye, scenes: Iterator[Scene]) -> dict[bool, Count]:
    """Return the counts of free (False) and taken (True) stalls that lie wholly in the scenes, mostly in sight."""
    counts = {False: Count(), True: Count()}
    for scene in scenes:
        shown = [stall for stall in scene.stalls if _is_in_sight(scene, stall)]
        if not shown:
            continue
        found = eye.look(scene.image, scene.metres_per_pixel).finding.stalls
        true = np.array([(stall.quad + 0.5) * scene.metres_per_pixel for stall in shown])
        is_found = np.zeros(len(shown), np.bool_)
        is_found[match(found, true).true] = True
        is_taken = np.array([stall.taken for stall in shown])
        for taken, before in counts.items():
            stalls, hits = int((is_taken == taken).sum()), int(is_found[is_taken == taken].sum())
            counts[taken] = Count(before.stalls + stalls, before.found + hits)
    return counts


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure by command line."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.perception.marks",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--scenes", type=int, default=SCENES, metavar="N", help=f"of each kind (default {SCENES})")
    parser.add_argument("--model", type=Path, metavar="FILE", help="other weights (default: those that ship)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures here")
    options = parser.parse_args(arguments)
    cv2.setNumThreads(1)
    eye = NetworkEye(StallNetwork.load(options.model))
    figures: dict[str, float] = {}
    print("| stalls parted by | lot | free: recall | taken: recall |", "|---" * 4 + "|", sep="\n")
    for kind in KINDS:
        for fill, occupancy in OCCUPANCIES.items():
            counts = measure(eye, lots(kind, occupancy, options.scenes))
            cells = [f"{counts[taken].recall:.2f} of {counts[taken].stalls}" for taken in (False, True)]
            print(f"| {kind} | {fill} | " + " | ".join(cells) + " |", flush=True)
            for name, taken in (("free", False), ("taken", True)):
                figures[f"marks_{kind}_{fill.replace(' ', '_')}_{name}"] = counts[taken].recall
    if options.json is not None:
        write_json(options.json, figures)
    return 0


def _is_in_sight(scene: Scene, stall: SceneStall) -> bool:
    height, width = scene.image.shape[:2]
    quad, edge = stall.quad, _EDGE_PX
    return bool(((quad > edge) & (quad < (width - edge, height - edge))).all()) and stall.covered < _COVERED


if __name__ == "__main__":
    raise SystemExit(main())
