"""Settings: read from ``config.toml``, from environment variables and from the command line, in this order of rank
(the last wins), and checked as a whole before anything starts.

``config.toml`` in the project's root is the reference: every setting with unit, default and what it does.
"""

from __future__ import annotations

import argparse
import base64
import binascii
import difflib
import ipaddress
import os
import re
import tomllib
import typing
from collections.abc import Callable, Mapping
from datetime import datetime, tzinfo
from pathlib import Path
from typing import Annotated, Any, Final, Literal, NamedTuple
from urllib.parse import urlsplit
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    SecretStr,
    ValidationError,
    model_validator,
)
from pydantic.fields import FieldInfo

from hawk.config.addresses import check_autopilot_address, check_camera_address, check_host, usable_path
from hawk.config.secrets import SecretUrl, is_secret
from hawk.formats.validation import wrong_values

ENVIRONMENT_PREFIX = "HAWK_"
"""``HAWK_WEB__PORT=3001`` sets ``port`` of section ``web``."""

Retry = Annotated[float, Field(ge=0.01, le=60)]
"""Seconds until something is tried again, or shown as missing."""
TravelHeight = Annotated[float, Field(ge=2, le=500)]
"""Metres above the arm place: above people and cars, and below the 1000 m of ArduCopter's FENCE_ALT_MAX."""
Degrees = Annotated[float, Field(ge=-180, le=180)]


class ConfigError(Exception):
    """A setting that cannot be used; the text names file, line, key and remedy."""


class Section(BaseModel):
    """Base of a section: unknown keys are errors. A setting that holds a secret has a type of `hawk.config.secrets`."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, hide_input_in_errors=True)


class _Removed(NamedTuple):
    """A setting of earlier versions. A value that states what holds now is passed over: the drone starts with it."""

    remedy: str
    holds_now: tuple[object, ...]


_REMOVED: Final = {
    ("vision", "use_network"): _Removed(
        "is no setting any more: the network alone finds stalls. Delete it from your settings", (True, "true")
    ),
}
"""By section and key."""


def _path(value: Any) -> Any:
    return usable_path(value) if isinstance(value, str | Path) else value


FilePath = Annotated[Path, BeforeValidator(_path)]
"""A file or folder; ``~`` stands for the home folder."""


def _camera(value: SecretUrl) -> SecretUrl:
    check_camera_address(value.get_secret_value())
    return value


def _receiver(value: SecretUrl) -> SecretUrl:
    parts = urlsplit(value.get_secret_value())
    if parts.scheme not in ("https", "http") or not parts.hostname:
        raise ValueError("must be an address, as https://example.org/hawk")
    return value


def _at_least(shortest: int) -> Callable[[SecretStr], SecretStr]:
    def check(value: SecretStr) -> SecretStr:
        if len(value.get_secret_value()) < shortest:
            raise ValueError(f"must have at least {shortest} characters")
        return value

    return check


def _signing_secret(value: SecretStr) -> SecretStr:
    text = value.get_secret_value()
    if text.startswith("whsec_"):
        try:
            base64.b64decode(text.removeprefix("whsec_"), validate=True)
        except binascii.Error:
            raise ValueError("must be base64 behind whsec_, as: echo whsec_$(openssl rand -base64 32)") from None
    return value


def _time_zone(value: str) -> str:
    try:
        ZoneInfo(value)
    except (ZoneInfoNotFoundError, ValueError, OSError):
        raise ValueError("must be a name of the time zone database, as Europe/Amsterdam or UTC") from None
    return value


def _page_host(value: str) -> str:
    if not value:
        raise ValueError("is empty: 0.0.0.0 stands for all addresses of this computer, 127.0.0.1 for itself alone")
    return check_host(value)


def _page_name(value: str) -> str:
    try:
        return check_host(value.strip("[]"))
    except ValueError:
        words = "must be names as a browser's address has them, without scheme, port and path (drone.example)"
        raise ValueError(words) from None


def host_and_port(address: str) -> tuple[str, int | None]:
    """Return the IP address and the port of ``IP``, ``IP:PORT``, ``[IPv6]`` or ``[IPv6]:PORT``; raises ValueError."""
    found = re.fullmatch(
        r"\[(?P<six>[^\]]+)\](:(?P<port6>\d+))?|(?P<four>[^:]+)(:(?P<port4>\d+))?|(?P<plain>.+)", address
    )
    if found is None:
        raise ValueError("is empty")
    host = ipaddress.ip_address(found["six"] or found["four"] or found["plain"])
    port = found["port6"] or found["port4"]
    if port is not None and not 0 < int(port) < 65536:
        raise ValueError("has no port of 1-65535")
    return str(host), None if port is None else int(port)


def _vehicle_address(value: str) -> str:
    try:
        host_and_port(value)
    except ValueError:
        raise ValueError("must be an IP address, or IP:PORT ([IPv6]:PORT)") from None
    return value


def _short_text(longest: int) -> Callable[[str], str]:
    """Return the check that a text has 1 to ``longest`` characters of printable ASCII."""

    def check(value: str) -> str:
        if not (1 <= len(value) <= longest and value.isascii() and value.isprintable() and value.strip() == value):
            raise ValueError(f"must have 1 to {longest} characters of plain ASCII, none of them a space at an end")
        return value

    return check


def _operator_id(value: str) -> str:
    if re.fullmatch(r"[A-Za-z]{3}[A-Za-z0-9]{13}-[A-Za-z0-9]{3}", value):
        raise ValueError("must not hold the secret part: leave out the dash and the three characters after it")
    return _short_text(20)(value)


class AutopilotSettings(Section):
    """Link to the autopilot."""

    url: Annotated[str, AfterValidator(check_autopilot_address)] = "udpin://127.0.0.1:14550"
    system_id: int = Field(default=245, ge=1, le=255)
    vehicle_system_id: int | None = Field(default=None, ge=1, le=255)
    vehicle_address: Annotated[str, AfterValidator(_vehicle_address)] | None = None
    connect_timeout_s: Retry = 5.0
    position_rate_hz: float = Field(default=20.0, ge=5, le=50)
    set_rtl_altitude: bool = True


class CameraSettings(Section):
    """Source of the pictures, and the camera's optics and mount."""

    url: Annotated[SecretUrl, AfterValidator(_camera)] = SecretUrl("http://127.0.0.1:8090/stream")
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
    operator_id: Annotated[str, AfterValidator(_operator_id)] | None = None
    operator_place: Literal["takeoff", "fixed"] = "takeoff"
    operator_latitude_deg: float | None = Field(default=None, ge=-90, le=90)
    operator_longitude_deg: float | None = Field(default=None, ge=-180, le=180)
    operator_height_m: float | None = Field(default=None, ge=-500, le=9000)
    description: Annotated[str, AfterValidator(_short_text(23))] | None = None
    serial_number: Annotated[str, AfterValidator(_short_text(20))] | None = None

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

    host: Annotated[str, AfterValidator(_page_host)] = "127.0.0.1"
    port: int = Field(default=3000, ge=0, le=65535)
    token: Annotated[SecretStr, AfterValidator(_at_least(16))] | None = None
    session_idle_h: float = Field(default=12.0, ge=0.25, le=168)
    session_limit_h: float = Field(default=168.0, ge=1, le=720)
    tls_certificate: FilePath | None = None
    tls_key: FilePath | None = None
    allowed_hosts: tuple[Annotated[str, AfterValidator(_page_name)], ...] = ()
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

    urls: tuple[Annotated[SecretUrl, AfterValidator(_receiver)], ...] = ()
    secret: Annotated[SecretStr, AfterValidator(_at_least(24)), AfterValidator(_signing_secret)] | None = None
    allow_private: bool = False

    @model_validator(mode="after")
    def _fit_together(self) -> WebhooksSettings:
        if self.urls and self.secret is None:
            raise ValueError("secret is missing: urls need it; make one with: echo whsec_$(openssl rand -base64 32)")
        return self


DAYS: Final = ("mon", "tue", "wed", "thu", "fri", "sat", "sun")


class ScheduledSurvey(Section):
    """A survey that is due on some days at a time. ``lot``: name or id."""

    lot: str = Field(min_length=1, max_length=80)
    at: str = Field(pattern=r"^([01]\d|2[0-3]):[0-5]\d$")
    days: tuple[Literal["mon", "tue", "wed", "thu", "fri", "sat", "sun"], ...] = Field(default=DAYS, min_length=1)
    time_zone: Annotated[str, AfterValidator(_time_zone)] | None = None

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
    schedule: tuple[ScheduledSurvey, ...] = ()
    watchdog: WatchdogSettings = WatchdogSettings()
    log: LogSettings = LogSettings()


def config_of(options: argparse.Namespace) -> Config:
    """Return the settings of a command with the options of `hawk.config.options.add_settings`. Raises ConfigError."""
    overrides = {} if options.store is None else {"store": {"directory": options.store}}
    return load_config(options.config, overrides=overrides)


def load_config(
    path: Path | None,
    environment: Mapping[str, str] = os.environ,
    overrides: Mapping[str, Mapping[str, Any]] | None = None,
) -> Config:
    """Return the checked settings.

    ``overrides`` (section -> key -> value) come from the command line. Raises ConfigError naming file, line and key.
    """
    text = ""
    if path is not None:
        try:
            text = path.read_text(encoding="utf-8-sig")
        except (OSError, UnicodeDecodeError) as error:
            raise ConfigError(f"{path}: cannot be read: {error}") from error
    try:
        values: dict[str, Any] = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise ConfigError(f"{path}: not TOML: {error}") from error
    variables: dict[tuple[str, str], str] = {}
    for name in sorted(name for name in environment if name.upper().startswith(ENVIRONMENT_PREFIX)):
        section, key = _setting_of(name)
        value = environment[name]
        variables[section, key] = name
        _section(values, section)[key] = value.replace(",", " ").split() if _is_list(section, key) else value
    for section, settings in (overrides or {}).items():
        _section(values, section).update(settings)
        variables = {at: name for at, name in variables.items() if at[0] != section or at[1] not in settings}
    for (section, key), removed in _REMOVED.items():
        given = values.get(section)
        if isinstance(given, dict) and given.get(key) in removed.holds_now:
            del given[key]
    try:
        return Config.model_validate(values)
    except ValidationError as error:
        raise ConfigError(_explain(error, path, text, variables)) from None


def variable_of(section: str, key: str) -> str:
    """Return the environment variable of a setting."""
    return f"{ENVIRONMENT_PREFIX}{section}__{key}".upper()


def _setting_of(variable: str) -> tuple[str, str]:
    """Return section and key of an environment variable; raises ConfigError for one that would change nothing."""
    section, _, key = variable.removeprefix(ENVIRONMENT_PREFIX).lower().partition("__")
    if key and variable.startswith(ENVIRONMENT_PREFIX):
        return section, key
    names = {variable_of(section, key): "" for section in Config.model_fields for key in section_fields(section)}
    near = difflib.get_close_matches(variable.upper(), names, n=1)
    remedy = f"write {near[0]}, or unset it" if near else "its form is HAWK_<SECTION>__<KEY>; unset it"
    raise ConfigError(f"{variable}: is no setting, and would change nothing: {remedy}")


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


def _is_list(section: str, key: str) -> bool:
    """Return True for a setting that is a list: in the environment its parts stand between commas or spaces."""
    field = section_fields(section).get(key)
    return field is not None and typing.get_origin(field.annotation) in (tuple, list)


def _section(values: dict[str, Any], name: str) -> dict[str, Any]:
    found = values.setdefault(name, {})
    if not isinstance(found, dict):
        raise ConfigError(f"{name}: is a value, must be a section: write [{name}]")
    return found


def _explain(error: ValidationError, path: Path | None, text: str, variables: Mapping[tuple[str, str], str]) -> str:
    """Return one line for each wrong setting: file and line, or environment variable, then key, what is wrong."""
    lines = []
    for wrong in wrong_values(error, Config):
        keys, message = [str(part) for part in wrong.location], wrong.reason
        if wrong.kind == "extra_forbidden":
            similar = f"is not a setting; see config.toml for those that are{_similar(keys)}"
            removed = _REMOVED.get((keys[0], keys[-1]))
            message = similar if removed is None else removed.remedy
        elif wrong.kind != "missing" and not _has_secret(keys):  # a secret, even a part of one, is not repeated
            message = f"{message} (found {wrong.given!r})"
        number = _line_of(keys, text)
        place = f"{path}, line {number}: " if number else f"{path}: " if path else ""
        if len(keys) > 1 and (variable := variables.get((keys[0], keys[1]))):
            place = f"{variable}: "
        lines.append(f"{place}{'.'.join(keys)}: {message}")
    return "\n".join(lines)


def _has_secret(keys: list[str]) -> bool:
    """Return True for a setting, a part of one or a section that holds a secret: an error goes into the journal."""
    fields = section_fields(keys[0]) if len(keys) > 1 else Config.model_fields
    field = fields.get(keys[min(1, len(keys) - 1)])
    return field is not None and is_secret(field.annotation)


def _similar(keys: list[str]) -> str:

    is_key = len(keys) > 1 and keys[0] in Config.model_fields
    names = list(section_fields(keys[0]) if is_key else Config.model_fields)
    near = difflib.get_close_matches(keys[-1], names, n=1)
    return f" (did you mean {near[0]}?)" if near else ""


def _line_of(keys: list[str], text: str) -> int | None:
    """Return the line on which the setting (else its section) stands in the TOML text, counted from 1."""
    section_line = None
    section: list[str] = []
    blocks: dict[str, int] = {}
    for number, line in enumerate(text.splitlines(), start=1):
        header = re.match(r"\s*(\[\[?)\s*([\w.-]+)\s*\]", line)
        if header:
            section = [header.group(2)]
            if header.group(1) == "[[":
                section.append(str(blocks.get(section[0], 0)))
                blocks[section[0]] = int(section[1]) + 1
            if section == keys[: len(section)]:
                section_line = number
        key = re.match(r"\s*([\w-]+)\s*=", line)
        if key and [*section, key.group(1)] == keys[: len(section) + 1]:
            return number
    return section_line


_OPTIONS: Final = (
    ("web", "host", "host"),
    ("web", "port", "port"),
    ("fence", "file", "fence"),
    ("flight", "outline_file", "outline"),
    ("autopilot", "url", "autopilot"),
    ("camera", "url", "camera"),
    ("store", "directory", "store"),
)
"""Section, key, and the option that sets them. A command need not have every option."""


def load_settings(options: argparse.Namespace) -> Config:
    """Return the settings of ``options.config`` with the command line's options applied. Raises ConfigError."""
    overrides: dict[str, dict[str, Any]] = {}
    for section, key, name in _OPTIONS:
        value = getattr(options, name, None)
        if value is not None:
            overrides.setdefault(section, {})[key] = value
    return load_config(options.config, overrides=overrides)


def refuse_existing(path: Path, remedy: str) -> None:
    """Raise ConfigError when the file of ``--out`` is there already, or its folder is closed to this user."""
    try:
        there = path.exists()
    except OSError as error:
        words = f"{path} cannot be written: {error.strerror or error}; name a folder that this user may write"
        raise ConfigError(f"--out: {words}") from error
    if there:
        raise ConfigError(f"--out: {path} exists already: {remedy}")
