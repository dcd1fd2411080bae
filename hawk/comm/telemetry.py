"""Telemetry: the autopilot's messages turned into what the daemon publishes. Runs on the loop, one message at a time.

Poses are put together from LOCAL_POSITION_NED, ATTITUDE and GLOBAL_POSITION_INT, each at the time that it carries.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from hawk.comm.clock import Clock, OffsetEstimator
from hawk.comm.frames import Frames, OffsetWatch, anchor
from hawk.comm.mavlink_link import Message, SensorHealth
from hawk.comm.pose_buffer import Attitude, EkfPosition, PoseBuffer
from hawk.comm.rates import RateKeeper
from hawk.comm.status_texts import StatusTexts
from hawk.comm.vehicle import VehicleTopics
from hawk.model import (
    ArmPlace,
    BatteryInfo,
    Diagnostics,
    GlobalPose,
    LandedState,
    State,
    StatusText,
    VehiclePose,
)

_LOG = logging.getLogger(__name__)
_ARMED = 128  # MAV_MODE_FLAG_SAFETY_ARMED
_NOT_AN_AUTOPILOT = 8  # MAV_AUTOPILOT_INVALID
_BOOT_MATCH_S = 5
_REBOOT_S = 1.0
_FRESH_S = 1.0
_LANDED_WAIT_S = 3.0
_FIX_3D = 3  # GPS_FIX_TYPE_3D_FIX
_PROVISIONAL_MOVE_M = 10.0

LINK_LOST_S = 2.6
"""Real seconds without a HEARTBEAT after which the link counts as lost, as MAVSDK counts it."""


class Telemetry:
    """The newest of everything that the autopilot said, and the frames it is said in."""

    def __init__(
        self,
        clock: Clock,
        topics: VehicleTopics,
        rates: RateKeeper,
        sensor_health: Callable[[], SensorHealth],
        wall: Callable[[], float],
    ) -> None:
        self._clock = clock
        self._topics = topics
        self._rates = rates
        self._sensor_health = sensor_health
        self._wall = wall
        self._buffer = PoseBuffer()
        self._boot_clock = OffsetEstimator()
        self._texts = StatusTexts()
        self._watch = OffsetWatch()
        self._state = State()
        self._gps: tuple[int, int, float | None] | None = None
        self._global: tuple[float, GlobalPose] | None = None
        self._home: GlobalPose | None = None
        self._boot: tuple[float, int] | None = None  # newest time since boot (s), boot id
        self._datum: GlobalPose | None = None
        self._provisional: GlobalPose | None = None
        self._frames: Frames | None = None
        self._restored: ArmPlace | None = None
        self._anchor_from: float | None = None  # "armed" came at this moment and is not anchored yet
        self._was_armed_at_start = False
        self._handlers: dict[str, Callable[[Mapping[str, Any], float], None]] = {
            "HEARTBEAT": self._on_heartbeat,
            "EXTENDED_SYS_STATE": self._on_extended_state,
            "LOCAL_POSITION_NED": self._on_local_position,
            "ATTITUDE": self._on_attitude,
            "GLOBAL_POSITION_INT": self._on_global_position,
            "SYS_STATUS": self._on_sys_status,
            "GPS_RAW_INT": self._on_gps,
            "HOME_POSITION": self._on_home,
            "STATUSTEXT": self._on_text,
        }
        self.on_reboot: Callable[[], None] = lambda: None

    def handle(self, message: Message) -> None:
        """Take one message of the autopilot."""
        handler = self._handlers.get(message.name)
        if handler is None:
            return
        self._rates.seen(message.name, message.arrival)
        try:
            handler(message.fields, message.arrival)
        except (KeyError, TypeError, ValueError) as error:
            _LOG.warning("%s of the autopilot is not usable: %r", message.name, error)

    def check_link(self, now: float) -> bool:
        """Return whether the autopilot is heard, and publish when it fell silent."""
        lost = now - self._state.time > LINK_LOST_S * self._clock.speed
        if lost and self._state.connected:
            self._publish_state(replace(self._state, connected=False))
        return not lost

    def silence(self, now: float) -> float:
        """Return the seconds since the last HEARTBEAT, zero before the first."""
        return now - self._state.time if self._state.time > -math.inf else 0.0

    @property
    def state(self) -> State:
        """The autopilot's state as last heard."""
        return self._state

    @property
    def sure(self) -> bool:
        """Whether EKF-local is tied to the map: not for a moment after it leapt."""
        return self._watch.sure

    @property
    def connected(self) -> bool:
        """Whether HEARTBEATs come."""
        return self._state.connected

    def from_boot(self, seconds: float) -> float | None:
        """Return a time of the autopilot's boot clock on ours, None before that clock is known."""
        return None if self._boot is None else self._boot_clock.to_ours(seconds)

    @property
    def frames(self) -> Frames | None:
        """The tied frames, None before there is an arm place."""
        return self._frames

    @property
    def boot_ms(self) -> int:
        """Newest time since boot that the autopilot told, milliseconds."""
        return 0 if self._boot is None else int(self._boot[0] * 1000)

    @property
    def datum(self) -> GlobalPose | None:
        """Origin of the map frame."""
        return self._datum

    def set_datum(self, datum: GlobalPose | None) -> None:
        """Lay the map frame's origin; None: the next arm place becomes it."""
        self._datum = datum
        if self._frames is not None and datum is not None:
            self._frames = Frames.create(self._frames.arm, datum)
        elif datum is None:
            self._frames = None

    @property
    def fence_origin(self) -> GlobalPose | None:
        """The datum; before there is one the provisional origin: where the drone stands, to within 10 m."""
        return self._datum or self._provisional

    def restore_arm_place(self, place: ArmPlace) -> None:
        """Keep the arm place of an earlier run until the autopilot's boot is known, then take it or leave it."""
        self._restored = place
        self._try_restored()

    def reason_since(self, time: float) -> str | None:
        """Return the autopilot's own words since then that explain a refusal."""
        return self._texts.reason_since(time)

    def pose_at(self, time: float) -> VehiclePose | None:
        """Return the pose interpolated to that moment."""
        position = self._buffer.position_at(time)
        attitude = self._buffer.attitude_at(time)
        if position is None or attitude is None or not self._watch.sure:
            return None
        return self._compose(position, attitude)

    # --- state -----------------------------------------------------------------------------------------------------

    def _on_heartbeat(self, fields: Mapping[str, Any], arrival: float) -> None:
        if int(fields["autopilot"]) == _NOT_AN_AUTOPILOT:
            return
        armed = bool(int(fields["base_mode"]) & _ARMED)
        first = self._state.time == -math.inf
        if armed and not self._state.armed:
            self._anchor_from = arrival
            self._was_armed_at_start = first
        elif not armed:
            self._anchor_from = None
        state = State(True, armed, int(fields["custom_mode"]), self._state.landed, arrival)
        self._publish_state(state)

    def _on_extended_state(self, fields: Mapping[str, Any], _: float) -> None:
        try:
            landed = LandedState(int(fields["landed_state"]))
        except ValueError:
            landed = LandedState.UNDEFINED
        if landed is not self._state.landed:
            self._publish_state(replace(self._state, landed=landed))

    def _publish_state(self, state: State) -> None:
        self._state = state
        self._topics.state.publish(state)

    # --- pose ------------------------------------------------------------------------------------------------------

    def _on_local_position(self, fields: Mapping[str, Any], arrival: float) -> None:
        time = self._stamp(fields, arrival)
        sample = EkfPosition(time, *(_number(fields, name) for name in ("x", "y", "z", "vx", "vy", "vz")))
        last = self._buffer.latest_position
        if self._frames is not None and last is not None and _leaps(last, sample):
            _LOG.warning("The autopilot's position leapt; no pose is given until it is tied to the map again")
            self._watch.doubt()
            self._buffer.clear()
        self._buffer.add_position(sample)
        attitude = self._buffer.attitude_at(time)
        if attitude is not None and self._watch.sure:
            pose = self._compose(sample, attitude)
            if pose is not None:
                self._topics.pose.publish(pose)

    def _on_attitude(self, fields: Mapping[str, Any], arrival: float) -> None:
        time = self._stamp(fields, arrival)
        self._buffer.add_attitude(Attitude(time, *(_number(fields, name) for name in ("roll", "pitch", "yaw"))))

    def _on_global_position(self, fields: Mapping[str, Any], arrival: float) -> None:
        time = self._stamp(fields, arrival)
        if int(fields["lat"]) == 0 and int(fields["lon"]) == 0:
            return  # ArduPilot's "no position yet"
        here = GlobalPose(int(fields["lat"]) / 1e7, int(fields["lon"]) / 1e7, int(fields["alt"]) / 1e3)
        self._global = (time, here)
        self._move_provisional(here)
        position = self._buffer.position_at(time)
        if position is None or self._boot is None:
            return
        if self._anchor_from is not None:
            self._anchor(position, here)
        elif self._frames is not None:
            self._look(position, here)

    def _compose(self, position: EkfPosition, attitude: Attitude) -> VehiclePose | None:
        frames = self._frames
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

    def _stamp(self, fields: Mapping[str, Any], arrival: float) -> float:
        """Return the message's own time on our clock; notice a boot by a clock that runs backwards."""
        boot = _number(fields, "time_boot_ms") / 1000.0
        if self._boot is not None and boot < self._boot[0] - _REBOOT_S:
            self._rebooted()
        if self._boot is None:
            boot_id = round(self._wall() - boot / self._clock.speed)
            self._boot = (boot, boot_id)
            self._try_restored()
        self._boot = (max(boot, self._boot[0]), self._boot[1])
        return self._boot_clock.update(boot, arrival)

    def _rebooted(self) -> None:
        _LOG.warning("The autopilot has booted")
        self._boot = None
        self._boot_clock = OffsetEstimator()
        self._buffer.clear()
        self._watch = OffsetWatch()
        self._frames = None
        self._global = self._home = self._gps = None
        self._anchor_from = None
        self._publish_state(replace(self._state, armed=False, landed=LandedState.UNDEFINED))
        self._rates.forget()
        self.on_reboot()

    # --- frames ----------------------------------------------------------------------------------------------------

    def _anchor(self, position: EkfPosition, here: GlobalPose) -> None:
        """Tie the frames to where the drone was armed: here if it stands, else home as the autopilot tells it."""
        assert self._boot is not None  # noqa: S101
        assert self._anchor_from is not None  # noqa: S101
        if self._was_armed_at_start and self._frames is not None:
            self._anchor_from = None  # taken up from the journal
            return
        landed = self._state.landed
        if landed is LandedState.UNDEFINED and self._clock() - self._anchor_from < _LANDED_WAIT_S:
            return
        place = here if landed is LandedState.ON_GROUND else self._home
        if place is None or position.time < self._anchor_from - _FRESH_S:
            return
        self._anchor_from = None
        self._tie(anchor(position, here, place, self._boot[1]))

    def _tie(self, arm: ArmPlace) -> None:
        if self._datum is None:
            self._datum = GlobalPose(arm.latitude, arm.longitude, arm.altitude)
        self._frames = Frames.create(arm, self._datum)
        self._topics.arm_place.publish(arm)

    def _look(self, position: EkfPosition, here: GlobalPose) -> None:
        assert self._frames is not None  # noqa: S101
        jump = self._watch.look(self._frames.arm, position, here)
        if jump is None:
            return
        _LOG.warning("EKF-local jumped by %.1f m; anchored again", jump.metres)
        self._buffer.clear()
        self._tie(jump.arm)
        self._topics.frame_jump.publish(jump.metres)

    def _try_restored(self) -> None:
        if self._restored is None or self._boot is None:
            return
        place, self._restored = self._restored, None
        if self._frames is not None:
            return  # armed in this run: newer than what was kept
        if abs(place.boot_id - self._boot[1]) > _BOOT_MATCH_S:
            _LOG.info("The arm place of the earlier run is void: the autopilot has booted since")
            return
        self._tie(place)

    def _move_provisional(self, here: GlobalPose) -> None:
        old = self._provisional
        if old is None or (not self._state.armed and math.dist(_flat(here, old), (0.0, 0.0)) > _PROVISIONAL_MOVE_M):
            self._provisional = here

    # --- the rest --------------------------------------------------------------------------------------------------

    def _on_sys_status(self, fields: Mapping[str, Any], arrival: float) -> None:
        percentage, voltage, current = (
            int(fields[name]) for name in ("battery_remaining", "voltage_battery", "current_battery")
        )
        self._topics.battery.publish(
            BatteryInfo(
                percentage=float(percentage) if 0 <= percentage <= 100 else None,
                voltage=voltage / 1000.0 if 0 < voltage < 65535 else None,
                current=current / 100.0 if current >= 0 else None,
                time=arrival,
            )
        )
        self._publish_diagnostics(arrival)

    def _publish_diagnostics(self, arrival: float) -> None:
        health = self._sensor_health()
        fresh = self._gps is not None and self._rates.age("GPS_RAW_INT", arrival) < _LANDED_WAIT_S
        fix, satellites, accuracy = self._gps if fresh and self._gps is not None else (None, None, None)
        located = fix is not None and fix >= _FIX_3D  # MAVSDK's flags are cached: they outlive the fix by seconds
        self._topics.diagnostics.publish(
            Diagnostics(
                all_ok=health.all_ok and located,
                armable=health.armable,
                global_position_ok=health.global_position_ok and located,
                home_position_ok=health.home_position_ok,
                gps_fix=fix,
                satellites=satellites,
                horizontal_accuracy=accuracy,
                time=arrival,
            )
        )

    def _on_gps(self, fields: Mapping[str, Any], _: float) -> None:
        accuracy = int(fields.get("h_acc") or 0)
        self._gps = (
            int(fields["fix_type"]),
            int(fields["satellites_visible"]),
            accuracy / 1000.0 if accuracy else None,
        )

    def _on_home(self, fields: Mapping[str, Any], _: float) -> None:
        self._home = GlobalPose(
            int(fields["latitude"]) / 1e7, int(fields["longitude"]) / 1e7, int(fields["altitude"]) / 1e3
        )

    def _on_text(self, fields: Mapping[str, Any], arrival: float) -> None:
        text = self._texts.take(fields, arrival)
        if text is not None:
            self._topics.status_text.publish(text)

    def say(self, severity: int, text: str) -> None:
        """Publish words of our own among the autopilot's."""
        self._topics.status_text.publish(StatusText(self._clock(), severity, text))


def _number(fields: Mapping[str, Any], name: str) -> float:
    """Return a finite number (MAVSDK gives None for NaN). Raises ValueError naming the field."""
    value = fields[name]
    if value is None or not math.isfinite(value):
        raise ValueError(f"{name} is not a finite number")
    return float(value)


def _leaps(last: EkfPosition, sample: EkfPosition) -> bool:
    """Whether the drone would have had to be more than 1 m faster than it says to get from one to the other."""
    dt = sample.time - last.time
    if not 0 < dt < _FRESH_S:
        return False
    predicted = [
        p + (a + b) / 2 * dt
        for p, a, b in ((last.x, last.vx, sample.vx), (last.y, last.vy, sample.vy), (last.z, last.vz, sample.vz))
    ]
    return math.dist(predicted, (sample.x, sample.y, sample.z)) > 1.0


def _flat(place: GlobalPose, origin: GlobalPose) -> tuple[float, float]:
    """Return metres north and east, good to a percent within a kilometre."""
    metres = 111_320.0
    return (
        (place.latitude - origin.latitude) * metres,
        (place.longitude - origin.longitude) * metres * math.cos(math.radians(origin.latitude)),
    )
