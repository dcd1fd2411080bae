from __future__ import annotations

import stat
import tomllib
from pathlib import Path

import pytest

from hawk.calibrate.settings_file import changed_text, write_settings
from hawk.config.sections import ConfigError

ROOT = Path(__file__).resolve().parents[3]


def test_a_value_is_replaced_in_its_section_and_its_remark_stays() -> None:
    text = (
        "[web]\nlatency_s = 1\n[camera]\n# seconds\nlatency_s = 0.08  # 0 to 5\nurl = 'v4l2:///dev/video0#1'\n[log]\n"
    )
    changed = changed_text(text, "camera", {"latency_s": "0.125"})
    assert changed == text.replace("latency_s = 0.08", "latency_s = 0.125")


def test_a_text_with_a_hash_is_replaced_whole() -> None:
    text = "[camera]\ncalibration = 'a#b.yaml'  # old\n"
    assert changed_text(text, "camera", {"calibration": '"c.yaml"'}) == '[camera]\ncalibration = "c.yaml"  # old\n'


def test_a_setting_that_is_missing_goes_to_the_end_of_its_section() -> None:
    text = "[camera]\n# calibration = 'camera.yaml'\nlatency_s = 0.1\n\n[log]\nlevel = 'info'\n"
    changed = changed_text(text, "camera", {"mount_yaw_deg": "3.5"})
    assert changed == text.replace("latency_s = 0.1\n", "latency_s = 0.1\nmount_yaw_deg = 3.5\n")


@pytest.mark.parametrize("text", ["", "[log]\nlevel = 'info'\n"])
def test_a_section_that_is_missing_is_added(text: str) -> None:
    changed = tomllib.loads(changed_text(text, "camera", {"latency_s": "0.1", "mount_yaw_deg": "2.0"}))
    assert changed["camera"] == {"latency_s": 0.1, "mount_yaw_deg": 2.0}


def test_the_reference_itself_can_be_changed() -> None:
    text = (ROOT / "config.toml").read_text(encoding="utf-8")
    changed = changed_text(text, "camera", {"latency_s": "0.125", "calibration": '"/c.yaml"'})
    assert tomllib.loads(changed)["camera"] | {"latency_s": 0.08} == tomllib.loads(text)["camera"] | {
        "latency_s": 0.08,
        "calibration": "/c.yaml",
    }
    assert len(set(text.splitlines()) - set(changed.splitlines())) == 1


def test_a_file_keeps_its_mode(tmp_path: Path) -> None:
    path = tmp_path / "config.toml"
    path.write_text("[camera]\nlatency_s = 0.1\n")
    path.chmod(0o640)
    write_settings(path, "camera", {"latency_s": "0.2"})
    assert path.read_text() == "[camera]\nlatency_s = 0.2\n"
    assert stat.S_IMODE(path.stat().st_mode) == 0o640
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_that_would_be_wrong_afterwards_is_not_changed(tmp_path: Path) -> None:
    path = tmp_path / "config.toml"
    path.write_text("[camera]\n")
    with pytest.raises(ConfigError, match=r"--apply: .*is not changed.*latency_s: must lie between 0 and 5"):
        write_settings(path, "camera", {"latency_s": "9"})
    assert path.read_text() == "[camera]\n"
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"--apply: .*none\.toml cannot be written: No such file"):
        write_settings(tmp_path / "none.toml", "camera", {"latency_s": "0.1"})
