"""Settles the mean of several trainings: ``python -m training.settle MEAN.pt --ground DIR --out FILE.onnx``.

Batch normalisations of a mean hold the mean of statistics, not the statistics of the mean. They are measured again, on
drawn scenes and real ground as the trainings saw them (Izmailov et al. 2018, arXiv 1803.05407, section 3.3).
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Sequence
from pathlib import Path

import torch
from torch import Tensor, nn

from hawk.algo.vision.network import StallNetwork
from training.export import export
from training.ground import read_ground
from training.network import StallNet
from training.pool import ScenePool
from training.settings import TrainingPlan
from training.train import SCENE_OVER_CROP, batches
from training.widen import widths_of_state

_BATCHES = 160
_SCENES = 100
_CROP = 320


@torch.no_grad()
def settle(network: StallNet, pictures: Iterable[tuple[Tensor, Tensor]]) -> StallNet:
    """Measure the statistics of all batch normalisations on pictures (B, 3, H, W) and suns (B, 2), in place."""
    for module in network.modules():
        if isinstance(module, nn.BatchNorm2d):
            module.reset_running_stats()
            module.momentum = None  # the plain mean of all batches
    network.train()
    for picture, sun in pictures:
        network(picture, sun)
    return network.eval()


def main(arguments: Sequence[str] | None = None) -> None:
    """Settle by command line."""
    parser = argparse.ArgumentParser(prog="python -m training.settle", description=__doc__.split("\n", 1)[0])
    parser.add_argument("weights", type=Path, help="torch weights (.pt), as training.average --keep writes them")
    parser.add_argument("--ground", type=Path, required=True, help="folder of pictures of real ground")
    parser.add_argument("--teacher", type=Path, help="network (.onnx) that labels real ground; the package's without")
    parser.add_argument("--seed", type=int, default=0, help="seed of scenes and samples (default 0)")
    parser.add_argument("--batches", type=int, default=_BATCHES, help=f"of six pictures (default {_BATCHES})")
    parser.add_argument("--out", type=Path, required=True, help="ONNX file to write")
    options = parser.parse_args(arguments)
    state = torch.load(options.weights, map_location="cpu", weights_only=True)
    network = StallNet(widths_of_state(state))
    network.load_state_dict(state)
    plan = TrainingPlan(minutes=1, seed=options.seed, side=_CROP)
    torch.manual_seed(plan.seed)
    ground = read_ground(options.ground, StallNetwork.load(options.teacher), (), plan.seed)
    pool = ScenePool(plan.seed, plan.capacity, plan.painters, round(plan.side * SCENE_OVER_CROP))
    try:
        pool.take_until(_SCENES)
        given = batches(pool, plan, ground, options.batches)
        settled = settle(network, ((batch.picture, batch.sun) for batch in given))
    finally:
        pool.close()
    print(f"{options.out}: differs from torch by {export(settled, options.out):.1g}", flush=True)


if __name__ == "__main__":
    main()
