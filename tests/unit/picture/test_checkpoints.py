from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Generic, TypeVar

import numpy as np
import pytest

from hawk.algo.vision.detection import Detection, Found, GroundImage
from hawk.model.pictures import CameraModel
from hawk.picture.checkpoints import Checkpoints
from hawk.picture.reconstruction.alignment import Pair, PosePrior, Reconstruction
from hawk.picture.reconstruction.camera_pose import CameraPose
from hawk.picture.reconstruction.features import Features, Search, Ties
from hawk.picture.reconstruction.headings import Couple
from hawk.picture.values import PictureError, Shot

T = TypeVar("T")
CAMERA = CameraModel(480, 360, 360.123456789012345, 360.0, 239.5, 179.5, (0.1, -0.02, 0.0, 0.0, 1e-9))
POSED = CameraPose(CAMERA, 1 / 3, -2.0, 60.1, (0.1, 0.2, 1e-17), (0.0, 0.1, 0.2), (3.0, 4.0), 1e-5, 0.25)
RNG = np.random.default_rng(1)
FEATURES = Features(RNG.random((5, 2)) * 480, RNG.integers(0, 256, (5, 128)).astype(np.uint8))


def shot(folder: Path, content: bytes = b"picture") -> Shot:
    path = folder / "a.jpg"
    path.write_bytes(content)
    return Shot(path, CAMERA, 52.0, 5.0, None, 60.0, None, (2.0, 3.0), None)


def found(count: int = 2) -> Found:
    to_map, valid = np.array([[0.0, -0.2, 9.0], [0.2, 0.0, 1 / 3]]), RNG.random((7, 9)) > 0.3
    layers = [GroundImage(RNG.random((7, 9)).astype(np.float32), to_map, valid) for _ in range(4)]
    return Found(tuple(Detection(*row) for row in RNG.random((count, 8)).tolist()), *layers)


class Counted(Generic[T]):
    """Makes a result, and counts how often."""

    def __init__(self, result: T) -> None:
        self.result = result
        self.times = 0

    def __call__(self) -> T:
        self.times += 1
        return self.result


def same_found(one: Found, other: Found) -> bool:
    pairs = [(getattr(one, name), getattr(other, name)) for name in ("lot", "car", "core", "taken")]
    same = [
        a.values.dtype == b.values.dtype
        and all(np.array_equal(getattr(a, name), getattr(b, name)) for name in ("values", "to_map", "valid"))
        for a, b in pairs
    ]
    return one.stalls == other.stalls and all(same)


def test_features_are_computed_once_and_read_to_the_last_bit(tmp_path: Path) -> None:
    one, make = shot(tmp_path), Counted(FEATURES)
    for _ in range(2):
        read = Checkpoints(tmp_path / "work").features(one, make)
        assert np.array_equal(read.pixels, FEATURES.pixels)
        assert np.array_equal(read.descriptors, FEATURES.descriptors)
    assert make.times == 1


@pytest.mark.parametrize("count", [0, 2])
def test_findings_are_computed_once_and_read_to_the_last_bit(tmp_path: Path, count: int) -> None:
    one, made = shot(tmp_path), found(count)
    make = Counted(made)
    work = Checkpoints(tmp_path / "work", "abc ort")
    assert [same_found(work.found(one, POSED, make), made) for _ in range(2)] == [True, True]
    assert make.times == 1


def test_poses_are_computed_once_and_read_to_the_last_bit(tmp_path: Path) -> None:
    other = dataclasses.replace(POSED, camera=dataclasses.replace(CAMERA, fx=300.5), level=0.0)
    adjusted = Reconstruction((POSED, other), np.array([True, False]), 0.1 + 0.2, 77, frozenset({1}))
    known = [PosePrior(posed, 2.0, 1.0, 0.02, 0.1) for posed in adjusted.posed]
    shots, make = [shot(tmp_path)] * 2, Counted(adjusted)
    for _ in range(2):
        read = Checkpoints(tmp_path / "work").adjusted(shots, known, make)
        assert read.posed == adjusted.posed
        assert read.is_adjusted.tolist() == [True, False]
        assert (read.residual, read.ties, read.turned) == (0.1 + 0.2, 77, frozenset({1}))
    assert make.times == 1
    Checkpoints(tmp_path / "work").adjusted(shots, known[::-1], make)
    assert make.times == 2


def test_ties_are_computed_once_and_read_to_the_last_bit(tmp_path: Path) -> None:
    made = [Ties(0, 1, np.array([3, 1, 2]), np.array([5, 4, 9])), Ties(0, 2, np.array([7]), np.array([1]))]
    pairs = [Pair((0, second), POSED, POSED, Search(4.0, 0.9, 0.3)) for second in (1, 2)]
    shots, make, work = [shot(tmp_path)] * 3, Counted(made), Checkpoints(tmp_path / "work")
    for _ in range(2):
        read = work.ties(shots, pairs, make)
        assert [(tie.first, tie.second, tie.here.tolist(), tie.there.tolist()) for tie in read] == [
            (0, 1, [3, 1, 2], [5, 4, 9]), (0, 2, [7], [1]),
        ]  # fmt: skip
    assert make.times == 1
    work.ties(shots, [dataclasses.replace(pairs[0], search=Search(5.0, 0.9, 0.3)), pairs[1]], make)
    work.ties(shots, [dataclasses.replace(pairs[0], second=dataclasses.replace(POSED, level=0.2)), pairs[1]], make)
    work.ties(shots, pairs[:1], make)
    assert make.times == 4


def test_middles_are_computed_once_and_read_to_the_last_bit(tmp_path: Path) -> None:
    made = [complex(0.1 + 0.2, -1e-17), None, complex(1 / 3, 2.0)]
    couples = [Couple((other, 3), POSED, POSED) for other in (1, 0, 2)]
    shots, make, work = [shot(tmp_path)] * 4, Counted(made), Checkpoints(tmp_path / "work")
    assert [work.middles(shots, couples, make) for _ in range(2)] == [made, made]
    assert make.times == 1
    work.middles(shots, couples[:2], make)
    work.middles(shots, [dataclasses.replace(couples[0], numbers=(2, 3)), *couples[1:]], make)
    work.middles(shots, [dataclasses.replace(couples[0], second=dataclasses.replace(POSED, level=0.2))], make)
    work.middles([shot(tmp_path, b"another picture")] * 4, couples, make)
    assert make.times == 5


def test_that_no_photographs_are_tied_is_kept_too(tmp_path: Path) -> None:
    pairs = [Pair((0, 1), POSED, POSED, Search(4.0, 0.9, 0.3))]
    make: Counted[list[Ties]] = Counted([])
    shots, work = [shot(tmp_path)] * 2, Checkpoints(tmp_path / "work")
    assert [work.ties(shots, pairs, make) for _ in range(2)] == [[], []]
    assert make.times == 1


@pytest.mark.parametrize("keep", [slice(0, 0), slice(0, 20), slice(0, -1), slice(1, None)])
def test_a_torn_file_is_computed_again(tmp_path: Path, keep: slice) -> None:
    one, make, work = shot(tmp_path), Counted(FEATURES), Checkpoints(tmp_path / "work")
    work.features(one, make)
    (path,) = (tmp_path / "work").iterdir()
    whole = path.read_bytes()
    path.write_bytes(whole[keep])
    assert np.array_equal(work.features(one, make).pixels, FEATURES.pixels)
    assert (make.times, path.read_bytes()) == (2, whole)


def test_another_picture_pose_or_network_is_another_result(tmp_path: Path) -> None:
    one, make, work = shot(tmp_path), Counted(found()), Checkpoints(tmp_path / "work", "abc ort")
    work.found(one, POSED, make)
    work.found(one, dataclasses.replace(POSED, level=0.26), make)
    work.found(one, dataclasses.replace(POSED, camera=dataclasses.replace(CAMERA, cx=240.0)), make)
    Checkpoints(tmp_path / "work", "abd ort").found(one, POSED, make)
    work.found(dataclasses.replace(one, frame=3), POSED, make)
    work.found(shot(tmp_path, b"another picture"), POSED, make)
    assert make.times == 6


def test_without_a_folder_nothing_is_kept(tmp_path: Path) -> None:
    one, make, work = shot(tmp_path), Counted(FEATURES), Checkpoints(None)
    assert [work.features(one, make) for _ in range(2)] == [FEATURES, FEATURES]
    assert (make.times, work.keeps, [each.name for each in tmp_path.iterdir()]) == (2, False, ["a.jpg"])


def test_a_folder_that_cannot_be_written_is_named_with_the_remedy(tmp_path: Path) -> None:
    (tmp_path / "work").write_text("a file")
    with pytest.raises(PictureError, match=r"work.*cannot be written.*--resume"):
        Checkpoints(tmp_path / "work").features(shot(tmp_path), Counted(FEATURES))
