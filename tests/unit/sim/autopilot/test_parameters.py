from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.sim.autopilot.parameters import ParameterType, copter_parameters


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("FS_GCS_ENABLE", 0),
        ("FENCE_ENABLE", 0),
        ("BATT_FS_LOW_ACT", 0),
        ("RTL_ALT", 1500),
        ("DISARM_DELAY", 10),
        ("FS_OPTIONS", 16),
        ("SYSID_MYGCS", 255),
    ],
)
def test_the_defaults_are_arducopters(name: str, value: float) -> None:
    assert copter_parameters()[name] == value


def test_the_ground_stations_id_has_one_name_at_a_time() -> None:
    old, new = copter_parameters("old"), copter_parameters("new")
    assert "SYSID_MYGCS" in old
    assert "MAV_GCS_SYSID" not in old
    assert new["MAV_GCS_SYSID"] == 255
    assert "SYSID_MYGCS" not in new


def test_the_return_altitude_in_metres_does_not_exist() -> None:
    with pytest.raises(KeyError):
        copter_parameters()["RTL_ALT_M"]


def test_every_parameter_is_found_by_its_place_and_fits_mavlink() -> None:
    parameters = copter_parameters()
    names = [parameters.at(index).name for index in range(len(parameters))]
    assert names == sorted(set(names))
    assert all(parameters.index(name) == index for index, name in enumerate(names))
    assert max(map(len, names)) <= 16
    for index in (-1, len(parameters)):
        with pytest.raises(IndexError):
            parameters.at(index)


@given(st.floats(-1e9, 1e9))
def test_whole_numbers_stay_whole_and_inside_their_type(value: float) -> None:
    parameters = copter_parameters()
    written = parameters.set("FENCE_ACTION", value)
    assert written.type is ParameterType.INT8
    assert written.value == int(written.value)
    assert -128 <= written.value <= 127
    assert parameters["FENCE_ACTION"] == written.value


def test_an_unknown_name_cannot_be_set() -> None:
    with pytest.raises(KeyError):
        copter_parameters().set("NO_SUCH_ONE", 1.0)
