"""All settings with what they mean, as page and documentation show them."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from hawk.config.reference import Setting, reference_text, settings, texts
from hawk.config.sections import AutopilotSettings, CameraSettings, Config, StoreSettings, WebSettings

PAGE = Path(__file__).parents[3] / "docs" / "settings.md"


def shown(config: Config | None = None) -> dict[tuple[str, str], Setting]:
    return {(each.section, each.key): each for each in settings(config or Config(), reference_text())}


def test_every_setting_is_there_with_a_text() -> None:
    found = shown()
    assert list(found) == [
        (section, key) for section, values in Config().model_dump().items() if section != "schedule" for key in values
    ]
    assert all(each.text for each in found.values())


def test_a_text_of_several_lines_is_whole_and_one_for_two_settings_stands_at_both() -> None:
    found = shown()
    assert found["heights", "least_clearance_m"].text.endswith("never more than half of Min counts")
    assert found["heights", "desired_m"].text == found["heights", "minimum_m"].text
    assert found["watchdog", "enabled"].text != found["watchdog", "timeout_s"].text


def test_a_setting_that_is_commented_out_is_found_and_prose_with_an_equals_sign_is_not() -> None:
    found = texts("[flight]\n# cells, as in x = 4\n# battery_cells = 4  # 1 to 24\n# of the battery\ntick_hz = 20.0\n")
    assert found == {("flight", "battery_cells"): "cells, as in x = 4", ("flight", "tick_hz"): "of the battery"}


@pytest.mark.parametrize(
    ("key", "unit"),
    [
        (("flight", "speed_m_s"), "m/s"),
        (("fence", "radius_m"), "m"),
        (("operator", "operator_hold_s"), "s"),
        (("flight", "explore_cm_per_pixel"), "cm/pixel"),
        (("store", "minimum_free_mb"), "MB"),
        (("web", "video_width"), "pixels"),
        (("web", "video_quality"), ""),
        (("camera", "mount_yaw_deg"), "°"),
    ],
)
def test_units(key: tuple[str, str], unit: str) -> None:
    assert shown()[key].unit == unit


def test_the_present_value_stands_beside_the_default() -> None:
    radius = shown(Config.model_validate({"fence": {"radius_m": 80.0}}))["fence", "radius_m"]
    assert (radius.value, radius.default, radius.lowest, radius.highest) == (80.0, 150.0, 20.0, 2000.0)


def test_no_token_and_no_password_is_shown() -> None:
    config = Config(
        web=WebSettings(token="secret-secret-secret"),
        camera=CameraSettings(url="rtsp://admin:pass@word@10.0.0.4/live"),
        autopilot=AutopilotSettings(url="udpin://127.0.0.1:14550"),
        store=StoreSettings(directory=Path("/var/lib/hawk")),
    )
    found = shown(config)
    assert found["web", "token"].value == "(set)"
    assert found["camera", "url"].value == "rtsp://***@10.0.0.4/***"
    assert found["autopilot", "url"].value == "udpin://127.0.0.1:14550"
    assert found["store", "directory"].value == "/var/lib/hawk"
    assert not any("secret-secret" in str(each.value) or "pass@" in str(each.value) for each in found.values())


def test_without_the_file_there_are_no_texts_and_all_values(tmp_path: Path) -> None:
    found = settings(Config(), "")
    assert len(found) == len(shown())
    assert {each.text for each in found} == {""}


def test_the_page_of_settings_shows_every_section() -> None:
    shown_there = re.findall(r"^<!-- \.\./config\.toml \[(\w+)\] -->$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    assert set(shown_there) == set(Config().model_dump())
