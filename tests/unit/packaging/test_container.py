"""The container's image: what its file says fits the program, and the folder that it is built in holds nothing else."""

from __future__ import annotations

import json
import re
import stat
import subprocess
import tomllib
from pathlib import Path
from typing import Any

import pytest

from hawk.config.loader import load_config
from hawk.config.sections import Config, section_fields
from hawk.versions.switch import RUNTIME_FOLDER
from tests.unit.packaging.containerfile import ROOT, Stage, read, words_of
from tests.unit.packaging.scripts import load

build_container = load("container/build_container")
build_deb = load("deb/build_deb")
ARGUMENTS, STAGES = read()
BY_NAME = {stage.name: stage for stage in STAGES}
PROGRAM = BY_NAME["program"]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
STORE = re.search(r"^u hawk - \".*\" (\S+)$", (ROOT / "packaging/systemd/hawk-drone.sysusers").read_text(), re.M)[1]  # type: ignore[index]


def fake_wheels(folder: Path) -> Path:
    folder.mkdir()
    for name in ("aiohttp-3.whl", "hawk_drone-1.whl", "requirements.txt"):
        (folder / name).write_text(name)
    return folder


# -- the file ---------------------------------------------------------------------------------------------------------


def test_the_base_is_named_by_its_digest_and_is_the_debian_of_the_package() -> None:
    assert re.fullmatch(r"docker\.io/library/debian:bookworm-\d{8}-slim@sha256:[0-9a-f]{64}", ARGUMENTS["BASE"])
    assert {stage.base for stage in STAGES} == {"${BASE}", "program"}
    installed = " ".join(PROGRAM.all("RUN")).split()
    assert {f"python{build_deb.RELEASES['bookworm'].python}", "libstdc++6", "openssl"} <= set(installed)


def test_the_last_stage_is_the_plain_one() -> None:
    """An engine builds it when nobody names a target."""
    assert (STAGES[-1].name, STAGES[-1].instructions) == ("drone", [])
    assert set(build_container.SETTINGS) == {stage.name for stage in STAGES} - {"environment", "program"}


@pytest.mark.parametrize("target", list(build_container.SETTINGS))
def test_everything_that_is_copied_is_in_the_folder_and_nothing_else(tmp_path: Path, target: str) -> None:
    folder = build_container.prepare(ROOT, fake_wheels(tmp_path / "wheels"), tmp_path / "context", target)
    copied = [words.split()[0] for stage in STAGES for words in stage.all("COPY") if "--from=" not in words]
    assert sorted(copied) == sorted(path.name for path in folder.iterdir())
    files = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    wheels = {f"wheels/{name}" for name in ("aiohttp-3.whl", "hawk_drone-1.whl", "requirements.txt")}
    assert files == wheels | {"settings/config.toml"}
    assert not any(stage.all("ADD") for stage in STAGES)


def test_python_packages_are_installed_by_their_hashes_without_a_network() -> None:
    (install,) = [line for line in BY_NAME["environment"].all("RUN") if "pip install" in line]
    steps = [step.strip() for step in install.split("&&") if "pip install" in step]
    assert len(steps) == 2
    assert all("--no-index" in step and "--no-deps" in step for step in steps)
    assert "--require-hashes" in steps[0]
    assert "/wheels/hawk_drone-" in steps[1]
    assert "pip check" in install


def test_it_runs_as_a_user_of_its_own_with_the_groups_of_the_unit() -> None:
    assert PROGRAM.all("USER") == ["hawk"]
    others = {stage.name: stage.all("USER")[-1] for stage in STAGES if stage is not PROGRAM and stage.all("USER")}
    assert others == {"blueos": "hawk"}
    users = (ROOT / "packaging" / "systemd" / "hawk-drone.sysusers").read_text("utf-8")
    groups = sorted(re.findall(r"^m hawk (\w+)$", users, re.MULTILINE))
    made = re.search(r"useradd (.*?)&&", " ".join(PROGRAM.all("RUN")))[1]  # type: ignore[index]
    assert f"--groups {','.join(groups)} " in made
    assert f"--home-dir {STORE} " in made
    assert int(re.search(r"--uid (\d+)", made)[1]) == int(re.search(r"--gid (\d+)", " ".join(PROGRAM.all("RUN")))[1])  # type: ignore[index]
    assert int(re.search(r"--uid (\d+)", made)[1]) > 0  # type: ignore[index]


def test_settings_and_store_are_volumes_and_the_program_finds_both() -> None:
    assert words_of(PROGRAM.all("VOLUME")[0]) == ["/etc/hawk", STORE]
    assert words_of(PROGRAM.all("CMD")[0]) == ["--config", "/etc/hawk/config.toml"]
    environment = PROGRAM.environment()
    config = load_config(None, {"HAWK_STORE__DIRECTORY": environment["HAWK_STORE__DIRECTORY"]})
    assert str(config.store.directory) == STORE
    assert environment["RUNTIME_DIRECTORY"] == str(RUNTIME_FOLDER)
    assert f"-m 0750 {STORE} {RUNTIME_FOLDER}" in " ".join(PROGRAM.all("RUN"))


def test_no_setting_of_the_daemon_but_the_store_is_in_the_environment() -> None:
    """It would override the settings' file, which a person edits; and a container's environment is no secret."""
    for stage in STAGES:
        assert {key for key in stage.environment() if key.startswith("HAWK_")} <= {"HAWK_STORE__DIRECTORY"}
        text = " ".join(f"{name} {words}" for name, words in stage.instructions)
        assert not re.search(r"token|password|secret", text, re.IGNORECASE)


def test_the_program_is_not_process_1() -> None:
    """The kernel spares process 1 from SIGALRM, which ends a hung daemon (hawk.runtime.process.end_within)."""
    entry = words_of(PROGRAM.all("ENTRYPOINT")[0])
    assert entry[:2] == ["/usr/bin/tini", "--"]
    assert entry[2:] == ["hawk-drone"]
    assert entry[2] in PROJECT["scripts"]
    assert "tini" in " ".join(PROGRAM.all("RUN")).split()
    assert PROGRAM.environment()["PATH"].startswith("/opt/hawk/bin:")


def test_it_ends_by_the_signal_that_the_daemon_waits_for() -> None:
    assert PROGRAM.all("STOPSIGNAL") == ["SIGTERM"]
    assert "signal.SIGTERM" in (ROOT / "hawk" / "daemon" / "root.py").read_text("utf-8")


def test_the_port_is_the_settings_default() -> None:
    assert PROGRAM.all("EXPOSE") == [f"{Config().web.port}/tcp"]


def test_the_health_check_is_a_program_of_the_image() -> None:
    (check,) = PROGRAM.all("HEALTHCHECK")
    options, _, command = check.partition(" CMD ")
    words = words_of(command)
    assert words[0].startswith("/opt/hawk/bin/python")
    module = words[words.index("-m") + 1]
    assert (ROOT / f"{module.replace('.', '/')}.py").is_file()
    assert "--start-period=60s" in options


# -- the settings in the image ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("target", list(build_container.SETTINGS))
def test_the_images_settings_are_valid_and_differ_where_they_should(tmp_path: Path, target: str) -> None:
    file = tmp_path / "config.toml"
    file.write_text(build_container.settings((ROOT / "config.toml").read_text("utf-8"), target), "utf-8")
    config, plain = load_config(file, {}), load_config(ROOT / "config.toml", {})
    changed = {
        f"{section}.{key}"
        for section in Config.model_fields
        for key in section_fields(section)
        if getattr(getattr(config, section), key) != getattr(getattr(plain, section), key)
    }
    assert changed == {name for name, _, _ in build_container.SETTINGS[target]}
    assert config.web.host == "0.0.0.0"
    assert config.web.token is None


def test_a_setting_that_is_not_where_it_was_is_an_error() -> None:
    text = (ROOT / "config.toml").read_text("utf-8")
    with pytest.raises(build_container.ContainerError, match=r"web\.host is not \"127\.0\.0\.1\""):
        build_container.settings(text.replace('host = "127.0.0.1"', 'host = "::1"'), "drone")


# -- the engine -------------------------------------------------------------------------------------------------------


def engines(folder: Path, monkeypatch: pytest.MonkeyPatch, **answers: int) -> None:
    """Put programs on the path that end with these statuses; they write down what they were handed."""
    for name, status in answers.items():
        program = folder / name
        program.write_text(f'#!/bin/sh\nprintf "%s\\n" "$@" > {folder}/{name}.words\nexit {status}\n')
        program.chmod(program.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("PATH", str(folder))


def test_the_first_engine_that_answers_builds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    engines(tmp_path, monkeypatch, docker=1, buildah=0)
    assert build_container.find_engine() == "buildah"


@pytest.mark.parametrize(
    ("answers", "words"), [({}, "no container engine answers; install one"), ({"docker": 1}, "docker: installed, and")]
)
def test_without_an_engine_the_remedy_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, answers: dict[str, int], words: str
) -> None:
    engines(tmp_path, monkeypatch, **answers)
    with pytest.raises(build_container.ContainerError, match=words):
        build_container.find_engine()


@pytest.mark.parametrize(
    ("name", "status", "error"), [("buildah", 0, ""), ("docker", 0, ""), ("podman", 3, "podman build")]
)
def test_what_an_engine_is_handed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, status: int, error: str
) -> None:
    engines(tmp_path, monkeypatch, **{name: status})
    wheels = fake_wheels(tmp_path / "wheels")
    monkeypatch.setattr(build_container, "run", lambda command: f"a line\n{wheels}\n")
    monkeypatch.setattr(build_container, "own_arch", lambda: "amd64")
    project = tmp_path / "project"
    project.mkdir()
    for file in ("pyproject.toml", "config.toml"):
        (project / file).write_text((ROOT / file).read_text("utf-8"), "utf-8")
    arguments: tuple[Any, ...] = (project, name, "blueos", "arm64", ["--no-cache"])
    if error:
        with pytest.raises(build_container.ContainerError, match=error):
            build_container.build(*arguments)
        return
    assert build_container.build(*arguments) == f"hawk-drone-blueos:{PROJECT['version']}"
    words = (tmp_path / f"{name}.words").read_text().splitlines()
    assert words[0] == "build"
    assert words[words.index("--target") + 1] == "blueos"
    assert words[words.index("--platform") + 1] == "linux/arm64"
    assert words[words.index("--build-arg") + 1] == f"VERSION={PROJECT['version']}"
    assert ("--format" in words) is (name == "buildah")
    assert words[-2:] == ["--no-cache", str(project / "build" / "container" / "blueos-arm64")]


def test_a_step_that_fails_says_why() -> None:
    with pytest.raises(build_container.ContainerError, match="No such file"):
        build_container.run(["ls", "/nowhere/at/all"])


@pytest.mark.slow
def test_the_makefile_builds_it() -> None:
    printed = subprocess.run(
        ["make", "--dry-run", "--always-make", "container", "ARGS=--target blueos"],
        cwd=ROOT, capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    assert "packaging/container/build_container.py --target blueos" in printed


def test_every_label_of_the_program_is_a_text() -> None:
    labels = Stage.labels(PROGRAM)
    assert labels["org.opencontainers.image.licenses"] == PROJECT["license"]
    assert labels["org.opencontainers.image.source"] == PROJECT["urls"]["Homepage"]
    assert labels["org.opencontainers.image.version"] == "${VERSION}"
    assert json.dumps(labels)
