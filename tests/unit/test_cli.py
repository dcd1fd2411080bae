from __future__ import annotations

import argparse
import errno
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from hawk.cli import main, make_parser, simulation_options
from hawk.comm.protocol.authority import Role
from hawk.config.loader import load_settings
from hawk.config.sections import ConfigError, WebSettings
from hawk.daemon.start_checks import listening_problem
from hawk.runtime.programs import remedy
from hawk.survey.run import Address, address_of
from hawk.web.access.tokens import TOKEN_FILE, rotate


def options(*arguments: str) -> argparse.Namespace:
    return make_parser().parse_args(arguments)


def test_a_wrong_config_file_names_the_key_and_the_line_and_ends_with_status_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "bad.toml"
    path.write_text("[web]\nport = 99999\n")
    assert main(["--config", str(path)]) == 2
    assert f"{path}, line 2: web.port" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["run", "--world", __file__], "--world: only together with --sim"),
        (["run", "--condition", "night"], "--condition: only together with --sim"),
        (["run", "--sim", "--cars", "1"], "--cars: only together with --world"),
        (["run", "--sim", "--world", __file__, "--metres-per-pixel", "0.1", "--cars", "1"], "--cars: needs --truth"),
        (["run", "--at", "2026-05-04T10:30"], "--at: only together with --sim"),
        (["run", "--compass-error", "3"], "--compass-error: only together with --sim"),
        (["run", "--gnss-bias", "3,1"], "--gnss-bias: only together with --sim"),
        (["run", "--sim", "--at", "noon"], "--at: must be an ISO 8601"),
        (["run", "--sim", "--at", "2026-05-04T10:30", "--condition", "dusk"], "--condition: dusk is a time of day"),
        (["run", "--sim", "--condition", "fog"], "--condition: must be one of day, overcast"),
        (["run", "--sim", "--condition", "fog"], "not fog"),
        (["run", "--speed", "2"], "--speed: only together with --sim"),
        (["run", "--sim", "--speed", "5"], "--speed: must be a number from 0.5 to 4"),
        (["run", "--sim", "--speed", "0.4"], "--speed: must be a number from 0.5 to 4"),
        (["run", "--sim", "--speed", "nan"], "--speed: must be a number from 0.5 to 4"),
        (["run", "--sim", "--world", "absent.png", "--metres-per-pixel", "0.1"], "--world: absent.png cannot be read"),
        (["run", "--sim", "--world", "n" * 300, "--metres-per-pixel", "0.1"], "cannot be read: File name too long"),
        (["run", "--sim", "--world", __file__], "--metres-per-pixel: is needed"),
        (["run", "--seed", "3"], "--seed: only together with --sim"),
        (["run", "--truth", __file__], "--truth: only together with --sim"),
        (["survey", "--out", "o"], "--url: is needed without --sim"),
        (["survey", "--out", "o", "--seed", "1", "--url", "http://x"], "--seed: only together with --sim"),
        (["survey", "--out", "o", "--url", "http://x:port"], "--url: 'http://x:port' is no address"),
        (["survey", "--out", "o", "--url", "http://x:70000"], "--url: 'http://x:70000' is no address"),
        (["survey", "--out", "o", "--url", "ftp://x"], "write http://HOST:PORT/"),
        (["survey", "--out", "o", "--url", "http://"], "write http://HOST:PORT/"),
        (["survey", "--out", "o", "--url", "http://[::1"], "--url: 'http://[::1' is no address"),
        (["run", "--store", "/dev/null"], "store.directory: /dev/null cannot be used"),
        (["run", "--store", "/dev/null/store"], "name a folder that this user may write"),
        (["survey", "--out", "/dev/null", "--url", "http://x"], "--out: /dev/null cannot be used"),
        (["survey", "--out", "o", "--sim", "--url", "http://x"], "--url: not together with --sim"),
    ],
)
def test_options_that_do_not_fit_are_named_and_end_with_status_2(
    arguments: list[str], named: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == 2
    assert named in capsys.readouterr().err


@pytest.mark.parametrize("beside", [["--url", "http://127.0.0.1:1"], ["--sim"]])
@pytest.mark.parametrize(
    "given",
    [
        ("--store", "s"),
        ("--port", "3001"),
        ("--host", "::1"),
        ("--autopilot", "udpin://127.0.0.1:1"),
        ("--camera", "file:///x"),
    ],
)
def test_survey_has_no_option_that_it_would_not_use(
    given: tuple[str, str], beside: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["survey", "--out", str(tmp_path / "o"), *beside, *given]) == 2
    assert f"unrecognized arguments: {given[0]}" in capsys.readouterr().err
    assert not (tmp_path / "o").exists()


@pytest.mark.parametrize("given", [("--config", "c.toml"), ("--fence", __file__)])
def test_survey_at_a_running_daemon_refuses_that_daemons_settings(
    given: tuple[str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["survey", "--out", "o", "--url", "http://x", *given]) == 2
    assert f"{given[0]}: a setting of the daemon at --url" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("url", "address"),
    [
        ("http://drone.local:3000/", Address("drone.local", 3000, False)),
        ("https://drone.local", Address("drone.local", 3000, True)),
        ("drone.local:8080", Address("drone.local", 8080, False)),
        ("http://[::1]:4000/?x=1", Address("::1", 4000, False)),
    ],
)
def test_the_address_of_a_page(url: str, address: Address) -> None:
    assert address_of(url) == address


def started(*arguments: str) -> subprocess.CompletedProcess[str]:
    """A daemon of its own process that is expected to end by itself."""
    command = [sys.executable, "-m", "hawk.cli", "run", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)


@pytest.mark.slow
@pytest.mark.parametrize(("content", "named"), [(None, "cannot be read"), (b"no network", "is not an ONNX file")])
def test_a_network_that_cannot_be_used_ends_the_start_before_the_page_is_announced(
    content: bytes | None, named: str, tmp_path: Path
) -> None:
    model, settings = tmp_path / "lot.onnx", tmp_path / "c.toml"
    if content is not None:
        model.write_bytes(content)
    settings.write_text(f"[vision]\nmodel = '{model}'\n")
    ended = started("--config", str(settings), "--store", str(tmp_path / "store"), "--port", "0")
    assert ended.returncode == 2
    assert f"hawk-drone: vision.model: {model}" in ended.stderr
    assert named in ended.stderr
    assert "Traceback" not in ended.stderr
    assert "http" not in ended.stdout


@pytest.mark.parametrize(
    ("error", "named"),
    [
        (OSError(errno.EADDRINUSE, "Address already in use"), "web.port: port 3000 of 192.0.2.1 is in use"),
        (OSError(errno.EADDRNOTAVAIL, "Cannot assign requested address"), "web.host: '192.0.2.1' is no address"),
        (socket.gaierror(-2, "Name or service not known"), "web.host: '192.0.2.1' is no address"),
        (OSError(errno.EACCES, "Permission denied"), "web.port: port 3000 is not for this user"),
        (OSError(errno.ENOBUFS, "No buffer space available"), "cannot be served: No buffer space"),
    ],
)
def test_what_keeps_the_page_from_being_served_is_named(error: OSError, named: str) -> None:
    assert named in listening_problem(error, WebSettings(host="192.0.2.1"))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "named"),
    [(["--host", "192.0.2.1"], "web.host: '192.0.2.1' is no address of this computer"), ([], "is in use")],
)
def test_a_wrong_host_and_a_port_in_use_are_different_things(arguments: list[str], named: str, tmp_path: Path) -> None:
    rotate(tmp_path / TOKEN_FILE, Role.OPERATOR)  # without a token no other host is served
    with socket.create_server(("127.0.0.1", 0)) as taken:
        ended = started("--store", str(tmp_path), "--port", str(taken.getsockname()[1]), *arguments)
    assert ended.returncode == 2
    assert named in ended.stderr
    assert "Traceback" not in ended.stderr


def test_the_command_line_overrides_the_file(tmp_path: Path) -> None:
    path = tmp_path / "c.toml"
    path.write_text("[web]\nport = 1000\nhost = '::1'\n")
    fence = tmp_path / "f.geojson"
    fence.touch()
    config = load_settings(options("run", "--config", str(path), "--port", "2000", "--fence", str(fence)))
    assert (config.web.port, config.web.host) == (2000, "::1")
    assert config.fence.file == fence


@pytest.mark.slow
@pytest.mark.parametrize(
    ("program", "arguments"),
    [("hawk.cli", ["--sim"]), ("hawk.cli", ["survey", "--out", "o", "--sim"]), ("hawk.sim.cli", [])],
)
def test_without_the_simulators_package_one_line_says_what_to_install(program: str, arguments: list[str]) -> None:
    code = f"import sys; sys.modules['pymavlink'] = None; from {program} import main; sys.exit(main({arguments}))"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False)
    assert ended.returncode == 2
    (line,) = ended.stderr.splitlines()
    assert line.endswith(f"the simulator needs pymavlink, which is not installed: {remedy('sim')}")


@pytest.mark.slow
def test_the_simulators_help_is_there_without_its_package() -> None:
    code = "import sys; sys.modules['pymavlink'] = None; from hawk.sim.cli import main; main(['--help'])"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert "--gnss-sigma" in ended.stdout


def test_without_sim_there_is_no_simulation() -> None:
    assert simulation_options(options("run")) is None


def test_an_attached_simulation_may_run_faster() -> None:
    assert simulation_options(options("run", "--attach-sim", "http://127.0.0.1:1", "--speed", "2")) is None


def test_a_seed_and_a_picture_become_the_simulators_options(tmp_path: Path) -> None:
    drawn = simulation_options(options("run", "--sim", "--seed", "7", "--speed", "2"))
    assert drawn is not None
    assert drawn.arguments() == ["--seed=7", "--speed=2.0"]
    picture = tmp_path / "lot.png"
    picture.write_bytes(b"")
    flown = simulation_options(
        options("run", "--sim", "--world", str(picture), "--metres-per-pixel", "0.1", "--start=3,4")
    )
    assert flown is not None
    assert flown.arguments() == [f"--world={picture}", "--metres-per-pixel=0.1", "--start=3,4", "--speed=1.0"]


def test_moment_and_constant_errors_reach_the_simulation() -> None:
    given = ["survey", "--out", "o", "--sim", "--at", "2026-05-04T10:30", "--repaint", "3"]
    given += ["--gnss-bias=-2,1", "--compass-error", "-4"]
    flown = simulation_options(options(*given))
    assert flown is not None
    arguments = ["--seed=1", "--at=2026-05-04T10:30", "--repaint=3", "--speed=1.0", "--gnss-bias=-2,1"]
    assert flown.arguments() == [*arguments, "--compass-error=-4.0"]


def test_a_condition_is_for_drawn_worlds(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    night = simulation_options(options("survey", "--out", "o", "--sim", "--condition", "night"))
    assert night is not None
    assert night.arguments() == ["--seed=1", "--condition=night", "--speed=1.0"]
    picture = tmp_path / "lot.png"
    picture.write_bytes(b"")
    given = ["run", "--sim", "--world", str(picture), "--metres-per-pixel", "0.1", "--condition", "night"]
    assert main(given) == 2
    assert "--condition: only for drawn worlds" in capsys.readouterr().err


def test_survey_without_out_is_a_usage_error(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["survey", "--sim"]) == 2
    assert "--out" in capsys.readouterr().err


def test_a_config_error_is_not_a_traceback() -> None:
    with pytest.raises(ConfigError):
        simulation_options(options("run", "--wind", "3"))


HANGING = """
import sys, threading
import hawk.cli, hawk.daemon.start
async def run_daemon(config, options):
    threading.Thread(target=threading.Event().wait, name="hangs in a library").start()
    return 0
hawk.daemon.start.run_daemon = run_daemon
hawk.cli.EXIT_S = 0.1
sys.exit(hawk.cli.main(["run"]))
"""


@pytest.mark.slow
def test_a_thread_that_hangs_does_not_keep_the_process() -> None:
    ended = subprocess.run([sys.executable, "-c", HANGING], capture_output=True, text=True, timeout=60, check=False)
    assert ended.returncode == 1
    assert "Timeout" in ended.stderr
    assert "in wait" in ended.stderr
