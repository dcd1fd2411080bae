"""Results of windows as files."""

from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path

import pytest

from hawk.picture.orthophoto.source import Orthophoto
from hawk.picture.orthophoto.steps import map_task, tasks_of
from hawk.picture.orthophoto.tile_detector import TileDetector
from hawk.picture.orthophoto.tile_results import ResultError, Results
from hawk.picture.orthophoto.windows import Task
from hawk.picture.values import PictureError
from hawk.picture.work_folder import FAILURES, WINDOWS
from tests.unit.picture.city.fakes import SHA, break_bright, load_fake, looks, windows

Ready = tuple[Orthophoto, tuple[Task, ...], Results, TileDetector]


@pytest.fixture
def ready(tmp_path: Path) -> Ready:
    source, tasks = windows(tmp_path)
    results = Results(tmp_path / "out")
    results.prepare()
    return source, tasks, results, load_fake(tmp_path / "model", "opencv")


def only_file(results: Results, kind: str) -> Path:
    (path,) = (results.folder / kind).iterdir()
    return path


def test_a_result_is_kept_whole_and_not_looked_for_again(ready: Ready, tmp_path: Path) -> None:
    source, tasks, results, detector = ready
    assert results.find(tasks[0]) is None
    assert map_task(tasks[0], source, detector, results) == ""
    found = results.find(tasks[0])
    assert found is not None
    assert found.window == tasks[0].window
    assert len(found.corners) == 1
    assert only_file(results, WINDOWS).name == f"{tasks[0].name}.json"
    assert map_task(tasks[0], source, detector, results) == ""
    assert looks(tmp_path) == 1


def test_a_torn_result_is_looked_at_again(ready: Ready, tmp_path: Path) -> None:
    source, tasks, results, detector = ready
    map_task(tasks[0], source, detector, results)
    path = only_file(results, WINDOWS)
    whole = path.read_bytes()
    for end in (0, 1, 40, len(whole) // 2, len(whole) - 2, len(whole) - 1):
        path.write_bytes(whole[:end])
        assert results.find(tasks[0]) is None
    path.write_bytes(whole[: len(whole) // 2] + b"\0" * (len(whole) - len(whole) // 2))
    assert map_task(tasks[0], source, detector, results) == ""
    assert looks(tmp_path) == 2
    assert path.read_bytes() == whole


def test_a_result_of_another_task_or_window_is_not_taken(ready: Ready) -> None:
    source, tasks, results, detector = ready
    map_task(tasks[0], source, detector, results)
    path = only_file(results, WINDOWS)
    path.rename(path.with_name(f"{tasks[1].name}.json"))
    assert results.find(tasks[1]) is None
    moved = path.with_name(f"{tasks[1].name}.json")
    moved.write_bytes(moved.read_bytes().replace(tasks[0].name.encode(), tasks[1].name.encode()))
    assert results.find(tasks[1]) is None


def test_a_failure_stands_with_its_reason_until_the_window_is_looked_at(ready: Ready, tmp_path: Path) -> None:
    source, tasks, results, detector = ready
    break_bright(tmp_path)
    assert map_task(tasks[-1], source, detector, results) == "it is too bright"
    assert list(results.failures()) == [(tasks[-1].window.name(source.grid), "it is too bright")]
    assert results.find(tasks[-1]) is None
    break_bright(tmp_path, is_broken=False)
    assert map_task(tasks[-1], source, detector, results) == ""
    assert list(results.failures()) == []
    assert list((results.folder / FAILURES).iterdir()) == []


def test_a_result_is_named_by_picture_window_network_and_engine(ready: Ready) -> None:
    source, tasks, *_ = ready
    window = [tasks[0].window]
    other = replace(source, identity="[1]")
    names = {
        tasks[0].name,
        tasks[1].name,
        tasks_of(source, window, SHA, "onnxruntime")[0].name,
        tasks_of(source, window, "6" * 64, "opencv")[0].name,
        tasks_of(other, window, SHA, "opencv")[0].name,
    }
    assert len(names) == 5
    assert tasks_of(source, window, SHA, "opencv") == tasks[:1]


def test_a_folder_that_cannot_be_written_ends_the_run_with_its_name(ready: Ready, tmp_path: Path) -> None:
    source, tasks, results, detector = ready
    (results.folder / WINDOWS).rmdir()
    with pytest.raises(ResultError, match=r"out/windows/.*json: cannot be written .*--resume") as caught:
        map_task(tasks[0], source, detector, results)
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)  # noqa: S301 - our own
    (tmp_path / "file").touch()
    with pytest.raises(PictureError, match="file/windows: cannot be written"):
        Results(tmp_path / "file").prepare()
