"""Settings: read from ``config.toml``, from environment variables and from the command line, in this order of rank
(the last wins), and checked as a whole before anything starts.

``config.toml`` in the project's root is the reference: every setting with unit, default and what it does.
"""

from __future__ import annotations

import difflib
import os
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError, model_validator

ENVIRONMENT_PREFIX = "HAWK_"
"""``HAWK_WEB__PORT=3001`` sets ``port`` of section ``web``."""

Seconds = Annotated[float, Field(gt=0, le=3600)]
Positive = Annotated[float, Field(gt=0)]
Degrees = Annotated[float, Field(ge=-180, le=180)]


class ConfigError(Exception):
    """A setting that cannot be used; the text names file, line, key and remedy."""


class Section(BaseModel):
    """Base of a section: unknown keys are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


AUTOPILOT_KINDS = ("udpin://", "udpout://", "tcpin://", "tcpout://", "serial://", "serial_flowcontrol://")
"""Links that MAVSDK opens."""
CAMERA_KINDS = ("http://", "https://", "v4l2://", "rtsp://", "rtsps://", "file://", "gst:")
"""Sources of pictures."""


def _address(*kinds: str) -> AfterValidator:
    """Return the check that an address begins with one of these prefixes."""

    def check(value: str) -> str:
        if not value.startswith(kinds):
            raise ValueError(f"must start with {', '.join(kinds[:-1])} or {kinds[-1]}")
        return value

    return AfterValidator(check)


class AutopilotSettings(Section):
    """Link to the autopilot."""

    url: Annotated[str, _address(*AUTOPILOT_KINDS)] = "udpin://0.0.0.0:14550"
    system_id: int = Field(default=245, ge=1, le=255)
    connect_timeout_s: Seconds = 5.0
    position_rate_hz: Positive = 20.0
    set_rtl_altitude: bool = True


class CameraSettings(Section):
    """Source of the pictures, and the camera's optics and mount."""

    url: Annotated[str, _address(*CAMERA_KINDS)] = "http://127.0.0.1:8090/stream"
    horizontal_fov_deg: float = Field(default=70.0, gt=5, lt=170)
    calibration: Path | None = None
    mount_roll_deg: Degrees = 0.0
    mount_pitch_deg: Degrees = 0.0
    mount_yaw_deg: Degrees = 0.0
    latency_s: float = Field(default=0.08, ge=0, le=5)
    exposure_s: float = Field(default=0.01, gt=0, le=1)
    reconnect_s: Seconds = 1.0


class HeightSettings(Section):
    """Travel heights until the operator configures others, metres above the arm place."""

    minimum_m: Positive = 15.0
    desired_m: Positive = 35.0
    maximum_m: Positive = 60.0
    ceiling_m: Positive = 100.0

    @model_validator(mode="after")
    def _ordered(self) -> HeightSettings:
        if not self.minimum_m <= self.desired_m <= self.maximum_m <= self.ceiling_m:
            raise ValueError("heights must rise: minimum_m <= desired_m <= maximum_m <= ceiling_m")
        return self


class FlightSettings(Section):
    """Flight and battery limits."""

    speed_m_s: float = Field(default=4.0, gt=0, le=15)
    tick_hz: float = Field(default=20.0, ge=5, le=50)
    arrival_radius_m: Positive = 1.5
    explore_cm_per_pixel: float | None = Field(default=None, ge=0.5, le=10)
    explore_lost_lot_s: Seconds = 10.0
    battery_reserve_percent: float = Field(default=20.0, ge=5, le=80)
    battery_arm_percent: float = Field(default=30.0, ge=5, le=100)
    maximum_hdop_m: Positive = 3.0


class FenceSettings(Section):
    """Limits of the flight."""

    file: Path | None = None
    radius_m: float = Field(default=150.0, gt=20, le=2000)
    margin_m: float = Field(default=5.0, ge=1, le=50)
    ceiling_margin_m: float = Field(default=3.0, ge=1, le=20)


class OperatorSettings(Section):
    """Timeouts for a lost operator."""

    operator_timeout_s: Seconds = 10.0
    operator_hold_s: Seconds = 30.0
    control_lease_s: Seconds = 30.0


class VisionSettings(Section):
    """Perception."""

    model: Path | None = None
    use_network: bool = True
    threads: int = Field(default=1, ge=1, le=8)
    minimum_height_m: float = Field(default=6.0, ge=1, le=100)
    minimum_stalls: int = Field(default=3, ge=1, le=100)


class WebSettings(Section):
    """The operator page."""

    host: str = "127.0.0.1"
    port: int = Field(default=3000, ge=0, le=65535)
    token: str | None = Field(default=None, min_length=16)
    allowed_hosts: tuple[str, ...] = ()
    maximum_clients: int = Field(default=20, ge=1, le=1000)
    video_width: int = Field(default=960, ge=160, le=1920)
    video_quality: int = Field(default=75, ge=20, le=95)


class StoreSettings(Section):
    """Storage on disk."""

    directory: Path = Path("var")
    record: bool = True
    minimum_free_mb: int = Field(default=500, ge=1)


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
    vision: VisionSettings = VisionSettings()
    web: WebSettings = WebSettings()
    store: StoreSettings = StoreSettings()
    watchdog: WatchdogSettings = WatchdogSettings()
    log: LogSettings = LogSettings()


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
            text = path.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise ConfigError(f"{path}: cannot be read: {error}") from error
    try:
        values: dict[str, Any] = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{path}: not TOML: {error}") from error
    for name in sorted(name for name in environment if name.startswith(ENVIRONMENT_PREFIX)):
        section, _, key = name.removeprefix(ENVIRONMENT_PREFIX).lower().partition("__")
        if key:
            _section(values, section)[key] = environment[name]
    for section, settings in (overrides or {}).items():
        _section(values, section).update(settings)
    try:
        return Config.model_validate(values)
    except ValidationError as error:
        raise ConfigError(_explain(error, path, text)) from None


def _section(values: dict[str, Any], name: str) -> dict[str, Any]:
    found = values.setdefault(name, {})
    if not isinstance(found, dict):
        raise ConfigError(f"{name}: is a value, must be a section: write [{name}]")
    return found


def _explain(error: ValidationError, path: Path | None, text: str) -> str:
    """Return one line for each wrong setting: file, line, key, what is wrong."""
    lines = []
    for problem in error.errors(include_url=False):
        keys = [str(part) for part in problem["loc"]]
        message = problem["msg"].removeprefix("Value error, ")
        if problem["type"] == "extra_forbidden":
            message = f"is not a setting; see config.toml for those that are{_similar(keys)}"
        elif problem["type"] == "missing":
            message = "is missing"
        elif keys[-1:] != ["token"]:  # a secret, even a part of one, is not repeated
            message = f"{message} (found {problem['input']!r})"
        number = _line_of(keys, text)
        place = f"{path}, line {number}: " if number else f"{path}: " if path else ""
        lines.append(f"{place}{'.'.join(keys)}: {message}")
    return "\n".join(lines)


def _similar(keys: list[str]) -> str:

    fields = Config.model_fields
    if len(keys) > 1 and keys[0] in fields:
        section = fields[keys[0]].annotation
        names = list(getattr(section, "model_fields", {}))
    else:
        names = list(fields)
    near = difflib.get_close_matches(keys[-1], names, n=1)
    return f" (did you mean {near[0]}?)" if near else ""


def _line_of(keys: list[str], text: str) -> int | None:
    """Return the line on which the setting (else its section) stands in the TOML text, counted from 1."""
    section_line = None
    section = ""
    for number, line in enumerate(text.splitlines(), start=1):
        header = re.match(r"\s*\[\s*([\w.-]+)\s*\]", line)
        if header:
            section = header.group(1)
            if section == keys[0]:
                section_line = number
        key = re.match(r"\s*([\w-]+)\s*=", line)
        if key and [section, key.group(1)] == keys[:2]:
            return number
        if key and not section and [key.group(1)] == keys[:1]:
            return number
    return section_line
