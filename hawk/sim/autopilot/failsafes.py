"""ArduCopter's checks before arming and its failsafes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from enum import Enum

from hawk.sim.autopilot.fence import FenceType, fence_words
from hawk.sim.autopilot.modes import ModeNumber
from hawk.sim.autopilot.parameters import Parameters


@dataclass(frozen=True, slots=True)
class ArmingView:
    """Inputs of the checks before arming."""

    mode_name: str
    mode_arms: bool
    mode_needs_position: bool
    position_ok: bool
    home_set: bool
    radio_failsafe: bool
    gcs_failsafe: bool
    battery_failsafe: bool
    battery_voltage: float
    battery_arm_voltage: float
    fence_enabled: bool
    fence_breaches: FenceType
    throttle_high: bool
    crashed: bool
    compasses_healthy: bool = True


def pre_arm_reasons(view: ArmingView) -> list[str]:
    """Return the reasons against arming in the present mode (the PREARM bit of SYS_STATUS)."""
    return list(_pre_arm(view))


def arming_reasons(view: ArmingView) -> list[str]:
    """Return the reasons why arming is refused at this moment, the mode first as in ArduCopter."""
    reasons = [] if view.mode_arms else [f"{view.mode_name} mode not armable"]
    reasons += _pre_arm(view)
    if view.throttle_high:
        reasons.append("Throttle too high")
    return reasons


def _pre_arm(view: ArmingView) -> Iterator[str]:
    if view.crashed:
        yield "Vehicle has crashed"
    if not view.compasses_healthy:
        yield "Compass not healthy"
    if (view.mode_needs_position or view.fence_enabled) and not (view.position_ok and view.home_set):
        yield "fence requires position" if view.fence_enabled else "Need Position Estimate"
    elif view.fence_breaches:
        yield f"Vehicle breaching {fence_words(view.fence_breaches)} fence"
    if view.radio_failsafe:
        yield "Radio failsafe on"
    if view.gcs_failsafe:
        yield "GCS failsafe on"
    if view.battery_failsafe:
        yield "Battery 1 low voltage failsafe"
    elif view.battery_voltage < view.battery_arm_voltage:
        yield "Battery 1 below minimum arming voltage"


RADIO_TIMEOUT_S = 1.0
"""RC_FS_TIMEOUT."""
EKF_TIMEOUT_S = 1.0
"""From unhealthy to the EKF failsafe."""
OPTION_CONTINUE_GUIDED_ON_RADIO = 1 << 2
OPTION_CONTINUE_LANDING = 1 << 3
OPTION_CONTINUE_PILOT_ON_GCS = 1 << 4
"""FS_OPTIONS bits."""
WARNING, CRITICAL, EMERGENCY = 4, 2, 0
"""MAV_SEVERITY."""


class Fallback(Enum):
    """Action of a failsafe."""

    NOTHING = "nothing"
    RTL = "rtl"
    LAND = "land"
    BRAKE = "brake"
    TERMINATE = "terminate"


_GCS = {1: Fallback.RTL, 2: Fallback.RTL, 3: Fallback.RTL, 4: Fallback.LAND, 5: Fallback.LAND, 7: Fallback.BRAKE}
_RADIO = {1: Fallback.RTL, 2: Fallback.RTL, 3: Fallback.LAND, 4: Fallback.RTL, 5: Fallback.LAND, 7: Fallback.BRAKE}
_BATTERY = {1: Fallback.LAND, 2: Fallback.RTL, 3: Fallback.RTL, 4: Fallback.LAND, 5: Fallback.TERMINATE}
_FENCE = {1: Fallback.RTL, 2: Fallback.LAND, 3: Fallback.RTL, 4: Fallback.BRAKE, 5: Fallback.LAND}
# SmartRTL choices fly RTL or LAND here, which is what ArduCopter falls back to without a recorded path.


@dataclass(frozen=True, slots=True)
class Watched:
    """Inputs of the failsafes. Times are seconds of the simulation."""

    time: float
    armed: bool
    landed: bool
    mode: int
    pilot_flies: bool
    needs_position: bool
    gcs_silent_s: float | None
    radio_present: bool
    position_ok: bool
    voltage: float
    used_mah: float
    breaches: FenceType


@dataclass(slots=True)
class Failsafes:
    """Latches and timers. ``react`` performs an action, ``say`` sends a STATUSTEXT.

    ``real_time_factor`` is simulated seconds per real one: a ground station's heartbeats come in real time, so
    FS_GCS_TIMEOUT counts real seconds.
    """

    parameters: Parameters
    say: Callable[[int, str], None]
    react: Callable[[Fallback], None]
    real_time_factor: float = 1.0
    gcs: bool = False
    radio: bool = False
    battery: bool = False
    battery_critical: bool = False
    ekf: bool = False
    fence: FenceType = FenceType.NONE
    _radio_since: float | None = field(default=None, repr=False)
    _ekf_since: float | None = field(default=None, repr=False)
    _low_since: float | None = field(default=None, repr=False)
    _critical_since: float | None = field(default=None, repr=False)

    def step(self, now: Watched) -> None:
        """Check every failsafe once."""
        self._watch_radio(now)
        self._watch_gcs(now)
        self._watch_battery(now)
        self._watch_ekf(now)
        self._watch_fence(now)

    def clear_battery(self) -> None:
        """Forget the battery failsafe (a new battery, a reboot)."""
        self.battery = self.battery_critical = False
        self._low_since = self._critical_since = None

    def _watch_gcs(self, now: Watched) -> None:
        enabled = self.parameters.flag("FS_GCS_ENABLE")
        if not enabled:
            return  # it stays as it is: switched off while it acts, it is never cleared (failsafe_gcs_check)
        limit = self.parameters["FS_GCS_TIMEOUT"] * self.real_time_factor
        lost = now.gcs_silent_s is not None and now.gcs_silent_s > limit
        if lost and not self.gcs:
            self.gcs = True
            continues = now.pilot_flies and self.parameters.flag("FS_OPTIONS") & OPTION_CONTINUE_PILOT_ON_GCS
            if not now.armed:
                self.say(WARNING, "GCS Failsafe")
            elif continues:
                self.say(WARNING, "GCS Failsafe - Continuing Pilot Control")
            else:
                self._announce("GCS", _GCS.get(enabled, Fallback.RTL), now)
        elif self.gcs and not lost:
            self.gcs = False
            self.say(WARNING, "GCS Failsafe Cleared")

    def _watch_radio(self, now: Watched) -> None:
        if now.radio_present:
            self._radio_since = None
            if self.radio:
                self.radio = False
                self.say(WARNING, "Radio Failsafe Cleared")
            return
        enabled = self.parameters.flag("FS_THR_ENABLE")
        if self._radio_since is None:
            self._radio_since = now.time
        if not enabled or self.radio or now.time - self._radio_since < RADIO_TIMEOUT_S:
            return
        self.radio = True
        options = self.parameters.flag("FS_OPTIONS")
        if now.armed and now.mode == ModeNumber.GUIDED and options & OPTION_CONTINUE_GUIDED_ON_RADIO:
            self.say(WARNING, "Radio Failsafe - Continuing Guided Mode")
        else:
            self._announce("Radio", _RADIO.get(enabled, Fallback.RTL), now)

    def _watch_battery(self, now: Watched) -> None:
        wait = self.parameters["BATT_LOW_TIMER"]
        self._low_since = self._since(self._low_since, self._is_low(now, "LOW"), now.time)
        self._critical_since = self._since(self._critical_since, self._is_low(now, "CRT"), now.time)
        words = f"{now.voltage:.2f}V used {now.used_mah:.0f} mAh"
        if self._critical_since is not None and now.time - self._critical_since >= wait and not self.battery_critical:
            self.battery = self.battery_critical = True
            self.say(CRITICAL, f"Battery 1 is critical {words}")
            self._announce("Battery", _BATTERY.get(self.parameters.flag("BATT_FS_CRT_ACT"), Fallback.NOTHING), now)
        elif self._low_since is not None and now.time - self._low_since >= wait and not self.battery:
            self.battery = True
            self.say(WARNING, f"Battery 1 is low {words}")
            self._announce("Battery", _BATTERY.get(self.parameters.flag("BATT_FS_LOW_ACT"), Fallback.NOTHING), now)

    def _is_low(self, now: Watched, level: str) -> bool:
        volts, charge = self.parameters[f"BATT_{level}_VOLT"], self.parameters[f"BATT_{level}_MAH"]
        left = self.parameters["BATT_CAPACITY"] - now.used_mah
        return (volts > 0.0 and now.voltage < volts) or (charge > 0.0 and left < charge)

    @staticmethod
    def _since(since: float | None, condition: bool, time: float) -> float | None:
        if not condition:
            return None
        return time if since is None else since

    def _watch_ekf(self, now: Watched) -> None:
        if now.position_ok:
            self._ekf_since = None
            if self.ekf:
                self.ekf = False
                self.say(CRITICAL, "EKF Failsafe Cleared")
            return
        if self._ekf_since is None:
            self._ekf_since = now.time
        if self.ekf or not now.armed or not now.needs_position or now.time - self._ekf_since < EKF_TIMEOUT_S:
            return
        if self.parameters.flag("FS_EKF_ACTION") == 0:
            return
        self.ekf = True
        self.say(CRITICAL, "EKF variance: position horizontal")
        self.react(Fallback.LAND)
        self.say(CRITICAL, "EKF Failsafe: changed to LAND Mode")

    def _watch_fence(self, now: Watched) -> None:
        new = now.breaches & ~self.fence
        gone = self.fence & ~now.breaches
        self.fence = now.breaches
        if not now.armed or now.landed:
            return
        if new:
            self.say(CRITICAL, f"{fence_words(new)} fence breached")
            if now.mode != ModeNumber.LAND:
                self.react(_FENCE.get(self.parameters.flag("FENCE_ACTION"), Fallback.NOTHING))
        elif gone and not self.fence:
            self.say(WARNING, "Fence breach cleared")

    def _announce(self, what: str, reaction: Fallback, now: Watched) -> None:
        """Send the text and act; on the ground `react` disarms the vehicle."""
        options = self.parameters.flag("FS_OPTIONS")
        if now.armed and now.mode == ModeNumber.LAND and options & OPTION_CONTINUE_LANDING:
            self.say(WARNING, f"{what} Failsafe - Continuing Landing")
            return
        if now.armed and now.landed and reaction is not Fallback.NOTHING:
            self.say(WARNING, f"{what} Failsafe - Disarming")
        else:
            self.say(WARNING, f"{what} Failsafe")
        if now.armed:
            self.react(reaction)
