"""The map: combines registration, evidence, stalls, outline, mosaic and encoding for each frame.

Work that is not needed on every frame (outline, mosaic) is done one piece a frame, so that no frame pays for two; the
rows go on by one step a frame.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hawk.algo.ground import Window, tile_window
from hawk.algo.mapper import delta
from hawk.algo.mapper.cell_classes import CLOSE_M, classify
from hawk.algo.mapper.evidence import (
    EVIDENCE_M,
    CellEvidence,
    Novelty,
    cell_evidence,
    extent,
    moved,
    outline,
    quality_mask,
)
from hawk.algo.mapper.grid import EvidenceGrid, EvidenceTile
from hawk.algo.mapper.mosaic import Mosaic
from hawk.algo.mapper.plan_on_map import PlanOnMap, given_look
from hawk.algo.mapper.published import StallIndex, TileEncoder
from hawk.algo.mapper.register import Registration, Shift
from hawk.algo.mapper.rowfill import RowFiller
from hawk.algo.mapper.stalls import Look, StallTracker
from hawk.algo.mapper.suggestions import Sight, Suggestion, Suggestions, car_boxes
from hawk.algo.mapper.table import Detections, angle_of, corners_of, from_bytes, geometry_of, probability, to_bytes
from hawk.algo.mapper.vehicles import TrackedVehicle, VehicleLook, VehicleTracker, moved_vehicles
from hawk.algo.registration.after_swap import REACH_M, SAME_CARS_S, AfterSwap, Stalls, TooFewError
from hawk.algo.vision.detection import FrameGround, GroundImage, Vehicle
from hawk.model.known_lot import KnownLot
from hawk.model.lot_map import TILE_M, Cell, OccupancyMap, Stall, TileKey
from hawk.model.plans import Inbound
from hawk.model.poses import MapPose
from hawk.model.shards import Sharded
from hawk.model.vehicles import MapVehicle


@dataclass(frozen=True, slots=True)
class MapperSettings:
    """Settings of the Mapper App."""

    good_share: float = 0.85
    """Middle share of the picture along each axis within which a place is seen well."""
    edge_m: float = 0.6
    """Border of the valid picture that is not used at all."""
    look_m: float = 5.0
    """Distance flown after which a frame is an independent look."""
    still_weight: float = 0.02
    """Weight of a frame from a place that was seen from already, until it adds nothing more (`Novelty`)."""
    anchor_m: float = 40.0
    """Distance flown since a stall was first found after which it holds the map in place: several passes show it."""
    max_shift_m: float = 2.0
    """Largest position error that registration takes out at once, about the last known error."""
    registers: bool = True
    """False: poses are taken as they are, because they were adjusted together already."""
    tiles_per_frame: int = 3
    """Tiles encoded at most in one frame."""
    slow_pieces: int = 1
    """Pieces of outline, mosaic, eviction and suggestions done at most in one frame."""
    mosaic_tiles_per_frame: int = 1
    """Mosaic tiles encoded at most in one frame."""
    mosaic_blended_tiles: int = 6
    """Mosaic tiles into which a picture is blended at most in one frame."""
    mosaic_pictures: int = 4
    """Pictures that wait for their turn at most."""
    mosaic_step_m: float = 1.5
    """Distance flown between two pictures that go into the mosaic."""
    rows_frames: int = 6
    """Frames between the begins of two completions of the rows near the drone, at least."""
    rows_reach_m: float = 28.0
    """Radius about the middle of the picture within which rows are completed."""
    outline_step_m: float = 2.0
    """Distance flown between two updates of the lot's outline."""
    outline_frames: int = 8
    """Most frames between two updates of the lot's outline."""
    cars_step_m: float = 10.0
    """Distance flown between two looks for cars that stand where no stall is known."""
    cars_frames: int = 12
    """Frames between them at least: where frames are few, they are left to the other work."""
    outline_reach_m: float = 18.0
    """Ground around the picture that is used for the outline; it is drawn up to ``CLOSE_M`` short of it."""


_SHARD = 128  # ids
_REACH_M = 12.0  # stalls this far outside the picture still matter to the outline
_LOT_NEAR_M = 0.5
_SAME = np.eye(2, 3)
_MANY_TILES = 16
_ROWS_STEP_M, _ROWS_RUNS = 16.0, 3  # a row counts once runs about several places imply it
_REGISTER_M = 60.0
_WHOLE_M = 3.0  # a stall this far from the picture's edge is in it as a whole
_BREAK_S = 60.0  # without a frame: the drone was on the ground, or its position was not trusted
_DRAWN_M = 90.0  # from the drone: what others ask about (`stalls_near`)
_PICTURE_TURN = 0.12  # radians after which a picture shows 3 m of other ground on its sides
_TILE_REACH_M = TILE_M * math.sqrt(0.5) + 5.0  # and half the diagonal of the longest stall


class MapCore:
    """One survey's map."""

    def __init__(self, settings: MapperSettings, map_id: str) -> None:
        self._settings = settings
        self._map_id = map_id
        self._version = 0
        self.grid = EvidenceGrid()
        self.tracker = StallTracker()
        self.registration = Registration(settings.max_shift_m)
        self._encoder = TileEncoder()
        self._mosaic = Mosaic()
        self.published = StallIndex()
        self._rows = RowFiller(settings.rows_reach_m)
        self.suggestions = Suggestions()
        self.vehicles = VehicleTracker()
        self._knows_vehicles = False
        self._vehicles: Sharded[int, MapVehicle] = Sharded(lambda number: number // _SHARD)
        self._novelty = Novelty(settings.look_m, settings.still_weight)
        self._last_pose: MapPose | None = None
        self._outlined: MapPose | None = None
        self._pictured: MapPose | None = None
        self._pictures: deque[tuple[GroundImage, MapPose]] = deque()
        self._looked_for_cars: MapPose | None = None
        self._flown_m = 0.0
        self._fused_at = math.inf
        self._relocation: AfterSwap | None = None
        self._plan = PlanOnMap()
        self._earlier_m = 0.0
        self._frame = self._outlined_at = self._rows_at = self._cars_at = 0
        self._is_spent = False
        self._touched: set[TileKey] = set()
        self._slow_steps: list[Callable[[CellEvidence, FrameGround], bool]] = [
            self._outline,
            self._picture,
            lambda *_: self.grid.evict() > 0,
            self._suggest,
        ]
        self.index = OccupancyMap(map_id=map_id)

    def fuse(self, seen: FrameGround) -> None:
        """Fuse one frame, unless it is not known yet where on an earlier flight's map it lies."""
        self._attend(seen)
        found = Detections.of(seen.stalls)
        if seen.captured - self._fused_at > _BREAK_S:
            self._begin_relocation(has_same_cars=seen.captured - self._fused_at < SAME_CARS_S)
        self._fused_at = seen.captured
        if self._relocation is not None and self._is_waiting(self._relocation, found, seen):
            return
        self._version += 1
        self._fly_on(seen.pose)
        weight = self._novelty.of(seen.pose)
        correction = _SAME
        if self._settings.registers:
            correction = self._register(found, seen)
            found = found.with_leans(self.registration.slip.leans)
            seen = _corrected(seen, correction)
        evidence = cell_evidence(seen, self._settings.edge_m, self._settings.good_share)
        if evidence is None:
            return
        self._touched.update(self.grid.fuse(evidence, weight, self._version))
        self._fuse_stalls(found.moved(correction), evidence, weight, seen)
        if seen.vehicles is not None:
            self._knows_vehicles = True
            self._fuse_vehicles(moved_vehicles(seen.vehicles, correction), evidence, weight, seen)
        self._frame += 1
        self._is_spent = False
        self._note_picture(seen)
        for _ in range(self._settings.slow_pieces):
            step = next((step for step in self._slow_steps if step(evidence, seen)), None)
            if step is None:
                break
            self._slow_steps.remove(step)
            self._slow_steps.append(step)
        self._complete_rows(seen)
        self._place_plan(seen.captured)
        self._show_stalls()

    def finish(self) -> None:
        """Do all the work that waits, at once: rows everywhere, outline, mosaic, encoding. No frame may follow soon."""
        confirmed = self.tracker.confirmed
        places = {(round(n / _ROWS_STEP_M), round(e / _ROWS_STEP_M)) for n, e in confirmed[["north", "east"]].tolist()}
        for north, east in sorted(places) * _ROWS_RUNS:
            self._version += 1
            middle = north * _ROWS_STEP_M, east * _ROWS_STEP_M
            self.tracker.attend(*middle, self._settings.rows_reach_m + _DRAWN_M)
            self._rows.begin(self.tracker, self.grid, middle)
            while self._rows.is_under_way:
                self._rows.go_on(self.tracker, self._version)
            self._show_stalls()
        self._version += 1
        for key in sorted(self.grid.tiles):
            self._outline_about(tile_window(key, EVIDENCE_M))
            self.grid.evict(_MANY_TILES)
        while self._picture():
            pass
        while self._encode_tiles(_MANY_TILES, (0.0, 0.0)) or self._mosaic.encode(_MANY_TILES, self._version):
            self.grid.evict(_MANY_TILES)
        self._renew_index()

    def know(self, lots: Sequence[KnownLot]) -> None:
        """Take the plans of the lots that are flown over: their places are looked for, then confirmed stalls are given.

        Without one nothing changes: what is given stays so.
        """
        self._plan.know(lots)

    def encode(self, pose: MapPose | None) -> None:
        """Encode a bounded number of changed tiles and renew the index; only one tile after the costliest step."""
        settings = self._settings
        near = (0.0, 0.0) if pose is None else (pose.north, pose.east)
        self._encode_tiles(1 if self._is_spent else settings.tiles_per_frame, near)
        self._mosaic.encode(0 if self._is_spent else settings.mosaic_tiles_per_frame, self._version)
        self._renew_index()

    def _encode_tiles(self, most: int, near: tuple[float, float]) -> bool:
        parts = [
            self.tracker.about(-(row + 0.5) * TILE_M, (column + 0.5) * TILE_M, _TILE_REACH_M)
            for row, column in self._encoder.next_tiles(most, near)
        ]
        if parts:
            rows = np.concatenate(parts)
            _, once = np.unique(rows["id"], return_index=True)  # drawn twice is not drawn: polygons fill even-odd
            self._encoder.encode(self.grid, rows[once], most, self._version, near)
        return bool(parts)

    def _renew_index(self) -> None:
        self.index = OccupancyMap(
            tiles=self._encoder.encoded,
            mosaic=self._mosaic.encoded,
            stalls=self.published.stalls,
            vehicles=self._vehicles if self._knows_vehicles else None,
            counts=self.published.counts(),
            lot_area_m2=round(self.grid.lot_area_m2, 1),
            version=self._version,
            map_id=self._map_id,
        )

    def stalls_near(self, north: float, east: float, radius: float) -> list[Stall]:
        """Return the valid stalls within a radius (metres) of a place near the drone."""
        rows = self.tracker.rows[self.tracker.near(north, east, radius)]
        return [self.index.stalls[i] for i in rows["id"][rows["confirmed"]].tolist() if i in self.index.stalls]

    def plan_places(self, lot: str) -> NDArray[np.float64] | None:
        """Return the stalls (N, 5) of the plan of a lot, see `PlanOnMap.places`."""
        return self._plan.places(lot)

    def inbound(self, north: float, east: float) -> Inbound:
        """Return the verdict on a place, by the majority of the cells within half a metre."""
        if not (math.isfinite(north) and math.isfinite(east)):
            return Inbound.UNKNOWN
        window = Window.around(np.array([[north, east]]), EVIDENCE_M, _LOT_NEAR_M)
        shown = self.grid.layer(window, "shown")
        middle = shown[window.rows // 2, window.columns // 2]
        known = np.count_nonzero(shown)
        if known < shown.size / 2 or middle == Cell.UNKNOWN:
            return Inbound.UNKNOWN
        return Inbound.INSIDE if np.count_nonzero(shown == Cell.LOT) > known / 2 else Inbound.OUTSIDE

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
        for number, suggestion in self.suggestions.changed_since(version):
            parts[f"{delta.SUGGESTION}/{number}"] = b"" if suggestion is None else suggestion.to_bytes()
        for number, vehicle in self.vehicles.changed_since(version):
            parts[f"{delta.VEHICLE}/{number}"] = b"" if vehicle is None else vehicle.to_bytes()
        shift = self.registration.shift
        meta = delta.MapMeta(self._map_id, self._version, self.tracker.next_id, (shift.north, shift.east, shift.turn))
        parts[delta.META] = meta.to_bytes()
        return delta.MapDelta(self._version, parts)

    def restore(self, deltas: Iterable[Mapping[str, bytes]], *, has_same_cars: bool = True) -> list[str]:
        """Restore a map; return the parts that cannot be read, in words. The others are kept.

        ``has_same_cars``: it is younger than `SAME_CARS_S`.
        """
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
        self._flown_m = float(self.tracker.rows["born"].max(initial=0.0)) + 2 * self._settings.anchor_m
        self._begin_relocation(has_same_cars=has_same_cars)
        everything = np.arange(len(self.tracker.rows))
        self.published.update(self.tracker.rows, everything, [], self._version)
        self._show_suggestions(-1)
        self._show_vehicles(-1)
        self._encoder.mark(set(self.grid.tiles))
        confirmed = self.tracker.confirmed
        while self._encoder.encode(self.grid, confirmed, 64, self._version, (0.0, 0.0)):
            self.grid.evict(64)
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
        elif kind == delta.SUGGESTION:
            if data:
                self.suggestions.restore(Suggestion.from_bytes(data), self._version)
        elif kind == delta.VEHICLE:
            if data:
                self._knows_vehicles = True
                self.vehicles.restore(TrackedVehicle.from_bytes(data), self._version)
        else:
            raise ValueError("an unknown part")

    def _fly_on(self, pose: MapPose) -> None:
        last, self._last_pose = self._last_pose, pose
        if last is not None:
            self._flown_m += pose.distance(last)

    def _attend(self, seen: FrameGround) -> None:
        """Load the stalls about the picture."""
        (north, east), radius = extent(seen.lot)
        aside = math.hypot(north - seen.pose.north, east - seen.pose.east)
        about = radius + max(math.sqrt(2) * self._settings.outline_reach_m, self._settings.rows_reach_m) + _REACH_M
        self.tracker.attend(north, east, max(about, aside + _DRAWN_M) + self._settings.max_shift_m)

    def _register(self, found: Detections, seen: FrameGround) -> NDArray[np.float64]:
        pose = seen.pose
        near = self.tracker.near(pose.north, pose.east, _REGISTER_M)
        rows = self.tracker.rows[near]
        rows = rows[rows["confirmed"] & ~rows["inferred"]]
        known = np.stack([rows["north"], rows["east"], angle_of(rows)], -1)
        sure = found.take(found.is_whole)
        drone = (pose.north, pose.east)
        anchored = self._flown_m - rows["born"] > self._settings.anchor_m
        places = np.stack([sure.north, sure.east, sure.angle], -1)
        return self.registration.update(known, places, drone, seen.captured, anchored).about(*drone)

    def _begin_relocation(self, *, has_same_cars: bool) -> None:
        """Look for the drone's place on the map as it is now: that of the flight before."""
        self._relocation, self._earlier_m = AfterSwap(has_same_cars=has_same_cars), self._flown_m

    def _is_waiting(self, relocation: AfterSwap, found: Detections, seen: FrameGround) -> bool:
        """Return True while the frame must wait for its place on the earlier map; over other ground it need not."""
        pose, shift = seen.pose, self.registration.shift
        correction = shift.about(pose.north, pose.east)
        rows = self.tracker.rows[self.tracker.near(pose.north, pose.east, _REGISTER_M)]
        rows = rows[rows["confirmed"] & ~rows["inferred"] & (rows["born"] <= self._earlier_m)]
        sure = found.take(found.is_whole).moved(correction)
        lot = moved(seen.lot, correction)
        usable = quality_mask(lot.valid, lot.metres_per_pixel, _WHOLE_M, self._settings.good_share) > 0
        reached = np.vstack([outline(lot), *(outline(lot) + REACH_M, outline(lot) - REACH_M)])
        window = Window.around(reached, EVIDENCE_M)
        well = self.grid.layer(window, "well")
        known = Stalls(np.stack([rows["north"], rows["east"]], -1), angle_of(rows), probability(rows["taken"]))
        try:
            step = relocation.look(
                known,
                Stalls(np.stack([sure.north, sure.east], -1), sure.angle, sure.taken),
                lambda places: _at(usable, lot.pixel_points(places)),
                lambda places: window.values_at(well, places) > 0,
            )
        except TooFewError:
            everything = found.moved(correction)
            return relocation.is_doubtful(known.places, np.stack([everything.north, everything.east], -1))
        if step is not None:
            self._relocate(step)
        if relocation.is_over:
            self._relocation = None
        return not relocation.is_over

    def _relocate(self, step: NDArray[np.float64]) -> None:
        """Move the drone, and what this flight has found already, to their place on the earlier map.

        The evidence of ground stays where it was put: later frames outweigh it.
        """
        self.registration.relocate(step)
        version = self._version + 1  # that of the frame which is fused next
        index = self.tracker.move_younger(self._earlier_m, step, version)
        self._encoder.mark_around(self.published.update(self.tracker.rows, index, [], version))
        self._rows.drop()
        self.suggestions.forget_younger(self._earlier_m, version)
        self._show_suggestions(version - 1)
        self.vehicles.forget_younger(self._earlier_m, version)
        self._show_vehicles(version - 1)

    def _fuse_stalls(self, found: Detections, evidence: CellEvidence, weight: float, seen: FrameGround) -> None:
        middle, radius = extent(seen.lot)
        still = self._settings.still_weight
        local = self.tracker.near(*middle, radius + _REACH_M)
        given = given_look(self.tracker.rows, local, seen)
        look = Look(found, weight, seen.captured, evidence.in_picture, self._version, self._flown_m, still, given,
                    seen.is_blurred)  # fmt: skip
        self.tracker.fuse(look, local)

    def _fuse_vehicles(
        self, found: tuple[Vehicle, ...], evidence: CellEvidence, weight: float, seen: FrameGround
    ) -> None:
        if not found and not self.vehicles.known:
            return
        middle, radius = extent(seen.lot)
        sight = VehicleLook(found, evidence.in_picture, weight, self._flown_m, seen.captured, self._version)
        self.tracker.next_id = self.vehicles.look(sight, middle, radius + _REACH_M, self.tracker.next_id)
        self._show_vehicles(self._version - 1)

    def _show_vehicles(self, since: int) -> None:
        """Publish the vehicles that were looked at after a version."""
        changed = dict(self.vehicles.shown(since))
        news = {number: vehicle for number, vehicle in changed.items() if vehicle is not None}
        self._vehicles = self._vehicles.changed(news, changed.keys() - news.keys())

    def _show_stalls(self) -> None:
        rows = self.tracker.rows
        fresh = np.flatnonzero(rows["touched"] == self._version)
        changed = self.published.update(rows, fresh, self.tracker.take_gone(), self._version)
        self._encoder.mark_around(changed)

    def _show_suggestions(self, since: int) -> None:
        """Publish the suggested stalls that were looked at after a version."""
        changed = self.suggestions.changed_since(since)
        self.published.suggest({i: one.to_stall() if one is not None and one.is_shown else None for i, one in changed})

    def _suggest(self, evidence: CellEvidence, seen: FrameGround) -> bool:
        """Look for cars that stand where no stall is known."""
        settings = self._settings
        is_due = self._frame - self._cars_at >= settings.cars_frames
        if not is_due or not _is_farther(self._looked_for_cars, seen.pose, settings.cars_step_m):
            return False
        self._looked_for_cars, self._cars_at = seen.pose, self._frame
        window, (middle, radius) = evidence.window, extent(seen.lot)
        car = self.grid.layer(window, "car") * (evidence.mask > 0)
        rows = self.tracker.rows[self.tracker.near(*middle, radius + _REACH_M)]
        sight = Sight(
            cars=car_boxes(car, window),
            car_at=lambda places: window.values_at(car, places),
            in_picture=evidence.in_picture,
            stalls=geometry_of(rows[rows["confirmed"]]),
            flown_m=self._flown_m,
            time=seen.captured,
            version=self._version,
        )
        self.tracker.next_id = self.suggestions.look(sight, middle, radius, self.tracker.next_id)
        self._show_suggestions(self._version - 1)
        return True

    def _complete_rows(self, seen: FrameGround) -> None:
        """Do one step of a run over the rows near the drone."""
        if not self._rows.is_under_way and self._frame - self._rows_at >= self._settings.rows_frames:
            self._rows_at = self._frame
            self._rows.begin(self.tracker, self.grid, extent(seen.lot)[0])
        elif self._rows.is_under_way:
            self._rows.go_on(self.tracker, self._version)

    def _place_plan(self, time: float) -> None:
        """Go on to look for the place of the lot's plan; it comes onto the map once that is certain."""
        index = self._plan.go_on(self.tracker, self.grid, self._version, time)
        if index is not None:
            self._rows.drop()
            self.published.plan = self._plan.names
            gone = self.tracker.take_gone()
            self._encoder.mark_around(self.published.update(self.tracker.rows, index, gone, self._version))

    def _outline(self, evidence: CellEvidence, seen: FrameGround) -> bool:
        """Update the lot's outline around the picture."""
        settings, window = self._settings, evidence.window
        is_due = self._frame - self._outlined_at >= settings.outline_frames
        if not is_due and not _is_farther(self._outlined, seen.pose, settings.outline_step_m):
            return False
        self._outlined, self._outlined_at = seen.pose, self._frame
        self._outline_about(window)
        return True

    def _outline_about(self, window: Window) -> None:
        reach = round(self._settings.outline_reach_m / EVIDENCE_M)
        wide = window.grown(reach).aligned(2)
        rows = self.tracker.rows[self.tracker.near(*wide.middle, math.hypot(*wide.shape) * EVIDENCE_M / 2)]
        shown = classify(self.grid, wide, corners_of(rows[rows["confirmed"]]))
        # gaps at the window's edge cannot be closed
        inner = window.grown(reach - round(CLOSE_M / EVIDENCE_M))
        self._show(inner, shown[wide.part(inner)])

    def _show(self, window: Window, shown: NDArray[np.uint8]) -> None:
        for key, in_tile, in_window in window.tiles():
            tile = self.grid.tile(key)
            if tile is None:
                continue
            if not np.array_equal(tile.layers.shown[in_tile], shown[in_window]):
                tile.layers.shown[in_tile] = shown[in_window]
                self.grid.note_change(key, self._version)
                self._encoder.mark({key})
                self._touched.add(key)
            if key in self._touched:
                self.grid.summarise(key)
                self._touched.discard(key)

    def _note_picture(self, seen: FrameGround) -> None:
        """Keep a picture of other ground than the last one's for the mosaic: other steps may have the frame's time."""
        last, settings = self._pictured, self._settings
        is_due = _is_farther(last, seen.pose, settings.mosaic_step_m) or _is_turned(last, seen.pose)
        if is_due and len(self._pictures) < settings.mosaic_pictures:
            self._pictured = seen.pose
            self._pictures.append((seen.picture, seen.pose))

    def _picture(self, *_: object) -> bool:
        most = self._settings.mosaic_blended_tiles
        if self._mosaic.go_on(most):
            return True
        if not self._pictures:
            return False
        picture, pose = self._pictures.popleft()
        self._mosaic.add(picture, (pose.north, pose.east), pose.height, most)
        return True


def _at(mask: NDArray[np.bool_], cells: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return the mask at (column, row) cells (N, 2), False outside it."""
    column, row = np.round(cells).astype(int).T
    inside = (row >= 0) & (row < mask.shape[0]) & (column >= 0) & (column < mask.shape[1])
    return np.asarray(inside & mask[np.where(inside, row, 0), np.where(inside, column, 0)])


def _corrected(seen: FrameGround, correction: NDArray[np.float64]) -> FrameGround:
    pose = seen.pose
    north, east = correction[:, :2] @ (pose.north, pose.east) + correction[:, 2]
    return replace(
        seen,
        lot=moved(seen.lot, correction),
        car=moved(seen.car, correction),
        core=moved(seen.core, correction),
        taken=moved(seen.taken, correction),
        picture=moved(seen.picture, correction),
        pose=replace(pose, north=float(north), east=float(east)),
    )


def _is_turned(last: MapPose | None, pose: MapPose) -> bool:
    return last is not None and abs(math.remainder(pose.yaw - last.yaw, math.tau)) > _PICTURE_TURN


def _is_farther(last: MapPose | None, pose: MapPose, step: float) -> bool:
    return last is None or last.distance(pose) >= step
