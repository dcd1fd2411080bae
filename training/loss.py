"""Loss of the network's answers."""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn.functional import binary_cross_entropy_with_logits, cross_entropy

from hawk.algo.vision.network import VEHICLE_KINDS
from training.targets import (
    CAR,
    CAR_WEIGHT,
    CORE,
    CORE_WEIGHT,
    COVER,
    COVER_WEIGHT,
    KINDS,
    LENGTH,
    LOT,
    PLACE_WEIGHT,
    SHADE,
    SHADE_WEIGHT,
    SINE,
    TAKEN,
    TAKEN_WEIGHT,
    VEHICLE,
    VEHICLE_WEIGHT,
)

_DICE_PIXELS = 50.0
_SHADE_SHARE = 0.3
_KIND_SHARE = 0.1
_CAR_IN_SHADE = 3.0
"""Factor on the cost of a car that is only a shadow."""


def loss(answer: Tensor, target: Tensor) -> tuple[Tensor, dict[str, float]]:
    """Return the loss of a batch, answers (B, 23, h, w) against targets (B, 30, h, w), and its parts by name."""
    place, judged, cars = target[:, PLACE_WEIGHT], target[:, CORE_WEIGHT], target[:, CAR_WEIGHT]
    shade = target[:, SHADE]
    weights = torch.stack([place, judged, cars * (1 + (_CAR_IN_SHADE - 1) * shade)], 1)
    truth, said = target[:, LOT : CAR + 1], answer[:, LOT : CAR + 1]
    crossed = (binary_cross_entropy_with_logits(said, truth, reduction="none") * weights).mean()
    counted = torch.stack([place, judged, cars], 1)
    dice = _dice(torch.sigmoid(said) * counted, truth * counted)
    dark = (
        binary_cross_entropy_with_logits(answer[:, SHADE], shade, reduction="none") * target[:, SHADE_WEIGHT]
    ).mean()
    core = (target[:, CORE] * judged).unsqueeze(1)
    mass = core.sum() + _DICE_PIXELS
    apart = (answer[:, SINE : LENGTH + 1] - target[:, SINE : LENGTH + 1]).abs()
    geometry = (apart * core).sum((0, 2, 3)) / mass
    taken = binary_cross_entropy_with_logits(answer[:, TAKEN], target[:, TAKEN], reduction="none")
    states = core[:, 0] * target[:, TAKEN_WEIGHT]
    taken = (taken * states).sum() / (states.sum() + _DICE_PIXELS)
    total = crossed + 0.25 * dice[0] + 0.25 * (dice[1] + dice[2]) + 0.25 * geometry.sum() + 0.4 * taken
    hidden = binary_cross_entropy_with_logits(answer[:, COVER], target[:, COVER], reduction="none")
    hidden = (hidden * target[:, COVER_WEIGHT]).mean()
    total = total + _SHADE_SHARE * (dark + hidden)
    vehicles = vehicle_loss(answer[:, VEHICLE:], target)
    total = total + vehicles
    parts = {
        "bce": crossed,
        "lot": dice[0],
        "core": dice[1],
        "car": dice[2],
        "geometry": geometry.sum(),
        "taken": taken,
        "shade": dark,
        "cover": hidden,
        "vehicles": vehicles,
    }
    return total, {name: float(part.detach()) for name, part in parts.items()}


def vehicle_loss(answer: Tensor, target: Tensor) -> Tensor:
    """Return the loss of core, shape and kind of vehicles, answers (B, 11, h, w) against targets (B, 30, h, w), over
    the ground on which they are known.
    """
    known, truth, said = target[:, VEHICLE_WEIGHT], target[:, VEHICLE], answer[:, 0]
    crossed = (binary_cross_entropy_with_logits(said, truth, reduction="none") * known).mean()
    dice = _dice((torch.sigmoid(said) * known).unsqueeze(1), (truth * known).unsqueeze(1))[0]
    core = (truth * known).unsqueeze(1)
    mass = core.sum() + _DICE_PIXELS
    geometry = ((answer[:, 1 : -len(VEHICLE_KINDS)] - target[:, VEHICLE + 1 : KINDS]).abs() * core).sum() / mass
    kinds = cross_entropy(answer[:, -len(VEHICLE_KINDS) :], target[:, KINDS:PLACE_WEIGHT], reduction="none").unsqueeze(
        1
    )
    return crossed + 0.25 * dice + 0.25 * geometry + _KIND_SHARE * (kinds * core).sum() / mass


def _dice(said: Tensor, truth: Tensor) -> Tensor:
    """Return one minus the Dice coefficient of each channel, (3,)."""
    shared = (said * truth).sum((0, 2, 3))
    return 1 - (2 * shared + _DICE_PIXELS) / (said.sum((0, 2, 3)) + truth.sum((0, 2, 3)) + _DICE_PIXELS)
