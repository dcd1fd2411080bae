"""Calibration of the camera: from a file (ROS ``camera_info`` YAML) or from a field of view.

ROS ``camera_calibration`` writes the file: https://wiki.ros.org/camera_calibration_parsers
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

from hawk.config.sections import CameraSettings, ConfigError
from hawk.formats.validation import wrong_values
from hawk.model.pictures import CameraModel

_MODELS = {"plumb_bob": 5, "rational_polynomial": 8}
_ASPECT_TOLERANCE = 0.01

Finite = Annotated[float, Field(allow_inf_nan=False)]


class _Matrix(BaseModel):
    model_config = ConfigDict(extra="ignore")

    rows: int
    cols: int
    data: list[Finite]

    @model_validator(mode="after")
    def _complete(self) -> _Matrix:
        if len(self.data) != self.rows * self.cols:
            raise ValueError(f"data has {len(self.data)} numbers, must have rows * cols = {self.rows * self.cols}")
        return self


class _CameraInfo(BaseModel):
    """The used keys of a ``camera_info`` file."""

    model_config = ConfigDict(extra="ignore")

    image_width: int = Field(gt=0, le=20_000)
    image_height: int = Field(gt=0, le=20_000)
    camera_matrix: _Matrix
    distortion_model: str = "plumb_bob"
    distortion_coefficients: _Matrix

    @model_validator(mode="after")
    def _sensible(self) -> _CameraInfo:
        if (self.camera_matrix.rows, self.camera_matrix.cols) != (3, 3):
            raise ValueError("camera_matrix must be 3 x 3")
        fx, _, cx, _, fy, cy = self.camera_matrix.data[:6]
        if fx <= 0 or fy <= 0:
            raise ValueError("camera_matrix: the focal lengths (data[0] and data[4]) must be above 0")
        if not (0 < cx < self.image_width and 0 < cy < self.image_height):
            raise ValueError("camera_matrix: the principal point (data[2], data[5]) lies outside the picture")
        known = _MODELS.get(self.distortion_model)
        if known is None:
            raise ValueError(
                f"distortion_model {self.distortion_model!r} is not known: use one of {', '.join(_MODELS)}"
            )
        coefficients = self.distortion_coefficients.data
        if len(coefficients) > known:
            raise ValueError(f"distortion_coefficients: {self.distortion_model} has at most {known} numbers")
        if any(coefficients[5:]):
            raise ValueError("distortion_coefficients: k4 to k6 are not supported: calibrate with plumb_bob")
        return self


@dataclass(frozen=True, slots=True)
class Calibration:
    """A camera's calibration. Without ``at`` a field of view, valid for every size of pictures."""

    mount: tuple[float, float, float]
    """Roll, pitch, yaw of the mount, radians."""
    horizontal_fov: float
    """Radians; used without ``at`` only."""
    at: _CameraInfo | None = None

    def misfit(self, width: int, height: int) -> str:
        """Return the reason why pictures of this size (pixels) do not fit; empty when they do."""
        at = self.at
        if at is None or abs((width / height) / (at.image_width / at.image_height) - 1) <= _ASPECT_TOLERANCE:
            return ""
        return (
            f"pictures are {width} x {height}, the calibration is for {at.image_width} x {at.image_height}: "
            "set the camera to that shape or calibrate it again"
        )

    def for_size(self, width: int, height: int) -> CameraModel:
        """Return the camera for pictures of this size (pixels); the calibration is scaled to it."""
        at = self.at
        if at is None:
            focal = width / 2 / math.tan(self.horizontal_fov / 2)
            return CameraModel(width, height, focal, focal, width / 2, height / 2, (), *self.mount)
        across, down = width / at.image_width, height / at.image_height
        fx, _, cx, _, fy, cy = at.camera_matrix.data[:6]
        # pixel centres are whole numbers: half a pixel is added before scaling
        cx, cy = (cx + 0.5) * across - 0.5, (cy + 0.5) * down - 0.5
        distortion = tuple(at.distortion_coefficients.data[:5])
        return CameraModel(width, height, fx * across, fy * down, cx, cy, distortion, *self.mount)


def load_calibration(settings: CameraSettings) -> Calibration:
    """Return the calibration of the settings. Raises ConfigError naming file and key."""
    mount = tuple(map(math.radians, (settings.mount_roll_deg, settings.mount_pitch_deg, settings.mount_yaw_deg)))
    info = None if settings.calibration is None else _read(settings.calibration)
    return Calibration((mount[0], mount[1], mount[2]), math.radians(settings.horizontal_fov_deg), info)


def _read(path: Path) -> _CameraInfo:
    try:
        content: Any = YAML(typ="safe", pure=True).load(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError(f"camera.calibration: {path} cannot be read: {error}") from error
    except YAMLError as error:
        text = " ".join(str(error).split())
        raise ConfigError(f"camera.calibration: {path} is not YAML: {text}") from error
    if not isinstance(content, dict):
        raise ConfigError(f"camera.calibration: {path} is no camera_info file: it has no keys")
    try:
        return _CameraInfo.model_validate(content)
    except ValidationError as error:
        found = wrong_values(error, _CameraInfo)
        problems = [f"{wrong.path or 'camera_info'}: {wrong.reason}" for wrong in found]
        raise ConfigError("\n".join(f"camera.calibration: {path}: {problem}" for problem in problems)) from None
