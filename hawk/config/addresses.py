"""Hosts, ports and files as settings and options name them: one reading for all, with a remedy in each refusal."""

from __future__ import annotations

import ipaddress
import re
import shlex
from pathlib import Path
from typing import Annotated, Any, Final, Literal, TypeVar
from urllib.parse import parse_qsl, unquote, urlsplit

from pydantic import BaseModel, ConfigDict, Field, StringConstraints, ValidationError, model_validator

BAUD_RATES: Final = (
    *(9600, 19200, 38400, 57600, 115200, 230400, 460800, 500000, 576000, 921600),
    *(1000000, 1152000, 1500000, 2000000, 2500000, 3000000, 3500000, 4000000),
)
"""Of a serial line, bits a second: those that MAVSDK 4.1 knows."""
SERIAL_KINDS: Final = ("serial://", "serial_flowcontrol://")
AUTOPILOT_KINDS: Final = ("udpin://", "udpout://", "tcpin://", "tcpout://", *SERIAL_KINDS)
"""Links that MAVSDK opens."""
MOST_PORT: Final = 65535
_LABEL: Final = re.compile(r"(?!-)[A-Za-z0-9_-]{1,63}(?<!-)")
_LONGEST_NAME: Final = 253


def usable_path(value: str | Path) -> Path:
    """Return a path with ``~`` replaced by the home folder. Raises ValueError for one that names nothing."""
    text = str(value)
    if not text.strip() or "\0" in text:
        raise ValueError("is empty: name a file or a folder, or leave it out")
    try:
        return Path(text).expanduser()
    except RuntimeError:
        raise ValueError(f"no home folder is known for {text.partition('/')[0]}: write the path in full") from None


def check_host(text: str) -> str:
    """Return the host's name or IP address (IPv6 without brackets). Raises ValueError."""
    address, _, scope = text.partition("%")
    try:
        ipaddress.ip_address(address)
    except ValueError:
        pass
    else:
        return text if not scope or _LABEL.fullmatch(scope) else _no_host(text)
    labels = text.removesuffix(".").split(".")
    is_name = all(_LABEL.fullmatch(label) for label in labels) and len(text) <= _LONGEST_NAME
    return text if is_name and not labels[-1].isdigit() else _no_host(text)


def _no_host(text: str) -> str:
    if not text:
        raise ValueError("names no host: write its name or IP address")
    raise ValueError(f"{text!r} is no host: write a name (drone.local) or an IP address (192.168.1.10)")


def check_port(text: str, least: int = 1) -> int:
    """Return a port. Raises ValueError."""
    if not (text.isascii() and text.isdigit() and least <= int(text[:6]) <= MOST_PORT):
        raise ValueError(f"the port must be {least} to {MOST_PORT}, not {text!r}")
    return int(text)


def check_autopilot_address(url: str) -> str:
    """Return a URL that MAVSDK can open, without a slash at its end. Raises ValueError with the form that is needed."""
    kind = next((each for each in AUTOPILOT_KINDS if url.startswith(each)), None)
    if kind is None:
        raise ValueError(f"must start with {_choice(AUTOPILOT_KINDS)}")
    place = url.removeprefix(kind)
    if kind in SERIAL_KINDS:
        _check_serial(kind, place)
        return url
    place = place.rstrip("/")
    host, colon, port = place.rpartition(":")
    if not colon or not host:
        raise ValueError(f"names no host and port: write {kind}HOST:PORT")
    check_port(port)
    is_ipv6 = host.startswith("[") and host.endswith("]")
    check_host(host[1:-1] if is_ipv6 else host)
    if ":" in host and not is_ipv6:
        raise ValueError(f"put the IPv6 address in brackets: {kind}[{host}]:{port}")
    if is_ipv6 and kind.startswith("tcp"):
        raise ValueError("MAVSDK opens TCP by IPv4 only: write an IPv4 address")
    if kind == "tcpin://" and not _is_address(host):
        raise ValueError(f"{host!r} is no address to listen on: write this computer's IP address, or 0.0.0.0 for all")
    return kind + place


def _check_serial(kind: str, place: str) -> None:
    device, colon, baud = place.rpartition(":")
    form = f"write {kind}/dev/ttyAMA0:921600"
    if not colon:
        raise ValueError(f"names no baud rate: {form}")
    if not device.startswith("/") or device.endswith("/"):
        raise ValueError(f"names no device: {form}")
    if not (baud.isascii() and baud.isdigit() and int(baud[:8]) in BAUD_RATES):
        raise ValueError(f"{baud!r} is no baud rate: one of {', '.join(map(str, BAUD_RATES))}")


def check_network_url(url: str) -> str:
    """Return a URL with a host and, if it names one, a port (``http://CAMERA:8080/stream``).

    Raises:
        ValueError: With the form that is needed, and without user and password.
    """
    scheme, _, rest = url.partition("://")
    form = f"write {scheme}://HOST:PORT/PATH"
    if any(letter.isspace() or not letter.isprintable() for letter in url):
        raise ValueError(f"has a space: write %20 in its place, {form}")
    place = _authority(rest)
    if "@" in place:
        place = place.rpartition("@")[2]
    elif "@" in rest and not _is_place(place):  # a password with a slash
        place = _authority(rest.rpartition("@")[2])
    if not place or place.startswith(":"):
        raise ValueError(f"names no host: {form}")
    check_place(place)
    return url


def check_place(text: str) -> tuple[str, int | None]:
    """Return host (IPv6 without brackets) and port of ``HOST``, ``HOST:PORT`` or ``[IPv6]:PORT``. Raises ValueError."""
    found = re.fullmatch(r"(?:\[(?P<six>[^\]]*)\]|(?P<host>[^:]*))(?::(?P<port>.*))?", text)
    if found is None:
        return _no_host(text), None
    return check_host(found["six"] or found["host"] or ""), None if found["port"] is None else check_port(found["port"])


def _authority(text: str) -> str:
    return re.split(r"[/?#]", text, maxsplit=1)[0]


def _is_place(text: str) -> bool:
    try:
        check_place(text)
    except ValueError:
        return False
    return True


def _is_address(host: str) -> bool:
    try:
        ipaddress.IPv4Address(host)
    except ValueError:
        return False
    return True


def _choice(kinds: tuple[str, ...]) -> str:
    return f"{', '.join(kinds[:-1])} or {kinds[-1]}"


RPICAM: Final = "rpicam:"
V4L2: Final = "v4l2://"
GSTREAMER: Final = "gst:"
FILM: Final = "file://"
NETWORK: Final = ("http://", "https://", "rtsp://", "rtsps://")
CAMERA_KINDS: Final = (*NETWORK[:2], RPICAM, V4L2, *NETWORK[2:], FILM, GSTREAMER)
"""Sources of pictures."""

Pixels = Annotated[int, Field(ge=64, le=9152)]
"""Up to the widest sensor for a Raspberry Pi, of 64 megapixels."""
Rate = Annotated[float, Field(ge=1, le=240)]
Word = Annotated[str, StringConstraints(pattern=r"^[a-z_]+$")]
M = TypeVar("M", bound="_Camera")


class _Camera(BaseModel):
    """Size and rate of any camera: the width with the height, or neither."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, populate_by_name=True, alias_generator=lambda name: name.replace("_", "-")
    )

    width: Pixels | None = None
    height: Pixels | None = None
    framerate: Rate | None = None

    @model_validator(mode="after")
    def _has_a_whole_size(self) -> _Camera:
        if (self.width is None) != (self.height is None):
            raise ValueError("name width and height, or neither of them")
        return self


class RpicamCamera(_Camera):
    """A camera on the Raspberry Pi's CSI connector. Options have the names that ``rpicam-vid`` gives them."""

    number: int = Field(default=0, ge=0, le=9)
    """As ``rpicam-hello --list-cameras`` numbers it."""
    shutter: int | None = Field(default=None, ge=10, le=1_000_000)
    """Fixed exposure, microseconds."""
    gain: float | None = Field(default=None, ge=1, le=64)
    exposure: Literal["normal", "sport"] = "sport"
    """``sport``: short exposures and more gain, for a camera that moves."""
    awb: Word | None = None
    denoise: Word | None = None
    quality: int = Field(default=85, ge=10, le=100)
    """Of the JPEG."""
    rotation: Literal["0", "180"] | None = None
    lens_position: float = Field(default=0.0, ge=0, le=32)
    """Focus, 1/metres; 0: infinity. A camera without a motor ignores it."""
    tuning_file: Path | None = None


class V4l2Camera(_Camera):
    """A camera of Linux's V4L2: USB, and whatever else is a ``/dev/video``."""

    device: Path
    format: Annotated[str, StringConstraints(pattern=r"^[A-Z0-9]{4}$")] | None = None
    """Four letters, as ``v4l2-ctl --list-formats`` shows them; None: MJPG, else YUYV, else any."""


def rpicam_camera(url: str) -> RpicamCamera:
    """Return the camera of ``rpicam:NUMBER?OPTIONS``. Raises ValueError naming the option and those that there are."""
    number, _, query = url.removeprefix(RPICAM).partition("?")
    named = {"number": number} if number else {}
    return _checked(RpicamCamera, query, named)


def v4l2_camera(url: str) -> V4l2Camera:
    """Return the camera of ``v4l2:///dev/PATH?OPTIONS``. Raises ValueError, as `rpicam_camera` does."""
    parts = urlsplit(url)
    path = unquote(parts.path)
    if parts.netloc or not path.rstrip("/").startswith("/"):
        raise ValueError("write three slashes before the device: v4l2:///dev/video0")
    return _checked(V4l2Camera, parts.query, {"device": path})


def check_camera_address(url: str) -> str:
    """Return the address. Raises ValueError for one that names no source, and for options that its kind has not."""
    if url.startswith(RPICAM):
        rpicam_camera(url)
    elif url.startswith(V4L2):
        v4l2_camera(url)
    elif url.startswith(NETWORK):
        check_network_url(url)
    elif url.startswith(GSTREAMER):
        _check_pipeline(url.removeprefix(GSTREAMER))
    elif url.startswith(FILM):
        _check_film(url)
    else:
        raise ValueError(f"must start with {', '.join(CAMERA_KINDS[:-1])} or {CAMERA_KINDS[-1]}")
    return url


def _check_pipeline(pipeline: str) -> None:
    example = "write gst:v4l2src ! videoconvert (a pipeline of GStreamer without its sink)"
    try:
        parts = shlex.split(pipeline)
    except ValueError as error:
        raise ValueError(f"the pipeline cannot be read ({error}): {example}") from None
    if not parts:
        raise ValueError(f"names no pipeline: {example}")
    if parts[0] == "!" or parts[-1] == "!":
        raise ValueError(f"the pipeline begins or ends with an exclamation mark: {example}")


def _check_film(url: str) -> None:
    parts = urlsplit(url)
    if parts.netloc or unquote(parts.path).rstrip("/") == "":
        raise ValueError("write three slashes before the film: file:///home/pilot/film.mp4")


def _checked(model: type[M], query: str, named: dict[str, Any]) -> M:
    options = dict(parse_qsl(query, keep_blank_values=True))
    known = [name.replace("_", "-") for name in model.model_fields if name not in named and name != "number"]
    unknown = sorted(options.keys() - known)
    if unknown:
        raise ValueError(f"has no option {unknown[0]!r}; there are {', '.join(known)}")
    try:
        return model.model_validate({**named, **options})
    except ValidationError as error:
        problem = error.errors(include_url=False)[0]
        name = str(problem["loc"][0]) if problem["loc"] else ""
        raise ValueError(f"{name}: {problem['msg'].removeprefix('Value error, ')}".removeprefix(": ")) from None


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
