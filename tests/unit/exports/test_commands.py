"""The command ``hawk-drone export``."""

from __future__ import annotations

import errno
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from hawk.cli import main
from hawk.exports import files
from hawk.lots.values import LotStoreError
from tests.unit.exports.stored import Stored, mosaic
from tests.unit.lots.repaints import extra, flown


def run(stored: Stored, tmp_path: Path, *arguments: str) -> int:
    stored.store.close()
    return main(["export", "Lot 1", "--store", str(tmp_path), *arguments])


@pytest.mark.nightly
def test_the_newest_survey_is_written(stored: Stored, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "lot.csv"
    assert run(stored, tmp_path, "--out", str(out)) == 0
    assert len(out.read_text().splitlines()) == 61
    said = capsys.readouterr().out
    assert said == f"survey {stored.first.survey}\n{out}: {out.stat().st_size / 1e6:.2f} MB\n"


@pytest.mark.nightly
def test_all_registered_surveys_go_into_one_geopackage(
    stored: Stored, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    second, out = stored.add(flown(2)), tmp_path / "lot.gpkg"
    assert run(stored, tmp_path, "--out", str(out), "--survey", "all") == 0
    assert "surveys: 2" in capsys.readouterr().out
    with closing(sqlite3.connect(out)) as opened:
        found = opened.execute("SELECT survey_id, count(*) FROM stalls GROUP BY survey_id").fetchall()
    assert sorted(found) == sorted((each, 60) for each in (stored.first.survey, second.survey))


@pytest.mark.slow
def test_all_surveys_fit_into_no_other_file(stored: Stored, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(stored, tmp_path, "--out", str(tmp_path / "lot.csv"), "--survey", "all") == 2
    assert "--out: lot.csv holds one survey; several go into a .gpkg" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize(("name", "key"), [("ngsi-ld", "ParkingSpot"), ("cds-aggregates", "occupancy_percent")])
def test_a_feed_is_printed(
    stored: Stored, tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, key: str
) -> None:
    assert run(stored, tmp_path, "--feed", name) == 0
    assert key in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "status", "reason"),
    [
        (
            ["--feed", "cds", "--from", "2026-05-04"],
            2,
            "--from: is not used by cds, a feed over a survey: leave it out",
        ),
        (
            ["--feed", "cds-aggregates", "--valid-s", "9"],
            2,
            "--valid-s: is not used by cds-aggregates, a feed over a pe",
        ),
        (["--out", "lot.csv", "--valid-s", "9"], 2, "--valid-s: only together with --feed"),
        (["--feed", "cds", "--valid-s", "0.9"], 2, "--valid-s"),
        (["--feed", "cds", "--survey", "all"], 2, "--survey: there is no survey 'all' of this lot"),
    ],
)
def test_an_option_that_a_feed_does_not_use_is_refused(
    stored: Stored, tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], status: int, reason: str
) -> None:
    if arguments[0] == "--out":
        arguments[1] = str(tmp_path / arguments[1])
    assert run(stored, tmp_path, *arguments) == status
    assert reason in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "status", "reason"),
    [
        (["--out", "lot.csv", "--survey", "zz"], 2, "--survey: there is no survey 'zz' of this lot"),
        (["--training", "new", "--survey", "zz"], 2, "--survey: only together with --out"),
    ],
)
def test_a_survey_that_is_not_there_writes_nothing(
    stored: Stored,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    status: int,
    reason: str,
) -> None:
    arguments[1] = str(tmp_path / arguments[1])
    assert run(stored, tmp_path, *arguments) == status
    assert reason in capsys.readouterr().err
    assert not Path(arguments[1]).exists()


@pytest.mark.slow
@pytest.mark.parametrize("end", ["csv", "png", "gpkg", "geojson", "kmz", "tif"])
def test_a_file_that_cannot_be_written_is_named_and_not_the_store(
    stored: Stored, tmp_path: Path, capsys: pytest.CaptureFixture[str], end: str
) -> None:
    assert run(stored, tmp_path, "--out", f"/proc/lot.{end}") == 1
    said = capsys.readouterr().err
    assert said.startswith(f"hawk-drone: --out: /proc/lot.{end} cannot be written: No such file or directory; name a")
    assert str(tmp_path) not in said


@pytest.mark.slow
@pytest.mark.parametrize("survey", ["newest", "all"])
def test_a_disk_without_room_is_named_with_the_remedy(
    stored: Stored, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, survey: str
) -> None:
    def full(path: Path, data: bytes) -> Path:
        raise OSError(errno.ENOSPC, "No space left on device", f"{path}{len(data)}")

    monkeypatch.setattr(files, "replace_whole", full)
    out = tmp_path / "lot.gpkg"
    assert run(stored, tmp_path, "--out", str(out), "--survey", survey) == 1
    said = capsys.readouterr().err
    assert (
        said
        == f"hawk-drone: --out: {out}: no room is left on its disk; make room there, or name a file on another disk\n"
    )


@pytest.mark.nightly
def test_pictures_with_labels_are_counted_beside_surveys_that_teach_nothing(
    stored: Stored, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    stored.edit({"do": "confirm", "all": True})
    one, two = tmp_path / "one", tmp_path / "two"
    train = "Train on from them: python -m training.adapt {} --out FILE\n".format
    assert run(stored, tmp_path, "--training", str(one)) == 0
    assert capsys.readouterr().out == f"{one}: pictures with labels: 1\n{train(one)}"
    later = Stored(tmp_path / "later")
    later.take_over(later.add(extra(flown(2))).survey, begin="all")
    newest = later.add(extra(flown(3)))
    later.pictures.write(newest.survey, mosaic())
    later.add(extra(flown(4)))
    later.edit({"do": "confirm", "all": True})
    assert run(later, tmp_path / "later", "--training", str(two)) == 0
    gone = "surveys without a picture: 1\nsurveys from before new paint: 2\n"
    assert capsys.readouterr().out == f"{two}: pictures with labels: 1\n{gone}{train(two)}"


def test_a_folder_for_training_that_cannot_be_written_is_named() -> None:
    reason = "--training: /proc cannot be written: No such file"
    with pytest.raises(LotStoreError, match=reason), files.written_to(Path("/proc"), "--training"):
        Path("/proc/a.jpg").write_bytes(b"")


def test_without_a_store_nothing_is_made(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", "Lot 1", "--store", str(tmp_path), "--out", str(tmp_path / "lot.kmz")]) == 1
    assert "there is no store of lots; name its folder by --store" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("end", ["lot.shp", "lot", "lot.geotiff"])
def test_another_end_is_refused_with_those_that_are_known(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], end: str
) -> None:
    assert main(["export", "Lot 1", "--out", str(tmp_path / end)]) == 2
    assert "must end in .csv or .geojson or .gpkg or .kmz or .png or .sections.csv" in capsys.readouterr().err
