from __future__ import annotations

from dataclasses import replace

import pytest

from hawk.sim.autopilot.control import Limits
from hawk.sim.autopilot.gps import Estimate
from hawk.sim.autopilot.modes import (
    MODES,
    AltHold,
    Brake,
    Guided,
    Land,
    Loiter,
    ModeInputs,
    Phase,
    Rtl,
    Stabilize,
    descend,
)
from hawk.sim.autopilot.parameters import copter_parameters


def view(
    place: tuple[float, float, float] = (0.0, 0.0, -20.0),
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0),
    **parameters: float,
) -> ModeInputs:
    values = copter_parameters()
    for name, value in parameters.items():
        values.set(name, value)
    return ModeInputs(
        time=100.0,
        estimate=Estimate(place, velocity, 0.0, 0.0, 0.0),
        parameters=values,
        limits=Limits.of(values),
        home=(0.0, 0.0, 0.0),
        landed=False,
        position_ok=True,
        stick=0.0,
        ceiling=None,
    )


def test_the_numbers_are_arducopters() -> None:
    assert sorted(MODES) == [0, 2, 4, 5, 6, 9, 16, 17, 21]
    assert Guided.number == 4


def test_only_these_modes_arm() -> None:
    arming = {number for number, mode in MODES.items() if mode.arms}
    assert arming == {0, 2, 4, 5, 16}
    assert Guided.arms


def test_stabilize_idles_with_the_stick_low_and_lifts_with_it_high() -> None:
    mode = Stabilize(view())
    assert mode.run(view()).idle
    assert mode.run(replace(view(), stick=0.8)).climb > 1.0


@pytest.mark.parametrize("kind", [AltHold, Loiter])
def test_height_follows_the_stick(kind: type[AltHold] | type[Loiter]) -> None:
    mode = kind(view())
    assert mode.run(view()).climb == -2.4
    assert mode.run(replace(view(), stick=None)).climb == -2.4
    assert mode.run(replace(view(), stick=0.5)).climb == pytest.approx(0.0)
    assert mode.run(replace(view(), stick=1.0)).climb == pytest.approx(2.5)


def test_loiter_stays_where_it_could_stop() -> None:
    setpoint = Loiter(view(velocity=(5.0, 0.0, 0.0))).run(view())
    assert setpoint.position is not None
    assert 5.0 < setpoint.position[0] < 7.5


def test_brake_takes_the_speed_out_first_then_the_place() -> None:
    moving = view(velocity=(5.0, 0.0, 0.0))
    mode = Brake(moving)
    assert mode.run(moving).velocity == (0.0, 0.0)
    assert mode.run(view((4.0, 0.0, -20.0))).position == (4.0, 0.0)
    assert mode.run(view((4.5, 0.0, -20.0))).position == (4.0, 0.0)


class TestReturn:
    def test_climbs_where_it_is_first(self) -> None:
        mode = Rtl(view((30.0, 0.0, -10.0), RTL_ALT=2500))
        setpoint = mode.run(view((30.0, 0.0, -10.0), RTL_ALT=2500))
        assert setpoint.position == pytest.approx((30.0, 0.0), abs=0.5)
        assert setpoint.down == -25.0

    def test_then_home_waits_and_comes_down(self) -> None:
        mode = Rtl(view((30.0, 0.0, -20.0)))
        assert mode.run(view((30.0, 0.0, -20.0))).position == (0.0, 0.0)
        at_home = view((0.5, 0.0, -20.0))
        mode.run(at_home)
        assert mode.run(at_home).down == -20.0
        later = replace(at_home, time=106.0)
        assert mode.run(later).climb < 0.0
        assert mode.phase is Phase.LANDING

    def test_never_sinks_in_transit(self) -> None:
        assert Rtl(view((30.0, 0.0, -60.0), RTL_ALT=1500)).run(view((30.0, 0.0, -60.0))).down == -60.0

    @pytest.mark.parametrize(("away", "height"), [(2.0, 6.0), (4.0, 12.0), (30.0, 15.0)])
    def test_the_cone_saves_a_climb_near_home(self, away: float, height: float) -> None:
        place = (away, 0.0, -5.0)
        assert Rtl(view(place)).run(view(place)).down == pytest.approx(-height)

    def test_stays_below_the_ceiling(self) -> None:
        low = replace(view((50.0, 0.0, -10.0), RTL_ALT=8000), ceiling=40.0)
        assert Rtl(low).run(low).down == -40.0


class TestLand:
    def test_slows_down_near_the_ground(self) -> None:
        assert descend(view((0.0, 0.0, -20.0)), None).climb == -1.5
        assert descend(view((0.0, 0.0, -9.0)), None).climb == -0.5
        assert descend(view((0.0, 0.0, -20.0), LAND_SPEED_HIGH=300), None).climb == -3.0

    def test_lets_go_of_the_place_without_a_position(self) -> None:
        mode = Land(view())
        assert mode.run(view()).position is not None
        assert mode.run(replace(view(), position_ok=False)).position is None

    def test_is_landing_until_it_rests_on_the_ground(self) -> None:
        mode = Land(view())
        assert mode.phase is Phase.LANDING
        assert mode.run(replace(view(), landed=True)).idle


class TestGuided:
    def test_holds_until_commanded(self) -> None:
        setpoint = Guided(view()).run(view())
        assert setpoint.position == pytest.approx((0.0, 0.0), abs=0.01)
        assert setpoint.down == pytest.approx(-20.0)

    def test_looks_where_it_goes_unless_a_yaw_is_commanded(self) -> None:
        mode = Guided(view())
        mode.go((0.0, 10.0), -20.0, None, view())
        assert mode.run(view()).yaw == pytest.approx(1.5708, abs=1e-3)
        mode.go((0.0, 10.0), -20.0, 0.3, view())
        assert mode.run(view()).yaw == 0.3

    def test_spools_up_before_it_lifts(self) -> None:
        ground = replace(view((0.0, 0.0, 0.0)), landed=True)
        mode = Guided(ground)
        mode.take_off(ground, -10.0)
        phases = [mode.phase]
        assert mode.run(ground).idle
        assert not mode.run(replace(ground, time=101.5)).idle
        mode.run(replace(view((0.0, 0.0, -9.9)), time=110.0))
        phases.append(mode.phase)
        assert phases == [Phase.TAKING_OFF, Phase.FLYING]

    def test_on_the_ground_targets_are_forgotten(self) -> None:
        ground = replace(view((0.0, 0.0, 0.0)), landed=True)
        mode = Guided(ground)
        mode.go((5.0, 0.0), -10.0, None, ground)
        assert mode.run(ground).idle
        assert mode.target == (0.0, 0.0, 0.0)

    def test_a_velocity_ends(self) -> None:
        mode = Guided(view())
        mode.move((1.0, 2.0, -0.5), None, view())
        setpoint = mode.run(replace(view(), time=102.9))
        assert (setpoint.velocity, setpoint.climb) == ((1.0, 2.0), 0.5)
        assert mode.run(replace(view(), time=103.1)).velocity is None
