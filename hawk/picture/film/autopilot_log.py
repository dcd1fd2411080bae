"""A drone's course by an ArduPilot log: telemetry (``.tlog``) or the autopilot's own (``.bin``), read by pymavlink.

Telemetry: GLOBAL_POSITION_INT, ATTITUDE, GIMBAL_DEVICE_ATTITUDE_STATUS
(https://mavlink.io/en/messages/common.html). The autopilot's: POS, ATT, MNT
(https://ardupilot.org/copter/docs/logmessages.html). Their times are Unix seconds: by the ground station's clock, and
by GNSS.
"""

from __future__ import annotations

import math
import struct
from collections import Counter
from contextlib import redirect_stderr, suppress
from dataclasses import dataclass, field, replace
from io import StringIO
from pathlib import Path
from typing import Any, Final

import numpy as np

from hawk.model.pictures import CameraModel, angles, rotation
from hawk.picture.film.course import Course, FloatArray, turning_between
from hawk.picture.photographs.tags import looking_down
from hawk.picture.values import PictureError
from hawk.runtime.late import load
from hawk.runtime.programs import remedy

SUFFIXES: Final = (".tlog", ".bin")
_TELEMETRY: Final = ("GLOBAL_POSITION_INT", "ATTITUDE", "GIMBAL_DEVICE_ATTITUDE_STATUS")
_OWN: Final = ("POS", "ATT", "MNT")
_YAW_IN_EARTH: Final = 64 | 16
"""GIMBAL_DEVICE_FLAGS_YAW_IN_EARTH_FRAME or, of older gimbals, YAW_LOCK."""
_DOWN: Final = rotation(0.0, math.pi / 2, 0.0)
"""Turns the axes of a camera that looks ahead, as gimbals have them, into those of one that looks down."""
_YEAR_2000: Final = 946_684_800.0
_SIGMA_M: Final = (1.5, 2.0)
_DAMAGED: Final = "download it again from the autopilot, or name the ground station's .tlog"


@dataclass(frozen=True, slots=True)
class LoggedFlight:
    """A flight by its log. ``has_gimbal``: the attitudes are the gimbal's, otherwise those of a camera that is fixed to
    the drone as its calibration's mount says.
    """

    course: Course
    has_gimbal: bool


@dataclass(slots=True)
class _Rows:
    """``places``: time, latitude, longitude, altitude, height; ``body``, ``gimbal``: time, roll, pitch, yaw."""

    places: list[tuple[float, ...]] = field(default_factory=list)
    body: list[tuple[float, ...]] = field(default_factory=list)
    gimbal: list[tuple[float, ...]] = field(default_factory=list)


def read_log(path: Path, camera: CameraModel | None = None) -> LoggedFlight:
    """Return the flight of a log. ``camera``: its mount turns a camera that is fixed to the drone.

    Raises PictureError without pymavlink, or where the log cannot be read or has no places.
    """
    rows = _telemetry(path) if path.suffix.lower() == ".tlog" else _own(path)
    if len(rows.places) < 2:
        raise PictureError(
            f"{path}: no places are in it (GLOBAL_POSITION_INT, POS): the drone had no GPS fix, or it is no flight's "
            f"log; {_DAMAGED}"
        )
    if not rows.body and not rows.gimbal:
        raise PictureError(f"{path}: no attitudes are in it (ATTITUDE, ATT); {_DAMAGED}")
    places = _in_order(rows.places)
    turned = _in_order(rows.gimbal or rows.body)
    if not rows.gimbal and camera is not None:
        mount = rotation(camera.mount_roll, camera.mount_pitch, camera.mount_yaw)
        turned[:, 1:] = [angles(rotation(*row) @ mount) for row in turned[:, 1:]]
    epoch = 0.0 if places[0, 0] > _YEAR_2000 else None
    return LoggedFlight(_joined(places, turned, epoch), bool(rows.gimbal))


_NO_FIELD: Final = (AttributeError, TypeError, ValueError, OverflowError)


def _joined(places: FloatArray, turned: FloatArray, epoch: float | None) -> Course:
    """Return the course at the times of both: attitudes come more often than places, and change faster.

    Attitudes within a gap of the places are left out, so that it stays one.
    """
    blank = np.full((len(places), 3), math.nan)
    course = Course.of_rows(places, blank, _SIGMA_M, epoch)
    between = turned[course.covers(turned[:, 0]), 0]
    times = np.union1d(places[:, 0], between)
    return replace(course.at(times), attitude=turning_between(times, turned[:, 0], turned[:, 1:]))


def _in_order(rows: list[tuple[float, ...]]) -> FloatArray:
    """Return rows by their time, each time once."""
    _, first = np.unique([row[0] for row in rows], return_index=True)
    return np.array([rows[k] for k in first], np.float64)


def _opened(path: Path) -> Any:
    try:
        pymavlink = load("pymavlink", "DFReader", "mavutil")  # only desks that read logs have it
    except ImportError as error:
        raise PictureError(f"pymavlink is not installed, which reads {path.suffix} logs: {remedy('sim')}") from error
    try:
        if path.stat().st_size == 0:
            raise PictureError(f"{path}: is empty; {_DAMAGED}")
        with redirect_stderr(StringIO()):  # it prints each byte that it cannot read
            # its mavlink_connection runs what lies in a folder named bin, and connects to names such as tcp:a.bin
            pymavlink.mavutil.set_dialect("ardupilotmega")
            is_telemetry = path.suffix.lower() == ".tlog"
            return (pymavlink.mavutil.mavmmaplog if is_telemetry else pymavlink.DFReader.DFReader_binary)(str(path))
    except OSError as error:
        raise PictureError(f"{path} cannot be read ({error.strerror or error}); {_DAMAGED}") from None
    except PictureError:
        raise
    except Exception as error:  # pymavlink raises struct.error, IndexError, KeyError and others for torn logs
        raise PictureError(f"{path}: is damaged, or no log of ArduPilot ({error!r}); {_DAMAGED}") from None


def _messages(path: Path, names: tuple[str, ...]) -> Any:
    """Give a log's messages of these names, up to its damage."""
    log = _opened(path)
    try:
        while (message := _next(log, names)) is not None:
            yield message
    finally:
        log.close()


def _next(log: Any, names: tuple[str, ...]) -> Any:
    """Return the next message of these names, None at the end or where the log is torn: what was read counts."""
    with redirect_stderr(StringIO()), suppress(ValueError, LookupError, TypeError, struct.error, OSError):
        return log.recv_match(type=list(names))
    return None


def _telemetry(path: Path) -> _Rows:
    """Return the rows of the drone that has most of the places: a ground station may have logged several."""
    by_system: dict[int, _Rows] = {}
    counts: Counter[int] = Counter()
    for message in _messages(path, _TELEMETRY):
        system, time = int(message.get_srcSystem()), float(message._timestamp)
        rows = by_system.setdefault(system, _Rows())
        kind = message.get_type()
        if kind == "GLOBAL_POSITION_INT":
            if message.lat or message.lon:
                counts[system] += 1
                above, height = message.alt / 1000.0, message.relative_alt / 1000.0
                rows.places.append((time, message.lat / 1e7, message.lon / 1e7, above, height))
        elif kind == "ATTITUDE":
            rows.body.append((time, message.roll, message.pitch, message.yaw))
        else:
            rows.gimbal.append((time, *message.q, int(message.flags)))
    if not counts:
        return _Rows()
    rows = by_system[counts.most_common(1)[0][0]]
    rows.gimbal = _gimbal_rows(rows)
    return rows


def _gimbal_rows(rows: _Rows) -> list[tuple[float, ...]]:
    """Return the gimbal's attitudes as a camera's; its yaw follows the drone's where the flags do not say north."""
    if not rows.gimbal or not rows.body:
        return []
    body = _in_order(rows.body)
    found: list[tuple[float, ...]] = []
    for time, w, x, y, z, flags in rows.gimbal:
        if not math.isfinite(w + x + y + z) or (w, x, y, z) == (0.0, 0.0, 0.0, 0.0):
            continue
        turn = _matrix(w, x, y, z)
        if not int(flags) & _YAW_IN_EARTH:
            heading = float(turning_between(np.array([time]), body[:, 0], body[:, 1:])[0, 2])
            turn = rotation(0.0, 0.0, heading) @ turn
        found.append((time, *angles(turn @ _DOWN)))
    return found


def _matrix(w: float, x: float, y: float, z: float) -> FloatArray:
    """Return the turn (3, 3) of a quaternion; its angles at straight down would not say the yaw."""
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def _own(path: Path) -> _Rows:
    rows = _Rows()
    for message in _messages(path, _OWN):
        with suppress(*_NO_FIELD):  # a message without its fields, of a log whose formats are damaged, is none
            _take(rows, message)
    return rows


def _take(rows: _Rows, message: Any) -> None:
    """Add a message of an autopilot's own log."""
    kind, time = message.get_type(), float(message._timestamp)
    if kind == "POS":
        if message.Lat or message.Lng:
            height = getattr(message, "RelHomeAlt", math.nan)
            rows.places.append((time, *map(float, (message.Lat, message.Lng, message.Alt, height))))
    elif kind == "ATT":
        roll, pitch, yaw = (math.radians(each) for each in (message.Roll, message.Pitch, message.Yaw))
        rows.body.append((time, roll, pitch, math.remainder(yaw, math.tau)))
    elif hasattr(message, "YawE") and math.isfinite(message.Pitch + message.YawE):
        roll, pitch, yaw = (math.radians(each) for each in (message.Roll, message.Pitch, message.YawE))
        rows.gimbal.append((time, *looking_down(roll, pitch, math.remainder(yaw, math.tau))))
