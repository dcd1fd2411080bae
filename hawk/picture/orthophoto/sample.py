"""Windows of a picture for checking by eye: its lots cut into squares, each with what the program counts in it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from itertools import product
from typing import Final

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from hawk.algo.mapper.vehicles import SHOWN
from hawk.model.lot_map import StallState
from hawk.picture.orthophoto.grid import FloatArray
from hawk.picture.orthophoto.outline_lots import polygons_of
from hawk.picture.orthophoto.survey import Findings, PictureFrame
from hawk.picture.orthophoto.tile_detector import states_of
from hawk.picture.values import SampleWindow
from hawk.results.map_picture import FREE, TAKEN

SIDE_M: Final = 40.0
"""Side of a window, metres: some 40 stalls, which a person counts in a minute."""
_MARGIN_M: Final = 5.0
_LEAST_M2: Final = 25.0
"""A window with less ground of lots is no window: two stalls."""
_LEAST_PX: Final = 600
"""Side of a picture, at least: a coarser one is enlarged."""
_SQUARE: Final = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], np.float64)
_LOT: Final = (255, 0, 255)
_BORDER: Final = (0, 220, 255)
_UNKNOWN: Final = (255, 255, 255)
_VEHICLE: Final = (80, 255, 80)


class PictureSample:
    """The windows of one picture."""

    def __init__(self, findings: Findings, plane: PictureFrame) -> None:
        """``plane``: the picture with the lots that count; without lots all ground that was looked at."""
        self._findings = findings
        self._plane = plane
        self._stalls = findings.counted_on(plane)
        self._metres = np.array(findings.source.grid.metres)

    @property
    def _shown(self) -> FloatArray:
        """Corners (V, 4, 2) of the vehicles that are sure enough."""
        vehicles = self._stalls.vehicles
        return np.zeros((0, 4, 2)) if vehicles is None else vehicles.corners[vehicles.probability >= SHOWN]

    @property
    def identity(self) -> str:
        """Text that is the same for the same picture, network, outlines and findings."""
        stalls = self._stalls
        content = [
            self._findings.source.identity, self._findings.model, SIDE_M, stalls.corners.round(2).tolist(),
            stalls.taken.round(4).tolist(), stalls.vehicle_corners.round(2).tolist(),
        ]  # fmt: skip
        return hashlib.sha256(json.dumps(content).encode()).hexdigest()

    def windows(self) -> tuple[SampleWindow, ...]:
        """Return the windows with lot ground, row by row."""
        stalls = self._stalls
        states = states_of(stalls.taken)
        doubt = 1 - stalls.score * np.maximum(stalls.taken, 1 - stalls.taken)
        cells = {
            "free": self._cells(stalls.corners[[state is StallState.FREE for state in states]]),
            "taken": self._cells(stalls.corners[[state is StallState.TAKEN for state in states]]),
        }
        if stalls.vehicles is not None:
            cells["vehicles"] = self._cells(self._shown)
        counts = {name: _counted(found) for name, found in cells.items()}
        doubts: dict[tuple[int, int], float] = {}
        for cell, value in zip(self._cells(stalls.corners), doubt.tolist(), strict=True):
            doubts[cell] = doubts.get(cell, 0.0) + value
        for cell in self._cells(stalls.suggested):
            doubts[cell] = doubts.get(cell, 0.0) + 1.0
        return tuple(
            SampleWindow(
                number, f"{row}/{column}", {name: each.get((row, column), 0) for name, each in counts.items()},
                round(doubts.get((row, column), 0.0), 4), self._ring((row, column)),
            )
            for number, (row, column) in enumerate(self._grounds(), 1)
        )  # fmt: skip

    def picture(self, window: SampleWindow) -> NDArray[np.uint8]:
        """Return a window's picture, BGR: the ground alone, and beside it with what the program found. Its border is
        yellow, the lots' magenta: what has its middle in both counts. Raises PictureError.
        """
        row, column = (int(part) for part in window.name.split("/"))
        low = np.array([column, row]) * SIDE_M - _MARGIN_M
        grid = self._findings.source.grid
        most = np.array([grid.columns, grid.rows])
        left, top = np.clip(np.floor(low / self._metres), 0, most).astype(int).tolist()
        right, bottom = np.clip(np.ceil((low + SIDE_M + 2 * _MARGIN_M) / self._metres), 0, most).astype(int).tolist()
        image = self._findings.source.read((left, top, right, bottom)).image
        scale = max(1.0, _LEAST_PX / min(image.shape[:2]))
        size = (round(image.shape[1] * scale), round(image.shape[0] * scale))
        plain = np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_CUBIC), np.uint8)
        corner, marked = np.array([left, top]), plain.copy()

        def draw(quads: FloatArray, colour: tuple[int, int, int]) -> None:
            pixels = np.rint((quads - corner) * scale).astype(np.int32)
            cv2.polylines(marked, [*pixels], True, colour, 2, cv2.LINE_AA)

        states = np.array([str(state) for state in states_of(self._stalls.taken)], object)
        colours = {"free": FREE, "taken": TAKEN, "unknown": _UNKNOWN}
        for state, colour in colours.items():
            draw(self._stalls.corners[states == state], colour)
        draw(self._shown, _VEHICLE)
        border = _SQUARE * SIDE_M + (low + _MARGIN_M)
        for each in (plain, marked):
            for ring, colour, width in (*((ring, _LOT, 1) for ring in self._edges(low)), (border, _BORDER, 2)):
                pixels = np.rint((ring / self._metres - corner) * scale).astype(np.int32)
                cv2.polylines(each, [pixels], True, colour, width, cv2.LINE_AA)
        return np.hstack([plain, marked])

    def _edges(self, low: FloatArray) -> Iterator[FloatArray]:
        """Yield the rings of the lots about a window, metres; ``low``: its upper left corner."""
        box = shapely.box(*low, *(low + SIDE_M + 2 * _MARGIN_M))
        for lot in () if self._plane.lots is None else self._plane.lots:
            if lot.intersects(box):
                for part in polygons_of(lot):
                    yield from (np.array(ring.coords) for ring in (part.exterior, *part.interiors))

    def _cells(self, quads: FloatArray) -> list[tuple[int, int]]:
        """Return the (row, column) of the window that has the middle of each quad (N, 4, 2)."""
        middles = np.floor(quads.mean(axis=1) * self._metres / SIDE_M).astype(int)
        return [(int(row), int(column)) for column, row in middles]

    def _grounds(self) -> list[tuple[int, int]]:
        """Return the windows with ground of lots, in order; those with a find too."""
        cells = {*self._cells(self._stalls.corners), *self._cells(self._shown)}
        if self._plane.lots is None:
            for part in self._findings.results:
                core = np.array(part.window.core, np.float64) * np.tile(self._metres, 2) / SIDE_M
                (left, top), (right, bottom) = np.floor(core[:2]).astype(int), np.ceil(core[2:]).astype(int)
                cells |= set(product(range(int(top), int(bottom)), range(int(left), int(right))))
            return sorted(cells)
        for lot in self._plane.lots:
            left, top, right, bottom = (np.array(lot.bounds) / SIDE_M).tolist()
            shapely.prepare(lot)
            for row in range(max(int(top), 0), int(bottom) + 1):
                for column in range(max(int(left), 0), int(right) + 1):
                    box = shapely.box(column * SIDE_M, row * SIDE_M, (column + 1) * SIDE_M, (row + 1) * SIDE_M)
                    if lot.intersection(box).area >= _LEAST_M2:
                        cells.add((row, column))
        return sorted(cells)

    def _ring(self, cell: tuple[int, int]) -> tuple[tuple[float, float], ...]:
        row, column = cell
        corners = (_SQUARE + np.array([column, row])) * SIDE_M / self._metres
        places = self._findings.source.grid.on_earth(corners)
        return tuple((round(float(latitude), 8), round(float(longitude), 8)) for latitude, longitude in places)


def _counted(cells: list[tuple[int, int]]) -> Mapping[tuple[int, int], int]:
    found: dict[tuple[int, int], int] = {}
    for cell in cells:
        found[cell] = found.get(cell, 0) + 1
    return found
