"""The network that looks for stalls and vehicles: an ONNX file run by one of the engines.

Input ``image``: float32 (1, 3, H, W), blue-green-red, value / 255 - 0.5, 0.1 m a pixel, H and W multiples of 32. Input
``sun``: float32 (1, 2), as `sun_input` gives it, 0 where the sun is not known; a network need not have it.
Output: float32 (1, 23, H/2, W/2); cell (c, r) belongs to input pixel (2 c, 2 r). Channels: logits of lot, stall core
(the inner 74 % of a stall) and car; sin and cos of twice the direction of the long side (atan2 of row over column);
offset to the stall's centre, columns and rows, in units of 10 cells; logarithms of width / 2.6 m and length / 5.2 m;
logit of taken. The next two are optional: logits of shade on the ground, and of what hides it (crowns, roofs). So are
the last eleven, of vehicles: logit of the core, direction, offset and size as of stalls, the sizes over 1.9 m and
4.6 m; then a logit for each of `VEHICLE_KINDS`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Final, Literal, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision.network_file import VisionModelError, packaged_weights, read_weights
from hawk.model.vehicles import VehicleKind
from hawk.runtime.programs import remedy

Engine = Literal["opencv", "onnxruntime"]
EngineChoice = Literal["auto", "opencv", "onnxruntime"]
"""An engine, or the fastest that is installed."""
DEFAULT_ENGINE: Final = "opencv"
"""The engine that is always installed."""

Blob = NDArray[np.float32]
Inputs = Mapping[str, Blob]

_FATAL_ONLY: Final = 4
"""ONNX Runtime's log level: what goes wrong is raised, so it need not be printed."""


class EngineError(Exception):
    """The engine cannot read or run the network; the text says why."""


class MissingEngineError(EngineError):
    """The engine is not installed."""


class Runner(Protocol):
    """One network in one engine."""

    def run(self, inputs: Inputs) -> Blob:
        """Return the first output for inputs by name. Raises EngineError."""
        ...


def open_runner(engine: Engine, onnx: bytes, threads: int) -> Runner:
    """Read an ONNX file. OpenCV takes its number of threads from ``cv2.setNumThreads``, ONNX Runtime this one.

    Raises:
        EngineError: The engine cannot read it.
        MissingEngineError: The engine is not installed.
    """
    return _OnnxRuntime(onnx, threads) if engine == "onnxruntime" else _OpenCv(onnx)


def open_chosen(choice: EngineChoice, onnx: bytes, threads: int) -> tuple[Engine, Runner]:
    """Read an ONNX file by the engine that is chosen; return which one it is. Raises as `open_runner` does."""
    if choice == "auto":
        try:
            return "onnxruntime", open_runner("onnxruntime", onnx, threads)
        except MissingEngineError:
            choice = DEFAULT_ENGINE
    return choice, open_runner(choice, onnx, threads)


class _OpenCv:
    def __init__(self, onnx: bytes) -> None:
        try:
            self._net = cv2.dnn.readNetFromONNX(np.frombuffer(onnx, np.uint8))
        except (cv2.error, ValueError) as error:
            raise EngineError(str(error)) from error

    def run(self, inputs: Inputs) -> Blob:
        """Return the first output for inputs by name."""
        try:
            for name, blob in inputs.items():
                self._net.setInput(blob, name)
            return np.asarray(self._net.forward(), np.float32)
        except cv2.error as error:
            raise EngineError(str(error)) from error


class _OnnxRuntime:
    def __init__(self, onnx: bytes, threads: int) -> None:
        try:
            import onnxruntime  # an extra
        except ImportError as error:
            raise MissingEngineError(str(error)) from error
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = threads
        options.inter_op_num_threads = 1
        options.log_severity_level = _FATAL_ONLY
        options.add_session_config_entry("session.intra_op.allow_spinning", "0")  # a waiting thread leaves its core
        try:
            self._session = onnxruntime.InferenceSession(onnx, options, providers=["CPUExecutionProvider"])
        except Exception as error:  # its errors have no class in common
            raise EngineError(str(error)) from error

    def run(self, inputs: Inputs) -> Blob:
        """Return the first output for inputs by name."""
        try:
            return np.asarray(self._session.run(None, dict(inputs))[0], np.float32)
        except Exception as error:  # as above
            raise EngineError(str(error)) from error


MapArray = NDArray[np.float32]

CELL_PIXELS = 2
"""Input pixels a side of an output cell."""
VEHICLE_CELLS = 2
"""Output cells a side that the network gives one answer about vehicles for."""
OFFSET_CELLS = 10.0
"""Unit of the offsets to a stall's centre, cells."""
USUAL_WIDTH_M = 2.6
"""Unit of the widths, metres."""
USUAL_LENGTH_M = 5.2
"""Unit of the lengths, metres."""
USUAL_VEHICLE_M: Final = (1.9, 4.6)
"""Units of the widths and lengths of vehicles, metres."""
VEHICLE_KINDS: Final = tuple(VehicleKind)
"""Order of the channels of kinds."""
CORE_SHARE = 0.74
"""Side of a stall's or vehicle's core as a share of the whole: cars bumper to bumper have two cores."""
CHANNELS = 10
"""Channels that every network has."""
FURTHER_CHANNELS = 2
SHAPE_CHANNELS: Final = 7
"""Core, sine, cosine, offset to column and row, width and length."""
VEHICLE_CHANNELS: Final = SHAPE_CHANNELS + len(VEHICLE_KINDS)
_FORMS: Final = (CHANNELS, CHANNELS + FURTHER_CHANNELS, CHANNELS + FURTHER_CHANNELS + VEHICLE_CHANNELS)
_MULTIPLE = 32
_LARGEST, _OVERLAP = 576, 64


@dataclass(frozen=True, slots=True)
class VehicleMaps:
    """The network's vehicles, as `NetworkMaps` has stalls, but each (rows, columns) at `VEHICLE_CELLS` cells a cell:
    offsets, too, are in these. ``kinds`` (4, rows, columns) are logits of `VEHICLE_KINDS`.
    """

    core: MapArray = field(repr=False)
    sine: MapArray = field(repr=False)
    cosine: MapArray = field(repr=False)
    offset_column: MapArray = field(repr=False)
    offset_row: MapArray = field(repr=False)
    width: MapArray = field(repr=False)
    length: MapArray = field(repr=False)
    kinds: MapArray = field(repr=False)

    def part(self, rows: slice, columns: slice) -> VehicleMaps:
        """Return the maps of a part of the picture, given in cells of `NetworkMaps`, whose first ones are even."""
        rows, columns = (slice(each.start // VEHICLE_CELLS, -(-each.stop // VEHICLE_CELLS)) for each in (rows, columns))
        return VehicleMaps(*(np.ascontiguousarray(getattr(self, f.name)[..., rows, columns]) for f in fields(self)))


@dataclass(frozen=True, slots=True)
class NetworkMaps:
    """Output of the network, each (rows, columns) at `CELL_PIXELS` a cell; ``lot``, ``core``, ``car``, ``taken``,
    ``shade`` and ``cover`` are probabilities, the rest as in the module's description, with offsets in cells and sizes
    in metres. ``shade`` and ``cover`` are 0 where the network does not say them, ``vehicles`` are None then.
    """

    lot: MapArray = field(repr=False)
    core: MapArray = field(repr=False)
    car: MapArray = field(repr=False)
    sine: MapArray = field(repr=False)
    cosine: MapArray = field(repr=False)
    offset_column: MapArray = field(repr=False)
    offset_row: MapArray = field(repr=False)
    width: MapArray = field(repr=False)
    length: MapArray = field(repr=False)
    taken: MapArray = field(repr=False)
    shade: MapArray = field(repr=False)
    cover: MapArray = field(repr=False)
    vehicles: VehicleMaps | None = field(default=None, repr=False)

    def part(self, rows: slice, columns: slice) -> NetworkMaps:
        """Return the maps of a part of the picture, given in cells."""
        changes: dict[str, Any] = {
            f.name: np.ascontiguousarray(getattr(self, f.name)[rows, columns])
            for f in fields(self)
            if f.name != "vehicles"
        }
        return replace(self, **changes, vehicles=None if self.vehicles is None else self.vehicles.part(rows, columns))


class StallNetwork:
    """A loaded network."""

    def __init__(
        self,
        onnx: bytes,
        source: str = "the network of the package",
        engine: EngineChoice = "auto",
        threads: int = 1,
    ) -> None:
        """Load it and try it on an empty picture. Raises VisionModelError when it does not fit."""
        self._source = source
        try:
            self.engine, self._runner = open_chosen(engine, onnx, threads)
        except MissingEngineError as error:
            raise VisionModelError(
                f"vision.engine: {engine} is not installed ({error}): {remedy(engine)}, or set it to {DEFAULT_ENGINE}"
            ) from error
        except EngineError as error:
            raise VisionModelError(
                f"vision.model: {source} is not an ONNX file that {_named(engine)} can read ({_short(error)}); "
                "name a network (.onnx) with the inputs and outputs of docs/model-card.md"
            ) from error
        self._takes_sun = self._is_asked_for_sun()
        self.run(np.zeros((64, 96, 3), np.uint8))

    @classmethod
    def load(cls, path: Path | None = None, engine: EngineChoice = "auto", threads: int = 1) -> StallNetwork:
        """Return the network at ``path``, that of the package for None. Raises VisionModelError."""
        if path is None:
            return cls(packaged_weights(), engine=engine, threads=threads)
        return cls(read_weights(path), str(path), engine, threads)

    def run(self, picture: NDArray[np.uint8], sun: Blob | None = None) -> NetworkMaps:
        """Return the maps of a picture, uint8 BGR (H, W, 3) at 0.1 m a pixel, each (ceil(H/2), ceil(W/2)).

        ``sun`` (2,) is that of `sun_input`, None where it is not known.

        Raises VisionModelError when the network's answer does not have the shape that is asked for.
        """
        rows, columns = (-(-side // CELL_PIXELS) for side in picture.shape[:2])
        output = np.empty((0, rows, columns), np.float32)
        for row, below in _parts(picture.shape[0]):
            for column, right in _parts(picture.shape[1]):
                part = self._forward(picture[row.start : row.stop, column.start : column.stop], sun)
                if part.shape[1:] == (rows, columns):
                    return maps_from_output(part)
                if not len(output):
                    output = np.empty((len(part), rows, columns), np.float32)
                output[:, below[0] : below[1], right[0] : right[1]] = part[
                    :, below[0] - row.start // CELL_PIXELS :, right[0] - column.start // CELL_PIXELS :
                ][:, : below[1] - below[0], : right[1] - right[0]]
        return maps_from_output(output)

    def _is_asked_for_sun(self) -> bool:
        """Return True when the network takes the sun: a file says its inputs only when it is run."""
        inputs = {"image": np.zeros((1, 3, 64, 64), np.float32), "sun": np.zeros((1, 2), np.float32)}
        try:
            self._runner.run(inputs)
        except EngineError:
            return False
        return True

    def _forward(self, picture: NDArray[np.uint8], sun: Blob | None) -> MapArray:
        """Return the raw answer (channels, ceil(H/2), ceil(W/2)) to a small picture."""
        rows, columns = picture.shape[:2]
        padded = cv2.copyMakeBorder(picture, 0, -rows % _MULTIPLE, 0, -columns % _MULTIPLE, cv2.BORDER_REFLECT_101)
        inputs = {"image": np.asarray(cv2.dnn.blobFromImage(padded, 1 / 255, mean=(127.5, 127.5, 127.5)), np.float32)}
        if self._takes_sun:
            inputs["sun"] = np.zeros((1, 2), np.float32) if sun is None else sun.reshape(1, 2)
        try:
            output = self._runner.run(inputs)
        except EngineError as error:
            raise VisionModelError(f"vision.model: {self._source} cannot be run: {error}") from error
        expected = (1, CHANNELS, padded.shape[0] // CELL_PIXELS, padded.shape[1] // CELL_PIXELS)
        if output.shape not in [(1, channels, *expected[2:]) for channels in _FORMS]:
            raise VisionModelError(
                f"vision.model: {self._source} answers with shape {output.shape} where {expected} is needed; "
                "docs/model-card.md describes inputs and outputs"
            )
        return np.asarray(output[0, :, : -(-rows // CELL_PIXELS), : -(-columns // CELL_PIXELS)])


def sun_input(cast: NDArray[np.floating[Any]]) -> NDArray[np.float32]:
    """Return the network's input (2,) for the shadow (2,) of one metre of height, metres along columns and rows.

    It points as the shadow does, 0 long for a sun overhead and up to 1 for one at the horizon.
    """
    size = float(np.hypot(*cast))
    return np.asarray(cast * (np.tanh(size / 2) / size if size > 0 else 0.0), np.float32)


def maps_from_output(output: MapArray) -> NetworkMaps:
    """Turn the network's raw output (10, 12 or 23, rows, columns) into probabilities, cells and metres."""
    lot, core, car, sine, cosine, column, row, width, length, taken = output[:CHANNELS]
    further, vehicles = output[CHANNELS : CHANNELS + FURTHER_CHANNELS], output[CHANNELS + FURTHER_CHANNELS :]
    shade, cover = _sigmoid(further) if len(further) else np.zeros((FURTHER_CHANNELS, *lot.shape), np.float32)
    return NetworkMaps(
        lot=_sigmoid(lot),
        car=_sigmoid(car),
        **_shape_maps((core, sine, cosine, column, row, width, length), (USUAL_WIDTH_M, USUAL_LENGTH_M), (1.0, 1.0)),
        taken=_sigmoid(taken),
        shade=shade,
        cover=cover,
        vehicles=_vehicle_maps(vehicles) if len(vehicles) else None,
    )


def _vehicle_maps(output: MapArray) -> VehicleMaps:
    output = output[:, ::VEHICLE_CELLS, ::VEHICLE_CELLS]
    shape = tuple(output[:SHAPE_CHANNELS])
    return VehicleMaps(
        **_shape_maps(shape, USUAL_VEHICLE_M, (1.0, 1.5), OFFSET_CELLS / VEHICLE_CELLS), kinds=output[SHAPE_CHANNELS:]
    )


def _shape_maps(
    shape: tuple[MapArray, ...],
    usual: tuple[float, float],
    most: tuple[float, float],
    offset: float = OFFSET_CELLS,
) -> dict[str, MapArray]:
    """Return core, direction, offset and size of stalls or vehicles by the names of their fields.

    ``usual``: units of width and length, metres; ``most``: logarithms by which they differ from these at most;
    ``offset``: unit of the offsets, cells.
    """
    core, sine, cosine, column, row, *sizes = shape
    width, length = (
        np.float32(unit) * np.exp(np.clip(size, -limit, limit))
        for unit, size, limit in zip(usual, sizes, most, strict=True)
    )
    return {
        "core": _sigmoid(core),
        "sine": sine,
        "cosine": cosine,
        "offset_column": column * np.float32(offset),
        "offset_row": row * np.float32(offset),
        "width": width,
        "length": length,
    }


def _named(engine: EngineChoice) -> str:
    return "the engine" if engine == "auto" else engine


def _short(error: EngineError) -> str:
    """Return an engine's reason without its name, numbers and codes before it."""
    line = (str(error).splitlines() or [""])[0]
    return line.rpartition(" : ")[2][:120].rstrip(". ")


def _parts(side: int) -> list[tuple[slice, tuple[int, int]]]:
    """Split a side of a picture into overlapping parts no larger than the network is used to.

    Returns each part's pixels, and the first and last cell that are taken from it: the middle of each overlap is the
    border, since at its own edge a part sees less.
    """
    whole = CELL_PIXELS * VEHICLE_CELLS
    count = max(1, -(-(side - _OVERLAP) // (_LARGEST - _OVERLAP)))
    length = side if count == 1 else -(-(side + (count - 1) * _OVERLAP) // count // _MULTIPLE) * _MULTIPLE
    starts = [-(-(side - length) * k // max(count - 1, 1) // whole) * whole for k in range(count)]
    ends = [*(start + length for start in starts[:-1]), side]
    borders = [(end + start) // 2 // CELL_PIXELS for end, start in zip(ends, starts[1:], strict=False)]
    cells = -(-side // CELL_PIXELS)
    taken = zip([0, *borders], [*borders, cells], strict=True)
    return [(slice(start, end), cell) for start, end, cell in zip(starts, ends, taken, strict=True)]


def _sigmoid(logits: MapArray) -> MapArray:
    found = np.clip(logits, -30, 30)
    for step in (np.negative, np.exp):
        step(found, out=found)
    found += 1
    return np.asarray(np.reciprocal(found, out=found), np.float32)
