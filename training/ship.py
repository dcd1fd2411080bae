"""Trains the weights that ship, from nothing: ``python -m training.ship --ground DIR --folder DIR --out FILE``.

1. drawn: 34,000 steps on drawn scenes;
2. ground: three times 1,500 steps from there, half of each batch real ground, each with another third of the regions
   left out, and once 3,000 steps with all of them, a third of each batch;
3. the mean of the four (Wortsman et al. 2022, arXiv 2203.05482), its normalisations settled (`training.settle`);
4. the evidence of rows, fitted to what that network says (`training.rows`), for `hawk.algo.rows.evidence.WEIGHTS`.

What a stage has made lies in the folder: the same command goes on where it was ended. On two cores it takes some four
hours (41,500 steps of .34 s); with ``--device cuda --painters 14`` the painters of 31,000 scenes set the pace.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from training import average, rows, settle, train
from training.settings import DEVICES, share_option

Command = Callable[[Sequence[str]], None]

DRAWN_STEPS: Final = 34_000
GROUND_STEPS: Final = 1_500
_GROUND_RATE: Final = 3e-4
_CROP: Final = 320
_FOLDS: Final = 3
_SHARE_OF_ALL: Final = 0.34


@dataclass(frozen=True, slots=True)
class Stage:
    """One command with its arguments. It is done when its ``result`` is there; None: it is repeated."""

    name: str
    command: Command
    arguments: tuple[str, ...]
    result: Path | None = None

    @property
    def is_done(self) -> bool:
        """True when its result lies in the folder."""
        return self.result is not None and self.result.exists()


def stages(options: argparse.Namespace) -> list[Stage]:
    """Return all stages, in order. The names of the regions follow from the folder of real ground."""
    folder: Path = options.folder
    common = ["--crop", str(_CROP), "--device", options.device, "--painters", str(options.painters)]
    drawn = folder / "drawn.onnx"
    first = _training(folder, "drawn", [*common, "--steps", str(options.drawn_steps), "--seed", str(options.seed)])
    ground = ["--ground", str(options.ground), "--start-from", str(drawn), "--teacher", str(drawn)]
    ground += ["--steps", str(options.ground_steps), "--rate", str(_GROUND_RATE), "--textures", str(options.textures)]
    regions = sorted(path.stem for path in options.ground.glob("*.jpg"))
    folds = []
    for number in range(_FOLDS):
        left_out = [word for name in regions[number::_FOLDS] for word in ("--leave-out", name)]
        seed = ["--seed", str(options.seed + 1 + number)]
        folds.append(_training(folder, f"ground-{number}", [*common, *ground, *seed, *left_out]))
    twice = ["--steps", str(2 * options.ground_steps), "--ground-share", str(_SHARE_OF_ALL)]
    every = _training(folder, "ground-all", [*common, *ground, *twice, "--seed", str(options.seed + 1 + _FOLDS)])
    weights = [str(folder / f"{stage.name}.pt") for stage in (*folds, every)]
    mean = folder / "mean.onnx"
    kept = folder / "mean.pt"
    averaged = Stage("mean", average.main, (*weights, "--keep", str(kept), "--out", str(mean)), mean)
    settling = (str(kept), "--ground", str(options.ground), "--teacher", str(drawn), "--seed", str(options.seed))
    settled = Stage("settle", settle.main, (*settling, "--out", str(options.out)), options.out)
    fit = Stage("rows", rows.main, ("--model", str(options.out), "--ground", str(options.ground)))
    return [first, *folds, every, averaged, settled, fit]


def _training(folder: Path, name: str, arguments: Sequence[str]) -> Stage:
    out = folder / f"{name}.onnx"
    files = ("--keep", str(folder / f"{name}.pt"), "--checkpoint", str(folder / f"{name}.checkpoint"))
    return Stage(name, train.main, (*arguments, *files, "--out", str(out)), out)


def run(given: Sequence[Stage]) -> None:
    """Run the stages that are not done."""
    for number, stage in enumerate(given, 1):
        print(f"stage {number} of {len(given)}, {stage.name}: {'done' if stage.is_done else 'begins'}", flush=True)
        if not stage.is_done:
            stage.command(stage.arguments)


def parse(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(prog="python -m training.ship", description=__doc__.split("\n", 1)[0])
    parser.add_argument("--ground", type=_folder, required=True, help="folder of pictures of real ground")
    parser.add_argument("--folder", type=Path, required=True, help="folder for what the stages make")
    parser.add_argument("--out", type=Path, required=True, help="ONNX file to write")
    parser.add_argument("--seed", type=int, default=0, help="seed of everything (default 0)")
    parser.add_argument("--device", choices=DEVICES, default="cpu", help="what learns (default cpu)")
    parser.add_argument("--painters", type=int, default=1, help="processes that draw scenes (default 1)")
    parser.add_argument("--drawn-steps", type=int, default=DRAWN_STEPS, help=f"(default {DRAWN_STEPS})")
    parser.add_argument("--ground-steps", type=int, default=GROUND_STEPS, help=f"each (default {GROUND_STEPS})")
    parser.add_argument(
        "--textures",
        type=share_option,
        default=0.0,
        help="share of the ground stages' drawn scenes with real looks (0)",
    )
    return parser.parse_args(arguments)


def _folder(text: str) -> Path:
    path = Path(text)
    if not any(path.glob("*.jpg")):
        raise argparse.ArgumentTypeError(f"{text} holds no REGION.jpg: name a folder as training/ground.py reads it")
    return path


def main(arguments: Sequence[str] | None = None) -> None:
    """Train by command line."""
    options = parse(arguments)
    options.folder.mkdir(parents=True, exist_ok=True)
    run(stages(options))


if __name__ == "__main__":
    main()
