"""Poses of the shots of one flight: as their files say them, adjusted together, at the scale of all witnesses."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Final

import numpy as np
import pymap3d

from hawk.algo.vision.detector import StallDetector
from hawk.model.poses import GlobalPose
from hawk.picture.checkpoints import Checkpoints
from hawk.picture.photographs.heights import HIGHEST_M, doubt_of, guess_heights
from hawk.picture.photographs.places import unwrap_longitudes, wrap_longitudes
from hawk.picture.photographs.scale import (
    HeightPrior,
    Scale,
    ScaleEstimate,
    by_height,
    by_places,
    by_stalls,
    choose_scale,
    middle_height,
    scale_poses,
)
from hawk.picture.photographs.shot_detections import ShotReader
from hawk.picture.reconstruction.alignment import PosePrior, Reconstruction, reconstruct
from hawk.picture.reconstruction.camera_pose import CameraPose
from hawk.picture.reconstruction.features import Features
from hawk.picture.reconstruction.tilt import oblique_shots
from hawk.picture.values import LeftOut, PictureError, Progress, Provenance, Shot

TILT: Final = math.radians(1.0)
HEADING: Final = math.radians(6.0)
"""Standard deviations of what a gimbal says of roll and pitch, and of the heading."""
ROUGH_TILT: Final = math.radians(5.0)
ROUGH_HEADING: Final = math.radians(15.0)
"""The same of an aircraft without a gimbal, as measured on one flight (docs/results/perception.md)."""
LEAST_HEIGHT_M: Final = 0.5
BAROMETER_SHARE: Final = 0.01
"""Standard deviation of a barometer's height against those of the same flight: the larger of both."""
ROUGH_HEIGHT_M: Final = 3.0
"""The same of an altitude by GNSS."""
_UNKNOWN: Final = math.pi


@dataclass(frozen=True, slots=True)
class ReconstructedShots:
    """The shots that can be used, about a ``datum``, with their adjusted poses at the scale that is decided."""

    shots: tuple[Shot, ...]
    datum: GlobalPose
    adjusted: Reconstruction
    scale: Scale
    left_out: tuple[LeftOut, ...]


def pose_shots(
    provenance: Provenance,
    shots: Sequence[Shot],
    reader: ShotReader,
    checkpoints: Checkpoints,
    finder: StallDetector,
    progress: Progress,
) -> ReconstructedShots:
    """Adjust the poses of shots and decide the scale. Arguments and errors are those of `survey_shots`."""
    flight = provenance.flight
    datum = _middle(shots) if flight is None or flight.datum is None else GlobalPose(*flight.datum, 0.0)
    doubt = "" if provenance.height_m is not None else doubt_of(shots)
    is_none = any(shot.height is None or shot.height > HIGHEST_M for shot in shots)
    shots = guess_heights(shots) if is_none else shots
    known = [known_pose(shot, datum) for shot in shots]
    shots, known, left_out = _usable(provenance.lot, shots, known, reader, progress)
    adjusted = _adjusted(checkpoints, shots, known, reader.features_of(shots), progress)
    said = HeightPrior(provenance.height_m, doubt, is_none)
    scale = _scale(provenance.lot, shots, known, adjusted, said, partial(reader.widths, shots, finder=finder))
    return ReconstructedShots(tuple(shots), datum, scale_poses(adjusted, scale.factor), scale, tuple(left_out))


def _usable(
    name: str, shots: Sequence[Shot], known: list[PosePrior], reader: ShotReader, progress: Progress
) -> tuple[list[Shot], list[PosePrior], list[LeftOut]]:
    """Return the shots that can be read and look down, and the others with the reason. Raises PictureError for none."""
    usable, left_out = reader.read(shots, progress)
    shots, known = [shots[k] for k in usable], [known[k] for k in usable]
    if not shots:
        raise PictureError(f"{name}: no photograph can be read: {left_out[0].name}: {left_out[0].reason}")
    poses = [one.posed for one in known]
    oblique = oblique_shots(shots, poses, reader.features_of(shots), reader.picture)
    down = [k for k, shot in enumerate(shots) if shot.name not in oblique]
    if not down:
        first, reason = next(iter(oblique.items()))
        raise PictureError(f"{name}: no photograph looks straight down: {first} {reason}")
    left_out += [LeftOut(shot, reason) for shot, reason in oblique.items()]
    return reader.only(down, shots), [known[k] for k in down], left_out


def _adjusted(
    checkpoints: Checkpoints,
    shots: Sequence[Shot],
    known: list[PosePrior],
    found: Callable[[int], Features],
    progress: Progress,
) -> Reconstruction:
    """Adjust shots, or return what an earlier run has kept of it."""

    def make() -> Reconstruction:
        return reconstruct(
            known,
            found,
            lens_is_known=all(shot.lens_is_known for shot in shots),
            progress=progress,
            keep=partial(checkpoints.ties, shots),
            keep_middles=partial(checkpoints.middles, shots),
        )

    return checkpoints.adjusted(shots, known, make)


def _middle(shots: Sequence[Shot]) -> GlobalPose:
    latitude = np.mean([shot.latitude for shot in shots])
    longitude = wrap_longitudes(unwrap_longitudes(np.array([shot.longitude for shot in shots])).mean())
    return GlobalPose(float(latitude), float(longitude), 0.0)


def known_pose(shot: Shot, datum: GlobalPose) -> PosePrior:
    """Return a shot's pose about a datum as its file says, with how far that is believed. Raises PictureError."""
    if shot.height is None:
        raise PictureError(f"{shot.name}: its height above the ground is not known; give it by --height METRES")
    north, east, _ = pymap3d.geodetic2ned(shot.latitude, shot.longitude, 0.0, datum.latitude, datum.longitude, 0.0)
    attitude = shot.attitude or (0.0, 0.0, 0.0)
    posed = CameraPose(
        shot.camera, float(north), float(east), shot.height, attitude, velocity=shot.velocity, line_s=shot.line_s
    )
    is_level = shot.attitude is not None and shot.has_gimbal
    heading = HEADING if is_level else ROUGH_HEADING
    return PosePrior(
        posed, shot.sigma[0], max(LEAST_HEIGHT_M, BAROMETER_SHARE * shot.height) if is_level else ROUGH_HEIGHT_M,
        TILT if is_level else ROUGH_TILT,
        heading if shot.attitude is not None and shot.yaw_is_sure else _UNKNOWN,
    )  # fmt: skip


def _scale(
    name: str,
    shots: Sequence[Shot],
    known: Sequence[PosePrior],
    adjusted: Reconstruction,
    said: HeightPrior,
    widths: Callable[[Reconstruction], list[float]],
) -> Scale:
    """Return the scale on which the witnesses agree. Raises PictureError where they do not."""

    def look(factor: float) -> ScaleEstimate | None:
        seen = by_stalls(widths(scale_poses(adjusted, factor)))
        return None if seen is None else replace(seen, factor=seen.factor * factor)

    height = by_height(known, adjusted, lens_is_known=all(shot.lens_is_known for shot in shots))
    return choose_scale(name, by_places(shots, known, adjusted), height, said, middle_height(adjusted), look)
