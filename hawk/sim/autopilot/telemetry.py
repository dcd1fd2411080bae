"""Telemetry of the autopilot as MAVLink messages."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from typing import Any

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.sim.autopilot.autopilot import Autopilot
from hawk.sim.autopilot.modes import Phase
from hawk.sim.geometry import Vector, subtract

Message = Any
"""A pymavlink message (the package has no types)."""

_ALWAYS_HEALTHY = (
    mavlink.MAV_SYS_STATUS_SENSOR_3D_GYRO
    | mavlink.MAV_SYS_STATUS_SENSOR_3D_ACCEL
    | mavlink.MAV_SYS_STATUS_SENSOR_ABSOLUTE_PRESSURE
    | mavlink.MAV_SYS_STATUS_SENSOR_ANGULAR_RATE_CONTROL
    | mavlink.MAV_SYS_STATUS_SENSOR_ATTITUDE_STABILIZATION
    | mavlink.MAV_SYS_STATUS_SENSOR_YAW_POSITION
    | mavlink.MAV_SYS_STATUS_SENSOR_MOTOR_OUTPUTS
)
_SENSORS = (
    _ALWAYS_HEALTHY
    | mavlink.MAV_SYS_STATUS_SENSOR_3D_MAG
    | mavlink.MAV_SYS_STATUS_SENSOR_GPS
    | mavlink.MAV_SYS_STATUS_SENSOR_Z_ALTITUDE_CONTROL
    | mavlink.MAV_SYS_STATUS_SENSOR_XY_POSITION_CONTROL
    | mavlink.MAV_SYS_STATUS_SENSOR_RC_RECEIVER
    | mavlink.MAV_SYS_STATUS_AHRS
    | mavlink.MAV_SYS_STATUS_SENSOR_BATTERY
    | mavlink.MAV_SYS_STATUS_GEOFENCE
    | mavlink.MAV_SYS_STATUS_PREARM_CHECK
)
_CAPABILITIES = (
    mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_FLOAT
    | mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_FLOAT
    | mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_INT
    | mavlink.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
    | mavlink.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED
    | mavlink.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_GLOBAL_INT
    | mavlink.MAV_PROTOCOL_CAPABILITY_FLIGHT_TERMINATION
    | mavlink.MAV_PROTOCOL_CAPABILITY_MAVLINK2
    | mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_FENCE
    | mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_RALLY
)
_VERSION = (4 << 24) | (6 << 16) | (0 << 8) | 255
"""Flight software 4.6.0, FIRMWARE_VERSION_TYPE_OFFICIAL."""


def build(message_id: int, autopilot: Autopilot) -> Message | None:
    """Return a message, None when it is unknown or needs a position that the autopilot does not have yet."""
    builder = BUILDERS.get(message_id)
    return None if builder is None else builder(autopilot)


def heartbeat(autopilot: Autopilot) -> Message:
    """Return the HEARTBEAT."""
    base = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED | mavlink.MAV_MODE_FLAG_STABILIZE_ENABLED
    base |= mavlink.MAV_MODE_FLAG_MANUAL_INPUT_ENABLED
    if autopilot.mode.needs_position:
        base |= mavlink.MAV_MODE_FLAG_GUIDED_ENABLED
    if autopilot.armed:
        base |= mavlink.MAV_MODE_FLAG_SAFETY_ARMED
    status = mavlink.MAV_STATE_ACTIVE if autopilot.armed and not autopilot.landed else mavlink.MAV_STATE_STANDBY
    failsafes = autopilot.failsafes
    if autopilot.armed and (failsafes.gcs or failsafes.radio or failsafes.battery or failsafes.ekf):
        status = mavlink.MAV_STATE_CRITICAL
    return mavlink.MAVLink_heartbeat_message(
        mavlink.MAV_TYPE_QUADROTOR, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, base, int(autopilot.mode.number), status, 3
    )


def _milliseconds(autopilot: Autopilot) -> int:
    return int(autopilot.time_boot * 1000.0 + 1e-6)


def _geodetic(autopilot: Autopilot, place: Vector) -> tuple[int, int, int]:
    """Return latitude and longitude (1e-7 degrees) and altitude (millimetres) of a place in the world."""
    latitude, longitude, altitude = autopilot.origin.to_geodetic(place)
    return round(latitude * 1e7), round(longitude * 1e7), round(altitude * 1000)


def _sys_status(autopilot: Autopilot) -> Message:
    health = _ALWAYS_HEALTHY | mavlink.MAV_SYS_STATUS_SENSOR_Z_ALTITUDE_CONTROL
    for bit, healthy in (
        (mavlink.MAV_SYS_STATUS_SENSOR_GPS, autopilot.estimator.healthy),
        (mavlink.MAV_SYS_STATUS_SENSOR_3D_MAG, not autopilot.compasses.failed),
        (mavlink.MAV_SYS_STATUS_SENSOR_XY_POSITION_CONTROL, autopilot.position_ok),
        (mavlink.MAV_SYS_STATUS_AHRS, autopilot.position_ok),
        (mavlink.MAV_SYS_STATUS_SENSOR_RC_RECEIVER, autopilot.radio.report.was_heard and not autopilot.failsafes.radio),
        (mavlink.MAV_SYS_STATUS_SENSOR_BATTERY, not autopilot.failsafes.battery),
        (mavlink.MAV_SYS_STATUS_GEOFENCE, not autopilot.failsafes.fence),
        (mavlink.MAV_SYS_STATUS_PREARM_CHECK, autopilot.pre_arm_ok),
    ):
        health |= bit if healthy else 0
    present = enabled = _SENSORS
    if not autopilot.radio.report.was_heard:
        present = enabled = _SENSORS & ~mavlink.MAV_SYS_STATUS_SENSOR_RC_RECEIVER
    if not (autopilot.fence.is_on(autopilot.parameters) and autopilot.parameters["FENCE_ACTION"]):
        enabled &= ~mavlink.MAV_SYS_STATUS_GEOFENCE
    battery = autopilot.battery
    return mavlink.MAVLink_sys_status_message(
        present,
        enabled,
        health,
        120,
        round(battery.voltage * 1000),
        round(battery.current * 100),
        math.ceil(battery.remaining * 100),
        0,
        0,
        0,
        0,
        0,
        0,
    )


def _gps_raw(autopilot: Autopilot) -> Message:
    estimator = autopilot.estimator
    fixed = estimator.fix_type >= 3
    north, east, _ = autopilot.estimate.velocity
    course = math.degrees(math.atan2(east, north)) % 360.0
    accuracy = round(estimator.horizontal_accuracy * 1000)
    return mavlink.MAVLink_gps_raw_int_message(
        int(autopilot.time_boot * 1e6),
        estimator.fix_type,
        *(_geodetic(autopilot, estimator.measured(autopilot.body)) if fixed else (0, 0, 0)),
        80 if fixed else 9999,
        120 if fixed else 9999,
        round(math.hypot(north, east) * 100) if fixed else 0,
        round(course * 100) % 36000 if fixed else 0,
        estimator.satellites,
        h_acc=accuracy,
        v_acc=accuracy * 2,
        vel_acc=200,
    )


def _global_position(autopilot: Autopilot) -> Message | None:
    if autopilot.home is None:
        return None
    estimate = autopilot.estimate
    return mavlink.MAVLink_global_position_int_message(
        _milliseconds(autopilot),
        *_geodetic(autopilot, estimate.position),
        round((autopilot.home[2] - estimate.position[2]) * 1000),
        *(round(value * 100) for value in estimate.velocity),
        round(math.degrees(estimate.yaw) % 360.0 * 100) % 36000,
    )


def _local_position(autopilot: Autopilot) -> Message | None:
    local = autopilot.local_position
    if local is None:
        return None
    return mavlink.MAVLink_local_position_ned_message(_milliseconds(autopilot), *local, *autopilot.estimate.velocity)


def _attitude(autopilot: Autopilot) -> Message:
    estimate = autopilot.estimate
    return mavlink.MAVLink_attitude_message(
        _milliseconds(autopilot), estimate.roll, estimate.pitch, estimate.yaw, 0.0, 0.0, estimate.yaw_rate
    )


def _attitude_quaternion(autopilot: Autopilot) -> Message:
    estimate = autopilot.estimate
    cr, sr = math.cos(estimate.roll / 2), math.sin(estimate.roll / 2)
    cp, sp = math.cos(estimate.pitch / 2), math.sin(estimate.pitch / 2)
    cy, sy = math.cos(estimate.yaw / 2), math.sin(estimate.yaw / 2)
    return mavlink.MAVLink_attitude_quaternion_message(
        _milliseconds(autopilot),
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        0.0,
        0.0,
        estimate.yaw_rate,
    )


def _extended_state(autopilot: Autopilot) -> Message:
    states = {
        None: mavlink.MAV_LANDED_STATE_ON_GROUND,
        Phase.FLYING: mavlink.MAV_LANDED_STATE_IN_AIR,
        Phase.TAKING_OFF: mavlink.MAV_LANDED_STATE_TAKEOFF,
        Phase.LANDING: mavlink.MAV_LANDED_STATE_LANDING,
    }
    return mavlink.MAVLink_extended_sys_state_message(mavlink.MAV_VTOL_STATE_UNDEFINED, states[autopilot.phase])


def _home_position(autopilot: Autopilot) -> Message | None:
    if autopilot.home is None or autopilot.ekf_origin is None:
        return None
    return mavlink.MAVLink_home_position_message(
        *_geodetic(autopilot, autopilot.home),
        *subtract(autopilot.home, autopilot.ekf_origin),
        [1.0, 0.0, 0.0, 0.0],
        0.0,
        0.0,
        0.0,
        int(autopilot.time_boot * 1e6),
    )


def _gps_origin(autopilot: Autopilot) -> Message | None:
    if autopilot.ekf_origin is None:
        return None
    place = _geodetic(autopilot, autopilot.ekf_origin)
    return mavlink.MAVLink_gps_global_origin_message(*place, int(autopilot.time_boot * 1e6))


def _battery_status(autopilot: Autopilot) -> Message:
    battery = autopilot.battery
    return mavlink.MAVLink_battery_status_message(
        0,
        mavlink.MAV_BATTERY_FUNCTION_ALL,
        mavlink.MAV_BATTERY_TYPE_LIPO,
        32767,
        [round(battery.voltage * 1000)] + [65535] * 9,
        round(battery.current * 100),
        round(battery.used_mah),
        -1,
        math.ceil(battery.remaining * 100),
    )


def _vfr_hud(autopilot: Autopilot) -> Message:
    estimate = autopilot.estimate
    speed = math.hypot(estimate.velocity[0], estimate.velocity[1])
    altitude = autopilot.origin.altitude - estimate.position[2]
    heading = int(math.degrees(estimate.yaw) % 360.0)
    throttle = 0 if autopilot.landed else 40
    return mavlink.MAVLink_vfr_hud_message(speed, speed, heading, throttle, altitude, -estimate.velocity[2])


def _ekf_status(autopilot: Autopilot) -> Message:
    """Flags and variances as a real ArduCopter gives them with GNSS, without it, and with one that is off."""
    estimator = autopilot.estimator
    flags = mavlink.EKF_ATTITUDE | mavlink.EKF_VELOCITY_VERT | mavlink.EKF_POS_VERT_ABS
    if autopilot.position_ok:
        flags |= mavlink.EKF_VELOCITY_HORIZ | mavlink.EKF_POS_HORIZ_REL | mavlink.EKF_POS_HORIZ_ABS
        flags |= mavlink.EKF_PRED_POS_HORIZ_REL | mavlink.EKF_PRED_POS_HORIZ_ABS
    elif not estimator.aids:
        flags |= mavlink.EKF_VELOCITY_HORIZ | mavlink.EKF_CONST_POS_MODE
    if estimator.glitch.is_reported:
        flags |= mavlink.EKF_GPS_GLITCHING
    horizontal = 0.01 + estimator.glitch.variance
    return mavlink.MAVLink_ekf_status_report_message(
        flags, 0.01, horizontal, 0.01, 0.02 + estimator.heading.variance, 0.0
    )


def _system_time(autopilot: Autopilot) -> Message:
    moment = autopilot.utc_s
    return mavlink.MAVLink_system_time_message(0 if moment is None else round(moment * 1e6), _milliseconds(autopilot))


def _wind(autopilot: Autopilot) -> Message:
    source = math.degrees(autopilot.wind.heading) + 180.0
    return mavlink.MAVLink_wind_message((source + 180.0) % 360.0 - 180.0, autopilot.wind.speed, 0.0)


def _rc_channels(autopilot: Autopilot) -> Message:
    """Return the last pulses: they stay when the receiver is lost, as on a real ArduCopter."""
    radio = autopilot.radio.report
    rest = [0] * (18 - len(radio.pulses))
    return mavlink.MAVLink_rc_channels_message(_milliseconds(autopilot), radio.channels, *radio.pulses, *rest, 255)


def _fence_status(autopilot: Autopilot) -> Message:
    breach = autopilot.failsafes.fence
    return mavlink.MAVLink_fence_status_message(int(bool(breach)), 0, int(breach), 0)


def _scaled_imu(autopilot: Autopilot) -> Message:
    estimate = autopilot.estimate
    tilt = (math.sin(estimate.pitch), -math.sin(estimate.roll), -math.cos(estimate.roll) * math.cos(estimate.pitch))
    return mavlink.MAVLink_scaled_imu_message(
        _milliseconds(autopilot),
        *(round(value * 1000) for value in tilt),
        0,
        0,
        round(estimate.yaw_rate * 1000),
        0,
        0,
        0,
    )


def _distance_sensor(autopilot: Autopilot) -> Message | None:
    sensor = autopilot.rangefinder
    if not sensor.is_there:
        return None
    return mavlink.MAVLink_distance_sensor_message(
        _milliseconds(autopilot),
        *sensor.limits_cm,
        sensor.measure_cm(autopilot.body, autopilot.options.slope),
        mavlink.MAV_DISTANCE_SENSOR_UNKNOWN,
        0,
        mavlink.MAV_SENSOR_ROTATION_PITCH_270,
        0,
    )


def _rangefinder(autopilot: Autopilot) -> Message | None:
    sensor = autopilot.rangefinder
    if not sensor.is_there:
        return None
    return mavlink.MAVLink_rangefinder_message(sensor.measure_cm(autopilot.body, autopilot.options.slope) / 100.0, 0.0)


def _autopilot_version(_: Autopilot) -> Message:
    middle = list(struct.pack("8s", b"hawk-sim"))
    return mavlink.MAVLink_autopilot_version_message(
        _CAPABILITIES, _VERSION, 0, 0, 0, middle, middle, middle, 0, 0, 0x6861776B
    )


BUILDERS: dict[int, Callable[[Autopilot], Message | None]] = {
    mavlink.MAVLINK_MSG_ID_HEARTBEAT: heartbeat,
    mavlink.MAVLINK_MSG_ID_SYS_STATUS: _sys_status,
    mavlink.MAVLINK_MSG_ID_SYSTEM_TIME: _system_time,
    mavlink.MAVLINK_MSG_ID_GPS_RAW_INT: _gps_raw,
    mavlink.MAVLINK_MSG_ID_SCALED_IMU: _scaled_imu,
    mavlink.MAVLINK_MSG_ID_ATTITUDE: _attitude,
    mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION: _attitude_quaternion,
    mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: _local_position,
    mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: _global_position,
    mavlink.MAVLINK_MSG_ID_MISSION_CURRENT: lambda _: mavlink.MAVLink_mission_current_message(0),
    mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN: _gps_origin,
    mavlink.MAVLINK_MSG_ID_RC_CHANNELS: _rc_channels,
    mavlink.MAVLINK_MSG_ID_VFR_HUD: _vfr_hud,
    mavlink.MAVLINK_MSG_ID_BATTERY_STATUS: _battery_status,
    mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION: _autopilot_version,
    mavlink.MAVLINK_MSG_ID_FENCE_STATUS: _fence_status,
    mavlink.MAVLINK_MSG_ID_WIND: _wind,
    mavlink.MAVLINK_MSG_ID_EKF_STATUS_REPORT: _ekf_status,
    mavlink.MAVLINK_MSG_ID_HOME_POSITION: _home_position,
    mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: _extended_state,
    mavlink.MAVLINK_MSG_ID_DISTANCE_SENSOR: _distance_sensor,
    mavlink.MAVLINK_MSG_ID_RANGEFINDER: _rangefinder,
}
"""Every message that this autopilot can send on request. ArduPilot does not send ALTITUDE."""
