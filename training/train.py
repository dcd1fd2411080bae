"""Trains the network and writes it as ONNX: ``python -m training.train --steps 34000 --crop 320 --seed 0 --out FILE``.

With ``--steps`` the same seed gives the same weights on the same kind of machine: every scene comes at its step. With
``--minutes`` it ends in time, and the number of steps depends on the machine. The result is the mean of some states
from the second half of the training: the last one alone is fitted too closely to the renderer. With ``--checkpoint
FILE`` the same command goes on where it was ended; it draws new scenes then.
"""

from __future__ import annotations

import argparse
import copy
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn

from hawk.algo.vision.network import StallNetwork
from training.augment import sample
from training.average import average
from training.checkpoint import CheckpointFile, Progress
from training.export import export
from training.ground import Ground, read_ground
from training.looks import Dress
from training.loss import loss
from training.network import WIDTHS, StallNet, set_memory_format
from training.pool import ScenePool
from training.resume import load_onnx, widths_of_onnx
from training.settings import TrainingPlan, parse, plan_of, rate
from training.steady import STEADY_SHARE, draw_pair, unsteadiness
from training.textures import cut_textures
from training.widen import widen, widths_of_state


@dataclass(frozen=True, slots=True)
class Batch:
    """Pictures (B, 3, H, W), targets and suns (B, 2). ``cells``: the last two pictures are a `training.steady.Pair`."""

    picture: Tensor
    target: Tensor
    sun: Tensor
    cells: tuple[int, int]


_TAKEN_AT_ONCE = 4
SCENE_OVER_CROP = 1.5
_CALIBRATION_BATCHES = 8


def train(
    plan: TrainingPlan,
    network: StallNet,
    pool: ScenePool,
    keep: Callable[[StallNet], None] = lambda _: None,
    clock: Callable[[], float] = time.monotonic,
    checkpoint: CheckpointFile | None = None,
    ground: Ground | None = None,
) -> StallNet:
    """Train as planned.

    Args:
        plan: the settings; the scenes follow from its seed.
        network: the network to train, in place.
        pool: the scenes.
        keep: gets the running mean of the weights (EMA) at every report.
        clock: seconds; decides the end where the plan has no steps.
        checkpoint: where the training begins, if it holds anything; written at every report.
        ground: real ground, from which a part of each batch is taken.

    Returns:
        The network with the mean of some states of that running mean.
    """
    device = torch.device(plan.device)
    network = set_memory_format(network.to(device), torch.channels_last).train()
    mean = copy.deepcopy(network)
    optimiser = torch.optim.AdamW(network.parameters(), plan.rate, weight_decay=1e-4)
    progress = checkpoint.restore(network, mean, optimiser) if checkpoint else Progress()
    states, step = progress.states, progress.step
    rng = np.random.default_rng((plan.seed, 1, step) if step else (plan.seed, 1))
    pool.take_until(progress.drawn + plan.first_scenes)
    start, share = clock() - progress.seconds, 0.0
    with ThreadPoolExecutor(1) as beside:  # the next batch is made while the network learns from this one
        following = beside.submit(_batch, pool, rng, plan, ground)
        while share < 1:
            share = (clock() - start) / (60 * plan.minutes) if plan.steps is None else (step + 1) / plan.steps
            for group in optimiser.param_groups:
                group["lr"] = plan.rate * rate(step, share)
            batch = following.result()
            if plan.steps is not None:
                pool.take_until(step * plan.batch // plan.reuse)
            elif pool.drawn * plan.reuse < step * plan.batch:
                pool.take(_TAKEN_AT_ONCE)
            following = beside.submit(_batch, pool, rng, plan, ground)
            parts = learn(network, optimiser, batch, bfloat16=plan.bfloat16)
            step += 1
            follow(mean, network, min(plan.decay, (1 + step) / (10 + step)))
            if len(states) < len(plan.averaged) and share >= plan.averaged[len(states)]:
                states.append(copy.deepcopy(mean.state_dict()))
            if step % plan.report_steps == 0:
                words = " ".join(f"{name} {value:.3f}" for name, value in parts.items())
                keep(mean)
                if checkpoint:
                    checkpoint.save(Progress(step, clock() - start, pool.drawn, states), network, mean, optimiser)
                print(f"step {step} {clock() - start:.0f} s scenes {pool.drawn} {words}", flush=True)
    print(f"trained {step} steps of {plan.batch} on {pool.drawn} scenes", flush=True)
    mean.load_state_dict(average(states))
    return mean.eval().cpu()


def main(arguments: Sequence[str] | None = None) -> None:
    """Train by command line."""
    options = parse(arguments)
    plan = plan_of(options)
    torch.set_num_threads(plan.threads)
    torch.manual_seed(plan.seed)
    network = StallNet(options.widths or WIDTHS)
    print(f"{sum(p.numel() for p in network.parameters())} parameters", flush=True)

    def keep(weights: StallNet) -> None:
        if options.keep:
            torch.save(weights.state_dict(), options.keep)

    checkpoint = CheckpointFile(options.checkpoint) if options.checkpoint else None
    drawn = checkpoint.drawn() if checkpoint else 0
    ground = _ground(options)
    side = round(plan.side * SCENE_OVER_CROP)
    dress = _dress(ground, options)
    pool = ScenePool(plan.seed, plan.capacity, plan.painters, side, drawn=drawn, dress=dress)
    try:
        if options.start_from and not drawn:  # a checkpoint holds weights that came from them
            _start_from(network, options.start_from, pool, plan)
        trained = train(plan, network, pool, keep, checkpoint=checkpoint, ground=ground)
    finally:
        pool.close()
    keep(trained)
    print(f"{options.out}: differs from torch by {export(trained, options.out):.1g}", flush=True)


def _ground(options: argparse.Namespace) -> Ground | None:
    """Read the real ground that the command line names."""
    if options.ground is None:
        print("no real ground (--ground): every picture is drawn", flush=True)
        return None
    ground = read_ground(options.ground, StallNetwork.load(options.teacher), options.leave_out, options.seed)
    for region in ground.regions:
        print(f"ground {region.name}: {len(region.scene.quads)} stalls", flush=True)
    return ground


def _dress(ground: Ground | None, options: argparse.Namespace) -> Dress | None:
    """Cut textures where the command line asks for them."""
    if ground is None or not options.textures:
        return None
    textures = cut_textures(ground, np.random.default_rng((options.seed, 5)))
    counts = [f"{name} {len(getattr(textures, name))}" for name in textures.__dataclass_fields__]
    print("textures:", ", ".join(counts), flush=True)
    return Dress(textures, options.textures)


def _start_from(network: StallNet, path: Path, pool: ScenePool, plan: TrainingPlan) -> None:
    """Load torch's weights, or those of an exported network; a wider network gives the same answer as they do."""
    if path.suffix != ".onnx":
        state = torch.load(path, map_location="cpu", weights_only=True)
        given = StallNet(widths_of_state(state))
        given.load_state_dict(state)
    else:
        pool.take_until(plan.first_scenes)
        rng = np.random.default_rng((plan.seed, 2))
        pictures = torch.cat([_batch(pool, rng, plan).picture for _ in range(_CALIBRATION_BATCHES)])
        given = StallNet(widths_of_onnx(path))
        load_onnx(given, path, pictures)
    widen(given, network)


def learn(network: StallNet, optimiser: torch.optim.Optimizer, batch: Batch, *, bfloat16: bool) -> dict[str, float]:
    """Take one step from a batch, on the network's device; return the parts of its loss, and the ``total``."""
    device = network.answer.weight.device
    picture, target, sun = (part.to(device, non_blocking=True) for part in (batch.picture, batch.target, batch.sun))
    with torch.autocast(device.type, torch.bfloat16, enabled=bfloat16):
        answer = network(picture, sun)
    total, parts = loss(answer.float(), target)
    shaken = unsteadiness(answer.float(), batch.cells)
    total = total + STEADY_SHARE * shaken
    optimiser.zero_grad()
    torch.autograd.backward(total)
    torch.nn.utils.clip_grad_norm_(network.parameters(), 5.0)
    optimiser.step()
    return {"total": float(total.detach()), **parts, "shaken": float(shaken.detach())}


def _batch(pool: ScenePool, rng: np.random.Generator, plan: TrainingPlan, ground: Ground | None = None) -> Batch:
    """Return a batch whose last two pictures show one scene, shifted: of real ground where there is any."""
    real = 0 if ground is None else round(plan.batch * plan.ground_share)
    scenes = [pool[int(rng.integers(len(pool)))] for _ in range(plan.batch - real)]
    if ground is not None:
        scenes += [ground.window(rng) for _ in range(real)]
    pair = draw_pair(scenes[-1], rng, plan.side)
    samples = [*(sample(scene, rng, plan.side) for scene in scenes[:-2]), pair.first, pair.second]
    picture, target, sun = (
        torch.from_numpy(np.stack([getattr(s, name) for s in samples])) for name in ("picture", "target", "sun")
    )
    return Batch(picture.contiguous(memory_format=torch.channels_last), target, sun, pair.cells)


def batches(pool: ScenePool, plan: TrainingPlan, ground: Ground | None, count: int) -> Iterator[Batch]:
    """Yield batches as a training takes them."""
    rng = np.random.default_rng((plan.seed, 4))
    for _ in range(count):
        yield _batch(pool, rng, plan, ground)


@torch.no_grad()
def follow(mean: nn.Module, network: nn.Module, decay: float) -> None:
    """Move the running mean of weights a little towards those of a network."""
    for kept, new in zip(mean.state_dict().values(), network.state_dict().values(), strict=True):
        if kept.dtype.is_floating_point:
            kept.mul_(decay).add_(new, alpha=1 - decay)
        else:
            kept.copy_(new)


if __name__ == "__main__":
    main()
