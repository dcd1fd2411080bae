"""Each check before Arm at its limits, from facts that are written down."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from hawk.comm.protocol.heartbeat import CheckItem
from hawk.config.sections import FenceSettings, FlightSettings, HeightSettings, OperatorSettings, RemoteControlSettings
from hawk.ddc.battery.charge import ChargeFacts
from hawk.ddc.battery.chemistry import LIION, LIPO
from hawk.ddc.battery.survey import SurveyNeed
from hawk.ddc.facts import Facts
from hawk.ddc.fence.geometry import Ring, ring_from_map
from hawk.ddc.fence.plan import FencePlan
from hawk.ddc.parameters.failsafes import FlightLimits
from hawk.ddc.readings.belief import GroundFacts
from hawk.ddc.readings.clearance import BelowFacts, Slope
from hawk.ddc.readings.home import HomeFacts
from hawk.ddc.rules.preflight import autopilot_view, failsafe_checks, preflight_items
from hawk.ddc.settings import DdcSettings
from hawk.model.operation import Fall, Health, HealthStatus
from hawk.model.plans import Fence, HeightParameters
from hawk.model.poses import GlobalPose
from hawk.model.vehicle import BatteryInfo, LandedState
from tests.unit.ddc.fakes import SAFE_PARAMETERS
from tests.unit.ddc.written_facts import DATUM, FENCE, PARTS, SETTINGS, flying, on_ground

NOW = 100.0
SQUARE: Ring = ((-100.0, -100.0), (100.0, -100.0), (100.0, 100.0), (-100.0, 100.0))
L_SHAPE: Ring = ((-100.0, -100.0), (100.0, -100.0), (100.0, -40.0), (-20.0, -40.0), (-20.0, 100.0), (-100.0, 100.0))


def standing() -> Facts:
    """A drone that stands at the datum, disarmed, with everything well."""
    facts = on_ground(flying(NOW))
    home = HomeFacts(place=DATUM, age=1.0)
    return replace(facts, position=replace(facts.position, autopilot_home=home))


def north(metres: float) -> GlobalPose:
    """Return the place so far north of the datum."""
    ((latitude, longitude),) = ring_from_map(DATUM, ((metres, 0.0),))
    return GlobalPose(latitude, longitude, DATUM.altitude)


def drawn(ring: Ring, *zones: Ring) -> FencePlan:
    return FencePlan("drawn", ring_from_map(DATUM, ring), 100.0, tuple(ring_from_map(DATUM, zone) for zone in zones))


def with_parts(facts: Facts, **healths: Health) -> Facts:
    return replace(facts, parts=tuple((name, healths.get(name, Health())) for name in PARTS))


def with_diagnostics(facts: Facts, **changes: Any) -> Facts:
    return replace(facts, diagnostics=replace(facts.diagnostics, **changes))


def with_battery(percentage: float | None, voltage: float | None = 12.0, charge: ChargeFacts | None = None) -> Facts:
    facts = standing()
    info = BatteryInfo(percentage, voltage, 10.0, NOW)
    return replace(facts, battery=replace(facts.battery, info=info, charge=charge or ChargeFacts()))


def with_plan(plan: FencePlan, problem: str = "") -> Facts:
    facts = standing()
    return replace(facts, limits=replace(facts.limits, plan=plan, plan_problem=problem))


def with_home(**changes: Any) -> Facts:
    facts = standing()
    home = replace(facts.position.autopilot_home, **changes)
    return replace(facts, position=replace(facts.position, autopilot_home=home))


def check(
    name: str,
    facts: Facts,
    settings: DdcSettings = SETTINGS,
    values: dict[str, float | None] | None = None,
    *,
    is_killed: bool = False,
    fall: Fall | None = None,
) -> CheckItem:
    known = dict(SAFE_PARAMETERS) if values is None else values
    items = preflight_items(facts, known, settings, is_killed=is_killed, fall=fall)
    (found,) = (item for item in items if item.name == name)
    assert found.passed or (found.consequence and found.remedy), "a failed check has a consequence and a remedy"
    return found


def passes(name: str, facts: Facts, value: str, settings: DdcSettings = SETTINGS) -> None:
    found = check(name, facts, settings)
    assert (found.passed, found.value, found.remedy_command) == (True, value, None)


def fails(name: str, facts: Facts, value: str, settings: DdcSettings = SETTINGS) -> CheckItem:
    found = check(name, facts, settings)
    assert (found.passed, found.value) == (False, value)
    return found


def test_all_is_well() -> None:
    items = preflight_items(standing(), dict(SAFE_PARAMETERS), SETTINGS, is_killed=False)
    assert all(item.passed for item in items), [item for item in items if not item.passed]
    assert [(item.name, item.value) for item in items][:12] == [
        ("Motors", "free to start"),
        ("Link", "0.1 s"),
        ("Autopilot", "its sensors are well"),
        ("GPS", "16 satellites, ±0.9 m"),
        ("Battery", "80 %, 12.0 V"),
        ("Remote control", "switch at STABILIZE (position 6), 8 channels"),
        ("Camera", "on"),
        ("Recording", "on"),
        ("Heights", "35 m, never below 15 m or above 60 m; no obstacle declared"),
        ("Fence", "290 × 290 m, drone and home inside"),
        ("Home", "at the drone"),
        ("Return height", "15 m, ceiling 97 m"),
    ]


def test_motors_that_were_cut_and_motors_that_went_off_in_the_air() -> None:
    cut = check("Motors", standing(), is_killed=True)
    assert (cut.passed, cut.value, cut.remedy_command) == (False, "cut", "Clear Kill")
    fell = check("Motors", standing(), is_killed=True, fall=Fall(0.0, height=3.0))
    assert fell.value == "off in the air at 3.0 m, 1970-01-01 00:00:00 UTC"
    assert check("Motors", standing(), fall=Fall(0.0)).passed, "it was cleared"


class TestLink:
    def test_a_second_sender_counts_also_where_the_autopilot_is_heard(self) -> None:
        facts = standing()
        fails(
            "Link",
            replace(facts, link=replace(facts.link, second_sender="10.0.0.6 sends, too.")),
            "10.0.0.6 sends, too.",
        )

    def test_one_that_is_down_fails_by_either_word(self) -> None:
        facts = standing()
        fails("Link", replace(facts, link=replace(facts.link, is_up=False)), "looking at it")
        fails("Link", with_parts(facts, link=Health.bad("No word from the autopilot.")), "No word from the autopilot.")


class TestSensors:
    def test_one_that_is_not_known_to_stand(self) -> None:
        facts = standing()
        unsure = replace(facts, vehicle=replace(facts.vehicle, landed=LandedState.UNDEFINED))
        found = fails("Autopilot", unsure, "it is not known to be on the ground")
        assert found.consequence == "Its landing would not be seen."
        fails("Autopilot", replace(unsure, ground=GroundFacts(doubt="it climbs")), "it climbs")
        fails("Autopilot", with_diagnostics(unsure, all_ok=False), "its sensors are not ready")

    def test_compasses(self) -> None:
        for well in (True, None):
            passes("Autopilot", with_diagnostics(standing(), compass_ok=well), "its sensors are well")
        found = check("Autopilot", with_diagnostics(standing(), compass_ok=False))
        assert not found.passed
        assert found.remedy == "Check the compasses."

    def test_the_autopilots_own_words(self) -> None:
        bad = with_diagnostics(standing(), all_ok=False)
        fails("Autopilot", bad, "its sensors are not ready")
        fails("Autopilot", replace(bad, link=replace(bad.link, words="PreArm: Gyros")), "PreArm: Gyros")


class TestGps:
    @pytest.mark.parametrize(
        ("changes", "passed", "value"),
        [
            ({"gps_fix": 3}, True, "16 satellites, ±0.9 m"),
            ({"gps_fix": 4}, True, "16 satellites, ±0.9 m"),
            ({"gps_fix": 2}, False, "no fix, 16 satellites, ±0.9 m"),
            ({"gps_fix": None}, False, "no fix, 16 satellites, ±0.9 m"),
            ({"satellites": None}, True, "±0.9 m"),
            ({"horizontal_accuracy": 3.0}, True, "16 satellites, ±3.0 m"),
            ({"horizontal_accuracy": 3.01}, False, "16 satellites, ±3.0 m"),
            ({"horizontal_accuracy": None}, False, "16 satellites, accuracy unknown"),
            ({"global_position_ok": False}, False, "16 satellites, ±0.9 m"),
            (
                {"global_position_ok": False, "estimator_fault": "GPS glitch"},
                False,
                "16 satellites, ±0.9 m, GPS glitch",
            ),
            ({"is_mavlink_1": True}, True, "16 satellites, ±0.9 m"),
            ({"is_mavlink_1": True, "gps_fix": 2}, False, "no fix, 16 satellites, ±0.9 m"),
        ],
    )
    def test_each_reading_alone(self, changes: dict[str, Any], passed: bool, value: str) -> None:
        found = check("GPS", with_diagnostics(standing(), **changes))
        assert (found.passed, found.value) == (passed, value)

    def test_a_position_that_is_not_trusted(self) -> None:
        fails("GPS", with_parts(standing(), position=Health.bad("it creeps")), "16 satellites, ±0.9 m")

    def test_mavlink_1_has_its_own_remedy(self) -> None:
        found = check("GPS", with_diagnostics(standing(), horizontal_accuracy=None, is_mavlink_1=True))
        assert not found.passed
        assert found.value == "16 satellites, accuracy unknown: the link speaks MAVLink 1, which has none"
        assert "SERIALn_PROTOCOL" in found.remedy


class TestBattery:
    def test_one_that_is_not_known(self) -> None:
        fails("Battery", replace(standing(), battery=replace(standing().battery, info=None)), "not known")
        fails("Battery", with_battery(None), "not known")

    @pytest.mark.parametrize("voltage", [None, 0.0, 3.9])
    def test_a_counter_alone_is_no_witness(self, voltage: float | None) -> None:
        fails("Battery", with_battery(80.0, voltage), "80 %, voltage not known")

    def test_the_least_voltage_is_that_of_the_smallest_pack(self) -> None:
        passes("Battery", with_battery(80.0, 4.0), "80 %, 4.0 V")

    def test_the_least_charge(self) -> None:
        passes("Battery", with_battery(30.0), "30 %, 12.0 V")
        found = fails("Battery", with_battery(29.9), "30 %, 12.0 V")
        assert found.remedy == "Charge it to 30 % or more."

    def test_the_voltage_may_allow_less_than_the_counter_says(self) -> None:
        def charge(allowed: float) -> ChargeFacts:
            return ChargeFacts(counter=45.0, volts=3.7, cells=3, allowed=allowed)

        passes("Battery", with_battery(45.0, 11.1, charge(30.0)), "45 %, 11.1 V, 3.70 V a cell of 3")
        fails("Battery", with_battery(45.0, 11.1, charge(29.0)), "45 %, 11.1 V, 3.70 V a cell of 3: 29 % at most")
        fails("Battery", with_battery(20.0, 11.1, charge(50.0)), "20 %, 11.1 V, 3.70 V a cell of 3")
        fails("Battery", with_battery(20.0, 11.1, charge(20.0)), "20 %, 11.1 V, 3.70 V a cell of 3")

    def test_a_doubted_counter(self) -> None:
        facts = with_battery(80.0, 11.1, ChargeFacts(volts=3.7, cells=3, allowed=80.0, doubt="it says too much"))
        fails("Battery", facts, "11.1 V; it says too much")

    def test_no_cell_holds_more_than_a_full_one(self) -> None:
        top = LIPO.resting[1]
        passes(
            "Battery", with_battery(80.0, 12.75, ChargeFacts(volts=top, cells=3)), "80 %, 12.8 V, 4.25 V a cell of 3"
        )
        found = fails(
            "Battery",
            with_battery(80.0, 12.8, ChargeFacts(volts=top + 0.02, cells=3)),
            "80 %, 12.8 V, 4.27 V a cell of 3",
        )
        assert found.consequence == "No such cell holds so much: its voltage is not known."


def test_a_survey_is_reported_and_refuses_nothing() -> None:
    facts = standing()
    names = [item.name for item in preflight_items(facts, {}, SETTINGS, is_killed=False)]
    assert "Survey" not in names
    need = SurveyNeed("fence", 84_100.0, 900.0, 90.0, 25.0, 80.0)
    assert check("Survey", replace(facts, battery=replace(facts.battery, survey=need))).passed


def test_camera_and_recording() -> None:
    facts = standing()
    young = replace(facts, sight=replace(facts.sight, camera_age=1.26))
    passes("Camera", young, "picture 1.3 s old")
    damaged = Health(HealthStatus.HEALTHY, "1 picture was damaged")
    passes("Camera", with_parts(young, camera=damaged), "picture 1.3 s old, 1 picture was damaged")
    passes("Camera", with_parts(facts, camera=damaged), "on, 1 picture was damaged")
    fails("Camera", with_parts(young, camera=Health.bad("no picture")), "no picture")
    passes("Recording", with_parts(facts, recording=Health(HealthStatus.HEALTHY, "5 GB free")), "5 GB free")
    fails("Recording", with_parts(facts, recording=Health.bad("disk full")), "disk full")


class TestHeights:
    def test_they_lie_under_the_ceiling_of_the_planned_fence(self) -> None:
        def under(planned: float) -> Facts:
            facts = standing()
            limits = replace(facts.limits, heights=HeightParameters(15.0, 20.0, 60.0), planned_ceiling=planned)
            return replace(facts, limits=limits)

        assert check("Heights", under(60.0)).passed
        found = check("Heights", under(59.9))
        assert not found.passed
        assert "ceiling" in found.consequence

    def test_the_declared_obstacle(self) -> None:
        settings = replace(SETTINGS, heights=HeightSettings(minimum_m=15.0, highest_obstacle_m=9.5))
        assert check("Heights", standing(), settings).value.endswith("above 60 m; highest obstacle 9.5 m")


class TestFence:
    def test_the_drone_stands_inside_or_on_the_edge(self) -> None:
        square = with_plan(drawn(SQUARE))
        passes("Fence", square, "190 × 190 m, drone and home inside")
        beside = with_plan(drawn(tuple((n + 150.0, e) for n, e in SQUARE)))
        found = fails("Fence", beside, "190 × 190 m, drone 55 m outside the dotted line")
        assert found.remedy_command == "Set Fence"

    def test_a_stored_fence_that_cannot_be_used(self) -> None:
        found = fails("Fence", with_plan(drawn(SQUARE), "fence.geojson: not JSON"), "fence.geojson: not JSON")
        assert found.consequence == "What it forbids is not known."
        assert found.remedy_command == "Set Fence"

    def test_one_with_nothing_left_inside(self) -> None:
        found = check("Fence", with_plan(drawn(((0.0, 0.0), (9.0, 0.0), (9.0, 200.0), (0.0, 200.0)))))
        assert not found.passed
        assert "too narrow" in found.value

    def test_without_a_place_there_is_none(self) -> None:
        facts = standing()
        blind = replace(facts, position=replace(facts.position, pose=None))
        found = fails("Fence", blind, "position not known")
        assert found.remedy_command is None
        fails("Home", blind, "no fence to compare it with")
        fails("Return height", blind, "15 m, no fence to compare it with")

    def test_before_the_first_datum_the_place_is_the_datum(self) -> None:
        facts = standing()
        passes(
            "Fence", replace(facts, position=replace(facts.position, datum=None)), "290 × 290 m, drone and home inside"
        )


class TestHome:
    def test_one_that_is_not_known_or_old(self) -> None:
        fails("Home", with_home(place=None), "not known")
        passes("Home", with_home(age=10.0), "at the drone")
        fails("Home", with_home(age=10.1), "not known")

    def test_one_that_was_moved(self) -> None:
        fails("Home", with_home(away=3.1, is_inside=True), "Home is 3 m from the arm place.")
        passes("Home", with_home(away=3.0, is_inside=True), "at the drone")

    @pytest.mark.parametrize(
        ("away", "value"),
        [(9.9, "at the drone"), (10.1, "10 m away; Arm sets it here"), (140.0, "140 m away; Arm sets it here")],
    )
    def test_one_away_from_the_drone(self, away: float, value: str) -> None:
        passes("Home", with_home(place=north(away)), value)

    def test_one_outside_the_fence(self) -> None:
        found = fails("Home", with_home(place=north(146.0)), "146 m away, outside the fence")
        assert found.consequence == "It would return there."


class TestReturnHeight:
    def test_one_that_was_not_read(self) -> None:
        found = check("Return height", standing(), values={})
        assert (found.passed, found.value) == (False, "not read yet")

    @pytest.mark.parametrize(("centimetres", "passed"), [(9700, True), (9701, False)])
    def test_the_ceiling(self, centimetres: float, passed: bool) -> None:
        found = check("Return height", standing(), values={**SAFE_PARAMETERS, "RTL_ALT": centimetres})
        assert (found.passed, found.value) == (passed, "97 m, ceiling 97 m")

    def test_parts_from_which_home_is_not_seen(self) -> None:
        zone: Ring = ((40.0, 40.0), (60.0, 40.0), (60.0, 60.0), (40.0, 60.0))
        behind = check("Return height", with_plan(drawn(SQUARE, zone)))
        assert behind.passed
        assert behind.value.endswith("fly straight and cross a zone from parts")

    def test_a_bent_fence(self) -> None:
        bent = drawn(tuple((n + 60.0, e - 60.0) for n, e in L_SHAPE))  # the drone stands in one of its arms
        found = check("Return height", with_plan(bent))
        assert found.passed
        assert found.value.endswith("fly straight and leave it from parts")


class TestSlope:
    def facts(self, slope: Slope | None, plan: FencePlan | None = None) -> Facts:
        facts = with_plan(plan or FencePlan("circle", (), 100.0))
        return replace(facts, position=replace(facts.position, below=BelowFacts(slope=slope)))

    def names(self, facts: Facts) -> list[str]:
        return [item.name for item in preflight_items(facts, {}, SETTINGS, is_killed=False)]

    def test_it_is_reported_with_the_heights_of_the_flight(self) -> None:
        found = check("Slope", self.facts(Slope(0.06, 0.0)))
        assert found.passed
        assert found.value.endswith("Min 15 m clears it by 6 m")
        settings = replace(SETTINGS, heights=HeightSettings(minimum_m=15.0, highest_obstacle_m=4.0))
        assert "an obstacle of 4 m" in check("Slope", self.facts(Slope(0.06, 0.0)), settings).value

    def test_where_it_says_nothing(self) -> None:
        assert "Slope" not in self.names(self.facts(None))
        assert "Slope" not in self.names(self.facts(Slope(0.05, 0.0)))
        narrow = drawn(((0.0, 0.0), (9.0, 0.0), (9.0, 200.0), (0.0, 200.0)))
        assert "Slope" not in self.names(self.facts(Slope(0.06, 0.0), narrow))


class TestTheAutopilotsOwnFailsafes:
    def test_each_that_can_be_set_offers_it(self) -> None:
        items = preflight_items(standing(), {**SAFE_PARAMETERS, "FS_GCS_ENABLE": 0}, SETTINGS, is_killed=False)
        (found,) = (item for item in items if not item.passed)
        assert (found.name, found.remedy_command) == ("Ground-station failsafe", "Set Failsafes")
        by_hand = check("Battery thresholds", standing(), values={})
        assert (by_hand.passed, by_hand.remedy_command) == (False, None)

    def test_what_the_values_are_compared_with(self) -> None:
        settings = DdcSettings(
            FlightSettings(battery_chemistry="liion"),
            FenceSettings(),
            OperatorSettings(),
            HeightSettings(),
            77,
            remote_control=RemoteControlSettings(required=False),
        )
        view = autopilot_view(standing(), settings)
        assert (view.system_id, view.cells, view.fence_on) == (77, (3,), True)
        assert (view.needs_remote_control, view.chemistry, view.limits) == (False, LIION, None)
        assert autopilot_view(standing(), SETTINGS).needs_remote_control

    def test_the_limits_of_a_flight_count_while_it_is_armed_with_a_fence(self) -> None:
        facts = flying(NOW)
        assert autopilot_view(facts, SETTINGS).limits == FlightLimits(FENCE.ceiling, FENCE.autopilot_ceiling)
        none: Fence | None = None
        assert autopilot_view(replace(facts, limits=replace(facts.limits, fence=none)), SETTINGS).limits is None
        assert len(failsafe_checks(facts, dict(SAFE_PARAMETERS), SETTINGS)) == 9
