"""Kinds of settings: their bounds, and the checks of texts, addresses, secrets and files."""

from __future__ import annotations

import base64
import binascii
import re
from collections.abc import Callable
from ipaddress import ip_address
from pathlib import Path
from typing import Annotated, Any
from urllib.parse import urlsplit
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

from pydantic import AfterValidator, BeforeValidator, Field, SecretStr

from hawk.config.addresses import (
    check_autopilot_address,
    check_camera_address,
    check_host,
    host_and_port,
    usable_path,
)
from hawk.config.secrets import SecretUrl

Retry = Annotated[float, Field(ge=0.01, le=60)]
"""Seconds until something is tried again, or shown as missing."""
TravelHeight = Annotated[float, Field(ge=2, le=500)]
"""Metres above the arm place: above people and cars, and below the 1000 m of ArduCopter's FENCE_ALT_MAX."""
Degrees = Annotated[float, Field(ge=-180, le=180)]


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


def _desk(value: SecretUrl) -> SecretUrl:
    url = urlsplit(_receiver(value).get_secret_value())
    if url.scheme.lower() != "https" and not _is_here(url.hostname or ""):
        raise ValueError("must begin with https://: others on this network could read the token")
    return value


def _is_here(host: str) -> bool:
    """Return True for a host that is this computer."""
    try:
        return host == "localhost" or ip_address(host).is_loopback
    except ValueError:
        return False


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


def _tidy(value: object) -> object:
    return " ".join(value.split()) if isinstance(value, str) else value


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


AutopilotAddress = Annotated[str, AfterValidator(check_autopilot_address)]
VehicleAddress = Annotated[str, AfterValidator(_vehicle_address)]
CameraAddress = Annotated[SecretUrl, AfterValidator(_camera)]
ReceiverAddress = Annotated[SecretUrl, AfterValidator(_receiver)]
DeskAddress = Annotated[SecretUrl, AfterValidator(_desk)]
PageHost = Annotated[str, AfterValidator(_page_host)]
PageName = Annotated[str, AfterValidator(_page_name)]
PageToken = Annotated[SecretStr, AfterValidator(_at_least(16))]
SigningSecret = Annotated[SecretStr, AfterValidator(_at_least(24)), AfterValidator(_signing_secret)]
OperatorId = Annotated[str, AfterValidator(_operator_id)]
Description = Annotated[str, AfterValidator(_short_text(23))]
SerialNumber = Annotated[str, AfterValidator(_short_text(20))]
LotName = Annotated[str, BeforeValidator(_tidy)]
"""A lot's name or id, without space around it: a lot's own name has none."""
ZoneName = Annotated[str, AfterValidator(_time_zone)]
"""A name of the time zone database."""
