"""Files for systemd, udev and dpkg: names by serial number, the user's groups, the folders' owners."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

import pytest

from hawk.versions.folder import READY

ROOT = Path(__file__).parents[3]
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


def test_a_purge_takes_every_secret_that_the_daemon_keeps() -> None:
    from hawk.daemon.announcement import ADDRESS_FILE
    from hawk.web.access.access import LOGIN_FILE
    from hawk.web.access.tls import CERTIFICATE_FILE, KEY_FILE
    from hawk.web.access.tokens import SECRET_FILE, TOKEN_FILE

    script = (ROOT / "debian" / "hawk-drone.postrm").read_text("utf-8")
    for name in (LOGIN_FILE, CERTIFICATE_FILE, KEY_FILE, ADDRESS_FILE, SECRET_FILE, TOKEN_FILE):
        assert f"/var/lib/hawk/{name}" in script, name
