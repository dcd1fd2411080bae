"""Every number in the settings has a lowest and a highest value, and one beyond them is refused by both."""

from __future__ import annotations

import math
import re
import types
import typing
from pathlib import Path
from typing import Any

import pytest

from hawk.config.loader import load_config
from hawk.config.sections import Config, ConfigError, Section, bounds
from tests.sweep import sweep

REFERENCE = Path(__file__).parents[3] / "config.toml"
NUMBERS = (int, float)
NO_NUMBERS = (math.nan, math.inf, -math.inf, "many")


def is_number(annotation: Any) -> bool:
    kinds = typing.get_args(annotation) if isinstance(annotation, types.UnionType) else (annotation,)
    return any(kind in NUMBERS for kind in kinds)


def numeric() -> list[tuple[str, str]]:
    sections = {name: type(section) for name, section in Config() if isinstance(section, Section)}
    return [
        (name, key)
        for name, section in sections.items()
        for key, field in section.model_fields.items()
        if is_number(field.annotation)
    ]


def test_every_number_of_the_settings_is_tried() -> None:
    defaults = Config().model_dump()
    numbers = {
        (s, k) for s, v in defaults.items() if isinstance(v, dict) for k, each in v.items() if type(each) in NUMBERS
    }
    assert numbers <= set(numeric())
    assert ("flight", "explore_cm_per_pixel") in numeric()
    assert len(numeric()) > 35


@pytest.mark.fault(
    "a number in the settings beyond what is physically right",
    "the daemon does not start; file, line, name, value and both bounds are shown",
)
@sweep("section, key", numeric())
def test_a_number_beyond_either_bound_is_refused_with_name_value_and_both_bounds(section: str, key: str) -> None:
    found = bounds(section, key)
    assert found is not None, "has no bounds"
    lowest, highest = found
    assert lowest < highest
    default = getattr(getattr(Config(), section), key)
    assert default is None or lowest <= default <= highest
    for beyond in (lowest - 0.01 if lowest % 1 else lowest - 1, highest + 1):
        with pytest.raises(ConfigError) as caught:
            load_config(None, {}, {section: {key: beyond}})
        text = str(caught.value)
        assert f"{section}.{key}: must lie between {lowest:.10g} and {highest:.10g} (found {beyond!r})" in text


@sweep("section, key", numeric())
def test_the_reference_names_both_bounds(section: str, key: str) -> None:
    found = bounds(section, key)
    assert found is not None
    part = REFERENCE.read_text().split(f"[{section}]", 1)[1].split("\n[", 1)[0]
    assert re.search(rf"^(# )?{key} = \S+  # {found[0]:.10g} to {found[1]:.10g}$", part, re.MULTILINE)


@sweep(
    "section, key, value", [(*each, value) for each in numeric() for value in (math.nan, math.inf, -math.inf, "many")]
)
def test_what_is_no_number_is_refused(section: str, key: str, value: object) -> None:
    with pytest.raises(ConfigError, match=rf"{section}\.{key}: "):
        load_config(None, {}, {section: {key: value}})


@pytest.mark.parametrize(
    ("section", "key", "value"),
    [
        ("heights", "ceiling_m", 1e6),
        ("heights", "minimum_m", 0.5),
        ("flight", "maximum_hdop_m", 50.0),
        ("flight", "arrival_radius_m", 500.0),
        ("flight", "speed_m_s", 1e-3),
        ("autopilot", "position_rate_hz", 0.5),
        ("operator", "operator_timeout_s", 3600.0),
        ("operator", "operator_hold_s", 3600.0),
        ("store", "minimum_free_mb", 10**12),
    ],
)
def test_a_value_that_would_undo_a_safety_rule_is_refused(section: str, key: str, value: float) -> None:
    with pytest.raises(ConfigError, match=rf"{section}\.{key}: must lie between"):
        load_config(None, {}, {section: {key: value}})


def test_a_drone_that_may_arm_below_its_reserve_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"flight: battery_arm_percent \(10\) must not be less than battery_reserve"):
        load_config(None, {}, {"flight": {"battery_arm_percent": 10, "battery_reserve_percent": 20}})
