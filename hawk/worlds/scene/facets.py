"""Flat pictures at a height, and how they are drawn over a picture of the ground."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.worlds.scene.canvas import Bytes, Points, as_bytes

_OPAQUE = 127
_LEVEL_LIMITS = (1.5, 3.0)  # texels to a pixel from which on a halved picture is taken


@dataclass(frozen=True, slots=True, eq=False)
class HeightLayer:
    """A flat picture above the ground: a car's body or roof, a slice of a crown, a roof or a wall.

    ``corners`` are (4, 3) metres (x east, y south, z up): where the picture's upper left, upper right, lower right and
    lower left corners are; they span a parallelogram. ``pixels`` is BGRA uint8. ``label`` is car, tree, roof, wall or
    post. ``fine`` layers may be left out of a picture from afar.
    """

    corners: Points
    pixels: Bytes
    label: str
    fine: bool = False

    @property
    def height(self) -> float:
        """The highest corner, metres."""
        return float(self.corners[:, 2].max())

    @property
    def box(self) -> tuple[float, float, float, float]:
        """Bounding box on the ground: x0, y0, x1, y1 in metres."""
        (x0, y0), (x1, y1) = self.corners[:, :2].min(0), self.corners[:, :2].max(0)
        return float(x0), float(y0), float(x1), float(y1)


@dataclass(frozen=True, slots=True)
class VisibleLayer:
    """One layer in a picture: its warped picture (BGRA) and the mask (255) of its opaque part, at (row, column)."""

    label: str
    colour: Bytes
    opaque: Bytes
    row: int
    column: int

    def paint(self, image: Bytes) -> None:
        """Draw it over a BGRA picture."""
        cv2.copyTo(self.colour, self.opaque, image[self._window])

    def mark(self, mask: Bytes, value: int) -> None:
        """Set a mask where it is opaque."""
        mask[self._window][self.opaque > 0] = value

    @property
    def _window(self) -> tuple[slice, slice]:
        rows, columns = self.opaque.shape
        return slice(self.row, self.row + rows), slice(self.column, self.column + columns)


@dataclass(frozen=True, slots=True)
class VisiblePlain:
    """The same for a layer of one colour, which is a polygon: walls have large bounding boxes and little to show."""

    label: str
    colour: tuple[float, ...]
    quad: NDArray[np.int32]

    def paint(self, image: Bytes) -> None:
        """Draw it over a BGRA picture."""
        cv2.fillConvexPoly(image, self.quad, self.colour, shift=4)

    def mark(self, mask: Bytes, value: int) -> None:
        """Set a mask where it is."""
        cv2.fillConvexPoly(mask, self.quad, float(value), shift=4)


class FacetSet:
    """Height layers made ready to be seen from anywhere, lowest first."""

    def __init__(self, layers: Sequence[HeightLayer]) -> None:
        ordered = sorted(layers, key=lambda layer: layer.height)
        self.labels = [layer.label for layer in ordered]
        self._pictures = [_levels(layer.pixels) for layer in ordered]
        self._last_level = np.array([len(picture) - 1 for picture in self._pictures], np.int64)
        self._scales = np.array([_level_scales(picture) for picture in self._pictures]).reshape(-1, 3, 3, 3)
        self._texels = np.array([layer.pixels.shape[0] * layer.pixels.shape[1] for layer in ordered], float)
        self._fine = np.array([layer.fine for layer in ordered], bool)
        self._area_m2 = np.array([_areas(layer.corners[None, :, :2])[0] for layer in ordered])
        self._corners = np.ones((len(ordered), 4, 4))
        self._to_world = np.zeros((len(ordered), 4, 3))
        for k, layer in enumerate(ordered):
            self._corners[k, :, :3] = layer.corners
            self._to_world[k] = _texel_to_world(layer)

    def __len__(self) -> int:
        return len(self.labels)

    def seen(
        self, projection: NDArray[np.float64], width: int, height: int, *, fine_from: float = 0.0
    ) -> Iterator[VisibleLayer | VisiblePlain]:
        """Yield the layers that appear in a picture of that size.

        ``projection`` is 3 x 4: homogeneous world metres to homogeneous pixels (pixel centres are whole numbers).
        Layers behind the camera (third component not positive) are left out, and fine layers where a metre has fewer
        than ``fine_from`` pixels.
        """
        if not self.labels:
            return
        image = self._corners @ projection.T
        ahead = (image[..., 2] > 1e-6).all(1)
        pixels = image[..., :2] / np.where(image[..., 2:] > 1e-6, image[..., 2:], 1.0)
        low = np.maximum(np.floor(pixels.min(1)), 0).astype(int)
        high = np.minimum(np.ceil(pixels.max(1)) + 1, (width, height)).astype(int)
        area = _areas(pixels)
        coarse = self._fine & (area < self._area_m2 * fine_from**2)
        shown = np.nonzero(ahead & (high > low).all(1) & (area >= 1.0) & ~coarse)[0]
        level = np.digitize(np.sqrt(self._texels[shown] / area[shown]), _LEVEL_LIMITS)
        level = np.minimum(level, self._last_level[shown])
        to_texels = self._scales[shown, level] @ np.linalg.inv(projection @ self._to_world[shown])
        # the picture of one layer starts at its own upper left corner
        to_texels[:, :, 2] += np.einsum("nij,nj->ni", to_texels[:, :, :2], low[shown].astype(float))
        for k, number, inverse in zip(shown.tolist(), level.tolist(), to_texels, strict=True):
            picture = self._pictures[k][number]
            if picture.shape[:2] == (1, 1):
                yield self._outlined(k, pixels[k])
            else:
                yield self._warped(k, picture, inverse, low[k].tolist(), high[k].tolist())

    def _warped(
        self, k: int, picture: Bytes, to_texel: NDArray[np.float64], low: list[int], high: list[int]
    ) -> VisibleLayer:
        size = (high[0] - low[0], high[1] - low[1])
        warped = cv2.warpPerspective(picture, to_texel, size, flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP)
        opaque = cv2.threshold(cv2.extractChannel(warped, 3), _OPAQUE, 255, cv2.THRESH_BINARY)[1]
        return VisibleLayer(self.labels[k], as_bytes(warped), as_bytes(opaque), low[1], low[0])

    def _outlined(self, k: int, quad: NDArray[np.float64]) -> VisiblePlain:
        fixed = np.round(np.clip(quad, -30000, 30000) * 16).astype(np.int32)
        return VisiblePlain(self.labels[k], tuple(map(float, self._pictures[k][0][0, 0])), fixed)


def draw_layers(image: Bytes, facets: FacetSet, projection: NDArray[np.float64], *, fine_from: float = 0.0) -> None:
    """Draw every visible layer over ``image`` (BGRA uint8) in place; ``fine_from`` as in `FacetSet.seen`."""
    for layer in facets.seen(projection, image.shape[1], image.shape[0], fine_from=fine_from):
        layer.paint(image)


def ground_projection(
    origin: tuple[float, float], metres_per_pixel: float, viewer: tuple[float, float, float] | None = None
) -> NDArray[np.float64]:
    """Return the 3 x 4 projection onto a picture of the ground (upper left corner at ``origin``, north up).

    Seen from a ``viewer`` (x, y, height; metres), a thing at height z leans away from it as in a frame that was
    rectified to the ground plane; None looks from straight above everywhere.
    """
    x0, y0 = origin
    to_px = np.array(
        [
            [1 / metres_per_pixel, 0, -x0 / metres_per_pixel - 0.5],
            [0, 1 / metres_per_pixel, -y0 / metres_per_pixel - 0.5],
            [0, 0, 1.0],
        ]
    )
    if viewer is None:
        return np.asarray(to_px @ np.array([[1.0, 0, 0, 0], [0, 1.0, 0, 0], [0, 0, 0, 1.0]]))
    x, y, height = viewer
    return np.asarray(to_px @ np.array([[height, 0, -x, 0], [0, height, -y, 0], [0, 0, -1.0, height]]))


def flat_layer(
    pixels: Bytes,
    centre: tuple[float, float],
    heading: float,
    size: tuple[float, float],
    height: float,
    label: str,
    *,
    fine: bool = False,
) -> HeightLayer:
    """Return a horizontal layer; ``size`` is metres along the heading and across it."""
    ahead = np.array([np.cos(heading), np.sin(heading)]) * size[0] / 2
    aside = np.array([-np.sin(heading), np.cos(heading)]) * size[1] / 2
    middle = np.array(centre)
    ground = np.array([middle - ahead - aside, middle + ahead - aside, middle + ahead + aside, middle - ahead + aside])
    return HeightLayer(np.column_stack([ground, np.full(4, height)]), pixels, label, fine)


def _levels(pixels: Bytes) -> tuple[Bytes, ...]:
    """Return the picture and up to two halvings of it."""
    levels = [np.ascontiguousarray(pixels)]
    while len(levels) < 3 and min(levels[-1].shape[:2]) >= 8:
        rows, columns = levels[-1].shape[:2]
        half = cv2.resize(levels[-1], ((columns + 1) // 2, (rows + 1) // 2), interpolation=cv2.INTER_AREA)
        levels.append(as_bytes(half))
    if pixels.shape[:2] == (1, 1):
        return tuple(levels)
    return tuple(with_rim(level) for level in levels)


def with_rim(picture: Bytes) -> Bytes:
    """Return a BGRA picture with a transparent rim of one pixel.

    The rim has the colours beside it: the black beyond would otherwise darken samples at the edge.
    """
    rimmed = as_bytes(cv2.copyMakeBorder(picture, 1, 1, 1, 1, cv2.BORDER_REPLICATE))
    for edge in (rimmed[0], rimmed[-1], rimmed[:, 0], rimmed[:, -1]):
        edge[..., 3] = 0
    return rimmed


def _texel_to_world(layer: HeightLayer) -> NDArray[np.float64]:
    """Return 4 x 3: homogeneous texel (column, row, 1) to homogeneous world metres."""
    rows, columns = layer.pixels.shape[:2]
    right = (layer.corners[1] - layer.corners[0]) / columns
    down = (layer.corners[3] - layer.corners[0]) / rows
    start = layer.corners[0] + (right + down) / 2
    return np.vstack([np.column_stack([right, down, start]), [0, 0, 1]])


def _level_scales(levels: Sequence[Bytes]) -> NDArray[np.float64]:
    """Return (3, 3, 3): for each of three levels, texels of the finest without its rim to its own with it.

    Texel centres are whole numbers.
    """
    scales = np.zeros((3, 3, 3))
    rows, columns = levels[0].shape[0] - 2, levels[0].shape[1] - 2
    for k, picture in enumerate([*levels, *[levels[-1]] * 2][:3]):
        sy, sx = (picture.shape[0] - 2) / rows, (picture.shape[1] - 2) / columns
        scales[k] = [[sx, 0, 0.5 * sx + 0.5], [0, sy, 0.5 * sy + 0.5], [0, 0, 1.0]]
    return scales


def _areas(quads: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the areas (N,) of quadrilaterals (N, 4, 2), from their diagonals."""
    first, second = quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1]
    return np.asarray(np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / 2)
