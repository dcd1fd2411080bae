"""Messages of a recording in Foxglove's schemas (https://docs.foxglove.dev/docs/sdk/schemas), for anybody's viewer.

Frame ``map``: x east, y north, z up, metres, from the map's datum at the height of the arm place. Times are those of
the recording.

foxglove-sdk's own writer is not used: its file would lose what it holds back when the process is killed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, Final

from foxglove import Schema
from foxglove.messages import (
    CameraCalibration,
    Color,
    CompressedImage,
    GeoJson,
    LinePrimitive,
    LinePrimitiveLineType,
    LocationFix,
    Log,
    LogLevel,
    Point3,
    Pose,
    PoseInFrame,
    Quaternion,
    SceneEntity,
    SceneEntityDeletion,
    SceneEntityDeletionType,
    SceneUpdate,
    Timestamp,
    Vector3,
)

from hawk.model.lot_map import Stall, StallState
from hawk.model.operation import Level
from hawk.model.pictures import CameraModel
from hawk.model.poses import MapPose, VehiclePose
from hawk.results.survey_map import recorded_geojson
from hawk.store.frame_codec import View, Words
from hawk.store.replay import CAMERA, STALLS_ON_EARTH

CALIBRATION: Final = "camera_calibration"
LOCATION: Final = "location"
POSE: Final = "pose"
LOG: Final = "log"
STALLS: Final = "stalls"
MAP_FRAME: Final = "map"
DRONE_FRAME: Final = "drone"
CAMERA_FRAME: Final = "camera"
_LINE_M: Final = 0.15
_COLOURS: Final = {
    StallState.FREE: Color(r=0.18, g=0.56, b=1.0, a=1.0),
    StallState.TAKEN: Color(r=1.0, g=0.48, b=0.1, a=1.0),
    StallState.UNKNOWN: Color(r=0.5, g=0.5, b=0.5, a=1.0),
    StallState.SUGGESTED: Color(r=0.8, g=0.7, b=0.3, a=1.0),
}
_LEVELS: Final[Mapping[Level, LogLevel]] = {"warning": LogLevel.Warning, "error": LogLevel.Error}


_KINDS: Final[Mapping[str, Any]] = {
    CAMERA: CompressedImage,
    CALIBRATION: CameraCalibration,
    LOCATION: LocationFix,
    POSE: PoseInFrame,
    LOG: Log,
    STALLS_ON_EARTH: GeoJson,
    STALLS: SceneUpdate,
}


Coded = tuple[str, bytes]
"""A topic, and a message of its schema."""


def schema_of(topic: str) -> Schema:
    """Return the schema of a topic of this module."""
    schema: Schema = _KINDS[topic].get_schema()
    return schema


def views_of(view: View, time_ns: int) -> Iterator[Coded]:
    """Give the messages that show a value; ``time_ns``: the recording's time, nanoseconds."""
    stamp = _stamp(time_ns)
    if isinstance(view, Words):
        words = f"{view.text}\n{view.details}" if view.details else view.text
        yield LOG, Log(timestamp=stamp, level=_level(view.level), message=words, name="hawk").encode()
    elif isinstance(view, VehiclePose):
        yield from _place(view, stamp)
    else:
        yield STALLS_ON_EARTH, GeoJson(geojson=recorded_geojson(view.datum, view.stalls)).encode()
        yield STALLS, _scene(view.stalls, stamp).encode()


def picture_message(jpeg: bytes, captured_ns: int) -> Coded:
    """Return a picture; ``captured_ns``: its exposure in the recording's time, nanoseconds."""
    image = CompressedImage(timestamp=_stamp(captured_ns), frame_id=CAMERA_FRAME, data=jpeg, format="jpeg")
    return CAMERA, image.encode()


def calibration_message(camera: CameraModel, time_ns: int) -> Coded:
    """Return the camera of the pictures from ``time_ns`` on."""
    fx, fy, cx, cy = camera.fx, camera.fy, camera.cx, camera.cy
    message = CameraCalibration(
        timestamp=_stamp(time_ns),
        frame_id=CAMERA_FRAME,
        width=camera.width,
        height=camera.height,
        distortion_model="plumb_bob",
        D=[*camera.distortion, *([0.0] * (5 - len(camera.distortion)))],
        K=[fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
        R=[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        P=[fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
    )
    return CALIBRATION, message.encode()


def _stamp(time_ns: int) -> Timestamp:
    seconds, rest = divmod(time_ns, 1_000_000_000)
    return Timestamp(seconds, rest)


def _level(level: Level) -> LogLevel:
    return _LEVELS.get(level, LogLevel.Info)


def _place(pose: VehiclePose, stamp: Timestamp) -> Iterator[Coded]:
    place = pose.global_
    fix = LocationFix(
        timestamp=stamp,
        frame_id=DRONE_FRAME,
        latitude=place.latitude,
        longitude=place.longitude,
        altitude=place.altitude,
    )
    yield LOCATION, fix.encode()
    if pose.map is not None and pose.map.is_finite():
        yield POSE, PoseInFrame(timestamp=stamp, frame_id=MAP_FRAME, pose=_pose(pose.map)).encode()


def _pose(pose: MapPose) -> Pose:
    """Return a pose with axes forward, left and up, about east, north and up."""
    x, y, z, w = _quaternion(pose.roll, -pose.pitch, math.pi / 2 - pose.yaw)
    place = Vector3(x=pose.east, y=pose.north, z=pose.height)
    return Pose(position=place, orientation=Quaternion(x=x, y=y, z=z, w=w))


def _quaternion(roll: float, pitch: float, yaw: float) -> tuple[float, float, float, float]:
    """Return x, y, z, w of a turn by yaw about z, then pitch about y, then roll about x, radians."""
    cr, sr = math.cos(roll / 2), math.sin(roll / 2)
    cp, sp = math.cos(pitch / 2), math.sin(pitch / 2)
    cy, sy = math.cos(yaw / 2), math.sin(yaw / 2)
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


def _scene(stalls: Mapping[int, Stall], stamp: Timestamp) -> SceneUpdate:
    """Return the outlines of all stalls as one entity: it takes the place of the one before."""
    if not stalls:
        return SceneUpdate(deletions=[SceneEntityDeletion(timestamp=stamp, type=SceneEntityDeletionType.All)])
    points, colours = [], []
    for stall in stalls.values():
        corners = [Point3(x=east, y=north, z=0.0) for north, east in stall.corners().tolist()]
        for start, end in zip(corners, (*corners[1:], corners[0]), strict=True):
            points += [start, end]
        colours += [_COLOURS[stall.state]] * 8
    lines = LinePrimitive(type=LinePrimitiveLineType.LineList, thickness=_LINE_M, points=points, colors=colours)
    return SceneUpdate(entities=[SceneEntity(timestamp=stamp, frame_id=MAP_FRAME, id="stalls", lines=[lines])])
