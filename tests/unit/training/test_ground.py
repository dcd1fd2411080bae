from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.unit.training.test_agreement import BRIGHT, BrightStalls, picture
from training.ground import Ground, GroundError, cut, read_ground, read_region
from training.targets import UNKNOWN

LEFTS = (60, 120, 180)


def write(folder: Path, name: str = "region", labelled: int | None = 2, scale: float = 0.1) -> Path:
    """Write a picture of three stalls and labels of the first of them; None: without a file of labels."""
    path = folder / f"{name}.jpg"
    cv2.imwrite(str(path), picture(), [cv2.IMWRITE_JPEG_QUALITY, 100])
    if labelled is not None:
        corners = [[(x, 70), (x + 26, 70), (x + 26, 122), (x, 122)] for x in LEFTS[:labelled]]
        stalls = [{"corners_m": (np.array(c) * scale).tolist(), "state": "unclear"} for c in corners]
        text = {"metres_per_pixel": scale, "stalls": stalls, "lots_m": []}
        path.with_suffix(".json").write_text(json.dumps(text))
    return path


def read(path: Path) -> object:
    return read_region(path, BrightStalls(), np.random.default_rng(0))  # type: ignore[arg-type]


def test_labels_say_where_stalls_are_and_the_network_what_stands_on_them(tmp_path: Path) -> None:
    scene = read(write(tmp_path)).scene  # type: ignore[attr-defined]
    assert scene.quads.shape == (2, 4, 2)
    np.testing.assert_allclose(scene.quads[0][0], (59.5, 69.5), atol=0.1)
    assert scene.taken.tolist() == [True, False]
    assert not scene.unclear.any()
    assert scene.judged.all()
    assert scene.seen is None, "everything of the picture is judged: what is not labelled is no stall"
    assert set(np.unique(scene.labels[..., 2:])) == {UNKNOWN}, "nothing is known of shade and cover"
    assert scene.cast is None


@pytest.mark.slow
def test_a_picture_of_another_scale_is_brought_to_a_tenth_of_a_metre(tmp_path: Path) -> None:
    scene = read(write(tmp_path, scale=0.2)).scene  # type: ignore[attr-defined]
    assert scene.image.shape[:2] == (401, 521)
    np.testing.assert_allclose(np.ptp(scene.quads[0], axis=0), (52, 104), atol=0.1)


@pytest.mark.slow
def test_without_labels_the_stalls_are_those_that_the_views_agree_on(tmp_path: Path) -> None:
    scene = read(write(tmp_path, labelled=None)).scene  # type: ignore[attr-defined]
    assert len(scene.quads) == 3
    assert scene.judged.all()
    assert sorted(scene.taken.tolist()) == [False, False, True]
    assert scene.seen[96, 73] == 1
    assert scene.seen[10, 10] == 1


@pytest.mark.slow
def test_missing_ground_is_not_judged(tmp_path: Path) -> None:
    path = write(tmp_path)
    image = picture()
    image[:, 108:176] = 128
    cv2.imwrite(str(path), image, [cv2.IMWRITE_JPEG_QUALITY, 100])
    scene = read(path).scene  # type: ignore[attr-defined]
    assert scene.judged.tolist() == [True, False]
    assert scene.seen[50, 140] == 0
    assert scene.seen[50, 30] == 1
    assert (scene.labels[50, 140] == UNKNOWN).all()


@pytest.mark.slow
def test_a_label_at_the_picture_s_edge_is_not_judged(tmp_path: Path) -> None:
    path = write(tmp_path)
    labels = json.loads(path.with_suffix(".json").read_text())
    labels["stalls"][0]["corners_m"] = [[0, 7], [2.6, 7], [2.6, 12.2], [0, 12.2]]
    path.with_suffix(".json").write_text(json.dumps(labels))
    assert read(path).scene.judged.tolist() == [False, True]  # type: ignore[attr-defined]


@pytest.mark.slow
def test_windows_hold_the_stalls_that_touch_them_in_their_own_pixels(tmp_path: Path) -> None:
    scene = read(write(tmp_path)).scene  # type: ignore[attr-defined]
    part = cut(scene, 110, 60, 80)
    assert part.image.shape == (80, 80, 3)
    np.testing.assert_array_equal(part.image, scene.image[60:140, 110:190])
    assert len(part.quads) == 1
    np.testing.assert_allclose(part.quads[0][0], (9.5, 9.5), atol=0.1)
    assert part.taken.tolist() == [False]


@pytest.mark.slow
def test_regions_are_left_out_by_name_and_drawn_from_by_their_stalls(tmp_path: Path) -> None:
    for name in ("one", "two", "three"):
        write(tmp_path, name)
    ground = read_ground(tmp_path, BrightStalls(), ["t*"])  # type: ignore[arg-type]
    assert [region.name for region in ground.regions] == ["one"]
    window = ground.window(np.random.default_rng(0))
    assert window.image.max() > BRIGHT / 2
    assert len(window.quads) == 2
    with pytest.raises(GroundError, match="no picture is left"):
        read_ground(tmp_path, BrightStalls(), ["*"])  # type: ignore[arg-type]
    with pytest.raises(GroundError, match="no picture is left"):
        Ground([])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{", "not labels"),
        ('{"stalls": []}', "metres_per_pixel"),
        ('{"metres_per_pixel": 0, "stalls": []}', "above 0"),
        ('{"metres_per_pixel": 0.1, "stalls": [{"corners_m": [[1, 2]]}]}', "not labels"),
    ],
)
def test_labels_that_cannot_be_read_name_their_file(tmp_path: Path, text: str, words: str) -> None:
    path = write(tmp_path)
    path.with_suffix(".json").write_text(text)
    with pytest.raises(GroundError, match=words) as caught:
        read(path)
    assert "region.json" in str(caught.value)


def test_a_picture_that_cannot_be_read_names_its_file(tmp_path: Path) -> None:
    (tmp_path / "bad.jpg").write_bytes(b"no picture")
    with pytest.raises(GroundError, match=r"bad\.jpg"):
        read(tmp_path / "bad.jpg")
