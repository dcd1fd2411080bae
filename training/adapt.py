"""Trains on from an owner's corrected lots: ``python -m training.adapt DIR --out FILE.onnx``.

``DIR`` is what ``hawk-drone export LOT --training DIR`` wrote. Half of each batch are windows of the earlier flights,
half drawn scenes; the weights begin as those that ship. The result is written only where it is better on the owner's
later flights and no worse on drawn worlds; where the whole change is refused, half of it is tried (Wortsman et al.
2022, arXiv 2109.01903). Otherwise nothing is written, and the exit status is 1.

``--halves PLACES``: labelled places in place of flights: one half of each teaches, the other one judges. It writes DIR.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import cv2

from benchmarks.figures import Section, print_and_write
from benchmarks.options import folder_option, seeds_option
from benchmarks.perception.places import read_lots
from hawk.algo.vision.network import StallNetwork
from hawk.algo.vision.network_file import packaged_weights
from training.lessons import DRAWN_SEEDS, LessonError, Split, figures, halves, judge, refusal, split
from training.settings import DEVICES, computes_bfloat16

STEPS: Final = 500
RATE: Final = 3e-4
CROP: Final = 320
_REFUSED: Final = 1
_USAGE: Final = 2


def main(arguments: Sequence[str] | None = None) -> int:
    """Train on by command line; return the exit status."""
    options = _parser().parse_args(arguments)
    try:
        return adapt(options)
    except (LessonError, OSError) as error:
        print(f"training.adapt: {error}", file=sys.stderr)
        return _USAGE


def adapt(options: argparse.Namespace) -> int:
    """Train, judge, and write the weights that are taken. Raises LessonError, OSError."""
    cv2.setNumThreads(1)
    if options.halves is not None:
        halves(options.halves, options.folder)
    parts = split(options.folder)
    places = [place for place in read_lots(options.folder) if place.name in parts.judged]
    print(f"{len(parts.learnt)} pictures teach, {len(parts.judged)} of later flights judge", flush=True)
    before = judge(StallNetwork.load(options.model), places, options.drawn)
    with tempfile.TemporaryDirectory() as text:
        folder = Path(text)
        base = folder / "base.onnx"
        base.write_bytes(packaged_weights() if options.model is None else options.model.read_bytes())
        for name, make in (("whole step", _train), ("half of it", _half)):
            made = make(options, parts, base, folder)
            after = judge(StallNetwork.load(made), places, options.drawn)
            print_and_write([Section(name, figures(before, after))], options.json)
            reason = refusal(before, after)
            if not reason:
                options.out.write_bytes(made.read_bytes())
                print(f"{options.out}: taken. Fly with it: vision.model in the settings names the file")
                return 0
            print(f"{name}: refused, {reason}", flush=True)
    print("nothing is written: the weights of before stay")
    return _REFUSED


def _train(options: argparse.Namespace, parts: Split, base: Path, folder: Path) -> Path:
    from training import train  # torch: seconds

    out = folder / "whole.onnx"
    words = ["--ground", str(options.folder), "--start-from", str(base), "--steps", str(options.steps)]
    words += ["--rate", str(RATE), "--crop", str(CROP), "--seed", str(options.seed), "--device", options.device]
    words += [word for name in parts.judged for word in ("--leave-out", name)]
    words += [] if options.device != "cpu" or computes_bfloat16() else ["--float32"]
    train.main([*words, "--out", str(out)])
    return out


def _half(options: argparse.Namespace, parts: Split, base: Path, folder: Path) -> Path:
    del options, parts
    from training import average

    out = folder / "half.onnx"
    average.main([str(base), str(folder / "whole.onnx"), "--out", str(out)])
    return out


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m training.adapt", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, metavar="DIR", help="what hawk-drone export LOT --training DIR wrote")
    parser.add_argument("--out", type=Path, required=True, help="ONNX file to write")
    parser.add_argument("--model", type=Path, help="network (.onnx) to go on from; the package's without")
    parser.add_argument("--steps", type=int, default=STEPS, help=f"of six pictures (default {STEPS})")
    parser.add_argument("--seed", type=int, default=0, help="seed of scenes and samples (default 0)")
    parser.add_argument("--device", choices=DEVICES, default="cpu", help="what learns (default cpu)")
    parser.add_argument("--drawn", type=seeds_option, default=DRAWN_SEEDS, help="seeds of the drawn worlds that judge")
    parser.add_argument("--halves", type=folder_option, metavar="PLACES", help="labelled places to write DIR from")
    parser.add_argument("--json", type=Path, help="write the figures here")
    return parser


if __name__ == "__main__":
    sys.exit(main())
