"""A release is built from a clean tree at its own tag only, with checksums and a signature that hold."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import tempfile
import tomllib
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.unit.docs.scripts import load

release = load("release")
ROOT = Path(__file__).parents[3]
PERSON = {f"GIT_{role}_{what}": "test@localhost" for role in ("AUTHOR", "COMMITTER") for what in ("NAME", "EMAIL")}


def git(root: Path, *arguments: str) -> None:
    environment = {**os.environ, **PERSON, "GIT_CONFIG_GLOBAL": os.devnull}
    subprocess.run(["git", *arguments], cwd=root, check=True, capture_output=True, env=environment)


@pytest.fixture
def project(tmp_path: Path) -> Path:
    root = tmp_path / "project"
    root.mkdir()
    (root / "pyproject.toml").write_text('[project]\nname = "hawk-drone"\nversion = "1.4.0"\n')
    (root / "CHANGELOG.md").write_text("# Changelog\n\n## Unreleased\n\n## 1.4.0 - 2026-05-01\n")
    (root / ".gitignore").write_text("/dist/\n")
    (root / "Makefile").write_text("docs:\n")
    git(root, "init", "--quiet")
    git(root, "add", ".")
    git(root, "commit", "--quiet", "--message", "first")
    git(root, "tag", "v1.4.0")
    return root


def build(_: Path, target: Path, leave_out: str = "") -> None:
    """Stand for the build: a wheel with what it must carry, and a source archive."""
    with zipfile.ZipFile(target / "hawk_drone-1.4.0-py3-none-any.whl", "w") as wheel:
        for name in release.IN_THE_WHEEL:
            if name != leave_out:
                wheel.writestr(name, name)
    (target / "hawk_drone-1.4.0.tar.gz").write_bytes(b"source")


def test_the_files_have_checksums_that_hold(project: Path) -> None:
    made = release.release(project, None, build)
    assert [path.name for path in made] == [
        "SHA256SUMS",
        "hawk_drone-1.4.0-py3-none-any.whl",
        "hawk_drone-1.4.0.tar.gz",
    ]
    folder = project / "dist" / "1.4.0"
    check = ["sha256sum", "--check", "--strict", "SHA256SUMS"]
    assert subprocess.run(check, cwd=folder, check=False, capture_output=True).returncode == 0
    (folder / "hawk_drone-1.4.0.tar.gz").write_bytes(b"another")
    assert subprocess.run(check, cwd=folder, check=False, capture_output=True).returncode == 1


def test_a_tree_with_changes_is_refused(project: Path) -> None:
    (project / "new.py").write_text("")
    with pytest.raises(release.ReleaseError, match=r"commit or remove new\.py"):
        release.release(project, None, build)
    assert not (project / "dist").exists()


@pytest.mark.parametrize(
    ("tags", "words"),
    [([], "has no tag"), (["v1.3.9"], "is tagged v1.3.9"), (["v1.4.0", "v1.5.0"], "is tagged v1.4.0, v1.5.0")],
)
def test_a_tag_that_is_not_the_version_is_refused(project: Path, tags: list[str], words: str) -> None:
    git(project, "tag", "--delete", "v1.4.0")
    for tag in tags:
        git(project, "tag", tag)
    with pytest.raises(release.ReleaseError, match=f"{words}: tag it v1.4.0"):
        release.release(project, None, build)


def test_a_version_without_a_section_in_the_change_log_is_refused(project: Path) -> None:
    (project / "CHANGELOG.md").write_text("# Changelog\n\n## 1.4.01\n")
    git(project, "commit", "--all", "--quiet", "--message", "second")
    git(project, "tag", "--force", "v1.4.0")
    with pytest.raises(release.ReleaseError, match=r"has no section 1\.4\.0"):
        release.release(project, None, build)


@pytest.mark.parametrize("name", release.IN_THE_WHEEL)
def test_a_wheel_that_lacks_a_part_is_refused(project: Path, name: str) -> None:
    with pytest.raises(release.ReleaseError, match=f"lacks {name}"):
        release.release(project, None, lambda root, target: build(root, target, leave_out=name))


def test_a_build_of_another_version_is_refused(project: Path) -> None:
    with pytest.raises(release.ReleaseError, match="no wheel and source archive"):
        release.release(project, None, lambda _, target: (target / "hawk_drone-1.3.9.tar.gz").touch())


def test_an_earlier_build_is_not_mixed_in(project: Path) -> None:
    release.release(project, None, build)
    with pytest.raises(release.ReleaseError, match=r"dist/1\.4\.0 is there already"):
        release.release(project, None, build)


@pytest.mark.parametrize("left", ["hawk-drone_1.4.0+deb12_arm64.deb", "hawk-drone_1.3.9+deb12_arm64.deb"])
def test_the_debian_package_of_this_version_belongs_to_it(
    project: Path, monkeypatch: pytest.MonkeyPatch, left: str
) -> None:
    (project / "Makefile").write_text(f"deb:\n\ttouch dist/{left}\n")
    git(project, "commit", "--all", "--quiet", "--message", "packages")
    git(project, "tag", "--force", "v1.4.0")
    run = release._run

    def hatchling_is_fast(folder: Path, command: list[str], environment: dict[str, str] | None = None) -> None:
        if "hatchling" in command:
            build(folder, Path(command[-1]))
        else:
            run(folder, command, environment)

    monkeypatch.setattr(release, "_run", hatchling_is_fast)
    if "1.4.0" in left:
        assert left in {path.name for path in release.release(project, None, release.build_packages)}
        assert left in (project / "dist" / "1.4.0" / "SHA256SUMS").read_text()
    else:
        with pytest.raises(release.ReleaseError, match=r"left no package of 1\.4\.0"):
            release.release(project, None, release.build_packages)


# -- the signature ----------------------------------------------------------------------------------------------------


@pytest.fixture
def key(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """A key of its own, in a home of its own: the agent's socket needs a short path."""
    home = tempfile.mkdtemp(prefix="gpg-")
    monkeypatch.setenv("GNUPGHOME", home)
    make = ["gpg", "--batch", "--quiet", "--passphrase", "", "--quick-generate-key", "hawk test", "ed25519", "sign"]
    subprocess.run(make, check=True, capture_output=True, timeout=60)
    yield "hawk test"
    subprocess.run(["gpgconf", "--kill", "all"], check=False, capture_output=True)
    shutil.rmtree(home, ignore_errors=True)


@pytest.mark.skipif(shutil.which("gpg") is None, reason="GnuPG is not installed")
def test_the_signature_is_that_of_the_checksums(project: Path, key: str) -> None:
    made = release.release(project, key, build)
    sums, signature = (project / "dist" / "1.4.0" / name for name in ("SHA256SUMS", "SHA256SUMS.asc"))
    assert {sums, signature} <= set(made)
    verify = ["gpg", "--batch", "--verify", str(signature), str(sums)]
    assert subprocess.run(verify, check=False, capture_output=True).returncode == 0
    assert ".asc" not in sums.read_text()
    sums.write_text(sums.read_text().replace("0", "1"))
    assert subprocess.run(verify, check=False, capture_output=True).returncode == 1


@pytest.mark.skipif(shutil.which("gpg") is None, reason="GnuPG is not installed")
def test_a_key_that_is_not_there_is_an_error(project: Path, key: str) -> None:
    with pytest.raises(release.ReleaseError, match="gpg"):
        release.release(project, "somebody else", build)


def test_without_a_word_about_the_signature_nothing_is_built(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        release.main([])
    assert "--sign --unsigned" in capsys.readouterr().err


def test_the_workflow_calls_the_command_and_names_its_secret() -> None:
    workflow = (ROOT / ".github" / "workflows" / "release.yml").read_text(encoding="utf-8")
    assert 'packaging/release.py --sign "$key"' in workflow
    assert "secrets.RELEASE_KEY" in workflow
    assert "RELEASE_KEY" in (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_version_is_the_same_wherever_it_stands() -> None:
    def text(name: str) -> str:
        return (ROOT / name).read_text(encoding="utf-8")

    version = tomllib.loads(text("pyproject.toml"))["project"]["version"]
    locked = [each for each in tomllib.loads(text("uv.lock"))["package"] if each["name"] == "hawk-drone"]
    assert [each["version"] for each in locked] == [version]
    page, page_lock = (json.loads(text(f"hawk/web/page/{name}.json")) for name in ("package", "package-lock"))
    assert [page["version"], page_lock["version"], page_lock["packages"][""]["version"]] == [version] * 3
    examples = json.loads(text("docs/examples/messages.json"))["fromDrone"]
    assert [each["Version"] for each in examples if each["Type"] == "Welcome"] == [version]
