"""Ground that nobody may look at: it is taken out of a frame before anything is mapped, shown or recorded of it.

The picture's witnesses, camera check and odometry, have compared the whole picture before: a mask moves nothing for
them. On the map such ground is seen and no lot, so that no flight waits for it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from hawk.algo.frame import FrameInput
from hawk.algo.vision.detection import Detection, FloatArray, FrameGround, GroundImage, Vehicle, VisionResult
from hawk.algo.vision.rectify import ground_footprint, project
from hawk.model.pictures import CameraModel
from hawk.model.poses import MapPose, Ring

_STEP_M: Final = 1.0
"""Sides of a ring are bent by the lens: they are drawn in pieces as long as this."""
_FIXED_POINT: Final = 4
_QUALITY: Final = (cv2.IMWRITE_JPEG_QUALITY, 92)


def hidden(seen: VisionResult, frame: FrameInput) -> VisionResult:
    """Return what a frame shows without the private ground in it; the same object where it shows none."""
    pose = frame.over_ground
    if not frame.private or seen.image is None or pose is None:
        return seen
    ground = _in_picture(frame.private, frame.camera, pose)
    if ground.is_empty:
        return seen
    shown = seen.ground
    return replace(
        seen,
        image=_blackened(seen.image, ground, frame.camera, pose),
        ground=None if shown is None else _without(shown, ground),
    )


def recorded_jpeg(frame: FrameInput, whole: VisionResult, seen: VisionResult) -> bytes | None:
    """Return the JPEG to record of a frame; None: its own, b"": none.

    ``whole``: what the frame shows, ``seen``: the same as of `hidden`. Where there is private ground, no frame is
    recorded that cannot be read, or whose place or direction is not sure.
    """
    if not frame.private:
        return None
    if seen.image is None or frame.over_ground is None or frame.map_problem:
        return b""
    if seen.image is whole.image:
        return None
    done, jpeg = cv2.imencode(".jpg", seen.image, _QUALITY)
    return jpeg.tobytes() if done else b""


def blackened(picture: GroundImage, private: BaseGeometry) -> GroundImage:
    """Return a picture on the ground whose private part, (north, east) metres, is black, not seen, and in no view."""
    shown, view = _unseen(picture, private), picture.view
    if view is None:
        return shown
    image = view.image.copy()
    for ring in _rings(private):
        places = np.column_stack([ring, np.ones(len(ring))]) @ view.to_image.T
        cv2.fillPoly(image, [_fixed(places[:, :2] / places[:, 2:])], (0, 0, 0), cv2.LINE_8, _FIXED_POINT)
    return replace(shown, view=replace(view, image=image))


def _in_picture(rings: Sequence[Ring], camera: CameraModel, pose: MapPose) -> BaseGeometry:
    """Return the private ground that a picture shows, (north, east)."""
    corners = [(corner.north, corner.east) for corner in ground_footprint(camera, pose)]
    if len(corners) < 3:
        return shapely.Polygon()
    footprint = shapely.MultiPoint(corners).convex_hull
    private = shapely.union_all([shapely.make_valid(shapely.Polygon(ring)) for ring in rings])
    return footprint.buffer(_STEP_M).intersection(private)


def _blackened(image: NDArray[np.uint8], ground: BaseGeometry, camera: CameraModel, pose: MapPose) -> NDArray[np.uint8]:
    masked = image.copy()
    for ring in _rings(shapely.segmentize(ground, _STEP_M)):
        pixels = project(ring, camera, pose)
        if np.isfinite(pixels).all() and np.abs(pixels).max() < 1e6:
            cv2.fillPoly(masked, [_fixed(pixels)], (0, 0, 0), cv2.LINE_8, _FIXED_POINT)
    return masked


def _without(ground: FrameGround, private: BaseGeometry) -> FrameGround:
    vehicles = None if ground.vehicles is None else tuple(v for v in ground.vehicles if not _is_in(v, private))
    mask = _mask(ground.core, private)  # the layers are one raster
    return replace(
        ground,
        stalls=tuple(stall for stall in ground.stalls if not _is_in(stall, private)),
        vehicles=vehicles,
        lot=_emptied(ground.lot, mask),
        car=_emptied(ground.car, mask),
        core=_emptied(ground.core, mask),
        taken=_emptied(ground.taken, mask),
        picture=_unseen(ground.picture, private),
    )


def _is_in(found: Detection | Vehicle, private: BaseGeometry) -> bool:
    return bool(shapely.intersects_xy(private, found.north, found.east))


def _emptied(layer: GroundImage, mask: NDArray[np.bool_]) -> GroundImage:
    """Return a layer of probabilities that are 0 where the mask of private ground is set."""
    return replace(layer, values=np.where(mask, np.float32(0), layer.values))


def _unseen(picture: GroundImage, private: BaseGeometry) -> GroundImage:
    """Return a picture without private ground; the camera's own, from which it was sampled, stays as it is: only seen
    pixels are taken out of it.
    """
    mask = _mask(picture, private)
    values = picture.values.copy()
    values[mask] = 0
    return replace(picture, values=values, valid=picture.valid & ~mask)


def _mask(layer: GroundImage, private: BaseGeometry) -> NDArray[np.bool_]:
    mask = np.zeros(layer.valid.shape, np.uint8)
    for ring in _rings(private):
        cv2.fillPoly(mask, [_fixed(layer.pixel_points(ring))], 1, cv2.LINE_8, _FIXED_POINT)
    return mask > 0


def _rings(ground: BaseGeometry) -> Iterator[FloatArray]:
    """Yield the outer rings of areas; holes are hidden with them."""
    for part in shapely.get_parts(ground):
        for each in shapely.get_parts(part):
            if isinstance(each, shapely.Polygon) and not each.is_empty:
                yield np.asarray(each.exterior.coords, np.float64)


def _fixed(pixels: FloatArray) -> NDArray[np.int32]:
    return np.asarray(np.rint(pixels * 2**_FIXED_POINT), np.int32)
