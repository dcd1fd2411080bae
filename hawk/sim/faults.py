"""Faults of the simulated drone, of its sensors, its link and its camera (`POST /fault`)."""

from __future__ import annotations

import math
import struct
from typing import Annotated, Final, Literal

from pydantic import BaseModel, ConfigDict, Field

from hawk.sim.autopilot.autopilot import Autopilot, RefusedError
from hawk.sim.autopilot.fence import FenceCommand, FenceError, FenceItem
from hawk.sim.autopilot.parameters import Other
from hawk.sim.autopilot.radio import POSITIONS
from hawk.sim.autopilot.rally import MAX_POINTS, RallyPoint
from hawk.sim.camera.camera import Camera, Frame
from hawk.sim.link.mavlink_link import MavlinkLink

LOST_BYTES: Final = 3000
EVERY: Final = 10
"""One picture of this number is damaged."""
UPRIGHT: Final = 1
"""EXIF orientation of a picture that is not turned."""
_ORIENTATION_TAG: Final = 0x0112
_SHORT: Final = 3
_START: Final = 2
"""Bytes of a JPEG's start mark."""


def damage(jpeg: bytes, sequence: int) -> bytes:
    """Return the picture without `LOST_BYTES` of its middle, where it is one of the damaged ones."""
    if sequence % EVERY or len(jpeg) < 2 * LOST_BYTES:
        return jpeg
    middle = len(jpeg) // 2
    return jpeg[: middle - LOST_BYTES // 2] + jpeg[middle + LOST_BYTES // 2 :]


def orient(jpeg: bytes, orientation: int) -> bytes:
    """Return the picture with an EXIF orientation, 1 to 8; the pixels stay (EXIF 2.32, 4.6.4)."""
    if orientation == UPRIGHT:
        return jpeg
    entry = struct.pack(">HHIHH", _ORIENTATION_TAG, _SHORT, 1, orientation, 0)
    tiff = b"MM\0*" + struct.pack(">IH", 8, 1) + entry + struct.pack(">I", 0)
    exif = b"Exif\0\0" + tiff
    return jpeg[:_START] + b"\xff\xe1" + struct.pack(">H", len(exif) + 2) + exif + jpeg[_START:]


Metres = Annotated[float, Field(ge=-10_000.0, le=10_000.0, allow_inf_nan=False)]
Speed = Annotated[float, Field(ge=-50.0, le=50.0, allow_inf_nan=False)]


class StationMessage(BaseModel):
    """A MAVLink message that a second ground station sends the autopilot; text for fields of characters."""

    model_config = ConfigDict(extra="forbid")

    kind: str = Field(description="name of the message, as PARAM_SET", pattern="^[A-Za-z0-9_]+$")
    fields: dict[str, float | int | str | list[float]] = Field(description="its fields by name, all of them")
    system: int = Field(255, ge=1, le=255)
    component: int = Field(190, ge=0, le=255)


class Fault(BaseModel):
    """Faults to inject or to clear. A field that is absent stays as it is."""

    model_config = ConfigDict(extra="forbid")

    gps: Literal["ok", "lost"] | None = Field(None, description="GNSS reception")
    gps_jump: tuple[Metres, Metres, Metres] | None = Field(
        None, description="the position estimate jumps by (north, east, down) metres, local and global alike"
    )
    gps_glitch: tuple[Metres, Metres, Metres] | None = Field(
        None, description="GNSS is off by (north, east, down) metres: the EKF refuses it for 10 s, then jumps to it"
    )
    gps_glitch_s: float | None = Field(
        None, gt=0.0, le=3600.0, description="with gps_glitch: it ends by itself after this time, seconds"
    )
    gps_bias: tuple[Metres, Metres, Metres] | None = Field(
        None,
        description="constant error of GNSS, (north, east, down) metres; the EKF takes a small step at once and treats "
        "a large one as a glitch, a boot begins with it; what was walked until now is gone",
    )
    gps_walk: tuple[Speed, Speed] | None = Field(
        None, description="GNSS walks away (north, east), m/s, and the EKF with it; 0, 0: it stays where it is"
    )
    baro_drift: Speed | None = Field(
        None, description="the barometer's height rises by this, m/s, and the EKF's with it; 0: it stays; GNSS does not"
    )
    baro_error: Metres | None = Field(None, description="the barometer's height is too high by this, metres")
    compass: Literal["ok", "lost"] | None = Field(None, description="all compasses at once")
    compass_error_deg: float | None = Field(
        None, ge=-180.0, le=180.0, description="all compasses turn by this, clockwise, degrees; the EKF follows"
    )
    home: tuple[Metres, Metres, Metres] | None = Field(
        None, description="another station moves home to (north, east, down) metres from where the world begins"
    )
    rally: list[tuple[Metres, Metres, Metres]] | None = Field(
        None,
        max_length=MAX_POINTS,
        description="another station uploads these rally points, (north, east, up) metres from home; none: it "
        "clears them",
    )
    fence: list[tuple[Metres, Metres]] | None = Field(
        None,
        description="another station replaces the fence by this polygon, (north, east) metres from home; none: it "
        "clears the fence",
    )
    parameters: dict[str, float] | None = Field(None, description="another station sets these parameters")
    station: list[StationMessage] | None = Field(
        None, description="another station on another link of the autopilot sends these messages, in order"
    )
    others: list[Other] | None = Field(
        None,
        description="others that give signs of life on our link, once a second before the copter's own: antenna "
        "tracker, gimbal, second copter, ground station",
    )
    ekf_shift: tuple[Metres, Metres, Metres] | None = Field(
        None, description="EKF-local's origin moves by (north, east, down) metres; global stays"
    )
    camera: Literal["ok", "dark", "frozen", "garbage", "damaged", "unstamped", "closed", "mirrored"] | None = Field(
        None,
        description="no pictures; one picture for ever with new stamps; JPEGs cut off; 3 kB lost within one JPEG of "
        "ten; no time stamps; connections refused; left and right swapped",
    )
    camera_stamp_step_s: float | None = Field(
        None, ge=-60.0, le=60.0, description="the camera's time stamps are off by this from now on, seconds"
    )
    camera_orientation: int | None = Field(
        None, ge=1, le=8, description="EXIF orientation that pictures claim; 1: none is written"
    )
    camera_tail_bytes: int | None = Field(None, ge=0, le=100_000, description="zero bytes behind each JPEG's end")
    camera_contrast: float | None = Field(
        None, ge=0.0, le=1.0, description="share of the pictures' contrast that is left: ground without texture"
    )
    camera_blank_every: int | None = Field(
        None, ge=0, le=1000, description="each picture of this number shows nothing, as a bad exposure; 0: none"
    )
    camera_turn_deg: float | None = Field(
        None, ge=-360.0, le=360.0, description="the camera sits turned in its mount, clockwise seen from above, degrees"
    )
    link: Literal["ok", "cut", "mute"] | None = Field(
        None, description="MAVLink is lost in both directions; only from the autopilot"
    )
    link_version: Literal[1, 2] | None = Field(None, description="MAVLink 1 or 2 from the autopilot")
    late_parameters_s: float | None = Field(
        None, ge=0.0, le=60.0, description="a parameter that was set reads as the old one for this time, seconds"
    )
    link_loss: float | None = Field(None, ge=0.0, le=1.0, description="share of datagrams lost, in each direction")
    battery: float | None = Field(None, ge=0.0, le=100.0, description="charge left, percent, true and counted")
    battery_charge: float | None = Field(
        None, ge=0.0, le=100.0, description="true charge left, percent, which the counter does not see"
    )
    battery_counter: Literal["ok", "still", "restart"] | None = Field(
        None, description="the counter of charge: it counts; it stands still; it begins at 100 % again and counts"
    )
    battery_rest_v: float | None = Field(
        None, ge=0.0, le=100.0, description="volts at rest whatever the charge; 0: by the charge again"
    )
    battery_error_v: float | None = Field(None, ge=-50.0, le=50.0, description="error of the voltage sensor, volts")
    battery_resistance_ohm: float | None = Field(
        None, ge=0.0, le=1.0, description="resistance within the battery; an old or cold one sags (0.012 at first)"
    )
    battery_cells: int | None = Field(
        None, ge=1, le=14, description="cells in series; no parameter changes (3 at first)"
    )
    motors: Literal["off"] | None = Field(None, description="motors stop, in the air too; the autopilot disarms")
    wind: float | None = Field(None, ge=0.0, le=30.0, description="mean wind, m/s")
    wind_heading_deg: float | None = Field(None, ge=-360.0, le=360.0, description="where the wind blows to, degrees")
    radio: Literal["ok", "lost"] | None = Field(None, description="the pilot's radio control")
    rangefinder: Literal["ok", "stuck"] | None = Field(None, description="stuck: it measures what it measures now")
    stick: float | None = Field(None, ge=0.0, le=1.0, description="the pilot's throttle stick")
    mode_switch: int | None = Field(None, ge=1, le=6, description="the pilot's mode switch moves to this position")
    pilot_mode: int | None = Field(None, ge=0, le=255, description="the pilot switches to this custom_mode")
    remote_id: Literal["ok", "lost"] | None = Field(None, description="the Remote ID transmitter")
    repair: bool | None = Field(None, description="true: a crashed vehicle stands upright again where it lies")
    autopilot: Literal["crash", "reboot", "power_cycle"] | None = Field(
        None, description="its program ends; boots when disarmed; boots at once, whatever it does"
    )


class CameraFaults:
    """Faults of the camera's HTTP side."""

    def __init__(self) -> None:
        self.garbage = False
        self.damaged = False
        self.stamp_step_s = 0.0
        self.orientation = UPRIGHT
        self.tail_bytes = 0
        self.unstamped = False
        self.closed = False

    def picture(self, frame: Frame) -> bytes:
        """Return the bytes that are sent for a frame."""
        jpeg = frame.jpeg
        if self.garbage:
            jpeg = jpeg[: len(jpeg) // 3]
        elif self.damaged:
            jpeg = damage(jpeg, frame.sequence)
        return orient(jpeg, self.orientation) + bytes(self.tail_bytes)

    def stamp(self, frame: Frame) -> float:
        """Return the time stamp that is sent for a frame, seconds."""
        return frame.stamp + self.stamp_step_s


def apply_fault(
    fault: Fault, autopilot: Autopilot, link: MavlinkLink, camera: Camera, server: CameraFaults
) -> list[str]:
    """Inject the faults and return the problems in words."""
    if fault.gps is not None:
        autopilot.estimator.receiving = fault.gps == "ok"
    if fault.gps_jump is not None:
        autopilot.estimator.jump(*fault.gps_jump)
    _sensors(fault, autopilot)
    if fault.home is not None:
        autopilot.set_home(fault.home)
    if fault.ekf_shift is not None:
        autopilot.shift_ekf_origin(fault.ekf_shift)
    _camera(fault, camera, server)
    if fault.link is not None:
        link.cut, link.mute = fault.link == "cut", fault.link == "mute"
    if fault.late_parameters_s is not None:
        link.late_parameters_s = fault.late_parameters_s
    if fault.link_loss is not None:
        link.loss = fault.link_loss
    if fault.link_version is not None:
        link.version = fault.link_version
    if fault.others is not None:
        link.others.present = frozenset(fault.others)
    _battery(fault, autopilot)
    if fault.wind is not None:
        autopilot.wind.speed = fault.wind
    if fault.wind_heading_deg is not None:
        autopilot.wind.heading = math.radians(fault.wind_heading_deg)
    if fault.radio is not None:
        autopilot.radio_present = fault.radio == "ok"
    if fault.rangefinder is not None:
        autopilot.rangefinder.stuck_cm = None
        if fault.rangefinder == "stuck":
            autopilot.rangefinder.stuck_cm = autopilot.rangefinder.measure_cm(autopilot.body, autopilot.options.slope)
    if fault.stick is not None:
        autopilot.stick = fault.stick
    if fault.mode_switch is not None:
        autopilot.radio.switch = POSITIONS[fault.mode_switch - 1]
    if fault.remote_id is not None:
        link.transmitter.is_broken = fault.remote_id == "lost"
    if fault.repair:
        autopilot.repair()
    return [*_station(fault, autopilot, link), *_commands(fault, autopilot)]


def _sensors(fault: Fault, autopilot: Autopilot) -> None:
    if fault.gps_glitch is not None:
        autopilot.gnss.set_glitch(fault.gps_glitch, fault.gps_glitch_s or math.inf)
    if fault.gps_bias is not None:
        autopilot.gnss.set_bias(fault.gps_bias)
    if fault.gps_walk is not None:
        autopilot.gnss.walk = fault.gps_walk
    if fault.baro_error is not None:
        autopilot.barometer.error = fault.baro_error
    if fault.baro_drift is not None:
        autopilot.barometer.drift = fault.baro_drift
    if fault.compass is not None:
        autopilot.compasses.failed = fault.compass == "lost"
    if fault.compass_error_deg is not None:
        autopilot.compasses.error = math.radians(fault.compass_error_deg)


def _battery(fault: Fault, autopilot: Autopilot) -> None:
    battery = autopilot.battery
    if fault.battery is not None:
        battery.remaining = fault.battery / 100.0
        autopilot.failsafes.clear_battery()
    if fault.battery_charge is not None:
        battery.charge = fault.battery_charge / 100.0
    if fault.battery_counter is not None:
        battery.counts = fault.battery_counter != "still"
        if fault.battery_counter == "restart":
            battery.restart_counter()
    if fault.battery_rest_v is not None:
        battery.rest_v = fault.battery_rest_v or None
    if fault.battery_error_v is not None:
        battery.error_v = fault.battery_error_v
    if fault.battery_resistance_ohm is not None:
        battery.resistance = fault.battery_resistance_ohm
    if fault.battery_cells is not None:
        battery.cells = fault.battery_cells


def _station(fault: Fault, autopilot: Autopilot, link: MavlinkLink) -> list[str]:
    """Let another station change what the fault names; return the problems in words."""
    problems = []
    try:
        if fault.rally is not None:
            autopilot.load_rally([RallyPoint(*autopilot.beside_home(n, e), up) for n, e, up in fault.rally])
        if fault.fence is not None:
            corners = [autopilot.beside_home(*corner) for corner in fault.fence]
            autopilot.load_fence(
                [FenceItem(FenceCommand.INCLUSION_VERTEX, len(corners), *corner) for corner in corners]
            )
    except (RefusedError, FenceError) as error:
        problems.append(f"{'rally' if fault.rally is not None else 'fence'}: {error}")
    for name, value in (fault.parameters or {}).items():
        if name not in autopilot.parameters:
            problems.append(f"parameters: there is no {name}")
            continue
        fields = {"target_system": 1, "target_component": 1, "param_id": name, "param_value": value, "param_type": 9}
        link.station_says("PARAM_SET", fields, 255, 190)
    for message in fault.station or []:
        try:
            link.station_says(message.kind, message.fields, message.system, message.component)
        except ValueError as error:
            problems.append(f"station: {error}")
    return problems


def _commands(fault: Fault, autopilot: Autopilot) -> list[str]:
    problems = []
    if fault.pilot_mode is not None:
        try:
            autopilot.set_mode(fault.pilot_mode)
        except RefusedError as error:
            problems.append(f"pilot_mode: {error}")
    if fault.motors == "off":
        autopilot.disarm(force=True)
    if fault.autopilot == "crash":
        autopilot.crash_program("a fault was asked for")
    elif fault.autopilot == "power_cycle":
        autopilot.boot()
    elif fault.autopilot == "reboot":
        try:
            autopilot.reboot()
        except RefusedError as error:
            problems.append(f"autopilot: {error}; power_cycle boots it all the same")
    return problems


CAMERA_FIELDS = frozenset(name for name in Fault.model_fields if name.startswith("camera"))
"""Fields of the camera alone."""


def apply_camera_fault(fault: Fault, camera: Camera, server: CameraFaults) -> list[str]:
    """Inject a fault of the camera, where there is no drone; return the problems of the other fields in words."""
    _camera(fault, camera, server)
    return [f"{name}: only the camera can fail here" for name in fault.model_fields_set - CAMERA_FIELDS]


def _camera(fault: Fault, camera: Camera, server: CameraFaults) -> None:
    if fault.camera_turn_deg is not None:
        camera.turned = math.radians(fault.camera_turn_deg)
    if fault.camera_contrast is not None:
        camera.contrast = fault.camera_contrast
    if fault.camera_blank_every is not None:
        camera.blank_every = fault.camera_blank_every
    if fault.camera_stamp_step_s is not None:
        server.stamp_step_s = fault.camera_stamp_step_s
    if fault.camera_orientation is not None:
        server.orientation = fault.camera_orientation
    if fault.camera_tail_bytes is not None:
        server.tail_bytes = fault.camera_tail_bytes
    kind = fault.camera
    if kind is None:
        return
    camera.dark = kind == "dark"
    camera.frozen = kind == "frozen"
    camera.mirrored = kind == "mirrored"
    server.garbage = kind == "garbage"
    server.damaged = kind == "damaged"
    server.unstamped = kind == "unstamped"
    server.closed = kind == "closed"
