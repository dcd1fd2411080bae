"""Averages weights of one training: ``python -m training.average A.pt B.pt ... --out FILE.onnx``.

Distant states of one training average to weights that often do better on new pictures than the last
state alone (Izmailov et al. 2018), which has settled on what the renderer draws. So do the weights from which a
training started and those at which it ended (Wortsman et al. 2022, arXiv 2109.01903): name both exported networks,
``A.onnx B.onnx``.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import torch
from torch import Tensor

from training.export import export
from training.network import StallNet
from training.resume import folded_network
from training.widen import widths_of_state

State = dict[str, Tensor]


def average(states: Sequence[State]) -> State:
    """Return the mean of every weight. Raises ValueError for no states and for those of different networks."""
    if not states:
        raise ValueError("average: name at least one file of weights")
    shapes = [{name: value.shape for name, value in state.items()} for state in states]
    if any(other != shapes[0] for other in shapes[1:]):
        raise ValueError("average: the files hold different networks; name states of one training")
    return {
        name: torch.stack([state[name].double() for state in states]).mean(0).to(first.dtype)
        for name, first in states[0].items()
    }


def main(arguments: Sequence[str] | None = None) -> None:
    """Average by command line."""
    parser = argparse.ArgumentParser(prog="python -m training.average", description=__doc__)
    parser.add_argument(
        "weights",
        nargs="+",
        type=Path,
        help="torch weights (.pt) as training.train --keep writes them, or networks (.onnx)",
    )
    parser.add_argument("--keep", type=Path, help="also write torch's weights here")
    parser.add_argument("--out", type=Path, required=True, help="ONNX file to write")
    options = parser.parse_args(arguments)
    if len({path.suffix == ".onnx" for path in options.weights}) > 1:
        parser.error("argument weights: name torch weights (.pt) or exported networks (.onnx), not both")
    state = average([_state(path) for path in options.weights])
    if options.keep:
        torch.save(state, options.keep)
    network = StallNet(widths_of_state(state))
    network.load_state_dict(state)
    print(f"{options.out}: differs from torch by {export(network, options.out):.1g}", flush=True)


def _state(path: Path) -> State:
    if path.suffix != ".onnx":
        state: State = torch.load(path, map_location="cpu", weights_only=True)
        return state
    return dict(folded_network(path).state_dict())


if __name__ == "__main__":
    main()
