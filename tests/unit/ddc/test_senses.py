"""The senses by their front door: what a tick believes of the readings, and what must last before it counts."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import pytest

from hawk.comm.autopilot.remote_id import RemoteIdReport
from hawk.config.sections import FenceSettings, FlightSettings, HeightSettings, OperatorSettings
from hawk.ddc.acts import Ask, SetMode
from hawk.ddc.battery.energy import ASSUMED_DRAIN, SAFETY_FACTOR, seconds_home
from hawk.ddc.battery.survey import SurveyReading
from hawk.ddc.facts import Facts
from hawk.ddc.fence.geometry import circle, polygon_fence
from hawk.ddc.fence.keepers import FenceKeeper, OutlineKeeper
from hawk.ddc.readings.link import VehicleEvent
from hawk.ddc.readings.topic_interface import DdcInputs, DdcTopicInterface
from hawk.ddc.requests.flight_log import FlightLog
from hawk.ddc.requests.requests import Outcomes, Requests
from hawk.ddc.requests.service_interface import DdcServiceInterface
from hawk.ddc.senses import Senses, Sources
from hawk.ddc.settings import DdcSettings, SurveyMemory
from hawk.model.lot_map import Counts, OccupancyMap
from hawk.model.operation import Fall, Health, StateName
from hawk.model.plans import DesiredPose, ExploreStatus, Fence, HeightParameters, Inbound, PathPlan, Verdict
from hawk.model.poses import GlobalPose, MapPoint
from hawk.model.vehicle import CopterMode, LandedState
from tests.manual_clock import ManualClock
from tests.unit.ddc.fakes import PLACE, START, TICK_S, UTC_START, FakeAutopilot, FakeDesk

FENCE = polygon_fence(circle(MapPoint(0.0, 0.0), 100.0), 5.0, 50.0, 3.0)
HEALTHY = ("camera_health", "vision_health", "mapper_health", "path_plan_health", "recording_health")


class Bench:
    """The senses, and everything that they read, without anything that decides or acts."""

    def __init__(self, directory: Path, flight: FlightSettings | None = None, fall: Fall | None = None) -> None:
        self.clock = ManualClock(START)
        self.autopilot = FakeAutopilot(self.clock)
        self.desk = FakeDesk()
        self.inputs = DdcInputs.create(self.clock)
        self.topics = DdcTopicInterface(self.autopilot.topics, self.inputs, self.clock)
        self.settings = DdcSettings(
            flight or FlightSettings(), FenceSettings(), OperatorSettings(), HeightSettings(), 245
        )
        self.service = DdcServiceInterface(self.autopilot, self.topics, self.clock, 4.0, lambda _kind, _payload: None)
        self.fences = FenceKeeper(self.settings, directory)
        self.log = FlightLog(self.clock, self.utc)
        self.requests = Requests(self.clock, lambda _name, _failure: None)
        self.outcomes = Outcomes()
        self.survey = SurveyReading(self.settings, SurveyMemory(), continues_survey=False)
        self.silent: set[str] = set()
        """Parts of perception that say nothing."""
        self.bad: dict[str, str] = {}
        """Parts of perception that are unhealthy, with their reason."""
        self.senses = Senses(
            Sources(
                clock=self.clock,
                utc=self.utc,
                topics=self.topics,
                service=self.service,
                desk=self.desk,
                fences=self.fences,
                outlines=OutlineKeeper(None, SurveyMemory()),
                log=self.log,
                requests=self.requests,
                outcomes=self.outcomes,
                settings=self.settings,
                survey=self.survey,
                fall=fall,
            )
        )

    def utc(self) -> datetime:
        return datetime.fromtimestamp(UTC_START + self.clock() - START, UTC)

    def publish(self) -> None:
        self.autopilot.publish()
        for name in HEALTHY:
            if name not in self.silent:
                health = Health.bad(self.bad[name]) if name in self.bad else Health()
                getattr(self.inputs, name).publish(health)

    def tick(self) -> Facts:
        self.clock.advance(TICK_S)
        self.autopilot.step(TICK_S)
        self.publish()
        return self.senses.tick()

    def run(self, seconds: float) -> Facts:
        facts = self.tick()
        for _ in range(round(seconds / TICK_S) - 1):
            facts = self.tick()
        return facts

    def fly(self, height: float = 30.0, fence: Fence | None = FENCE) -> Facts:
        self.autopilot.put_in_air(height)
        if fence is not None:
            self.topics.fence_pub.publish(fence)
        return self.run(2.0)


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    made = Bench(tmp_path)
    yield made
    made.senses.close()


class TestLink:
    def test_found_lost_and_back(self, bench: Bench) -> None:
        assert not bench.senses.look().link.is_up
        facts = bench.tick()
        assert facts.link.events == (VehicleEvent.FOUND,)
        assert facts.link.is_up
        assert bench.tick().link.events == ()
        bench.autopilot.connected = False
        facts = bench.tick()
        assert facts.link.events == (VehicleEvent.LINK_LOST,)
        assert not facts.link.is_up
        bench.run(1.0)
        assert bench.senses.look().link.age == pytest.approx(1.05)
        bench.autopilot.connected = True
        assert bench.tick().link.events == (VehicleEvent.LINK_BACK,)

    async def test_while_the_link_is_lost_the_fence_that_the_autopilot_holds_is_not_known(self, bench: Bench) -> None:
        bench.tick()
        await bench.service.upload_fence(FENCE)
        assert bench.tick().limits.held == FENCE
        bench.autopilot.connected = False
        assert bench.tick().limits.held is None
        assert bench.senses.look().limits.held is None
        assert bench.service.held_fence == FENCE, "to forget it is an act: the senses do nothing to the service"

    def test_the_mode_that_a_tick_sees_first_is_a_fact_of_that_tick(self, bench: Bench) -> None:
        bench.fly()
        bench.autopilot.change_mode(CopterMode.RTL)
        bench.publish()
        assert bench.senses.look().link.new_mode is None
        assert bench.tick().link.new_mode == CopterMode.RTL
        assert bench.tick().link.new_mode is None

    def test_a_tick_that_fails_loses_no_event(self, bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
        bench.fly()
        bench.autopilot.connected = False
        with monkeypatch.context() as broken:
            broken.setattr(bench.topics, "get_part_healths", lambda: 1 / 0)
            for _ in range(2):
                with pytest.raises(ZeroDivisionError):
                    bench.tick()
        assert bench.tick().link.events == (VehicleEvent.LINK_LOST,)

    def test_a_mode_that_nobody_of_us_asked_for(self, bench: Bench) -> None:
        bench.fly()
        bench.autopilot.change_mode(CopterMode.LOITER)
        facts = bench.tick()
        assert facts.link.events == (VehicleEvent.FOREIGN_MODE,)
        assert facts.link.mode_changed_at == facts.now
        assert facts.vehicle.custom_mode == CopterMode.LOITER

    def test_its_words_and_a_second_sender(self, bench: Bench) -> None:
        bench.autopilot.topics.status_text.listen(bench.log.hear)
        bench.tick()
        bench.autopilot.say("PreArm: GPS", 3)
        bench.inputs.second_sender.publish("somebody sends from 10.0.0.9")
        facts = bench.tick()
        assert facts.link.words == "PreArm: GPS"
        assert facts.link.second_sender == "somebody sends from 10.0.0.9"

    def test_a_look_has_no_events(self, bench: Bench) -> None:
        bench.publish()
        assert bench.senses.look().link.events == ()
        assert bench.tick().link.events == (VehicleEvent.FOUND,)


class TestArmedAndLanded:
    def test_a_doubt_is_an_event_after_half_a_second(self, bench: Bench) -> None:
        bench.fly()
        bench.autopilot.landed = LandedState.ON_GROUND
        events = [bench.tick().link.events for _ in range(14)]
        assert events.index((VehicleEvent.DOUBTED,)) in (10, 11)
        assert sum(map(len, events)) == 1
        facts = bench.senses.look()
        assert facts.ground.doubt == "The autopilot says that it is on the ground, but its height is 30 m."
        assert facts.health("ground").reason == facts.ground.doubt
        assert facts.is_airborne

    def test_a_shorter_one_is_not_shown(self, bench: Bench) -> None:
        bench.fly()
        bench.autopilot.landed = LandedState.ON_GROUND
        assert bench.run(0.5).health("ground").is_healthy
        bench.autopilot.landed = LandedState.IN_AIR
        assert bench.run(1.0).link.events == ()

    def test_without_a_link_nothing_is_doubted(self, bench: Bench) -> None:
        bench.fly()
        bench.autopilot.landed = LandedState.ON_GROUND
        bench.run(1.0)
        bench.autopilot.connected = False
        assert bench.run(0.2).health("ground").is_healthy

    def test_the_parts_in_their_order(self, bench: Bench) -> None:
        assert [name for name, _ in bench.run(1.0).parts] == [
            "link",
            "position",
            "ground",
            "camera",
            "vision",
            "mapper",
            "planner",
            "recording",
            "requests",
            "tasks",
            "loop",
            "home",
            "remote control",
            "remote id",
        ]

    @pytest.mark.slow
    def test_a_fall_is_a_fact(self, tmp_path: Path) -> None:
        kept = Fall(5.0, 43.0, -79.0, 12.0)
        bench = Bench(tmp_path, fall=kept)
        assert bench.tick().fall == kept
        assert bench.fly(17.7).fall is None
        bench.autopilot.armed, bench.autopilot.landed = False, LandedState.ON_GROUND
        facts = bench.run(6.0)
        assert facts.fall is not None
        assert facts.fall.height == pytest.approx(17.7)
        assert facts.fall.at == pytest.approx(UTC_START + 2.0, abs=6.0)
        assert facts.fall.latitude == pytest.approx(PLACE.latitude)

    def test_the_place_of_a_fall_is_no_old_one(self, bench: Bench) -> None:
        bench.fly(17.7)
        bench.autopilot.pose_flows = False
        bench.autopilot.armed, bench.autopilot.landed = False, LandedState.ON_GROUND
        facts = bench.run(5.5)
        assert facts.fall is not None
        assert facts.fall.latitude == pytest.approx(PLACE.latitude), "where it was last seen"


class TestPosition:
    def test_pose_age_and_trust(self, bench: Bench) -> None:
        bench.fly()
        bench.autopilot.position_good = False
        facts = bench.run(3.0)
        assert facts.position.distrusted_s == pytest.approx(3.0)
        assert facts.position.age == pytest.approx(0.0)
        bench.autopilot.position_good, bench.autopilot.pose_flows = True, False
        facts = bench.run(2.0)
        assert facts.position.distrusted_s == 0.0
        assert facts.position.age == pytest.approx(2.0)
        assert facts.pose is None

    def test_home_is_the_arm_place_on_the_map(self, bench: Bench) -> None:
        facts = bench.tick()
        assert (facts.position.arm_place, facts.position.home) == (None, None)
        bench.autopilot.north = 12.0
        facts = bench.fly()
        assert facts.position.datum == PLACE
        assert facts.position.arm_place is not None
        assert facts.position.home is not None
        assert facts.position.home.north == pytest.approx(12.0, abs=0.01)
        assert facts.position.home.east == pytest.approx(0.0, abs=0.01)
        place = facts.position.arm_place
        assert place is not None
        bench.autopilot.topics.arm_place.publish(replace(place, latitude=PLACE.latitude))
        again = bench.tick().position.home
        assert again is not None
        assert again.north == pytest.approx(0.0, abs=0.01)

    def test_jumps_are_reported_once(self, bench: Bench) -> None:
        bench.fly()
        bench.autopilot.topics.frame_jump.publish(3.0)
        bench.autopilot.topics.frame_jump.publish(2.0)
        bench.autopilot.topics.estimate_jump.publish(-7.0)
        look = bench.senses.look().position
        assert (look.jump_m, look.estimate_jump_m) == (0.0, 0.0)
        facts = bench.tick().position
        assert (facts.jump_m, facts.estimate_jump_m) == (3.0, 7.0)
        facts = bench.tick().position
        assert (facts.jump_m, facts.estimate_jump_m) == (0.0, 0.0)

    def test_closed_it_listens_no_more(self, bench: Bench) -> None:
        bench.fly()
        bench.senses.close()
        bench.autopilot.topics.frame_jump.publish(3.0)
        bench.autopilot.topics.estimate_jump.publish(3.0)
        facts = bench.tick().position
        assert (facts.jump_m, facts.estimate_jump_m) == (0.0, 0.0)

    def test_a_home_that_was_moved(self, bench: Bench) -> None:
        bench.fly()
        assert bench.run(2.0).position.autopilot_home.away == pytest.approx(0.0, abs=0.1)
        bench.autopilot.move_home(GlobalPose(PLACE.latitude + 4e-4, PLACE.longitude, PLACE.altitude))
        facts = bench.run(2.0)
        assert facts.position.autopilot_home.is_moved
        assert facts.position.autopilot_home.away == pytest.approx(44.4, abs=0.5)
        assert not facts.health("home").is_healthy
        assert facts.position.home == MapPoint(0.0, 0.0), "the arm place stays"

    def test_before_the_first_heartbeat_no_home_is_set_by_the_ground(self, bench: Bench) -> None:
        bench.autopilot.connected = False
        bench.autopilot.move_home(PLACE)
        bench.clock.advance(0.1)
        assert bench.senses.tick().position.autopilot_home.away is None


class TestBattery:
    @pytest.mark.slow
    def test_on_the_ground(self, bench: Bench) -> None:
        facts = bench.run(1.0).battery
        assert facts.info is not None
        assert (facts.info.percentage, facts.info.voltage) == (95.0, 12.0)
        assert (facts.age, facts.unknown_s, facts.reserve, facts.reached_s, facts.cells) == (0.0, 0.0, None, None, (3,))
        assert facts.charge.volts == pytest.approx(4.0)
        bench.autopilot.battery = None
        facts = bench.run(60.0).battery
        assert (facts.info, facts.unknown_s) == (None, 0.0), "on the ground nothing hurries"

    def test_the_reserve_is_the_cost_of_the_flight_home(self, bench: Bench) -> None:
        bench.fly()
        bench.autopilot.north = 40.0
        facts = bench.tick()
        reserve = facts.battery.reserve
        assert reserve is not None
        home = seconds_home(40.0, 30.0, HeightParameters().maximum, 4.0)
        assert reserve.percentage == 95.0
        assert reserve.flight == pytest.approx(SAFETY_FACTOR * home * ASSUMED_DRAIN)
        assert reserve.needed == pytest.approx(20.0 + reserve.flight)
        assert facts.battery.reached_s is None

    def test_a_reached_reserve_is_timed(self, bench: Bench) -> None:
        bench.fly()
        bench.autopilot.battery = 15.0
        assert bench.tick().battery.reached_s == 0.0
        assert bench.run(2.0).battery.reached_s == pytest.approx(2.0)
        bench.autopilot.battery = 94.0
        assert bench.tick().battery.reached_s is None
        bench.autopilot.battery = 15.0
        bench.run(1.0)
        bench.autopilot.height, bench.autopilot.landed = 0.0, LandedState.ON_GROUND
        bench.tick()
        facts = bench.tick().battery
        assert (facts.reserve, facts.reached_s) == (None, None)

    @pytest.mark.slow
    def test_a_charge_that_is_not_known_is_timed_in_flight(self, bench: Bench) -> None:
        bench.fly()
        bench.autopilot.battery = None
        facts = bench.run(10.0).battery
        assert facts.unknown_s == pytest.approx(10.0)
        assert facts.reserve is not None, "that of before"
        bench.autopilot.battery = 80.0
        assert bench.tick().battery.unknown_s == 0.0

    def test_the_farther_of_arm_place_and_home_counts(self, bench: Bench) -> None:
        bench.fly()
        bench.run(1.0)
        near = bench.tick().battery.reserve
        bench.autopilot.move_home(GlobalPose(PLACE.latitude + 4e-4, PLACE.longitude, PLACE.altitude))
        far = bench.run(1.0).battery.reserve
        bench.autopilot.north = 44.4
        back = bench.tick().battery.reserve
        assert near is not None
        assert far is not None
        assert back is not None
        assert far.flight - near.flight == pytest.approx(SAFETY_FACTOR * 44.4 / 4.0 * ASSUMED_DRAIN, rel=0.05)
        assert back.flight == pytest.approx(far.flight, rel=0.02)

    def test_without_a_place_the_reserve_of_before_stays(self, bench: Bench) -> None:
        bench.fly()
        bench.autopilot.pose_flows = False
        before = bench.run(1.0).battery.reserve
        bench.autopilot.battery = 50.0
        assert bench.run(3.0).battery.reserve == before

    @pytest.mark.slow
    def test_the_drain_of_one_flight_is_not_that_of_the_next(self, bench: Bench) -> None:
        bench.fly()
        for _ in range(60):
            assert bench.autopilot.battery is not None
            bench.autopilot.battery -= 0.5
            bench.run(1.0)
        drained = bench.senses.look().battery.reserve
        assert drained is not None
        bench.autopilot.armed, bench.autopilot.height, bench.autopilot.landed = False, 0.0, LandedState.ON_GROUND
        bench.autopilot.battery = 95.0
        bench.run(2.0)
        fresh = bench.fly().battery.reserve
        assert fresh is not None
        assert drained.flight == pytest.approx(fresh.flight * 0.5 / ASSUMED_DRAIN, rel=0.05)

    def test_cells_are_counted_at_rest(self, bench: Bench) -> None:
        bench.run(1.0)
        bench.fly()
        bench.autopilot.volts = 3.5 * 4
        assert bench.run(1.0).battery.cells == (3,), "in flight the count stays"
        bench.autopilot.armed, bench.autopilot.height, bench.autopilot.landed = False, 0.0, LandedState.ON_GROUND
        assert bench.run(1.0).battery.cells == (4,)

    def test_found_in_the_air_they_are_counted_there(self, bench: Bench) -> None:
        bench.autopilot.volts = 3.35 * 4
        assert bench.fly().battery.cells == (4,)

    def test_settings_of_the_battery(self, tmp_path: Path) -> None:
        bench = Bench(tmp_path, FlightSettings(battery_chemistry="liion", battery_cells=4, battery_return_v=3.3))
        bench.autopilot.volts = 3.25 * 4
        facts = bench.fly()
        assert facts.battery.cells == (4,)
        facts = bench.run(4.0)
        assert (facts.battery.charge.is_low, facts.battery.charge.is_critical) == (True, False)

    def test_a_voltage_without_a_counter_still_counts(self, bench: Bench) -> None:
        bench.fly()
        bench.autopilot.battery, bench.autopilot.volts = None, 9.3
        facts = bench.run(4.0)
        assert facts.battery.info is None
        assert facts.battery.charge.is_critical

    @pytest.mark.slow
    def test_what_is_believed_decides(self, bench: Bench) -> None:
        bench.fly()
        bench.autopilot.volts = 3.35 * 3
        facts = bench.run(5.0)
        assert facts.battery.info is not None
        assert facts.battery.info.percentage == 95.0
        assert facts.battery.reserve is not None
        assert facts.battery.reserve.percentage < 13.0

    def test_a_survey_that_fails_hides_no_fact(self, bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
        bench.fly()

        def fail(_seen: object) -> None:
            raise RuntimeError("boom")

        monkeypatch.setattr(bench.survey, "update", fail)
        facts = bench.tick()
        assert facts.battery.reserve is not None
        assert facts.battery.survey is None

    @pytest.mark.slow
    def test_the_survey_is_given_what_was_seen(self, bench: Bench) -> None:
        assert bench.run(1.0).battery.survey is not None
        bench.fly()
        bench.topics.curr_state_pub.publish(StateName.AUTONOMOUS_EXPLORE)
        bench.inputs.occupancy_map.publish(OccupancyMap(lot_area_m2=90_000.0))
        for _ in range(60):
            assert bench.autopilot.battery is not None
            bench.autopilot.battery -= 1.0
            bench.run(0.5)
        facts = bench.tick()
        assert facts.battery.survey is not None
        assert facts.battery.short_s is not None
        assert facts.battery.short_s > 0.0


class TestWind:
    @pytest.mark.slow
    def test_a_strong_wind_is_timed_and_forgotten_on_the_ground(self, bench: Bench) -> None:
        bench.fly()
        bench.autopilot.tilt = (0.0, -0.3)
        bench.run(60.0)
        facts = bench.tick()
        assert facts.wind.estimate is not None
        assert facts.wind.estimate.speed > 10.0
        assert facts.wind.strong_s is not None
        before = facts.wind.strong_s
        assert bench.run(2.0).wind.strong_s == pytest.approx(before + 2.0)
        bench.autopilot.height, bench.autopilot.landed, bench.autopilot.armed = 0.0, LandedState.ON_GROUND, False
        bench.tick()
        facts = bench.tick()
        assert (facts.wind.estimate, facts.wind.strong_s) == (None, None)

    @pytest.mark.slow
    def test_calm_air_is_no_strong_wind(self, bench: Bench) -> None:
        bench.fly()
        facts = bench.run(60.0)
        assert facts.wind.estimate is not None
        assert facts.wind.estimate.speed < 3.0
        assert facts.wind.strong_s is None


class TestFence:
    @pytest.mark.parametrize("side", ["fence", "ceiling"])
    def test_a_breach_begins_beyond_the_tolerance_and_ends_inside(self, bench: Bench, side: str) -> None:
        ceiling, edge = FENCE.ceiling, max(north for north, _ in FENCE.polygon)
        out = (edge + 0.4, 30.0) if side == "fence" else (0.0, ceiling + 0.4)
        farther = (edge + 0.7, 30.0) if side == "fence" else (0.0, ceiling + 0.7)
        inside = (edge - 0.4, 30.0) if side == "fence" else (0.0, ceiling - 0.2)
        bench.fly()
        assert bench.tick().limits.breached_s is None
        bench.autopilot.north, bench.autopilot.height = out
        assert bench.tick().limits.breached_s is None
        bench.autopilot.north, bench.autopilot.height = farther
        facts = bench.tick()
        assert facts.limits.breached_s == 0.0
        assert facts.is_breached
        bench.autopilot.north, bench.autopilot.height = out
        assert bench.run(2.0).limits.breached_s == pytest.approx(2.0)
        bench.autopilot.north, bench.autopilot.height = inside
        assert bench.tick().limits.breached_s is None

    def test_on_the_ground_and_without_a_fence_nothing_is_breached(self, bench: Bench) -> None:
        bench.topics.fence_pub.publish(FENCE)
        bench.autopilot.north = 300.0
        assert bench.run(1.0).limits.breached_s is None
        other = bench.fly(fence=None)
        assert other.limits.breached_s == pytest.approx(2.0, abs=0.1)

    def test_without_a_place_a_breach_goes_on(self, bench: Bench) -> None:
        bench.fly()
        bench.autopilot.north = 120.0
        bench.run(1.0)
        bench.autopilot.pose_flows = False
        bench.autopilot.north = 0.0
        assert bench.run(2.0).limits.breached_s == pytest.approx(2.95, abs=0.1)

    def test_the_limits(self, bench: Bench) -> None:
        bench.topics.heights_pub.publish(HeightParameters(11.0, 22.0, 33.0))
        facts = bench.fly().limits
        assert facts.heights == HeightParameters(11.0, 22.0, 33.0)
        assert facts.fence == FENCE
        assert facts.plan == bench.fences.plan
        assert facts.planned_ceiling == bench.fences.plan.ceiling - 3.0
        assert (facts.plan_problem, facts.outline) == ("", None)
        bench.fences.problem = "broken"
        assert bench.tick().limits.plan_problem == "broken"


class TestSight:
    def test_the_first_fault_in_the_order_of_dependence_is_timed(self, bench: Bench) -> None:
        bench.fly()
        assert (bench.tick().sight.fault, bench.tick().sight.fault_s) == ("", 0.0)
        bench.bad = {"mapper_health": "slow", "path_plan_health": "lost"}
        assert bench.tick().sight.fault == "Mapper: slow"
        bench.bad["camera_health"] = "dark"
        facts = bench.run(1.0)
        assert facts.sight.fault == "Camera: dark"
        assert facts.sight.fault_s == pytest.approx(1.0)
        bench.bad = {"recording_health": "full"}
        assert (bench.tick().sight.fault, bench.tick().sight.fault_s) == ("", 0.0)

    def test_a_silent_part_is_a_fault(self, bench: Bench) -> None:
        bench.run(1.0)
        bench.silent = {"vision_health"}
        assert bench.run(1.9).sight.fault == ""
        assert bench.run(0.3).sight.fault == "Vision: No result lately."

    def test_results_of_perception(self, bench: Bench) -> None:
        bench.fly()
        plan = PathPlan(
            MapPoint(1.0, 2.0), 20.0, 0.5, explore=ExploreStatus(seen=0.4), asked=Verdict(9, Inbound.INSIDE)
        )
        verdict = Verdict(3, Inbound.OUTSIDE)
        bench.inputs.path_plan.publish(plan)
        bench.inputs.verdict.publish(verdict)
        bench.inputs.park_lot_detected.publish(True)
        bench.inputs.footprint.publish((MapPoint(0.0, 1.0),))
        bench.inputs.vision_rate.publish(7.5)
        bench.inputs.camera_time.publish(bench.clock() - 0.3)
        bench.inputs.occupancy_map.publish(OccupancyMap(counts=Counts(free=1, taken=2, unknown=3), lot_area_m2=77.0))
        bench.topics.des_pose_pub.publish(DesiredPose(3, 5.0, 6.0))
        bench.outcomes.desired_count = 4
        facts = bench.senses.look().sight
        assert (facts.lot, facts.plan, facts.verdict, facts.asked) == (True, plan, verdict, plan.asked)
        assert facts.plan_time == bench.clock()
        assert (facts.desired, facts.desired_count) == (DesiredPose(3, 5.0, 6.0), 4)
        assert (facts.footprint, facts.counts.taken, facts.lot_area) == ((MapPoint(0.0, 1.0),), 2, 77.0)
        assert facts.vision_rate == 7.5
        assert facts.camera_age == pytest.approx(0.3)


class TestOthers:
    def test_the_operator(self, bench: Bench) -> None:
        facts = bench.tick().operator
        assert (facts.is_present, facts.is_controlled, facts.controller) == (True, True, "ana")
        assert facts.clients == frozenset({"ana"})
        assert facts.names == (("ana", "Ana"), ("eve", "Eve"))
        bench.desk.client, bench.desk.former = None, "Ana"
        facts = bench.tick().operator
        assert (facts.is_present, facts.is_controlled, facts.controller) == (False, False, "")
        assert (facts.clients, facts.given_back_by) == (frozenset(), "Ana")

    async def test_requests_and_outcomes(self, bench: Bench) -> None:
        bench.tick()
        ask = Ask(SetMode(CopterMode.GUIDED), bench.clock())
        bench.requests.start(ask, lambda: bench.service.set_mode(CopterMode.GUIDED))
        bench.outcomes.target_refusal, bench.outcomes.starts_in_air = "too old", 2
        facts = bench.senses.look()
        assert ask.answer(facts).is_pending
        assert (facts.target_refusal, facts.starts_in_air) == ("too old", 2)
        for _ in range(5):
            await asyncio.sleep(0)
        assert ask.answer(bench.senses.look()).is_done

    async def test_parameters_that_decide(self, bench: Bench) -> None:
        await bench.service.get_parameter("BATT_LOW_VOLT")
        await bench.service.get_parameter("FENCE_ENABLE")
        bench.autopilot.values["WPNAV_SPEED"] = 500.0
        await bench.service.get_parameter("WPNAV_SPEED")
        assert dict(bench.tick().parameters) == {"BATT_LOW_VOLT": 10.5, "FENCE_ENABLE": 1.0}

    def test_times(self, bench: Bench) -> None:
        facts = bench.run(2.0)
        assert facts.now == pytest.approx(START + 2.0)
        assert facts.utc == pytest.approx(UTC_START + 2.0)

    async def test_the_remote_control(self, bench: Bench) -> None:
        await bench.service.get_parameter("FLTMODE_CH")
        facts = bench.fly().remote_control
        assert (facts.channel, facts.pulse, facts.lost_s) == (5, 1800, None)
        bench.autopilot.radio = False
        facts = bench.run(3.0).remote_control
        assert facts.lost_s is not None
        bench.autopilot.connected = False
        bench.run(1.0)
        assert bench.senses.look().remote_control.lost_s is None

    def test_remote_id(self, bench: Bench) -> None:
        bench.autopilot.remote_id = RemoteIdReport(good=True)
        assert bench.tick().remote_id.age == pytest.approx(0.0, abs=0.1)

    def test_a_rangefinder(self, bench: Bench) -> None:
        bench.autopilot.below = lambda _north, _east: 26.5
        facts = bench.fly()
        assert facts.health("rangefinder").is_healthy
        assert facts.position.below.low_s is not None
        assert facts.position.below.low_m == pytest.approx(3.5, abs=0.1)
        assert math.isfinite(facts.position.below.low_s)


def test_facts_are_replaced_whole(bench: Bench) -> None:
    facts = bench.tick()
    assert replace(facts, now=1.0) != facts
