"""ArduCopter's failsafes: what is watched, for how long, and what follows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum

from hawk.sim.fence import FenceType, fence_words
from hawk.sim.modes import ModeNumber
from hawk.sim.parameters import Parameters

RADIO_TIMEOUT_S = 0.5
EKF_TIMEOUT_S = 1.0
"""From unhealthy to the EKF failsafe."""
OPTION_CONTINUE_GUIDED_ON_RADIO = 1 << 2
OPTION_CONTINUE_LANDING = 1 << 3
OPTION_CONTINUE_PILOT_ON_GCS = 1 << 4
"""FS_OPTIONS bits."""
WARNING, CRITICAL, EMERGENCY = 4, 2, 0
"""MAV_SEVERITY."""


class Reaction(Enum):
    """What a failsafe does."""

    NOTHING = "nothing"
    RTL = "rtl"
    LAND = "land"
    BRAKE = "brake"
    TERMINATE = "terminate"


_GCS = {1: Reaction.RTL, 2: Reaction.RTL, 3: Reaction.RTL, 4: Reaction.LAND, 5: Reaction.LAND, 7: Reaction.BRAKE}
_RADIO = {1: Reaction.RTL, 2: Reaction.RTL, 3: Reaction.LAND, 4: Reaction.RTL, 5: Reaction.LAND, 7: Reaction.BRAKE}
_BATTERY = {1: Reaction.LAND, 2: Reaction.RTL, 3: Reaction.RTL, 4: Reaction.LAND, 5: Reaction.TERMINATE}
_FENCE = {1: Reaction.RTL, 2: Reaction.LAND, 3: Reaction.RTL, 4: Reaction.BRAKE, 5: Reaction.LAND}
# SmartRTL choices fly RTL or LAND here, which is what ArduCopter falls back to without a recorded path.


@dataclass(frozen=True, slots=True)
class Watched:
    """What the failsafes look at. Times are seconds of the simulation."""

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
    """Latches and timers. ``react`` does what a failsafe asks for, ``say`` sends a STATUSTEXT.

    ``real_time_factor`` is simulated seconds per real one: a ground station's heartbeats come in real time, so
    FS_GCS_TIMEOUT counts real seconds.
    """

    parameters: Parameters
    say: Callable[[int, str], None]
    react: Callable[[Reaction], None]
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
        """Look at everything once."""
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
        limit = self.parameters["FS_GCS_TIMEOUT"] * self.real_time_factor
        lost = bool(enabled) and now.gcs_silent_s is not None and now.gcs_silent_s > limit
        if lost and not self.gcs:
            self.gcs = True
            continues = now.pilot_flies and self.parameters.flag("FS_OPTIONS") & OPTION_CONTINUE_PILOT_ON_GCS
            if not now.armed:
                self.say(WARNING, "GCS Failsafe")
            elif continues:
                self.say(WARNING, "GCS Failsafe - Continuing Pilot Control")
            else:
                self._announce("GCS", _GCS.get(enabled, Reaction.RTL), now)
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
            self._announce("Radio", _RADIO.get(enabled, Reaction.RTL), now)

    def _watch_battery(self, now: Watched) -> None:
        wait = self.parameters["BATT_LOW_TIMER"]
        self._low_since = self._since(self._low_since, self._is_low(now, "LOW"), now.time)
        self._critical_since = self._since(self._critical_since, self._is_low(now, "CRT"), now.time)
        words = f"{now.voltage:.2f}V used {now.used_mah:.0f} mAh"
        if self._critical_since is not None and now.time - self._critical_since >= wait and not self.battery_critical:
            self.battery = self.battery_critical = True
            self.say(CRITICAL, f"Battery 1 is critical {words}")
            self._announce("Battery", _BATTERY.get(self.parameters.flag("BATT_FS_CRT_ACT"), Reaction.NOTHING), now)
        elif self._low_since is not None and now.time - self._low_since >= wait and not self.battery:
            self.battery = True
            self.say(WARNING, f"Battery 1 is low {words}")
            self._announce("Battery", _BATTERY.get(self.parameters.flag("BATT_FS_LOW_ACT"), Reaction.NOTHING), now)

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
        self.react(Reaction.LAND)
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
                self.react(_FENCE.get(self.parameters.flag("FENCE_ACTION"), Reaction.NOTHING))
        elif gone and not self.fence:
            self.say(WARNING, "Fence breach cleared")

    def _announce(self, what: str, reaction: Reaction, now: Watched) -> None:
        """Say it and do it; a vehicle on the ground is left to `react`, which disarms it."""
        options = self.parameters.flag("FS_OPTIONS")
        if now.armed and now.mode == ModeNumber.LAND and options & OPTION_CONTINUE_LANDING:
            self.say(WARNING, f"{what} Failsafe - Continuing Landing")
            return
        if now.armed and now.landed and reaction is not Reaction.NOTHING:
            self.say(WARNING, f"{what} Failsafe - Disarming")
        else:
            self.say(WARNING, f"{what} Failsafe")
        if now.armed:
            self.react(reaction)
