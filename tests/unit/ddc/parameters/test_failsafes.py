"""The autopilot's failsafes: each parameter alone decides, only listed values pass, and nothing unread passes."""

from __future__ import annotations

from collections.abc import Mapping

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.ddc.battery.chemistry import LIHV, LIION, LIPO
from hawk.ddc.parameters.failsafes import (
    ALL_NAMES,
    CEILING_NAME,
    CORNERS_NAME,
    HIGHEST_ID_NAME,
    WATCHED_ID_NAMES,
    AutopilotView,
    check_failsafes,
    return_altitude,
    wanted_values,
    watched_names,
)
from hawk.ddc.parameters.values import (
    ALL_RETURN_NAMES,
    NOT_READ,
    RETURN_ALTITUDE_NAMES,
    THRESHOLD_NAMES,
    FailsafeCheck,
    threshold_problem,
    threshold_words,
)
from hawk.ddc.readings.remote_control import SWITCH_NAMES
from tests.sweep import sweep
from tests.unit.ddc.fakes import DEFAULT_PARAMETERS, SAFE_PARAMETERS

VIEW = AutopilotView(245, cells=(3,), fence_on=True)
SAFE: dict[str, float | None] = dict(SAFE_PARAMETERS)
SAFE_47: dict[str, float | None] = {
    **{
        name: value
        for name, value in SAFE.items()
        if name not in ("SYSID_MYGCS", "RTL_ALT", "RTL_ALT_FINAL", "RTL_CLIMB_MIN", "RTL_SPEED")
    },
    "MAV_GCS_SYSID": 245.0,
    "MAV_GCS_SYSID_HI": 0.0,
    "RTL_ALT_M": 15.0,
    "RTL_SPEED_MS": 0.0,
    "RTL_ALT_FINAL_M": 0.0,
    "RTL_CLIMB_MIN_M": 0.0,
}
CHECK_OF = {
    "FS_GCS_ENABLE": "Ground-station failsafe",
    "FS_GCS_TIMEOUT": "Ground-station failsafe",
    "SYSID_MYGCS": "Ground-station failsafe",
    "MAV_GCS_SYSID": "Ground-station failsafe",
    "MAV_GCS_SYSID_HI": "Ground-station failsafe",
    "FS_OPTIONS": "Pilot keeps control",
    "FS_THR_ENABLE": "Remote-control failsafe",
    "FS_EKF_ACTION": "Position failsafe",
    "FS_EKF_THRESH": "Position failsafe",
    "FENCE_ENABLE": "Fence in the autopilot",
    "FENCE_ACTION": "Fence in the autopilot",
    "FENCE_TYPE": "Fence in the autopilot",
    "BATT_FS_LOW_ACT": "Battery failsafe",
    "BATT_FS_CRT_ACT": "Battery failsafe",
    "BATT_LOW_VOLT": "Battery thresholds",
    "BATT_LOW_MAH": "Battery thresholds",
    "BATT_LOW_TIMER": "Battery thresholds",
    "BATT_CAPACITY": "Battery thresholds",
    "RTL_ALT_FINAL": "Autopilot's return",
    "RTL_ALT_FINAL_M": "Autopilot's return",
    "RTL_CLIMB_MIN": "Autopilot's return",
    "RTL_CLIMB_MIN_M": "Autopilot's return",
    "RTL_ALT_TYPE": "Autopilot's return",
    "RTL_LOIT_TIME": "Autopilot's return",
    "RTL_SPEED": "Autopilot's return",
    "RALLY_TOTAL": "Autopilot's return",
}
RIGHT: dict[str, set[float]] = {
    "FS_GCS_ENABLE": {1, 3, 4, 5},
    "FS_THR_ENABLE": {1, 3, 4, 5},
    "FS_EKF_ACTION": {1, 3},
    "FENCE_ENABLE": {1},
    "FENCE_ACTION": {1, 2, 3, 4, 5},
    "FENCE_TYPE": {5, 7},
    "BATT_FS_LOW_ACT": {1, 2, 3, 4},
    "BATT_FS_CRT_ACT": {0, 1, 2, 3, 4},
    "RTL_ALT_TYPE": {0},
}
"""Written down apart from the program."""
BOUNDS = {
    "FS_GCS_TIMEOUT": ((3, 5, 10), (0, 2.9, 11, 120)),
    "FS_EKF_THRESH": ((0.6, 0.8, 0.800000011920929, 1.0), (0, -1, 0.5, 1.1)),
    "BATT_LOW_VOLT": ((9.9, 10.5, 11.7), (0, 9.8, 11.8, 14.0)),
    "BATT_LOW_TIMER": ((1, 10, 30), (0, 31, 120)),
    "RTL_CLIMB_MIN": ((0, 100, 300), (-1, 301, 3000)),
    "RTL_ALT_FINAL": ((0,), (-1, 1, 200, 1000)),
    "RALLY_TOTAL": ((0,), (1, 6)),
    "RTL_LOIT_TIME": ((0, 5000, 60000), (-1, 60001, 2147483647)),
    "RTL_SPEED": ((0, 100, 2000), (-1, 1, 99, 2001)),
}


def failed(values: Mapping[str, float | None], view: AutopilotView = VIEW) -> list[FailsafeCheck]:
    return [check for check in check_failsafes(values, view) if not check.passed]


@pytest.mark.parametrize("values", [SAFE, SAFE_47], ids=["before 4.7", "4.7"])
def test_what_is_safe_passes(values: dict[str, float | None]) -> None:
    assert failed(values) == []
    assert wanted_values(values, 245) == {}


@pytest.mark.fault("a parameter is not answered", '"not read yet" never passes; each name alone refuses')
@sweep("name", CHECK_OF)
def test_a_parameter_that_was_not_read_has_not_passed(name: str) -> None:
    whole = SAFE if name in SAFE else SAFE_47
    values = {key: value for key, value in whole.items() if key != name}
    (check,) = failed(values)
    assert (check.name, check.value) == (CHECK_OF[name], NOT_READ)
    assert not check.is_read
    assert name in watched_names(values)


def test_every_parameter_that_decides_is_read() -> None:
    read = [set(watched_names({name: 1.0})) for name in RETURN_ALTITUDE_NAMES]
    assert set(watched_names({})).union(*read) == set(ALL_NAMES)
    assert set(watched_names({})) & ALL_RETURN_NAMES == {"RALLY_TOTAL"}
    others = {*RETURN_ALTITUDE_NAMES, *SWITCH_NAMES, "RTL_SPEED_MS", CEILING_NAME, CORNERS_NAME}
    assert {*CHECK_OF, *others} == set(ALL_NAMES)


@pytest.mark.fault(
    "BATT_FS_LOW_ACT 5 (Terminate), 7 (Brake), or any value that is not listed",
    'Arm is refused: "cuts the motors (BATT_FS_LOW_ACT 5)"; Set failsafes sets RTL',
)
@sweep(("name", "value"), [(name, value) for name in RIGHT for value in [*range(-1, 17), 0.5]])
def test_only_the_listed_values_pass(name: str, value: float) -> None:
    found = failed({**SAFE, name: value})
    assert [check.name for check in found] == ([] if value in RIGHT[name] else [CHECK_OF[name]])
    for check in found:
        assert check.consequence
        assert check.remedy
        assert check.can_be_set
        after = {**SAFE, name: value, **wanted_values({**SAFE, name: value}, 245)}
        assert failed(after) == []


@sweep(("name", "value"), [(name, value) for name, (right, _) in BOUNDS.items() for value in right])
def test_a_threshold_within_its_bounds_passes(name: str, value: float) -> None:
    assert failed({**SAFE, name: value}) == []


@pytest.mark.fault(
    "FS_GCS_TIMEOUT, FS_EKF_THRESH out of bounds; FS_EKF_ACTION, FS_THR_ENABLE, FENCE_TYPE, FENCE_ACTION wrong",
    "Arm is refused with consequence and remedy; Set failsafes puts it right",
)
@sweep(("name", "value"), [(name, value) for name, (_, wrong) in BOUNDS.items() for value in wrong])
def test_a_threshold_beyond_its_bounds_does_not_pass(name: str, value: float) -> None:
    (check,) = failed({**SAFE, name: value})
    assert check.name == CHECK_OF[name]
    assert check.consequence
    assert check.remedy
    assert check.can_be_set is (name not in (*THRESHOLD_NAMES, "RALLY_TOTAL"))


WORDS: dict[str, dict[int, str]] = {
    "FS_GCS_ENABLE": {0: "off", 2: "goes on in Auto", 7: "stops and stays in the air"},
    "FS_THR_ENABLE": {0: "off", 2: "goes on in Auto", 7: "stops and stays in the air"},
    "FS_EKF_ACTION": {0: "only reports", 2: "drifts without a position in AltHold"},
    "FENCE_TYPE": {0: "no fence"},
    "FENCE_ACTION": {0: "only reports"},
    "FENCE_ENABLE": {0: "off"},
    "BATT_FS_LOW_ACT": {0: "off", 5: "cuts the motors", 7: "stops and stays in the air"},
    "BATT_FS_CRT_ACT": {5: "cuts the motors", 7: "stops and stays in the air"},
}


@sweep(("name", "value"), [(name, value) for name, words in WORDS.items() for value in words])
def test_a_wrong_value_is_reported_in_words(name: str, value: int) -> None:
    (check,) = failed({**SAFE, name: float(value)})
    assert check.value == f"{WORDS[name][value]} ({name} {value})"


def test_what_is_right_is_reported_in_words() -> None:
    assert [(check.name, check.value) for check in check_failsafes(SAFE | {"FS_GCS_ENABLE": 5.0}, VIEW)][:5] == [
        ("Ground-station failsafe", "lands, watches this station (245)"),
        ("Pilot keeps control", "yes"),
        ("Remote-control failsafe", "returns home"),
        ("Position failsafe", "lands"),
        ("Fence in the autopilot", "on, returns home"),
    ]


def test_set_failsafes_writes_these_values_in_this_order_where_nothing_is_right() -> None:
    wanted = wanted_values({}, 245)
    assert wanted == {
        "MAV_GCS_SYSID": 245.0,
        "FS_OPTIONS": 16.0,
        "FS_GCS_ENABLE": 1.0,
        "FS_GCS_TIMEOUT": 5.0,
        "FS_THR_ENABLE": 1.0,
        "FS_EKF_ACTION": 1.0,
        "FS_EKF_THRESH": 0.8,
        "BATT_FS_LOW_ACT": 2.0,
        "BATT_FS_CRT_ACT": 1.0,
        "FENCE_TYPE": 5.0,
        "FENCE_ACTION": 1.0,
        "FENCE_ENABLE": 1.0,
    }
    assert list(wanted)[-1] == "FENCE_ENABLE", "the fence is enabled last"


@pytest.mark.parametrize("value", [0.0, 1.0, 2.0, 7.0])
@pytest.mark.parametrize("needed", [True, False])
def test_only_without_a_remote_control_its_failsafe_may_be_off(value: float, needed: bool) -> None:
    values = {**SAFE, "FS_THR_ENABLE": value, "FENCE_ENABLE": 0.0}
    check = check_failsafes(values, AutopilotView(245, (3,), fence_on=True, needs_remote_control=needed))[2]
    is_off = value == 0.0 and not needed
    assert check.passed is (is_off or value == 1.0)
    assert (check.value == "off, no remote control is required") is is_off
    wanted = wanted_values(values, 245, needs_remote_control=needed)
    assert ("FS_THR_ENABLE" in wanted) is not check.passed
    assert wanted["FENCE_ENABLE"] == 1.0, "what comes after it is written"


def test_a_remote_control_is_needed_unless_it_is_said_that_it_is_not() -> None:
    values = {**SAFE, "FS_THR_ENABLE": 0.0}
    assert not check_failsafes(values, AutopilotView(245, (3,), fence_on=True))[2].passed
    assert wanted_values(values, 245) == {"FS_THR_ENABLE": 1.0}


def test_with_the_older_name_of_the_station_the_end_of_the_range_is_not_read() -> None:
    assert HIGHEST_ID_NAME in watched_names({"MAV_GCS_SYSID": 245.0})
    assert HIGHEST_ID_NAME not in watched_names({"SYSID_MYGCS": 245.0})


def test_the_option_of_the_pilot_is_bit_four() -> None:
    for options, passes in ((0.0, False), (15.0, False), (16.0, True), (47.0, False), (48.0, True)):
        assert check_failsafes({**SAFE, "FS_OPTIONS": options}, VIEW)[1].passed is passes


@pytest.mark.fault("BATT_FS_LOW_ACT 5 (Terminate), 7 (Brake), or any value that is not listed")
def test_terminate_does_not_return_home() -> None:
    (check,) = failed({**SAFE, "BATT_FS_LOW_ACT": 5.0})
    assert check.value == "cuts the motors (BATT_FS_LOW_ACT 5)"


@pytest.mark.fault(
    "MAV_GCS_SYSID_HI makes a range: any other station keeps the failsafe quiet",
    "Arm is refused; Set failsafes sets 0",
)
def test_another_station_must_not_keep_the_failsafe_quiet() -> None:
    assert failed({**SAFE_47, HIGHEST_ID_NAME: 245.0}) == []
    assert failed({**SAFE_47, HIGHEST_ID_NAME: None}) == []
    (check,) = failed({**SAFE_47, HIGHEST_ID_NAME: 255.0})
    assert check.value == "watches every station from 245 to 255: any of them keeps it quiet"
    assert wanted_values({**SAFE_47, HIGHEST_ID_NAME: 255.0}, 245) == {HIGHEST_ID_NAME: 0.0}


@pytest.mark.parametrize("watched", [0.0, 1.0, 244.0, 246.0, 255.0])
def test_the_watched_station_must_be_this_one(watched: float) -> None:
    (check,) = failed({**SAFE, "SYSID_MYGCS": watched})
    assert check.value == f"watches station {watched:.0f}, this is 245"


@pytest.mark.fault("a switch or MAV_CMD_DO_FENCE_ENABLE turns the fence off, FENCE_ENABLE stays 1")
def test_a_fence_that_a_switch_turned_off_does_not_pass() -> None:
    (check,) = failed(SAFE, AutopilotView(245, (3,), fence_on=False))
    assert (check.value, check.can_be_set) == ("switched off", False)
    (check,) = failed(SAFE, AutopilotView(245, (3,), fence_on=None))
    assert check.value == NOT_READ


@pytest.mark.fault(
    "rally points, RTL_ALT_FINAL above 0, RTL_CLIMB_MIN above 3 m, RTL_ALT_TYPE terrain: RTL ends elsewhere, "
    "in the air, or above the ceiling",
    "Arm is refused with what it would do; Set failsafes puts it right, but deletes no rally point; rally "
    "points that another station uploads in flight are cleared",
)
@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("RTL_ALT_FINAL_M", 2.0, "stays in the air above home (RTL_ALT_FINAL_M 2)"),
        ("RTL_CLIMB_MIN_M", 3.5, "climbs first, above the ceiling (RTL_CLIMB_MIN_M 3.5)"),
        ("RTL_ALT_TYPE", 1.0, "follows a terrain that it may not know (RTL_ALT_TYPE 1)"),
        ("RALLY_TOTAL", 2.0, "to a rally point where one is nearer (RALLY_TOTAL 2)"),
    ],
)
def test_a_return_must_end_on_the_ground_at_home(name: str, value: float, words: str) -> None:
    (check,) = failed({**SAFE_47, name: value})
    assert (check.name, check.value) == ("Autopilot's return", words)


def test_a_climb_in_metres_is_not_one_in_centimetres() -> None:
    assert failed({**SAFE_47, "RTL_CLIMB_MIN_M": 3.0}) == []
    assert failed({**SAFE, "RTL_CLIMB_MIN": 300.0}) == []
    assert wanted_values({**SAFE_47, "RTL_CLIMB_MIN_M": 4.0}, 245) == {"RTL_CLIMB_MIN_M": 0.0}
    assert wanted_values({**SAFE, "RTL_ALT_FINAL": 4.0}, 245) == {"RTL_ALT_FINAL": 0.0}


def test_an_autopilot_without_rally_points_passes() -> None:
    assert failed({**SAFE, "RALLY_TOTAL": None}) == []


def test_rally_points_are_not_deleted() -> None:
    assert wanted_values({**SAFE, "RALLY_TOTAL": 3.0}, 245) == {}


# -- thresholds of the battery ----------------------------------------------------------------------------------------


def thresholds(view: AutopilotView = VIEW, **changed: float) -> FailsafeCheck:
    return check_failsafes({**SAFE, **changed}, view)[-1]


@pytest.mark.fault(
    "BATT_LOW_VOLT and BATT_LOW_MAH are 0, or BATT_LOW_TIMER is 0: the battery failsafe never triggers",
    "Arm is refused with the value to set; Set failsafes never writes it",
)
def test_thresholds_that_are_off_never_trigger() -> None:
    check = thresholds(BATT_LOW_VOLT=0, BATT_LOW_MAH=0)
    assert not check.passed
    assert check.value == "off: BATT_LOW_VOLT and BATT_LOW_MAH are 0"
    assert check.remedy == "Set BATT_LOW_VOLT in the autopilot to 10.5 V, 3.5 V for each of 3 cells."
    assert not check.can_be_set


@pytest.mark.fault(
    "low voltage of three cells on a battery of four",
    'Arm is refused: "2.62 V a cell of 4", set 14.0 V',
)
def test_the_default_of_three_cells_is_too_late_for_four() -> None:
    check = thresholds(AutopilotView(245, (4,), True))
    assert not check.passed
    assert "2.62 V a cell of 4" in check.value
    assert "14.0 V" in check.remedy
    assert thresholds(AutopilotView(245, (4,), True), BATT_LOW_VOLT=14.0).passed


@pytest.mark.fault("BATT_LOW_VOLT is 0, BATT_LOW_MAH alone is set", "Arm is refused with the voltage to set")
@pytest.mark.parametrize("charge", [0, 100, 330, 660, 1980, 2200])
def test_a_charge_alone_is_not_enough(charge: float) -> None:
    """It is the counter's, which begins at 100 % with any battery."""
    check = thresholds(BATT_LOW_VOLT=0, BATT_LOW_MAH=charge)
    assert not check.passed
    assert "Set BATT_LOW_VOLT" in check.remedy


def test_a_charge_stands_for_no_voltage_that_does_not_trigger() -> None:
    assert not thresholds(BATT_LOW_VOLT=9.0, BATT_LOW_MAH=660).passed
    assert not thresholds(BATT_LOW_TIMER=0, BATT_LOW_MAH=660).passed
    assert not thresholds(BATT_LOW_VOLT=14.0, BATT_LOW_MAH=660).passed
    assert thresholds(BATT_LOW_MAH=660).passed


def test_the_low_voltage_belongs_to_the_chemistry() -> None:
    view = AutopilotView(245, (3,), True, chemistry=LIION)
    assert thresholds(view, BATT_LOW_VOLT=9.6).passed
    assert not thresholds(view, BATT_LOW_VOLT=8.4).passed
    assert "9.6 V, 3.2 V for each of 3 cells" in thresholds(view, BATT_LOW_VOLT=12.0).remedy
    assert not thresholds(AutopilotView(245, (3,), True), BATT_LOW_VOLT=9.6).passed
    assert thresholds(AutopilotView(245, (3,), True, chemistry=LIHV), BATT_LOW_VOLT=12.0).passed


@pytest.mark.fault("cells not known, or two counts possible", "Arm is refused, the remedy names flight.battery_cells")
def test_unknown_cells_do_not_pass_and_name_the_setting() -> None:
    check = thresholds(AutopilotView(245, (), True))
    assert not check.passed
    assert "flight.battery_cells" in check.remedy


@pytest.mark.fault("cells not known, or two counts possible")
def test_a_battery_that_may_be_one_of_two_must_fit_both() -> None:
    check = thresholds(AutopilotView(245, (5, 6), True), BATT_LOW_VOLT=17.5)
    assert not check.passed
    assert "flight.battery_cells" in check.remedy
    assert thresholds(AutopilotView(245, (5,), True), BATT_LOW_VOLT=17.5).passed


@pytest.mark.parametrize(
    ("voltage", "cells"),
    [
        (12.6, (3,)),
        (10.6, (3,)),
        (12.0, (3,)),
        (16.8, (4,)),
        (14.1, (4,)),
        (21.0, (5, 6)),
        (25.2, (6,)),
        (50.4, (12, 14)),
        (13.3, ()),
        (0.0, ()),
        (None, ()),
    ],
)
def test_the_cells_by_the_voltage_at_rest(voltage: float | None, cells: tuple[int, ...]) -> None:
    assert LIPO.possible_cells(voltage, None, in_flight=False) == cells
    assert LIPO.possible_cells(voltage, 6, in_flight=False) == (6,)


@given(st.sampled_from([2, 3, 4, 6, 8]), st.floats(3.5, 4.2))
def test_the_true_cells_are_among_the_possible_ones(count: int, each: float) -> None:
    assert count in LIPO.possible_cells(count * each, None, in_flight=False)


# -- Set Failsafes ----------------------------------------------------------------------------------------------------


@pytest.mark.slow
@given(
    st.dictionaries(st.sampled_from(sorted(RIGHT)), st.integers(-1, 63).map(float)),
    st.sampled_from(["MAV_GCS_SYSID", "SYSID_MYGCS"]),
    st.integers(1, 255),
    st.integers(0, 63),
    st.none() | st.integers(0, 255),
)
def test_what_is_wanted_always_makes_the_checks_pass(
    found: dict[str, float], name: str, watched: int, options: int, highest: int | None
) -> None:
    whole = SAFE if name == "SYSID_MYGCS" else {**SAFE_47, HIGHEST_ID_NAME: highest}
    values = {**whole, **found, name: float(watched), "FS_OPTIONS": float(options)}
    after = {**values, **wanted_values(values, 245)}
    assert failed(after) == []
    assert wanted_values(after, 245) == {}
    assert int(after["FS_OPTIONS"] or 0) & options == options


def test_it_never_writes_a_threshold_of_the_battery() -> None:
    assert not set(wanted_values({}, 245)) & set(THRESHOLD_NAMES)


def test_the_defaults_of_arducopter_pass_after_it() -> None:
    values: dict[str, float | None] = dict(DEFAULT_PARAMETERS)
    assert [check.name for check in failed(values) if not check.can_be_set] == []
    assert failed({**values, **wanted_values(values, 245)}) == []


def test_a_name_is_given_up_only_when_the_other_one_answers() -> None:
    for newer, older in (WATCHED_ID_NAMES, RETURN_ALTITUDE_NAMES):
        assert {newer, older} <= set(watched_names({}))
        assert {newer, older} <= set(watched_names({newer: None}))
        assert set(watched_names({newer: 1.0})) & {newer, older} == {newer}
        assert set(watched_names({older: 1.0})) & {newer, older} == {older}


def test_the_return_altitude_in_either_unit() -> None:
    assert return_altitude({"RTL_ALT_M": 30.0}) == 30
    assert return_altitude({"RTL_ALT_M": None, "RTL_ALT": 1500.0}) == 15
    assert return_altitude({}) is None


def written(**values: float) -> dict[str, float]:
    """Right thresholds for three cells, and what a test changes of them."""
    right = {"BATT_LOW_VOLT": 10.5, "BATT_LOW_MAH": 0.0, "BATT_LOW_TIMER": 10.0, "BATT_CAPACITY": 5000.0}
    return right | values


@pytest.mark.parametrize(
    ("values", "cells", "found"),
    [
        ({}, (3,), None),
        ({"BATT_LOW_VOLT": 0.0}, (3,), "off"),
        ({"BATT_LOW_VOLT": 1.0}, (3,), "0.33 V a cell of 3"),
        ({"BATT_LOW_VOLT": 0.5}, (3,), "0.17 V a cell of 3"),
        ({"BATT_LOW_VOLT": 0.0, "BATT_LOW_MAH": 1.0}, (3,), "no voltage: BATT_LOW_VOLT is 0"),
        ({"BATT_LOW_VOLT": 0.0, "BATT_LOW_MAH": 0.5}, (3,), "no voltage: BATT_LOW_VOLT is 0"),
        ({"BATT_LOW_MAH": 1.0, "BATT_CAPACITY": 1.0}, (3,), "would return at once"),
        ({"BATT_LOW_MAH": 0.5, "BATT_CAPACITY": 1.0}, (3,), None),
        ({"BATT_LOW_VOLT": 3.3 * 4}, (4,), None),
        ({"BATT_LOW_VOLT": 13.1}, (4,), "3.27 V a cell of 4"),
        ({"BATT_LOW_VOLT": 15.6}, (4,), None),
        ({"BATT_LOW_VOLT": 15.7}, (4,), "3.92 V a cell of 4"),
        ({"BATT_LOW_TIMER": 1.0}, (3,), None),
        ({"BATT_LOW_TIMER": 0.9}, (3,), "must be 1 to 30 s"),
        ({"BATT_LOW_TIMER": 30.0}, (3,), None),
        ({"BATT_LOW_TIMER": 30.1}, (3,), "must be 1 to 30 s"),
        ({"BATT_LOW_MAH": 3000.0}, (3,), None),
        ({"BATT_LOW_MAH": 3001.0}, (3,), "would return at once"),
        ({"BATT_LOW_VOLT": 0.0, "BATT_LOW_MAH": 1000.0}, (3,), "no voltage"),
        ({"BATT_LOW_VOLT": 8.0, "BATT_LOW_MAH": 1000.0}, (3,), "2.67 V a cell of 3"),
        ({"BATT_LOW_VOLT": 15.7, "BATT_LOW_MAH": 1000.0}, (4,), "3.92 V a cell of 4"),
        ({"BATT_CAPACITY": 0.0, "BATT_LOW_MAH": 1000.0}, (3,), None),
        ({}, (), "not known"),
    ],
)
def test_thresholds_at_their_limits(values: dict[str, float], cells: tuple[int, ...], found: str | None) -> None:
    problem = threshold_problem(written(**values), cells)
    if found is None:
        assert problem is None
    else:
        assert problem is not None
        assert found in problem.value


@pytest.mark.parametrize(
    ("values", "cells", "remedy"),
    [
        ({"BATT_LOW_VOLT": 0.0}, (4,), "14.0 V, 3.5 V for each of 4 cells"),
        ({"BATT_LOW_VOLT": 0.0}, (3, 4), "3.5 V for each cell"),
        ({"BATT_LOW_VOLT": 8.0}, (3,), "10.5 V, 3.5 V for each of 3 cells"),
        ({"BATT_LOW_VOLT": 8.0}, (3, 4), "flight.battery_cells"),
        ({"BATT_LOW_MAH": 4000.0}, (3,), "BATT_LOW_MAH to 1000"),
        ({"BATT_LOW_VOLT": 0.0, "BATT_LOW_MAH": 100.0}, (3,), "10.5 V, 3.5 V for each of 3 cells"),
        ({"BATT_LOW_TIMER": 0.0}, (3,), "BATT_LOW_TIMER to 10 s"),
    ],
)
def test_a_wrong_threshold_names_its_remedy(values: dict[str, float], cells: tuple[int, ...], remedy: str) -> None:
    problem = threshold_problem(written(**values), cells)
    assert problem is not None
    assert remedy in problem.remedy


@pytest.mark.parametrize(
    ("values", "cells", "words"),
    [
        ({}, (3,), "below 10.5 V (3.50 V a cell) for 10 s"),
        ({}, (3, 4), "below 10.5 V for 10 s"),
        ({"BATT_LOW_MAH": 1000.0}, (3,), "below 10.5 V (3.50 V a cell) for 10 s or below 1000 mAh"),
    ],
)
def test_right_thresholds_in_words(values: dict[str, float], cells: tuple[int, ...], words: str) -> None:
    assert threshold_words(written(**values), cells) == words


def test_the_cells_of_a_battery_that_sags_in_flight() -> None:
    def cells(volts: float | None, configured: int | None = None, *, in_flight: bool = False) -> tuple[int, ...]:
        return LIPO.possible_cells(volts, configured, in_flight=in_flight)

    assert cells(3.3 * 4, in_flight=True) == (4,)
    assert cells(3.3 * 4) == ()
    assert cells(4.25 * 3) == (3,)
    assert cells(4.25 * 3 + 0.01) == ()
    assert cells(3.5 * 4) == (4,)
    assert cells(None, 6) == (6,)
    assert cells(3.1 * 3, in_flight=True) == (3,), "below its limits, too, where one count fits"
    assert cells(2.8 * 3 - 0.01, in_flight=True) == (2,)
    assert cells(3.3 * 14 - 0.1, in_flight=True) == (12,)
    assert cells(2.8 * 14 + 0.1, in_flight=True) == (10,)
    assert cells(2.79 * 2, in_flight=True) == ()


def test_a_check_is_read_when_its_parameters_are_and_offers_set_failsafes_only_where_that_helps() -> None:
    unread = check_failsafes({}, VIEW)
    assert not any(check.passed or check.is_read for check in unread)
    settable = {check.name for check in unread if check.can_be_set}
    assert settable == {check.name for check in unread} - {"Battery thresholds"}
    off = {check.name: check for check in check_failsafes(SAFE, AutopilotView(245, (3,), fence_on=False))}
    fence = off["Fence in the autopilot"]
    assert (fence.passed, fence.can_be_set, fence.value) == (False, False, "switched off")


def test_a_range_of_watched_stations_ends_at_the_first() -> None:
    for highest, passes in ((244.0, True), (245.0, True), (246.0, False)):
        values = SAFE_47 | {"MAV_GCS_SYSID_HI": highest}
        assert check_failsafes(values, VIEW)[0].passed is passes
        assert ("MAV_GCS_SYSID_HI" in wanted_values(values, 245)) is not passes


def test_only_what_is_wrong_is_written_and_other_options_are_kept() -> None:
    assert wanted_values(SAFE, 245) == {}
    assert wanted_values(SAFE | {"FS_OPTIONS": 3.0}, 245) == {"FS_OPTIONS": 19.0}
    assert wanted_values(SAFE | {"SYSID_MYGCS": 255.0}, 245) == {"SYSID_MYGCS": 245.0}
    assert wanted_values(SAFE | {"FS_GCS_ENABLE": 0.0}, 245) == {"FS_GCS_ENABLE": 1.0}


def test_options_that_were_not_read_are_taken_for_none() -> None:
    unread = {name: value for name, value in SAFE.items() if name != "FS_OPTIONS"}
    assert wanted_values(unread, 245) == {"FS_OPTIONS": 16.0}


@pytest.mark.parametrize("highest", [None, 0.0])
def test_a_station_without_a_range_is_named_alone(highest: float | None) -> None:
    values = SAFE_47 | {"MAV_GCS_SYSID": 0.0, "MAV_GCS_SYSID_HI": highest}
    assert check_failsafes(values, VIEW)[0].value == "watches station 0, this is 245"


def test_a_return_altitude_in_centimetres_is_given_in_metres() -> None:
    assert return_altitude({"RTL_ALT": 1500.0}) == 15.0
    assert return_altitude({"RTL_ALT_M": 12.0, "RTL_ALT": 1500.0}) == 12.0
    assert return_altitude({}) is None
