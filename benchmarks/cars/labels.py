"""Labels of vehicles: by hand for the Dutch regions (``labels/``), and those that came with tiles and crossings."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision.detection import FloatArray
from hawk.algo.vision.network import VEHICLE_KINDS

HAND_LABELS: Final = Path(__file__).parent / "labels"
"""``REGION.json`` of each Dutch region; how they were made: its README.md."""


class LabelError(ValueError):
    """A file of labels cannot be used; the text names it and the remedy."""


@dataclass(frozen=True, slots=True)
class VehicleTruth:
    """Vehicles of one picture: ``corners`` (N, 4, 2) metres from its upper left corner, x right, y down, the short ends
    first and last; ``kind`` (N,) index of `VEHICLE_KINDS`; ``ground``: open, shade or crown; ``is_kerb``: along a kerb;
    ``is_moving``: in a lane; ``is_counted`` (N,): False for what the picture cuts, and where a person would not bet.
    """

    corners: FloatArray
    kind: NDArray[np.intp]
    ground: tuple[str, ...]
    is_kerb: NDArray[np.bool_]
    is_moving: NDArray[np.bool_]
    is_counted: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.corners)

    @property
    def centres(self) -> FloatArray:
        """(N, 2), metres."""
        return np.asarray(self.corners.mean(axis=1))


def truth_of(vehicles: Sequence[dict[str, Any]]) -> VehicleTruth:
    """Return the vehicles of a list as ``labels/REGION.json`` has it. Raises KeyError, TypeError, ValueError."""
    return VehicleTruth(
        corners=np.array([one["corners_m"] for one in vehicles], np.float64).reshape(-1, 4, 2),
        kind=np.array([VEHICLE_KINDS.index(one.get("class", "car")) for one in vehicles], np.intp),
        ground=tuple(str(one.get("ground", "open")) for one in vehicles),
        is_kerb=np.array([bool(one.get("kerb")) for one in vehicles], np.bool_),
        is_moving=np.array([bool(one.get("moving")) for one in vehicles], np.bool_),
        is_counted=np.array([not (one.get("cut") or one.get("unsure")) for one in vehicles], np.bool_),
    )


def read_truth(path: Path) -> VehicleTruth | None:
    """Read a file of hand labels; None where there is none. Raises LabelError."""
    if not path.exists():
        return None
    try:
        return truth_of(json.loads(path.read_text())["vehicles"])
    except (KeyError, TypeError, ValueError) as error:
        raise LabelError(f"{path}: not labels of vehicles ({error}); see {HAND_LABELS.name}/README.md") from error
