"""Settings of a training: its plan, its command line and its schedule. Needs no torch."""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

_DESCRIPTION = "Train the network on drawn scenes and write it as ONNX."
DEVICES = ("cpu", "cuda")
_WARM_UP_STEPS = 50
_LEVELS = 5


@dataclass(frozen=True, slots=True)
class TrainingPlan:
    """Settings of a training: ``steps`` steps, or ``minutes`` minutes where that is None.

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
    ground_share: float = 0.5
    """Share of each batch from real ground, where there is any."""
    device: str = "cpu"
    """Torch's name of the device that learns: ``cpu``, or ``cuda`` for a GPU."""


def parse(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    """Read the command line of ``python -m training.train``."""
    parser = argparse.ArgumentParser(prog="python -m training.train", description=_DESCRIPTION)
    length = parser.add_mutually_exclusive_group()
    length.add_argument("--minutes", type=_above_zero, default=60.0, help="time to train, minutes (default 60)")
    length.add_argument("--steps", type=_count, help="steps to train instead: the same seed gives the same weights")
    parser.add_argument("--out", type=Path, required=True, help="ONNX file to write")
    parser.add_argument("--seed", type=int, default=0, help="seed of scenes, weights and samples (default 0)")
    parser.add_argument("--threads", type=_count, default=1, help="threads of torch (default 1)")
    parser.add_argument("--painters", type=_count, default=1, help="processes that draw scenes (default 1)")
    parser.add_argument(
        "--crop", type=_crop, default=256, help="side of a training picture, pixels, a multiple of 32 (default 256)"
    )
    parser.add_argument(
        "--widths",
        type=widths_option,
        metavar="A,B,C,D,E",
        help="channels at 1/2 to 1/32 of the resolution (default 16,32,48,64,80); --start-from may have fewer",
    )
    parser.add_argument("--batch", type=_count, default=6, help="pictures a step (default 6)")
    parser.add_argument("--rate", type=_above_zero, default=2e-3, help="learning rate (default 0.002)")
    parser.add_argument("--float32", action="store_true", help="no bfloat16: slower, for processors without it")
    parser.add_argument("--device", choices=DEVICES, default="cpu", help="what learns (default cpu)")
    parser.add_argument("--keep", type=Path, help="also write torch's weights here")
    parser.add_argument("--checkpoint", type=Path, help="keep the progress here, and go on from it")
    parser.add_argument(
        "--ground", type=Path, help="folder of pictures of real ground (training.ground); without it, drawn"
    )
    parser.add_argument(
        "--ground-share",
        type=share_option,
        default=0.5,
        help="share of each batch from real ground, 0 to 1 (default 0.5)",
    )
    parser.add_argument(
        "--textures",
        type=share_option,
        default=0.0,
        metavar="SHARE",
        help="share of the drawn scenes with ground, leaves and cars cut from --ground, 0 to 1 (default 0)",
    )
    parser.add_argument(
        "--leave-out", action="append", default=[], metavar="PATTERN", help="names of real pictures not to train on"
    )
    parser.add_argument("--teacher", type=Path, help="network (.onnx) that labels real ground; the package's without")
    parser.add_argument(
        "--start-from", type=Path, help="torch weights (.pt) or an exported network (.onnx) to go on from"
    )
    options = parser.parse_args(arguments)
    if options.textures and options.ground is None:
        parser.error("--textures needs --ground, the folder to cut them from")
    return options


def computes_bfloat16(cpuinfo: Path = Path("/proc/cpuinfo")) -> bool:
    """Return whether this processor has instructions for bfloat16; without them a step takes ten times as long.

    Linux names them ``avx512_bf16``, ``amx_bf16`` and, on ARM, ``bf16``. False where there is no such file.
    """
    try:
        words = set(cpuinfo.read_text().split())
    except OSError:
        return False
    return bool(words & {"avx512_bf16", "amx_bf16", "bf16"})


def _above_zero(text: str) -> float:
    value = float(text)
    if not 0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"must be a number above 0, not {text!r}")
    return value


def share_option(text: str) -> float:
    """Return a share that a command line names. Raises ArgumentTypeError, which argparse prints."""
    value = float(text)
    if not 0 <= value <= 1:
        raise argparse.ArgumentTypeError(f"must be from 0 to 1, not {text!r}")
    return value


def _count(text: str) -> int:
    if not text.isdigit() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"must be a whole number from 1, not {text!r}")
    return int(text)


def widths_option(text: str) -> tuple[int, ...]:
    """Return the channels of a network that a command line names. Raises ArgumentTypeError, which argparse prints."""
    widths = tuple(_count(part) for part in text.split(","))
    if len(widths) != _LEVELS:
        raise argparse.ArgumentTypeError(f"must be {_LEVELS} whole numbers with commas, not {text!r}")
    return widths


def _crop(text: str) -> int:
    side = _count(text)
    if side % 32:
        raise argparse.ArgumentTypeError(f"must be a multiple of 32, not {side}")
    return side


def plan_of(options: argparse.Namespace) -> TrainingPlan:
    """Return the plan of a command line."""
    return TrainingPlan(
        minutes=options.minutes,
        seed=options.seed,
        steps=options.steps,
        batch=options.batch,
        side=options.crop,
        rate=options.rate,
        threads=options.threads,
        painters=options.painters,
        bfloat16=not options.float32,
        ground_share=options.ground_share,
        device=options.device,
    )


def rate(step: int, share: float) -> float:
    """Return the share of the full rate: a warm-up, then a half cosine to a hundredth (Loshchilov and Hutter 2017)."""
    return min(1.0, step / _WARM_UP_STEPS + 0.05) * (0.5 * (1 + math.cos(math.pi * min(share, 1.0))) + 0.01)
