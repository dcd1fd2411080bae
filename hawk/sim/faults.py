"""Faults that a test may put in: `POST /fault` with one or more of these fields."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from hawk.sim.autopilot import Autopilot, RefusedError
from hawk.sim.camera import Camera
from hawk.sim.mavlink_link import MavlinkLink

Metres = Annotated[float, Field(ge=-10_000.0, le=10_000.0, allow_inf_nan=False)]


class Fault(BaseModel):
    """What is to go wrong, or right again. A field that is absent stays as it is."""

    model_config = ConfigDict(extra="forbid")

    gps: Literal["ok", "lost"] | None = Field(None, description="GNSS reception")
    gps_jump: tuple[Metres, Metres, Metres] | None = Field(
        None, description="the position estimate jumps by (north, east, down) metres, local and global alike"
    )
    ekf_shift: tuple[Metres, Metres, Metres] | None = Field(
        None, description="EKF-local's origin moves by (north, east, down) metres; global stays"
    )
    camera: Literal["ok", "dark", "frozen", "garbage", "unstamped", "closed"] | None = Field(
        None, description="no pictures; one picture for ever; broken JPEGs; no time stamps; connections refused"
    )
    link: Literal["ok", "cut"] | None = Field(None, description="MAVLink both ways")
    link_loss: float | None = Field(None, ge=0.0, le=1.0, description="share of datagrams lost, each way")
    battery: float | None = Field(None, ge=0.0, le=100.0, description="charge left, percent")
    wind: float | None = Field(None, ge=0.0, le=30.0, description="mean wind, m/s")
    wind_heading_deg: float | None = Field(None, ge=-360.0, le=360.0, description="where the wind blows to, degrees")
    radio: Literal["ok", "lost"] | None = Field(None, description="the pilot's radio control")
    stick: float | None = Field(None, ge=0.0, le=1.0, description="the pilot's throttle stick")
    pilot_mode: int | None = Field(None, ge=0, le=255, description="the pilot switches to this custom_mode")
    repair: bool | None = Field(None, description="true: a crashed vehicle stands upright again where it lies")
    autopilot: Literal["crash", "reboot", "power_cycle"] | None = Field(
        None, description="its program ends; boots when disarmed; boots at once, whatever it does"
    )


class CameraFaults:
    """Faults of the HTTP side of the camera, read by its server."""

    def __init__(self) -> None:
        self.garbage = False
        self.unstamped = False
        self.closed = False


def apply_fault(
    fault: Fault, autopilot: Autopilot, link: MavlinkLink | None, camera: Camera, server: CameraFaults
) -> list[str]:
    """Put the faults in. Returns what could not be done, in words."""
    if fault.gps is not None:
        autopilot.estimator.receiving = fault.gps == "ok"
    if fault.gps_jump is not None:
        autopilot.glitch(fault.gps_jump)
    if fault.ekf_shift is not None:
        autopilot.shift_ekf_origin(fault.ekf_shift)
    if fault.camera is not None:
        _camera(fault.camera, camera, server)
    if link is not None and fault.link is not None:
        link.cut = fault.link == "cut"
    if link is not None and fault.link_loss is not None:
        link.loss = fault.link_loss
    if fault.battery is not None:
        autopilot.battery.remaining = fault.battery / 100.0
        autopilot.failsafes.clear_battery()
    if fault.wind is not None:
        autopilot.wind.speed = fault.wind
    if fault.wind_heading_deg is not None:
        autopilot.wind.heading = math.radians(fault.wind_heading_deg)
    if fault.radio is not None:
        autopilot.radio_present = fault.radio == "ok"
    if fault.stick is not None:
        autopilot.stick = fault.stick
    if fault.repair:
        autopilot.repair()
    return _commands(fault, autopilot)


def _commands(fault: Fault, autopilot: Autopilot) -> list[str]:
    problems = []
    if fault.pilot_mode is not None:
        try:
            autopilot.set_mode(fault.pilot_mode)
        except RefusedError as error:
            problems.append(f"pilot_mode: {error}")
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


def _camera(kind: str, camera: Camera, server: CameraFaults) -> None:
    camera.dark = kind == "dark"
    camera.frozen = kind == "frozen"
    server.garbage = kind == "garbage"
    server.unstamped = kind == "unstamped"
    server.closed = kind == "closed"
