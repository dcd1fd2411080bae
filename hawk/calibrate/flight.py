"""A recorded flight as its calibration needs it: the drone's track, and the frames without their pictures."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, TypeAdapter, ValidationError

from hawk.config.addresses import RPICAM, V4L2
from hawk.model.operation import GROUND_STATES, StateName
from hawk.model.pictures import CameraModel, angles, rotation
from hawk.model.poses import MapPose
from hawk.store.frame_codec import FRAME_INPUT, FrameFormatError, picture_of, values_of
from hawk.store.recording import newest_file
from hawk.store.replay import RecordingError, read_metadata, read_recording

Floats = NDArray[np.float64]

TICK: Final = "tick"
"""Topic of the facts of a tick (`hawk.ddc.recorder`), 20 a second: they hold the pose."""
LONGEST_GAP_S: Final = 0.35
"""The track is interpolated over no longer time without a pose."""
_LAGS_S: Final = np.arange(-0.1, 0.1005, 0.001)
_LAG_ERROR: Final = math.radians(0.15)
_LEAST_HEIGHT_M: Final = 6.0  # lower down cars are no longer small against the height


class FlightError(Exception):
    """The recording cannot be used for a calibration; the text says why, and the remedy."""


class _Value(BaseModel):
    model_config = ConfigDict(extra="ignore", frozen=True)


class _Frame(_Value):
    captured: float
    camera: CameraModel
    pose: MapPose | None
    speed: float
    state: StateName
    map_problem: str = ""
    ground: float = 0.0


class _VehiclePose(_Value):
    time: float
    map: MapPose | None


class _Position(_Value):
    pose: _VehiclePose | None = None


@dataclass(frozen=True, slots=True)
class Track:
    """The drone's poses.

    ``times`` (T,) rise, seconds of the daemon's clock; ``poses`` (T, 6): north, east, height (metres, map frame), roll,
    pitch, yaw (radians; yaw without leaps). The attitudes are ``lag`` seconds older than their times say.
    """

    times: Floats = field(repr=False)
    poses: Floats = field(repr=False)
    lag: float = 0.0

    @classmethod
    def of(cls, timed: Sequence[tuple[float, MapPose]]) -> Track:
        """Return the track of poses and their times, in any order; of two with the same time the first counts."""
        times, first = np.unique([time for time, _ in timed], return_index=True)
        rows = [(p.north, p.east, p.height, p.roll, p.pitch, p.yaw) for p in (timed[k][1] for k in first)]
        poses = np.array(rows, float).reshape(-1, 6)
        poses[:, 5] = np.unwrap(poses[:, 5])
        return cls(np.asarray(times, float), poses)

    def at(self, times: Floats) -> Floats:
        """Return the poses (N, 6) at times (N,), interpolated; beyond the ends the pose of the end."""
        late = times + self.lag
        return np.column_stack([np.interp(times if k < 3 else late, self.times, self.poses[:, k]) for k in range(6)])

    def covers(self, time: float, margin_s: float) -> bool:
        """Return True when the track has no gap from ``margin_s`` seconds before that time to as long after it."""
        first = int(np.searchsorted(self.times, time - margin_s, side="right")) - 1
        last = int(np.searchsorted(self.times, time + margin_s, side="left"))
        if first < 0 or last >= len(self.times):
            return False
        return bool(np.diff(self.times[first : last + 1]).max(initial=0.0) <= LONGEST_GAP_S)


def aligned(dense: Track, exact: Track) -> Track:
    """Return the dense track with the lag of its attitudes taken out; the exact one where no lag explains them.

    A tick's pose has the time of its position, and the attitude that came before it. The poses of the frames are
    interpolated to the moment: they show the lag.
    """
    if len(dense.times) < 2 or len(exact.times) < 2:
        return exact
    inside = (exact.times > dense.times[0] - _LAGS_S[0]) & (exact.times < dense.times[-1] - _LAGS_S[-1])
    best = exact, _LAG_ERROR
    for lag in _LAGS_S:
        tried = Track(dense.times, dense.poses, float(lag))
        off = tried.at(exact.times[inside])[:, 3:] - exact.poses[inside, 3:]
        off -= math.tau * np.round(off / math.tau)
        error = float(np.sqrt(np.mean(off**2))) if len(off) else math.inf
        if error < best[1]:
            best = tried, error
    return best[0]


@dataclass(frozen=True, slots=True)
class Look:
    """One frame of the flight; ``index`` counts the recording's frames.

    ``captured`` is the time of exposure by the settings of the flight; ``ground`` the height of the ground below,
    metres above the arm place.
    """

    index: int
    captured: float
    pose: MapPose
    speed: float
    ground: float

    @property
    def over_ground(self) -> float:
        """Metres above the ground below."""
        return self.pose.height - self.ground


@dataclass(frozen=True, slots=True)
class Flown:
    """Settings of the camera that a flight was flown with."""

    latency_s: float
    has_gimbal: bool = False
    has_kernel_stamps: bool = False
    """The kernel stamps the pictures: ``latency_s`` is not used."""


@dataclass(frozen=True, slots=True)
class Flight:
    """A recorded flight. ``camera`` has the mount's settings.

    Where the camera hangs on a gimbal, the poses have the attitude of the gimbal in place of the drone's, and the mount
    is level.
    """

    path: Path
    camera: CameraModel
    flown: Flown
    track: Track
    looks: tuple[Look, ...] = field(repr=False)


def read_flight(path: Path) -> Flight:
    """Read a recording. Raises FlightError, `hawk.store.replay.RecordingError`."""
    flown = _flown(path)
    looks: list[Look] = []
    cameras: list[CameraModel] = []
    timed: list[tuple[float, MapPose]] = []
    positions, frames = TypeAdapter(_Position), TypeAdapter(_Frame)
    count = 0
    for recorded in read_recording(path):
        try:
            if recorded.topic == FRAME_INPUT:
                frame = frames.validate_python(values_of(recorded.data))
                count += 1
                if _is_of_use(frame) and frame.pose is not None:
                    pose, camera = _aimed(frame.pose, frame.camera) if flown.has_gimbal else (frame.pose, frame.camera)
                    looks.append(Look(count - 1, frame.captured, pose, frame.speed, frame.ground))
                    cameras.append(camera)
            elif recorded.topic == TICK:
                timed += _poses(positions, recorded.payload())
        except (FrameFormatError, ValidationError) as error:
            raise FlightError(f"{path}: a message of {recorded.topic} cannot be read: {error}") from error
    if not looks:
        raise FlightError(
            f"{path}: has no pictures from {_LEAST_HEIGHT_M:g} m above the ground with a pose: name the recording of a "
            "flight that mapped"
        )
    kept = tuple(look for look, its in zip(looks, cameras, strict=True) if its == cameras[-1])
    exact = Track.of([(look.captured, look.pose) for look in kept])
    track = exact if flown.has_gimbal else aligned(Track.of(timed), exact)
    return Flight(path, cameras[-1], flown, track, kept)


def _aimed(pose: MapPose, camera: CameraModel) -> tuple[MapPose, CameraModel]:
    """Return the pose with the attitude by which the camera looks straight down, and the camera with a level mount."""
    body = rotation(pose.roll, pose.pitch, pose.yaw)
    turn = body @ rotation(camera.mount_roll, camera.mount_pitch, camera.mount_yaw)
    roll, pitch, yaw = angles(turn)
    level = replace(camera, mount_roll=0.0, mount_pitch=0.0, mount_yaw=0.0)
    return MapPose(pose.north, pose.east, pose.height, roll, pitch, yaw), level


def pictures(path: Path, wanted: frozenset[int]) -> Iterator[tuple[int, bytes]]:
    """Yield index and JPEG of the wanted frames, in the recording's order. Raises RecordingError."""
    count = -1
    for recorded in read_recording(path):
        if recorded.topic != FRAME_INPUT:
            continue
        count += 1
        if count in wanted:
            try:
                yield count, picture_of(recorded.data)
            except FrameFormatError as error:
                raise RecordingError(f"{path}: {error}") from error


def newest_recording(folder: Path) -> Path:
    """Return the newest recording of a store's folder. Raises FlightError."""
    try:
        return newest_file(folder / "recordings")
    except ValueError:
        raise FlightError(
            f"store.directory: {folder / 'recordings'} has no recording: fly with [store] record = true, or name one"
        ) from None


def _is_of_use(frame: _Frame) -> bool:
    pose = frame.pose
    if pose is None or not pose.is_finite() or frame.state in GROUND_STATES or frame.map_problem:
        return False
    return pose.height - frame.ground >= _LEAST_HEIGHT_M


def _poses(positions: TypeAdapter[_Position], payload: dict[str, Any]) -> list[tuple[float, MapPose]]:
    facts = payload.get("facts")
    found = facts.get("position") if isinstance(facts, dict) else None
    pose = positions.validate_python(found).pose if isinstance(found, dict) else None
    if pose is None or pose.map is None or not pose.map.is_finite():
        return []
    return [(pose.time, pose.map)]


def _flown(path: Path) -> Flown:
    text = read_metadata(path).get("configuration", "")
    try:
        camera = _Settings.model_validate_json(text).camera
    except ValidationError as error:
        raise FlightError(f"{path}: its metadata do not hold the setting camera.latency_s of the flight") from error
    return Flown(camera.latency_s, camera.gimbal, camera.url.startswith((RPICAM, V4L2)))


class _CameraPart(_Value):
    url: str
    latency_s: float
    gimbal: bool = False


class _Settings(_Value):
    camera: _CameraPart
