"""The layer for rpi-image-gen: its fields, its keys, and its steps in a folder that stands for the new root."""

from __future__ import annotations

import os
import re
import stat
import subprocess
from pathlib import Path

import pytest

from tests.unit.packaging.rpi_layer import CONFIG, ROOT, body, fields, hooks

FIELDS = fields()
LAYER_FIELDS = {"Name", "Category", "Desc", "Version", "Requires", "AfterProvider"}
"""Those of docs/layer/index.adoc of rpi-image-gen that this layer uses."""
VARIABLE_FIELDS = {"Desc", "Required", "Valid", "Set"}
KEYS = {"packages", "customize-hooks"}
"""Keys of mmdebstrap that bdebstrap(1) merges, and this layer uses."""
PAGE = (ROOT / "docs" / "raspberry-pi-image.md").read_text("utf-8")
UNIT = (ROOT / "packaging" / "systemd" / "hawk-drone.service").read_text("utf-8")


def new_root(folder: Path, config: str) -> Path:
    """Make what is there when the layer's steps run, and a ``chroot`` that writes down its words."""
    (folder / "boot" / "firmware").mkdir(parents=True)
    (folder / "boot" / "firmware" / "config.txt").write_text(config)
    program = folder / "bin" / "chroot"
    program.parent.mkdir()
    program.write_text('#!/bin/sh\nshift\nprintf "%s " "$@" >> "$WORDS"\necho >> "$WORDS"\n')
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    return folder


def run(root: Path, hook: str, package: Path | None = None) -> list[str]:
    """Run a step as mmdebstrap does; return what ran in the root."""
    words = root / "words"
    words.touch()
    environment = {"PATH": f"{root / 'bin'}:{os.environ['PATH']}", "WORDS": str(words)}
    if package is not None:
        environment["IGconf_hawk_package"] = str(package)
    subprocess.run(["sh", "-c", hook, "exec", str(root)], env=environment, check=True)
    return [line.strip() for line in words.read_text().splitlines()]


def test_the_fields_are_those_that_rpi_image_gen_reads() -> None:
    layer = {name.removeprefix("X-Env-Layer-") for name in FIELDS if name.startswith("X-Env-Layer-")}
    assert layer == LAYER_FIELDS
    variables = {name.removeprefix("X-Env-Var-") for name in FIELDS if name.startswith("X-Env-Var-")}
    names = {name.partition("-")[0] for name in variables}
    assert variables == names | {f"{name}-{field}" for name in names for field in VARIABLE_FIELDS}
    assert FIELDS["X-Env-VarPrefix"] == "hawk"
    assert set(FIELDS) == {f"X-Env-Layer-{n}" for n in layer} | {f"X-Env-Var-{n}" for n in variables} | {
        "X-Env-VarPrefix"
    }
    assert re.fullmatch(r"\d+\.\d+\.\d+", FIELDS["X-Env-Layer-Version"])


def test_the_steps_use_the_variables_that_are_declared() -> None:
    used = set(re.findall(r"IGconf_(\w+)", " ".join(hooks())))
    assert used == {f"hawk_{name[10:]}" for name in FIELDS if re.fullmatch(r"X-Env-Var-\w+", name)}


@pytest.mark.parametrize(
    ("path", "fits"),
    [
        ("/home/me/dist/hawk-drone_0.2.0+deb12_arm64.deb", True),
        ("/hawk-drone_0.2.0+deb12_arm64.deb", True),
        ("dist/hawk-drone_0.2.0+deb12_arm64.deb", False),
        ("/dist/hawk-drone_0.2.0+deb12_amd64.deb", False),
        ("/dist/hawk-drone_0.2.0+deb13_arm64.deb", False),
    ],
)
def test_the_package_is_one_of_a_raspberry_pi(path: str, fits: bool) -> None:
    pattern = FIELDS["X-Env-Var-package-Valid"].removeprefix("regex:")
    assert (re.match(pattern, path) is not None) is fits


def test_the_keys_are_mmdebstraps() -> None:
    assert set(body()) == {"mmdebstrap"}
    assert set(body()["mmdebstrap"]) == KEYS
    packages = body()["mmdebstrap"]["packages"]
    assert packages == sorted(set(packages))
    control = (ROOT / "debian" / "control").read_text("utf-8")
    recommended = re.search(r"^Recommends: (.*)$", control, re.MULTILINE)[1].split(", ")  # type: ignore[index]
    assert set(recommended) <= set(packages)  # apt installs none of itself here
    assert "python3.11" in packages
    source = (ROOT / "hawk" / "comm" / "cameras" / "sources" / "rtsp.py").read_text("utf-8")
    assert set(re.findall(r"gstreamer1\.0-[a-z]+(?:-[a-z]+)?", source)) <= set(packages)
    assert FIELDS["X-Env-Layer-Requires"] == "bookworm-minbase"  # the Debian that has this Python


@pytest.mark.parametrize("hook", hooks())
def test_a_step_stops_at_its_first_fault(hook: str) -> None:
    assert subprocess.run(["sh", "-n", "-c", hook], check=False).returncode == 0
    assert "set -eu" in hook


def test_the_package_is_installed_and_the_service_enabled(tmp_path: Path) -> None:
    root = new_root(tmp_path / "root", "")
    package = tmp_path / "hawk-drone_0.2.0_arm64.deb"
    package.write_text("a package")
    first, second, _ = hooks()
    ran = run(root, first, package)
    assert ran == ["apt-get install --yes --no-install-recommends /var/cache/hawk/hawk-drone.deb"]
    assert not (root / "var" / "cache" / "hawk").exists()
    assert run(root, second)[1:] == ["systemctl enable hawk-drone.service"]
    assert (ROOT / "packaging" / "systemd" / "hawk-drone.service").is_file()


def test_without_a_package_it_stops(tmp_path: Path) -> None:
    root = new_root(tmp_path / "root", "")
    with pytest.raises(subprocess.CalledProcessError):
        run(root, hooks()[0])
    with pytest.raises(subprocess.CalledProcessError):
        run(root, hooks()[0], tmp_path / "missing.deb")
    assert (root / "words").read_text() == ""


@pytest.mark.parametrize("before", ["", "dtparam=audio=on\n", "[cm4]\notg_mode=1"])
def test_the_camera_is_looked_for_once_and_on_every_board(tmp_path: Path, before: str) -> None:
    root = new_root(tmp_path / "root", before)
    for _ in range(2):
        run(root, hooks()[2])
    text = (root / "boot" / "firmware" / "config.txt").read_text()
    assert text == f"{before}\n[all]\ncamera_auto_detect=1\n"


def test_the_unit_may_use_what_libcamera_opens() -> None:
    allowed = set(re.findall(r"^DeviceAllow=(\S+) rw$", UNIT, re.MULTILINE))
    assert {"char-video4linux", "char-media", "char-dma_heap"} <= allowed
    assert "DevicePolicy=closed" in UNIT


def test_nothing_secret_is_in_it() -> None:
    configured = body(CONFIG)
    assert configured["layer"] == {"app": FIELDS["X-Env-Layer-Name"]}
    assert configured["ssh"]["pubkey_only"] in (True, "y")
    lines = "\n".join((CONFIG.read_text("utf-8"), *hooks())).splitlines()
    text = "\n".join(line for line in lines if not line.startswith("#"))
    assert not re.search(r"pass(word|hash)?\s*[:=]|chpasswd|token|PRIVATE KEY", text)
    assert set(configured["device"]) == {"layer", "hostname", "user1"}


def test_the_page_names_what_is_configured() -> None:
    configured = body(CONFIG)
    assert f"host name `{configured['device']['hostname']}`" in PAGE
    assert f"ssh {configured['device']['user1']}@{configured['device']['hostname']}.local" in PAGE
    for name in re.findall(r"IGconf_hawk_\w+", PAGE):
        assert f"X-Env-Var-{name.removeprefix('IGconf_hawk_')}" in FIELDS
    assert f"-c {CONFIG.name}" in PAGE
