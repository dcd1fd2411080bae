"""The installed product: the wheel is complete, and the service is set as designed."""

from __future__ import annotations

import configparser
import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from hawk.versions.switch import RUNTIME_FOLDER

ROOT = Path(__file__).resolve().parents[2]
UNIT = ROOT / "packaging" / "systemd" / "hawk-drone.service"
COMMAND = "/opt/hawk/current/bin/hawk-drone"
EXPOSURE = {"hawk-drone.service": 1.5, "hawk-desk.service": 1.2, "hawk-inbox.service": 0.5}
"""Greatest exposure of each unit, as systemd-analyze(1) counts it."""
"""Of `systemd-analyze security`, 0 to 10; what is left are the network, devices, and its user's groups."""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Iterator[zipfile.ZipFile]:
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "--no-cache-dir"]
    built = subprocess.run(
        [*command, f"--wheel-dir={folder}", str(ROOT)], capture_output=True, text=True, timeout=300, check=False
    )
    assert built.returncode == 0, built.stdout + built.stderr
    (path,) = folder.glob("hawk_drone-*.whl")
    with zipfile.ZipFile(path) as found:
        yield found


def test_the_wheel_carries_the_built_page_with_all_that_it_asks_for(wheel: zipfile.ZipFile) -> None:
    page = wheel.read("hawk/web/static/index.html").decode()
    asked = set(re.findall(r'(?:src|href)="\.?/?([\w./-]+)"', page))
    assert {"app.js", "app.css"} <= asked
    names = set(wheel.namelist())
    assert {f"hawk/web/static/{name}" for name in asked | {"life-worker.js", "licences.txt"}} <= names
    assert b"hawk-app" in wheel.read("hawk/web/static/app.js")


def test_the_wheel_carries_the_network_and_every_module(wheel: zipfile.ZipFile) -> None:
    weights = Path("hawk/algo/vision/weights/lot.onnx")
    assert wheel.read(weights.as_posix()) == (ROOT / weights).read_bytes()
    modules = {path.relative_to(ROOT).as_posix() for path in (ROOT / "hawk").rglob("*.py") if not _of_the_page(path)}
    assert modules <= set(wheel.namelist())
    assert "hawk/py.typed" in wheel.namelist()


def test_the_wheel_carries_nothing_that_a_user_does_not_need(wheel: zipfile.ZipFile) -> None:
    folders = {name.split("/")[0] for name in wheel.namelist()}
    (shared,) = [folder for folder in folders if folder.endswith(".data")]
    assert {folder for folder in folders if not folder.endswith(".dist-info")} == {"hawk", shared}
    beside = {name.removeprefix(f"{shared}/data/share/").split("/")[0] for name in wheel.namelist() if shared in name}
    assert beside == {"man", "bash-completion", "zsh"}
    assert not [name for name in wheel.namelist() if name.startswith("hawk/web/page/") or name.endswith(".pyc")]


def test_the_wheel_installs_both_commands(wheel: zipfile.ZipFile) -> None:
    (name,) = [name for name in wheel.namelist() if name.endswith(".dist-info/entry_points.txt")]
    commands = configparser.ConfigParser()
    commands.read_string(wheel.read(name).decode())
    assert dict(commands["console_scripts"]) == {"hawk-drone": "hawk.cli:main", "hawk-sim": "hawk.sim.cli:main"}


def test_the_service_is_watched_started_again_at_once_and_never_simulated() -> None:
    unit = configparser.RawConfigParser(strict=False)
    unit.optionxform = str  # type: ignore[assignment, method-assign]
    unit.read_string(UNIT.read_text())
    service = unit["Service"]
    assert service["Type"] == "notify"
    assert service["Restart"] == "always"
    assert service["RestartSec"] == "0"
    assert unit["Unit"]["StartLimitIntervalSec"] == "0"
    assert service["WatchdogSignal"] == "SIGKILL"
    assert float(service["WatchdogSec"]) <= 3
    assert service["ExecStart"].split()[0] == COMMAND
    assert "--sim" not in UNIT.read_text()


def test_the_package_s_hooks_stop_no_daemon_and_its_word_outlives_it() -> None:
    """They run as root (+); one that fails, or is not there without the package, has no effect (-)."""
    unit = configparser.RawConfigParser(strict=False)
    unit.optionxform = str  # type: ignore[assignment, method-assign]
    unit.read_string(UNIT.read_text())
    service = unit["Service"]
    assert service["ExecStartPost"] == "-+/usr/lib/hawk-drone/service-hook ready"
    assert service["ExecStopPost"] == "-+/usr/lib/hawk-drone/service-hook ended"
    assert (service["RuntimeDirectory"], service["RuntimeDirectoryPreserve"]) == (RUNTIME_FOLDER.name, "yes")


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd-analyze is not installed")
@pytest.mark.parametrize("name", sorted(EXPOSURE))
def test_each_service_is_confined(name: str) -> None:
    command = ["systemd-analyze", "security", "--offline=yes", "--no-pager", str(UNIT.with_name(name))]
    analyzed = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True).stdout
    found = re.search(r"Overall exposure level for \S+: ([\d.]+)", analyzed)
    assert found is not None, analyzed
    assert float(found.group(1)) <= EXPOSURE[name], analyzed


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd-analyze is not installed")
@pytest.mark.parametrize("name", sorted(EXPOSURE))
def test_each_service_is_understood_by_systemd(tmp_path: Path, name: str) -> None:
    unit = tmp_path / name
    text = UNIT.with_name(name).read_text().replace("/usr/lib/hawk-drone/service-hook", sys.executable)
    text = re.sub(r"/opt/[\w/-]+/bin/hawk-drone", sys.executable, text)
    unit.write_text(text)  # it verifies that the commands are there
    verified = subprocess.run(
        ["systemd-analyze", "verify", "--man=no", str(unit)], capture_output=True, text=True, timeout=60, check=False
    )
    assert (verified.returncode, verified.stdout + verified.stderr) == (0, "")


def _of_the_page(path: Path) -> bool:
    return path.is_relative_to(ROOT / "hawk" / "web" / "page")
