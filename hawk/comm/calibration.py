"""How the camera sees: from a calibration file (ROS ``camera_info`` YAML) or from a field of view.

The file is what ROS ``camera_calibration`` writes: https://wiki.ros.org/camera_calibration_parsers
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

from hawk.config import CameraSettings, ConfigError
from hawk.model import CameraModel

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
    """The keys of a ``camera_info`` file that are used here."""

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
    """A camera at the size it was calibrated at (``width`` None: a field of view, good for every size)."""

    width: int | None
    height: int | None
    fx: float
    fy: float
    cx: float
    cy: float
    horizontal_fov: float
    distortion: tuple[float, ...]
    mount: tuple[float, float, float]

    def misfit(self, width: int, height: int) -> str:
        """Return why pictures of this size do not fit the calibration; empty when they do."""
        if self.width is None or self.height is None:
            return ""
        if abs((width / height) / (self.width / self.height) - 1) <= _ASPECT_TOLERANCE:
            return ""
        return (
            f"pictures are {width} x {height}, the calibration is for {self.width} x {self.height}: "
            "set the camera to that shape or calibrate it again"
        )

    def for_size(self, width: int, height: int) -> CameraModel:
        """Return the camera for pictures of this size (pixels); the calibration is scaled to it."""
        roll, pitch, yaw = self.mount
        if self.width is None or self.height is None:
            focal = width / 2 / math.tan(self.horizontal_fov / 2)
            fx, fy, cx, cy = focal, focal, width / 2, height / 2
        else:
            across, down = width / self.width, height / self.height
            # pixel centres are whole numbers, so that half a pixel is added before scaling
            cx, cy = (self.cx + 0.5) * across - 0.5, (self.cy + 0.5) * down - 0.5
            fx, fy = self.fx * across, self.fy * down
        return CameraModel(width, height, fx, fy, cx, cy, self.distortion, roll, pitch, yaw)


def load_calibration(settings: CameraSettings) -> Calibration:
    """Return the calibration that the settings name. Raises ConfigError naming file and key."""
    mount = (
        math.radians(settings.mount_roll_deg),
        math.radians(settings.mount_pitch_deg),
        math.radians(settings.mount_yaw_deg),
    )
    if settings.calibration is None:
        fov = math.radians(settings.horizontal_fov_deg)
        return Calibration(None, None, 0.0, 0.0, 0.0, 0.0, fov, (), mount)
    info = _read(settings.calibration)
    fx, _, cx, _, fy, cy = info.camera_matrix.data[:6]
    fov = 2 * math.atan(info.image_width / 2 / fx)
    distortion = tuple(info.distortion_coefficients.data[:5])
    return Calibration(info.image_width, info.image_height, fx, fy, cx, cy, fov, distortion, mount)


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
        problems = [
            f"{'.'.join(str(part) for part in problem['loc']) or 'camera_info'}: "
            f"{problem['msg'].removeprefix('Value error, ')}"
            for problem in error.errors(include_url=False)
        ]
        raise ConfigError("\n".join(f"camera.calibration: {path}: {problem}" for problem in problems)) from None
