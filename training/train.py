"""Trains the network and writes it as ONNX: ``python -m training.train --steps 34000 --crop 320 --seed 0 --out FILE``.

With ``--steps`` the same seed gives the same weights on the same kind of machine: every scene comes at its step. With
``--minutes`` it ends in time, and how far it comes depends on the machine. What is written is the mean of some states
from the second half of the training: the last one alone has settled on what the renderer draws.
"""

from __future__ import annotations

import argparse
import copy
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from training.augment import sample
from training.average import State, average
from training.export import export
from training.loss import loss
from training.network import StallNet, lay_out
from training.pool import ScenePool
from training.resume import load_onnx

_WARM_UP_STEPS = 50
_TAKEN_AT_ONCE = 4
_SCENE_OVER_CROP = 1.5
_CALIBRATION_BATCHES = 8


@dataclass(frozen=True, slots=True)
class Plan:
    """How to train: ``steps`` steps, or for ``minutes`` where that is None.

    ``side`` is the crop's in pixels; ``first_scenes`` are drawn before the first step, and later ones so that each is
    used about ``reuse`` times. ``averaged`` are the shares (0..1] of the training at which the states are taken whose
    mean is the answer.
    """

    minutes: float
    seed: int
    steps: int | None = None
    batch: int = 6
    side: int = 256
    rate: float = 2e-3
    decay: float = 0.998
    capacity: int = 8000
    first_scenes: int = 60
    reuse: int = 8
    report_steps: int = 100
    threads: int = 1
    painters: int = 1
    bfloat16: bool = True
    averaged: tuple[float, ...] = (0.5, 0.75, 1.0)


def train(
    plan: Plan,
    network: StallNet,
    pool: ScenePool,
    keep: Callable[[StallNet], None] = lambda _: None,
    clock: Callable[[], float] = time.monotonic,
) -> StallNet:
    """Train as planned and return the mean of some states of the running mean of the weights (EMA), which ``keep`` gets
    now and then.

    The scenes follow from the seed. Without steps, how many fit into the time depends on the machine.
    """
    rng = np.random.default_rng((plan.seed, 1))
    network = lay_out(network, torch.channels_last).train()
    mean, states = copy.deepcopy(network), list[State]()
    optimiser = torch.optim.AdamW(network.parameters(), plan.rate, weight_decay=1e-4)
    pool.take_until(plan.first_scenes)
    start, step, share = clock(), 0, 0.0
    while share < 1:
        share = (clock() - start) / (60 * plan.minutes) if plan.steps is None else (step + 1) / plan.steps
        for group in optimiser.param_groups:
            group["lr"] = plan.rate * _rate(step, share)
        if plan.steps is not None:
            pool.take_until(step * plan.batch // plan.reuse)
        elif pool.drawn * plan.reuse < step * plan.batch:
            pool.take(_TAKEN_AT_ONCE)
        picture, target = _batch(pool, rng, plan)
        with torch.autocast("cpu", torch.bfloat16, enabled=plan.bfloat16):
            answer = network(picture)
        total, parts = loss(answer.float(), target)
        optimiser.zero_grad()
        torch.autograd.backward(total)
        torch.nn.utils.clip_grad_norm_(network.parameters(), 5.0)
        optimiser.step()
        step += 1
        _follow(mean, network, min(plan.decay, (1 + step) / (10 + step)))
        if len(states) < len(plan.averaged) and share >= plan.averaged[len(states)]:
            states.append(copy.deepcopy(mean.state_dict()))
        if step % plan.report_steps == 0:
            words = " ".join(f"{name} {value:.3f}" for name, value in parts.items())
            keep(mean)
            print(f"step {step} {clock() - start:.0f} s scenes {pool.drawn} {words}", flush=True)
    print(f"trained {step} steps of {plan.batch} on {pool.drawn} scenes", flush=True)
    mean.load_state_dict(average(states))
    return mean.eval()


def main(arguments: Sequence[str] | None = None) -> None:
    """Train by command line."""
    options = _parse(arguments)
    plan = Plan(
        minutes=options.minutes,
        seed=options.seed,
        steps=options.steps,
        batch=options.batch,
        side=options.crop,
        rate=options.rate,
        threads=options.threads,
        painters=options.painters,
        bfloat16=not options.float32,
    )
    torch.set_num_threads(plan.threads)
    torch.manual_seed(plan.seed)
    network = StallNet()
    print(f"{sum(p.numel() for p in network.parameters())} parameters", flush=True)

    def keep(weights: StallNet) -> None:
        if options.keep:
            torch.save(weights.state_dict(), options.keep)

    pool = ScenePool(plan.seed, plan.capacity, plan.painters, round(plan.side * _SCENE_OVER_CROP))
    try:
        if options.start_from:
            _start_from(network, options.start_from, pool, plan)
        trained = train(plan, network, pool, keep)
    finally:
        pool.close()
    keep(trained)
    print(f"{options.out}: differs from torch by {export(trained, options.out):.1g}", flush=True)


def _start_from(network: StallNet, path: Path, pool: ScenePool, plan: Plan) -> None:
    """Take up torch's weights, or those of an exported network."""
    if path.suffix != ".onnx":
        network.load_state_dict(torch.load(path, weights_only=True))
        return
    pool.take_until(plan.first_scenes)
    rng = np.random.default_rng((plan.seed, 2))
    pictures = torch.cat([_batch(pool, rng, plan)[0] for _ in range(_CALIBRATION_BATCHES)])
    load_onnx(network, path, pictures)


def _parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m training.train", description=__doc__)
    length = parser.add_mutually_exclusive_group()
    length.add_argument("--minutes", type=float, default=60.0, help="time to train, minutes (default 60)")
    length.add_argument("--steps", type=int, help="steps to train instead: the same seed gives the same weights")
    parser.add_argument("--out", type=Path, required=True, help="ONNX file to write")
    parser.add_argument("--seed", type=int, default=0, help="seed of scenes, weights and samples (default 0)")
    parser.add_argument("--threads", type=int, default=1, help="threads of torch (default 1)")
    parser.add_argument("--painters", type=int, default=1, help="processes that draw scenes (default 1)")
    parser.add_argument("--crop", type=int, default=256, help="side of a training picture, pixels (default 256)")
    parser.add_argument("--batch", type=int, default=6, help="pictures a step (default 6)")
    parser.add_argument("--rate", type=float, default=2e-3, help="learning rate (default 0.002)")
    parser.add_argument("--float32", action="store_true", help="no bfloat16: slower, for processors without it")
    parser.add_argument("--keep", type=Path, help="also write torch's weights here")
    parser.add_argument(
        "--start-from", type=Path, help="torch weights (.pt) or an exported network (.onnx) to go on from"
    )
    return parser.parse_args(arguments)


def _rate(step: int, share: float) -> float:
    """Warm up, then a half cosine down to a hundredth (Loshchilov and Hutter 2017)."""
    return min(1.0, step / _WARM_UP_STEPS + 0.05) * (0.5 * (1 + math.cos(math.pi * min(share, 1.0))) + 0.01)


def _batch(pool: ScenePool, rng: np.random.Generator, plan: Plan) -> tuple[Tensor, Tensor]:
    samples = [sample(pool[int(rng.integers(len(pool)))], rng, plan.side) for _ in range(plan.batch)]
    picture = torch.from_numpy(np.stack([s[0] for s in samples])).contiguous(memory_format=torch.channels_last)
    return picture, torch.from_numpy(np.stack([s[1] for s in samples]))


@torch.no_grad()
def _follow(mean: StallNet, network: StallNet, decay: float) -> None:
    """Move the running mean a little towards the network."""
    for kept, new in zip(mean.state_dict().values(), network.state_dict().values(), strict=True):
        if kept.dtype.is_floating_point:
            kept.mul_(decay).add_(new, alpha=1 - decay)
        else:
            kept.copy_(new)


if __name__ == "__main__":
    main()
