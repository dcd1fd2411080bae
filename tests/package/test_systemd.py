"""The unit under a systemd that runs: started, hardened, restarted by an upgrade, and gone back from a bad version.

One boot and one life: the tests go on where the one before them ended, in their order.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from hawk.versions.flight_state import read_flight_state
from tests.package.clean_root import CleanRoot
from tests.package.systemd_root import NoSystemdError, SystemdRoot, booted

pytestmark = pytest.mark.timeout(1800)

UNIT = "hawk-drone"
STORE = "/var/lib/hawk"
WAIT_S = 300.0
"""Real seconds, on a busy machine."""


@pytest.fixture(scope="module")
def system(clean_root: CleanRoot) -> Iterator[SystemdRoot]:
    try:
        with booted(clean_root) as system:
            yield system
    except NoSystemdError as error:
        pytest.skip(f"no systemd runs here: {error}")


def process(system: SystemdRoot) -> int:
    return int(system.shown("MainPID"))


def executable(system: SystemdRoot) -> str:
    return system.run("cat", f"/proc/{process(system)}/cmdline").split("\0")[0]


def command_of(version: str, python: str) -> str:
    return f"/opt/hawk/lib/venv-{version}/bin/{python}"


def signal(system: SystemdRoot, name: str) -> None:
    system.run("systemctl", "kill", "--kill-whom=main", f"--signal={name}", UNIT)


def wait_for(system: SystemdRoot, name: str, value: str) -> None:
    until = time.monotonic() + WAIT_S
    while (found := system.shown(name)) != value:
        journal = system.run("journalctl", "--no-pager", "--lines=30", f"--unit={UNIT}")
        assert time.monotonic() < until, f"{name} is {found}\n{journal}"
        time.sleep(0.5)


def test_it_is_installed_stopped_and_started_by_its_user(
    system: SystemdRoot, package_before: Path, before: str, python: str
) -> None:
    system.run("dpkg", "--install", system.root.bring(package_before))
    assert system.shown("ActiveState") == "inactive"
    system.run("systemctl", "enable", "--now", UNIT)  # it is up when the state machine ticks
    assert system.shown("ActiveState") == "active"
    assert executable(system) == command_of(before, python)
    assert "in force" in system.run("hawk-drone", "versions")
    assert (system.root.path(f"/opt/hawk/lib/venv-{before}") / ".was-ready").exists()


def test_the_hardened_unit_has_its_priority_and_no_capability(system: SystemdRoot) -> None:
    """It is up, so `LOOK` could open the device of its group, and no other one, within its confines."""
    pid = process(system)
    status = dict(
        line.split(":\t", 1) for line in system.run("cat", f"/proc/{pid}/status").splitlines() if ":\t" in line
    )
    assert int(status["CapEff"], 16) == 0
    assert status["Seccomp"].strip() == "2"
    niceness = system.run("cat", f"/proc/{pid}/stat").rpartition(")")[2].split()[16]  # field 19, proc(5)
    assert niceness == "-5"


def test_the_daemon_works_under_the_unit(system: SystemdRoot) -> None:
    """Its page answers, its vision is loaded, and its flight state is that nothing flies."""
    code = "import urllib.request as r; print(r.urlopen('http://127.0.0.1:3000/metrics').read().decode())"
    until = time.monotonic() + WAIT_S
    while "hawk_status_age_seconds" not in (text := system.run("python3", "-c", code)):
        assert time.monotonic() < until, text
        time.sleep(0.5)
    assert "A version may be switched now." in system.run("hawk-drone", "versions")
    assert "SIGSYS" not in system.run("journalctl", "--no-pager", f"--unit={UNIT}")


def test_an_upgrade_restarts_it_with_the_new_version(
    system: SystemdRoot, package: Path, version: str, python: str
) -> None:
    before = process(system)
    system.run("dpkg", "--install", system.root.bring(package))
    assert system.shown("ActiveState") == "active"
    assert process(system) != before
    assert executable(system) == command_of(version, python)


def test_a_rollback_restarts_it_with_the_version_before(
    system: SystemdRoot, version: str, before: str, python: str
) -> None:
    system.run("hawk-drone", "rollback")
    assert executable(system) == command_of(before, python)
    assert system.shown("ActiveState") == "active"


def test_a_daemon_that_runs_and_hangs_counts_as_armed(system: SystemdRoot, version: str) -> None:
    pid = process(system)
    signal(system, "STOP")
    refused = system.run("hawk-drone", "rollback", version, fails=True)
    signal(system, "CONT")
    assert "it counts as armed" in refused
    assert process(system) == pid


def test_a_crash_of_a_version_that_was_ready_starts_the_same_again(
    system: SystemdRoot, before: str, python: str
) -> None:
    """As in the air: five crashes in a row leave the version alone."""
    for _ in range(5):
        ended = process(system)
        signal(system, "KILL")
        until = time.monotonic() + WAIT_S
        while process(system) in (0, ended) or system.shown("ActiveState") != "active":
            assert time.monotonic() < until
            time.sleep(0.2)
    assert executable(system) == command_of(before, python)


def test_a_version_that_never_starts_is_left_by_itself(
    system: SystemdRoot, package: Path, version: str, before: str
) -> None:
    """Installed again, with an interpreter that ends at once before it is ready."""
    system.run("systemctl", "stop", UNIT)
    system.run("dpkg", "--install", f"/root/{package.name}")
    broken = system.root.path(f"/opt/hawk/lib/venv-{version}/bin/hawk-drone")
    broken.unlink()  # a link of the package's file
    broken.write_text("#!/bin/sh\nexit 1\n")
    broken.chmod(0o755)
    system.run("systemctl", "start", "--no-block", UNIT)
    wait_for(system, "ActiveState", "active")
    until = time.monotonic() + WAIT_S
    while not executable(system).startswith(f"/opt/hawk/lib/venv-{before}/"):
        assert time.monotonic() < until
        time.sleep(0.5)
    journal = system.run("journalctl", "--no-pager", f"--unit={UNIT}")
    assert f"version {version} failed to start 3 times; version {before} is in force again" in journal
    assert f"{version}  was never ready, left because it did not start" in system.run("hawk-drone", "versions")


def test_a_removal_stops_it(system: SystemdRoot) -> None:
    system.run("dpkg", "--remove", UNIT)
    assert not system.root.path("/opt/hawk").exists()
    assert system.run("systemctl", "is-active", UNIT, fails=True).strip() in ("inactive", "failed")
    assert not read_flight_state(system.root.path("/run/hawk")).is_held
