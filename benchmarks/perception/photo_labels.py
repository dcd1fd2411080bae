"""Labels of a lot in one photograph, made by hand, with who is parked there in every photograph of the flight."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Final

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from benchmarks.perception.photo_shots import Shot, read_shot
from benchmarks.perception.places import state_array
from hawk.model.lot_map import StallState
from hawk.survey.accuracy import FloatArray, StateArray

PHOTO_LOT: Final = Path(__file__).with_name("data") / "photo_lot.json"
"""Labels of OpenDroneMap/odm_data_garfield_msp."""
Pixel = tuple[float, float]
Angles = tuple[float, float, float]


class _Pose(BaseModel):
    """``attitude_deg``: roll, pitch, yaw; ``turning_deg_s``: about the camera's x, y and z."""

    model_config = ConfigDict(extra="forbid")
    height_m: Annotated[float, Field(gt=0)]
    attitude_deg: Angles
    turning_deg_s: Angles


class _File(BaseModel):
    """Corners are pixels of the photograph as it is stored; whole numbers are pixel centres."""

    model_config = ConfigDict(extra="forbid")
    comment: str
    licence: str
    photograph: str
    pose: _Pose
    lots: list[Annotated[list[Pixel], Field(min_length=3)]]
    stalls: Annotated[dict[str, tuple[Pixel, Pixel, Pixel, Pixel]], Field(min_length=1)]
    taken: dict[str, list[str]]
    unclear: dict[str, list[str]] = {}


@dataclass(frozen=True, slots=True)
class PhotoLabels:
    """The labels of a lot on the ground of the photograph of that name: metres north and east of the point below its
    camera, which was ``height_m`` above. ``stalls`` (N, 4, 2) have ``names``; ``taken`` and ``unclear`` name those of
    each photograph that was looked at.
    """

    photograph: str
    shot: Shot
    height_m: float
    names: tuple[str, ...]
    stalls: FloatArray = field(repr=False)
    lots: tuple[FloatArray, ...] = field(repr=False)
    taken: Mapping[str, list[str]] = field(repr=False)
    unclear: Mapping[str, list[str]] = field(repr=False)

    def states(self, photograph: str) -> StateArray:
        """Return the states (N,) at the time of a photograph; unknown in one whose cars nobody labelled."""
        if photograph not in self.taken:
            return state_array([StallState.UNKNOWN] * len(self.names))
        taken, unclear = set(self.taken[photograph]), set(self.unclear.get(photograph, ()))
        return state_array(
            [
                StallState.UNKNOWN if name in unclear else StallState.TAKEN if name in taken else StallState.FREE
                for name in self.names
            ]
        )

    def height_of(self, shot: Shot) -> float:
        """Return the height of a photograph over the lot by EXIF's altitudes."""
        return self.height_m + shot.altitude - self.shot.altitude


def read_labels(path: Path, folder: Path) -> PhotoLabels:
    """Return the labels of a file. Raises ValueError, which names the file, its fault and a remedy.

    ``folder`` holds the photographs of the flight: the labelled one gives lens and place.
    """
    try:
        read = _File.model_validate_json(path.read_bytes())
        unknown = {name for names in (*read.taken.values(), *read.unclear.values()) for name in names} - set(
            read.stalls
        )
        if unknown:
            raise ValueError(
                f"{', '.join(sorted(unknown))}: stalls with a state and without corners; add their corners"
            )
        if not (folder / read.photograph).is_file():
            raise ValueError(f"its photograph {read.photograph} is not in {folder}; name the folder of that flight")
    except OSError as error:
        raise ValueError(f"{path} cannot be read: {error.strerror}; name a label file") from error
    except ValidationError as error:
        first = error.errors()[0]
        field_name = ".".join(str(part) for part in first["loc"]) or "the file"
        raise ValueError(f"{path}: {field_name}: {first['msg']}; correct it as photo_lot.json has it") from error
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
    return _labels(read, read_shot(folder / read.photograph))


def _labels(read: _File, shot: Shot) -> PhotoLabels:
    roll, pitch, yaw = (math.radians(angle) for angle in read.pose.attitude_deg)
    x, y, z = (math.radians(angle) for angle in read.pose.turning_deg_s)
    shot = replace(shot, attitude=(roll, pitch, yaw), turning=(x, y, z))
    height = read.pose.height_m
    corners = np.array(list(read.stalls.values()), float)
    stalls = shot.ground(corners.reshape(-1, 2), height).reshape(corners.shape)
    lots = tuple(shot.ground(np.array(lot, float), height) for lot in read.lots)
    return PhotoLabels(read.photograph, shot, height, tuple(read.stalls), stalls, lots, read.taken, read.unclear)
