"""Results of the steps of a survey by photographs or a film, kept as files: work that was cut off goes on.

A file is named by everything that makes its content: the picture's file (name, size, time of its change), the program,
the network, the pose. It begins with the SHA-256 of the rest, so that a torn one is computed again. Numbers are kept to
the last bit: a survey that went on is the one that was never cut off.
"""

from __future__ import annotations

import hashlib
import json
import struct
import zlib
from collections.abc import Callable, Sequence
from dataclasses import asdict, astuple, fields
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final, TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision.detection import Detection, Found, GroundImage
from hawk.model.pictures import CameraModel
from hawk.picture.reconstruction.alignment import Pair, PosePrior, Reconstruction
from hawk.picture.reconstruction.camera_pose import CameraPose
from hawk.picture.reconstruction.features import Features, Ties
from hawk.picture.reconstruction.headings import Couple, Middles
from hawk.picture.values import PictureError, Shot, cannot_write
from hawk.runtime.files import replace_whole

T = TypeVar("T")
_FORM: Final = 2
"""Number of the form of the files; another one is computed again."""
_DIGEST: Final = 32


class Checkpoints:
    """Files of one survey's steps. Without a folder every step is computed, and nothing is kept."""

    def __init__(self, folder: Path | None, network: str = "") -> None:
        """``network``: name of network and engine, by whose digits results differ."""
        self._folder = folder
        self._program = f"{_FORM} {version('hawk-drone')} {cv2.__version__}"
        self._network = network

    @property
    def keeps(self) -> bool:
        """True where results are kept."""
        return self._folder is not None

    def features(self, shot: Shot, make: Callable[[], Features]) -> Features:
        """Return the features of a shot's picture. Raises PictureError, as all steps, where they cannot be kept."""
        return self._result("features", [_identity(shot)], make, _features_bytes, _features_of)

    def ties(self, shots: Sequence[Shot], pairs: Sequence[Pair], make: Callable[[], list[Ties]]) -> list[Ties]:
        """Return the ties of pairs of shots."""
        makes = [[*_two(shots, pair), astuple(pair.search)] for pair in pairs]
        return self._result("ties", makes, make, _ties_bytes, _ties_of)

    def middles(self, shots: Sequence[Shot], couples: Sequence[Couple], make: Callable[[], Middles]) -> Middles:
        """Return where the middles of shots show in other ones, by which headings are judged."""
        makes = [_two(shots, couple) for couple in couples]
        return self._result("middles", makes, make, _middles_bytes, _middles_of)

    def adjusted(
        self, shots: Sequence[Shot], known: Sequence[PosePrior], make: Callable[[], Reconstruction]
    ) -> Reconstruction:
        """Return the poses of all shots; they follow from all pictures."""
        makes = [
            [_identity(shot), _pose(one.posed), one.place_m, one.height_m, one.tilt, one.heading, shot.lens_is_known]
            for shot, one in zip(shots, known, strict=True)
        ]
        return self._result("poses", makes, make, _adjusted_bytes, _adjusted_of)

    def found(self, shot: Shot, posed: CameraPose, make: Callable[[], Found]) -> Found:
        """Return the network's findings in a levelled shot."""
        return self._result("found", [_identity(shot), _pose(posed), self._network], make, _found_bytes, _found_of)

    def _result(
        self, kind: str, makes: list[Any], make: Callable[[], T], pack: Callable[[T], bytes], read: Callable[[bytes], T]
    ) -> T:
        if self._folder is None:
            return make()
        named = json.dumps([self._program, kind, makes]).encode()
        path = self._folder / f"{kind}-{hashlib.sha256(named).hexdigest()[:40]}"
        data = _whole(path)
        if data is not None:
            return read(data)
        result = make()
        packed = pack(result)
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            replace_whole(path, hashlib.sha256(packed).digest() + packed)
        except OSError as error:
            raise PictureError(cannot_write(path, error)) from error
        return result


def _whole(path: Path) -> bytes | None:
    """Return the content of a file; None when it is not there, or not as it was written."""
    try:
        data = path.read_bytes()
    except OSError:
        return None
    return data[_DIGEST:] if hashlib.sha256(data[_DIGEST:]).digest() == data[:_DIGEST] else None


def _identity(shot: Shot) -> list[Any]:
    """Return the facts by which a picture is known: another file differs in one of them."""
    try:
        facts = shot.path.stat()
    except OSError:  # reading it says why
        return [shot.name]
    return [shot.name, facts.st_size, facts.st_mtime_ns]


def _two(shots: Sequence[Shot], two: Pair | Couple) -> list[Any]:
    """Return the facts by which two photographs and their poses are known."""
    return [*two.numbers, *(_identity(shots[number]) for number in two.numbers), _pose(two.first), _pose(two.second)]


def _pose(posed: CameraPose) -> list[Any]:
    return [astuple(posed.camera), *_values(posed)]


def _values(posed: CameraPose) -> list[Any]:
    """Return the values of a pose without its camera."""
    return [getattr(posed, name) for name in _OF_POSE]


_OF_POSE: Final = tuple(each.name for each in fields(CameraPose) if each.name != "camera")


def _features_bytes(features: Features) -> bytes:
    return struct.pack("<I", len(features.pixels)) + features.pixels.tobytes() + features.descriptors.tobytes()


def _features_of(data: bytes) -> Features:
    (count,) = struct.unpack_from("<I", data)
    pixels = np.frombuffer(data, np.float64, 2 * count, 4).reshape(-1, 2)
    return Features(pixels, np.frombuffer(data, np.uint8, 128 * count, 4 + 16 * count).reshape(-1, 128))


def _ties_bytes(ties: list[Ties]) -> bytes:
    parts = [struct.pack("<3Q", tie.first, tie.second, len(tie.here)) for tie in ties]
    numbers = (np.concatenate([tie.here, tie.there]).astype("<i8").tobytes() for tie in ties)
    return b"".join(part for both in zip(parts, numbers, strict=True) for part in both)


def _ties_of(data: bytes) -> list[Ties]:
    ties, at = [], 0
    while at < len(data):
        first, second, count = struct.unpack_from("<3Q", data, at)
        here, there = np.frombuffer(data, "<i8", 2 * count, at + 24).astype(np.intp).reshape(2, count)
        ties.append(Ties(first, second, here, there))
        at += 24 + 16 * count
    return ties


def _middles_bytes(middles: Middles) -> bytes:
    """Pack each as two numbers, none as NaN."""
    return np.array([complex(np.nan, np.nan) if one is None else one for one in middles], "<c16").tobytes()


def _middles_of(data: bytes) -> Middles:
    return [None if np.isnan(one) else one for one in np.frombuffer(data, "<c16").tolist()]


def _adjusted_bytes(adjusted: Reconstruction) -> bytes:
    cameras = list(dict.fromkeys(one.camera for one in adjusted.posed))
    number = {camera: k for k, camera in enumerate(cameras)}
    values = {
        "cameras": [asdict(camera) for camera in cameras],
        "posed": [[number[one.camera], *_values(one)] for one in adjusted.posed],
        "is_adjusted": adjusted.is_adjusted.tolist(),
        "residual": adjusted.residual,
        "ties": adjusted.ties,
        "turned": sorted(adjusted.turned),
    }
    return json.dumps(values).encode()


def _adjusted_of(data: bytes) -> Reconstruction:
    values = json.loads(data)
    cameras = [CameraModel(**{**each, "distortion": tuple(each["distortion"])}) for each in values["cameras"]]
    posed = tuple(CameraPose(cameras[k], *_with_tuples(rest)) for k, *rest in values["posed"])
    is_adjusted = np.array(values["is_adjusted"], np.bool_)
    return Reconstruction(posed, is_adjusted, values["residual"], values["ties"], frozenset(values["turned"]))


def _with_tuples(values: list[Any]) -> list[Any]:
    return [tuple(value) if isinstance(value, list) else value for value in values]


_LAYERS: Final = ("lot", "car", "core", "taken")


def _found_bytes(found: Found) -> bytes:
    """Pack the layers by the bytes of their numbers: those of equal weight lie together, and are alike."""
    stalls = np.array([astuple(stall) for stall in found.stalls], np.float64).reshape(-1, 8)
    layers = [np.ascontiguousarray(getattr(found, name).values, np.float32) for name in _LAYERS]
    split = b"".join(layer.view(np.uint8).reshape(-1, 4).T.tobytes() for layer in layers)
    rows, columns = found.core.valid.shape
    head = struct.pack("<3I", rows, columns, len(stalls))
    rest = found.core.to_map.tobytes() + stalls.tobytes() + np.packbits(found.core.valid).tobytes() + split
    return head + zlib.compress(rest, 1)


def _found_of(data: bytes) -> Found:
    rows, columns, count = struct.unpack_from("<3I", data)
    rest = zlib.decompress(data[12:])
    cells, at = rows * columns, 48 + 64 * count
    to_map = np.frombuffer(rest, np.float64, 6).reshape(2, 3)
    stalls = np.frombuffer(rest, np.float64, 8 * count, 48).reshape(-1, 8)
    packed = -(-cells // 8)
    bits = np.unpackbits(np.frombuffer(rest, np.uint8, packed, at), count=cells)
    valid = bits.reshape(rows, columns).astype(np.bool_)
    layers = [_layer(rest, at + packed + 4 * cells * k, (rows, columns)) for k in range(len(_LAYERS))]
    images = [GroundImage(layer, to_map, valid) for layer in layers]
    return Found(tuple(Detection(*row) for row in stalls.tolist()), *images)


def _layer(data: bytes, begin: int, shape: tuple[int, int]) -> NDArray[np.float32]:
    split = np.frombuffer(data, np.uint8, 4 * shape[0] * shape[1], begin).reshape(4, -1)
    return np.ascontiguousarray(split.T).view(np.float32).reshape(shape)
