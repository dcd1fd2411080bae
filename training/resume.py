"""Loads an exported network to train it further: unfolds the batch normalisations of an ONNX file.

Export folds each batch normalisation into its convolution. Here the convolution keeps the folded weights, and the
normalisation gets the mean and deviation that the convolution really gives on some pictures, with scale and shift that
undo it: in use the network is the exported one exactly, and while training nearly so.
"""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

import numpy as np
import onnx
import torch
from onnx import numpy_helper
from torch import Tensor, nn

from training.network import StallNet, Widths

Module = TypeVar("Module", bound=nn.Module)

_FIRST_OF_LEVEL = (0, 2, 4, 7, 10)
"""The first convolution of each level on the path down, among all."""


class ResumeError(ValueError):
    """The file holds another network; the text names the difference."""


def load_onnx(network: StallNet, path: Path, pictures: Tensor) -> None:
    """Give ``network`` the weights of an exported one; ``pictures`` (B, 3, H, W) show it what to expect.

    Raises ResumeError when the file holds another network.
    """
    shifts = load_folded(network, path)
    norms = list(shifts)
    with torch.no_grad():
        found = _outputs(network, norms, pictures)
        for norm, (mean, variance) in zip(norms, found, strict=True):
            _undo(norm, mean, variance, shifts[norm])


def folded_network(path: Path) -> StallNet:
    """Return a network that answers as an exported one (`load_folded`). Raises ResumeError when it is none."""
    network = StallNet(widths_of_onnx(path))
    load_folded(network, path)
    return network


def load_folded(network: StallNet, path: Path) -> dict[nn.BatchNorm2d, Tensor]:
    """Give ``network`` the answer of an exported one: each normalisation only adds what is returned for it.

    Raises ResumeError when the file holds another network.
    """
    folded = _convolutions(path)
    modules = _of_type(network, nn.Conv2d)
    for younger in (network.vehicles, network.further):
        if len(folded) < len(modules):  # an older file
            modules = modules[: -len(_of_type(younger, nn.Conv2d))]
    shapes = [tuple(module.weight.shape) for module in modules]
    if [weight.shape for weight, _ in folded] != shapes:
        raise ResumeError(f"{path}: its convolutions are not those of this network; train from the beginning")
    norms = iter(_of_type(network, nn.BatchNorm2d))  # one follows each convolution without a bias
    shifts = {
        next(norms): torch.from_numpy(bias)
        for module, (_, bias) in zip(modules, folded, strict=True)
        if module.bias is None
    }
    network.eval()
    with torch.no_grad():
        for module, (weight, bias) in zip(modules, folded, strict=True):
            module.weight.copy_(torch.from_numpy(weight))
            if module.bias is not None:
                module.bias.copy_(torch.from_numpy(bias))
        for lit, weight in zip((m for m in network.modules() if isinstance(m, nn.Linear)), _linear(path), strict=False):
            lit.weight.copy_(weight)
        for norm, shift in shifts.items():
            _undo(norm, torch.zeros_like(shift), torch.ones_like(shift), shift)
    return shifts


def _of_type(network: nn.Module, kind: type[Module]) -> list[Module]:
    return [module for module in network.modules() if isinstance(module, kind)]


def widths_of_onnx(path: Path) -> Widths:
    """Return the channels at 1/2 to 1/32 of the resolution of an exported network. Raises ResumeError for another."""
    channels = [weight.shape[0] for weight, _ in _convolutions(path)]
    if len(channels) <= _FIRST_OF_LEVEL[-1]:
        raise ResumeError(f"{path}: its convolutions are not those of this network; train from the beginning")
    a, b, c, d, e = (int(channels[first]) for first in _FIRST_OF_LEVEL)
    return a, b, c, d, e


def _convolutions(path: Path) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return weight and bias of every convolution of the file, in the order in which they are run."""
    graph = onnx.load(str(path)).graph
    values = _values(graph)
    return [(values[node.input[1]], values[node.input[2]]) for node in graph.node if node.op_type == "Conv"]


def _linear(path: Path) -> list[Tensor]:
    """Return the weights by which the sun is taken in, in the order in which they are used; none of an older file."""
    graph = onnx.load(str(path)).graph
    values = _values(graph)
    return [torch.from_numpy(values[node.input[1]].T.copy()) for node in graph.node if node.op_type == "MatMul"]


def _values(graph: onnx.GraphProto) -> dict[str, np.ndarray]:
    """Return the weights of a graph by name; those that are alike are kept once, and have further names."""
    values = {one.name: numpy_helper.to_array(one).copy() for one in graph.initializer}
    for node in graph.node:
        if node.op_type == "Identity" and node.input[0] in values:
            values[node.output[0]] = values[node.input[0]]
    return values


def _undo(norm: nn.BatchNorm2d, mean: Tensor, variance: Tensor, shift: Tensor) -> None:
    """Make a normalisation add ``shift`` and nothing else, for inputs of this mean and variance."""
    for kept, value in ((norm.running_mean, mean), (norm.running_var, variance)):
        if kept is not None:
            kept.copy_(value)
    norm.weight.copy_(torch.sqrt(variance + norm.eps))
    norm.bias.copy_(mean + shift)


def _outputs(network: StallNet, norms: list[nn.BatchNorm2d], pictures: Tensor) -> list[tuple[Tensor, Tensor]]:
    """Return mean and variance of what goes into every normalisation."""
    found: dict[nn.Module, tuple[Tensor, Tensor]] = {}

    def look(module: nn.Module, inputs: tuple[Tensor, ...]) -> None:
        found[module] = inputs[0].mean((0, 2, 3)), inputs[0].var((0, 2, 3))

    hooks = [norm.register_forward_pre_hook(look) for norm in norms]
    network(pictures, torch.zeros(len(pictures), 2))
    for hook in hooks:
        hook.remove()
    return [found[norm] for norm in norms]
