"""The simulated ArduCopter: modes, arming, targets and failsafes around the flying body. It knows no MAVLink."""

from __future__ import annotations

import contextlib
import logging
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hawk.sim.autopilot.control import Controller, Limits, Setpoint
from hawk.sim.autopilot.failsafes import ArmingView, Failsafes, Fallback, Watched, arming_reasons, pre_arm_reasons
from hawk.sim.autopilot.fence import Fence, FenceItem, FenceType
from hawk.sim.autopilot.gps import Estimate, Estimator
from hawk.sim.autopilot.modes import MODES, Guided, Mode, ModeInputs, ModeNumber, Phase, Stabilize
from hawk.sim.autopilot.parameters import AutopilotOptions, Parameters, copter_parameters
from hawk.sim.autopilot.radio import Radio
from hawk.sim.autopilot.rally import Rally, RallyPlace, RallyPoint
from hawk.sim.autopilot.sensors import SIMULATED, Barometer, Battery, Compasses, Rangefinder, Receiver
from hawk.sim.geometry import Origin, Vector, add, subtract
from hawk.sim.vehicle import GRAVITY, Body, Demand, Wind, step_body

log = logging.getLogger(__name__)

STEP_S = 0.01
"""Length of a physics step, simulated seconds."""
FAILSAFE_PERIOD_S = 0.1
LAND_DETECT_S = 1.0
CRASH_DISARM_S = 2.0
PRE_ARM_PERIOD_S = 30.0
"""Between two reports of the reasons against arming, while disarmed."""
TEXTS_KEPT = 50
EMERGENCY, CRITICAL, WARNING, INFO = 0, 2, 4, 6
"""MAV_SEVERITY."""


@dataclass(frozen=True, slots=True)
class Text:
    """A STATUSTEXT that waits to be sent."""

    severity: int
    text: str


class RefusedError(Exception):
    """The autopilot refuses a command: it answers FAILED, and sends its reason, if it gives one, as STATUSTEXT."""


class Autopilot:
    """Everything on board. `step` moves it; commands act at once and raise RefusedError."""

    def __init__(self, options: AutopilotOptions, origin: Origin, rng: np.random.Generator) -> None:
        self.options = options
        self.origin = origin
        self._rng = rng
        self.parameters: Parameters = copter_parameters(options.gcs_parameter)
        if options.rangefinder_m:
            self.parameters.set("RNGFND1_TYPE", SIMULATED)
            self.parameters.set("RNGFND1_MAX", options.rangefinder_m)
        self.rangefinder = Rangefinder(self.parameters)
        self.fence = Fence()
        self.battery = Battery(options.battery_minutes, options.battery_cells)
        self.gnss = Receiver((*options.gnss_bias, 0.0))
        self.barometer = Barometer()
        self.compasses = Compasses(options.compass_error)
        self.rally = Rally(self.parameters)
        self.wind = Wind(options.wind, options.wind_heading, rng)
        self.body = Body(position=(options.start[0], options.start[1], 0.0), yaw=options.yaw)
        self.radio_present = True
        self.stick = 0.0
        self.radio = Radio()
        self.time = 0.0
        self.stopped = ""
        self.boots = 0
        self.texts: list[Text] = []
        self.estimator: Estimator
        self.boot()

    def boot(self) -> None:
        """Start the autopilot's program: only parameters, fence, rally points, body and the sensors' errors survive."""
        self.boot_time = self.time
        self.stopped = ""
        self.armed = False
        self.landed = True
        self.boots += 1
        self.fence.boot()
        self.rangefinder.boot()
        self.radio.boot()
        self.mode_changes = 0
        sigma, wait = self.options.gnss_sigma, self.options.gnss_wait_s
        self.barometer.boot()
        self.battery.restart_counter()
        self.estimator = Estimator(sigma, wait, self._rng, self.gnss, self.barometer, self.compasses)
        self.failsafes = Failsafes(self.parameters, self.say, self._react, self.options.real_time_factor)
        self.ekf_origin: Vector | None = None
        self.home: Vector | None = None
        self._home_locked = False
        self._controller = Controller()
        self._setpoint = Setpoint(idle=True)
        self._limits = Limits.of(self.parameters)
        self._gcs_time: float | None = None
        self._grounded_since: float | None = None
        self._armed_on_ground_since = self.time
        self._next_failsafe = self.time
        self._glitches = False
        self._yaw_resets = 0
        self._crash_time: float | None = None
        self._next_pre_arm = self.time + PRE_ARM_PERIOD_S
        self.estimate: Estimate = self.estimator.step(self.body, 0.0)
        self.mode: Mode = Stabilize(self._view())
        self.say(INFO, "ArduCopter V4.6.0 (hawk-sim)")

    @property
    def time_boot(self) -> float:
        """Seconds since boot."""
        return self.time - self.boot_time

    @property
    def utc_s(self) -> float | None:
        """Moment by GNSS, Unix seconds; None before the first good position since the boot."""
        start = self.options.utc_s
        return None if start is None or self.ekf_origin is None else start + self.time

    @property
    def gcs_id(self) -> int:
        """System id of the ground station that the failsafe watches."""
        name = "SYSID_MYGCS" if "SYSID_MYGCS" in self.parameters else "MAV_GCS_SYSID"
        return self.parameters.flag(name)

    @property
    def position_ok(self) -> bool:
        """True while modes that need a position may be flown."""
        return self.estimator.healthy and self.ekf_origin is not None

    @property
    def local_position(self) -> Vector | None:
        """EKF-local position (NED metres), None before the EKF has an origin."""
        return None if self.ekf_origin is None else subtract(self.estimate.position, self.ekf_origin)

    @property
    def phase(self) -> Phase | None:
        """Phase of the flight, None on the ground."""
        return None if self.landed else self.mode.phase

    def step(self, dt: float = STEP_S) -> None:
        """Move everything on by ``dt`` simulated seconds."""
        self.time += dt
        wind = self.wind.step(dt)
        self.estimate = self.estimator.step(self.body, dt)
        self._take_reset()
        if self.ekf_origin is None and self.estimator.healthy:
            self.ekf_origin = self.home = self.estimate.position
            self.say(INFO, "EKF3 IMU0 origin set")
        demand = self._fly(dt) if self.armed and not self.stopped and not self.battery.is_empty else Demand()
        self.body = step_body(self.body, demand, wind, dt, self.options.slope)
        lifting = demand.motors and not demand.idle
        self.battery.step(lifting, max(0.0, 1.0 - self.body.climb_force / GRAVITY), dt)
        if not self.stopped:
            self._follow_switch()
            self._watch()

    def _follow_switch(self) -> None:
        mode = self.radio.step(self.parameters, self.radio_present, self.stick, self.time)
        if mode is not None:
            with contextlib.suppress(RefusedError):  # it says why by itself
                self.set_mode(mode)

    def _take_reset(self) -> None:
        """Move the place that the mode itself chose with the estimate, as ArduCopter does, and report a glitch."""
        reset = self.estimator.take_reset()
        if any(reset):
            self.mode.reset_position(reset)
        if self.estimator.glitch.is_reported != self._glitches:
            self._glitches = self.estimator.glitch.is_reported
            self.say(CRITICAL, "GPS Glitch or Compass error" if self._glitches else "Glitch cleared")
        if self.estimator.yaw_resets > self._yaw_resets:
            self._yaw_resets = self.estimator.yaw_resets
            self.say(WARNING, "EKF3 IMU0 emergency yaw reset")

    def _fly(self, dt: float) -> Demand:
        self._setpoint = self.mode.run(self._view())
        demand = self._controller.update(self.estimate, self._setpoint, self._limits, dt)
        return demand.turned(-self.estimator.heading.error)

    def _watch(self) -> None:
        self._detect_landing()
        self._watch_crash()
        if self.time >= self._next_failsafe:
            self._next_failsafe = self.time + FAILSAFE_PERIOD_S
            self._limits = Limits.of(self.parameters)
            self.failsafes.step(self._watched())
        if not self.armed and self.time >= self._next_pre_arm:
            self._next_pre_arm = self.time + PRE_ARM_PERIOD_S
            self.report_pre_arm()

    # Commands

    def arm(self, force: bool = False) -> None:
        """Arm, without checks when forced. Raises RefusedError after sending every reason as STATUSTEXT."""
        if self.armed:
            return
        reasons = [] if force else arming_reasons(self._arming_view())
        for reason in reasons:
            self.say(CRITICAL, f"Arm: {reason}")
        if reasons:
            raise RefusedError("; ".join(reasons))
        self.armed = True
        self._armed_on_ground_since = self.time
        self._controller.reset()
        if self.position_ok and not self._home_locked:
            self.home = self.estimate.position
        self.mode = type(self.mode)(self._view())
        self.say(INFO, "Arming motors")

    def disarm(self, force: bool = False) -> None:
        """Disarm. Raises RefusedError in the air unless forced: then the motors stop at once."""
        if not self.armed:
            return
        if not force and not self.landed:
            raise RefusedError("in the air")
        self.armed = False
        self.landed = True
        self.say(INFO, "Disarming motors")

    def terminate(self) -> None:
        """Cut the motors at once, in the air too."""
        if self.armed:
            self.say(EMERGENCY, "Terminating due to GCS request")
        self.disarm(force=True)

    def set_mode(self, number: int) -> None:
        """Change the flight mode. Raises RefusedError for one that is not known or cannot be flown at present."""
        if number == self.mode.number:
            return
        kind = MODES.get(number)
        if kind is None:
            self.say(WARNING, f"No such mode {number}")
            raise RefusedError(f"no such mode {number}")
        if self.armed and kind.needs_position and not self.position_ok:
            self.say(WARNING, f"Mode change to {kind.number.name} failed: requires position")
            raise RefusedError("requires position")
        self.mode = kind(self._view())
        self._controller.reset(self.estimate)
        self.mode_changes += 1

    def take_off(self, height: float) -> None:
        """Climb to ``height`` metres above home. Raises RefusedError unless armed on the ground in GUIDED."""
        if not (self.armed and self.landed and isinstance(self.mode, Guided) and self.home and self.position_ok):
            raise RefusedError("not armed on the ground in GUIDED")
        if not math.isfinite(height) or height <= 0.0:
            raise RefusedError("no height to climb to")
        self.mode.take_off(self._view(), self.home[2] - height)

    def fly_to(self, place: Vector, yaw: float | None, *, strict: bool = False) -> None:
        """Take a GUIDED target (NED metres in the world), silently ignored outside the fence or in another mode.

        ``strict`` raises RefusedError instead. A target that is not finite stops the autopilot's program.
        """
        if not isinstance(self.mode, Guided) or self.home is None:
            if strict:
                raise RefusedError("not in GUIDED")
            return
        if not all(map(math.isfinite, place)) or (yaw is not None and not math.isfinite(yaw)):
            if math.dist(place, self.mode.target) > 0.0 or math.isnan(sum(place)):
                self.crash_program("a GUIDED target that is not finite")
            return
        if self.fence.breaches(place, self.home, self.parameters):
            if strict:
                raise RefusedError("outside the fence")
            return
        self.mode.go((place[0], place[1]), place[2], yaw, self._view())

    def fly_velocity(self, velocity: Vector, yaw: float | None) -> None:
        """Take a GUIDED velocity (NED, m/s); ignored in another mode."""
        if not isinstance(self.mode, Guided):
            return
        if not all(map(math.isfinite, velocity)) or (yaw is not None and not math.isfinite(yaw)):
            self.crash_program("a GUIDED velocity that is not finite")
            return
        self.mode.move(velocity, yaw, self._view())

    def turn_to(self, yaw: float) -> None:
        """Turn to a heading in GUIDED. Raises RefusedError in another mode."""
        if not isinstance(self.mode, Guided) or not math.isfinite(yaw):
            raise RefusedError("not in GUIDED")
        self.mode.turn(yaw)

    def set_speed(self, speed: float) -> None:
        """Set the travel speed in GUIDED, m/s. Raises RefusedError in another mode."""
        if not isinstance(self.mode, Guided) or not speed > 0.0 or not math.isfinite(speed):
            raise RefusedError("not in GUIDED")
        self.mode.speed = speed

    def set_home(self, place: Vector) -> None:
        """Move home (NED metres in the world). From now on arming does not move it, until a boot."""
        self.home, self._home_locked = place, True

    def beside_home(self, north: float, east: float) -> tuple[float, float]:
        """Return latitude and longitude of a place, metres from home. Raises RefusedError without a home."""
        if self.home is None:
            raise RefusedError("no home yet")
        return self.origin.to_geodetic((self.home[0] + north, self.home[1] + east, 0.0))[:2]

    def load_fence(self, items: Sequence[FenceItem]) -> None:
        """Store an uploaded fence (it does not enable it). Raises FenceError."""
        places = [self.origin.to_world(item.latitude, item.longitude, self.origin.altitude)[:2] for item in items]
        self.fence.load(items, places)
        self.parameters.set("FENCE_TOTAL", len(items))

    def load_rally(self, points: Sequence[RallyPoint]) -> None:
        """Store uploaded rally points; none: they are cleared."""
        places = [self.origin.to_world(p.latitude, p.longitude, self.origin.altitude)[:2] for p in points]
        self.rally.load(points, places)

    def reboot(self) -> None:
        """Start the program again. Raises RefusedError while armed."""
        if self.armed:
            raise RefusedError("armed")
        self.boot()

    # Events

    def note_gcs(self, system_id: int) -> None:
        """Take a heartbeat of a ground station."""
        highest = self.parameters.flag("MAV_GCS_SYSID_HI") if "MAV_GCS_SYSID_HI" in self.parameters else 0
        if self.gcs_id <= system_id <= max(self.gcs_id, highest):
            self._gcs_time = self.time

    def crash_program(self, why: str) -> None:
        """End the autopilot's program: it sends nothing more and its motors stop."""
        log.error("the simulated autopilot's program crashed: %s", why)
        self.stopped = why

    def shift_ekf_origin(self, shift: Vector) -> None:
        """Move EKF-local against the world (an EKF reset); the vehicle itself does not move."""
        if self.ekf_origin is not None:
            self.ekf_origin = add(self.ekf_origin, shift)

    def repair(self) -> None:
        """Put a crashed vehicle upright where it lies."""
        if self.body.crashed:
            self.body = replace(self.body, roll=0.0, pitch=0.0, crashed=False)

    def say(self, severity: int, text: str) -> None:
        """Queue a STATUSTEXT."""
        self.texts.append(Text(severity, text))
        del self.texts[:-TEXTS_KEPT]

    def report_pre_arm(self) -> None:
        """Queue a STATUSTEXT for each reason against arming."""
        for reason in pre_arm_reasons(self._arming_view()):
            self.say(CRITICAL, f"PreArm: {reason}")

    @property
    def pre_arm_ok(self) -> bool:
        """The PREARM bit of SYS_STATUS: True when the present mode may be armed."""
        return not pre_arm_reasons(self._arming_view())

    # Internals

    def _view(self) -> ModeInputs:
        ceiling = None
        if self.fence.is_on(self.parameters) and self.parameters.flag("FENCE_TYPE") & FenceType.ALT_MAX:
            ceiling = self.parameters["FENCE_ALT_MAX"] - self.parameters["FENCE_MARGIN"]
        return ModeInputs(
            time=self.time,
            estimate=self.estimate,
            parameters=self.parameters,
            limits=self._limits,
            home=self.home or self.estimate.position,
            rally=self._rally(),
            landed=self.landed,
            position_ok=self.position_ok,
            stick=self.stick if self.radio_present else None,
            ceiling=ceiling,
        )

    def _rally(self) -> RallyPlace | None:
        """Return where RTL goes in place of home; a point outside the fence does not count, as in ArduCopter."""
        if self.home is None or not self.rally.places:
            return None

        def allowed(place: RallyPlace) -> bool:
            at = (place.place[0], place.place[1], self.home[2] - place.height) if self.home else (0.0, 0.0, 0.0)
            return self.home is not None and not self.fence.breaches(at, self.home, self.parameters)

        return self.rally.nearest(self.estimate.position[:2], self.home[:2], allowed)

    def _arming_view(self) -> ArmingView:
        return ArmingView(
            mode_name=self.mode.name,
            mode_arms=self.mode.arms,
            mode_needs_position=self.mode.needs_position,
            position_ok=self.position_ok,
            home_set=self.home is not None,
            radio_failsafe=self.failsafes.radio,
            gcs_failsafe=self.failsafes.gcs,
            battery_failsafe=self.failsafes.battery,
            battery_voltage=self.battery.voltage,
            battery_arm_voltage=self.parameters["BATT_ARM_VOLT"],
            fence_enabled=self.fence.is_on(self.parameters),
            fence_breaches=self._breaches(),
            throttle_high=self.radio_present and self.stick > 0.05,
            crashed=self.body.crashed,
            compasses_healthy=not self.compasses.failed,
        )

    def _breaches(self) -> FenceType:
        if self.home is None:
            return FenceType.NONE
        return self.fence.breaches(self.estimate.position, self.home, self.parameters)

    def _watched(self) -> Watched:
        return Watched(
            time=self.time,
            armed=self.armed,
            landed=self.landed,
            mode=self.mode.number,
            pilot_flies=self.mode.pilot_flies,
            needs_position=self.mode.needs_position,
            gcs_silent_s=None if self._gcs_time is None else self.time - self._gcs_time,
            radio_present=self.radio_present,
            position_ok=self.position_ok,
            voltage=self.battery.voltage,
            used_mah=self.battery.used_mah,
            breaches=self._breaches(),
        )

    def _detect_landing(self) -> None:
        if not self.armed:
            self.landed = True
            return
        sinks = self._setpoint.idle or (self._setpoint.down is None and self._setpoint.climb <= 0.0)
        below = self._setpoint.down is not None and self._setpoint.down > self.estimate.position[2]
        if not self.body.on_ground:
            self.landed, self._grounded_since = False, None
        elif self.landed:
            self._auto_disarm(lifting=not self._setpoint.idle)
        elif sinks or below:
            self._grounded_since = self._grounded_since or self.time
            if self.time - self._grounded_since >= LAND_DETECT_S:
                self.landed = True
                self._armed_on_ground_since = self.time
                if self.mode.disarms_when_landed:
                    self.disarm()

    def _auto_disarm(self, lifting: bool) -> None:
        delay = self.parameters["DISARM_DELAY"]
        if lifting:
            self._armed_on_ground_since = self.time
        elif self.mode.disarms_when_landed or 0.0 < delay <= self.time - self._armed_on_ground_since:
            self.disarm()

    def _watch_crash(self) -> None:
        if not (self.body.crashed and self.armed):
            self._crash_time = None
            return
        self._crash_time = self._crash_time or self.time
        if self.time - self._crash_time >= CRASH_DISARM_S:
            self.say(EMERGENCY, "Crash: Disarming: AngErr=180>30, Accel=0.0<3.0")
            self.disarm(force=True)

    def _react(self, reaction: Fallback) -> None:
        """Perform a failsafe's action: on the ground disarm, without a position land."""
        if reaction is Fallback.NOTHING or not self.armed:
            return
        if reaction is Fallback.TERMINATE:
            self.terminate()
        elif self.landed:
            self.disarm()
        elif reaction is Fallback.LAND or not self.position_ok:
            self.set_mode(ModeNumber.LAND)
        else:
            self.set_mode(ModeNumber.RTL if reaction is Fallback.RTL else ModeNumber.BRAKE)
