"""The image as buildah builds it from the Containerfile, on a Debian root in place of the base, and the program in it.

buildah needs no service here: its steps run in a chroot, and its images lie in a folder of the test. There is no engine
that starts a container, so the program is started in the image by `buildah run`, by the image's user.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from tests.package.clean_root import CALM, printed
from tests.package.conftest import ROOT, archive
from tests.unit.packaging.containerfile import read, words_of

pytestmark = pytest.mark.timeout(3600)
BASE = "localhost/hawk-test-base:bookworm"
STORAGE = '[storage]\ndriver = "vfs"\nrunroot = "{0}/run"\ngraphroot = "{0}/graph"\n'
STORE = "/var/lib/hawk"
READY_S = 300.0
"""Real seconds for a daemon on a busy machine."""
STAGES = {stage.name: stage for stage in read()[1]}


@dataclass(frozen=True)
class Buildah:
    """buildah with images of its own."""

    storage: Path

    @property
    def environment(self) -> dict[str, str]:
        return {**os.environ, "CONTAINERS_STORAGE_CONF": str(self.storage), "BUILDAH_ISOLATION": "chroot"}

    def __call__(self, *words: str, fails: bool = False, timeout: float = 600) -> str:
        return printed([*CALM, "buildah", *words], self.environment, fails=fails, timeout=timeout)

    def words(self, container: str, *command: str) -> list[str]:
        """Return the command that runs one in a container, by the image's user."""
        return [*CALM, "buildah", "run", "--isolation=chroot", container, "--", *command]


@pytest.fixture(scope="module")
def buildah(tmp_path_factory: pytest.TempPathFactory) -> Buildah:
    if shutil.which("buildah") is None or shutil.which("mmdebstrap") is None or os.geteuid() != 0:
        pytest.skip("buildah or mmdebstrap is not installed, or this is not root: run make deb")
    folder = tmp_path_factory.mktemp("containers")
    storage = folder / "storage.conf"
    storage.write_text(STORAGE.format(folder))
    return Buildah(storage)


@pytest.fixture(scope="module")
def image(buildah: Buildah) -> str:
    """The extension's image: all stages but the empty last one."""
    base = buildah("from", "scratch").strip()
    buildah("add", base, str(archive("bookworm", "base", "--variant=minbase", needs=())), "/")
    buildah("commit", "--rm", base, BASE)
    program = str(ROOT / "packaging" / "container" / "build_container.py")
    command = [sys.executable, program, "--engine=buildah", "--target=blueos"]
    options = ["--", "--isolation=chroot", f"--build-arg=BASE={BASE}"]
    output = printed([*CALM, *command, *options], buildah.environment, fails=False, timeout=3000)
    return output.splitlines()[-1].partition(": built by ")[0]


@pytest.fixture(scope="module")
def container(buildah: Buildah, image: str) -> Iterator[str]:
    name = buildah("from", image).strip()
    yield name
    buildah("rm", name)


@pytest.fixture(scope="module")
def config(buildah: Buildah, image: str) -> Any:
    """The image as an engine and BlueOS read it."""
    return json.loads(buildah("inspect", "--type=image", image))["Docker"]["config"]


def test_the_labels_are_in_the_image_as_they_are_tested_here(config: Any, image: str) -> None:
    """tests/unit/packaging/test_blueos.py reads them from the file."""
    version = image.partition(":")[2]
    labels = {**STAGES["program"].labels(), **STAGES["blueos"].labels()}
    expected = {key: value.replace("${VERSION}", version) for key, value in labels.items()}
    found = {key: value for key, value in config["Labels"].items() if not key.startswith("io.buildah")}
    assert found == expected
    assert json.loads(found["permissions"])["HostConfig"]["NetworkMode"] == "host"


def test_how_it_is_started_is_in_the_image(config: Any) -> None:
    assert config["User"] == "hawk"
    assert config["Entrypoint"] == words_of(STAGES["program"].all("ENTRYPOINT")[0])
    assert config["Healthcheck"]["Test"] == ["CMD", "/opt/hawk/bin/python", "-I", "-m", "hawk.versions.alive"]
    assert config["StopSignal"] == "SIGTERM"
    assert set(config["Volumes"]) == {"/etc/hawk", STORE}


def test_nothing_of_the_checkout_but_wheels_and_settings_is_in_it(buildah: Buildah, container: str) -> None:
    root = Path(buildah("mount", container).strip())
    brought = [path for pattern in ("*.whl", "uv.lock", ".git", "pyproject.toml") for path in root.rglob(pattern)]
    assert brought == []
    listed = printed(buildah.words(container, "find", STORE, "/run/hawk"), buildah.environment, fails=False, timeout=60)
    assert listed.splitlines() == [STORE, "/run/hawk"]


def test_the_program_runs_by_its_user_and_refuses_to_start_without_a_token(buildah: Buildah, container: str) -> None:
    def run(*command: str, fails: bool = False) -> str:
        return printed(buildah.words(container, *command), buildah.environment, fails=fails, timeout=300)

    assert run("id", "-un").strip() == "hawk"
    assert {"dialout", "video"} <= set(run("id", "-Gn").split())
    assert run(*config_of("ENTRYPOINT"), "--version").split()[-1] == project_version()
    refusal = run(*config_of("ENTRYPOINT"), *config_of("CMD"), fails=True)
    assert f"hawk-drone tokens rotate operator --store {STORE}" in refusal


def test_with_a_token_it_starts_is_healthy_and_ends_by_sigterm(buildah: Buildah, container: str) -> None:
    def health() -> int:
        command = buildah.words(container, *words_of(STAGES["program"].all("HEALTHCHECK")[0].partition(" CMD ")[2]))
        return subprocess.run(command, env=buildah.environment, capture_output=True, check=False).returncode

    made = buildah.words(container, *config_of("ENTRYPOINT"), "tokens", "rotate", "operator", "--store", STORE)
    token = printed(made, buildah.environment, fails=False, timeout=300).split()[-1]
    assert health() == 1
    # ports of its own: the program shares this computer's network here, and a container's autopilot is not heard
    settings = (
        "HAWK_WEB__PORT=0",
        f"HAWK_AUTOPILOT__URL=udpin://127.0.0.1:{free_port()}",
        "HAWK_WATCHDOG__ENABLED=false",
    )
    command = buildah.words(container, "env", *settings, *config_of("ENTRYPOINT"), *config_of("CMD"))
    daemon = subprocess.Popen(command, env=buildah.environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    try:
        until = time.monotonic() + READY_S
        while daemon.poll() is None and time.monotonic() < until and health() != 0:
            time.sleep(0.5)
        assert daemon.poll() is None
        assert health() == 0
        os.kill(program_of(daemon.pid), signal.SIGTERM)
        output = daemon.communicate(timeout=60)[0].decode()
    finally:
        if daemon.poll() is None:
            daemon.kill()
            daemon.communicate(timeout=60)
    assert daemon.returncode == 0, output
    assert token not in output
    assert health() == 1


def config_of(instruction: str) -> list[str]:
    """Return the words that start the program, as the file has them."""
    return words_of(STAGES["program"].all(instruction)[0])


def project_version() -> str:
    return str(tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["version"])


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


def program_of(pid: int) -> int:
    """Return the process of the image's entry point, which an engine would signal: it descends from buildah."""
    entry = config_of("ENTRYPOINT")[0].encode()
    return next(found for found in descendants(pid) if Path(f"/proc/{found}/cmdline").read_bytes().startswith(entry))


def descendants(pid: int) -> Iterator[int]:
    for task in Path(f"/proc/{pid}/task").iterdir():
        for child in (task / "children").read_text().split():
            yield int(child)
            yield from descendants(int(child))
