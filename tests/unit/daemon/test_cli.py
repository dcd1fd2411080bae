from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

import pytest

from hawk.cli import load_settings, main, make_parser, simulation_options
from hawk.config import ConfigError


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
        (["run", "--world", "x.png"], "--world: only together with --sim"),
        (["run", "--condition", "night"], "--condition: only together with --sim"),
        (["run", "--sim", "--condition", "fog"], "--condition: must be one of day, overcast"),
        (["run", "--sim", "--condition", "fog"], "not fog"),
        (["run", "--speed", "2"], "--speed: only together with --sim"),
        (["run", "--sim", "--speed", "5"], "--speed: must be 0.5 to 4"),
        (["run", "--sim", "--speed", "0.4"], "--speed: must be 0.5 to 4"),
        (["run", "--sim", "--speed", "nan"], "--speed: must be 0.5 to 4"),
        (["run", "--sim", "--world", "absent.png", "--metres-per-pixel", "0.1"], "--world: absent.png is not a file"),
        (["run", "--sim", "--world", "absent.png"], "--metres-per-pixel: is needed"),
        (["survey", "--out", "o"], "--url: is needed without --sim"),
        (["survey", "--out", "o", "--sim", "--url", "http://x"], "--url: not together with --sim"),
    ],
)
def test_options_that_do_not_fit_are_named_and_end_with_status_2(
    arguments: list[str], named: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == 2
    assert named in capsys.readouterr().err


def test_the_command_line_overrides_the_file(tmp_path: Path) -> None:
    path = tmp_path / "c.toml"
    path.write_text("[web]\nport = 1000\nhost = '::1'\n")
    config = load_settings(options("run", "--config", str(path), "--port", "2000", "--fence", "f.geojson"))
    assert (config.web.port, config.web.host) == (2000, "::1")
    assert config.fence.file == Path("f.geojson")


@pytest.mark.parametrize(
    ("program", "arguments"),
    [("hawk.cli", ["--sim"]), ("hawk.cli", ["survey", "--out", "o", "--sim"]), ("hawk.sim.cli", [])],
)
def test_without_the_simulators_package_one_line_says_what_to_install(program: str, arguments: list[str]) -> None:
    code = f"import sys; sys.modules['pymavlink'] = None; from {program} import main; sys.exit(main({arguments}))"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False)
    assert ended.returncode == 2
    (line,) = ended.stderr.splitlines()
    assert line.endswith("the simulator needs pymavlink, which is not installed: pip install 'hawk-drone[sim]'")


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
    with pytest.raises(SystemExit) as ended:
        main(["survey", "--sim"])
    assert ended.value.code == 2
    assert "--out" in capsys.readouterr().err


def test_a_config_error_is_not_a_traceback() -> None:
    with pytest.raises(ConfigError):
        simulation_options(options("run", "--wind", "3"))


HANGING = """
import sys, threading
import hawk.cli, hawk.daemon
async def run_daemon(config, options):
    threading.Thread(target=threading.Event().wait, name="hangs in a library").start()
    return 0
hawk.daemon.run_daemon = run_daemon
hawk.cli.EXIT_S = 0.1
sys.exit(hawk.cli.main(["run"]))
"""


@pytest.mark.slow
def test_a_thread_that_hangs_does_not_keep_the_process() -> None:
    ended = subprocess.run([sys.executable, "-c", HANGING], capture_output=True, text=True, timeout=60, check=False)
    assert ended.returncode == 1
    assert "Timeout" in ended.stderr
    assert "in wait" in ended.stderr
