"""Beyond the rows of observation: determinism, faults, restarts, the ground."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from hawk.sim.autopilot.autopilot import Autopilot, RefusedError
from hawk.sim.autopilot.modes import ModeNumber
from hawk.sim.autopilot.parameters import AutopilotOptions
from hawk.sim.geometry import Origin


def autopilot(seed: int = 1, **changes: Any) -> Autopilot:
    options = AutopilotOptions(**{"gnss_wait_s": 0.5, "gnss_sigma": 0.0, **changes})
    return Autopilot(options, Origin(), np.random.default_rng(seed))


def run(unit: Autopilot, seconds: float) -> Autopilot:
    for _ in range(round(seconds / 0.01)):
        unit.step()
    return unit


def hovering(height: float = 10.0, **changes: Any) -> Autopilot:
    unit = run(autopilot(**changes), 4.0)
    unit.set_mode(4)
    unit.arm()
    unit.take_off(height)
    return run(unit, 14.0)


@pytest.mark.nightly
def test_the_same_seed_flies_the_same_flight() -> None:
    flights = [run(hovering(gnss_sigma=0.5, wind=4.0), 5.0) for _ in range(2)]
    assert flights[0].body == flights[1].body
    assert flights[0].estimate == flights[1].estimate
    other = hovering(gnss_sigma=0.5, wind=4.0, seed=2)
    assert other.body != flights[0].body


@pytest.mark.slow
def test_takes_off_where_it_stands_with_its_heading() -> None:
    unit = hovering(start=(-30.0, 12.0), yaw=1.0)
    assert unit.body.position == pytest.approx((-30.0, 12.0, -10.0), abs=0.3)
    assert unit.body.yaw == pytest.approx(1.0, abs=0.03)


@pytest.mark.slow
def test_ekf_local_starts_at_the_first_position_and_global_agrees() -> None:
    unit = hovering(start=(-30.0, 12.0), gnss_sigma=2.0)
    assert unit.ekf_origin is not None
    local = unit.local_position
    assert local is not None
    difference = np.subtract(unit.estimate.position, local)
    assert tuple(difference) == pytest.approx(unit.ekf_origin)


@pytest.mark.nightly
def test_drift_moves_the_true_vehicle_not_the_estimate() -> None:
    unit = run(hovering(gnss_sigma=5.0), 60.0)
    held = math.dist(unit.estimate.position[:2], (0.0, 0.0))
    true = math.dist(unit.body.position[:2], (0.0, 0.0))
    assert held < 0.5 < true


@pytest.mark.nightly
def test_wind_leans_it_and_the_place_is_held() -> None:
    unit = run(hovering(wind=7.0), 15.0)
    assert math.hypot(unit.body.roll, unit.body.pitch) > math.radians(3)
    assert math.hypot(*unit.body.position[:2]) < 1.0


@pytest.mark.slow
def test_an_ekf_reset_moves_local_only() -> None:
    unit = hovering()
    before, place = unit.local_position, unit.body.position
    unit.shift_ekf_origin((2.0, 0.0, 0.0))
    after = unit.local_position
    assert before is not None
    assert after is not None
    assert after[0] - before[0] == pytest.approx(-2.0)
    run(unit, 2.0)
    assert math.dist(unit.body.position, place) < 0.2


@pytest.mark.slow
def test_a_jump_makes_it_fly_back_to_a_target_that_was_sent() -> None:
    unit = hovering()
    unit.fly_to((0.0, 0.0, -10.0), 0.0)
    unit.estimator.jump(3.0, 0.0, 0.0)
    run(unit, 10.0)
    assert unit.body.position[0] == pytest.approx(-3.0, abs=0.2)


@pytest.mark.slow
@pytest.mark.parametrize("mode", [None, ModeNumber.BRAKE, ModeNumber.LOITER])
def test_a_jump_does_not_move_it_where_no_target_was_sent(mode: ModeNumber | None) -> None:
    unit = hovering()
    if mode is not None:
        unit.set_mode(mode)
        unit.stick = 0.5
        run(unit, 3.0)
    unit.estimator.jump(3.0, 0.0, 0.0)
    run(unit, 6.0)
    assert unit.body.position[0] == pytest.approx(0.0, abs=0.3)
    assert unit.estimate.position[0] == pytest.approx(3.0, abs=0.3)


@pytest.mark.slow
def test_gnss_that_is_off_is_refused_for_ten_seconds_and_then_taken() -> None:
    """Figures of a real ArduCopter: variance 6.66 at 25 m, the flag after 1.2 s, the jump after 10 s."""
    unit = hovering()
    unit.fly_to((0.0, 0.0, -10.0), 0.0)
    unit.gnss.set_glitch((25.0, 0.0, 0.0))
    run(unit, 0.5)
    assert unit.estimator.glitch.variance == pytest.approx(6.6, abs=0.1)
    assert "GPS Glitch or Compass error" not in [text.text for text in unit.texts]
    run(unit, 9.0)
    assert unit.texts[-1].text == "GPS Glitch or Compass error"
    assert unit.estimate.position[0] == pytest.approx(0.0, abs=0.3)
    run(unit, 0.6)
    assert unit.estimate.position[0] == pytest.approx(25.0, abs=0.4)
    assert unit.estimator.glitch.variance == 0.0
    run(unit, 9.9)
    assert unit.body.position[0] == pytest.approx(-25.0, abs=0.5)
    assert "Glitch cleared" not in [text.text for text in unit.texts]
    run(unit, 0.2)
    assert unit.texts[-1].text == "Glitch cleared"


@pytest.mark.slow
def test_gnss_that_is_off_by_little_is_taken_without_a_jump() -> None:
    unit = hovering()
    unit.gnss.set_glitch((3.0, 0.0, 0.0))
    last = unit.estimate.position[0]
    for _ in range(600):
        run(unit, 0.01)
        assert abs(unit.estimate.position[0] - last) < 0.1
        last = unit.estimate.position[0]
    assert unit.estimator.glitch.taken[0] == pytest.approx(3.0, abs=0.1)
    assert not unit.estimator.glitch.is_reported


@pytest.mark.slow
def test_an_empty_battery_falls() -> None:
    unit = hovering()
    unit.battery.remaining = 0.0
    run(unit, 5.0)
    assert unit.body.crashed
    assert not unit.armed
    assert any(text.text.startswith("Crash: Disarming") for text in unit.texts)


@pytest.mark.slow
def test_a_crashed_vehicle_does_not_arm() -> None:
    unit = hovering()
    unit.terminate()
    run(unit, 5.0)
    with pytest.raises(RefusedError, match="crashed"):
        unit.arm()


@pytest.mark.slow
def test_a_stopped_program_drops_the_vehicle_and_boots_again() -> None:
    unit = hovering()
    unit.crash_program("a test")
    run(unit, 3.0)
    assert unit.body.crashed
    unit.boot()
    assert not unit.stopped
    assert not unit.armed
    assert unit.time_boot == pytest.approx(0.0)


@pytest.mark.slow
def test_loitering_to_the_ground_disarms_after_the_delay() -> None:
    unit = hovering()
    unit.set_mode(5)
    run(unit, 8.0)
    assert unit.armed
    assert unit.landed
    run(unit, 10.5)
    assert not unit.armed


@pytest.mark.slow
def test_a_pilot_may_fly_on_with_the_stick() -> None:
    unit = hovering()
    unit.stick = 0.5
    unit.set_mode(5)
    run(unit, 5.0)
    assert unit.body.height == pytest.approx(10.0, abs=0.3)


def test_the_stick_up_is_no_place_to_arm_from() -> None:
    unit = run(autopilot(), 4.0)
    unit.stick = 0.5
    with pytest.raises(RefusedError, match="Throttle"):
        unit.arm()


@pytest.mark.slow
def test_modes_that_need_a_position_are_refused_in_the_air_without_one() -> None:
    unit = hovering()
    unit.set_mode(2)
    unit.stick = 0.5
    unit.estimator.receiving = False
    run(unit, 9.0)
    with pytest.raises(RefusedError, match="position"):
        unit.set_mode(4)
    assert unit.mode.number == 2


@pytest.mark.nightly
@pytest.mark.parametrize("speed", [math.nan, 0.0, -1.0, math.inf])
def test_no_nonsense_speed(speed: float) -> None:
    with pytest.raises(RefusedError):
        hovering().set_speed(speed)


@pytest.mark.slow
def test_speed_and_yaw_are_guideds() -> None:
    unit = hovering()
    unit.set_speed(2.0)
    unit.turn_to(1.0)
    unit.fly_to((30.0, 0.0, -10.0), 1.0)
    run(unit, 6.0)
    assert math.hypot(*unit.body.velocity[:2]) == pytest.approx(2.0, abs=0.2)
    unit.set_mode(17)
    with pytest.raises(RefusedError):
        unit.set_speed(2.0)
    with pytest.raises(RefusedError):
        unit.turn_to(0.0)


@pytest.mark.slow
def test_a_velocity_that_is_not_finite_ends_the_program() -> None:
    unit = hovering()
    unit.fly_velocity((math.nan, 0.0, 0.0), None)
    assert unit.stopped


@pytest.mark.slow
def test_what_speaks_against_arming_is_said_every_half_minute() -> None:
    unit = run(autopilot(), 1.0)
    unit.radio_present = False
    unit.texts.clear()
    run(unit, 62.0)
    assert [text.text for text in unit.texts].count("PreArm: Radio failsafe on") == 2


def test_texts_do_not_pile_up_when_nobody_listens() -> None:
    unit = autopilot()
    for number in range(500):
        unit.say(6, str(number))
    assert len(unit.texts) == 50
    assert unit.texts[-1].text == "499"
