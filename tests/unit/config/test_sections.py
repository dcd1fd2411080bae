from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

from hawk.config.addresses import host_and_port
from hawk.config.loader import load_config
from hawk.config.sections import AutopilotSettings, Config, ConfigError
from tests.sweep import sweep

REFERENCE = Path(__file__).parents[3] / "config.toml"


def settings() -> list[tuple[str, str, Any]]:
    sections = {name: field for name, field in Config().model_dump().items() if name != "schedule"}  # a list of blocks
    return [(section, key, value) for section, field in sections.items() for key, value in field.items()]


def test_the_reference_file_is_the_defaults() -> None:
    assert load_config(REFERENCE, {}) == Config()


@sweep("section, key", [(section, key) for section, key, _ in settings()])
def test_every_setting_is_in_the_reference_with_a_comment(section: str, key: str) -> None:
    text = REFERENCE.read_text()
    part = text.split(f"[{section}]", 1)[1].split("\n[", 1)[0]
    found = re.search(rf"^(# )?{key} = ", part, re.MULTILINE)
    assert found, f"{section}.{key} is not in config.toml"
    before = part[: found.start()].rstrip().splitlines()[-1]
    assert before.startswith("#") or "=" in before


def test_the_reference_has_no_other_settings() -> None:
    known = {(section, key) for section, key, _ in settings()}
    found = tomllib.loads(REFERENCE.read_text())
    assert {(section, key) for section, values in found.items() for key in values} <= known


@pytest.mark.parametrize(
    ("text", "line", "key", "hint"),
    [
        ("[web]\nport = 70000\n", 2, "web.port", "65535"),
        ("[web]\n\nprot = 1\n", 3, "web.prot", "did you mean port?"),
        ("[heights]\ndesired_m = 5.0\n", 1, "heights", "must rise"),
        ("[heights]\nhighest_obstacle_m = 12.0\n", 1, "heights", "minimum_m must be 17 or more"),
        ("[flight]\nspeed_m_s = nan\n", 2, "flight.speed_m_s", "finite"),
        ("[camera]\nurl = 'ftp://cam'\n", 2, "camera.url", "rtsp://"),
        ("[autopilot]\nurl = '/dev/ttyACM0'\n", 2, "autopilot.url", "serial://"),
        ("[autopilot]\nvehicle_address = 'drone.local'\n", 2, "autopilot.vehicle_address", "IP:PORT"),
        ("[autopilot]\nvehicle_address = '10.0.0.1:0'\n", 2, "autopilot.vehicle_address", "IP:PORT"),
        ("[autopilot]\nvehicle_system_id = 0\n", 2, "autopilot.vehicle_system_id", "1"),
        ("[wbe]\nport = 1\n", 1, "wbe", "did you mean web?"),
        ("[web]\ntoken = 'short'\n", 2, "web.token", "16"),
        ("[remote_control]\nrequired = 3\n", 2, "remote_control.required", "true or false"),
        ("[remote_id]\nenabled = true\n", 1, "remote_id", "operator_id is missing"),
        ("[remote_id]\noperator_id = ''\n", 2, "remote_id.operator_id", "1 to 20"),
        ("[remote_id]\noperator_id = 'FIN87astrdge12k8-too-long'\n", 2, "remote_id.operator_id", "1 to 20"),
        ("[remote_id]\noperator_id = 'Müller'\n", 2, "remote_id.operator_id", "plain ASCII"),
        ("[remote_id]\noperator_id = 'FIN87astrdge12k8-xyz'\n", 2, "remote_id.operator_id", "secret part"),
        ("[remote_id]\ndescription = 'a description far too long'\n", 2, "remote_id.description", "1 to 23"),
        ("[remote_id]\noperator_place = 'home'\n", 2, "remote_id.operator_place", "takeoff"),
        ("[remote_id]\noperator_place = 'fixed'\n", 1, "remote_id", "needs operator_latitude_deg"),
        (
            "[remote_id]\noperator_place = 'fixed'\noperator_latitude_deg = 0\noperator_longitude_deg = 0\n",
            1,
            "remote_id",
            "takes that for unknown",
        ),
        ("[remote_id]\noperator_latitude_deg = 91\n", 2, "remote_id.operator_latitude_deg", "90"),
    ],
)
def test_a_wrong_setting_names_file_line_and_key(tmp_path: Path, text: str, line: int, key: str, hint: str) -> None:
    path = tmp_path / "bad.toml"
    path.write_text(text)
    with pytest.raises(ConfigError) as caught:
        load_config(path, {})
    assert f"{path}, line {line}: {key}: " in str(caught.value)
    assert hint in str(caught.value)


@pytest.mark.parametrize(
    ("address", "expected"),
    [
        ("10.0.0.1", ("10.0.0.1", None)),
        ("10.0.0.1:14555", ("10.0.0.1", 14555)),
        ("fe80::1", ("fe80::1", None)),
        ("[fe80::1]", ("fe80::1", None)),
        ("[fe80::1]:5", ("fe80::1", 5)),
    ],
)
def test_addresses_of_both_families_are_read(address: str, expected: tuple[str, int | None]) -> None:
    assert host_and_port(address) == expected
    assert AutopilotSettings(vehicle_address=address).vehicle_address == address


@pytest.mark.parametrize("address", ["", ":5", "10.0.0.1:", "10.0.0.1:x", "10.0.0.1:65536", "[fe80::1", "10.0.0"])
def test_other_addresses_are_refused(address: str) -> None:
    with pytest.raises(ValueError, match="vehicle_address"):
        AutopilotSettings(vehicle_address=address)


def test_nothing_outside_this_computer_is_heard_by_default() -> None:
    assert AutopilotSettings().url == "udpin://127.0.0.1:14550"


def test_what_is_not_toml_and_what_cannot_be_read_is_said(tmp_path: Path) -> None:
    path = tmp_path / "bad.toml"
    path.write_text("[web\n")
    with pytest.raises(ConfigError, match=r"not TOML.*line 1"):
        load_config(path, {})
    with pytest.raises(ConfigError, match="cannot be read"):
        load_config(tmp_path / "absent.toml", {})


def test_environment_overrides_the_file_and_the_command_line_both(tmp_path: Path) -> None:
    path = tmp_path / "c.toml"
    path.write_text("[web]\nport = 1\n[log]\nlevel = 'debug'\n")
    config = load_config(path, {"HAWK_WEB__PORT": "2", "HAWK_LOG__LEVEL": "error"}, {"web": {"port": 3}})
    assert config.web.port == 3
    assert config.log.level == "error"


def test_a_wrong_environment_variable_is_named() -> None:
    with pytest.raises(ConfigError, match=r"^HAWK_WEB__PORT: web\.port: .*found 'x'"):
        load_config(None, {"HAWK_WEB__PORT": "x"})
    with pytest.raises(ConfigError, match=r"^web\.port: .*found 'y'"):
        load_config(None, {"HAWK_WEB__PORT": "x"}, {"web": {"port": "y"}})


def test_a_wrong_token_is_not_repeated() -> None:
    """A service's error goes into the journal."""
    with pytest.raises(ConfigError, match=r"web\.token: .*16 characters") as refused:
        load_config(None, {"HAWK_WEB__TOKEN": "half a secret"})
    assert "half" not in str(refused.value)


@pytest.mark.parametrize(
    ("text", "hosts"),
    [
        ("a.example", ("a.example",)),
        ("a.example,b.example", ("a.example", "b.example")),
        (" a.example  b.example ", ("a.example", "b.example")),
        ("", ()),
    ],
)
def test_a_list_in_the_environment_has_its_parts_between_commas_or_spaces(text: str, hosts: tuple[str, ...]) -> None:
    assert load_config(None, {"HAWK_WEB__ALLOWED_HOSTS": text}).web.allowed_hosts == hosts
