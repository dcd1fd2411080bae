from __future__ import annotations

import contextlib
import json
import math
from datetime import UTC, datetime
from pathlib import Path

import cv2
import numpy as np
import pytest

from hawk.sim.cli import main, make_parser, run_options
from hawk.sim.world_options import load_world


@pytest.fixture
def picture(tmp_path: Path) -> Path:
    path = tmp_path / "lot.png"
    cv2.imwrite(str(path), np.full((100, 200, 3), 120, np.uint8))
    return path


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["--speed", "0.4"], "--speed"),
        (["--speed", "5"], "--speed"),
        (["--speed", "nan"], "--speed"),
        (["--seed", "-1"], "--seed"),
        (["--start", "1"], "--start"),
        (["--start", "1,inf"], "--start"),
        (["--mavlink", "tcp:127.0.0.1:5760"], "--mavlink"),
        (["--http", "8090"], "--http"),
        (["--http", "127.0.0.1:70000"], "--http"),
        (["--gnss-sigma", "-1"], "--gnss-sigma"),
        (["--wind", "40"], "--wind"),
        (["--latitude", "91"], "--latitude"),
        (["--battery-minutes", "0"], "--battery-minutes"),
        (["--gcs-param-name", "other"], "--gcs-param-name"),
        (["--metres-per-pixel", "-1"], "--metres-per-pixel"),
        (["--battery-cells", "0"], "--battery-cells"),
        (["--gnss-bias", "3"], "--gnss-bias"),
        (["--compass-error", "31"], "--compass-error"),
        (["--at", "2026-05-04"], "--at"),
        (["--repaint", "-1"], "--repaint"),
        (["--mavlink-version", "3"], "--mavlink-version"),
        (["--others", "tracker,kite"], "--others"),
    ],
)
def test_a_wrong_option_is_named_and_ends_with_two(
    arguments: list[str], named: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as error:
        main(arguments)
    assert error.value.code == 2
    assert f"argument {named}:" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["--metres-per-pixel", "0.1"], "--metres-per-pixel"),
        (["--cars", "1"], "--cars"),
        (["--world", "PICTURE", "--metres-per-pixel", "0.1", "--cars", "1"], "--cars"),
        (["--truth", __file__], "--truth"),
        (["--world", "PICTURE"], "--metres-per-pixel"),
        (["--world", "missing.png", "--metres-per-pixel", "0.1"], "missing.png"),
        (["--world", "PICTURE", "--metres-per-pixel", "0.1", "--truth", "missing.json"], "missing.json"),
        (["--world", "PICTURE", "--metres-per-pixel", "0.1", "--start", "30,5"], "--start"),
        (["--world", "PICTURE", "--metres-per-pixel", "0.1", "--at", "2026-05-04T10:30"], "--at"),
        (["--world", "PICTURE", "--metres-per-pixel", "0.1", "--repaint", "2"], "--repaint"),
        (["--at", "2026-05-04T10:30", "--condition", "night"], "--condition"),
        (["--world", "PICTURE", "--metres-per-pixel", "0.1", "--save-truth", "/nowhere/x.json"], "--save-truth"),
        (
            [
                "--world",
                "PICTURE",
                "--metres-per-pixel",
                "0.1",
                "--follow",
                "udpin:127.0.0.1:0",
                "--mavlink",
                "udpin:127.0.0.1:0",
            ],
            "--follow",
        ),
    ],
)
def test_options_that_do_not_fit_are_named(
    arguments: list[str], named: str, picture: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = [str(picture) if part == "PICTURE" else part for part in arguments]
    with contextlib.suppress(SystemExit):
        assert main(given) == 2
    assert named in capsys.readouterr().err


@pytest.mark.slow
def test_an_address_in_use_ends_with_one(picture: Path, capsys: pytest.CaptureFixture[str]) -> None:
    world = [f"--world={picture}", "--metres-per-pixel=0.1"]
    assert main([*world, "--http=127.0.0.1:0", "--mavlink=udpin:192.0.2.1:0"]) == 1
    assert "--mavlink" in capsys.readouterr().err


@pytest.mark.slow
def test_a_parent_that_is_gone_ends_with_two(picture: Path, capsys: pytest.CaptureFixture[str]) -> None:
    world = [f"--world={picture}", "--metres-per-pixel=0.1"]
    assert main([*world, "--http=127.0.0.1:0", "--parent-pid=99999999"]) == 2
    assert "--parent-pid" in capsys.readouterr().err


def test_the_drone_starts_at_the_given_place(picture: Path) -> None:
    options = make_parser().parse_args(
        [
            f"--world={picture}",
            "--metres-per-pixel=0.1",
            "--start=15,4",
            "--heading=90",
            "--speed=2",
            "--gcs-param-name=new",
        ]
    )
    run = run_options(options, load_world(options))
    assert run.start == (15.0, 4.0)
    assert run.autopilot.start == (-4.0, 15.0)
    assert run.autopilot.yaw == pytest.approx(np.pi / 2)
    assert run.autopilot.real_time_factor == run.speed == 2.0
    assert run.autopilot.gcs_parameter == "new"


def test_without_a_start_it_is_the_worlds_own(picture: Path) -> None:
    options = make_parser().parse_args([f"--world={picture}", "--metres-per-pixel=0.1"])
    world = load_world(options)
    assert run_options(options, world).start == world.start()


@pytest.mark.slow
def test_the_truth_of_a_picture_is_read_and_saved(picture: Path, tmp_path: Path) -> None:
    truth = tmp_path / "truth.json"
    corners = [[1.0, 1.0], [3.5, 1.0], [3.5, 6.0], [1.0, 6.0]]
    truth.write_text(json.dumps({"stalls": [{"corners_m": corners, "state": "taken"}], "lots_m": []}))
    saved = tmp_path / "saved.json"
    world = [f"--world={picture}", "--metres-per-pixel=0.1", f"--truth={truth}"]
    assert main([*world, f"--save-truth={saved}", "--http=127.0.0.1:0", "--parent-pid=99999999"]) == 2
    written = json.loads(saved.read_text())
    assert written["stalls"][0]["state"] == "taken"


@pytest.mark.slow
def test_the_lies_of_the_command_line_reach_the_drone(picture: Path) -> None:
    given = [
        f"--world={picture}",
        "--metres-per-pixel=0.1",
        "--battery-cells",
        "4",
        "--gnss-bias=-3,2.5",
        "--compass-error=-6",
        "--mavlink-version",
        "1",
        "--others",
        "tracker,gimbal",
    ]
    options = make_parser().parse_args(given)
    run = run_options(options, load_world(options))
    assert run.autopilot.battery_cells == 4
    assert run.autopilot.gnss_bias == (-3.0, 2.5)
    assert run.autopilot.compass_error == pytest.approx(math.radians(-6.0))
    assert run.mavlink_version == 1
    assert run.others == ("tracker", "gimbal")


@pytest.mark.slow
def test_the_moment_is_that_of_the_lots_place() -> None:
    options = make_parser().parse_args(["--at=2026-05-04T10:30", "--latitude=52.1", "--longitude=16"])
    world = load_world(options)
    assert world.at == datetime(2026, 5, 4, 9, 30, tzinfo=UTC)
    assert run_options(options, world).autopilot.utc_s == world.at.timestamp()
    assert world.stays is not None
    assert {stall.id for stall in world.stalls if stall.taken} == set(world.stays.at(world.at))
