"""The lock is the project's and names public hosts only; a tree is copied under a version."""

from __future__ import annotations

import re
import subprocess
import tomllib
from pathlib import Path
from typing import Any

import pytest
from ruamel.yaml import YAML

from tests.unit.packaging.scripts import load

build_deb = load("deb/build_deb")


ROOT = Path(__file__).parents[3]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
LOCK = tomllib.loads((ROOT / "uv.lock").read_text("utf-8"))


def named(requirement: str) -> tuple[str, str]:
    """Return name and bounds of a requirement, as the lock spells them."""
    found = re.match(r"([\w.-]+)(\[\w+\])?(.*)", requirement)
    assert found is not None
    return re.sub(r"[._]", "-", found.group(1)), found.group(3)


def own_package() -> dict[str, Any]:
    packages: list[dict[str, Any]] = LOCK["package"]
    (own,) = [package for package in packages if package["name"] == "hawk-drone"]
    return own


def test_the_lock_was_made_from_the_project_as_it_is() -> None:
    """Else: python -m uv lock."""
    wanted = {named(text) for text in PROJECT["dependencies"]}
    for values in PROJECT["optional-dependencies"].values():
        wanted |= {named(text) for text in values}
    locked = {(each["name"], each.get("specifier", "")) for each in own_package()["metadata"]["requires-dist"]}
    assert locked == wanted
    assert own_package()["version"] == PROJECT["version"]


def test_the_lock_names_public_hosts_and_a_hash_for_every_file() -> None:
    text = (ROOT / "uv.lock").read_text("utf-8")
    assert set(re.findall(r"https?://([^/\"]+)", text)) == build_deb.LOCK_HOSTS
    files = [file for package in LOCK["package"] for file in package.get("wheels", [])]
    assert len(files) > 100
    assert all(file["hash"].startswith("sha256:") for file in files)


def test_every_package_of_the_daemon_has_a_wheel_for_both_processors() -> None:
    by_name: dict[str, list[str]] = {}
    for package in LOCK["package"]:
        urls = [file["url"].rpartition("/")[2] for file in package.get("wheels", [])]
        by_name.setdefault(package["name"], []).extend(urls)
    own = own_package()
    extras = [dependency for extra in build_deb.EXTRAS for dependency in own["optional-dependencies"][extra]]
    assert len(extras) == 2
    for name in [dependency["name"] for dependency in (*own["dependencies"], *extras)]:
        for arch, platforms in build_deb.PLATFORMS.items():
            fits = [url for url in by_name[name] if "-none-any" in url or any(p in url for p in platforms)]
            assert fits, f"{name}: no wheel for {arch}"


def test_debian_s_changelog_is_of_the_project_s_version() -> None:
    assert build_deb.project_version(ROOT) == PROJECT["version"]


def test_a_changelog_of_another_version_is_refused(tmp_path: Path) -> None:
    (tmp_path / "debian").mkdir()
    (tmp_path / "pyproject.toml").write_text('[project]\nversion = "0.3.0"\n')
    (tmp_path / "debian" / "changelog").write_text("hawk-drone (0.2.0) unstable; urgency=medium\n")
    with pytest.raises(build_deb.BuildError, match=r"debian/changelog: its first entry must be of version 0\.3\.0"):
        build_deb.project_version(tmp_path)


def test_a_lock_of_a_mirror_is_refused(tmp_path: Path) -> None:
    (tmp_path / "uv.lock").write_text('source = { registry = "https://mirror.example/simple" }\n')
    with pytest.raises(build_deb.BuildError, match=r"names mirror\.example; lock it from https://pypi\.org/simple"):
        build_deb.requirements(tmp_path)


LISTED = """\
numpy==2.4.6 ; python_full_version < '3.12' \\
    --hash=sha256:00 \\
    --hash=sha256:01
numpy==2.5.5 ; python_full_version >= '3.12' \\
    --hash=sha256:02
    # via scipy
colour==1.0 ; sys_platform == 'win32' \\
    --hash=sha256:03
fast==1.0 ; platform_machine == 'aarch64' \\
    --hash=sha256:04
idna==3.20 \\
    --hash=sha256:05
"""


@pytest.mark.parametrize(
    ("release", "arch", "wanted"),
    [
        ("bookworm", "amd64", ["numpy==2.4.6", "idna==3.20"]),
        ("bookworm", "arm64", ["numpy==2.4.6", "fast==1.0", "idna==3.20"]),
        ("trixie", "amd64", ["numpy==2.5.5", "idna==3.20"]),
    ],
)
def test_conditions_are_judged_by_the_release_and_not_by_this_python(
    release: str, arch: str, wanted: list[str]
) -> None:
    listed = build_deb.chosen(LISTED, arch, release)
    assert re.findall(r"^(\S+)", listed, re.MULTILINE) == wanted
    assert ";" not in listed
    if release == "bookworm":
        assert listed.startswith("numpy==2.4.6 \\\n    --hash=sha256:00 \\\n    --hash=sha256:01\n")


def test_a_release_upgrades_the_package_of_the_one_before() -> None:
    """dpkg compares the numbers behind the same text."""
    versions = [build_deb.package_version("0.2.0", release) for release in build_deb.RELEASES]
    assert versions == ["0.2.0+deb12", "0.2.0+deb13"]
    assert [about.python for about in build_deb.RELEASES.values()] == ["3.11", "3.13"]


def test_the_workflow_and_make_deb_build_each_release() -> None:
    releases = list(build_deb.RELEASES)
    workflow = YAML(typ="safe", pure=True).load((ROOT / ".github" / "workflows" / "packages.yml").read_text("utf-8"))
    assert workflow["jobs"]["deb"]["strategy"]["matrix"]["release"] == releases
    makefile = (ROOT / "Makefile").read_text("utf-8")
    assert re.search(r"^RELEASES \?= (.*)$", makefile, re.MULTILINE)[1].split() == releases  # type: ignore[index]


@pytest.mark.parametrize(("release", "abi"), [("bookworm", "cp311"), ("trixie", "cp313")])
def test_wheels_are_of_the_release_s_python(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, release: str, abi: str
) -> None:
    commands: list[list[str]] = []
    monkeypatch.setattr(build_deb, "requirements", lambda _root: LISTED)
    monkeypatch.setattr(build_deb, "run", lambda command, _folder: commands.append(list(command)))
    build_deb.download(tmp_path, "amd64", release, tmp_path / "wheels")
    assert [option for option in commands[0] if option.startswith("--abi=cp")] == [f"--abi={abi}"]
    assert f"--python-version={build_deb.RELEASES[release].python}" in commands[0]
    assert (tmp_path / "wheels" / build_deb.LIST).read_text() == build_deb.chosen(LISTED, "amd64", release)


def test_the_locked_wheels_are_downloaded_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    commands: list[list[str]] = []
    listed = "numpy==2.4.6 --hash=sha256:00\n"
    monkeypatch.setattr(build_deb, "requirements", lambda _root: listed)
    monkeypatch.setattr(build_deb, "run", lambda command, _folder: commands.append(list(command)))
    for _ in range(2):
        build_deb.download(tmp_path, "arm64", "bookworm", tmp_path / "wheels")
    assert len(commands) == 1
    assert {"--require-hashes", "--only-binary=:all:", "--platform=manylinux_2_28_aarch64"} <= set(commands[0])
    assert not [option for option in commands[0] if "x86_64" in option]
    listed = "numpy==2.4.7 --hash=sha256:01\n"
    build_deb.download(tmp_path, "arm64", "bookworm", tmp_path / "wheels")
    assert len(commands) == 2


def make_project(root: Path) -> None:
    (root / "debian").mkdir(parents=True)
    for built in build_deb.BUILT:
        (root / built).mkdir(parents=True)
        (root / built / "index.html").write_text(f"{built.name}")
    (root / "pyproject.toml").write_text('[project]\nname = "hawk-drone"\nversion = "0.2.0"\n')
    (root / "debian" / "changelog").write_text("hawk-drone (0.2.0) unstable; urgency=medium\n")
    (root / "debian" / "unit").symlink_to("../pyproject.toml")
    (root / ".gitignore").write_text("/hawk/web/static/\n/hawk/web/docs_site/\n/build/\n")
    for command in (["init", "--quiet"], ["add", "--all"]):
        subprocess.run(["git", *command], cwd=root, check=True)


def test_a_tree_is_copied_under_another_version_with_what_was_built_and_its_links(tmp_path: Path) -> None:
    root = tmp_path / "project"
    make_project(root)
    (root / "build").mkdir()
    (root / "build" / "left").write_text("")
    tree = build_deb.stage(root, root / "build" / "deb" / "x" / "tree", "0.1.0", "trixie")
    assert 'version = "0.1.0"' in (tree / "pyproject.toml").read_text()
    assert (tree / "debian" / "changelog").read_text().startswith("hawk-drone (0.1.0+deb13) ")
    assert (tree / "debian" / "unit").is_symlink()
    assert [(tree / built / "index.html").read_text() for built in build_deb.BUILT] == ["static", "docs_site"]
    assert not (tree / "build").exists()
    assert 'version = "0.2.0"' in (root / "pyproject.toml").read_text()


@pytest.mark.parametrize("built", build_deb.BUILT, ids=lambda built: built.name)
def test_without_page_or_documentation_no_package_is_built(tmp_path: Path, built: Path) -> None:
    root = tmp_path / "project"
    make_project(root)
    (root / built / "index.html").unlink()
    with pytest.raises(build_deb.BuildError, match=f"{built}: is not built; run: {build_deb.BUILT[built]}"):
        build_deb.stage(root, tmp_path / "work" / "tree", "0.1.0", "trixie")


def test_a_line_that_is_not_there_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("nothing")
    with pytest.raises(build_deb.BuildError, match="has no line that fits"):
        build_deb.replace_once(tmp_path / "file", "version", "x")


def test_a_step_that_fails_is_shown_with_what_it_printed(tmp_path: Path) -> None:
    with pytest.raises(build_deb.BuildError, match=r"failed with status 3:\nno wheel"):
        build_deb.run(["sh", "-c", "echo no wheel; exit 3"], tmp_path)
