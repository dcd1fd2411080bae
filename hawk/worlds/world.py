"""A world to fly over, and its scale: a picture of the ground, what stands on it, and the truth about its stalls."""

from __future__ import annotations

import io
import json
import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
import shapely
import shapely.ops
from numpy.typing import NDArray

from hawk.formats.image import JPEG_START, DamagedImage, NoImage, decode_any, read_jpeg, upright
from hawk.worlds import COARSEST_M, FINEST_M
from hawk.worlds.scene.canvas import Bytes, Points
from hawk.worlds.scene.facets import HeightLayer
from hawk.worlds.stays import LotStays

_STATES = ("free", "taken", "unclear")
_START_INSET_M = 1.0


class WorldError(ValueError):
    """A world or a truth that cannot be used; the message names the file or field and the remedy."""


@dataclass(frozen=True, slots=True, eq=False)
class TrueStall:
    """A painted stall.

    ``corners`` is (4, 2) metres in the world's ground frame (x east, y south from the picture's corner);
    corners[0]-corners[1] and corners[2]-corners[3] are the short ends. ``covered`` is the share (0..1) of it that
    vehicles cover; more than half of a ``hidden`` one is under crowns or roofs; the state of an ``unclear`` one is
    unknown (then ``taken`` means nothing). Fences keep cars off a ``closed`` one, which is unclear too.
    """

    id: int
    corners: NDArray[np.float64]
    taken: bool
    hidden: bool = False
    worn: bool = False
    kind: str = "perpendicular"
    covered: float = 0.0
    unclear: bool = False
    closed: bool = False

    @property
    def state(self) -> str:
        """Return free, taken or unclear."""
        return "unclear" if self.unclear else ("taken" if self.taken else "free")


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """Truth about a world: its stalls, and the outlines (N, 2) of its lots, metres."""

    stalls: tuple[TrueStall, ...] = ()
    lots: tuple[Points, ...] = ()
    start: tuple[float, float] | None = None
    metres_per_pixel: float | None = None
    seed: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class World:
    """A place to fly over.

    Ground frame: origin in the upper left corner of the picture, x east, y south, metres. ``ground`` is BGR uint8
    (H, W, 3) at ``metres_per_pixel``, with all shadows and nothing that has height; that is in ``layers``.
    A world ``at`` a moment has the ``stays`` that its cars come from.
    """

    name: str
    metres_per_pixel: float
    ground: Bytes = field(repr=False)
    layers: tuple[HeightLayer, ...] = field(default=(), repr=False)
    stalls: tuple[TrueStall, ...] = field(default=(), repr=False)
    lots: tuple[Points, ...] = field(default=(), repr=False)
    seed: int | None = None
    start_m: tuple[float, float] | None = None
    at: datetime | None = None
    stays: LotStays | None = field(default=None, repr=False)

    @property
    def size_m(self) -> tuple[float, float]:
        """Width (east) and height (south) in metres."""
        rows, columns = self.ground.shape[:2]
        return columns * self.metres_per_pixel, rows * self.metres_per_pixel

    def start(self) -> tuple[float, float]:
        """Return the start of a drone, metres: just inside the middle of an edge of the largest lot.

        Of its edges the one nearest to a corner of the picture. Without a lot, the middle of the picture.
        """
        if self.start_m is not None:
            return self.start_m
        width, height = self.size_m
        if not self.lots:
            return width / 2, height / 2
        corners = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float64)
        largest = max(self.lots, key=lambda lot: shapely.Polygon(lot).buffer(0).area)
        best = min(
            _edge_middles(largest, width, height),
            key=lambda point: float(np.linalg.norm(corners - point, axis=1).min()),
            default=None,
        )
        return (width / 2, height / 2) if best is None else _inside(best, largest)

    def truth_json(self) -> dict[str, Any]:
        """Return the truth as it is saved (`load_truth` reads it)."""
        rows, columns = self.ground.shape[:2]
        moment = {} if self.at is None else {"at": self.at.isoformat()}
        return {
            **moment,
            "metres_per_pixel": self.metres_per_pixel,
            "size_px": [columns, rows],
            "stalls": [_stall_json(stall) for stall in self.stalls],
            "lots_m": [np.round(lot, 3).tolist() for lot in self.lots],
            "start_m": [round(value, 3) for value in self.start()],
            "seed": self.seed,
            "name": self.name,
        }


def load_truth(path: str | Path) -> Truth:
    """Read a truth file (`World.truth_json`, or stalls and outlines alone). Raises WorldError naming the fault."""
    path = Path(path)
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise WorldError(f"truth {path}: cannot be read ({error.strerror}); name a JSON file that exists") from error
    except ValueError as error:
        raise WorldError(f"truth {path}: is not JSON ({error})") from error
    if not isinstance(data, Mapping):
        raise WorldError(f"truth {path}: must be an object with 'stalls' and 'lots_m'")
    source, stalls = str(path), data.get("stalls", [])
    lots = data.get("lots_m", [])
    if not isinstance(stalls, list) or not isinstance(lots, list):
        raise WorldError(f"{source}: 'stalls' and 'lots_m' must be lists")
    start = data.get("start_m")
    scale, seed = data.get("metres_per_pixel"), data.get("seed")
    return Truth(
        stalls=tuple(_stall_from_json(entry, k, f"{source}: stalls[{k}]") for k, entry in enumerate(stalls)),
        lots=tuple(_points(lot, f"{source}: lots_m[{k}]", minimum=3) for k, lot in enumerate(lots)),
        start=None if start is None else _pair(start, f"{source}: start_m"),
        metres_per_pixel=None if scale is None else _positive(scale, f"{source}: metres_per_pixel"),
        seed=seed if isinstance(seed, int) else None,
    )


def _stall_json(stall: TrueStall) -> dict[str, Any]:
    return {
        "id": stall.id,
        "corners_m": np.round(stall.corners, 3).tolist(),
        "covered": round(stall.covered, 3),
        "state": stall.state,
        "hidden": stall.hidden,
        "worn": stall.worn,
        "kind": stall.kind,
        **({"closed": True} if stall.closed else {}),
    }


def _stall_from_json(entry: object, number: int, source: str) -> TrueStall:
    if not isinstance(entry, Mapping) or "corners_m" not in entry:
        raise WorldError(f"{source}: must be an object with 'corners_m'")
    corners = _points(entry["corners_m"], f"{source}.corners_m", minimum=4)
    if len(corners) != 4:
        raise WorldError(f"{source}.corners_m: must be 4 corners, not {len(corners)}")
    state = entry.get("state", "unclear")
    if state not in _STATES:
        raise WorldError(f"{source}.state: must be one of {', '.join(_STATES)}, not {state!r}")
    return TrueStall(
        id=int(entry.get("id", number)),
        corners=_short_ends_first(corners),
        taken=state == "taken",
        hidden=bool(entry.get("hidden", False)),
        worn=bool(entry.get("worn", False)),
        kind=str(entry.get("kind", "perpendicular")),
        covered=float(entry.get("covered", 0.0)),
        unclear=state == "unclear",
        closed=bool(entry.get("closed", False)),
    )


def _short_ends_first(corners: Points) -> Points:
    """Turn the order of the corners so that the first and third side are the short ones."""
    sides = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
    return corners if sides[0] + sides[2] <= sides[1] + sides[3] else np.roll(corners, -1, axis=0)


def _points(value: object, source: str, *, minimum: int) -> Points:
    try:
        points = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise WorldError(f"{source}: must be a list of [x, y] pairs in metres") from error
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < minimum or not np.isfinite(points).all():
        raise WorldError(f"{source}: must be at least {minimum} finite [x, y] pairs in metres")
    return points


def _pair(value: object, source: str) -> tuple[float, float]:
    points = _points([value], source, minimum=1)
    return float(points[0, 0]), float(points[0, 1])


def _positive(value: object, source: str) -> float:
    if not isinstance(value, (int, float)) or isinstance(value, bool) or not 0 < float(value) < 100:
        raise WorldError(f"{source}: must be a number above 0, not {value!r}")
    return float(value)


def _edge_middles(lot: Points, width: float, height: float) -> list[Points]:
    """Return the middles of a lot's longer edges, those inside the picture."""
    ends = np.roll(lot, -1, axis=0)
    lengths = np.linalg.norm(ends - lot, axis=1)
    long = lengths >= min(6.0, float(lengths.max()))
    middles = ((lot + ends) / 2)[long]
    inside = (middles >= 0).all(1) & (middles[:, 0] <= width) & (middles[:, 1] <= height)
    return list(middles[inside])


def _inside(point: Points, lot: Points) -> tuple[float, float]:
    """Return the nearest point to ``point`` that is a little inside the lot."""
    area = shapely.Polygon(lot).buffer(0)
    inner = area.buffer(-_START_INSET_M)
    if inner.is_empty:
        centre = area.representative_point()
        return float(centre.x), float(centre.y)
    nearest = shapely.ops.nearest_points(inner, shapely.Point(point))[0]
    return float(nearest.x), float(nearest.y)


_LARGEST_PX = 20000


def _head_of(data: bytes) -> tuple[tuple[int, int] | None, int]:
    """Return width and height that a picture's header claims, None when it has none, and its EXIF orientation."""
    if data.startswith(JPEG_START):
        try:
            head = read_jpeg(data)
        except ValueError:
            return None, 1
        return head.size, head.orientation
    import imagesize  # comes with the simulator

    try:
        width, height = imagesize.get(io.BytesIO(data))
    except (ValueError, struct.error):
        return None, 1
    return None if width < 0 else (int(width), int(height)), 1


def _check_size(path: Path, size: tuple[int, int] | None) -> None:
    """Refuse a picture that is too small or too large (width, height; None: not known). Raises WorldError."""
    if size is not None and not (min(size) >= 16 and max(size) <= _LARGEST_PX):
        given = f"{size[0]} x {size[1]}"
        raise WorldError(f"world {path}: must be 16 to {_LARGEST_PX} pixels a side, not {given}; resize it")


def picture_world(path: str | Path, metres_per_pixel: float, truth_path: str | Path | None = None) -> World:
    """Make a world of an orthophoto (PNG, JPEG, TIFF; north up) and, if there is one, its truth.

    Everything in the picture is flat. A JPEG is turned by its EXIF orientation: north is up as viewers show it. Raises
    WorldError naming the file or option and the remedy.
    """
    path = Path(path)
    if not FINEST_M <= metres_per_pixel <= COARSEST_M:
        raise WorldError(
            f"metres_per_pixel: must be between {FINEST_M} and {COARSEST_M}, not {metres_per_pixel}; "
            "it is the side of one pixel on the ground"
        )
    try:
        data = path.read_bytes()
    except OSError as error:
        raise WorldError(f"world {path}: cannot be read ({error.strerror}); name a picture that exists") from error
    size, orientation = _head_of(data)
    _check_size(path, size)  # before it takes gigabytes
    try:
        ground = upright(decode_any(data), orientation)
    except DamagedImage as error:
        raise WorldError(f"world {path}: {error}; export or copy it again") from None
    except NoImage:
        raise WorldError(f"world {path}: is not a picture that can be read; use PNG, JPEG or TIFF") from None
    _check_size(path, (ground.shape[1], ground.shape[0]))
    truth = load_truth(truth_path) if truth_path is not None else Truth()
    return World(
        name=path.stem,
        metres_per_pixel=metres_per_pixel,
        ground=ground,
        stalls=truth.stalls,
        lots=truth.lots,
        start_m=truth.start,
    )
