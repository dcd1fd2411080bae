"""Every setting and every option of every command: a wrong value ends with status 2 before anything starts, and the
message names what is wrong."""

from __future__ import annotations

import argparse
import functools
import types
import typing
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import hawk.cli
import hawk.daemon.start
import hawk.sim.cli
import hawk.survey.run
from hawk.config.loader import load_config, variable_of
from hawk.config.sections import Config, ConfigError, Section, bounds
from tests.sweep import sweep

EMPTY = ("", "  ")
NO_PATH = (*EMPTY, "~nobody-of-this-name/x")
NO_HOST = (*EMPTY, "a b", "http://x", "x/y", "192.168.1.256", "1.2.3", "-x", "x..y", "ht!tp")
NO_WORD = ("", "both")
NO_WHOLE = ("-1", "1.5", "x", "", "nan", "²", "9" * 30)
NOT_THERE = (*NO_PATH, "/nowhere/there", "n" * 300)

SETTINGS: dict[str, tuple[str, ...]] = {
    "autopilot.url": (
        *("", "udpin", "udpin://", "udpin://0.0.0.0", "udpin://:14550", "udpin://0.0.0.0:0", "udpin://0.0.0.0:99999"),
        *("udpin://0.0.0.0:x", "udpin://0.0.0.0:-1", "udpin://0.0.0.0:²", "udpout://a b:14550", "udpout://x:1/y"),
        *("udpin://::1:14550", "tcpout://[::1]:5760", "tcpout://127.0.0.1", "tcpin://localhost:5760", "tcp://x:1"),
        *("serial:///dev/ttyAMA0", "serial:///dev/ttyAMA0:", "serial:///dev/ttyAMA0:57601", "serial:///dev/ttyAMA0:0"),
        *(
            "serial://:57600",
            "serial:// :57600",
            "serial://ttyAMA0:57600",
            "serial:///dev/:57600",
            "serial:/dev/x:57600",
        ),
        *("serial_flowcontrol:///dev/ttyAMA0", "serial:///dev/ttyAMA0:fast", " udpin://0.0.0.0:14550"),
    ),
    "autopilot.vehicle_address": ("", "x", "1.2.3.4:0", "1.2.3.4:99999"),
    "camera.url": (
        *(
            "",
            "x",
            "http://",
            "http:///stream",
            "http://x:99999/",
            "http://x:0/",
            "http://x:y/",
            "http://a b/",
            "ftp://x",
        ),
        *("https://[::1/", "rtsp://", "rtsp:///x", "rtsps://x:70000/y", "http://user:pw@/x", "http://ht!tp:80/"),
        *("gst:", "gst:  ", "gst:!", "gst:videotestsrc !", "gst:'videotestsrc", "file://", "file:///", "file://x.mp4"),
        *("v4l2://", "v4l2:///", "v4l2://dev/video0", "v4l2:///dev/video0?width=1", "rpicam:x", "rpicam:0?awb=1"),
    ),
    "flight.battery_chemistry": NO_WORD,
    "remote_id.operator_id": ("", "x" * 21),
    "remote_id.operator_place": NO_WORD,
    "remote_id.description": ("", "x" * 24),
    "remote_id.serial_number": ("", "x" * 21),
    "vision.engine": NO_WORD,
    "vision.sun": NO_WORD,
    "web.host": NO_HOST,
    "web.token": ("", "short"),
    "web.allowed_hosts": ("http://x.example", "x.example:80", "x.example/hawk", "*.example"),
    "webhooks.urls": ("example.org", "ftp://x.example", "https://", "https:///hook"),
    "webhooks.secret": ("", "short", "whsec_" + "%" * 24),
    "collect.url": ("desk.example", "ftp://x.example", "https://", "http://x.example"),
    "collect.lots": NO_WORD,
    "collect.recordings": NO_WORD,
    "log.level": ("", "loud"),
}
"""Those that are neither numbers nor paths nor true or false."""


def kinds(annotation: Any) -> tuple[Any, ...]:
    return typing.get_args(annotation) if isinstance(annotation, types.UnionType) else (annotation,)


def wrong_settings() -> Iterator[tuple[str, str, str]]:
    for section, model in Config():
        if not isinstance(model, Section):
            continue  # tests/unit/daemon/lots/test_schedule.py has wrong blocks of the schedule
        for key, field in type(model).model_fields.items():
            name = f"{section}.{key}"
            found = bounds(section, key)
            if name in SETTINGS:
                values = SETTINGS[name]
            elif found is not None:
                values = ("", "x", "nan", str(found[0] - 1), str(found[1] + 1))
            elif bool in kinds(field.annotation):
                values = ("", "perhaps", "2")
            else:
                assert "Path" in str(field.annotation), f"{name}: no wrong value"
                values = NO_PATH
            yield from ((section, key, value) for value in values)


@sweep("section, key, value", wrong_settings())
def test_a_wrong_setting_is_refused_by_its_name(section: str, key: str, value: str) -> None:
    with pytest.raises(ConfigError) as caught:
        load_config(None, {variable_of(section, key): value})
    assert str(caught.value).startswith(f"{variable_of(section, key)}: {section}.{key}")
    with pytest.raises(ConfigError, match=rf"{section}\.{key}"):
        load_config(None, {}, {section: {key: [value] if key in ("allowed_hosts", "urls") else value}})


@pytest.mark.parametrize(
    ("name", "near"),
    [
        ("HAWK_WEB_PORT", "HAWK_WEB__PORT"),
        ("hawk_web__port", "HAWK_WEB__PORT"),
        ("HAWK_WEB_TOKEN", "HAWK_WEB__TOKEN"),
        ("HAWK_STORE_DIRECTORY", "HAWK_STORE__DIRECTORY"),
        ("HAWK_AUTOPILOT_URL", "HAWK_AUTOPILOT__URL"),
        ("HAWK_", "HAWK_<SECTION>__<KEY>"),
        ("HAWK_DEBUG", "HAWK_<SECTION>__<KEY>"),
    ],
)
def test_a_variable_that_would_change_nothing_is_refused(name: str, near: str) -> None:
    with pytest.raises(ConfigError, match=f"^{name}: is no setting") as caught:
        load_config(None, {name: "1"})
    assert near in str(caught.value)


def test_a_setting_of_earlier_versions_is_named_with_what_to_do(tmp_path: Path) -> None:
    file = tmp_path / "config.toml"
    file.write_text("[vision]\nthreads = 1\nuse_network = false\n")
    words = "vision.use_network: is no setting any more: the network alone finds stalls. Delete it from your settings"
    with pytest.raises(ConfigError) as caught:
        load_config(file, {})
    assert str(caught.value) == f"{file}, line 3: {words}"
    with pytest.raises(ConfigError) as caught:
        load_config(None, {"HAWK_VISION__USE_NETWORK": "false"})
    assert str(caught.value) == f"HAWK_VISION__USE_NETWORK: {words}"


def test_a_setting_of_earlier_versions_that_changes_nothing_keeps_no_drone_from_starting(tmp_path: Path) -> None:
    file = tmp_path / "config.toml"
    file.write_text("[vision]\nthreads = 2\nuse_network = true\n")
    assert load_config(file, {}).vision.threads == 2
    assert load_config(None, {"HAWK_VISION__USE_NETWORK": "true"}).vision == load_config(None, {}).vision


def test_the_home_folder_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", "/home/pilot")
    found = load_config(None, {"HAWK_STORE__DIRECTORY": "~/hawk"}, {"fence": {"file": "~/fence.geojson"}})
    assert found.store.directory == Path("/home/pilot/hawk")
    assert found.fence.file == Path("/home/pilot/fence.geojson")


def test_a_password_is_not_repeated() -> None:
    with pytest.raises(ConfigError, match=r"camera\.url") as caught:
        load_config(None, {"HAWK_CAMERA__URL": "rtsp://pilot:secret@cam:99999/"})
    assert "secret" not in str(caught.value)


@pytest.mark.parametrize(
    "url",
    [
        *("udpin://0.0.0.0:14550", "udpin://[::]:14550", "udpout://drone.local:14550", "tcpout://10.0.0.2:5760"),
        *("tcpin://0.0.0.0:5760", "serial:///dev/ttyAMA0:921600", "serial_flowcontrol:///dev/hawk/autopilot-1:57600"),
    ],
)
def test_a_link_that_mavsdk_opens_is_taken(url: str) -> None:
    assert load_config(None, {"HAWK_AUTOPILOT__URL": url}).autopilot.url == url


def test_a_slash_behind_the_port_has_one_clear_meaning() -> None:
    assert load_config(None, {"HAWK_AUTOPILOT__URL": "udpin://0.0.0.0:1/"}).autopilot.url == "udpin://0.0.0.0:1"


@pytest.mark.parametrize(
    "url",
    [
        *("http://cam/", "http://192.168.1.2:8080/stream?x=1", "https://[::1]:8443/s", "rtsp://u:p%40w@cam:554/live"),
        *("gst:videotestsrc ! videoconvert", "file:///home/pilot/film%20one.mp4", "v4l2:///dev/video0", "rpicam:"),
    ],
)
def test_a_camera_is_taken(url: str) -> None:
    assert load_config(None, {"HAWK_CAMERA__URL": url}).camera.url.get_secret_value() == url


SIM = ("--sim",)
URL = ("--url", "http://127.0.0.1:1/")
NOT_PID = ("-1", "0", "x", "", "2147483648")
NOT_PORT = ("-1", "65536", "99999", "x", "", "80.5")
STORE: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {"--config": ((), NOT_THERE), "--store": ((), NO_PATH)}
LINKS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "--host": ((), NO_HOST),
    "--port": ((), NOT_PORT),
    "--autopilot": ((), SETTINGS["autopilot.url"]),
    "--camera": ((), SETTINGS["camera.url"]),
}


def simulated(
    beside: tuple[str, ...], needs: tuple[str, ...] = ()
) -> dict[str, tuple[tuple[str, ...], tuple[str, ...]]]:
    world = (*beside, "--world", __file__, "--metres-per-pixel", "0.1")
    return {
        "--seed": (beside, NO_WHOLE),
        "--noise-seed": (beside, NO_WHOLE),
        "--condition": (beside, ("", "fog", "Day")),
        "--at": (beside, ("", "2026-05-04", "2026-13-01T00:00", "10:30", "1999-05-04T10:30", "9999-12-31T23:59")),
        "--repaint": (beside, ("-1", "101", "x", "1.5", "")),
        "--gnss-bias": (beside, ("1", "x,y", "nan,0", "")),
        "--compass-error": (beside, ("31", "-31", "nan", "x", "")),
        "--world": ((*beside, "--metres-per-pixel", "0.1"), (*NOT_THERE, "/")),
        "--metres-per-pixel": ((*beside, "--world", __file__), ("0", "-1", "0.001", "1.5", "nan", "inf", "x", "")),
        "--truth": (world, NOT_THERE),
        "--cars": ((*world, "--truth", __file__), NO_WHOLE),
        "--start": (beside, ("1", "1,2,3", "x,y", "nan,1", "1,inf", "")),
        "--speed": (beside, ("0.4", "5", "nan", "x", "", "-1")),
        "--gnss-sigma": (beside, ("-1", "51", "nan", "inf", "x", "")),
        "--wind": (beside, ("-1", "16", "nan", "x", "")),
        "--slope": (beside, ("1", "-1,0", "31,0", "1,361", "nan,0", "x,y", "")),
        "--rangefinder": (beside, ("-1", "301", "nan", "x", "")),
    }


ASKED: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "LOT": ((), EMPTY),
    "--from": ((), (*EMPTY, "yesterday", "2026-13-01")),
    "--to": ((), (*EMPTY, "yesterday", "2026-05-04T25:00")),
    "--time-zone": ((), (*EMPTY, "Mars/North", "../x")),
    "--weekday": ((), (*EMPTY, "noday", "mon-", "mon,,fri")),
    "--hour": ((), (*EMPTY, "25", "7-", "seven", "-1")),
    "--row": ((), EMPTY),
    "--zone": ((), EMPTY),
    "--section": ((), EMPTY),
    "--kind": ((), EMPTY),
}
"""Of a question about a lot: its period, parts and hours."""
OPTIONS: dict[str, dict[str, tuple[tuple[str, ...], tuple[str, ...]]]] = {
    "run": {
        **STORE,
        **LINKS,
        **simulated(SIM),
        "--fence": ((), NOT_THERE),
        "--outline": ((), NOT_THERE),
        "--ready-file": ((), (*NO_PATH, "/", "/nowhere/there")),
        "--parent-pid": ((), NOT_PID),
    },
    "survey": {
        "--config": (SIM, NOT_THERE),
        **{name: (SIM, wrong) for name, (_, wrong) in {**LINKS, "--store": ((), NO_PATH)}.items()},
        **simulated(SIM),
        "--fence": (SIM, NOT_THERE),
        "--outline": (SIM, NOT_THERE),
        "--out": (SIM, NO_PATH),
        "--url": (
            (),
            ("", " ", "ht!tp:/x", "ftp://x", "http://", "http://x:99999", "http://x:0", "x y", "http://[::1"),
        ),
        "--token": (URL, EMPTY),
        "--certificate": (("--url", "https://x"), NOT_THERE),
        "--timeout": (SIM, ("-1", "0", "nan", "inf", "x", "", "1e9")),
        "--again": (URL, EMPTY),
    },
    "plan-day": {
        "--url": (
            (),
            ("", " ", "ht!tp:/x", "ftp://x", "http://", "http://x:99999", "http://x:0", "x y", "http://[::1"),
        ),
        "--token": ((), EMPTY),
        "--certificate": ((), (*NOT_THERE, __file__)),
        "--batteries": ((), ("0", "101", "1.5", "x", "")),
        "--forecast": ((), (*NOT_THERE, __file__)),
        "--wind": (("--gust", "9"), ("-1", "101", "nan", "x", "", "10")),
        "--gust": (("--wind", "9"), ("-1", "101", "nan", "x", "", "8")),
        "--cloud": (("--wind", "1", "--gust", "2"), ("-1", "101", "nan", "x", "")),
        "--rain": (("--wind", "1", "--gust", "2"), ("-1", "501", "nan", "x", "")),
    },
    "desk": {**STORE, "--host": ((), NO_HOST), "--port": ((), NOT_PORT), "--lot": ((), EMPTY)},
    "replay": {
        "RECORDING": (("--check",), NOT_THERE),
        "--json": (("--check", __file__), (*NO_PATH, "a.txt", "/nowhere/a.json")),
        "--model": ((__file__,), NOT_THERE),
        "--port": ((__file__,), NOT_PORT),
        "--out": (("--process", __file__), (*NO_PATH, "/", __file__)),
        "--to-odm": ((__file__,), (*NO_PATH, "/", __file__)),
    },
    "map": {
        "SOURCE": (("--out", "o"), (*NO_PATH, "/nowhere/a.tif")),
        "--out": ((__file__,), NO_PATH),
        **dict.fromkeys(
            (
                "--model",
                "--outline",
                "--private",
                "--checked",
                "--lenses",
                "--calibration",
                "--log",
                "--tls-ca-file",
                "--tls-cert",
                "--tls-key",
            ),
            ((__file__, "--out", "o"), NOT_THERE),
        ),
        "--allow-host": ((__file__, "--out", "o"), (*NO_HOST, "https://tiles.example", "tiles.example:0")),
        "--check": ((__file__, "--out", "o"), ("0", "-1", "1.5", "x", "")),
        "--seed": ((__file__, "--out", "o", "--check", "9"), ("-1", "1.5", "x", "")),
        **dict.fromkeys(("--crs", "--scheduler", "--name"), ((__file__, "--out", "o"), EMPTY)),
        "--taken": ((__file__, "--out", "o"), ("2026-05-04", "2026-05-04T10:30", "3026-05-04T10:30Z", "x", "")),
        "--workers": ((__file__, "--out", "o"), ("0", "257", "1.5", "x", "")),
        "--height": ((__file__, "--out", "o"), ("2", "501", "nan", "x", "")),
        "--place": ((__file__, "--out", "o"), ("gps", "")),
        "--group": ((__file__, "--out", "o"), ("0", "1.5", "x", "")),
        "--log-offset": ((__file__, "--out", "o"), ("nan", "inf", "86401", "x", "")),
        "--hfov": ((__file__, "--out", "o"), ("4", "161", "nan", "x", "")),
        "--focal35": ((__file__, "--out", "o"), ("7", "501", "nan", "x", "")),
        "--store": ((__file__, "--out", "o"), NO_PATH),
        "--port": ((__file__, "--out", "o", "--page"), NOT_PORT),
        "--watch": (("--store", "s"), NOT_THERE),
        "--settle": (("--watch", "/", "--store", "s"), ("0", "86401", "nan", "x", "")),
        "--memory": ((__file__, "--out", "o"), ("499", "nan", "x", "")),
    },
    "film": {"RECORDING": ((), NOT_THERE), "FILM": ((), (*NO_PATH, "film.mp4", "/nowhere/film.avi", "/"))},
    "tokens": {
        **STORE,
        "work": ((), ("make",)),
        "role": ((), ("pilot", "")),
        "--name": ((), (*EMPTY, "you", "x" * 25, "operator2")),
        "--role": ((), ("pilot", "")),
        "--lot": ((), EMPTY),
    },
    "make-certificate": {
        **STORE,
        "--name": ((), (*EMPTY, "a b", "http://x")),
        "--out": ((), (*NO_PATH, "/dev/null")),
        "--days": ((), ("0", "-1", "826", "1.5", "x", "")),
    },
    "check": {"--config": ((), NO_PATH), "--store": ((), NO_PATH), "--host": ((), EMPTY), "--port": ((), NOT_PORT)},
    "doctor": {
        "--config": ((), NO_PATH),
        "--store": ((), NO_PATH),
        "--out": ((), (*NO_PATH, "x.zip", "/nowhere/x.tar.gz")),
    },
    "calibrate": {
        **STORE,
        "work": ((), ("lens",)),
        "--out": ((), (*NO_PATH, "/", "/nowhere/camera.yaml")),
        "--paper": (("board",), ("A5", "")),
        "--camera": ((), SETTINGS["camera.url"]),
        "--pictures": ((), NOT_THERE),
        "--preview": ((), (*NO_PATH, "preview.png", "/nowhere/preview.jpg")),
        "--time-limit": ((), ("-1", "0", "nan", "x", "", "1e9")),
        "--in-flight": ((), NOT_THERE),
    },
    "make-background": {
        "PICTURE": (("--out", "o"), NOT_THERE),
        "--out": ((__file__,), NO_PATH),
        "--zooms": ((__file__, "--out", "o"), ("", "x", "5-4", "24", "-1")),
    },
    "backup": {**STORE, "FILE": ((), (*NO_PATH, "/", "/nowhere/lots.db"))},
    "restore": {**STORE, "FILE": ((), NOT_THERE)},
    "verify": {**STORE, "FILE": ((), NOT_THERE)},
    "erase": {**STORE, "--lot": ((), EMPTY), "--survey": ((), EMPTY)},
    "export": {
        **STORE,
        "LOT": ((), EMPTY),
        "--training": ((), (*NO_PATH, __file__)),
        "--out": ((), (*NO_PATH, "lot.shp", "/nowhere/lot.csv")),
        "--survey": ((), EMPTY),
        "--feed": ((), ("", "datex")),
        "--valid-s": ((), (*EMPTY, "0", "soon", "nan")),
        "--from": ((), (*EMPTY, "yesterday")),
        "--to": ((), (*EMPTY, "yesterday")),
        "--time-zone": ((), (*EMPTY, "Mars/North")),
    },
    "stats": {**STORE, **ASKED, "--by": ((), ("", "week"))},
    "report": {
        **STORE,
        **ASKED,
        "--out": ((), (*EMPTY, "report.doc")),
        "--language": ((), ("", "de")),
        "--paper": ((), ("", "a5")),
    },
    "import-plan": {
        **STORE,
        "FILE": ((), NOT_THERE),
        **{f"--{name}": ((), EMPTY) for name in ("lot", "new", "layer", "units", "label", "crs", "who")},
        "--pin": ((), (*EMPTY, "1,2", "a,b,c,d", "nan,1,1,1", "1,1,91,1")),
    },
    "rollback": {},
    "versions": {},
}
"""For each option what it is given with, and wrong values of it."""
NOT_TRIED = {
    *(("run", "--attach-sim"), ("map", "--flight"), ("map", "--parent-pid")),  # only a program gives them
    *(("check", name) for name in ("--autopilot", "--camera")),  # a check reports them, like every other setting
    ("rollback", "VERSION"),
    *((command, name) for command in ("rollback", "versions") for name in ("--root", "--runtime")),
}


def subparsers(parser: argparse.ArgumentParser) -> dict[str, argparse.ArgumentParser]:
    (found,) = (each for each in parser._actions if isinstance(each, argparse._SubParsersAction))
    return dict(found.choices)


def options_of(parser: argparse.ArgumentParser) -> set[str]:
    with_value = (
        each for each in parser._actions if each.nargs != 0 and not isinstance(each, argparse._SubParsersAction)
    )
    return {each.option_strings[-1] if each.option_strings else str(each.metavar or each.dest) for each in with_value}


def test_every_option_with_a_value_is_tried() -> None:
    for command, parser in subparsers(hawk.cli.make_parser()).items():
        untried = options_of(parser) - OPTIONS[command].keys()
        assert {(command, name) for name in untried} <= NOT_TRIED
    assert options_of(hawk.sim.cli.make_parser()) == set(SIMULATOR)
    assert options_of(subparsers(hawk.sim.cli.make_parser())["photos"]) == set(PHOTOS)


def cases() -> Iterator[tuple[str, str, tuple[str, ...], str]]:
    for command, options in OPTIONS.items():
        for name, (beside, wrong) in options.items():
            yield from ((command, name, beside, value) for value in wrong)


POSITIONS: dict[str, Callable[[str, str], list[str]]] = {
    "film": lambda name, value: [value, "x.avi"] if name == "RECORDING" else [__file__, value],
    "backup": lambda name, value: [value if name == "FILE" else "lots.db"],
    "restore": lambda name, value: [value if name == "FILE" else __file__],
    "verify": lambda name, value: [value] if name == "FILE" else [],
    "export": lambda name, value: [value if name == "LOT" else "Lot 1", "--training", "out"],
    "stats": lambda name, value: [value if name == "LOT" else "Lot 1"],
    "report": lambda name, value: [value if name == "LOT" else "Lot 1", "--out", "report.html"],
    "import-plan": lambda name, value: [value if name == "FILE" else __file__, "--lot", "Lot 1"],
    "tokens": lambda name, value: [value, "operator"] if name == "work" else ["rotate", value],
}


def arguments(command: str, name: str, beside: tuple[str, ...], value: str) -> list[str]:
    positional = not name.startswith("--")
    given = [value] if positional else [f"{name}={value}"]
    if command in POSITIONS:
        given = POSITIONS[command](name, value) if positional else [*POSITIONS[command]("role", "operator"), *given]
    if command == "survey" and name != "--out":
        beside = ("--out", "results", *beside)
    return [command, *beside, *given]


def status(work: Callable[[list[str]], int], given: list[str]) -> int:
    try:
        return work(given)
    except SystemExit as ended:
        return int(ended.code or 0)


@pytest.fixture
def one_parser(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make the parsers of all commands once: for each of a thousand values they took most of the time."""
    for commands in (hawk.cli, hawk.sim.cli):
        monkeypatch.setattr(commands, "make_parser", functools.cache(commands.make_parser))


@pytest.fixture
def nothing_starts(one_parser: None, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    def started(*_: object) -> None:
        raise AssertionError("something was started")

    monkeypatch.setattr(hawk.daemon.start, "run_daemon", started)
    monkeypatch.setattr(hawk.survey.run, "SimulatedStack", started)
    monkeypatch.setattr(hawk.survey.run, "DroneClient", started)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.slow
@sweep("command, name, beside, value", cases())
def test_a_wrong_option_is_named_and_ends_with_two_before_anything_starts(
    command: str,
    name: str,
    beside: tuple[str, ...],
    value: str,
    nothing_starts: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert status(hawk.cli.main, arguments(command, name, beside, value)) == 2
    said = capsys.readouterr().err.splitlines()[-1]
    setting = {"--host": "web.host", "--autopilot": "autopilot.url", "--camera": "camera.url", "--store": "store."}
    assert name in said or setting.get(name, value) in said
    assert list(nothing_starts.iterdir()) == []


SIMULATOR: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    **simulated(()),
    "--heading": ((), ("361", "nan", "")),
    "--latitude": ((), ("91", "nan", "")),
    "--longitude": ((), ("181", "nan", "")),
    "--save-truth": ((), (*NO_PATH, "/", "/nowhere/x.json")),
    "--gnss-wait": ((), ("-1", "601", "nan", "")),
    "--battery-minutes": ((), ("0", "601", "nan", "")),
    "--gcs-param-name": ((), ("other", "")),
    "--mavlink": (
        (),
        ("", "udpout:x", "udpout:x:0", "udpout:x:99999", "udpin:a b:1", "tcp:x:1", "udpin::1", "udpin:x:²"),
    ),
    "--battery-cells": ((), ("0", "15", "x", "", "1.5")),
    "--mavlink-version": ((), ("0", "3", "x", "")),
    "--others": ((), ("", "plane", "tracker,", "tracker;gimbal")),
    "--follow": ((), ("", "udpout:x", "udpin:x:99999")),
    "--http": ((), ("", "8090", "x:99999", "a b:1", ":8090", "x:²")),
    "--latency": ((), ("-1", "6", "nan", "")),
    "--camera-rate": ((), ("0", "0.9", "61", "nan", "")),
    "--parent-pid": ((), NOT_PID),
}


PHOTOS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    **{
        name: SIMULATOR[name]
        for name in ("--seed", "--condition", "--at", "--repaint", "--world", "--metres-per-pixel")
    },
    **{name: SIMULATOR[name] for name in ("--truth", "--cars", "--latitude", "--longitude", "--noise-seed")},
    "--out": ((), (*NO_PATH, "/")),
    "--height": ((), ("4", "501", "nan", "")),
    "--overlap": ((), ("", "70", "70/96", "-1/60", "a/b", "nan/60", "70/60/50")),
    "--camera": ((), ("", "fc6310", "FC1")),
    "--width": ((), ("319", "8193", "1e3", "")),
    "--gps-sigma": ((), ("-1", "51", "nan", "")),
    "--gps-bias": ((), ("-1", "51", "nan", "")),
    "--yaw-error": ((), ("-1", "46", "nan", "")),
    "--height-error": ((), ("-1", "51", "nan", "")),
    "--lens-error": ((), ("-1", "21", "nan", "")),
}


@pytest.mark.usefixtures("one_parser")
@pytest.mark.slow
@sweep(
    "name, beside, value",
    [(name, beside, value) for name, (beside, wrong) in PHOTOS.items() for value in wrong],
)
def test_hawk_sim_photos_refuses_them_before_it_draws(
    name: str, beside: tuple[str, ...], value: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = [] if name == "--out" else [f"--out={tmp_path / 'new'}"]
    assert status(hawk.sim.cli.main, ["photos", *out, *beside, f"{name}={value}"]) == 2
    assert name in capsys.readouterr().err.splitlines()[-1]
    assert not (tmp_path / "new").exists()


@pytest.mark.usefixtures("one_parser")
@pytest.mark.slow
@sweep(
    "name, beside, value",
    [(name, beside, value) for name, (beside, wrong) in SIMULATOR.items() for value in wrong],
)
def test_hawk_sim_refuses_the_same(
    name: str, beside: tuple[str, ...], value: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert status(hawk.sim.cli.main, [*beside, f"{name}={value}"]) == 2
    assert name in capsys.readouterr().err.splitlines()[-1]


@pytest.mark.parametrize(
    ("given", "named"),
    [
        (["run", "--sim", "--autopilot", "udpin://127.0.0.1:1"], "--autopilot: not together with --sim"),
        (["run", "--sim", "--camera", "http://x/"], "--camera: not together with --sim"),
        (["run", "--sim", "--truth", __file__], "--truth: only together with --world"),
        (["run", "--sim", "--metres-per-pixel", "0.1"], "--metres-per-pixel: only together with --world"),
        (["run", "--sim", "--seed", "2", "--world", __file__, "--metres-per-pixel", "0.1"], "--seed: draws a world"),
        (["survey", "--sim", "--out", "o", "--token", "x"], "--token: only together with --url"),
        (["survey", "--sim", "--out", "o", "--certificate", __file__], "--certificate: only together with --url"),
        (["survey", *URL, "--out", "o", "--certificate", __file__], "--certificate: only for a page by HTTPS"),
        (["survey", *URL, "--out", "o", "--truth", __file__], "--truth: "),
    ],
)
def test_what_would_change_nothing_is_refused(
    given: list[str], named: str, nothing_starts: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert status(hawk.cli.main, given) == 2
    assert named in capsys.readouterr().err
    assert list(nothing_starts.iterdir()) == []
