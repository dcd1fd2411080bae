"""Films of a flight over a drawn world, with its captions or its log, for tests."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from functools import cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.model.pictures import CameraModel
from hawk.sim.geometry import Origin
from hawk.worlds.camera import Lens, WorldCamera
from hawk.worlds.world import World

SIZE = (320, 180)
FOCAL = 260.0
LENS = CameraModel(*SIZE, FOCAL, FOCAL, 159.5, 89.5)
FPS = 10.0
HEIGHT = 30.0
ORIGIN = Origin(latitude=46.8, longitude=-91.9, altitude=200.0)
START = datetime(2026, 5, 4, 10, 30, tzinfo=UTC)
Place = tuple[float, float, float]
"""Metres east and south in the world, yaw in radians."""


@dataclass(frozen=True)
class Flight:
    """A drone's place by the seconds of a film that lasts ``seconds``."""

    place: Callable[[float], Place]
    seconds: float

    def geodetic(self, at: float) -> tuple[float, float, float]:
        x, y, _ = self.place(at)
        return ORIGIN.to_geodetic((-y, x, -HEIGHT))


def straight(at: float) -> Place:
    """Fly east at 5 m/s from (30, 50), the picture's top ahead."""
    return 30.0 + 5.0 * at, 50.0, math.pi / 2


def stop_and_go(at: float) -> Place:
    """Fly east, stand from 3 to 5 s, then fly on faster."""
    return 30.0 + 4.0 * min(at, 3.0) + 6.0 * max(0.0, at - 5.0), 50.0, math.pi / 2


@cache
def world() -> World:
    """Return 150 x 100 m of ground with blots of all sizes."""
    rng = np.random.default_rng(5)
    ground = np.full((1000, 1500, 3), 110.0)
    for cells in (12, 50, 200):
        blots = rng.normal(0.0, 22.0, (cells, round(cells * 1.5), 3))
        ground += cv2.resize(blots, (1500, 1000), interpolation=cv2.INTER_LINEAR)
    return World(name="blots", metres_per_pixel=0.1, ground=np.clip(ground, 0, 255).astype(np.uint8), lots=())


def write_film(path: Path, flight: Flight, camera: CameraModel = LENS, fourcc: str = "mp4v") -> Path:
    """Draw a flight as a film."""
    detector = WorldCamera(world(), camera, Lens(noise=1.0))
    size = (camera.width, camera.height)
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*fourcc), FPS, size)
    assert writer.isOpened()
    for number in range(round(flight.seconds * FPS)):
        x, y, yaw = flight.place(number / FPS)
        writer.write(detector.render(x, y, HEIGHT, 0.0, 0.0, yaw, rng=np.random.default_rng(number)))
    writer.release()
    return path


def captions(flight: Flight, first: int = 1, gimbal: bool = True, pitch: float = -90.0, extra: str = "") -> str:
    """Return captions as a Mavic 3 writes them, one a frame."""
    blocks = []
    for number in range(round(flight.seconds * FPS)):
        at = number / FPS
        latitude, longitude, altitude = flight.geodetic(at)
        yaw = math.degrees(flight.place(at)[2])
        angles = f" [gb_yaw: {yaw:.1f} gb_pitch: {pitch:.1f} gb_roll: 0.0]" if gimbal else ""
        blocks.append(
            f"{number + 1}\n{_span(at)} --> {_span(at + 1 / FPS)}\n"
            f'<font size="28">FrameCnt: {number + first}, DiffTime: 100ms\n'
            f"{START + timedelta(seconds=at):%Y-%m-%d %H:%M:%S.%f}"[:-3]
            + f"\n[iso: 100] [shutter: 1/1000.0] [fnum: 2.8] {extra}[latitude: {latitude:.7f}] "
            f"[longitude: {longitude:.7f}] [rel_alt: {HEIGHT:.3f} abs_alt: {altitude:.3f}]{angles} </font>\n"
        )
    return "\n".join(blocks)


def _span(at: float) -> str:
    whole = round(at * 1000)
    return f"{whole // 3_600_000:02d}:{whole // 60_000 % 60:02d}:{whole // 1000 % 60:02d},{whole % 1000:03d}"


def write_tlog(path: Path, flight: Flight, begin: float = 0.0, end: float | None = None, rate: float = 10.0) -> Path:
    """Write a ground station's log of a flight; its first message is ``begin`` seconds after the film's first frame."""
    sender = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
    data = b""
    for at in np.arange(begin, flight.seconds if end is None else end, 1.0 / rate).tolist():
        latitude, longitude, altitude = flight.geodetic(at)
        yaw, boot = flight.place(at)[2], round((at - begin) * 1000) + 5000
        degrees = round(math.degrees(yaw) % 360 * 100)
        stamp = struct.pack(">Q", round((START.timestamp() + at) * 1e6))
        messages: list[Any] = [
            sender.global_position_int_encode(
                boot, round(latitude * 1e7), round(longitude * 1e7), round(altitude * 1e3), round(HEIGHT * 1e3),
                0, 0, 0, degrees,
            ),
            sender.attitude_encode(boot, 0.0, 0.0, yaw, 0.0, 0.0, 0.0),
        ]  # fmt: skip
        data += b"".join(stamp + message.pack(sender) for message in messages)
    path.write_bytes(data)
    return path


_FORMATS = {
    "GPS": (130, "QBIHBcLLeffffB", "TimeUS,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd,GCrs,VZ,Yaw,U"),
    "POS": (131, "QLLfff", "TimeUS,Lat,Lng,Alt,RelHomeAlt,RelOriginAlt"),
    "ATT": (132, "Qccccff", "TimeUS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw"),
}
_CODES = {"Q": "Q", "B": "B", "I": "I", "H": "H", "c": "h", "L": "i", "e": "i", "f": "f"}
_GPS_EPOCH, _LEAP_S, _WEEK_S = 315_964_800, 18, 604_800


def write_bin(path: Path, flight: Flight, begin: float, end: float) -> Path:
    """Write an autopilot's own log: FMT (https://ardupilot.org/dev/docs/code-overview-adding-a-new-log-message.html)."""
    data = b""
    formats = {"FMT": (128, "BBnNZ", "Type,Length,Name,Format,Columns"), **_FORMATS}
    for name, (number, form, columns) in formats.items():
        length = 89 if name == "FMT" else 3 + struct.calcsize("<" + "".join(_CODES[each] for each in form))
        data += b"\xa3\x95\x80" + struct.pack(
            "<BB4s16s64s", number, length, name.encode(), form.encode(), columns.encode()
        )
    for at in np.arange(begin, end, 0.1).tolist():
        boot = round((at - begin) * 1e6) + 5_000_000
        latitude, longitude, altitude = flight.geodetic(at)
        place = round(latitude * 1e7), round(longitude * 1e7)
        since = START.timestamp() + at - _GPS_EPOCH + _LEAP_S
        week, rest = divmod(since, _WEEK_S)
        gps = (boot, 3, round(rest * 1000), int(week), 15, 80, *place, round(altitude * 100), 5.0, 90.0, 0.0, 0.0, 1)
        yaw = math.degrees(flight.place(at)[2])
        rows = {"GPS": gps, "POS": (boot, *place, altitude, HEIGHT, HEIGHT), "ATT": (boot, 0, 0, 0, 0, yaw, yaw)}
        for name, row in rows.items():
            number, form, _ = _FORMATS[name]
            data += bytes([0xA3, 0x95, number]) + struct.pack("<" + "".join(_CODES[each] for each in form), *row)
    path.write_bytes(data)
    return path
