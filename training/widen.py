"""Widens a trained network: the wider one gives the same answer, and has more channels to learn with.

``python -m training.widen NARROW.onnx --widths A,B,C,D,E --seed 4 --out WIDE.onnx`` writes what a training with
``--start-from NARROW.onnx`` of those widths and that seed begins with.

Source: Net2Net (Chen, Goodfellow and Shlens 2016, arXiv 1511.05641), but new channels begin at random in place of
copies of old ones, and what the old ones take of them begins at zero.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path

import torch
from torch import Tensor, nn

from training.export import export
from training.network import EXTRA_MAPS, StallNet, Widths
from training.resume import folded_network
from training.settings import widths_option

Segments = list[tuple[int, int]]
"""Channels that were joined to one input: how many the narrow network has of each part, and the wide one."""


class WidenError(ValueError):
    """The networks do not fit; the text says where."""


def widths_of_state(state: Mapping[str, Tensor]) -> Widths:
    """Return the channels at 1/2, 1/4, 1/8, 1/16 and 1/32 of the picture's resolution, of a network's weights."""
    a, b, c, d, e = (int(state[f"down{level}.0.0.weight"].shape[0]) for level in (1, 2, 3, 4, 5))
    return a, b, c, d, e


def widen(narrow: StallNet, wide: StallNet) -> None:
    """Give ``wide``, whose new channels keep their random weights, the answer of ``narrow``.

    Raises WidenError when ``wide`` has fewer channels anywhere.
    """
    before, after = widths_of_state(narrow.state_dict()), widths_of_state(wide.state_dict())
    if any(old > new for old, new in zip(before, after, strict=True)):
        raise WidenError(f"widths: {after} has fewer channels than {before}, the widths of the weights to start from")
    joined = _joined(before, after)
    with torch.no_grad():
        for (name, old), (_, new) in zip(narrow.named_modules(), wide.named_modules(), strict=True):
            if isinstance(old, nn.Conv2d) and isinstance(new, nn.Conv2d):
                _widen_convolution(old, new, joined.get(name, [(old.in_channels, new.in_channels)]))
            elif isinstance(old, nn.BatchNorm2d) and isinstance(new, nn.BatchNorm2d):
                for kept, value in zip(_of_norm(new), _of_norm(old), strict=True):
                    kept[: len(value)] = value
            elif isinstance(old, nn.Linear) and isinstance(new, nn.Linear):
                new.weight[: old.out_features] = old.weight


def _joined(before: Widths, after: Widths) -> dict[str, Segments]:
    """Return the parts of each input that joins the level below with the one beside it."""
    pairs = list(zip(before, after, strict=True))
    joined = {f"up{level}.0.0": [pairs[level], pairs[level - 1]] for level in (4, 3, 2, 1)}
    half = before[0] + EXTRA_MAPS, after[0] + EXTRA_MAPS
    return {**joined, "vehicles.joined.0": [half, pairs[1], pairs[1]]}


def _widen_convolution(old: nn.Conv2d, new: nn.Conv2d, segments: Segments) -> None:
    rows = old.out_channels
    new.weight[:rows] = 0.0
    from_old = from_new = 0
    for narrow, wide in segments:
        new.weight[:rows, from_new : from_new + narrow] = old.weight[:, from_old : from_old + narrow]
        from_old, from_new = from_old + narrow, from_new + wide
    if old.bias is not None and new.bias is not None:
        new.bias[:rows] = old.bias


def _of_norm(norm: nn.BatchNorm2d) -> list[Tensor]:
    kept = [norm.weight, norm.bias, norm.running_mean, norm.running_var]
    return [value for value in kept if value is not None]


def main(arguments: Sequence[str] | None = None) -> None:
    """Widen by command line."""
    parser = argparse.ArgumentParser(prog="python -m training.widen", description=__doc__)
    parser.add_argument("narrow", type=Path, help="exported network (.onnx)")
    parser.add_argument(
        "--widths", type=widths_option, required=True, metavar="A,B,C,D,E", help="channels of the wide one"
    )
    parser.add_argument(
        "--seed", type=int, default=0, help="seed of the new channels, as that of the training (default 0)"
    )
    parser.add_argument("--out", type=Path, required=True, help="ONNX file to write")
    options = parser.parse_args(arguments)
    torch.manual_seed(options.seed)
    wide = StallNet(options.widths)
    try:
        widen(folded_network(options.narrow), wide)
    except WidenError as error:
        parser.error(f"argument --widths: {error}")
    print(f"{options.out}: differs from torch by {export(wide.eval(), options.out):.1g}", flush=True)


if __name__ == "__main__":
    main()
