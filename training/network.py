"""The network that is trained: a small U-Net with its answer at half the picture's resolution."""

from __future__ import annotations

from typing import NamedTuple, TypeVar

import torch
from torch import Tensor, nn
from torch.nn import functional

from hawk.algo.vision.network import CHANNELS, VEHICLE_CHANNELS

Network = TypeVar("Network", bound=nn.Module)
Widths = tuple[int, int, int, int, int]
WIDTHS: Widths = (16, 32, 48, 64, 80)
"""Channels at 1/2, 1/4, 1/8, 1/16 and 1/32 of the picture's resolution."""
EXTRA_CHANNELS = 2
"""Shade and cover, after the channels of the answer."""
EXTRA_MAPS = 8
"""Maps at half the resolution beyond the first of the widths."""
_SUN_HIDDEN = 16
_VEHICLE_WIDTH = 32
_CORE_BIAS = -3.0
"""Log-odds of a vehicle's core before training: a twentieth of the ground (Lin et al. 2017, arXiv 1708.02002)."""


class Features(NamedTuple):
    """Maps of the trunk: at ``half`` and at a ``quarter`` of the picture's resolution, and ``fine``, those at a quarter
    before the network looks at the surroundings.
    """

    half: Tensor
    quarter: Tensor
    fine: Tensor


class StallNet(nn.Module):
    """U-Net (Ronneberger et al. 2015) of 3 x 3 convolutions with batch normalisation; about 560 000 parameters.

    Takes (B, 3, H, W), H and W multiples of 32, and suns (B, 2); gives (B, 23, H/2, W/2) as
    `hawk.algo.vision.network` describes. While training the style of the shallow maps is perturbed.
    """

    def __init__(self, widths: Widths = WIDTHS) -> None:
        super().__init__()
        a, b, c, d, e = widths
        self.down1 = nn.Sequential(_block(3, a, stride=2), _block(a, a))
        self.down2 = nn.Sequential(_block(a, b, stride=2), _block(b, b))
        self.down3 = nn.Sequential(_block(b, c, stride=2), _block(c, c), _block(c, c))
        self.down4 = nn.Sequential(_block(c, d, stride=2), _block(d, d), _block(d, d))
        self.down5 = nn.Sequential(_block(d, e, stride=2), _block(e, e), _block(e, e), _Context(e))
        self.up4 = nn.Sequential(_block(e + d, d, kernel=1), _block(d, d))
        self.up3 = nn.Sequential(_block(d + c, c, kernel=1), _block(c, c))
        self.up2 = nn.Sequential(_block(c + b, b, kernel=1), _block(b, b))
        self.up1 = nn.Sequential(_block(b + a, a + EXTRA_MAPS, kernel=1), _block(a + EXTRA_MAPS, a + EXTRA_MAPS))
        self.answer = nn.Conv2d(a + EXTRA_MAPS, CHANNELS, 1)
        self.further = nn.Conv2d(a + EXTRA_MAPS, EXTRA_CHANNELS, 1)
        self.vehicles = VehicleHead(a + EXTRA_MAPS, b)
        self.lit = nn.ModuleList(_Lit(width) for width in (a, b, c))
        self.perturbed = StylePerturbation()

    def forward(self, picture: Tensor, sun: Tensor) -> Tensor:
        """Return the maps of a batch of pictures under suns (B, 2)."""
        features = self.features(picture, sun)
        half = features.half
        return torch.cat([self.answer(half), self.further(half), self.vehicles(features)], 1)

    def features(self, picture: Tensor, sun: Tensor) -> Features:
        """Return what the heads look at, of a batch of pictures under suns (B, 2)."""
        half = self.lit[0](self.perturbed(self.down1(picture)), sun)
        fine = self.lit[1](self.perturbed(self.down2(half)), sun)
        eighth = self.lit[2](self.down3(fine), sun)
        sixteenth = self.down4(eighth)
        deepest = self.down5(sixteenth)
        sixteenth = self.up4(torch.cat([twice(deepest), sixteenth], 1))
        eighth = self.up3(torch.cat([twice(sixteenth), eighth], 1))
        quarter = self.up2(torch.cat([twice(eighth), fine], 1))
        return Features(self.up1(torch.cat([twice(quarter), half], 1)), quarter, fine)


class VehicleHead(nn.Module):
    """Finds vehicles in the maps of the trunk, at a quarter of the picture's resolution: gaps between cores are three
    cells wide there.
    """

    def __init__(self, half: int, quarter: int) -> None:
        super().__init__()
        self.joined = _block(half + 2 * quarter, _VEHICLE_WIDTH, kernel=1)
        self.about = _block(_VEHICLE_WIDTH, _VEHICLE_WIDTH)
        self.answer = nn.Conv2d(_VEHICLE_WIDTH, VEHICLE_CHANNELS, 1)
        with torch.no_grad():
            torch.as_tensor(self.answer.bias)[0] = _CORE_BIAS

    def forward(self, features: Features) -> Tensor:
        """Return the channels of vehicles (B, 11, H/2, W/2)."""
        return twice(self.coarse(features))

    def coarse(self, features: Features) -> Tensor:
        """Return the channels of vehicles (B, 11, H/4, W/4), of which each cell answers for two by two."""
        near = functional.avg_pool2d(features.half, 2)
        maps = self.joined(torch.cat([near, features.quarter, features.fine], 1))
        return torch.as_tensor(self.answer(self.about(maps)))


class _Lit(nn.Module):
    """Adds to every channel what the sun says: nothing for a sun that is not known, nor before training."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.hidden = nn.Linear(2, _SUN_HIDDEN, bias=False)
        self.out = nn.Linear(_SUN_HIDDEN, width, bias=False)
        nn.init.zeros_(self.out.weight)

    def forward(self, maps: Tensor, sun: Tensor) -> Tensor:
        """Return the maps (B, C, H, W) under suns (B, 2)."""
        return maps + torch.as_tensor(self.out(functional.relu(self.hidden(sun))))[:, :, None, None]


class StylePerturbation(nn.Module):
    """Changes mean and deviation of each channel at random while training.

    Source: Normalization Perturbation (Fan et al. 2022, arXiv 2211.04393).
    They carry a picture's style: the light, the camera, the ground. A network that leans on them is lost elsewhere.
    """

    SHARE = 0.5
    DEVIATION = 0.35

    def forward(self, maps: Tensor) -> Tensor:
        """Return the maps (B, C, H, W); some of the batch's pictures in another style."""
        if not self.training:
            return maps
        mean = maps.mean((2, 3), keepdim=True)
        size = (maps.shape[0], maps.shape[1], 1, 1)
        # drawn on the processor, so that the same seed gives the same on every device
        is_changed = (torch.rand(maps.shape[0], 1, 1, 1) < self.SHARE).to(maps)
        apart, shift = (1 + is_changed * self.DEVIATION * torch.randn(size).to(maps) for _ in range(2))
        return torch.as_tensor(apart * (maps - mean) + shift * mean)


def set_memory_format(network: Network, memory_format: torch.memory_format) -> Network:
    """Set the memory format of the weights (channels last trains faster, export needs contiguous)."""
    for weights in network.parameters():
        if weights.dim() == 4:
            weights.data = weights.data.contiguous(memory_format=memory_format)
    return network


class _Context(nn.Module):
    """Lets the deepest maps look far: residual convolutions of dilation 2 and 4 (Yu and Koltun 2016)."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.near = _block(width, width, dilation=2)
        self.far = _block(width, width, dilation=4)

    def forward(self, maps: Tensor) -> Tensor:
        """Return the maps with their surroundings added."""
        maps = maps + self.near(maps)
        return maps + torch.as_tensor(self.far(maps))


def _block(inside: int, outside: int, stride: int = 1, kernel: int = 3, dilation: int = 1) -> nn.Sequential:
    padding = kernel // 2 * dilation
    return nn.Sequential(
        nn.Conv2d(inside, outside, kernel, stride, padding, dilation, bias=False),
        nn.BatchNorm2d(outside),
        nn.ReLU(inplace=True),
    )


def twice(maps: Tensor) -> Tensor:
    """Return maps at twice their resolution: each cell four times."""
    return functional.interpolate(maps, scale_factor=2.0, mode="nearest")
