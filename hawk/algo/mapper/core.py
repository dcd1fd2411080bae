"""The map itself: brings registration, evidence, stalls, outline, mosaic and encoding together for each frame.

What need not be done on every frame (outline, rows, mosaic) is done one at a time, so that no frame pays for two.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hawk.algo.mapper import delta
from hawk.algo.mapper.detections import Detections
from hawk.algo.mapper.encode import TileEncoder
from hawk.algo.mapper.evidence import EVIDENCE_M
from hawk.algo.mapper.grid import CellEvidence, EvidenceGrid, EvidenceTile
from hawk.algo.mapper.index import StallIndex
from hawk.algo.mapper.layout import lay, moved, outline
from hawk.algo.mapper.mosaic import Mosaic
from hawk.algo.mapper.register import Registration, Shift
from hawk.algo.mapper.rowfill import RowFiller
from hawk.algo.mapper.settings import MapperSettings
from hawk.algo.mapper.shown import CLOSE_M, classify
from hawk.algo.mapper.stalls import Look, StallTracker
from hawk.algo.mapper.table import angle_of, corners_of, from_bytes, to_bytes
from hawk.algo.mapper.window import Window
from hawk.algo.vision.seen import Seen
from hawk.model import TILE_M, Cell, Inbound, MapPose, OccupancyMap, Stall, TileKey

_REACH_M = 12.0  # stalls this far outside the picture still matter to the outline
_LOT_NEAR_M = 0.5
_REGISTER_M = 60.0
_DRAWN_M = 90.0  # from the drone: what others ask about (`stalls_near`)
_TILE_REACH_M = TILE_M * math.sqrt(0.5) + 5.0  # and half the diagonal of the longest stall


class MapCore:
    """One survey's map."""

    def __init__(self, settings: MapperSettings, map_id: str) -> None:
        self._settings = settings
        self._map_id = map_id
        self._version = 0
        self.grid = EvidenceGrid()
        self.tracker = StallTracker()
        self.registration = Registration(settings.max_shift_m, learns_height=settings.learns_height)
        self._encoder = TileEncoder()
        self._mosaic = Mosaic()
        self._stalls = StallIndex()
        self._rows = RowFiller(settings.rows_reach_m)
        self._last_pose: MapPose | None = None
        self._outlined: MapPose | None = None
        self._pictured: MapPose | None = None
        self._way = 0.0
        self._frame = self._outlined_at = self._rows_at = 0
        self._is_spent = False
        self._touched: set[TileKey] = set()
        self._chores: list[Callable[[Window, Seen], bool]] = [
            self._outline,
            self._complete_rows,
            self._picture,
            self._rest,
        ]
        self.index = OccupancyMap(map_id=map_id)

    def fuse(self, seen: Seen, raised: float = 1.0) -> None:
        """Take in one frame; ``raised`` is what the height that the autopilot told was multiplied by to lay it."""
        self._version += 1
        weight = self._weight(seen.pose)
        self._attend(seen)
        found = Detections.of(seen.stalls)
        correction = self._register(found, seen, raised)
        found = found.leaning(self.registration.leans)
        seen = _corrected(seen, correction)
        evidence = lay(seen, self._settings.edge_m, self._settings.good_share)
        if evidence is None:
            return
        self._touched.update(self.grid.fuse(evidence, weight, self._version))
        self._fuse_stalls(found.moved(correction), evidence, weight, seen)
        self._frame += 1
        self._is_spent = False
        for chore in self._chores:
            if chore(evidence.window, seen):
                self._chores.remove(chore)
                self._chores.append(chore)
                break
        self._show_stalls()

    def encode(self, pose: MapPose | None) -> None:
        """Encode a bounded number of changed tiles and renew the index; after the dearest of the chores only one."""
        settings = self._settings
        near = (0.0, 0.0) if pose is None else (pose.north, pose.east)
        most = 1 if self._is_spent else settings.tiles_per_frame
        parts = [
            self.tracker.about(-(row + 0.5) * TILE_M, (column + 0.5) * TILE_M, _TILE_REACH_M)
            for row, column in self._encoder.next_tiles(most, near)
        ]
        if parts:
            rows = np.concatenate(parts)
            _, once = np.unique(rows["id"], return_index=True)  # drawn twice is not drawn: polygons fill even-odd
            self._encoder.encode(self.grid, rows[once], most, self._version, near)
        self._mosaic.encode(0 if self._is_spent else settings.mosaic_tiles_per_frame, self._version)
        self.index = OccupancyMap(
            tiles=self._encoder.encoded,
            mosaic=self._mosaic.encoded,
            stalls=self._stalls.stalls,
            counts=self._stalls.counts(),
            lot_area_m2=round(self.grid.lot_area_m2, 1),
            version=self._version,
            map_id=self._map_id,
        )

    def extent(self) -> NDArray[np.float64] | None:
        """Return two corners (2, 2) of (north, east) around all tiles, None when there are none."""
        return self.grid.extent()

    def stalls_near(self, north: float, east: float, radius: float) -> list[Stall]:
        """Return the stalls that count within a radius of a place near the drone."""
        rows = self.tracker.rows[self.tracker.near(north, east, radius)]
        return [self.index.stalls[i] for i in rows["id"][rows["confirmed"]].tolist() if i in self.index.stalls]

    @property
    def unclear(self) -> Mapping[int, Stall]:
        """The stalls that count whose state is not known."""
        return self._stalls.unclear

    def inbound(self, north: float, east: float) -> Inbound:
        """Return the verdict on a place: what most of the cells within half a metre show."""
        if not (math.isfinite(north) and math.isfinite(east)):
            return Inbound.UNKNOWN
        window = Window.around(np.array([[north, east]]), EVIDENCE_M, _LOT_NEAR_M)
        shown = self.grid.layer(window, "shown")
        middle = shown[window.rows // 2, window.columns // 2]
        known = np.count_nonzero(shown)
        if known < shown.size / 2 or middle == Cell.UNKNOWN:
            return Inbound.UNKNOWN
        return Inbound.INSIDE if np.count_nonzero(shown == Cell.LOT) > known / 2 else Inbound.OUTSIDE

    def corrected(self, pose: MapPose) -> MapPose:
        """Return the pose with the present shift of registration."""
        shift = self.registration.shift
        north, east = pose.north + shift.north, pose.east + shift.east
        return MapPose(north, east, pose.height * shift.scale, pose.roll, pose.pitch, pose.yaw + shift.turn)

    def changes_since(self, version: int) -> delta.MapDelta:
        """Return the parts that changed after ``version``."""
        parts: dict[str, bytes] = {}
        for key in self.grid.recent.since(version):
            parts[delta.tile_name(delta.GRID, key)] = self.grid.tiles[key].to_bytes()
        for key in self._mosaic.recent.since(version):
            parts[delta.tile_name(delta.MOSAIC, key)] = self._mosaic.encoded[key].data
        for rows in self.tracker.touched_since(version):
            for row in rows:
                parts[f"{delta.STALL}/{int(row['id'])}"] = to_bytes(row)
        for stall_id in self.tracker.gone.since(version):
            parts[f"{delta.STALL}/{stall_id}"] = b""
        shift = self.registration.shift
        meta = delta.MapMeta(
            self._map_id, self._version, self.tracker.next_id, (shift.north, shift.east, shift.turn, shift.scale)
        )
        parts[delta.META] = meta.to_bytes()
        return delta.MapDelta(self._version, parts)

    def restore(self, deltas: Iterable[Mapping[str, bytes]]) -> list[str]:
        """Take up a map; return what could not be read. What can be is kept."""
        parts: dict[str, bytes] = {}
        for one in deltas:
            parts.update(one)
        problems: list[str] = []
        rows = [self.tracker.rows]
        for name, data in sorted(parts.items(), key=lambda part: part[0] != delta.META):
            try:
                self._restore_part(name, data, rows)
            except ValueError as error:
                problems.append(f"{name}: {error}")
        self.tracker.restore(np.concatenate(rows), self.tracker.next_id)
        self._way = float(self.tracker.rows["born"].max(initial=0.0)) + 2 * self._settings.anchor_m
        everything = np.arange(len(self.tracker.rows))
        self._stalls.update(self.tracker.rows, everything, [], self._version)
        self._encoder.mark(set(self.grid.tiles))
        confirmed = self.tracker.confirmed
        while self._encoder.encode(self.grid, confirmed, 64, self._version, (0.0, 0.0)):
            self.grid.rest(64)
        self.encode(None)
        return problems

    def _restore_part(self, name: str, data: bytes, rows: list[NDArray[np.void]]) -> None:
        kind = name.partition("/")[0]
        if kind == delta.META:
            meta = delta.MapMeta.from_bytes(data)
            self._map_id, self._version = meta.map_id, max(self._version, meta.version)
            self.tracker.next_id = max(self.tracker.next_id, meta.next_id)
            self.registration.restore(Shift(*meta.shift))
        elif kind == delta.GRID:
            self.grid.put(delta.tile_key(name), EvidenceTile(data), self._version)
        elif kind == delta.MOSAIC:
            self._mosaic.restore(delta.tile_key(name), self._version, data)
        elif kind == delta.STALL:
            if data:
                rows.append(from_bytes(data))
        else:
            raise ValueError("an unknown part")

    def _weight(self, pose: MapPose) -> float:
        """How much of an independent look the frame is: by the way flown and the turn since the last one."""
        last, self._last_pose = self._last_pose, pose
        if last is None:
            return 1.0
        way = math.dist((pose.north, pose.east, pose.height), (last.north, last.east, last.height))
        turn = abs(math.remainder(pose.yaw - last.yaw, math.tau))
        self._way += way
        settings = self._settings
        return min(1.0, settings.still_weight + way / settings.look_m + turn / 0.6)

    def _attend(self, seen: Seen) -> None:
        """Have the stalls at hand that anything below looks at."""
        (north, east), radius = _extent(seen)
        aside = math.hypot(north - seen.pose.north, east - seen.pose.east)
        about = radius + max(math.sqrt(2) * self._settings.outline_reach_m, self._settings.rows_reach_m) + _REACH_M
        self.tracker.attend(north, east, max(about, aside + _DRAWN_M) + self._settings.max_shift_m)

    def _register(self, found: Detections, seen: Seen, raised: float) -> NDArray[np.float64]:
        pose = seen.pose
        near = self.tracker.near(pose.north, pose.east, _REGISTER_M)
        rows = self.tracker.rows[near]
        rows = rows[rows["confirmed"] & ~rows["inferred"]]
        known = np.stack([rows["north"], rows["east"], angle_of(rows)], -1)
        sure = found.take(found.is_whole)
        drone = (pose.north, pose.east)
        places = drone + (np.stack([sure.north, sure.east], -1) - drone) / raised
        anchored = self._way - rows["born"] > self._settings.anchor_m
        size = None if seen.scale == 1.0 else seen.scale / raised
        told = np.column_stack([places, sure.angle])
        shift = self.registration.update(known, told, drone, seen.captured, anchored, size)
        return replace(shift, scale=shift.scale / raised).about(*drone)

    def _fuse_stalls(self, found: Detections, evidence: CellEvidence, weight: float, seen: Seen) -> None:
        def in_picture(points: NDArray[np.float64]) -> NDArray[np.bool_]:
            cells = np.round(evidence.window.cells_of(points[:, 0], points[:, 1])).astype(int)
            inside = np.all((cells >= 0) & (cells < (evidence.window.columns, evidence.window.rows)), axis=1)
            column, row = np.where(inside[:, None], cells, 0).T
            return np.asarray(inside & (evidence.mask[row, column] > 0))

        middle, radius = _extent(seen)
        look = Look(found, weight, seen.captured, in_picture, self._version, self._way)
        self.tracker.fuse(look, self.tracker.near(*middle, radius + _REACH_M))

    def _show_stalls(self) -> None:
        rows = self.tracker.rows
        fresh = np.flatnonzero(rows["touched"] == self._version)
        changed = self._stalls.update(rows, fresh, self.tracker.take_gone(), self._version)
        self._encoder.mark_around(changed)

    def _complete_rows(self, _: Window, seen: Seen) -> bool:
        if self._frame - self._rows_at < self._settings.rows_frames:
            return False
        self._rows_at = self._frame
        self._is_spent = True
        self._rows.run(self.tracker, self.grid, _extent(seen)[0], self._version)
        return True

    def _outline(self, window: Window, seen: Seen) -> bool:
        """Draw the lot's outline anew around the picture."""
        settings = self._settings
        is_due = self._frame - self._outlined_at >= settings.outline_frames
        if not is_due and not _is_farther(self._outlined, seen.pose, settings.outline_step_m):
            return False
        self._outlined, self._outlined_at = seen.pose, self._frame
        reach = round(settings.outline_reach_m / EVIDENCE_M)
        wide = window.grown(reach).aligned(2)
        rows = self.tracker.rows[self.tracker.near(*wide.middle, math.hypot(*wide.shape) * EVIDENCE_M / 2)]
        shown = classify(self.grid, wide, corners_of(rows[rows["confirmed"]]))
        # near its edge a window does not know what is to be closed over
        inner = window.grown(reach - round(CLOSE_M / EVIDENCE_M))
        self._show(inner, shown[wide.part(inner)])
        return True

    def _show(self, window: Window, shown: NDArray[np.uint8]) -> None:
        for key, in_tile, in_window in window.tiles():
            tile = self.grid.tile(key)
            if tile is None:
                continue
            if not np.array_equal(tile.shown[in_tile], shown[in_window]):
                tile.shown[in_tile] = shown[in_window]
                self.grid.note_change(key, self._version)
                self._encoder.mark({key})
                self._touched.add(key)
            if key in self._touched:
                self.grid.summarise(key)
                self._touched.discard(key)

    def _rest(self, _: Window, __: Seen) -> bool:
        return self.grid.rest() > 0

    def _picture(self, _: Window, seen: Seen) -> bool:
        if not _is_farther(self._pictured, seen.pose, self._settings.mosaic_step_m):
            return False
        self._pictured = seen.pose
        self._mosaic.add(seen.picture, (seen.pose.north, seen.pose.east), seen.pose.height)
        return True


def _extent(seen: Seen) -> tuple[tuple[float, float], float]:
    """Middle (north, east) of the picture on the ground, and the radius about it."""
    corners = outline(seen.lot)
    middle = corners.mean(0)
    return (float(middle[0]), float(middle[1])), float(np.hypot(*(corners - middle).T).max())


def _corrected(seen: Seen, correction: NDArray[np.float64]) -> Seen:
    pose = seen.pose
    north, east = correction[:, :2] @ (pose.north, pose.east) + correction[:, 2]
    return Seen(
        stalls=seen.stalls,
        lot=moved(seen.lot, correction),
        car=moved(seen.car, correction),
        core=moved(seen.core, correction),
        picture=moved(seen.picture, correction),
        park_lot_detected=seen.park_lot_detected,
        scale=seen.scale,
        pose=MapPose(float(north), float(east), pose.height, pose.roll, pose.pitch, pose.yaw),
        captured=seen.captured,
    )


def _is_farther(last: MapPose | None, pose: MapPose, step: float) -> bool:
    return last is None or math.dist((last.north, last.east, last.height), (pose.north, pose.east, pose.height)) >= step
