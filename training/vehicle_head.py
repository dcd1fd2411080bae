"""Trains the head for vehicles alone: ``python -m training.vehicle_head --ground DIR --folder DIR --steps 700``.

The trunk of an exported network is frozen, so all that it says of stalls stays the same to the bit. One head learns
from every region that has labels by hand, and with ``--folds`` each further one from all but a part of them, by which
it is judged. All look at the same maps of the trunk. Writes ``all.onnx`` and ``fold-0.onnx`` and so on; prints which
regions each left out.
"""

from __future__ import annotations

import argparse
import copy
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from benchmarks.cars.labels import VehicleTruth
from benchmarks.cars.scenes import CarScene, read_regions
from hawk.algo.vision.network import OFFSET_CELLS
from training.augment import Sample, sample
from training.export import export
from training.ground import METRES_PER_PIXEL, WINDOW_PIXELS, cut
from training.loss import vehicle_loss
from training.network import Features, StallNet, VehicleHead, set_memory_format, twice
from training.pool import ScenePool
from training.resume import folded_network
from training.settings import rate
from training.steady import STEADY_SHARE, draw_pair, unsteadiness
from training.targets import LABELS, UNKNOWN, VEHICLE, TrainingScene, VehicleLabels
from training.train import SCENE_OVER_CROP, follow

BATCH: Final = 8
REAL: Final = 5
"""Pictures of a batch that show real ground, the two of the pair among them in every second batch."""
_SIDE: Final = 320
_RATE: Final = 1e-2
_DECAY: Final = 0.998
_REUSE: Final = 16
_FIRST_SCENES: Final = 30
_CAPACITY: Final = 600
_REPORT_STEPS: Final = 50
_NEAR_VEHICLES: Final = 0.7
"""Share of the windows about a labelled vehicle; the others lie anywhere."""
_JITTER_PIXELS: Final = 110.0
_CROWN, _KERB = 4.0, 2.0
"""Weights of windows about a vehicle under branches, and about one along a kerb; 1 about others."""


@dataclass(frozen=True, slots=True)
class VehicleRegion:
    """A picture whose vehicles a person labelled; ``share`` (M,): how often a window lies about each of them."""

    name: str
    scene: TrainingScene = field(repr=False)
    share: NDArray[np.float64] = field(repr=False)

    def window(self, rng: np.random.Generator) -> TrainingScene:
        """Return a random window, most of them about a vehicle."""
        size = np.array(self.scene.image.shape[1::-1])
        about = rng.uniform((0, 0), size)
        if len(self.share) and self.scene.vehicles is not None and rng.random() < _NEAR_VEHICLES:
            quad = self.scene.vehicles.quads[int(rng.choice(len(self.share), p=self.share))]
            about = quad.mean(0) + rng.normal(0, _JITTER_PIXELS, 2)
        left, top = np.clip(about - WINDOW_PIXELS / 2, 0, np.maximum(size - WINDOW_PIXELS, 0)).astype(int).tolist()
        return cut(self.scene, left, top, WINDOW_PIXELS)


def vehicle_region(scene: CarScene) -> VehicleRegion:
    """Return a region of which nothing but the vehicles is known. ``scene`` has pixels of 0.1 m."""
    height, width = ((side - 1) | 1 for side in scene.image.shape[:2])
    truth = scene.truth
    kept = TrainingScene(
        image=scene.image[:height, :width],
        labels=np.full((height, width, LABELS), UNKNOWN, np.uint8),
        quads=np.zeros((0, 4, 2), np.float32),
        taken=np.zeros(0, np.bool_),
        judged=np.zeros(0, np.bool_),
        seen=None if scene.missing is None else (~scene.missing[:height, :width]).astype(np.uint8),
        vehicles=VehicleLabels(
            (truth.corners / METRES_PER_PIXEL - 0.5).astype(np.float32), truth.kind, truth.is_counted
        ),
    )
    return VehicleRegion(scene.name, kept, _shares(truth))


def _shares(truth: VehicleTruth) -> NDArray[np.float64]:
    weight = np.where(np.array(truth.ground, object) == "crown", _CROWN, np.where(truth.is_kerb, _KERB, 1.0))
    return np.asarray(weight / max(weight.sum(), 1.0), np.float64)


@dataclass(frozen=True, slots=True)
class HeadBatch:
    """Pictures (B, 3, H, W), targets, suns (B, 2), the region of each (None: drawn); the last two are a pair that lies
    ``cells`` apart.
    """

    picture: Tensor
    target: Tensor
    sun: Tensor
    regions: tuple[str | None, ...]
    cells: tuple[int, int]


def draw_batch(
    pool: ScenePool, regions: Sequence[VehicleRegion], rng: np.random.Generator, side: int = _SIDE
) -> HeadBatch:
    """Return a batch of drawn scenes and real windows; its pair shows either, by turns of chance."""
    weight = np.sqrt([len(region.share) + 1.0 for region in regions])
    chosen = [regions[int(k)] for k in rng.choice(len(regions), REAL, p=weight / weight.sum())]
    given: list[tuple[str | None, TrainingScene]] = [(region.name, region.window(rng)) for region in chosen]
    drawn = [(None, pool[int(rng.integers(len(pool)))]) for _ in range(BATCH - REAL)]
    given = [*drawn, *given] if rng.random() < 0.5 else [*given, *drawn]
    *singles, (name, last) = given[:-1]  # the pair takes two places
    pair = draw_pair(last, rng, side)
    samples: list[Sample] = [*(sample(scene, rng, side) for _, scene in singles), pair.first, pair.second]
    picture, target, sun = (
        torch.from_numpy(np.stack([getattr(one, part) for one in samples])) for part in ("picture", "target", "sun")
    )
    names = (*(each for each, _ in singles), name, name)
    return HeadBatch(picture.contiguous(memory_format=torch.channels_last), target, sun, names, pair.cells)


@dataclass(slots=True)
class Pupil:
    """A head that learns from all regions but those ``left_out``; ``mean`` is the running mean of its weights."""

    name: str
    left_out: frozenset[str]
    head: VehicleHead
    mean: VehicleHead
    optimiser: torch.optim.AdamW

    @classmethod
    def of(cls, name: str, left_out: Sequence[str], head: VehicleHead) -> Pupil:
        """Return a pupil that begins with a copy of the weights of ``head``."""
        own = set_memory_format(copy.deepcopy(head), torch.channels_last).train()
        return cls(
            name,
            frozenset(left_out),
            own,
            copy.deepcopy(own),
            torch.optim.AdamW(own.parameters(), _RATE, weight_decay=1e-4),
        )

    def learn(self, features: Features, batch: HeadBatch, share: float, step: int) -> float:
        """Take one step from the pictures of a batch that are not left out; return the loss."""
        kept = torch.tensor([name not in self.left_out for name in batch.regions])
        if int(kept.sum()) < 2:
            return 0.0
        for group in self.optimiser.param_groups:
            group["lr"] = _RATE * rate(step, share)
        with torch.autocast("cpu", torch.bfloat16):
            answer = self.head.coarse(Features(*(maps[kept] for maps in features))).float()
        total = vehicle_loss(answer, coarse_target(batch.target[kept]))
        if bool(kept[-1]):
            total = total + STEADY_SHARE * unsteadiness(twice(answer[-2:, :1]), batch.cells, (0,))
        self.optimiser.zero_grad()
        torch.autograd.backward(total)
        torch.nn.utils.clip_grad_norm_(self.head.parameters(), 5.0)
        self.optimiser.step()
        follow(self.mean, self.head, min(_DECAY, (1 + step) / (10 + step)))
        return float(total.detach())


def coarse_target(target: Tensor) -> Tensor:
    """Return targets (B, 30, h/2, w/2) of cells that answer for two by two: offsets are those from their middle."""
    coarse = target[:, :, ::2, ::2].clone()
    coarse[:, VEHICLE + 3 : VEHICLE + 5] -= 0.5 / OFFSET_CELLS
    return coarse


def pupils_of(head: VehicleHead, names: Sequence[str], folds: int) -> list[Pupil]:
    """Return the one that leaves out nothing and one for each fold of the regions."""
    parts = [names[number::folds] for number in range(folds)] if folds > 1 else []
    return [Pupil.of("all", (), head), *(Pupil.of(f"fold-{k}", part, head) for k, part in enumerate(parts))]


def train(
    trunk: StallNet, pupils: Sequence[Pupil], pool: ScenePool, regions: Sequence[VehicleRegion], steps: int, seed: int
) -> None:
    """Let the pupils learn from what the trunk, which stays as it is, makes of the same pictures."""
    trunk = set_memory_format(trunk, torch.channels_last).eval()
    rng = np.random.default_rng((seed, 6))
    sums = np.zeros(len(pupils))
    for step in range(steps):
        pool.take_until(_FIRST_SCENES + step * (BATCH - REAL) // _REUSE)
        batch = draw_batch(pool, regions, rng)
        with torch.no_grad(), torch.autocast("cpu", torch.bfloat16):
            features = trunk.features(batch.picture, batch.sun)
        sums += [pupil.learn(features, batch, (step + 1) / steps, step) for pupil in pupils]
        if (step + 1) % _REPORT_STEPS == 0:
            words = " ".join(
                f"{pupil.name} {value:.3f}" for pupil, value in zip(pupils, sums / _REPORT_STEPS, strict=True)
            )
            print(f"step {step + 1} scenes {pool.drawn} {words}", flush=True)
            sums[:] = 0


def main(arguments: Sequence[str] | None = None) -> None:
    """Train by command line."""
    parser = argparse.ArgumentParser(prog="python -m training.vehicle_head", description=__doc__.split("\n", 1)[0])
    parser.add_argument("--ground", type=Path, required=True, help="folder of the regions that benchmarks.cars labels")
    parser.add_argument("--model", type=Path, required=True, help="exported network (.onnx) whose trunk is kept")
    parser.add_argument("--folder", type=Path, required=True, help="folder for all.onnx and fold-K.onnx")
    parser.add_argument(
        "--folds", type=int, default=3, help="parts of the regions, each left out by a head (default 3)"
    )
    parser.add_argument("--steps", type=int, default=700, help="steps of eight pictures (default 700)")
    parser.add_argument("--seed", type=int, default=0, help="seed of scenes, weights and samples (default 0)")
    options = parser.parse_args(arguments)
    torch.set_num_threads(1)
    torch.manual_seed(options.seed)
    network = folded_network(options.model)
    regions = [vehicle_region(scene) for scene in read_regions(options.ground)]
    if not regions:
        parser.error(
            f"argument --ground: no region of {options.ground} has vehicles labelled in benchmarks/cars/labels"
        )
    pupils = pupils_of(network.vehicles, [region.name for region in regions], options.folds)
    for pupil in pupils:
        print(f"{pupil.name}: without {', '.join(sorted(pupil.left_out)) or 'none'}", flush=True)
    pool = ScenePool(options.seed, _CAPACITY, 1, round(_SIDE * SCENE_OVER_CROP))
    try:
        train(network, pupils, pool, regions, options.steps, options.seed)
    finally:
        pool.close()
    for pupil in pupils:
        network.vehicles = pupil.mean
        out = options.folder / f"{pupil.name}.onnx"
        print(f"{out}: differs from torch by {export(network, out):.1g}", flush=True)


if __name__ == "__main__":
    main()
