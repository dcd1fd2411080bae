"""Pictures: the camera that takes them, and the one that operators see."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class CameraModel:
    """Pinhole camera with radial-tangential distortion (ROS ``plumb_bob``) and its mount.

    ``fx, fy, cx, cy`` in pixels of a ``width`` x ``height`` picture; ``distortion`` is k1, k2, p1, p2, k3. Mount angles
    (radians) turn the camera away from looking straight down with the picture's top towards the nose.
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    distortion: tuple[float, ...] = ()
    mount_roll: float = 0.0
    mount_pitch: float = 0.0
    mount_yaw: float = 0.0


@dataclass(frozen=True, slots=True)
class AnnotatedFrame:
    """An annotated picture for the operators; ``captured`` is seconds of the daemon's clock."""

    sequence: int
    captured: float
    jpeg: bytes = field(repr=False)
