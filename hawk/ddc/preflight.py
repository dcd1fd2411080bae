"""Preflight check: what must be well before Arm, each with its consequence and remedy."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Literal

from hawk.comm.messages import CheckItem
from hawk.ddc.errors import ReqFailed
from hawk.ddc.failsafes import check_failsafes, return_altitude, wanted_values, watched_names
from hawk.ddc.geofence import FenceError, contains, extent, outside_by, sees_all, to_map
from hawk.ddc.params import ParameterError, check_heights
from hawk.ddc.requests import Request
from hawk.ddc.words import metres
from hawk.model import Fence, MapPoint

if TYPE_CHECKING:
    from hawk.ddc.operations_manager import OperationsManager

REREAD_S = 20.0
"""A parameter is read again after so many seconds on the ground: others may change it, the autopilot reboot."""
STALE_S = 60.0
"""A parameter older than this counts as not read."""
RETRY_S = 3.0
"""After a read that failed, seconds."""
GPS_FIX_3D = 3

Remedy = Literal["Set Failsafes", "Clear Kill", "Set Fence"]


class Preflight:
    """Reads the autopilot's parameters one by one while disarmed, and makes the list of checks."""

    def __init__(self, context: OperationsManager) -> None:
        self._context = context
        self._values: dict[str, float | None] = {}
        self._read_at: dict[str, float] = {}
        self._reading: tuple[str, Request] | None = None
        self._setting: Request | None = None
        self._not_before = float("-inf")
        self._ground_time = 0.0
        self._last_tick = context.now
        self._items: tuple[float, tuple[CheckItem, ...]] | None = None
        self._plan_made: tuple[float, tuple[Fence, MapPoint] | CheckItem] | None = None

    @property
    def is_setting(self) -> bool:
        """Whether failsafes are being set."""
        return self._setting is not None

    @property
    def return_height(self) -> float | None:
        """The height at which the autopilot returns, metres above the arm place; None while it was not read lately."""
        return return_altitude(self._fresh_values())

    @property
    def passed_count(self) -> int:
        """How many checks passed."""
        return sum(item.passed for item in self.items())

    def first_failed(self) -> CheckItem | None:
        """Return the first check that has not passed."""
        return next((item for item in self.items() if not item.passed), None)

    def items(self) -> tuple[CheckItem, ...]:
        """Return all checks in the order in which they should be put right; made once a tick."""
        if self._items is None or self._items[0] != self._context.now:
            self._items = (self._context.now, self._make_items())
        return self._items[1]

    def _make_items(self) -> tuple[CheckItem, ...]:
        makers: tuple[Callable[[], CheckItem], ...] = (
            self._kill,
            self._link,
            self._sensors,
            self._gps,
            self._battery,
            self._camera,
            self._recording,
            self._heights,
            self._fence,
            self._return_height,
        )
        return (*(make() for make in makers), *self._failsafes())

    def tick(self, disarmed: bool) -> None:
        """Look at answers and ask for the next parameter; only while disarmed, one at a time."""
        self._items = self._plan_made = None
        now, last, self._last_tick = self._context.now, self._last_tick, self._context.now
        if disarmed:
            self._ground_time += now - last  # what was read does not age in flight, when nothing can be read
        self._finish_setting()
        if self._reading is not None and not self._reading[1].is_pending:
            self._take_reading(*self._reading)
            self._reading = None
        if self._reading is None and self._setting is None and disarmed and self._context.has_link:
            self._read_next()

    def forget(self) -> None:
        """The link was lost, or the autopilot may have rebooted: read everything again."""
        self._values.clear()
        self._read_at.clear()

    def reread(self, *names: str) -> None:
        """These were changed: read them again, those that exist."""
        for name in names:
            if self._values.get(name) is not None:
                self._read_at.pop(name, None)

    def set_failsafes(self) -> None:
        """Set what the checks found missing; each value is read back."""
        self._setting = self._context.ask("set failsafes", self._set_missing())

    async def _set_missing(self) -> None:
        """Read what is not known yet (an older name shows only when the newer one is not there), then set."""
        while unread := [name for name in watched_names(self._values) if name not in self._values]:
            await self._read(unread[0])
        wanted = wanted_values(self._values, self._context.settings.system_id)
        await self._context.service.set_failsafes(wanted)

    def _finish_setting(self) -> None:
        if self._setting is None or self._setting.is_pending:
            return
        if self._setting.has_failed:
            self._context.log.add("error", "The failsafes were not set.", self._setting.reason)
        else:
            self._context.log.add("ok", "Failsafes set and read back.")
        self._setting = None
        self._read_at.clear()

    def _read_next(self) -> None:
        now = self._ground_time
        if now < self._not_before:
            return
        due = [n for n in watched_names(self._values) if now - self._read_at.get(n, float("-inf")) >= REREAD_S]
        if due:
            name = min(due, key=lambda n: self._read_at.get(n, float("-inf")))
            self._reading = (name, self._context.ask(f"read {name}", self._read(name)))

    async def _read(self, name: str) -> None:
        """Read one parameter; one that the autopilot does not have has the value None when there is another name."""
        try:
            self._values[name] = float(await self._context.service.get_parameter(name))
        except ReqFailed:
            if name not in ("MAV_GCS_SYSID", "RTL_ALT_M") or self._values.get(name) is not None:
                raise
            self._values[name] = None

    def _take_reading(self, name: str, request: Request) -> None:
        if request.has_failed:
            self._not_before = self._ground_time + RETRY_S
        else:
            self._read_at[name] = self._ground_time

    def _fresh_values(self) -> dict[str, float | None]:
        """Return what is known: a value is void when it could not be read again for long; a name is not."""
        now = self._ground_time
        return {
            name: value
            for name, value in self._values.items()
            if value is None or now - self._read_at.get(name, now) < STALE_S
        }

    # -- the checks ----------------------------------------------------------------------------------------------

    def _kill(self) -> CheckItem:
        if not self._context.kill.is_killed:
            return _passed("Motors", "free to start")
        return _failed(
            "Motors", "cut", "The drone may be damaged.", "Look at it, then clear the cut.", remedy_command="Clear Kill"
        )

    def _link(self) -> CheckItem:
        health = self._context.topics.get_link_health()
        if health.is_healthy and self._context.has_link:
            return _passed("Link", f"{self._context.topics.get_link_age():.1f} s")
        found = health.reason or "looking at it"
        return _failed("Link", found, "Nothing can be commanded.", "Switch the drone on, check its cable.")

    def _sensors(self) -> CheckItem:
        if self._context.topics.get_diagnostics().all_ok:
            return _passed("Autopilot", "its sensors are well")
        words = self._context.log.autopilot_reason() or "its sensors are not ready"
        return _failed("Autopilot", words, "It would refuse to arm.", "Wait a minute after switching on.")

    def _gps(self) -> CheckItem:
        found = self._context.topics.get_diagnostics()
        accuracy, fix = found.horizontal_accuracy, found.gps_fix
        limit = self._context.settings.flight.maximum_hdop_m
        text = ", ".join(
            part
            for part in (
                "no fix" if fix is None or fix < GPS_FIX_3D else "",
                f"{found.satellites} satellites" if found.satellites is not None else "",
                f"±{accuracy:.1f} m" if accuracy is not None else "accuracy unknown",
            )
            if part
        )
        good = fix is not None and fix >= GPS_FIX_3D and accuracy is not None and accuracy <= limit
        if good and found.global_position_ok and self._context.topics.get_position_health().is_healthy:
            return _passed("GPS", text)
        return _failed("GPS", text, "The drone would not know where it is.", "Wait under open sky.")

    def _battery(self) -> CheckItem:
        battery = self._context.topics.get_battery_info()
        needed = self._context.settings.flight.battery_arm_percent
        if battery is None or battery.percentage is None:
            return _failed("Battery", "not known", "It could fall.", "Set up the autopilot's battery monitor.")
        voltage = "" if battery.voltage is None else f", {battery.voltage:.1f} V"
        text = f"{battery.percentage:.0f} %{voltage}"
        if battery.percentage >= needed:
            return _passed("Battery", text)
        return _failed("Battery", text, "It would have to return at once.", f"Charge it to {needed:.0f} % or more.")

    def _camera(self) -> CheckItem:
        health = self._context.topics.get_camera_health()
        age = self._context.topics.get_camera_age()
        if health.is_healthy:
            return _passed("Camera", "on" if age is None else f"picture {age:.1f} s old")
        return _failed("Camera", health.reason, "Nothing would be seen.", "Check the camera and its address.")

    def _recording(self) -> CheckItem:
        health = self._context.topics.get_recording_health()
        if health.is_healthy:
            return _passed("Recording", health.reason or "on")
        return _failed("Recording", health.reason, "The flight would not be recorded.", "Make room on the disk.")

    def _heights(self) -> CheckItem:
        heights, ceiling = self._context.heights, self._context.ceiling
        text = f"{heights.desired:g} m, never below {heights.minimum:g} m or above {heights.maximum:g} m"
        try:
            check_heights(heights, ceiling)
        except ParameterError as error:
            return _failed("Heights", text, str(error), "Change the heights.")
        return _passed("Heights", text)

    def _fence(self) -> CheckItem:
        planned = self._planned()
        if isinstance(planned, CheckItem):
            return planned
        fence, home = planned
        north, east = extent(fence)
        text = f"{north:.0f} × {east:.0f} m"
        if not contains(fence, home):
            away = metres(max(1.0, outside_by(fence, home)))
            return _bad_fence(f"{text}, drone {away} outside", "It could not fly anywhere.")
        return _passed("Fence", f"{text}, drone and home inside")

    def _return_height(self) -> CheckItem:
        name, planned, altitude = "Return height", self._planned(), self.return_height
        if altitude is None or isinstance(planned, CheckItem):
            value = "not read yet" if altitude is None else f"{metres(altitude)}, no fence to compare it with"
            return _failed(name, value, "It may be above the fence.", "Wait.")
        fence, home = planned
        text = f"{metres(altitude)}, ceiling {metres(fence.ceiling)}"
        if altitude > fence.ceiling:
            return _failed(name, text, "On its way home it would leave the fence.", "Change the heights.")
        return _passed(name, text if sees_all(fence, home) else f"{text}; from parts the way home leaves the fence")

    def _planned(self) -> tuple[Fence, MapPoint] | CheckItem:
        """Return what `_plan` says, made once a tick."""
        if self._plan_made is None or self._plan_made[0] != self._context.now:
            self._plan_made = (self._context.now, self._plan())
        return self._plan_made[1]

    def _plan(self) -> tuple[Fence, MapPoint] | CheckItem:
        """Return the fence that Arm would lay and the drone's place, its home to be; else the check that fails."""
        if self._context.fences.problem:
            return _bad_fence(self._context.fences.problem, "What it forbids is not known.")
        place, datum = self._context.topics.get_global_pose(), self._context.datum_for_arm()
        if place is None or datum is None:
            return _failed("Fence", "position not known", "There is no fence to fly in.", "Wait for the position.")
        try:
            fence = self._context.fences.build(datum, place.latitude, place.longitude)
        except FenceError as error:
            return _bad_fence(str(error), "There is no fence to fly in.")
        return fence, to_map(datum, place.latitude, place.longitude)

    def _failsafes(self) -> tuple[CheckItem, ...]:
        found = check_failsafes(self._fresh_values(), self._context.settings.system_id)
        return tuple(
            _passed(check.name, check.value)
            if check.passed
            else _failed(check.name, check.value, check.consequence, "Set failsafes.", remedy_command="Set Failsafes")
            for check in found
        )


def _passed(name: str, value: str) -> CheckItem:
    return CheckItem(name=name, passed=True, value=value)


def _bad_fence(value: str, consequence: str) -> CheckItem:
    remedy = "Put the drone inside the fence, or draw another one."
    return _failed("Fence", value, consequence, remedy, remedy_command="Set Fence")


def _failed(name: str, value: str, consequence: str, remedy: str, *, remedy_command: Remedy | None = None) -> CheckItem:
    return CheckItem(
        name=name, passed=False, value=value, consequence=consequence, remedy=remedy, remedy_command=remedy_command
    )
