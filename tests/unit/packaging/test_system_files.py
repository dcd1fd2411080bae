"""Files for systemd, udev and dpkg: names by serial number, the user's groups, the folders' owners."""

from __future__ import annotations

import re
import shlex
import subprocess
from collections.abc import Mapping
from pathlib import Path

import pytest

from hawk.cli import make_parser
from hawk.daemon.announcement import ADDRESS_FILE
from hawk.versions.folder import READY
from hawk.versions.switch import DESK_UNIT
from hawk.versions.switch import UNIT as DRONE_UNIT
from hawk.web.access.access import LOGIN_FILE
from hawk.web.access.tls import CERTIFICATE_FILE, KEY_FILE
from hawk.web.access.tokens import SECRET_FILE, TOKEN_FILE

ROOT = Path(__file__).parents[3]
UNITS = sorted((ROOT / "packaging" / "systemd").glob("*.service"))
RULES = (ROOT / "packaging" / "udev" / "hawk-drone.rules").read_text("utf-8")
TOKEN = re.compile(r'(?P<key>[A-Z]+(?:\{\w+\})?)(?P<operator>==|\+=|=)"(?P<value>[^"]*)"(?:, )?')
AUTOPILOT = {
    "ACTION": "add",
    "SUBSYSTEM": "tty",
    "ENV{ID_BUS}": "usb",
    "ENV{ID_SERIAL_SHORT}": "300027001951333",
    "ENV{ID_USB_INTERFACE_NUM}": "00",
}
CAMERA = {
    "ACTION": "add",
    "SUBSYSTEM": "video4linux",
    "ENV{ID_BUS}": "usb",
    "ENV{ID_SERIAL_SHORT}": "SN0001",
    "ATTR{index}": "0",
}


def links(device: Mapping[str, str]) -> list[str]:
    """Return the links that the rules give a device (udev(7): matches, SYMLINK, GOTO)."""
    found: list[str] = []
    skipped = ""
    for line in RULES.splitlines():
        if not line or line.startswith("#"):
            continue
        tokens = [match.groupdict() for match in TOKEN.finditer(line)]
        assert "".join(match.group() for match in TOKEN.finditer(line)) == line, line
        keys = {token["key"]: token["value"] for token in tokens}
        if skipped and keys.get("LABEL") != skipped:
            continue
        matches = [token for token in tokens if token["operator"] == "=="]
        if not all(_fits(device.get(token["key"], ""), token["value"]) for token in matches):
            continue
        skipped = keys.get("GOTO", "")
        if "SYMLINK" in keys:
            found.append(re.sub(r"\$env\{(\w+)\}", lambda name: device[f"ENV{{{name.group(1)}}}"], keys["SYMLINK"]))
    return found


def _fits(value: str, pattern: str) -> bool:
    return bool(value) if pattern == "?*" else value == pattern


@pytest.mark.parametrize(
    ("device", "expected"),
    [
        (AUTOPILOT, ["hawk/autopilot-300027001951333"]),
        (CAMERA, ["hawk/camera-SN0001"]),
        ({**AUTOPILOT, "ENV{ID_USB_INTERFACE_NUM}": "02"}, []),
        ({**CAMERA, "ATTR{index}": "1"}, []),
        ({**AUTOPILOT, "ENV{ID_SERIAL_SHORT}": ""}, []),
        ({**CAMERA, "ENV{ID_BUS}": "platform"}, []),
        ({**AUTOPILOT, "ACTION": "remove"}, []),
    ],
)
def test_devices_of_usb_are_named_by_their_serial_number(device: Mapping[str, str], expected: list[str]) -> None:
    assert links(device) == expected


def test_the_rules_are_read_after_those_that_read_the_serial_number() -> None:
    assert "dh_installudev --priority=70" in (ROOT / "debian" / "rules").read_text("utf-8")


def test_the_user_has_the_groups_and_the_folder_of_the_unit() -> None:
    systemd = ROOT / "packaging" / "systemd"
    unit = (systemd / "hawk-drone.service").read_text("utf-8")
    users = (systemd / "hawk-drone.sysusers").read_text("utf-8")
    groups = re.findall(r"^m hawk (\w+)$", users, re.MULTILINE)
    assert re.search(r"^SupplementaryGroups=(.*)$", unit, re.MULTILINE)[1].split() == groups  # type: ignore[index]
    folder = re.search(r"^u hawk - \".*\" (\S+)$", users, re.MULTILINE)[1]  # type: ignore[index]
    assert f"d {folder} 0750 hawk hawk -" in (systemd / "hawk-drone.tmpfiles").read_text("utf-8")
    assert f"WorkingDirectory={folder}" in unit
    assert "StateDirectoryMode=0750" in unit


def test_every_linked_file_of_debian_is_there() -> None:
    linked = [path for path in (ROOT / "debian").iterdir() if path.is_symlink()]
    assert {path.suffix for path in linked} == {".service", ".sysusers", ".tmpfiles", ".udev"}
    assert all(path.resolve().is_file() for path in linked)


def test_the_hook_looks_for_the_mark_that_the_program_sets() -> None:
    """So a restart in the air starts no Python."""
    assert f"[ -e /opt/hawk/current/{READY} ] && exit 0" in (ROOT / "packaging/deb/service-hook").read_text("utf-8")


def test_the_package_depends_on_the_python_of_its_environment() -> None:
    depends = re.search(r"^Depends: (.*)$", (ROOT / "debian" / "control").read_text("utf-8"), re.MULTILINE)
    assert depends is not None
    assert "${hawk:Python}" in depends[1].split(", ")
    rules = (ROOT / "debian" / "rules").read_text("utf-8")
    assert "-Vhawk:Python=python$(DEB_PYTHON)" in rules
    assert "--python $(DEB_PYTHON)" in rules


@pytest.mark.parametrize("name", ["hawk-drone.postrm", "hawk-drone.prerm"])
def test_a_script_of_the_package_is_one_of_the_shell(name: str) -> None:
    subprocess.run(["sh", "-n", str(ROOT / "debian" / name)], check=True)


def test_a_purge_takes_every_secret_of_daemon_and_desk_and_no_survey(tmp_path: Path) -> None:
    secrets = (LOGIN_FILE, CERTIFICATE_FILE, KEY_FILE, ADDRESS_FILE, SECRET_FILE, TOKEN_FILE)
    stores = [tmp_path / "hawk", tmp_path / "hawk-desk"]
    for store in stores:
        store.mkdir()
        for name in (*secrets, "lots.db"):
            (store / name).write_text("")
    (stores[0] / "lots.db").unlink()  # an empty store goes
    script = (ROOT / "debian" / "hawk-drone.postrm").read_text("utf-8").replace("/var/lib/", f"{tmp_path}/")
    printed = subprocess.run(
        ["sh", "-s", "purge"], input=script.replace("/etc/hawk", str(tmp_path / "none")),
        capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    assert [path.relative_to(tmp_path).as_posix() for path in sorted(tmp_path.rglob("*"))] == [
        "hawk-desk",
        "hawk-desk/lots.db",
    ]
    assert printed == f"hawk-drone: surveys and recordings stay in {stores[1]}; remove them by hand\n"


# -- units ------------------------------------------------------------------------------------------------------------


def unit(name: str) -> dict[str, str]:
    """Return the assignments of a unit by their key, continued lines joined; of several the last."""
    text = (ROOT / "packaging" / "systemd" / name).read_text("utf-8").replace("\\\n", "")
    return dict(line.split("=", 1) for line in text.splitlines() if "=" in line and not line.startswith("#"))


@pytest.mark.parametrize("path", UNITS, ids=lambda path: path.name)
def test_the_package_installs_every_unit_and_starts_none(path: Path) -> None:
    name = path.stem
    link = ROOT / "debian" / ("hawk-drone.service" if name == "hawk-drone" else f"hawk-drone.{name}.service")
    assert link.resolve() == path
    rules = (ROOT / "debian" / "rules").read_text("utf-8").splitlines()
    chosen = "" if name == "hawk-drone" else f"--name={name} "
    assert f"\tdh_installsystemd {chosen}--no-enable --no-start --no-stop-on-upgrade" in rules
    assert path.name in (ROOT / "debian" / "hawk-drone.prerm").read_text("utf-8")


@pytest.mark.parametrize("path", UNITS, ids=lambda path: path.name)
def test_the_command_of_a_unit_is_one_of_the_program(path: Path, tmp_path: Path) -> None:
    program, *words = unit(path.name)["ExecStart"].replace("/srv/hawk-inbox", str(tmp_path)).split()
    assert program.endswith("/bin/hawk-drone")
    options = make_parser().parse_args(["run", *words] if words[0].startswith("-") else words)
    if path.name == DESK_UNIT:
        assert options.collect
        assert str(options.config) == unit(path.name)["AssertPathExists"]
    if path.name == "hawk-inbox.service":
        assert unit(path.name)["AssertPathExists"] == program
        assert str(options.store) == f"/var/lib/{unit(DESK_UNIT)['StateDirectory']}"


def test_a_desk_has_a_store_of_its_own_and_no_device() -> None:
    desk, drone = unit(DESK_UNIT), unit(DRONE_UNIT)
    store = f"/var/lib/{desk['StateDirectory']}"
    assert desk["StateDirectory"] != drone["StateDirectory"]
    assert f"HAWK_STORE__DIRECTORY={store} " in desk["Environment"]
    assert f"d {store} 0750 hawk hawk -" in (ROOT / "packaging/systemd/hawk-drone.tmpfiles").read_text("utf-8")
    assert (desk["PrivateDevices"], "DeviceAllow" in desk, "SupplementaryGroups" in desk) == ("yes", False, False)
    assert "Conflicts" not in desk, "it would end a flight"


@pytest.mark.parametrize(
    ("enabled", "state", "starts"),
    [
        (1, "inactive", True),
        (1, "failed", True),
        (1, "active", False),
        (1, "activating", False),  # between two starts, in the air too
        (0, "inactive", False),
    ],
)
def test_a_desk_does_not_start_on_the_computer_of_a_drone(
    tmp_path: Path, enabled: int, state: str, starts: bool
) -> None:
    program = tmp_path / "systemctl"
    program.write_text(f'#!/bin/sh\ncase "$*" in *is-enabled*) exit {enabled} ;; esac\necho {state}\n')
    program.chmod(0o755)
    condition = unit(DESK_UNIT)["ExecCondition"].removeprefix("+").replace("$$", "$")
    words = shlex.split(condition)
    done = subprocess.run(words, env={"PATH": f"{tmp_path}:/bin"}, capture_output=True, text=True, check=False)
    assert (done.returncode == 0) is starts
    assert ("hawk-drone.service is enabled or runs" in done.stderr) is not starts
