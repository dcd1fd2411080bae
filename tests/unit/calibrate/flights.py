"""Flights with known errors of the camera: a drone that brakes, leans, turns and wobbles, and what its camera sees."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hawk.calibrate.flight import Flight, Flown, Look, Track
from hawk.calibrate.pairs import Matches, Pair, carried, choose_pairs, mounted
from hawk.model.pictures import CameraModel
from hawk.model.poses import MapPose

Floats = NDArray[np.float64]

STEP_S = 0.02
GRAVITY = 9.81
CAMERA = CameraModel(640, 360, 457.0, 457.0, 319.5, 179.5)


@dataclass(frozen=True)
class Errors:
    """``late``: seconds by which the pictures are taken later than stamped; mount in degrees."""

    late: float = 0.0
    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0

    @property
    def mount(self) -> Floats:
        return np.radians([self.roll, self.pitch, self.yaw])


def lanes(seconds: float, *, seed: int = 0, wobble: float = 0.02, turns: bool = True, speed: float = 4.0) -> Track:
    """A flight in lanes of 8 s at 25 m, every STEP_S; the nose turns with the lane where ``turns``."""
    rng = np.random.default_rng(seed)
    count = round(seconds / STEP_S)
    times: Floats = np.arange(count, dtype=np.float64) * STEP_S
    heading = np.array([0.3, 0.3 + math.pi / 2, 0.3 + math.pi, 0.3 + math.pi / 2])[(times // 8 % 4).astype(int)]
    wanted = speed * np.column_stack([np.cos(heading), np.sin(heading)])
    velocity = np.empty((count, 2))
    yaw = np.empty(count)
    now, nose = wanted[0].copy(), heading[0]
    for k in range(count):
        now = now + np.clip((wanted[k] - now) / 0.8, -2.5, 2.5) * STEP_S
        nose += float(np.clip(math.remainder(heading[k] - nose, math.tau), -0.8, 0.8)) * STEP_S if turns else 0.0
        velocity[k], yaw[k] = now, nose
    push = np.asarray(np.gradient(velocity, STEP_S, axis=0)) / GRAVITY
    lean = np.column_stack(
        [-np.sin(yaw) * push[:, 0] + np.cos(yaw) * push[:, 1], -np.cos(yaw) * push[:, 0] - np.sin(yaw) * push[:, 1]]
    )
    lean = np.column_stack([_smooth(lean[:, k], 0.3) + wobble * _wave(rng, times) for k in range(2)])
    place = np.cumsum(velocity, axis=0) * STEP_S
    height = 25 + 0.3 * _wave(rng, times)
    return Track(times, np.column_stack([place, height, lean, yaw]))


def _smooth(values: Floats, seconds: float) -> Floats:
    kept, out = 0.0, np.empty_like(values)
    for k, value in enumerate(values):
        kept += (value - kept) * STEP_S / seconds
        out[k] = kept
    return out


def _wave(rng: np.random.Generator, times: Floats) -> Floats:
    """Sum of sines of periods from 0.9 to 6 s, about 1 high."""
    waves = [np.sin(math.tau * times / rng.uniform(0.9, 6.0) + rng.uniform(0, math.tau)) for _ in range(4)]
    return np.asarray(np.sum(waves, axis=0) / math.sqrt(2))


def reported(true: Track, *, seed: int = 0, drift: float = 0.0, lean: float = 0.0) -> Track:
    """The poses as the autopilot reports them: GNSS drifts (m/s), attitudes err (radians)."""
    rng = np.random.default_rng(1000 + seed)
    count = len(true.times)
    poses = true.poses.copy()
    for k, size, keep_s in ((0, drift, 10.0), (1, drift, 10.0), (3, lean, 2.0), (4, lean, 2.0)):
        keep = math.exp(-STEP_S / keep_s)
        noise = rng.normal(0, size * math.sqrt(1 - keep**2), count)
        walk = np.empty(count)
        value = rng.normal(0, size)
        for n in range(count):
            value = keep * value + noise[n]
            walk[n] = value
        poses[:, k] += np.cumsum(walk) * STEP_S if k < 2 else walk
    return Track(true.times, poses)


def flight(
    track: Track, *, every_s: float = 0.14, camera: CameraModel = CAMERA, path: Path = Path("none.mcap")
) -> Flight:
    """The flight as it is recorded, without pictures."""
    times = np.arange(track.times[0] + 0.1, track.times[-1] - 0.1, every_s)
    poses = [MapPose(*(float(value) for value in row)) for row in track.at(times)]
    looks = tuple(Look(k, float(t), p, 4.0, 0.0) for k, (t, p) in enumerate(zip(times, poses, strict=True)))
    return Flight(path, camera, Flown(0.08), track, looks)


def seen(pairs: list[Pair], true: Track, errors: Errors, *, seed: int = 0, pixels: float = 0.3) -> list[Matches]:
    """Points that the pairs share, by the true poses at the true exposures."""
    rng = np.random.default_rng(seed)
    rays = rng.uniform((-0.7, -0.39), (0.7, 0.39), (len(pairs), 80, 2))
    before, now = (
        true.at(np.array([look.captured for look in looks]) + errors.late)
        for looks in ([pair.before for pair in pairs], [pair.now for pair in pairs])
    )
    again = carried(rays, before, now, mounted(errors.mount))
    again += rng.normal(0, pixels / CAMERA.fx, again.shape)
    found = []
    for k, pair in enumerate(pairs):
        inside = (np.abs(again[k]) < (0.7, 0.39)).all(1)
        found.append(Matches(pair, rays[k][inside][:40], again[k][inside][:40]))
    return found


def all_pairs(track: Track) -> list[Pair]:
    return choose_pairs(flight(track))
