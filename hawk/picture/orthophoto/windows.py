"""Windows of an orthophoto: each one is looked at by itself, with ground around it, and answers for its core."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Any, Final

import numpy as np
import shapely
from numpy.typing import NDArray

from hawk.algo.vision.network import VEHICLE_KINDS
from hawk.picture.orthophoto.grid import Box, FloatArray, PixelGrid
from hawk.picture.orthophoto.outline import LotOutline
from hawk.picture.orthophoto.source import Orthophoto
from hawk.picture.orthophoto.tile_detector import TileDetector, TileVehicles, program_name
from hawk.picture.values import PictureError

Mask = NDArray[np.bool_]
Runs = list[int]
"""Rows and columns of a mask, then the lengths of its runs, False first."""
CELL_M: Final = 0.4
"""Side of a cell of a core, metres; those of a core are a little smaller or larger, so that they fill it."""
CORE_M: Final = 128.0
MARGIN_M: Final = 16.0
"""Ground around a core that is looked at with it: three stalls of a row, and the aisle."""
AROUND_M: Final = 8.0
"""Ground about an outline that is looked at with it."""
_REACH_M: Final = 2.0
"""Stalls this near to a core are reported with it: its neighbour may have put them on the other side of the seam."""
_FINE_M: Final = 0.05
"""Pixels smaller than half of this are averaged while they are read, which bounds a window's memory."""
_FORMAT: Final = 3
"""Counts the changes of what a window's result holds."""


@dataclass(frozen=True, slots=True)
class Window:
    """A part of a picture. ``core``: the stalls in it are this window's; ``box``: what is looked at. ``step``: pixels
    along a side of what is read as one.
    """

    core: Box
    box: Box
    step: int = 1

    def name(self, grid: PixelGrid) -> str:
        """Return where a person finds the window's core: its pixels, from 0 as its file has them, and its middle."""
        left, top, right, bottom = self.core
        latitude, longitude = grid.on_earth(np.array([((left + right) / 2, (top + bottom) / 2)]))[0]
        if grid.is_mirrored:
            top, bottom = grid.rows - bottom, grid.rows - top
        return f"columns {left} to {right - 1}, rows {top} to {bottom - 1}, about {latitude:.6f}, {longitude:.6f}"


@dataclass(frozen=True, slots=True)
class Task:
    """A window to look at. ``name``: that of its result."""

    name: str
    window: Window


@dataclass(frozen=True, slots=True)
class WindowStalls:
    """Findings of a window, in (column, row) of the whole picture.

    ``corners`` (N, 4, 2) of the stalls in and near the core, ``taken`` and ``score`` (N,) as of
    `TileDetections`; ``suggested`` (M, 4, 2). ``lot`` and ``seen``: the cells of the core that are of a lot, and that
    show ground. ``vehicles``: those whose middle is in the core, None of a network that knows none, and without ground.
    """

    window: Window
    corners: FloatArray = field(repr=False)
    taken: FloatArray = field(repr=False)
    score: FloatArray = field(repr=False)
    suggested: FloatArray = field(repr=False)
    lot: NDArray[np.bool_] = field(repr=False)
    seen: NDArray[np.bool_] = field(repr=False)
    vehicles: TileVehicles | None = field(default=None, repr=False)

    def to_bytes(self) -> bytes:
        """Return it as JSON; the same findings give the same bytes."""
        content = {
            "format": _FORMAT,
            "core": self.window.core,
            "box": self.window.box,
            "step": self.window.step,
            "corners": self.corners.tolist(),
            "taken": self.taken.tolist(),
            "score": self.score.tolist(),
            "suggested": self.suggested.tolist(),
            "lot": encode_runs(self.lot),
            "seen": encode_runs(self.seen),
            "vehicles": None if self.vehicles is None else _vehicle_rows(self.vehicles),
        }
        return json.dumps(content, separators=(",", ":")).encode()

    @classmethod
    def from_bytes(cls, data: bytes) -> WindowStalls:
        """Return what `to_bytes` wrote. Raises PictureError for bytes that are no such result."""
        try:
            content: dict[str, Any] = json.loads(data)
            if content["format"] != _FORMAT:
                raise ValueError(f"format {content['format']}")
            core, box = (tuple(int(v) for v in content[name]) for name in ("core", "box"))
            runs: tuple[Runs, Runs] = content["lot"], content["seen"]
            lot, seen = (decode_runs(mask) for mask in runs)
            found = cls(
                Window(_box(core), _box(box), int(content["step"])),
                np.array(content["corners"], np.float64).reshape(-1, 4, 2),
                np.array(content["taken"], np.float64),
                np.array(content["score"], np.float64),
                np.array(content["suggested"], np.float64).reshape(-1, 4, 2),
                lot,
                seen,
                None if content["vehicles"] is None else _read_vehicles(content["vehicles"]),
            )
        except (ValueError, TypeError, KeyError, UnicodeDecodeError) as error:
            raise PictureError(f"a window's result cannot be read ({error!r}); remove it and map again") from error
        if not len(found.corners) == len(found.taken) == len(found.score):
            raise PictureError("a window's result cannot be read (its parts differ); remove it and map again")
        return found


def _vehicle_rows(vehicles: TileVehicles) -> list[list[float]]:
    table = np.column_stack([vehicles.corners.reshape(-1, 8), vehicles.probability, vehicles.kind])
    return table.tolist()  # type: ignore[no-any-return]


def _read_vehicles(rows: list[list[float]]) -> TileVehicles:
    """Return what `_vehicle_rows` made. Raises ValueError, TypeError."""
    table = np.array(rows, np.float64).reshape(-1, 10)
    kind = table[:, 9].astype(np.intp)
    if ((kind < 0) | (kind >= len(VEHICLE_KINDS))).any():
        raise ValueError("a vehicle of no kind")
    return TileVehicles(table[:, :8].reshape(-1, 4, 2), table[:, 8], kind)


def windows_of(source: Orthophoto, outline: LotOutline | None = None, *, core_m: float = CORE_M) -> tuple[Window, ...]:
    """Return the windows of a picture, row by row: those on an outline, and on ground where its overviews show it.

    Cores have ``core_m`` a side; a picture that is longer by `MARGIN_M` or less is one window.
    """
    grid = source.grid
    step = max(1, min(int(_FINE_M / max(grid.metres)), grid.columns, grid.rows))
    columns, rows = (
        _edges(side, metres, step, core_m) for side, metres in zip((grid.columns, grid.rows), grid.metres, strict=True)
    )
    margin_x, margin_y = (round(MARGIN_M / metres / step) * step for metres in grid.metres)
    windows = []
    for row, column in _places(source, outline, columns, rows):
        core = (columns[column], rows[row], columns[column + 1], rows[row + 1])
        left, top = max(core[0] - margin_x, 0), max(core[1] - margin_y, 0)
        right, bottom = min(core[2] + margin_x, columns[-1]), min(core[3] + margin_y, rows[-1])
        windows.append(Window(core, (left, top, right, bottom), step))
    return tuple(_on_ground(source, windows))


def _edges(side: int, metres: float, step: int, core_m: float) -> list[int]:
    """Return the borders of the cores along one side, the last one up to `MARGIN_M` longer than the others."""
    core = max(step, round(core_m / metres / step) * step)
    count = max(1, -(-(side - round(MARGIN_M / metres)) // core))
    return [*(k * core for k in range(count)), side // step * step]


def _places(
    source: Orthophoto, outline: LotOutline | None, columns: list[int], rows: list[int]
) -> Iterable[tuple[int, int]]:
    """Return the rows and columns of the cores that lie on an outline or near it; all cores without one."""
    if outline is None:
        return product(range(len(rows) - 1), range(len(columns) - 1))
    lots = outline.in_metres(source.grid)
    x, y = (np.array(edges) * metres for edges, metres in zip((columns, rows), source.grid.metres, strict=True))
    near: set[tuple[int, int]] = set()
    for left, top, right, bottom in (shapely.bounds(lots) + np.array([-1, -1, 1, 1]) * AROUND_M).tolist():
        across, down = _range(x, left, right), _range(y, top, bottom)
        near.update(product(down, across))
    found = np.array(sorted(near), np.intp).reshape(-1, 2)
    cores = shapely.box(x[found[:, 1]], y[found[:, 0]], x[found[:, 1] + 1], y[found[:, 0] + 1])
    kept = np.unique(shapely.STRtree(lots).query(cores, predicate="dwithin", distance=AROUND_M)[0])
    return [(row, column) for row, column in found[kept].tolist()]


def _range(edges: FloatArray, low: float, high: float) -> range:
    """Return the numbers of the parts between edges that meet [low, high]."""
    first, last = np.searchsorted(edges, [low, high])
    return range(max(int(first) - 1, 0), min(int(last), len(edges) - 1))


def _on_ground(source: Orthophoto, windows: list[Window]) -> list[Window]:
    ground = source.ground() if len(windows) > 1 else None
    if ground is None:
        return windows
    scale = np.array([ground.shape[1] / source.grid.columns, ground.shape[0] / source.grid.rows])

    def has_ground(window: Window) -> bool:
        left, top = np.floor(np.array(window.core[:2]) * scale).astype(int) - 1
        right, bottom = np.ceil(np.array(window.core[2:]) * scale).astype(int) + 1
        return bool(ground[max(top, 0) : bottom, max(left, 0) : right].any())

    return [window for window in windows if has_ground(window)]


def task_name(source: Orthophoto, window: Window, model: str) -> str:
    """Return the name of a window's result: SHA-256 of the picture, window, network, program and settings.

    Args:
        source: The picture; another time of change, size or place of its files is another picture.
        window: The window.
        model: SHA-256 of the network's file (`TileDetector.model`).
    """
    content = [
        _FORMAT, source.identity, source.grid.crs, source.grid.affine, source.bands.colours, source.bands.alpha,
        source.bands.levels, source.bands.has_white, window.core, window.box, window.step, model, program_name(model),
    ]  # fmt: skip
    content += source.private_in(window.box)
    return hashlib.sha256(json.dumps(content).encode()).hexdigest()


def map_window(source: Orthophoto, window: Window, detector: TileDetector) -> WindowStalls:
    """Look at one window.

    Args:
        source: The picture, whose file is opened here.
        window: One of `windows_of`.
        detector: Looks at it.

    Raises:
        PictureError: The file cannot be read there, or the network cannot be run.
    """
    left, top, right, bottom = window.box
    part = source.read(window.box, window.step)
    metres = np.array(source.grid.metres_at((left + right) / 2, (top + bottom) / 2))
    side = (float(metres[0]) * window.step, float(metres[1]) * window.step)
    corner = np.array((left, top), np.float64)
    core = (np.array(window.core, np.float64) - np.tile(corner, 2)) * np.tile(metres, 2)
    if not part.valid.any():
        shape = lot_cells(part.valid, side, core).shape
        blank, none = np.zeros(shape, np.bool_), np.zeros((0, 4, 2))
        return WindowStalls(window, none, np.zeros(0), np.zeros(0), none, blank, blank)
    step = window.step
    ends = left == 0, top == 0, right + step > source.grid.columns, bottom + step > source.grid.rows
    found = detector.detect(part.image, side, part.valid, ends)
    whole = (part.image.shape[1] * side[0], part.image.shape[0] * side[1])
    kept = _touch(found.stalls, core) & _is_in(found.stalls.mean(axis=1), (0.0, 0.0, *whole))
    suggested = found.suggested[_is_in(found.suggested.mean(axis=1), core)]
    seen = lot_cells(part.valid, side, core)
    vehicles = found.vehicles
    if vehicles is not None:
        vehicles = vehicles.chosen(_is_in(vehicles.corners.mean(axis=1), core))
        vehicles = replace(
            vehicles,
            corners=np.round(vehicles.corners / metres + corner, 2),
            probability=np.round(vehicles.probability, 4),
        )
    return WindowStalls(
        window,
        np.round(found.stalls[kept] / metres + corner, 2),
        np.round(found.taken[kept], 4),
        np.round(found.score[kept], 4),
        np.round(suggested / metres + corner, 2),
        lot_cells(found.lot, (found.lot_m, found.lot_m), core, seen.shape) & seen,
        seen,
        vehicles,
    )


def _touch(corners: FloatArray, core: FloatArray) -> NDArray[np.bool_]:
    """Return which quads (N, 4, 2) have a corner within `_REACH_M` of the core."""
    near = core + np.array([-_REACH_M, -_REACH_M, _REACH_M, _REACH_M])
    return np.asarray(_is_in(corners.reshape(-1, 2), near).reshape(-1, 4).any(axis=1))


def _is_in(places: FloatArray, box: FloatArray | tuple[float, ...]) -> NDArray[np.bool_]:
    return np.asarray((places >= np.asarray(box[:2])).all(axis=-1) & (places < np.asarray(box[2:])).all(axis=-1))


def _box(values: tuple[int, ...]) -> Box:
    left, top, right, bottom = values
    return left, top, right, bottom


def lot_cells(
    mask: Mask, side: tuple[float, float], core: NDArray[np.float64], shape: tuple[int, int] | None = None
) -> Mask:
    """Return the part of a window's mask that lies in its core, as cells of about `CELL_M`.

    Args:
        mask: (H, W) of the window, from its upper left corner.
        side: Metres of one of the mask's cells along a row and along a column.
        core: Left, top, right and bottom of the core, metres from that corner.
        shape: Rows and columns of the result; None: as many as fill the core.
    """
    left, top, right, bottom = core.tolist()
    rows, columns = shape or (max(1, round((bottom - top) / CELL_M)), max(1, round((right - left) / CELL_M)))
    x = (left + (np.arange(columns) + 0.5) * ((right - left) / columns)) / side[0]
    y = (top + (np.arange(rows) + 0.5) * ((bottom - top) / rows)) / side[1]
    column, row = (
        np.clip(np.floor(at).astype(np.intp), 0, most - 1) for at, most in ((x, mask.shape[1]), (y, mask.shape[0]))
    )
    return mask[np.ix_(row, column)]


def encode_runs(mask: Mask) -> Runs:
    """Return a mask as runs."""
    flat = np.concatenate([[False], mask.reshape(-1), [not bool(mask.reshape(-1)[-1])]]).astype(np.int8)
    ends = np.flatnonzero(np.diff(flat))
    return [*mask.shape, *np.diff(ends, prepend=0).tolist()]


def decode_runs(runs: Runs) -> Mask:
    """Return the mask of `encode_runs`. Raises ValueError for runs that make no mask."""
    rows, columns, *lengths = (int(value) for value in runs)
    values = np.arange(len(lengths)) % 2 == 1
    if rows < 1 or columns < 1 or min(lengths, default=0) < 0 or sum(lengths) != rows * columns:
        raise ValueError("its runs do not fill its mask")
    return np.repeat(values, lengths).reshape(rows, columns)
