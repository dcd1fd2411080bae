from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from hawk.versions.folder import VersionError, Versions
from tests.unit.versions.package import PYTHON, make_package


def put(versions: Versions, tmp_path: Path, version: str, previous: str | None = None) -> None:
    package = make_package(tmp_path / f"package-{version}", version)
    versions.put(versions.prepare(package, version), version)
    versions.switch(version, previous)


def test_a_version_is_linked_to_the_package_s_files_with_its_interpreter_and_compiled_modules(tmp_path: Path) -> None:
    versions = Versions(tmp_path / "hawk")
    put(versions, tmp_path, "0.3.0")
    folder = versions.folder("0.3.0")
    module = folder / "lib" / PYTHON.name / "site-packages" / "hawk" / "__init__.py"
    assert module.samefile(tmp_path / "package-0.3.0" / module.relative_to(folder))
    assert list(module.parent.glob("__pycache__/*.pyc"))
    for name in ("python", "python3", PYTHON.name):
        assert Path(os.readlink(folder / "bin" / name)) == PYTHON
    assert not list((tmp_path / "package-0.3.0").rglob("*.pyc"))  # dpkg would not know of them
    assert versions.current == "0.3.0"
    assert (versions.root / "current" / "bin" / "hawk-drone").read_text() == "0.3.0"


def test_compiled_modules_name_the_path_at_which_they_run(tmp_path: Path) -> None:
    versions = Versions(tmp_path / "hawk")
    put(versions, tmp_path, "0.3.0")
    (compiled,) = versions.folder("0.3.0").rglob("hawk/__pycache__/__init__.*.pyc")
    assert str(versions.folder("0.3.0")).encode() in compiled.read_bytes()


def test_modules_are_compiled_by_the_python_that_runs_them(tmp_path: Path) -> None:
    versions = Versions(tmp_path / "hawk")
    put(versions, tmp_path, "0.3.0")
    (compiled,) = versions.folder("0.3.0").rglob("hawk/__pycache__/__init__.*.pyc")
    assert compiled.suffixes == [f".cpython-{PYTHON.name.removeprefix('python').replace('.', '')}", ".pyc"]


def test_a_module_that_cannot_be_compiled_stops_nothing(tmp_path: Path) -> None:
    package = make_package(tmp_path / "package", "0.3.0")
    (package / "lib" / PYTHON.name / "site-packages" / "hawk" / "template.py").write_text("{{ name }} =")
    versions = Versions(tmp_path / "hawk")
    versions.put(versions.prepare(package, "0.3.0"), "0.3.0")
    assert versions.kept == ["0.3.0"]


@pytest.mark.parametrize(
    ("settings", "fault"),
    [
        ("executable = /usr/bin/python3.99\n", r"/usr/bin/python3\.99 is missing; run: apt-get install python3\.99"),
        ("executable = /tmp/python3.11\n", "names no Python of Debian"),
        ("home = /usr/bin\n", "names no Python of Debian"),
    ],
)
def test_a_package_for_a_python_that_is_not_there_is_not_prepared(tmp_path: Path, settings: str, fault: str) -> None:
    versions = Versions(tmp_path / "hawk")
    put(versions, tmp_path, "0.3.0")
    package = make_package(tmp_path / "package", "0.4.0")
    (package / "pyvenv.cfg").write_text(settings)
    with pytest.raises(VersionError, match=fault):
        versions.prepare(package, "0.4.0")
    assert {path.name for path in (versions.root / "lib").iterdir()} == {"venv-0.3.0"}


def test_the_files_of_a_replaced_package_live_on(tmp_path: Path) -> None:
    """As dpkg does it: the new file is written aside and renamed over the old one."""
    versions = Versions(tmp_path / "hawk")
    put(versions, tmp_path, "0.3.0")
    started = tmp_path / "package-0.3.0" / "bin" / "hawk-drone"
    fresh = started.with_name("hawk-drone.dpkg-new")
    fresh.write_text("0.4.0")
    fresh.rename(started)
    assert (versions.folder("0.3.0") / "bin" / "hawk-drone").read_text() == "0.3.0"


def test_on_another_file_system_files_are_copied(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_paths: object) -> None:
        raise OSError(errno.EXDEV, "Invalid cross-device link")

    monkeypatch.setattr("hawk.versions.folder.os.link", refuse)
    versions = Versions(tmp_path / "hawk")
    put(versions, tmp_path, "0.3.0")
    copied = versions.folder("0.3.0") / "bin" / "hawk-drone"
    assert not copied.samefile(tmp_path / "package-0.3.0" / "bin" / "hawk-drone")
    assert os.access(copied, os.X_OK)


def test_a_full_disk_leaves_the_version_in_force(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    versions = Versions(tmp_path / "hawk")
    put(versions, tmp_path, "0.3.0")

    def refuse(*_paths: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("hawk.versions.folder.os.link", refuse)
    with pytest.raises(OSError, match="No space left"):
        put(versions, tmp_path, "0.4.0", "0.3.0")
    assert (versions.current, versions.kept) == ("0.3.0", ["0.3.0"])


@pytest.mark.slow
def test_a_version_that_was_cut_off_while_it_was_prepared_is_not_kept_and_prepared_again(tmp_path: Path) -> None:
    versions = Versions(tmp_path / "hawk")
    package = make_package(tmp_path / "package", "0.3.0")
    versions.prepare(package, "0.3.0")  # the power went
    assert versions.kept == []
    versions.put(versions.prepare(package, "0.3.0"), "0.3.0")
    assert versions.kept == ["0.3.0"]


@pytest.mark.slow
def test_only_the_version_in_force_and_the_one_before_are_kept(tmp_path: Path) -> None:
    versions = Versions(tmp_path / "hawk")
    put(versions, tmp_path, "0.1.0")
    put(versions, tmp_path, "0.2.0", "0.1.0")
    put(versions, tmp_path, "0.3.0", "0.2.0")
    (versions.root / "lib" / ".new-0.4.0").mkdir()
    assert versions.prune() == ["0.1.0"]
    assert versions.kept == ["0.2.0", "0.3.0"]
    assert {path.name for path in (versions.root / "lib").iterdir()} == {"venv-0.2.0", "venv-0.3.0"}


def test_a_version_that_is_not_there_is_not_switched_to(tmp_path: Path) -> None:
    versions = Versions(tmp_path / "hawk")
    put(versions, tmp_path, "0.3.0")
    with pytest.raises(VersionError, match=r"0\.9\.0 is not kept; kept: 0\.3\.0"):
        versions.switch("0.9.0", None)
    assert versions.current == "0.3.0"


@pytest.mark.parametrize("name", ["", "../../etc", "0.3.0/../x", "-1", ".new-0.3.0"])
def test_a_name_that_leads_elsewhere_is_no_version(tmp_path: Path, name: str) -> None:
    with pytest.raises(VersionError, match="is no version"):
        Versions(tmp_path).folder(name)


def test_a_link_that_leads_elsewhere_names_no_version(tmp_path: Path) -> None:
    versions = Versions(tmp_path)
    (tmp_path / "current").symlink_to("/usr")
    assert versions.current is None


def test_failed_starts_are_counted_until_the_version_was_ready(tmp_path: Path) -> None:
    versions = Versions(tmp_path / "hawk")
    put(versions, tmp_path, "0.3.0")
    assert [versions.note_failed_start("0.3.0") for _ in range(2)] == [1, 2]
    (versions.folder("0.3.0") / ".failed-starts").write_text("")  # the power went
    assert versions.note_failed_start("0.3.0") == 1
    versions.note_failed("0.3.0")
    assert versions.has_failed("0.3.0")
    assert not versions.was_ready("0.3.0")
    versions.note_ready("0.3.0")
    assert versions.was_ready("0.3.0")
    assert not versions.has_failed("0.3.0")


@pytest.mark.slow
def test_a_version_that_is_installed_again_begins_again(tmp_path: Path) -> None:
    versions = Versions(tmp_path / "hawk")
    put(versions, tmp_path, "0.3.0")
    versions.note_failed("0.3.0")
    versions.put(versions.prepare(tmp_path / "package-0.3.0", "0.3.0"), "0.3.0")
    assert not versions.has_failed("0.3.0")
    assert versions.current == "0.3.0"
