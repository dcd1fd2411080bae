"""Progress of a training on disk, so that it goes on after it was ended."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import torch
from torch import Tensor
from torch.optim import Optimizer

from training.network import StallNet

State = dict[str, Tensor]


@dataclass(slots=True)
class Progress:
    """Steps and seconds of training so far, scenes drawn, and the states taken for the mean."""

    step: int = 0
    seconds: float = 0.0
    drawn: int = 0
    states: list[State] = field(default_factory=list)


class CheckpointError(ValueError):
    """The file is no checkpoint of this training; the text says why."""


class CheckpointFile:
    """One file that always holds a whole checkpoint."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def save(self, progress: Progress, network: StallNet, mean: StallNet, optimiser: Optimizer) -> None:
        """Write the progress with the weights, their running mean and the optimiser's state."""
        content = {
            "step": progress.step,
            "seconds": progress.seconds,
            "drawn": progress.drawn,
            "states": progress.states,
            "network": network.state_dict(),
            "mean": mean.state_dict(),
            "optimiser": optimiser.state_dict(),
        }
        unfinished = self._path.with_suffix(".unfinished")
        torch.save(content, unfinished)
        os.replace(unfinished, self._path)

    def restore(self, network: StallNet, mean: StallNet, optimiser: Optimizer) -> Progress:
        """Fill in what was saved; return its progress, none where there is no file.

        Raises CheckpointError for the checkpoint of another network.
        """
        if not self._path.exists():
            return Progress()
        content: dict[str, Any] = torch.load(self._path, map_location="cpu", weights_only=True)
        try:
            network.load_state_dict(content["network"])
            mean.load_state_dict(content["mean"])
        except (KeyError, RuntimeError) as error:
            raise CheckpointError(f"{self._path}: the checkpoint of another network; name another file") from error
        optimiser.load_state_dict(content["optimiser"])
        return Progress(content["step"], content["seconds"], content["drawn"], content["states"])

    def drawn(self) -> int:
        """Return the number of scenes that the saved training has drawn."""
        return int(torch.load(self._path, weights_only=True)["drawn"]) if self._path.exists() else 0
