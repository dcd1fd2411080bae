"""Settings: their sections, each with its defaults, bounds and checks, and what they say together.

`hawk.config.loader` reads them. ``config.toml`` in the project's root is the reference: every setting with unit,
default and what it does.
"""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime, tzinfo
from pathlib import Path
from typing import Any, Final, Literal
from zoneinfo import ZoneInfo

from pydantic import BaseModel, ConfigDict, Field, PrivateAttr, model_validator
from pydantic.fields import FieldInfo

from hawk.config.fields import (
    AutopilotAddress,
    CameraAddress,
    Degrees,
    Description,
    DeskAddress,
    FilePath,
    LotName,
    OperatorId,
    PageHost,
    PageName,
    PageToken,
    ReceiverAddress,
    Retry,
    SerialNumber,
    SigningSecret,
    TravelHeight,
    VehicleAddress,
    ZoneName,
)
from hawk.config.secrets import SecretUrl


class ConfigError(Exception):
    """A setting that cannot be used; the text names file, line, key and remedy."""


class Section(BaseModel):
    """Base of a section: unknown keys are errors. A setting that holds a secret has a type of `hawk.config.secrets`."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, hide_input_in_errors=True)


class AutopilotSettings(Section):
    """Link to the autopilot."""

    url: AutopilotAddress = "udpin://127.0.0.1:14550"
    system_id: int = Field(default=245, ge=1, le=255)
    vehicle_system_id: int | None = Field(default=None, ge=1, le=255)
    vehicle_address: VehicleAddress | None = None
    connect_timeout_s: Retry = 5.0
    position_rate_hz: float = Field(default=20.0, ge=5, le=50)
    set_rtl_altitude: bool = True


class CameraSettings(Section):
    """Source of the pictures, and the camera's optics and mount."""

    url: CameraAddress = SecretUrl("http://127.0.0.1:8090/stream")
    horizontal_fov_deg: float = Field(default=70.0, ge=5, le=170)
    calibration: FilePath | None = None
    mount_roll_deg: Degrees = 0.0
    mount_pitch_deg: Degrees = 0.0
    mount_yaw_deg: Degrees = 0.0
    gimbal: bool = False
    latency_s: float = Field(default=0.08, ge=0, le=5)
    exposure_s: float = Field(default=0.01, ge=0.00001, le=1)
    reconnect_s: Retry = 1.0


OBSTACLE_MARGIN_M = 5.0
"""Travel heights stay this far above the highest obstacle: a barometer drifts by some metres in a flight."""


class HeightSettings(Section):
    """Travel heights until the operator configures others, metres above the arm place."""

    minimum_m: TravelHeight = 15.0
    desired_m: TravelHeight = 35.0
    maximum_m: TravelHeight = 60.0
    ceiling_m: TravelHeight = 100.0
    highest_obstacle_m: float | None = Field(default=None, ge=0, le=490)
    least_clearance_m: float = Field(default=5.0, ge=1, le=50)

    @property
    def floor_m(self) -> float:
        """Lowest travel height: clear of the highest obstacle, metres above the arm place; 0 when none is declared."""
        return 0.0 if self.highest_obstacle_m is None else self.highest_obstacle_m + OBSTACLE_MARGIN_M

    @model_validator(mode="after")
    def _ordered(self) -> HeightSettings:
        if self.minimum_m < self.floor_m:
            raise ValueError(
                f"minimum_m must be {self.floor_m:g} or more: highest_obstacle_m and {OBSTACLE_MARGIN_M:g} m"
            )
        if not self.minimum_m <= self.desired_m <= self.maximum_m <= self.ceiling_m:
            raise ValueError("heights must rise: minimum_m <= desired_m <= maximum_m <= ceiling_m")
        return self


class FlightSettings(Section):
    """Flight and battery limits."""

    speed_m_s: float = Field(default=4.0, ge=0.5, le=15)
    tick_hz: float = Field(default=20.0, ge=5, le=50)
    arrival_radius_m: float = Field(default=1.5, ge=0.5, le=10)
    maximum_wind_m_s: float = Field(default=10.0, ge=1, le=25)
    explore_cm_per_pixel: float | None = Field(default=None, ge=0.5, le=10)
    outline_file: FilePath | None = None
    explore_lost_lot_s: float = Field(default=10.0, ge=1, le=120)
    battery_reserve_percent: float = Field(default=20.0, ge=5, le=80)
    battery_arm_percent: float = Field(default=30.0, ge=5, le=100)
    battery_cells: int | None = Field(default=None, ge=1, le=24)
    battery_chemistry: Literal["lipo", "lihv", "liion"] = "lipo"
    battery_return_v: float | None = Field(default=None, ge=2.5, le=4.0)
    battery_land_v: float | None = Field(default=None, ge=2.5, le=4.0)
    maximum_hdop_m: float = Field(default=3.0, ge=0.5, le=10)

    @model_validator(mode="after")
    def _lands_below_the_return(self) -> FlightSettings:
        back, land = self.battery_return_v, self.battery_land_v
        if back is not None and land is not None and land > back:
            raise ValueError(f"battery_land_v ({land:g}) must not be more than battery_return_v ({back:g})")
        return self

    @model_validator(mode="after")
    def _arms_with_more_than_the_reserve(self) -> FlightSettings:
        arm, reserve = self.battery_arm_percent, self.battery_reserve_percent
        if arm < reserve:
            raise ValueError(
                f"battery_arm_percent ({arm:g}) must not be less than battery_reserve_percent ({reserve:g}): "
                "the drone would return as soon as it took off"
            )
        return self


class FenceSettings(Section):
    """Limits of the flight."""

    file: FilePath | None = None
    radius_m: float = Field(default=150.0, ge=20, le=2000)
    margin_m: float = Field(default=5.0, ge=1, le=50)
    ceiling_margin_m: float = Field(default=3.0, ge=1, le=20)


class OperatorSettings(Section):
    """Timeouts for a lost operator."""

    operator_timeout_s: float = Field(default=10.0, ge=1, le=60)
    operator_hold_s: float = Field(default=30.0, ge=1, le=300)
    control_lease_s: float = Field(default=30.0, ge=1, le=300)


class RemoteControlSettings(Section):
    """The pilot's remote control."""

    required: bool = True
    switch_must_move: bool = False


class RemoteIdSettings(Section):
    """Remote ID: the operator's part, which the drone's transmitter needs."""

    enabled: bool = False
    operator_id: OperatorId | None = None
    operator_place: Literal["takeoff", "fixed"] = "takeoff"
    operator_latitude_deg: float | None = Field(default=None, ge=-90, le=90)
    operator_longitude_deg: float | None = Field(default=None, ge=-180, le=180)
    operator_height_m: float | None = Field(default=None, ge=-500, le=9000)
    description: Description | None = None
    serial_number: SerialNumber | None = None

    @model_validator(mode="after")
    def _says_who_and_where(self) -> RemoteIdSettings:
        if self.enabled and self.operator_id is None:
            raise ValueError("operator_id is missing: write the number of your registration, or set enabled = false")
        latitude, longitude = self.operator_latitude_deg, self.operator_longitude_deg
        if self.operator_place == "fixed" and (latitude is None or longitude is None):
            raise ValueError('operator_place = "fixed" needs operator_latitude_deg and operator_longitude_deg')
        if self.operator_place == "fixed" and latitude == 0 and longitude == 0:
            raise ValueError("operator_latitude_deg and operator_longitude_deg are 0: Remote ID takes that for unknown")
        return self


class VisionSettings(Section):
    """Perception."""

    model: FilePath | None = None
    engine: Literal["auto", "opencv", "onnxruntime"] = "auto"
    threads: int = Field(default=1, ge=1, le=8)
    minimum_height_m: float = Field(default=6.0, ge=1, le=100)
    minimum_stalls: int = Field(default=3, ge=1, le=100)
    sun: Literal["auto", "off"] = "auto"


class WebSettings(Section):
    """The operator page."""

    host: PageHost = "127.0.0.1"
    port: int = Field(default=3000, ge=0, le=65535)
    token: PageToken | None = None
    session_idle_h: float = Field(default=12.0, ge=0.25, le=168)
    session_limit_h: float = Field(default=168.0, ge=1, le=720)
    tls_certificate: FilePath | None = None
    tls_key: FilePath | None = None
    allowed_hosts: tuple[PageName, ...] = ()
    maximum_clients: int = Field(default=20, ge=1, le=1000)
    video_width: int = Field(default=960, ge=160, le=1920)
    video_quality: int = Field(default=75, ge=20, le=95)
    background_tiles: FilePath | None = None

    @model_validator(mode="after")
    def _fit_together(self) -> WebSettings:
        if (self.tls_certificate is None) != (self.tls_key is None):
            there, missing = ("tls_key", "tls_certificate") if self.tls_key else ("tls_certificate", "tls_key")
            raise ValueError(f"{missing} is missing: {there} needs it")
        if self.session_idle_h > self.session_limit_h:
            raise ValueError("session_idle_h must not be more than session_limit_h")
        return self


class StoreSettings(Section):
    """Storage on disk."""

    directory: FilePath = Path("var")
    lots: FilePath | None = None
    record: bool = True
    recordings_gb: float = Field(default=8.0, ge=0.1, le=100_000)
    recordings_days: float | None = Field(default=None, ge=0.1, le=36_500)
    minimum_free_mb: int = Field(default=500, ge=1, le=1_000_000)


class WebhooksSettings(Section):
    """Reports of surveys and layouts to other programs."""

    urls: tuple[ReceiverAddress, ...] = ()
    secret: SigningSecret | None = None
    allow_private: bool = False

    @model_validator(mode="after")
    def _fit_together(self) -> WebhooksSettings:
        if self.urls and self.secret is None:
            raise ValueError("secret is missing: urls need it; make one with: echo whsec_$(openssl rand -base64 32)")
        return self


class CollectSettings(Section):
    """A desk that collects the surveys of this store, by a token of this drone. ``lots``: those that come back.

    ``recordings``: whether the desk gets those that it asks for; they show everything that the camera saw.
    """

    url: DeskAddress | None = None
    token_file: FilePath | None = None
    certificate: FilePath | None = None
    kbit_s: int = Field(default=0, ge=0, le=1_000_000)
    lots: Literal["all", "seen"] = "all"
    recordings: Literal["never", "asked"] = "never"

    @model_validator(mode="after")
    def _fit_together(self) -> CollectSettings:
        if self.url is not None and self.token_file is None:
            raise ValueError(
                "token_file is missing: url needs it; the desk makes the token: hawk-drone tokens rotate drone"
            )
        return self


class InboxSettings(Section):
    """A folder of ``hawk-drone map --watch`` that programs fill by the API of a desk, and its limits."""

    folder: FilePath | None = None
    largest_gb: float = Field(default=4.0, ge=0.001, le=1000)
    most_gb: float = Field(default=100.0, ge=0.001, le=100_000)
    most_files: int = Field(default=100_000, ge=1, le=10_000_000)


DAYS: Final = ("mon", "tue", "wed", "thu", "fri", "sat", "sun")
DUE_DAYS: Final = 7
"""Days from now on in which the next survey of a lot is looked for."""


class ScheduledSurvey(Section):
    """A survey that is due on some days at a time. ``lot``: name or id."""

    lot: LotName = Field(min_length=1, max_length=80)
    at: str = Field(pattern=r"^([01]\d|2[0-3]):[0-5]\d$")
    days: tuple[Literal["mon", "tue", "wed", "thu", "fri", "sat", "sun"], ...] = Field(default=DAYS, min_length=1)
    time_zone: ZoneName | None = None
    _since: float = PrivateAttr(default=0.0)

    @property
    def since(self) -> float:
        """Unix seconds from which on it is known that the entry holds: the newest change of its file."""
        return self._since

    def hold_since(self, at: float) -> None:
        """Take the newest change of the file that the entry stands in, Unix seconds."""
        self._since = at

    def clock(self) -> tzinfo:
        """Return the clock of ``at``: that of the time zone, without one the computer's."""
        local = datetime.now().astimezone().tzinfo
        assert local is not None  # noqa: S101 - `astimezone` sets one
        return local if self.time_zone is None else ZoneInfo(self.time_zone)


class WatchdogSettings(Section):
    """End of a hung process."""

    timeout_s: float = Field(default=1.0, ge=0.2, le=30)
    enabled: bool = True


class LogSettings(Section):
    """Program log on standard error."""

    level: Literal["debug", "info", "warning", "error"] = "info"


class Config(Section):
    """All settings."""

    autopilot: AutopilotSettings = AutopilotSettings()
    camera: CameraSettings = CameraSettings()
    heights: HeightSettings = HeightSettings()
    flight: FlightSettings = FlightSettings()
    fence: FenceSettings = FenceSettings()
    operator: OperatorSettings = OperatorSettings()
    remote_control: RemoteControlSettings = RemoteControlSettings()
    remote_id: RemoteIdSettings = RemoteIdSettings()
    vision: VisionSettings = VisionSettings()
    web: WebSettings = WebSettings()
    store: StoreSettings = StoreSettings()
    webhooks: WebhooksSettings = WebhooksSettings()
    collect: CollectSettings = CollectSettings()
    inbox: InboxSettings = InboxSettings()
    schedule: tuple[ScheduledSurvey, ...] = ()
    watchdog: WatchdogSettings = WatchdogSettings()
    log: LogSettings = LogSettings()


def section_fields(section: str) -> Mapping[str, FieldInfo]:
    """Return the fields of a section by key; none of one that is not known."""
    model = Config.model_fields[section].annotation if section in Config.model_fields else None
    found: Mapping[str, FieldInfo] = getattr(model, "model_fields", {})
    return found


def bounds(section: str, key: str) -> tuple[float, float] | None:
    """Return the lowest and the highest value of a setting, both allowed; None for one that has no such bounds."""
    field = section_fields(section).get(key)
    limits: list[Any] = [] if field is None else field.metadata
    lowest = next((float(limit.ge) for limit in limits if hasattr(limit, "ge")), None)
    highest = next((float(limit.le) for limit in limits if hasattr(limit, "le")), None)
    return None if lowest is None or highest is None else (lowest, highest)
