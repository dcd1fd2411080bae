from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from hawk import cli
from hawk.versions import commands
from hawk.versions.flight_state import FlightStateFile
from hawk.versions.folder import Versions
from tests.unit.versions.package import make_package

ROOT = Path(__file__).parents[3]


def installed(tmp_path: Path, *versions: str) -> Versions:
    kept = Versions(tmp_path / "hawk")
    for version in versions:
        package = make_package(tmp_path / f"package-{version}", version)
        assert run(tmp_path, "install", str(package), version) == 0
    return kept


def run(tmp_path: Path, *arguments: str) -> int:
    folders = ["--root", str(tmp_path / "hawk"), "--runtime", str(tmp_path / "run")]
    return commands.main([*arguments, *folders])


@pytest.fixture(autouse=True)
def quiet(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("hawk.versions.commands.use_idle_time_only", lambda: None)
    monkeypatch.setattr("hawk.versions.switch.SYSTEMD_FOLDER", tmp_path / "none")
    (tmp_path / "run").mkdir()


def test_versions_are_listed_with_what_is_known_of_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    installed(tmp_path, "0.1.0", "0.2.0")
    assert run(tmp_path, "ready") == 0
    capsys.readouterr()
    assert run(tmp_path, "versions") == 0
    assert capsys.readouterr().out.splitlines() == [
        "0.1.0  previous, was never ready",
        "0.2.0  in force",
        "A version may be switched now.",
    ]


def test_a_version_whose_python_is_gone_is_listed_as_such(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    kept = installed(tmp_path, "0.1.0", "0.2.0")
    (kept.folder("0.1.0") / "bin" / "python").unlink()
    capsys.readouterr()
    assert run(tmp_path, "versions") == 0
    listed = capsys.readouterr().out.splitlines()
    assert listed[0] == "0.1.0  previous, was never ready, its Python is not installed"
    assert listed[1] == "0.2.0  in force, was never ready"


def test_rollback_by_the_command_line_of_the_version_in_force(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    kept = installed(tmp_path, "0.1.0", "0.2.0")
    folders = ["--root", str(tmp_path / "hawk"), "--runtime", str(tmp_path / "run")]
    assert cli.main(["rollback", *folders]) == 0
    assert kept.current == "0.1.0"
    assert capsys.readouterr().out.splitlines()[-1] == (
        "Version 0.1.0 is in force. Version 0.2.0 is kept: hawk-drone rollback 0.2.0 goes forward again."
    )


@pytest.mark.slow
def test_nothing_is_switched_while_a_daemon_says_that_it_flies(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    kept = installed(tmp_path, "0.1.0", "0.2.0")
    file = FlightStateFile(tmp_path / "run")
    file.write(may_fly=True)
    for arguments in (("ground",), ("rollback",), ("install", str(tmp_path / "package-0.1.0"), "0.1.0")):
        assert run(tmp_path, *arguments) == 1
        assert "armed" in capsys.readouterr().err
    assert kept.current == "0.2.0"
    file.write(may_fly=False)
    file.close()
    assert run(tmp_path, "ground") == 0


def test_the_daemon_s_user_may_read_a_version_that_a_careful_root_installed(tmp_path: Path) -> None:
    before = os.umask(0o077)
    try:
        kept = installed(tmp_path, "0.1.0")
    finally:
        os.umask(before)
    made = [kept.root, kept.root / "lib", *kept.folder("0.1.0").rglob("__pycache__")]
    assert len(made) > 2
    assert [path for path in made if path.stat().st_mode & 0o055 != 0o055] == []


def test_without_the_debian_package_the_commands_say_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for command in ("rollback", "versions"):
        assert run(tmp_path, command) == 1
        assert "the Debian package did not install this program" in capsys.readouterr().err


def test_only_root_may_go_back(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    installed(tmp_path, "0.1.0", "0.2.0")
    monkeypatch.setattr("hawk.versions.commands.os.geteuid", lambda: 1000)
    monkeypatch.setattr("hawk.versions.commands.os.access", lambda *_: False)
    assert run(tmp_path, "rollback") == 1
    assert "sudo hawk-drone rollback" in capsys.readouterr().err


def test_a_fault_of_the_disk_names_the_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "hawk").write_text("")  # a file where the folder belongs
    package = make_package(tmp_path / "package", "0.1.0")
    assert run(tmp_path, "install", str(package), "0.1.0") == 1
    assert str(tmp_path / "hawk") in capsys.readouterr().err


@pytest.mark.slow
def test_the_service_s_end_is_judged_by_what_systemd_says_of_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = installed(tmp_path, "0.1.0", "0.2.0")
    monkeypatch.setenv("SERVICE_RESULT", "success")
    for _ in range(3):
        assert run(tmp_path, "ended") == 0
    assert kept.current == "0.2.0"
    monkeypatch.setenv("SERVICE_RESULT", "exit-code")
    for _ in range(3):
        assert run(tmp_path, "ended") == 0
    assert kept.current == "0.1.0"
    assert "version 0.1.0 is in force again" in capsys.readouterr().err


def test_an_upgrade_whose_daemon_does_not_start_is_installed_with_a_warning(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("hawk.versions.switch.systemd_runs", lambda: True)
    monkeypatch.setattr(
        "hawk.versions.switch.subprocess.run",
        lambda command, **_: subprocess.CompletedProcess(command, int("try-restart" in command), "", "Job failed."),
    )
    kept = installed(tmp_path, "0.1.0")
    assert kept.current == "0.1.0"
    assert "warning: `systemctl try-restart hawk-drone.service` failed: Job failed.; see journalctl" in (
        capsys.readouterr().err
    )


def test_an_upgrade_restarts_daemon_and_desk_where_they_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []

    def run_command(command: list[str], **_: object) -> subprocess.CompletedProcess[str]:
        asked.append(" ".join(command))
        return subprocess.CompletedProcess(command, 0, "", "")

    monkeypatch.setattr("hawk.versions.switch.systemd_runs", lambda: True)
    monkeypatch.setattr("hawk.versions.switch.subprocess.run", run_command)
    installed(tmp_path, "0.1.0")
    assert asked[-3:] == [
        "systemctl daemon-reload",
        "systemctl try-restart hawk-drone.service",
        "systemctl try-restart hawk-desk.service",
    ]


def test_debian_s_python_runs_it_without_any_other_package(tmp_path: Path) -> None:
    """As the Debian package starts it: isolated, and without the folder of installed packages."""
    code = f"import sys; sys.path.insert(0, {str(ROOT)!r}); from hawk.versions.commands import main; sys.exit(main())"
    command = [sys.executable, "-I", "-S", "-B", "-c", code, "ground", "--runtime", str(tmp_path / "run")]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False, env=dict(os.environ))
    assert (ended.returncode, ended.stderr) == (0, "")


@pytest.mark.parametrize("hook", ["ready", "ended"])
def test_the_hooks_do_nothing_where_no_version_is_in_force(tmp_path: Path, hook: str) -> None:
    assert run(tmp_path, hook) == 0
