"""Bands of an orthophoto as a colour picture of 8 bits, and the pixels that show ground."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.picture.values import PictureError
from hawk.runtime.late import late

if TYPE_CHECKING:
    from rasterio import errors, windows
else:
    errors = late("rasterio.errors")
    windows = late("rasterio.windows")

Image = NDArray[np.uint8]
Mask = NDArray[np.bool_]
_PERCENTILES: Final = (0.5, 99.5)
"""Brightness of a picture of 16 bits that is shown as black and as white."""
_OVERVIEW: Final = 1024
"""Pixels a side of the overview by which brightness is measured."""
_SAMPLES: Final = 8
"""Blocks along each side of a picture without overviews, from which the same is measured."""
_BLOCK: Final = 256
_COLLAR: Final = 16
"""Pixels a side of a square of pure black, or of white from the border, that is taken for missing ground where nothing
else says what is missing.
"""
_RIM, _DARK = 8, 24
"""Pixels around it, and how far from pure their values may be, that compression has left there."""
_WHOLE: Final = 2048
"""Pixels a side of the picture, or of its overview, in which white is followed from the border."""


@dataclass(frozen=True, slots=True)
class Bands:
    """Choice of bands, counted from 1: ``colours`` are red, green and blue, or one grey; ``alpha`` 0: there is none.

    ``levels``: brightness shown as black and as white; None for bytes. ``palette``: BGR of each value (256, 3) of a
    picture with a table of colours. ``has_white``: pure white begins at the picture's border, where no ground is;
    ``white`` (H, W): that white in the whole file at a smaller scale, None where no overview shows it.
    """

    colours: tuple[int, ...]
    alpha: int = 0
    levels: tuple[float, float] | None = None
    palette: tuple[tuple[int, int, int], ...] = field(default=(), repr=False)
    has_white: bool = False
    white: Mask | None = field(default=None, repr=False, compare=False)


@dataclass(frozen=True, slots=True)
class Pixels:
    """Part of a picture: ``image`` (H, W, 3) BGR, ``valid`` (H, W) where it shows ground."""

    image: Image = field(repr=False)
    valid: Mask = field(repr=False)


def bands_of(dataset: Any, name: str) -> Bands:
    """Return the bands that an opened file of rasterio shows.

    Raises PictureError for a file of another kind; ``name`` is the file's.
    """
    kinds = [kind.name for kind in dataset.colorinterp]
    types = set(dataset.dtypes)
    if len(kinds) == 1 and types <= {"float32", "float64", "int16", "int32"}:
        raise PictureError(
            f"{name}: is a model of heights (DSM, DTM; {types.pop()}), no picture; name the orthophoto that was made "
            "with it, as odm_orthophoto.tif"
        )
    if not types <= {"uint8", "uint16"}:
        raise PictureError(
            f"{name}: has pixels of type {', '.join(sorted(types))}, 8 or 16 bits are read; convert it: "
            f"gdal_translate -ot Byte -scale {name} bytes.tif"
        )
    alpha = kinds.index("alpha") + 1 if "alpha" in kinds else 0
    if len(kinds) == 2 and not alpha:
        alpha = 2
    rest = [number for number in range(1, len(kinds) + 1) if number != alpha]
    if {"red", "green", "blue"} <= set(kinds):
        chosen = Bands(tuple(kinds.index(kind) + 1 for kind in ("red", "green", "blue")), alpha)
    elif len(rest) == 1:
        chosen = Bands((rest[0],), alpha, palette=_palette(dataset, rest[0], kinds))
    elif len(rest) in (3, 4):
        chosen = Bands(tuple(rest[:3]), alpha)
    else:
        raise PictureError(
            f"{name}: has {len(kinds)} bands without names of colours; save red, green and blue: "
            f"gdal_translate -b 1 -b 2 -b 3 {name} colours.tif"
        )
    if not chosen.palette and _is_silent(dataset, chosen):
        has_white = _has_white(dataset, chosen)
        chosen = replace(chosen, has_white=has_white, white=_white_of(dataset, chosen) if has_white else None)
    return chosen if types == {"uint8"} else replace(chosen, levels=_levels(dataset, chosen, name))


def _has_white(dataset: Any, bands: Bands) -> bool:
    """Return whether a square of pure white lies at the first or last rows of a file: a border takes one of them in."""
    high = min(_COLLAR, dataset.height)
    for top in (0, dataset.height - high):
        try:
            values = dataset.read(bands.colours, window=windows.Window(0, top, dataset.width, high))
        except errors.RasterioError:  # a part that is cut off: the window that reads it says so
            continue
        white = (values == np.iinfo(values.dtype).max).all(axis=(0, 1))
        edges = np.flatnonzero(np.diff(np.concatenate([[False], white, [False]])))
        if (edges[1::2] - edges[::2] >= min(_COLLAR, dataset.width)).any():
            return True
    return False


def _white_of(dataset: Any, bands: Bands) -> Mask | None:
    """Return which parts (H, W) of a file are white from its border; None where that would cost much."""
    scale = max(1.0, max(dataset.width, dataset.height) / _WHOLE)
    if scale > 2 * max(dataset.overviews(bands.colours[0]), default=1):
        return None
    size = (max(1, round(dataset.height / scale)), max(1, round(dataset.width / scale)))
    try:
        values = dataset.read(bands.colours, out_shape=(len(bands.colours), *size))
    except errors.RasterioError:  # a part that is cut off: the window that reads it says so
        return None
    return _joined(_collar(np.iinfo(values.dtype).max - values, scale), _edges(size, (True,) * 4))


def _palette(dataset: Any, band: int, kinds: list[str]) -> tuple[tuple[int, int, int], ...]:
    if kinds[band - 1] != "palette":
        return ()
    table = dataset.colormap(band)
    return tuple((b, g, r) for r, g, b, _ in (table.get(value, (0, 0, 0, 255)) for value in range(256)))


def _levels(dataset: Any, bands: Bands, name: str) -> tuple[float, float]:
    """Return the brightness to show as black and white, one pair for all colours: their balance stays."""
    is_small = max(dataset.width, dataset.height) <= _SAMPLES * _BLOCK
    parts = []
    if is_small or dataset.overviews(bands.colours[0]):
        scale = max(1.0, max(dataset.width, dataset.height) / _OVERVIEW)
        size = (max(1, round(dataset.height / scale)), max(1, round(dataset.width / scale)))
        parts.append((None, size))
    else:
        for k in range(_SAMPLES**2):
            left, top = (round((at + 0.5) / _SAMPLES * side) for at, side in zip(
                (k % _SAMPLES, k // _SAMPLES), (dataset.width, dataset.height), strict=True
            ))  # fmt: skip
            wide, high = min(_BLOCK, dataset.width - left), min(_BLOCK, dataset.height - top)
            parts.append((windows.Window(left, top, wide, high), (high, wide)))
    values, is_silent = [], _is_silent(dataset, bands)
    for window, size in parts:
        colours = dataset.read(bands.colours, window=window, out_shape=(len(bands.colours), *size))
        valid = valid_pixels(dataset, bands, window, size)
        if bands.has_white:
            valid = valid & ~(colours == np.iinfo(colours.dtype).max).all(axis=0)
        if is_silent:  # a black border is no ground either
            valid = valid & (colours > 0).any(axis=0)
        values.append(colours[:, valid].reshape(-1))
    shown = np.concatenate(values)
    if not len(shown):
        raise PictureError(
            f"{name}: shows no ground: every pixel that was looked at is empty; build "
            f"its overviews (gdaladdo {name}), or export it again"
        )
    low, high = (float(level) for level in np.percentile(shown, _PERCENTILES))
    return low, max(high, low + 1.0)


def read(dataset: Any, bands: Bands, box: tuple[int, int, int, int]) -> Pixels:
    """Return a part of an opened file, in the order of its own rows. Raises rasterio's errors."""
    left, top, right, bottom = box
    window, size = windows.Window(left, top, right - left, bottom - top), (bottom - top, right - left)
    values = dataset.read(bands.colours, window=window)
    valid = valid_pixels(dataset, bands, window, size)
    if _is_silent(dataset, bands) and not bands.palette:
        valid &= ~_collar(values)
        if bands.has_white:
            white = _collar(np.iinfo(values.dtype).max - values)
            valid &= ~_joined(white, _from_border(dataset, bands, box))
    if bands.palette:
        return Pixels(np.array(bands.palette, np.uint8)[np.minimum(values[0], 255)], valid)
    if bands.levels is not None:
        low, high = bands.levels
        values = np.clip((values.astype(np.float32) - low) * (255 / (high - low)) + 0.5, 0, 255).astype(np.uint8)
    order = (0, 0, 0) if len(bands.colours) == 1 else (2, 1, 0)
    return Pixels(np.ascontiguousarray(np.stack([values[k] for k in order], axis=-1)), valid)


def _collar(values: NDArray[Any], scale: float = 1.0) -> Mask:
    """Return where (H, W) bands (B, H, W) are 0 as no ground is: what programs write beside a picture's ground.

    ``scale``: pixels of the picture along a side of each value.
    """
    side, rim = max(1, round(_COLLAR / scale)), round(_RIM / scale)
    black = np.asarray((values == 0).all(axis=0), np.uint8)
    solid = cv2.morphologyEx(black, cv2.MORPH_OPEN, np.ones((side, side), np.uint8))
    if not solid.any():
        return np.zeros(black.shape, np.bool_)
    near = cv2.dilate(solid, np.ones((2 * rim + 1, 2 * rim + 1), np.uint8)) > 0
    return np.asarray((solid > 0) | (near & (values <= _DARK).all(axis=0)))


def _from_border(dataset: Any, bands: Bands, box: tuple[int, int, int, int]) -> Mask:
    """Return where (H, W) white that is seen in a part of a file comes from the file's border.

    Without an overview the border of the part stands for it: white that is cut there may go on to the file's.
    """
    left, top, right, bottom = box
    size = (bottom - top, right - left)
    if bands.white is None:
        return _edges(size, (True,) * 4)
    high, wide = bands.white.shape
    rows = ((np.arange(top, bottom) + 0.5) * (high / dataset.height)).astype(int)
    columns = ((np.arange(left, right) + 0.5) * (wide / dataset.width)).astype(int)
    ends = _edges(size, (top == 0, bottom == dataset.height, left == 0, right == dataset.width))
    return np.asarray(bands.white[np.ix_(rows, columns)] | ends)


def _edges(size: tuple[int, int], chosen: tuple[bool, ...]) -> Mask:
    """Return a mask (H, W) of the first row, the last one, the first column, the last one, as far as chosen."""
    mask = np.zeros(size, np.bool_)
    for is_chosen, edge in zip(chosen, (mask[0], mask[-1], mask[:, 0], mask[:, -1]), strict=True):
        edge[:] |= is_chosen
    return mask


def _joined(mask: Mask, begins: Mask) -> Mask:
    """Return the pieces of a mask (H, W) that hold a place where they may begin: bright roofs, which are ground, do
    not reach the border.
    """
    if not mask.any():
        return mask
    _, labels = cv2.connectedComponents(mask.astype(np.uint8), connectivity=4)
    return mask & np.isin(labels, np.unique(labels[begins & mask]))


def valid_pixels(dataset: Any, bands: Bands, window: Any, size: tuple[int, int]) -> Mask:
    """Return which pixels (H, W) of an opened file show ground, by alpha, mask or the value for none.

    ``window``: the part, None for the whole picture; ``size``: rows and columns of the result.
    """
    if bands.alpha:
        return np.asarray(dataset.read(bands.alpha, window=window, out_shape=size) > 0)
    if _is_silent(dataset, bands):
        return np.ones(size, np.bool_)
    return np.asarray(dataset.dataset_mask(window=window, out_shape=size) > 0)


def _is_silent(dataset: Any, bands: Bands) -> bool:
    """Return True for a file that does not say which pixels show ground."""
    return not bands.alpha and all("all_valid" in [flag.name for flag in flags] for flags in dataset.mask_flag_enums)
