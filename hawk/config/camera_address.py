"""Options in the addresses of cameras: ``rpicam:0?width=1456&height=1088`` and ``v4l2:///dev/video0?width=1280``."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated, Any, Final, Literal, TypeVar
from urllib.parse import parse_qsl, unquote, urlsplit

from pydantic import BaseModel, ConfigDict, Field, StringConstraints, ValidationError, model_validator

from hawk.config.addresses import check_network_url

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
