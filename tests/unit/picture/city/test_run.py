"""A city mapped, cut off, and mapped on."""

from __future__ import annotations

import sys
from collections.abc import Generator, Sequence
from pathlib import Path

import numpy as np
import pytest
import shapely

from hawk.picture.city.run import CityRun, CityWork, map_city, map_orthophoto
from hawk.picture.orthophoto.outline import LotOutline
from hawk.picture.orthophoto.source import Orthophoto, open_orthophoto
from hawk.picture.orthophoto.steps import map_task
from hawk.picture.orthophoto.tile_detector import TileDetector
from hawk.picture.orthophoto.tile_results import Results
from hawk.picture.orthophoto.windows import Task
from hawk.picture.values import PictureError, PictureSurvey
from hawk.picture.work_folder import WINDOWS as FOLDER
from tests.unit.picture.city import fakes
from tests.unit.picture.city.fakes import CORE_M, WINDOWS, break_bright, load_fake, looks
from tests.unit.picture.orthophoto.drawn import detector, lot_file


def mapped(folder: Path, name: str = "out", steps: list[tuple[int, int]] | None = None) -> CityRun:
    path = folder / "city.tif" if (folder / "city.tif").exists() else fakes.city(folder)
    report: list[tuple[int, int]] = [] if steps is None else steps
    work = CityWork(path, out=folder / name, model=folder / "model", core_m=CORE_M, load=load_fake)
    return map_city(work, lambda *step: report.append(step))


def same(one: PictureSurvey, other: PictureSurvey) -> bool:
    return (one.survey, one.area_m2, one.left_out) == (
        other.survey, other.area_m2, other.left_out,
    )  # fmt: skip


@pytest.mark.nightly
def test_results_that_are_there_are_not_computed_again(tmp_path: Path) -> None:
    steps: list[tuple[int, int]] = []
    first = mapped(tmp_path, steps=steps)
    assert (first.windows, first.reused, looks(tmp_path)) == (WINDOWS, 0, WINDOWS)
    assert len(first.mapped.survey.stalls) > 4
    assert steps == [(done, WINDOWS) for done in range(WINDOWS + 1)]
    files = sorted((tmp_path / "out" / FOLDER).iterdir())
    before = {path.name: path.read_bytes() for path in files}
    files[3].unlink()
    files[5].write_bytes(before[files[5].name][:-9])
    again = mapped(tmp_path)
    assert (again.reused, looks(tmp_path)) == (WINDOWS - 2, WINDOWS + 2)
    assert same(again.mapped, first.mapped)
    assert {path.name: path.read_bytes() for path in files} == before
    assert mapped(tmp_path).reused == WINDOWS
    assert looks(tmp_path) == WINDOWS + 2


@pytest.mark.slow
def test_a_run_that_was_cut_off_goes_on(tmp_path: Path) -> None:
    def stop(done: int, _: int) -> None:
        if done == 5:
            raise KeyboardInterrupt

    path = fakes.city(tmp_path)
    work = CityWork(path, out=tmp_path / "out", model=tmp_path / "model", core_m=CORE_M, load=load_fake)
    with pytest.raises(KeyboardInterrupt):
        map_city(work, stop)
    assert mapped(tmp_path).reused == 5
    assert looks(tmp_path) == WINDOWS
    assert [each.name for each in (tmp_path / "out").iterdir() if each.name.startswith(".")] == []


@pytest.mark.nightly
def test_failed_windows_are_named_and_tried_again(tmp_path: Path) -> None:
    whole = mapped(tmp_path, "whole").mapped
    before = looks(tmp_path)
    break_bright(tmp_path)
    steps: list[tuple[int, int]] = []
    part = mapped(tmp_path, steps=steps)
    failed = len(part.mapped.left_out)
    assert 0 < failed < WINDOWS
    assert {each.reason for each in part.mapped.left_out} == {"it is too bright"}
    assert steps[-1] == (WINDOWS, WINDOWS)
    assert len(list(Results(tmp_path / "out").failures())) == failed
    break_bright(tmp_path, is_broken=False)
    again = mapped(tmp_path)
    assert again.reused == WINDOWS - failed
    assert same(again.mapped, whole)
    assert looks(tmp_path) == before + WINDOWS + failed


@pytest.mark.slow
def test_what_a_worker_could_not_write_stands_among_the_failures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def dead(
        tasks: Sequence[Task], source: Orthophoto, sees: TileDetector, store: Results
    ) -> Generator[tuple[Task, str]]:
        yield from [(task, map_task(task, source, sees, store)) for task in tasks[1:]]
        yield tasks[0], "3 workers died at it"

    monkeypatch.setattr("hawk.picture.city.run.map_tasks", dead)
    part = mapped(tmp_path).mapped
    (left,) = part.left_out
    assert left.reason == "3 workers died at it"
    assert list(Results(tmp_path / "out").failures()) == [(left.name, left.reason)]


@pytest.mark.slow
def test_a_city_of_which_no_window_can_be_looked_at_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise PictureError("it is too bright")

    monkeypatch.setattr(fakes.FakeDetector, "detect", refuse)
    with pytest.raises(PictureError, match="it is too bright"):
        mapped(tmp_path)


@pytest.mark.nightly
def test_the_order_of_the_windows_changes_nothing(tmp_path: Path) -> None:
    usual = mapped(tmp_path)
    source, tasks = fakes.windows(tmp_path)
    results = Results(tmp_path / "other")
    results.prepare()
    for task in tasks[::-2] + tasks[::2]:
        map_task(task, source, load_fake(tmp_path / "model", "opencv"), results)
    other = mapped(tmp_path, "other")
    assert other.reused >= WINDOWS // 2
    assert same(other.mapped, usual.mapped)
    both = [sorted((tmp_path / name / FOLDER).iterdir()) for name in ("out", "other")]
    assert [path.read_bytes() for path in both[0]] == [path.read_bytes() for path in both[1]]


@pytest.mark.slow
def test_outlines_limit_the_windows_and_the_stalls(tmp_path: Path) -> None:
    path = fakes.city(tmp_path)
    grid = open_orthophoto(path).grid
    corner = np.array([(0, 0), (150, 0), (150, 150), (0, 150)], np.float64)
    lots = LotOutline.of(shapely.Polygon(grid.on_earth(corner)[:, ::-1]))
    work = CityWork(path, out=tmp_path / "out", outline=lots, model=tmp_path / "model", core_m=CORE_M, load=load_fake)
    run = map_city(work)
    assert run.windows == 4
    assert run.mapped.area_m2 == pytest.approx(225, rel=0.01)
    whole = mapped(tmp_path).mapped
    assert len(run.mapped.survey.stalls) < len(whole.survey.stalls)


@pytest.mark.nightly
def test_a_city_of_one_window_is_the_orthophoto_itself(tmp_path: Path) -> None:
    path = lot_file(tmp_path)
    run = map_city(CityWork(path, out=tmp_path / "out", load=lambda model, engine: detector()))
    assert same(run.mapped, map_orthophoto(path))
    assert len(run.mapped.survey.stalls) > 30


def test_bad_numbers_of_workers_and_a_missing_extra_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, out = fakes.city(tmp_path), tmp_path / "out"
    with pytest.raises(PictureError, match="--workers: 0 is no number"):
        map_city(CityWork(path, out=out, workers=0))
    monkeypatch.setitem(sys.modules, "hawk.picture.city.cluster", None)
    with pytest.raises(PictureError, match=r"distributed is not installed.*\[cluster\]"):
        map_city(CityWork(path, out=out, workers=2, model=tmp_path / "model", core_m=CORE_M, load=load_fake))
