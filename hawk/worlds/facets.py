"""Flat pictures that stand or lie at a height, and how they are laid over a picture of the ground."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.worlds.canvas import Bytes, Points, as_bytes

_OPAQUE = 127


@dataclass(frozen=True, slots=True, eq=False)
class HeightLayer:
    """A flat picture above the ground: a car's body or roof, a slice of a crown, a roof or a wall.

    ``corners`` are (4, 3) metres (x east, y south, z up): where the picture's upper left, upper right, lower right and
    lower left corners are; they span a parallelogram. ``pixels`` is BGRA uint8. ``label`` is car, tree, roof, wall or
    post.
    """

    corners: Points
    pixels: Bytes
    label: str

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
class Laid:
    """One layer as it appears in a picture: where, its colours and where it is opaque (255)."""

    rows: slice
    columns: slice
    colour: Bytes
    opaque: Bytes
    label: str


class FacetSet:
    """Height layers made ready to be seen from anywhere, lowest first."""

    def __init__(self, layers: Sequence[HeightLayer]) -> None:
        ordered = sorted(layers, key=lambda layer: layer.height)
        self.labels = [layer.label for layer in ordered]
        self._pictures = [_levels(layer.pixels) for layer in ordered]
        self._corners = np.ones((len(ordered), 4, 4))
        self._to_world = np.zeros((len(ordered), 4, 3))
        for k, layer in enumerate(ordered):
            self._corners[k, :, :3] = layer.corners
            self._to_world[k] = _texel_to_world(layer)

    def __len__(self) -> int:
        return len(self.labels)

    def seen(self, projection: NDArray[np.float64], width: int, height: int) -> Iterator[Laid]:
        """Yield the layers that appear in a picture of that size.

        ``projection`` is 3 x 4: homogeneous world metres to homogeneous pixels (pixel centres are whole numbers); what
        has no positive third component lies behind the camera and is left out.
        """
        if not self.labels:
            return
        image = self._corners @ projection.T
        ahead = (image[..., 2] > 1e-6).all(1)
        pixels = image[..., :2] / np.where(image[..., 2:] > 1e-6, image[..., 2:], 1.0)
        low = np.floor(pixels.min(1)).astype(int)
        high = np.ceil(pixels.max(1)).astype(int) + 1
        inside = (high[:, 0] > 0) & (high[:, 1] > 0) & (low[:, 0] < width) & (low[:, 1] < height)
        forward = projection @ self._to_world
        for k in np.nonzero(ahead & inside)[0]:
            laid = self._lay(int(k), forward[k], pixels[k], (low[k], high[k]), (width, height))
            if laid is not None:
                yield laid

    def _lay(
        self,
        k: int,
        forward: NDArray[np.float64],
        pixels: NDArray[np.float64],
        box: tuple[NDArray[np.int64], NDArray[np.int64]],
        size: tuple[int, int],
    ) -> Laid | None:
        x0, y0 = max(0, int(box[0][0])), max(0, int(box[0][1]))
        x1, y1 = min(size[0], int(box[1][0])), min(size[1], int(box[1][1]))
        if x1 - x0 < 1 or y1 - y0 < 1 or abs(_area(pixels)) < 1.0:
            return None
        picture, scale = self._level(k, pixels)
        inverse = np.linalg.inv(forward)
        inverse = scale @ inverse @ np.array([[1.0, 0, x0], [0, 1.0, y0], [0, 0, 1.0]])
        warped = cv2.warpPerspective(
            picture, inverse, (x1 - x0, y1 - y0), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        )
        opaque = cv2.threshold(cv2.extractChannel(warped, 3), _OPAQUE, 255, cv2.THRESH_BINARY)[1]
        colour = cv2.cvtColor(warped, cv2.COLOR_BGRA2BGR)
        return Laid(slice(y0, y1), slice(x0, x1), as_bytes(colour), as_bytes(opaque), self.labels[k])

    def _level(self, k: int, pixels: NDArray[np.float64]) -> tuple[Bytes, NDArray[np.float64]]:
        """Pick the resolution that comes nearest to the picture's."""
        levels = self._pictures[k]
        rows, columns = levels[0].shape[:2]
        per_pixel = np.sqrt(rows * columns / max(1.0, abs(_area(pixels))))
        number = 0 if per_pixel < 1.5 else (1 if per_pixel < 3 else 2)
        number = min(number, len(levels) - 1)
        sy, sx = levels[number].shape[0] / rows, levels[number].shape[1] / columns
        # texel centres lie at half numbers of the texture's own grid
        scale = np.array([[sx, 0, 0.5 * sx - 0.5], [0, sy, 0.5 * sy - 0.5], [0, 0, 1.0]])
        return levels[number], scale


def lay_all(image: Bytes, facets: FacetSet, projection: NDArray[np.float64]) -> None:
    """Lay every visible layer over ``image`` (BGR uint8) in place."""
    for laid in facets.seen(projection, image.shape[1], image.shape[0]):
        cv2.copyTo(laid.colour, laid.opaque, image[laid.rows, laid.columns])


def ground_projection(
    origin: tuple[float, float], metres_per_pixel: float, viewer: tuple[float, float, float] | None = None
) -> NDArray[np.float64]:
    """Return the 3 x 4 projection onto a picture of the ground (upper left corner at ``origin``, north up).

    ``viewer`` (x, y, height) is where it is seen from: a thing at height z then leans away from the viewer as in a
    frame that was rectified to the ground plane; None looks from straight above everywhere.
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
    pixels: Bytes, centre: tuple[float, float], heading: float, size: tuple[float, float], height: float, label: str
) -> HeightLayer:
    """Return a layer that lies flat; ``size`` is metres along the heading and across it."""
    ahead = np.array([np.cos(heading), np.sin(heading)]) * size[0] / 2
    aside = np.array([-np.sin(heading), np.cos(heading)]) * size[1] / 2
    middle = np.array(centre)
    ground = np.array([middle - ahead - aside, middle + ahead - aside, middle + ahead + aside, middle - ahead + aside])
    return HeightLayer(np.column_stack([ground, np.full(4, height)]), pixels, label)


def _levels(pixels: Bytes) -> tuple[Bytes, ...]:
    """Return the picture and up to two halvings of it."""
    levels = [np.ascontiguousarray(pixels)]
    while len(levels) < 3 and min(levels[-1].shape[:2]) >= 8:
        rows, columns = levels[-1].shape[:2]
        half = cv2.resize(levels[-1], ((columns + 1) // 2, (rows + 1) // 2), interpolation=cv2.INTER_AREA)
        levels.append(as_bytes(half))
    return tuple(levels)


def _texel_to_world(layer: HeightLayer) -> NDArray[np.float64]:
    """Return 4 x 3: homogeneous texel (column, row, 1) to homogeneous world metres."""
    rows, columns = layer.pixels.shape[:2]
    right = (layer.corners[1] - layer.corners[0]) / columns
    down = (layer.corners[3] - layer.corners[0]) / rows
    start = layer.corners[0] + (right + down) / 2
    return np.vstack([np.column_stack([right, down, start]), [0, 0, 1]])


def _area(quad: NDArray[np.float64]) -> float:
    """Signed area of a quadrilateral (N, 2)."""
    x, y = quad[:, 0], quad[:, 1]
    return float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2
