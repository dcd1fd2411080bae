"""The camera's pictures: decodes a JPEG and refuses an unusable one; annotates the picture for the operators.

Symbols do not depend on colour: free stalls have a filled blue outline, taken ones are hatched in orange, unknown ones
are dashed in white.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision import quads
from hawk.algo.vision.detection import Detection, FloatArray
from hawk.algo.vision.rectify import project, scaled_camera
from hawk.formats import image as pictures
from hawk.formats.image import NoImage, read_jpeg
from hawk.model.lot_map import Stall, StallState
from hawk.model.pictures import CameraModel
from hawk.model.poses import MapPose
from hawk.model.sentences import say, words_of

MINIMUM_SIDE = 64
"""Pixels; a smaller picture is refused."""
MAXIMUM_PIXELS = 24_000_000
"""A larger picture is refused before it is decoded: it would hold up the worker."""
_BLACK_MEAN = 4.0

FREE_BGR = (255, 143, 47)
TAKEN_BGR = (26, 122, 255)
TAKEN_HATCH_BGR = (0, 94, 224)
UNKNOWN_BGR = (255, 255, 255)
_DRAWN = (StallState.FREE, StallState.TAKEN, StallState.UNKNOWN)
_FILL = 0.30
_HATCH_STEPS = np.linspace(0.06, 0.94, 6)
_HATCH_LEAN = 0.18
_DASHES = 7
_FIXED_POINT = 4
_FREE_BELOW, _TAKEN_ABOVE = 0.35, 0.65
_LABEL_PIXELS = 18.0


def decode(jpeg: bytes) -> NDArray[np.uint8]:
    """Return the picture, uint8 BGR (H, W, 3), as the sensor gave it: EXIF's orientation is not applied.

    Raises NoImage with the reason when it cannot be used, DamagedImage when a part of it was lost.
    """
    if not jpeg:
        raise NoImage(say("the camera gave an empty picture"))
    try:
        head = read_jpeg(jpeg)
    except ValueError as error:
        raise NoImage(say("the picture is {fault}", fault=words_of(error))) from None
    width, height = head.size
    if min(width, height) < MINIMUM_SIDE:
        raise NoImage(
            say(
                "the picture is {width} x {height} pixels; at least {least} a side are needed",
                width=width,
                height=height,
                least=MINIMUM_SIDE,
            )
        )
    if width * height > MAXIMUM_PIXELS:
        raise NoImage(
            say(
                "the picture is {width} x {height} pixels; at most {millions} million fit",
                width=width,
                height=height,
                millions=MAXIMUM_PIXELS // 1_000_000,
            )
        )
    image = pictures.decode(jpeg)
    if float(image[::8, ::8].mean()) < _BLACK_MEAN:
        raise NoImage(say("the picture is black: is the lens covered?"))
    return image


@dataclass(frozen=True, slots=True)
class PictureStyle:
    """Style of the sent pictures: one wider than ``maximum_width`` pixels is made smaller; ``quality`` is JPEG's.

    ``caption`` is written on every picture, so that a simulated one is never taken for a real one.
    """

    maximum_width: int = 960
    quality: int = 75
    caption: str = ""


def annotate(
    image: NDArray[np.uint8],
    camera: CameraModel,
    pose: MapPose | None,
    stalls: Sequence[Stall | Detection] = (),
    style: PictureStyle = PictureStyle(),
) -> bytes:
    """Return the annotated picture (``image`` is uint8 BGR) as JPEG. Without a pose no stall is drawn."""
    canvas = _fit(image, style.maximum_width)
    if pose is not None and pose.is_finite() and pose.height > 0:
        view = scaled_camera(camera, canvas.shape[1], canvas.shape[0])
        _draw_stalls(canvas, stalls, view, pose)
    if style.caption:
        _write_caption(canvas, style.caption)
    done, jpeg = cv2.imencode(".jpg", canvas, [cv2.IMWRITE_JPEG_QUALITY, style.quality])
    return jpeg.tobytes() if done else b""


def state_of(stall: Stall | Detection) -> StallState:
    """Return the state of a stall: the fused one, or by one frame."""
    if isinstance(stall, Stall):
        return stall.state
    if stall.taken <= _FREE_BELOW:
        return StallState.FREE
    return StallState.TAKEN if stall.taken >= _TAKEN_ABOVE else StallState.UNKNOWN


def _fit(image: NDArray[np.uint8], maximum_width: int) -> NDArray[np.uint8]:
    height, width = image.shape[:2]
    if width <= maximum_width:
        return image.copy()
    size = (maximum_width, round(height * maximum_width / width))
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_LINEAR), np.uint8)


def _write_caption(canvas: NDArray[np.uint8], caption: str) -> None:
    width = canvas.shape[1]
    (across, up), below = cv2.getTextSize(caption, cv2.FONT_HERSHEY_SIMPLEX, 0.5, 1)
    left, base = width - across - 10, up + 10
    cv2.rectangle(canvas, (left - 4, base - up - 4), (width - 6, base + below + 2), (28, 22, 16), cv2.FILLED)
    cv2.putText(canvas, caption, (left, base), cv2.FONT_HERSHEY_SIMPLEX, 0.5, (255, 255, 255), 1, cv2.LINE_AA)


def _draw_stalls(
    canvas: NDArray[np.uint8], stalls: Sequence[Stall | Detection], view: CameraModel, pose: MapPose
) -> None:
    if not stalls:
        return
    table = np.array([(s.north, s.east, s.angle, s.width, s.length) for s in stalls])
    pixels = project(quads.corners(*table.T), view, pose)
    inside = _drawable(pixels, canvas.shape)
    states = np.array([state_of(s) for s in stalls], dtype=object)
    free, taken, unknown = (pixels[inside & (states == state)] for state in _DRAWN)
    filled = canvas.copy()
    _fill(filled, free, FREE_BGR)
    _fill(filled, taken, TAKEN_BGR)
    cv2.addWeighted(filled, _FILL, canvas, 1 - _FILL, 0, dst=canvas)
    _polylines(canvas, _hatching(taken), TAKEN_HATCH_BGR, closed=False)
    _polylines(canvas, free, FREE_BGR, closed=True)
    _polylines(canvas, taken, TAKEN_BGR, closed=True)
    _polylines(canvas, _dashes(unknown), UNKNOWN_BGR, closed=False)
    roomy = inside & (np.hypot(*(pixels[:, 1] - pixels[:, 0]).T) >= _LABEL_PIXELS)
    for k in np.flatnonzero(roomy).tolist():
        stall = stalls[k]
        if isinstance(stall, Stall):
            _label(canvas, str(stall.id), pixels[k].mean(axis=0).tolist())


def _drawable(pixels: FloatArray, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """Return which polygons (N, K, 2) touch the picture and lie near enough for OpenCV's integers."""
    height, width = shape[:2]
    finite = np.isfinite(pixels).all(axis=(1, 2))
    safe = np.where(np.isfinite(pixels), pixels, 1e9)
    low, high = safe.min(axis=1), safe.max(axis=1)
    touches = (high > 0).all(axis=1) & (low[:, 0] < width) & (low[:, 1] < height)
    return np.asarray(finite & touches & (np.abs(safe).max(axis=(1, 2)) < 1e4))


def _hatching(pixels: FloatArray) -> FloatArray:
    """Return slanted strokes (M, 2, 2) across quads (N, 4, 2)."""
    near = pixels[:, :1] + (pixels[:, 3:] - pixels[:, :1]) * np.clip(_HATCH_STEPS - _HATCH_LEAN / 2, 0, 1)[:, None]
    far = pixels[:, 1:2] + (pixels[:, 2:3] - pixels[:, 1:2]) * np.clip(_HATCH_STEPS + _HATCH_LEAN / 2, 0, 1)[:, None]
    return np.stack([near, far], axis=2).reshape(-1, 2, 2)


def _dashes(pixels: FloatArray) -> FloatArray:
    """Return dashes (M, 2, 2) along the sides of quads (N, 4, 2)."""
    start, side = pixels, np.roll(pixels, -1, axis=1) - pixels
    begin = (np.arange(_DASHES) / _DASHES)[:, None]
    first = start[:, :, None] + side[:, :, None] * begin
    last = first + side[:, :, None] * (0.55 / _DASHES)
    return np.stack([first, last], axis=3).reshape(-1, 2, 2)


def _fixed(points: FloatArray) -> NDArray[Any]:
    return np.asarray(np.rint(points * 2**_FIXED_POINT), np.int32)


def _fill(canvas: NDArray[np.uint8], pixels: FloatArray, colour: tuple[int, int, int]) -> None:
    if len(pixels):
        cv2.fillPoly(canvas, list(_fixed(pixels)), colour, cv2.LINE_8, _FIXED_POINT)


def _polylines(canvas: NDArray[np.uint8], pixels: FloatArray, colour: tuple[int, int, int], *, closed: bool) -> None:
    if len(pixels):
        cv2.polylines(canvas, list(_fixed(pixels)), closed, colour, 1, cv2.LINE_AA, _FIXED_POINT)


def _label(canvas: NDArray[np.uint8], text: str, middle: Sequence[float]) -> None:
    at = (round(middle[0]) - 4 * len(text), round(middle[1]) + 4)
    cv2.putText(canvas, text, at, cv2.FONT_HERSHEY_PLAIN, 0.8, (0, 0, 0), 2)
    cv2.putText(canvas, text, at, cv2.FONT_HERSHEY_PLAIN, 0.8, (255, 255, 255), 1)
