"""A package's life in a clean Debian root without a network: installed, started, upgraded, gone back, removed, purged.

One root and one life: the tests go on where the one before them ended, so they run in their order and stop at the first
that fails. There is no systemd here (`test_systemd.py`); a holder of the daemon's file stands for an armed drone.
"""

from __future__ import annotations

import json
import stat
import subprocess
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from hawk.versions.flight_state import FlightStateFile, read_flight_state
from proving.bare_root import CLEAN
from tests.package.clean_root import CleanRoot

CONFIG = "/etc/hawk/config.toml"
STORE = "/var/lib/hawk"
RUN = "/run/hawk"
AS_HAWK = ("runuser", "-u", "hawk", "--")
READY_S = 300.0
"""Real seconds for a daemon on a busy machine."""
EVERY_MODULE = """
import importlib, pkgutil, sys
import hawk
for found in pkgutil.walk_packages(hawk.__path__, "hawk."):
    importlib.import_module(found.name)
print(len([name for name in sys.modules if name.startswith("hawk.")]))
"""

pytestmark = pytest.mark.timeout(1800)


@pytest.fixture(autouse=True, scope="module")
def stop_at_the_first(request: pytest.FixtureRequest) -> None:
    request.session.config.option.maxfail = request.session.testsfailed + 1


@pytest.fixture(scope="module")
def root(clean_root: CleanRoot) -> CleanRoot:
    clean_root.path(RUN).mkdir(parents=True)
    return clean_root


@contextmanager
def flying(root: CleanRoot) -> Iterator[None]:
    """Hold the daemon's file as one does whose drone is armed; it has landed afterwards."""
    file, landed = FlightStateFile(root.path(RUN)), threading.Event()

    def fly() -> None:
        while not landed.wait(0.1):
            file.write(may_fly=True)

    file.write(may_fly=True)
    assert read_flight_state(root.path(RUN)).is_held
    pilot = threading.Thread(target=fly)
    pilot.start()
    try:
        yield
    finally:
        landed.set()
        pilot.join()
        file.write(may_fly=False)
        file.close()


def in_force(root: CleanRoot) -> str:
    """Return the version of the package whose program runs."""
    version = root.path("/opt/hawk/current").readlink().name.removeprefix("venv-")
    assert root.run("hawk-drone", "--version").split()[-1] == version.partition("+")[0]
    return version


def status(root: CleanRoot) -> tuple[str, str]:
    """Return what dpkg says of the package: its version and its state."""
    words = root.run("dpkg-query", "--show", "--showformat=${Version} ${db:Status-Status}", "hawk-drone").split()
    return words[0], words[1]


def owner(root: CleanRoot, name: str) -> str:
    return root.run("stat", "--format=%U:%G %a", name).strip()


def test_it_is_installed_without_a_network(root: CleanRoot, package_before: Path, before: str) -> None:
    root.run("dpkg", "--install", root.bring(package_before))
    assert status(root) == (before, "installed")
    assert in_force(root) == before
    assert owner(root, STORE) == "hawk:hawk 750"
    assert owner(root, CONFIG) == "root:hawk 640"
    assert owner(root, "/etc/hawk") == "root:hawk 750"
    assert {"video", "dialout"} <= set(root.run("id", "--name", "--groups", "hawk").split())
    assert root.run("systemctl", "is-enabled", "hawk-drone", fails=True).strip() == "disabled"


def test_every_library_finds_what_it_needs_and_every_module_is_there(root: CleanRoot, python: str) -> None:
    """A library of a wheel's own folder finds those beside it by the path of the one that asks for it."""
    beside = f"$(ls -d /opt/hawk/current/lib/{python}/site-packages/*.libs | tr '\\n' ':')"
    look = "find /opt/hawk/current/ -name '*.so*' -exec ldd '{}' + 2>/dev/null | grep 'not found' | sort -u; true"
    assert root.run("sh", "-c", f"LD_LIBRARY_PATH={beside}; export LD_LIBRARY_PATH; {look}") == ""
    modules = int(root.run("/opt/hawk/current/bin/python", "-c", EVERY_MODULE).splitlines()[-1])
    assert modules > 200


def test_modules_are_compiled_since_a_daemon_cannot_write_them(root: CleanRoot, before: str, python: str) -> None:
    packages = root.path(f"/opt/hawk/lib/venv-{before}/lib/{python}/site-packages")
    sources = [path for name in ("hawk", "aiohttp", "numpy") for path in (packages / name).rglob("*.py")]
    tag = f"cpython-{python.removeprefix('python').replace('.', '')}"
    without = [path for path in sources if not (path.parent / "__pycache__" / f"{path.stem}.{tag}.pyc").exists()]
    assert without == []
    assert not list(root.path("/usr/lib/hawk-drone").rglob("__pycache__"))


def test_check_runs_a_frame_through_the_network_for_stalls(root: CleanRoot) -> None:
    """There is neither a camera nor an autopilot here, so the whole has not passed."""
    options = ("--config", CONFIG, "--store", STORE, "--json")
    printed = root.run(*AS_HAWK, "hawk-drone", "check", *options, fails=True)
    checks = {check["name"]: check for check in json.loads(printed[printed.index("{") :])["checks"]}
    assert checks["Configuration"]["outcome"] == "passed"
    assert checks["Model"]["outcome"] in ("passed", "warning"), checks["Model"]  # a warning: a busy machine is slow
    assert checks["Store"]["outcome"] in ("passed", "warning"), checks["Store"]


def test_the_daemon_starts_as_its_user_and_says_that_nothing_flies(root: CleanRoot, before: str) -> None:
    root.run("chown", "hawk:hawk", RUN)
    ready = f"{STORE}/ready"
    settings = (f"RUNTIME_DIRECTORY={RUN}", f"HAWK_STORE__DIRECTORY={STORE}", "HAWK_WATCHDOG__ENABLED=false")
    command = root.command(*AS_HAWK, "env", *settings, "hawk-drone", "--config", CONFIG, "--ready-file", ready)
    daemon = subprocess.Popen(command, env=CLEAN, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    try:
        until = time.monotonic() + READY_S
        while not root.path(ready).exists() and daemon.poll() is None and time.monotonic() < until:
            time.sleep(0.2)
        assert root.path(ready).exists(), daemon.communicate(timeout=5)[0] if daemon.poll() is not None else "not ready"
        listed = root.run("hawk-drone", "versions")
        assert read_flight_state(root.path(RUN)).is_held
        assert listed.splitlines() == [f"{before}  in force, was never ready", "A version may be switched now."]
    finally:
        daemon.kill()  # its process space ends with it
        daemon.communicate(timeout=60)
    assert not read_flight_state(root.path(RUN)).is_held
    root.run("/usr/lib/hawk-drone/service-hook", "ready")


def test_an_armed_drone_refuses_the_upgrade_before_a_file_is_replaced(
    root: CleanRoot, package: Path, before: str
) -> None:
    file = root.bring(package)
    with flying(root):
        printed = root.run("dpkg", "--install", file, fails=True)
    assert "The drone is armed" in printed
    assert "nothing was changed; run the same command again then" in printed
    assert status(root) == (before, "installed")
    assert in_force(root) == before


def test_a_drone_that_is_armed_meanwhile_keeps_its_version_whole(
    root: CleanRoot, package: Path, version: str, before: str
) -> None:
    """The package's files are of the new version already, and the daemon that flies still loads modules of the old."""
    root.path(CONFIG).write_text(
        root.path(CONFIG).read_text().replace("set_rtl_altitude = true", "set_rtl_altitude = false")
    )
    root.path(f"{STORE}/survey").write_text("a survey")
    root.run("dpkg", "--unpack", f"/root/{package.name}")
    with flying(root):
        printed = root.run("dpkg", "--configure", "hawk-drone", fails=True)
        assert (
            f"version {version} is unpacked and not in force; put it in force then by: dpkg --configure -a" in printed
        )
        assert in_force(root) == before
        root.run("/opt/hawk/current/bin/python", "-c", EVERY_MODULE)
    root.run("dpkg", "--configure", "-a")
    assert status(root) == (version, "installed")
    assert in_force(root) == version


def test_settings_and_surveys_stay_at_the_upgrade(root: CleanRoot) -> None:
    assert "set_rtl_altitude = false" in root.path(CONFIG).read_text()
    assert owner(root, CONFIG) == "root:hawk 640"
    assert root.path(f"{STORE}/survey").read_text() == "a survey"


def test_both_versions_are_kept_and_take_the_space_of_their_files_once(
    root: CleanRoot, version: str, before: str, python: str
) -> None:
    listed = root.run("hawk-drone", "versions").splitlines()
    assert listed[:2] == [f"{before}  previous", f"{version}  in force, was never ready"]
    command = f"opt/hawk/lib/venv-{{}}/lib/{python}/site-packages/cv2/cv2.abi3.so"
    assert (root.folder / command.format(version)).stat().st_nlink == 2
    assert (root.folder / command.format(before)).stat().st_nlink == 1  # dpkg removed its own name of it


def test_rollback_is_refused_while_armed_and_then_goes_back_and_forward(
    root: CleanRoot, version: str, before: str
) -> None:
    with flying(root):
        assert "Land it, disarm it" in root.run("hawk-drone", "rollback", fails=True)
    assert in_force(root) == version
    assert f"Version {before} is in force." in root.run("hawk-drone", "rollback")
    assert in_force(root) == before
    assert "no version is kept that was in force before" in root.run("hawk-drone", "rollback", fails=True)
    root.run("hawk-drone", "rollback", version)
    assert in_force(root) == version


def test_a_person_who_is_not_root_may_not_go_back(root: CleanRoot, version: str) -> None:
    assert "sudo hawk-drone rollback" in root.run(*AS_HAWK, "hawk-drone", "rollback", fails=True)
    assert in_force(root) == version


def test_three_failed_starts_go_back_by_themselves(root: CleanRoot, version: str, before: str) -> None:
    ended = ("/usr/lib/hawk-drone/service-hook", "ended")
    for _ in range(2):
        root.run(*ended, environment={"SERVICE_RESULT": "exit-code"})
    assert in_force(root) == version
    assert f"version {before} is in force again" in root.run(*ended, environment={"SERVICE_RESULT": "exit-code"})
    assert in_force(root) == before
    for _ in range(5):  # this one was ready: it stays
        root.run(*ended, environment={"SERVICE_RESULT": "watchdog"})
    assert in_force(root) == before


def test_an_armed_drone_is_not_removed(root: CleanRoot, version: str) -> None:
    with flying(root):
        assert "nothing was removed" in root.run("dpkg", "--remove", "hawk-drone", fails=True)
    assert status(root) == (version, "installed")


def test_after_its_removal_settings_and_surveys_are_all_that_is_left(root: CleanRoot) -> None:
    root.run("dpkg", "--remove", "hawk-drone")
    for gone in ("/opt/hawk", "/usr/lib/hawk-drone", "/usr/bin/hawk-drone"):
        assert not root.path(gone).exists(), gone
    assert "set_rtl_altitude = false" in root.path(CONFIG).read_text()
    assert root.path(f"{STORE}/survey").read_text() == "a survey"


def test_a_purge_takes_settings_and_secrets_and_leaves_surveys(root: CleanRoot) -> None:
    root.path(f"{STORE}/web-tokens.json").write_text("{}")
    printed = root.run("dpkg", "--purge", "hawk-drone")
    assert f"surveys and recordings stay in {STORE}" in printed
    assert not root.path("/etc/hawk").exists()
    assert not root.path(f"{STORE}/web-tokens.json").exists()
    assert root.path(f"{STORE}/survey").read_text() == "a survey"
    assert stat.S_IMODE(root.path(STORE).stat().st_mode) == 0o750
