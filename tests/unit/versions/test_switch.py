from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from hawk.versions.folder import VersionError, Versions
from hawk.versions.switch import (
    ARMED,
    FAILED_STARTS,
    Outside,
    Refusal,
    Refused,
    install,
    note_end,
    note_ready,
    roll_back,
)
from tests.unit.versions.package import make_package

Install = Callable[[str], list[str]]


class Events:
    """A machine whose drone is on the ground unless `refusal` says otherwise."""

    def __init__(self) -> None:
        self.restarts = 0
        self.refusal: Refusal | None = None
        self.outside = Outside(look=lambda: self.refusal, restart=self._restart)

    def _restart(self) -> None:
        self.restarts += 1


@pytest.fixture
def versions(tmp_path: Path) -> Versions:
    return Versions(tmp_path / "hawk")


@pytest.fixture
def events() -> Events:
    return Events()


@pytest.fixture
def put(versions: Versions, events: Events, tmp_path: Path) -> Install:
    def do(version: str) -> list[str]:
        package = tmp_path / f"package-{version}"
        if not package.exists():
            make_package(package, version)
        return install(versions, package, version, events.outside)

    return do


def state(versions: Versions) -> tuple[str | None, str | None, list[str]]:
    return versions.current, versions.previous, versions.kept


def fail(versions: Versions, times: int, result: str = "exit-code") -> list[str | None]:
    return [note_end(versions, result) for _ in range(times)]


# -- upgrades ---------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_an_upgrade_keeps_the_version_before_and_removes_older_ones(versions: Versions, put: Install) -> None:
    assert put("0.1.0") == []
    assert state(versions) == ("0.1.0", None, ["0.1.0"])
    assert put("0.2.0") == []
    assert state(versions) == ("0.2.0", "0.1.0", ["0.1.0", "0.2.0"])
    assert put("0.3.0") == ["0.1.0"]
    assert state(versions) == ("0.3.0", "0.2.0", ["0.2.0", "0.3.0"])


@pytest.mark.slow
def test_the_same_version_again_keeps_the_one_before(versions: Versions, put: Install) -> None:
    put("0.1.0")
    put("0.2.0")
    put("0.2.0")
    assert state(versions) == ("0.2.0", "0.1.0", ["0.1.0", "0.2.0"])


@pytest.mark.slow
def test_a_downgrade_to_the_kept_version_can_be_gone_back_from(versions: Versions, put: Install) -> None:
    put("0.1.0")
    put("0.2.0")
    put("0.1.0")
    assert state(versions) == ("0.1.0", "0.2.0", ["0.1.0", "0.2.0"])


@pytest.mark.slow
def test_while_armed_an_upgrade_changes_nothing_and_can_be_made_later(
    versions: Versions, put: Install, events: Events
) -> None:
    put("0.1.0")
    events.refusal = ARMED
    with pytest.raises(Refused, match="armed"):
        put("0.2.0")
    assert state(versions) == ("0.1.0", None, ["0.1.0"])
    events.refusal = None
    put("0.2.0")
    assert state(versions) == ("0.2.0", "0.1.0", ["0.1.0", "0.2.0"])


def test_while_armed_the_same_version_is_not_replaced(versions: Versions, put: Install, events: Events) -> None:
    put("0.1.0")
    before = versions.folder("0.1.0").stat().st_ino
    events.refusal = ARMED
    with pytest.raises(Refused):
        put("0.1.0")
    assert versions.folder("0.1.0").stat().st_ino == before


# -- a person goes back -----------------------------------------------------------------------------------------------


def test_rollback_goes_to_the_previous_version_and_starts_it(versions: Versions, put: Install, events: Events) -> None:
    put("0.1.0")
    put("0.2.0")
    assert roll_back(versions, None, events.outside) == "0.1.0"
    assert state(versions) == ("0.1.0", None, ["0.1.0", "0.2.0"])
    assert events.restarts == 1


def test_a_second_rollback_names_the_step_forward(versions: Versions, put: Install, events: Events) -> None:
    put("0.1.0")
    put("0.2.0")
    roll_back(versions, None, events.outside)
    with pytest.raises(VersionError, match=r"go forward by: hawk-drone rollback 0\.2\.0"):
        roll_back(versions, None, events.outside)
    assert roll_back(versions, "0.2.0", events.outside) == "0.2.0"
    assert state(versions) == ("0.2.0", "0.1.0", ["0.1.0", "0.2.0"])


def test_without_another_version_there_is_none_to_go_back_to(versions: Versions, put: Install, events: Events) -> None:
    put("0.1.0")
    with pytest.raises(VersionError, match=r"no version is kept that was in force before 0\.1\.0; install one"):
        roll_back(versions, None, events.outside)


@pytest.mark.parametrize(("wanted", "reason"), [("0.2.0", "in force already"), ("0.9.0", "is not kept")])
def test_a_wanted_version_must_be_another_one_that_is_kept(
    versions: Versions, put: Install, events: Events, wanted: str, reason: str
) -> None:
    put("0.1.0")
    put("0.2.0")
    with pytest.raises(VersionError, match=reason):
        roll_back(versions, wanted, events.outside)


def lose_python(versions: Versions, version: str) -> None:
    """As an upgrade of Debian does: the links of the version lead nowhere."""
    link = versions.folder(version) / "bin" / "python"
    link.unlink()
    link.symlink_to("/usr/bin/python3.0")


def test_a_version_of_another_debian_is_not_gone_back_to(versions: Versions, put: Install, events: Events) -> None:
    put("0.1.0+deb12")
    put("0.1.0+deb13")
    lose_python(versions, "0.1.0+deb12")
    with pytest.raises(VersionError, match="its Python is not installed any more"):
        roll_back(versions, None, events.outside)
    assert versions.current == "0.1.0+deb13"
    assert events.restarts == 0


def test_while_armed_nobody_goes_back(versions: Versions, put: Install, events: Events) -> None:
    put("0.1.0")
    put("0.2.0")
    events.refusal = ARMED
    with pytest.raises(Refused, match="Land it"):
        roll_back(versions, None, events.outside)
    assert versions.current == "0.2.0"
    assert events.restarts == 0


# -- a version that does not start ------------------------------------------------------------------------------------


def test_failed_starts_do_not_go_back_to_a_version_of_another_debian(versions: Versions, put: Install) -> None:
    put("0.1.0+deb12")
    note_ready(versions)
    put("0.1.0+deb13")
    lose_python(versions, "0.1.0+deb12")
    reports = fail(versions, FAILED_STARTS)
    assert reports[-1] == ("version 0.1.0+deb13 failed to start 3 times; no version before it is kept to go back to")
    assert versions.current == "0.1.0+deb13"


def test_three_failed_starts_of_a_new_version_go_back(versions: Versions, put: Install) -> None:
    put("0.1.0")
    note_ready(versions)
    put("0.2.0")
    reports = fail(versions, FAILED_STARTS)
    assert reports[-1] == "version 0.2.0 failed to start 3 times; version 0.1.0 is in force again"
    assert state(versions) == ("0.1.0", None, ["0.1.0", "0.2.0"])
    assert versions.has_failed("0.2.0")


def test_two_failed_starts_do_not(versions: Versions, put: Install) -> None:
    put("0.1.0")
    put("0.2.0")
    assert fail(versions, 2)[-1] == "version 0.2.0 failed to start (exit-code), 2 of 3"
    assert versions.current == "0.2.0"


@pytest.mark.parametrize("result", ["watchdog", "signal", "core-dump", "exit-code", "timeout"])
def test_a_version_that_was_ready_is_never_left_by_itself(versions: Versions, put: Install, result: str) -> None:
    """It may be in the air: a crash there is no failed start."""
    put("0.1.0")
    put("0.2.0")
    fail(versions, 2)
    note_ready(versions)
    assert fail(versions, 10, result) == [None] * 10
    assert versions.current == "0.2.0"


def test_a_version_that_was_ready_in_an_earlier_boot_stays_too(versions: Versions, put: Install) -> None:
    put("0.1.0")
    put("0.2.0")
    note_ready(versions)
    assert fail(Versions(versions.root), 5) == [None] * 5


def test_starts_that_a_person_ended_do_not_count(versions: Versions, put: Install) -> None:
    put("0.1.0")
    put("0.2.0")
    assert fail(versions, 10, "success") == [None] * 10
    assert versions.current == "0.2.0"


def test_two_versions_that_do_not_start_do_not_alternate(versions: Versions, put: Install) -> None:
    put("0.1.0")
    put("0.2.0")
    seen = []
    for _ in range(12):
        note_end(versions, "exit-code")
        seen.append(versions.current)
    assert seen == ["0.2.0"] * 2 + ["0.1.0"] * 10


@pytest.mark.slow
def test_a_version_that_was_left_is_not_gone_back_to_after_the_next_upgrade(versions: Versions, put: Install) -> None:
    put("0.1.0")
    put("0.2.0")
    fail(versions, 3)
    roll_back(versions, "0.2.0", Events().outside)  # a person tries it again
    put("0.3.0")
    assert versions.previous == "0.2.0"
    assert fail(versions, 3)[-1] == (
        "version 0.3.0 failed to start 3 times; no version before it is kept to go back to"
    )
    assert versions.current == "0.3.0"


def test_the_first_version_stays_and_says_so_once(versions: Versions, put: Install) -> None:
    put("0.1.0")
    reports = fail(versions, 6)
    assert [report is not None and "no version before it" in report for report in reports] == [
        False,
        False,
        True,
        False,
        False,
        False,
    ]


def test_an_end_without_any_version_is_nobody_s(versions: Versions) -> None:
    assert note_end(versions, "exit-code") is None
    note_ready(versions)
