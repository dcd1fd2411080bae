"""Telemetry: the autopilot's messages turned into the daemon's topics, one at a time, on the loop.

Poses are made from LOCAL_POSITION_NED, ATTITUDE and GLOBAL_POSITION_INT, each at the time that it carries; a message
whose time is not believed (`hawk.comm.autopilot.boot_clock`) is dropped. `hawk.comm.autopilot.streams` asks for the
messages.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from datetime import datetime
from typing import Any, Final

from hawk.comm.autopilot.boot_clock import BootClock, GnssClock
from hawk.comm.autopilot.estimator import EstimatorReport, LeapObserver
from hawk.comm.autopilot.gimbal import GimbalAttitudes
from hawk.comm.autopilot.mavlink_link import Message, SensorHealth
from hawk.comm.autopilot.remote_control import RemoteControlReports
from hawk.comm.autopilot.remote_id import RemoteIdReports
from hawk.comm.autopilot.status_texts import StatusTexts
from hawk.comm.autopilot.streams import RateKeeper
from hawk.comm.autopilot.terrain import TerrainEstimator, looks_down, read_distance
from hawk.comm.autopilot.vehicle import VehicleTopics
from hawk.comm.clock import Clock
from hawk.model.frames import JUMP_M, Attitude, EkfPosition, FrameJump, MapTie, PoseBuffer
from hawk.model.moment import Moment
from hawk.model.poses import ArmPlace, GlobalPose, VehiclePose
from hawk.model.sentences import say
from hawk.model.sun import SunPosition, sun_position
from hawk.model.vehicle import BatteryInfo, Diagnostics, GnssHeight, LandedState, VehicleState

_LOG = logging.getLogger(__name__)
_ARMED: Final = 128  # MAV_MODE_FLAG_SAFETY_ARMED
_NOT_AN_AUTOPILOT: Final = 8  # MAV_AUTOPILOT_INVALID
_FIX_3D: Final = 3  # GPS_FIX_TYPE_3D_FIX
_COMPASS: Final = 1 << 2  # MAV_SYS_STATUS_SENSOR_3D_MAG
_GEOFENCE: Final = 1 << 20  # MAV_SYS_STATUS_GEOFENCE
_FRESH_S: Final = 1.0
_GPS_FRESH_S: Final = 3.0
_SATELLITES_UNKNOWN: Final = 255
_EXTENSIONS: Final = {
    "GPS_RAW_INT": ("alt_ellipsoid", "h_acc", "v_acc", "vel_acc", "hdg_acc", "yaw"),
    "HOME_POSITION": ("time_usec",),
}
"""Fields that MAVLink 2 added, of messages that an ArduCopter sends with at least one of them."""
_NOT_SHIFTED: Final = (0.0, 0.0)
_STAMPED: Final = frozenset(
    {
        "LOCAL_POSITION_NED",
        "ATTITUDE",
        "GLOBAL_POSITION_INT",
        "SYSTEM_TIME",
        "DISTANCE_SENSOR",
        "GIMBAL_DEVICE_ATTITUDE_STATUS",
    }
)
"""Messages that carry time_boot_ms."""

MAP_SHIFT_M: Final = 2.0
"""The mapper takes smaller errors of the position out by itself, metres (`MapperSettings.max_shift_m`)."""
LINK_LOST_S: Final = 2.6
"""Real seconds without a HEARTBEAT after which the link is lost, as in MAVSDK."""


Handler = Callable[[Mapping[str, Any], float], None]
"""Takes the fields of a message and its time, seconds of the daemon's clock."""


class Telemetry:
    """The newest of everything that the autopilot sent, as topics and as poses at a moment."""

    def __init__(
        self,
        clock: Clock,
        topics: VehicleTopics,
        rates: RateKeeper,
        sensor_health: Callable[[], SensorHealth],
        moment: Callable[[], Moment],
        on_reboot: Callable[[], None] = lambda: None,
    ) -> None:
        """``moment``: this computer's clocks. ``on_reboot`` is called when the autopilot has booted."""
        self._clock = clock
        self._topics = topics
        self._rates = rates
        self._sensor_health = sensor_health
        self._moment = moment
        self._on_reboot = on_reboot
        self.tie = MapTie()
        """Frames of reference, datum and arm place."""
        self._buffer = PoseBuffer()
        self._boot_clock = BootClock(clock.speed)
        self._gnss_clock = GnssClock()
        self._estimator = EstimatorReport()
        self._leaps = LeapObserver()
        self._terrain = TerrainEstimator()
        self._shift = _NOT_SHIFTED  # leaps of the estimate since the arm place: north, east (m)
        self.gimbal = GimbalAttitudes()
        """The camera's gimbal, where the autopilot reports one."""
        self.texts = StatusTexts()
        self.state = VehicleState()
        """The autopilot's state as last heard."""
        self._gps: tuple[int, int | None, float | None] | None = None  # fix, satellites, accuracy (m)
        self._fence_on: bool | None = None
        self._compass_ok: bool | None = None
        self._has_extensions = dict.fromkeys(_EXTENSIONS, True)  # until one came without
        self._global: tuple[float, GlobalPose] | None = None
        self._boot: Moment | None = None
        self._remote_control = RemoteControlReports(topics.remote_control)
        self._remote_id = RemoteIdReports(topics.remote_id)
        self._handlers = self._handler_table()

    def _handler_table(self) -> dict[str, Handler]:
        return {
            "HEARTBEAT": self._on_heartbeat,
            "EXTENDED_SYS_STATE": self._on_extended_state,
            "LOCAL_POSITION_NED": self._on_local_position,
            "ATTITUDE": self._on_attitude,
            "GLOBAL_POSITION_INT": self._on_global_position,
            "SYS_STATUS": self._on_sys_status,
            "GPS_RAW_INT": self._on_gps,
            "EKF_STATUS_REPORT": self._on_estimator,
            "HOME_POSITION": self._on_home,
            "DISTANCE_SENSOR": self._on_distance,
            "STATUSTEXT": self._on_text,
            "RC_CHANNELS": self._remote_control.take_channels,
            "GIMBAL_DEVICE_ATTITUDE_STATUS": self.gimbal.take,
            "OPEN_DRONE_ID_ARM_STATUS": self._remote_id.take_arm_status,
            "SYSTEM_TIME": self._gnss_clock.take,
        }

    def handle(self, message: Message) -> None:
        """Take one message of the autopilot. A malformed message is logged and dropped."""
        handler = self._handlers.get(message.name)
        if handler is None or (message.name == "DISTANCE_SENSOR" and not looks_down(message.fields)):
            return
        self._rates.seen(message.name, message.arrival)
        try:
            stamped = message.name in _STAMPED
            time = self._stamp(message) if stamped else message.arrival
            if time is not None:
                handler(message.fields, time)
        except (KeyError, TypeError, ValueError) as error:
            _LOG.warning("%s of the autopilot is not usable: %r", message.name, error)

    def check_link(self, now: float) -> bool:
        """Return True while the autopilot is heard; publish when it fell silent."""
        lost = now - self.state.time > LINK_LOST_S * self._clock.speed
        if lost and self.state.connected:
            self._publish_state(replace(self.state, connected=False))
        return not lost

    def silence(self, now: float) -> float:
        """Return the seconds since the last HEARTBEAT, zero before the first."""
        return now - self.state.time if self.state.time > -math.inf else 0.0

    def from_boot(self, seconds: float) -> float | None:
        """Return a time of the autopilot's boot clock on ours, None before that clock is known."""
        return self._boot_clock.to_ours(seconds)

    @property
    def boot_ms(self) -> int:
        """The autopilot's newest time since boot, milliseconds."""
        newest = self._boot_clock.newest
        return 0 if newest is None else int(newest * 1000)

    def restore_arm_place(self, place: ArmPlace) -> None:
        """Keep the arm place of an earlier run until the autopilot's boot is known, then restore or drop it."""
        self.tie.keep(place)
        self._try_restored()

    def pose_at(self, time: float) -> VehiclePose | None:
        """Return the pose interpolated to that moment, None when it is not known."""
        position = self._buffer.position_at(time)
        attitude = self._buffer.attitude_at(time)
        if position is None or attitude is None or not self.tie.offset.sure:
            return None
        return self._compose(position, attitude)

    def sun_at(self, time: float, pose: VehiclePose) -> SunPosition | None:
        """Return where the sun stands over a vehicle at a time, None while the autopilot's UTC is not known."""
        moment = self.utc_at(time)
        return None if moment is None else sun_position(moment, pose.global_.latitude, pose.global_.longitude)

    def utc_at(self, time: float) -> datetime | None:
        """Return the moment at a time of our clock by the autopilot's GNSS; None while its UTC is not known."""
        return self._gnss_clock.at(time)

    def map_problem(self, now: float) -> str:
        """Return why nothing should be mapped by the position at ``now`` (seconds); empty when it may be."""
        moved = math.hypot(*self._shift)
        if moved > MAP_SHIFT_M:
            return say(
                "the position jumped by {moved:.0f} m against the map: nothing is mapped until it is back", moved=moved
            )
        fault = self._estimator_fault(now)
        if not fault:
            return ""
        return say("the autopilot does not trust its position ({fault}): nothing is mapped", fault=fault)

    # --- state -----------------------------------------------------------------------------------------------------

    def _on_heartbeat(self, fields: Mapping[str, Any], arrival: float) -> None:
        if int(fields["autopilot"]) == _NOT_AN_AUTOPILOT:
            return
        armed = bool(int(fields["base_mode"]) & _ARMED)
        mode = int(fields["custom_mode"])
        if armed:
            self.tie.armed(arrival, at_start=self.state.time == -math.inf)
        else:
            self.tie.disarmed(arrival)
        self._publish_state(replace(self.state, connected=True, armed=armed, custom_mode=mode, time=arrival))

    def _on_extended_state(self, fields: Mapping[str, Any], arrival: float) -> None:
        try:
            landed = LandedState(int(fields["landed_state"]))
        except ValueError:
            landed = LandedState.UNDEFINED
        self._publish_state(replace(self.state, landed=landed, landed_time=arrival))

    def _publish_state(self, state: VehicleState) -> None:
        self.state = state
        self._topics.state.publish(state)

    # --- pose ------------------------------------------------------------------------------------------------------

    def _on_local_position(self, fields: Mapping[str, Any], time: float) -> None:
        sample = EkfPosition(time, *(_number(fields, name) for name in ("x", "y", "z", "vx", "vy", "vz")))
        sent = _number(fields, "time_boot_ms") / 1000.0
        if self._leaps.look(replace(sample, time=sent)) and self.tie.frames is not None:
            _LOG.warning("The autopilot's position leapt; no pose is given until it is tied to the map again")
            self.tie.offset.doubt()
            self._buffer.clear()
        self._buffer.add_position(sample)
        if self.tie.offset.sure:
            self._publish_pose(sample)

    def _publish_pose(self, position: EkfPosition) -> None:
        attitude = self._buffer.attitude_at(position.time)
        pose = None if attitude is None else self._compose(position, attitude)
        if pose is not None:
            self._topics.pose.publish(pose)

    def _on_attitude(self, fields: Mapping[str, Any], time: float) -> None:
        self._buffer.add_attitude(Attitude(time, *(_number(fields, name) for name in ("roll", "pitch", "yaw"))))

    def _on_distance(self, fields: Mapping[str, Any], time: float) -> None:
        reading = read_distance(fields, time, self._buffer.attitude_at(time))
        frames, position = self.tie.frames, self._buffer.position_at(time)
        place = None
        if frames is not None and position is not None and self.tie.offset.sure:
            local = frames.local(position, 0.0)
            place = (local.x, local.y, -local.z)
        self._topics.terrain.publish(self._terrain.take(reading, place))

    def _on_global_position(self, fields: Mapping[str, Any], time: float) -> None:
        if int(fields["lat"]) == 0 and int(fields["lon"]) == 0:
            return  # ArduPilot's "no position yet"
        here = GlobalPose(int(fields["lat"]) / 1e7, int(fields["lon"]) / 1e7, int(fields["alt"]) / 1e3)
        self._global = (time, here)
        self.tie.move_provisional(here, armed=self.state.armed)
        position = self._buffer.position_at(time)
        if position is None or self._boot is None:
            return
        now = self._clock()
        arm = self.tie.anchor(position, here, self.state.landed_at(now), self._boot, now)
        if arm is not None:
            self._topics.arm_place.publish(arm)
            self._leaps.settle()
            self._terrain.reset()
            self._shift = _NOT_SHIFTED
            return
        jump = self.tie.look(position, here)
        if jump is not None:
            self._take_jump(jump)
        if self.tie.frames is not None and self.tie.offset.sure:
            self._settle_leap(jump)

    def _settle_leap(self, jump: FrameJump | None) -> None:
        """Publish how far the estimate moved on the map: a leap that the frames, tied again, do not take up."""
        frames = (0.0, 0.0, 0.0) if jump is None else jump.shift
        north, east, down = (leap - taken for leap, taken in zip(self._leaps.settle(), frames, strict=True))
        metres = math.hypot(north, east, down)
        if metres <= JUMP_M:
            return
        self._shift = (self._shift[0] + north, self._shift[1] + east)
        self._terrain.reset()
        _LOG.warning("The position estimate jumped by %.1f m", metres)
        position = self._buffer.latest_position
        if position is not None:
            self._publish_pose(position)  # a listener to the jump finds the new place
        self._topics.estimate_jump.publish(metres)

    def _take_jump(self, jump: FrameJump) -> None:
        _LOG.warning("EKF-local jumped by %.1f m; anchored again", jump.metres)
        self._buffer.clear()
        self._topics.arm_place.publish(jump.arm)
        self._topics.frame_jump.publish(jump.metres)

    def _try_restored(self) -> None:
        arm = None if self._boot is None else self.tie.restore(self._boot)
        if arm is not None:
            self._topics.arm_place.publish(arm)

    def _compose(self, position: EkfPosition, attitude: Attitude) -> VehiclePose | None:
        frames = self.tie.frames
        if frames is not None:
            world = frames.world(position)
        elif self._global is not None and abs(position.time - self._global[0]) <= _FRESH_S:
            world = self._global[1]
        else:
            return None
        local = None if frames is None else frames.local(position, attitude.yaw)
        return VehiclePose(
            time=position.time,
            global_=world,
            relative_altitude=None if local is None else -local.z,
            local=local,
            map=None if frames is None else frames.map(position, attitude),
            velocity=(position.vx, position.vy, position.vz),
            roll=attitude.roll,
            pitch=attitude.pitch,
            yaw=attitude.yaw,
        )

    # --- boot ------------------------------------------------------------------------------------------------------

    def _stamp(self, message: Message) -> float | None:
        """Return the message's own time on our clock; None when it is not believed. Notice a boot."""
        boot = _number(message.fields, "time_boot_ms") / 1000.0
        reading = self._boot_clock.take(message.name, boot, message.arrival)
        if reading.time is None:
            return None
        if reading.event == "corrected":
            _LOG.warning("The autopilot's clock was mapped wrongly; poses are estimated again")
            self._global = None
            self._buffer.clear()
            self.gimbal.forget()
        elif reading.event:
            if reading.event == "booted":
                self._rebooted()
            running = message.arrival - reading.time + boot
            self._boot = self._moment().before(running / self._clock.speed)
            self._try_restored()
        return reading.time

    def _rebooted(self) -> None:
        """Drop everything that belonged to the old boot. Armed stays as the last HEARTBEAT gave it."""
        _LOG.warning("The autopilot has booted")
        self._global = self._gps = self._fence_on = self._compass_ok = None
        self._buffer.clear()
        self._gnss_clock.forget()
        self._estimator, self._leaps, self._shift = EstimatorReport(), LeapObserver(), _NOT_SHIFTED
        self._terrain.reset()
        self.gimbal.forget()
        self.tie.rebooted()
        self._publish_state(replace(self.state, landed=LandedState.UNDEFINED, landed_time=self._clock()))
        self._rates.forget()
        self._remote_control.forget()
        self._remote_id.forget()
        self._on_reboot()

    # --- other ---------------------------------------------------------------------------------------------------

    def _on_sys_status(self, fields: Mapping[str, Any], arrival: float) -> None:
        self._topics.battery.publish(battery_info(fields, arrival))
        enabled = fields.get("onboard_control_sensors_enabled")
        self._fence_on = None if enabled is None else bool(int(enabled) & _GEOFENCE)
        self._compass_ok = compass_works(fields)
        self._remote_control.take_status(fields, arrival)
        self._publish_diagnostics(arrival)

    def _publish_diagnostics(self, arrival: float) -> None:
        health = self._sensor_health()
        fresh = self._gps is not None and self._rates.age("GPS_RAW_INT", arrival) < _GPS_FRESH_S
        fix, satellites, accuracy = self._gps if fresh and self._gps is not None else (None, None, None)
        located = fix is not None and fix >= _FIX_3D  # MAVSDK's flags are cached: they outlive the fix by seconds
        fault = self._estimator_fault(arrival)
        self._topics.diagnostics.publish(
            Diagnostics(
                all_ok=health.all_ok and located,
                armable=health.armable,
                global_position_ok=health.global_position_ok and located and not fault,
                home_position_ok=health.home_position_ok,
                gps_fix=fix,
                satellites=satellites,
                horizontal_accuracy=accuracy,
                time=arrival,
                estimator_fault=fault,
                fence_on=self._fence_on,
                compass_ok=self._compass_ok,
                is_mavlink_1=self._speaks_mavlink_1(health.is_mavlink_1),
            )
        )

    def _speaks_mavlink_1(self, seen: bool | None) -> bool:
        """Return whether the link speaks MAVLink 1: as its frames say, else when what version 2 added is missing."""
        return not any(self._has_extensions.values()) if seen is None else seen

    def _on_estimator(self, fields: Mapping[str, Any], arrival: float) -> None:
        self._estimator.take(fields, arrival)  # SYS_STATUS publishes it: the age of diagnostics is its age

    def _estimator_fault(self, now: float) -> str:
        return self._estimator.fault(now) or (say("its position creeps") if self._leaps.creeps else "")

    def _on_gps(self, fields: Mapping[str, Any], arrival: float) -> None:
        self._remote_id.take_gps(fields)
        self._note_extensions("GPS_RAW_INT", fields)
        accuracy, satellites = int(fields.get("h_acc") or 0), int(fields["satellites_visible"])
        self._gps = (
            int(fields["fix_type"]),
            None if satellites == _SATELLITES_UNKNOWN else satellites,
            accuracy / 1000.0 if accuracy else None,
        )

        self._publish_gnss_height(fields, arrival)

    def _publish_gnss_height(self, fields: Mapping[str, Any], arrival: float) -> None:
        here, altitude, accuracy = self._global, fields.get("alt"), int(fields.get("v_acc") or 0)
        has_fix = int(fields["fix_type"]) >= _FIX_3D
        if not has_fix or altitude is None or here is None or arrival - here[0] > _FRESH_S:
            return
        height = GnssHeight(arrival, int(altitude) / 1e3, accuracy / 1e3 if accuracy else None, here[1].altitude)
        self._topics.gnss_height.publish(height)

    def _note_extensions(self, name: str, fields: Mapping[str, Any]) -> None:
        self._has_extensions[name] = any(fields.get(field) for field in _EXTENSIONS[name])

    def _on_home(self, fields: Mapping[str, Any], _: float) -> None:
        self._note_extensions("HOME_POSITION", fields)
        home = GlobalPose(int(fields["latitude"]) / 1e7, int(fields["longitude"]) / 1e7, int(fields["altitude"]) / 1e3)
        self.tie.home = home
        self._topics.home.publish(home)

    def _on_text(self, fields: Mapping[str, Any], arrival: float) -> None:
        text = self.texts.take(fields, arrival)
        if text is not None:
            self._topics.status_text.publish(text)


def _number(fields: Mapping[str, Any], name: str) -> float:
    """Return a finite number (MAVSDK gives None for NaN). Raises ValueError naming the field."""
    value = fields[name]
    if value is None or not math.isfinite(value):
        raise ValueError(f"{name} is not a finite number")
    return float(value)


def compass_works(fields: Mapping[str, Any]) -> bool | None:
    """Return whether a SYS_STATUS says that a compass works; None where none is in use."""
    present, enabled, health = (
        int(fields.get(f"onboard_control_sensors_{what}") or 0) for what in ("present", "enabled", "health")
    )
    return bool(health & _COMPASS) if present & enabled & _COMPASS else None


def battery_info(fields: Mapping[str, Any], arrival: float) -> BatteryInfo:
    """Return the battery of a SYS_STATUS; what it does not know is None."""
    percentage, voltage, current = (
        int(fields[name]) for name in ("battery_remaining", "voltage_battery", "current_battery")
    )
    return BatteryInfo(
        percentage=float(percentage) if 0 <= percentage <= 100 else None,
        voltage=voltage / 1000.0 if 0 < voltage < 65535 else None,
        current=current / 100.0 if current >= 0 else None,
        time=arrival,
    )
