"""Windows for checking by eye: drawn by a seed, filled in by a person, and the totals by them; wrong tables refused."""

from __future__ import annotations

import csv
import json
import shutil
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from hawk.cli import main
from hawk.picture.city.check_files import read_check, strata_of, write_check
from hawk.picture.values import PictureError, SampleWindow
from tests.unit.picture.orthophoto.drawn import lot_file


class DrawnSample:
    """A city of 200 windows with drawn counts."""

    identity = "drawn"

    def __init__(self) -> None:
        rng = np.random.default_rng(3)
        self.made = tuple(
            SampleWindow(
                n, f"0/{n}", {"free": int(free), "taken": int(free) // 2}, round(0.01 * n, 2) if free else 0.0,
                ((52.0, 5.0), (52.0, 5.1), (52.1, 5.1), (52.1, 5.0)),
            )
            for n, free in enumerate(rng.integers(0, 9, 200), 1)
        )  # fmt: skip

    def windows(self) -> tuple[SampleWindow, ...]:
        return self.made

    def picture(self, window: SampleWindow) -> np.ndarray[Any, np.dtype[np.uint8]]:
        return np.full((4, 8, 3), window.number % 256, np.uint8)


SAMPLE = DrawnSample()


def rows_of(table: Path) -> list[dict[str, str]]:
    with table.open(newline="") as file:
        return list(csv.DictReader(file))


def fill(table: Path, **by_eye: Any) -> None:
    """Fill in counts: a function of the program's, by column."""
    rows = rows_of(table)
    for row in rows:
        for name, how in by_eye.items():
            row[f"{name}_by_eye"] = str(how(int(row[name])))
    with table.open("w", newline="") as file:
        out = csv.DictWriter(file, [*rows[0]])
        out.writeheader()
        out.writerows(rows)


def test_the_same_seed_draws_the_same_windows_and_another_one_others(tmp_path: Path) -> None:
    drawn = [
        [row["window"] for row in rows_of(write_check(SAMPLE, tmp_path / name, 40, seed) / "windows.csv")]
        for name, seed in (("a", 1), ("b", 1), ("c", 2))
    ]
    assert drawn[0] == drawn[1] != drawn[2]
    assert len(drawn[0]) == len(set(drawn[0])) == 40
    folder = tmp_path / "a" / "check"
    assert len(list(folder.glob("*.png"))) == 40
    features = json.loads((folder / "windows.geojson").read_text())["features"]
    assert [each["id"] for each in features] == drawn[0]
    assert features[0]["geometry"]["coordinates"][0][0] == [5.0, 52.0]


def test_windows_without_a_find_are_a_stratum_and_doubt_orders_the_others() -> None:
    empty, *others = strata_of(SAMPLE.windows())
    assert all(not any(each.counts.values()) for each in empty)
    assert sum(map(len, (empty, *others))) == 200
    doubts = [each.doubt for part in others for each in part]
    assert doubts == sorted(doubts)


def test_what_a_person_counts_corrects_the_totals(tmp_path: Path) -> None:
    table = write_check(SAMPLE, tmp_path, 60, 1) / "windows.csv"
    fill(table, free=lambda count: count + (count > 4), taken=lambda count: count)
    found = read_check(SAMPLE, table)
    free = sum(each.counts["free"] for each in SAMPLE.made)
    truth = free + sum(each.counts["free"] > 4 for each in SAMPLE.made)
    assert (found.checked, found.windows) == (60, 200)
    assert found.totals["free"].least <= truth <= found.totals["free"].most
    assert found.totals["free"].total > free
    taken = sum(each.counts["taken"] for each in SAMPLE.made)
    assert found.totals["taken"].total == pytest.approx(taken)
    assert found.words.startswith("By 60 of 200 windows checked by eye, in nine of ten samples: free ")
    assert found.values()["free"]["range"] == [found.totals["free"].least, found.totals["free"].most]


def test_a_column_that_nobody_filled_in_is_left_and_a_table_without_any_is_refused(tmp_path: Path) -> None:
    table = write_check(SAMPLE, tmp_path, 20, 1) / "windows.csv"
    with pytest.raises(PictureError, match="has no counts by eye: fill in free_by_eye, taken_by_eye"):
        read_check(SAMPLE, table)
    fill(table, taken=lambda count: count)
    assert [*read_check(SAMPLE, table).totals] == ["taken"]


def test_a_spreadsheet_s_semicolons_and_mark_are_read(tmp_path: Path) -> None:
    table = write_check(SAMPLE, tmp_path, 20, 1) / "windows.csv"
    fill(table, free=lambda count: count)
    table.write_text("\ufeff" + table.read_text().replace(",", ";"), encoding="utf-8")
    assert read_check(SAMPLE, table).totals["free"].total == sum(each.counts["free"] for each in SAMPLE.made)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda text: text.replace("free_by_eye", "free_by_ear"), "has no counts by eye"),
        (lambda text: "\n".join(text.split("\n")[:-3]) + "\n", "lacks the row of window .*: leave no window out"),
        (lambda text: text.replace(",7\n", ",seven\n").replace(",7,", ",seven,"), "write a whole number"),
        (lambda text: text + text.split("\n")[3] + "\n", r"has window \d+/\d+ twice: keep one of these rows"),
        (lambda text: text.replace("window,", "name,"), "has no column window; fill in the table that --check wrote"),
    ],
)
def test_a_wrong_table_is_refused_by_row_and_column(tmp_path: Path, change: Any, words: str) -> None:
    table = write_check(SAMPLE, tmp_path, 40, 1) / "windows.csv"
    fill(table, free=lambda _: 7)
    table.write_text(change(table.read_text()))
    with pytest.raises(PictureError, match=words):
        read_check(SAMPLE, table)


def test_a_window_that_was_not_counted_is_named(tmp_path: Path) -> None:
    table = write_check(SAMPLE, tmp_path, 40, 1) / "windows.csv"
    fill(table, free=lambda count: count if count != 3 else "")
    with pytest.raises(PictureError, match=r"window 0/\d+: free_by_eye is empty: write a whole number"):
        read_check(SAMPLE, table)


def test_a_table_of_other_findings_or_without_its_design_is_refused(tmp_path: Path) -> None:
    table = write_check(SAMPLE, tmp_path, 40, 1) / "windows.csv"
    fill(table, free=lambda count: count)
    other = DrawnSample()
    other.identity = "another picture"
    with pytest.raises(PictureError, match="is of other findings: map with the picture"):
        read_check(other, table)
    alone = tmp_path / "alone.csv"
    shutil.copy(table, alone)
    with pytest.raises(PictureError, match=r"design.json cannot be read .*leave it beside"):
        read_check(SAMPLE, alone)
    (tmp_path / "check" / "design.json").write_text("{}")
    with pytest.raises(PictureError, match="is damaged: draw windows again"):
        read_check(SAMPLE, table)


def test_counts_by_eye_are_not_overwritten(tmp_path: Path) -> None:
    table = write_check(SAMPLE, tmp_path, 20, 1) / "windows.csv"
    write_check(SAMPLE, tmp_path, 30, 2)
    fill(table, free=lambda count: count)
    with pytest.raises(PictureError, match="has counts by eye; use them by --checked, or move the folder"):
        write_check(SAMPLE, tmp_path, 20, 1)


@pytest.mark.slow
def test_a_picture_is_mapped_checked_and_its_report_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture, out = lot_file(tmp_path), tmp_path / "out"
    assert main(["map", str(picture), "--out", str(out), "--check", "4", "--seed", "5"]) == 0
    assert f"{out / 'check'}: count by eye, fill in windows.csv" in capsys.readouterr().out
    table = out / "check" / "windows.csv"
    rows = rows_of(table)
    assert {"free", "taken", "vehicles", "free_by_eye", "vehicles_by_eye"} <= {*rows[0]}
    report = json.loads((out / "report.json").read_text())
    assert "checked" not in report
    image = cv2.imread(str(out / "check" / rows[0]["picture"]))
    assert image is not None
    assert image.shape[1] >= 2 * 600
    fill(table, free=lambda count: count, taken=lambda count: count + 1)
    assert main(["map", str(picture), "--out", str(out), "--resume", "--checked", str(table)]) == 0
    report = json.loads((out / "report.json").read_text())
    assert report["checked"]["windows"] >= 4
    assert report["checked"]["taken"]["total"] > report["taken"]
    assert abs(report["checked"]["free"]["total"] - report["free"]) < 0.1
    assert "windows checked by eye, in nine of ten samples: free " in capsys.readouterr().out
    second = tmp_path / "second"
    shutil.copytree(out, second)
    assert main(["map", str(picture), "--out", str(second), "--resume", "--check", "4"]) == 1
    assert "has counts by eye" in capsys.readouterr().err


def test_options_that_do_not_fit_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "photos").mkdir()
    asked = ["map", str(tmp_path / "photos"), "--out", str(tmp_path / "out")]
    assert main([*asked, "--seed", "3"]) == 2
    assert "--seed: only together with --check" in capsys.readouterr().err
