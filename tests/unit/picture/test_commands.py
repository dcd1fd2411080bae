from __future__ import annotations

import csv
import json
import re
import socket
from pathlib import Path

import numpy as np
import pytest
import rasterio
from rasterio.transform import from_origin
from sqlalchemy import select

from hawk.cli import main
from hawk.config.sections import Config
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import SURVEY
from tests.drawn_worlds import drawn_world
from tests.raster_server import raster_server
from tests.unit.picture.orthophoto.drawn import lot_picture, write


@pytest.fixture(scope="module")
def orthophoto(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Half of a drawn lot as a GeoTIFF of 10 cm."""
    path = tmp_path_factory.mktemp("orthophoto") / "yard.tif"
    picture = np.ascontiguousarray(drawn_world(3).ground[::2, ::2][:700, :700, ::-1])
    with rasterio.open(
        path, "w", driver="GTiff", width=700, height=700, count=3, dtype="uint8", crs="EPSG:28992",
        transform=from_origin(155_000, 463_000, 0.1, 0.1),
    ) as file:  # fmt: skip
        file.write(np.moveaxis(picture, -1, 0))
    return path


@pytest.mark.slow
def test_an_orthophoto_becomes_files_and_a_survey_in_the_store(
    orthophoto: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, store = tmp_path / "out", tmp_path / "store"
    assert main(["map", str(orthophoto), "--out", str(out), "--store", str(store), "--json"]) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    report = lines[-1]
    assert report["event"] == "report"
    assert report["stalls"] > 20
    assert report["free_range"][0] <= report["free"] <= report["free_range"][1]
    assert "as the first survey of" in report["store"]
    assert {line["event"] for line in lines[:-1]} == {"progress"}
    assert (out / "stalls-source-crs.geojson").exists()
    assert main(["map", str(orthophoto), "--out", str(out)]) == 2
    assert "--resume" in capsys.readouterr().err
    assert main(["map", str(orthophoto), "--out", str(out), "--resume"]) == 0
    said = capsys.readouterr().out
    assert "stalls on" in said
    assert "give it by --taken" in said
    taken = ["--taken", "2026-05-04T10:30+02:00"]
    assert main(["map", str(orthophoto), "--out", str(out), "--resume", *taken]) == 0
    assert "--taken" not in capsys.readouterr().out
    written = json.loads((out / "report.json").read_text())
    assert (written["survey_ended_utc"], written["time_is_sure"]) == ("2026-05-04T08:30:00Z", True)
    table = (out / "stalls.csv").read_text().splitlines()
    assert all("2026-05-04T08:30:00Z" in line for line in table[1:])


@pytest.mark.parametrize(
    ("more", "named"),
    [
        (["--port", "3000"], "--port"),
        (["--scheduler", "tcp://localhost:1", "--workers", "2"], "--workers"),
        (["--height", "60"], "--height"),
        (["--scheduler", "foo"], "tls://HOST:PORT"),
        (["--scheduler", "tcp://host:0"], "tls://HOST:PORT"),
        (["--scheduler", "tcp://10.0.0.1:8786"], "everybody on that network can run programs"),
        (["--scheduler", "tls://10.0.0.1:8786"], "--tls-ca-file is missing"),
        (["--tls-cert", __file__], "--tls-cert: only together with --scheduler"),
        (["--scheduler", "tcp://127.0.0.1:9"], "does not answer"),
    ],
)
def test_options_that_do_not_fit_are_named(
    orthophoto: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], more: list[str], named: str
) -> None:
    assert main(["map", str(orthophoto), "--out", str(tmp_path / "out"), *more]) in (1, 2)
    assert named in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_source_that_is_not_there_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["map", str(tmp_path / "none.tif"), "--out", str(tmp_path / "out")]) == 2
    assert "none.tif is not there" in capsys.readouterr().err


def test_an_error_is_a_line_of_json_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["map", str(tmp_path), "--out", str(tmp_path / "out"), "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["event"] == "error"


def test_a_store_that_cannot_be_is_refused_before_the_work(
    orthophoto: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").touch()
    out = tmp_path / "out"
    assert main(["map", str(orthophoto), "--out", str(out), "--store", str(tmp_path / "file" / "store")]) == 2
    assert "--store: " in (said := capsys.readouterr().err)
    assert "name a folder that this user may write" in said
    assert not out.exists()


def test_ctrl_c_says_how_to_go_on(
    orthophoto: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def stopped(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("hawk.picture.sources.survey_of_source", stopped)
    assert main(["map", str(orthophoto), "--out", str(tmp_path / "out")]) == 130
    assert capsys.readouterr().err.endswith("stopped; go on by --resume\n")


def test_what_is_used_wrongly_is_a_line_of_json_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for given in (["map", str(tmp_path / "none.tif"), "--json"], ["map", "--json", str(tmp_path), "--oops"]):
        assert main([*given, "--out", str(tmp_path / "out")]) == 2
        said = capsys.readouterr()
        assert json.loads(said.out) == {"event": "error", "text": said.err.removeprefix("hawk-drone: ").rstrip()}


def test_a_folder_of_other_files_is_refused_with_resume_too(
    orthophoto: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("letter.txt", "report.json"):
        (tmp_path / name).write_text("{}")
    assert main(["map", str(orthophoto), "--out", str(tmp_path), "--resume"]) == 2
    assert "holds other files" in capsys.readouterr().err
    assert {path.name for path in tmp_path.iterdir()} == {"letter.txt", "report.json"}


def test_a_port_in_use_is_refused_before_the_work(
    orthophoto: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        assert main(["map", str(orthophoto), "--out", str(tmp_path / "out"), "--page", "--port", port]) == 2
    assert f"--port: port {port} of" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_the_page_shows_the_survey_that_was_stored(
    orthophoto: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shown: list[tuple[str | None, str | None]] = []

    async def noted(_: Config, lot: str | None, survey: str | None) -> int:
        shown.append((lot, survey))
        return 0

    monkeypatch.setattr("hawk.daemon.desk.run_desk", noted)
    assert main(["map", str(orthophoto), "--out", str(tmp_path / "out"), "--page", "--port", "0"]) == 0
    with Database(tmp_path / "out" / "store" / "lots.db").reading() as connection:
        stored = connection.execute(select(SURVEY.c.lot, SURVEY.c.id)).one()
    assert shown == [tuple(stored)]


@pytest.mark.parametrize("value", [0, 255])
def test_a_picture_without_ground_is_refused_and_nothing_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], value: int
) -> None:
    path = write(tmp_path / "empty.tif", np.full((3, 100, 100), value, np.uint8))
    assert main(["map", str(path), "--out", str(tmp_path / "out")]) == 1
    assert "empty.tif: shows no ground" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_file_in_place_of_the_folder_is_called_one(
    orthophoto: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "out").write_text("a letter")
    for more in ([], ["--resume"]):
        assert main(["map", str(orthophoto), "--out", str(tmp_path / "out"), *more]) == 2
        assert capsys.readouterr().err.endswith("out is a file: name a new folder\n")


@pytest.mark.slow
def test_work_on_another_source_is_not_written_over(
    orthophoto: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, other = tmp_path / "out", write(tmp_path / "other.tif", lot_picture().transpose(2, 0, 1)[:, :300, :300])
    assert main(["map", str(other), "--out", str(out)]) == 0
    before = {path.name: path.read_bytes() for path in out.iterdir() if path.is_file()}
    capsys.readouterr()
    assert main(["map", str(orthophoto), "--out", str(out), "--resume"]) == 2
    said = capsys.readouterr().err
    assert said.endswith(f"--out: {out} holds the work on other.tif; name another folder\n")
    assert {path.name: path.read_bytes() for path in out.iterdir() if path.is_file()} == before
    assert main(["map", str(other), "--out", str(out), "--resume", "--name", "North"]) == 0
    (out / "source.json").unlink()
    assert main(["map", str(orthophoto), "--out", str(out), "--resume"]) == 2


@pytest.mark.slow
def test_a_survey_without_stalls_is_no_lot_in_the_report_as_in_the_store(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    grey = write(tmp_path / "grey.tif", np.full((3, 300, 300), 120, np.uint8))
    assert main(["map", str(grey), "--out", str(tmp_path / "out"), "--store", str(tmp_path / "store"), "--json"]) == 0
    report = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert report["store"].endswith("as a survey without a lot: it has no stalls")
    written = json.loads((tmp_path / "out" / "report.json").read_text())
    for each in (report, written):
        found = [each[name] for name in ("registered", "doubt", "lot_id", "free_range")]
        assert found == [False, "it has no stalls", "", None]


@pytest.mark.parametrize(
    ("source", "words"),
    [
        (
            "https://tiles.example/city.tif?sig=secret",
            "https://tiles.example/city.tif is .*: --allow-host tiles.example$",
        ),
        ("https://tiles.example:444/city.tif", "is on another computer, .*: --allow-host tiles.example:444$"),
        ("s3://tiles/city.tif", "s3://tiles/city.tif is on another .*: --allow-host s3.REGION.amazonaws.com$"),
        (
            "/vsicurl/https://x/c.tif",
            "https://x/c.tif is on another computer, which is not asked: copy the picture here",
        ),
        (
            "/vsizip/vsicurl/https://x/c.zip?secret",
            "/vsizip/vsicurl/https://x/c.zip is .*, or name https:// or s3:// \\(see",
        ),
        ("HTTPS://tiles.example/city.tif?secret", "https://tiles.example/city.tif is .*: --allow-host tiles.example$"),
        ("http://[::1/c.tif?secret", "http://\\[::1/c.tif names no host and file"),
        ("https://me:secret@x/c.tif", "https://x/c.tif has a user or password in its address"),
    ],
)
def test_a_picture_of_another_computer_is_refused_with_the_remedy(
    source: str, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    hosts = [] if source.startswith("s3") else ["--allow-host", "other.example"]
    assert main(["map", source, "--out", str(tmp_path / "out"), *hosts]) == 2
    said = capsys.readouterr().err
    assert re.search(words, said, re.MULTILINE)
    assert "secret" not in said
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
@pytest.mark.parametrize("more", [[], ["--workers", "2"]])
def test_a_picture_of_an_allowed_host_is_mapped_and_gone_on_with(
    orthophoto: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], more: list[str]
) -> None:
    out, local = tmp_path / "out", tmp_path / "local"
    assert main(["map", str(orthophoto), "--out", str(local)]) == 0
    with raster_server(orthophoto.read_bytes()) as server:
        command = [
            "map",
            f"http://{server.at}/city.tif?sig=secret",
            "--out",
            str(out),
            "--allow-host",
            server.at,
            *more,
        ]
        assert main(command) == 0
        before = {path.name: path.stat().st_mtime_ns for path in (out / "windows").iterdir()}
        assert main([*command, "--resume"]) == 0
        assert {path.name: path.stat().st_mtime_ns for path in (out / "windows").iterdir()} == before
    found, same = (
        [
            (row["state"], row["latitude"], row["longitude"])
            for row in csv.DictReader((at / "stalls.csv").read_text().splitlines())
        ]
        for at in (out, local)
    )
    assert found == same != []
    assert "secret" not in capsys.readouterr().out + "".join(
        path.read_text(errors="replace") for path in out.rglob("*") if path.is_file()
    )
