"""The steps of mapping: the store in which results are kept changes nothing of the survey."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from hawk.picture.orthophoto.source import Orthophoto
from hawk.picture.orthophoto.steps import MappingPlan, map_tasks, merge_results, start
from hawk.picture.orthophoto.tile_detector import TileDetector
from hawk.picture.orthophoto.tile_results import Results
from hawk.picture.orthophoto.windows import Window, WindowStalls, map_window
from hawk.picture.values import PictureError
from hawk.picture.work_folder import WINDOWS as FOLDER
from tests.unit.picture.city.fakes import CORE_M, WINDOWS, city, load_fake, looks
from tests.unit.picture.orthophoto.drawn import write


def started(folder: Path, path: Path) -> MappingPlan:
    return start(path, outline=None, crs=None, load=lambda: load_fake(folder / "model", "opencv"), core_m=CORE_M)


def on_disk(folder: Path) -> Results:
    results = Results(folder / "out")
    results.prepare()
    return results


def fill(picture: MappingPlan, store: Results) -> dict[str, str]:
    return {
        task.name: reason for task, reason in map_tasks(picture.missing(store), picture.source, picture.detector, store)
    }


@pytest.mark.slow
def test_results_of_one_run_are_those_of_the_next(tmp_path: Path) -> None:
    picture, disk = started(tmp_path, city(tmp_path)), on_disk(tmp_path)
    assert fill(picture, disk) == dict.fromkeys((task.name for task in picture.tasks), "")
    one, other = (merge_results(picture, disk, {}) for _ in range(2))
    assert len(one.survey.stalls) > 4
    assert (one.survey, one.area_m2, one.notes) == (other.survey, other.area_m2, other.notes)
    assert (fill(picture, disk), looks(tmp_path)) == ({}, WINDOWS)


@pytest.mark.slow
def test_a_result_that_is_gone_when_all_are_merged_is_named(tmp_path: Path) -> None:
    picture, disk = started(tmp_path, city(tmp_path)), on_disk(tmp_path)
    fill(picture, disk)
    (tmp_path / "out" / FOLDER / f"{picture.tasks[3].name}.json").unlink()
    mapped = merge_results(picture, disk, {})
    name = picture.tasks[3].window.name(picture.source.grid)
    assert [(each.name, each.reason) for each in mapped.left_out] == [(name, "its result is gone; go on by --resume")]
    with pytest.raises(PictureError, match="it is gone"):
        merge_results(
            picture, Results(tmp_path / "none"), dict.fromkeys((task.name for task in picture.tasks), "it is gone")
        )


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ('{"type":"Point","coordinates":[1,2]}', "holds no area"),
        (
            '{"type":"Polygon","coordinates":[[[1,2],[1.1,2],[1,2.1],[1,2]]]}',
            "none of the outlines lies in the picture",
        ),
    ],
)
def test_an_outline_that_does_not_fit_is_named_with_its_option(tmp_path: Path, content: str, words: str) -> None:
    outline = tmp_path / "far.geojson"
    outline.write_text(content)
    with pytest.raises(PictureError, match=rf"^--outline: .*far\.geojson: {words}"):
        start(city(tmp_path), outline=outline, crs=None, load=lambda: load_fake(tmp_path / "model", "opencv"))


@pytest.mark.nightly
@pytest.mark.parametrize("error", [MemoryError(), cv2.error("Insufficient memory")])
def test_a_window_that_the_memory_does_not_hold_is_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: Exception
) -> None:
    picture, disk = started(tmp_path, city(tmp_path)), on_disk(tmp_path)

    def short(source: Orthophoto, window: Window, detector: TileDetector) -> WindowStalls:
        if window == picture.tasks[1].window:
            raise error
        return map_window(source, window, detector)

    monkeypatch.setattr("hawk.picture.orthophoto.steps.map_window", short)
    failures = fill(picture, disk)
    reasons = [failures[task.name] for task in picture.tasks]
    assert "memory" in reasons[1]
    assert not any(reasons[:1] + reasons[2:])
    mapped = merge_results(picture, disk, failures)
    assert [each.reason for each in mapped.left_out] == [reasons[1]]
    assert any(reasons[1] in path.read_text() for path in (tmp_path / "out" / "failures").iterdir())


def test_a_picture_without_ground_leaves_no_result(tmp_path: Path) -> None:
    picture = started(tmp_path, write(tmp_path / "black.tif", np.zeros((3, 300, 300), np.uint8)))
    store = on_disk(tmp_path)
    fill(picture, store)
    assert picture.missing(store) == ()
    with pytest.raises(PictureError, match="shows no ground"):
        merge_results(picture, store, {})
    assert picture.missing(store) == picture.tasks


def test_the_reason_of_a_window_without_memory_has_the_remedy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def short(*_: object) -> None:
        raise cv2.error("(-4:Insufficient memory)\n> Failed to allocate 9 bytes\n")

    monkeypatch.setattr("hawk.picture.orthophoto.steps.map_window", short)
    reasons = set(fill(started(tmp_path, city(tmp_path)), on_disk(tmp_path)).values())
    assert reasons == {
        "memory may be short (error (-4:Insufficient memory) > Failed to allocate 9 bytes); close other programs, or "
        "start fewer --workers"
    }
