"""The charge that is believed: counter, voltage and time flown, compared."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.ddc.battery.charge import ChargeFacts, ChargeReading
from hawk.ddc.battery.chemistry import CHEMISTRIES, LIHV, LIION, LIPO, Chemistry
from hawk.ddc.battery.energy import ASSUMED_DRAIN
from hawk.model.vehicle import BatteryInfo

READING_S = 0.5
CELLS = (3,)


class Pack:
    """A battery whose counter and voltage are set by the test; readings come twice a second, ticks ten times."""

    def __init__(self, charge: ChargeReading | None = None, cells: tuple[int, ...] = CELLS) -> None:
        self.charge = charge or ChargeReading(LIPO)
        self.cells = cells
        self.now = 100.0
        self.counter: float | None = 100.0
        self.each: float | None = 4.2
        self.airborne = False
        self.facts = ChargeFacts()
        self._read = -math.inf
        self._info: BatteryInfo | None = None

    def run(self, seconds: float, drain: float = 0.0, each: Callable[[float], float] | None = None) -> ChargeFacts:
        end = self.now + seconds
        while self.now < end - 1e-6:
            self.now += 0.1
            if self.counter is not None:
                self.counter = max(0.0, self.counter - drain * 0.1)
            if self.now - self._read >= READING_S - 1e-6:
                self._read = self.now
                volts = self.each if each is None else each(self.now)
                shown = None if self.counter is None else float(round(self.counter))
                self._info = BatteryInfo(shown, None if volts is None else volts * CELLS[0], 10.0, self.now)
            self.facts = self.charge.update(self._info, self.cells, self.now, is_airborne=self.airborne)
        return self.facts

    def fly(self, seconds: float, drain: float = 0.1) -> ChargeFacts:
        self.airborne = True
        return self.run(seconds, drain)


class TestAtRest:
    @pytest.mark.parametrize(
        ("counter", "each", "believed"),
        [
            (100, 4.2, 100),
            (100, 4.15, 100),
            (95, 4.0, 95),
            (60, 4.2, 60),
            (60, 3.85, 60),
            (40, 3.75, 40),
            (5, 3.6, 5),
        ],
    )
    def test_counter_and_voltage_that_agree(self, counter: float, each: float, believed: float) -> None:
        pack = Pack()
        pack.counter, pack.each = counter, each
        facts = pack.run(5.0)
        assert facts.doubt == ""
        assert facts.believed == pytest.approx(believed, abs=0.1)
        assert facts.volts == pytest.approx(each)

    @pytest.mark.fault(
        "the counter says 100 % at 11.0 V of three cells, or 30 to 100 % at 3.2 to 3.85 V a cell at rest",
        "Arm is refused with what the voltage allows",
    )
    @pytest.mark.parametrize(
        ("counter", "each"),
        [
            (100, 11.0 / 3),
            (100, 3.53),
            (60, 3.53),
            (40, 3.53),
            (100, 3.7),
            (100, 3.8),
            (100, 3.85),
            (80, 3.65),
            (30, 3.2),
        ],
    )
    def test_a_counter_that_says_more_than_the_voltage_allows(self, counter: float, each: float) -> None:
        pack = Pack()
        pack.counter, pack.each = counter, each
        facts = pack.run(5.0)
        assert facts.doubt.startswith(f"the counter says {counter} %, {each:.2f} V a cell at rest is ")
        assert facts.believed is not None
        assert facts.believed < counter - 25.0

    def test_a_quarter_more_is_believed_and_any_more_is_not(self) -> None:
        pack = Pack()
        pack.each = 3.65  # 3.75 V is 25 %
        pack.counter = 50
        assert pack.run(7.0).doubt == ""
        pack.counter = 51
        assert pack.run(7.0).doubt == "the counter says 51 %, 3.65 V a cell at rest is 25 % at most"

    def test_another_battery_ends_the_doubt(self) -> None:
        pack = Pack()
        pack.each = 3.53
        assert pack.run(7.0).doubt
        pack.each = 4.2
        assert pack.run(7.0).doubt == ""

    def test_of_two_possible_counts_the_larger_one_is_taken(self) -> None:
        pack = Pack(cells=(3, 4))
        facts = pack.run(3.0)
        assert facts.cells == 4
        assert facts.volts == pytest.approx(3.15)
        assert facts.doubt

    @pytest.mark.parametrize("each", [None, math.nan, math.inf, -1.0, 0.0])
    def test_a_voltage_that_is_none(self, each: float | None) -> None:
        pack = Pack()
        pack.each = each
        facts = pack.run(7.0)
        assert (facts.volts, facts.allowed, facts.doubt, facts.believed) == (None, None, "", 100.0)

    def test_without_a_cell_count_the_voltage_says_nothing(self) -> None:
        facts = Pack(cells=()).run(7.0)
        assert (facts.volts, facts.cells, facts.believed) == (None, None, 100.0)

    @pytest.mark.parametrize("counter", [None, math.nan])
    def test_a_counter_that_says_nothing(self, counter: float | None) -> None:
        charge = ChargeReading(LIPO)
        facts = charge.update(BatteryInfo(counter, 12.0, None, 1.0), CELLS, 1.0, is_airborne=False)
        assert (facts.counter, facts.believed, facts.volts) == (None, None, 4.0)
        assert charge.update(None, CELLS, 9.0, is_airborne=False) == ChargeFacts(cells=3)


class TestUnderLoad:
    @pytest.mark.slow
    def test_a_flight_as_it_should_be(self) -> None:
        """A rested cell by the table, .25 V less under load, from full to 10 %."""
        pack = Pack()
        pack.run(5.0)
        pack.airborne = True
        volts = {round(charge): volts for volts, charge in LIPO.at_rest}
        for _ in range(180):
            each = volts[5 * round((pack.counter or 0.0) / 5)] - 0.25
            facts = pack.run(5.0, drain=0.1, each=lambda _now, each=each: each)  # type: ignore[misc]
            assert facts.doubt == ""
            assert facts.believed == facts.counter
            assert not facts.is_low

    @pytest.mark.parametrize(
        ("each", "low", "critical"),
        [
            (3.31, False, False),
            (3.29, True, False),
            (3.21, True, False),
            (3.19, True, True),
            (3.1, True, True),
            (2.5, True, True),
        ],
    )
    def test_the_limits(self, each: float, low: bool, critical: bool) -> None:
        pack = Pack()
        pack.run(5.0)
        pack.each = 3.8
        pack.fly(20.0)
        pack.each = each
        facts = pack.fly(6.0)
        assert (facts.is_low, facts.is_critical) == (low, critical)

    def test_it_takes_half_the_window_to_believe_it(self) -> None:
        pack = Pack()
        pack.each = 3.8
        pack.fly(20.0)
        pack.each = 3.1
        assert not pack.fly(2.5).is_low
        assert pack.fly(1.2).is_critical

    def test_after_take_off_it_takes_a_moment(self) -> None:
        pack = Pack()
        pack.run(5.0)
        pack.each = 3.1
        assert pack.fly(4.4).volts is None
        assert pack.fly(0.7).is_critical

    @pytest.mark.fault("a dip of 2 s right after take-off", "the flight goes on")
    @pytest.mark.parametrize("each_s", [0.25, 0.5, 1.0])
    def test_a_dip_of_two_seconds_right_after_take_off_does_not_count(self, each_s: float) -> None:
        """The motors take their largest current there. ``each_s``: time between two readings."""
        for after_s in (0.0, 0.3, 1.0, 2.5):
            charge, now = ChargeReading(LIPO), 0.0
            facts = charge.update(None, (3,), now, is_airborne=False)
            while now < 12.0:
                each = 2.9 if after_s <= now < after_s + 2.0 else 3.7
                facts = charge.update(BatteryInfo(90.0, 3 * each, time=now), (3,), now, is_airborne=True)
                now += each_s
            assert not facts.is_low
            assert facts.volts == pytest.approx(3.7)

    def test_a_slow_battery_message_is_known_all_the_time_after_the_climb_out(self) -> None:
        charge, facts = ChargeReading(LIPO), []
        for tick in range(400):
            now = tick / 10
            reading = BatteryInfo(90.0, 3 * 3.7, time=2.0 * (tick // 20))
            facts.append(charge.update(reading, (3,), now, is_airborne=True))
        assert sum(each.volts is None for each in facts[50:]) <= 20

    @pytest.mark.fault("dips of 2.5 s, a voltage that trembles about the limit, a broken wire", "the flight goes on")
    @pytest.mark.parametrize("lasting_s", [0.5, 1.5, 2.5])
    def test_a_dip_does_not_count(self, lasting_s: float) -> None:
        pack = Pack()
        pack.each = 3.7
        pack.fly(10.0)
        for _ in range(5):
            pack.each = 2.9
            assert not pack.fly(lasting_s).is_low
            pack.each = 3.7
            assert not pack.fly(6.0).is_low

    @pytest.mark.fault("dips of 2.5 s, a voltage that trembles about the limit, a broken wire")
    def test_a_voltage_that_trembles_about_the_limit_counts_by_its_middle(self) -> None:
        pack = Pack()
        pack.airborne = True
        assert not pack.run(60.0, 0.1, lambda now: 3.4 + 0.2 * math.sin(8.0 * now)).is_low
        assert pack.run(20.0, 0.1, lambda now: 3.25 + 0.2 * math.sin(8.0 * now)).is_low

    def test_what_was_low_stays_low_until_the_landing(self) -> None:
        pack = Pack()
        pack.each = 3.15
        pack.fly(10.0)
        pack.each = 3.6
        facts = pack.fly(30.0)
        assert (facts.is_low, facts.is_critical) == (True, True)
        pack.airborne = False
        facts = pack.run(1.0)
        assert (facts.is_low, facts.is_critical) == (False, False)

    @pytest.mark.fault("dips of 2.5 s, a voltage that trembles about the limit, a broken wire")
    @pytest.mark.parametrize("each", [0.0, 0.3, 1.9])
    def test_a_wire_that_broke_is_no_empty_battery(self, each: float) -> None:
        pack = Pack()
        pack.each = 3.8
        pack.fly(10.0)
        pack.each = each
        facts = pack.fly(20.0)
        assert (facts.volts, facts.is_low) == (None, False)
        assert facts.believed == facts.counter

    def test_of_two_possible_counts_the_smaller_one_ends_no_flight(self) -> None:
        pack = Pack(cells=(3, 4))
        pack.each = 3.9
        assert not pack.fly(20.0).is_low

    def test_limits_of_the_settings(self) -> None:
        for charge, each, low, critical in (
            (ChargeReading(LIPO, return_v=3.5), 3.45, True, False),
            (ChargeReading(LIPO, land_v=3.28), 3.27, True, True),
            (ChargeReading(LIPO, return_v=3.0), 3.05, False, False),
            (ChargeReading(LIPO, return_v=3.0), 2.95, True, True),
            (ChargeReading(LIION), 3.1, False, False),
            (ChargeReading(LIION), 2.9, True, False),
            (ChargeReading(LIION), 2.75, True, True),
            (ChargeReading(LIHV), 3.35, True, False),
            (ChargeReading(LIHV), 3.25, True, True),
        ):
            pack = Pack(charge)
            pack.each = each
            facts = pack.fly(10.0)
            assert (facts.is_low, facts.is_critical) == (low, critical), each

    def test_words(self) -> None:
        pack = Pack()
        pack.counter, pack.each = 61.0, 3.27
        pack.airborne = True
        facts = pack.run(5.0)
        assert facts.words.startswith("3.27 V a cell of 3, the counter says 61 %, 6 % was believed, 5 s in the air")
        assert ChargeFacts().words == (
            "voltage not known, the counter says nothing, nothing else was believed, 0 s in the air."
        )


class TestTheCounter:
    def test_one_that_counts_is_believed(self) -> None:
        pack = Pack()
        pack.run(5.0)
        pack.each = 4.0
        for _ in range(60):
            facts = pack.fly(10.0, drain=1.0 / 32.0)
            assert facts.doubt == ""
            assert facts.believed == facts.counter

    def test_one_that_stands_still_is_counted_by_time(self) -> None:
        pack = Pack()
        pack.each = 4.0
        pack.fly(60.0)
        start, counter = pack.now, round(pack.counter or 0.0)
        assert pack.fly(65.0, drain=0.0).doubt == ""
        facts = pack.fly(20.0, drain=0.0)
        assert facts.doubt.startswith(f"the counter stands still at {counter} % for 72 s")
        assert facts.believed == pytest.approx(counter - (pack.now - start) * ASSUMED_DRAIN, abs=1.5)
        assert 7.0 < facts.doubted_s < 14.0
        later = pack.fly(120.0, drain=0.0)
        assert later.believed == pytest.approx((facts.believed or 0.0) - 120.0 * ASSUMED_DRAIN, abs=0.1)
        assert later.doubt == facts.doubt

    def test_one_that_never_moves_is_found_a_minute_after_take_off(self) -> None:
        pack = Pack()
        pack.run(300.0)  # on the ground it may
        pack.each = 4.0
        assert pack.fly(70.0, drain=0.0).doubt == ""
        assert pack.fly(10.0, drain=0.0).doubt

    @pytest.mark.fault(
        "the counter stands still in flight, creeps, begins again, or says more than the voltage under load allows"
    )
    def test_one_that_creeps_is_counted_by_time(self) -> None:
        """BATT_CAPACITY is ten times too large."""
        pack = Pack()
        pack.each = 4.0
        facts = pack.fly(400.0, drain=0.016)
        assert facts.doubt.startswith("the counter fell by ")
        assert facts.believed == pytest.approx(100.0 - 400.0 * ASSUMED_DRAIN, abs=1.5)

    def test_each_reading_of_the_voltage_counts_once(self) -> None:
        charge = ChargeReading(LIPO)
        facts = ChargeFacts()
        for tick in range(30):
            old = BatteryInfo(90.0, 11.4, 10.0, 1.0)
            facts = charge.update(old, (3,), 1.0 + tick / 20, is_airborne=False)
        assert facts.volts == pytest.approx(3.8)
        for time in (3.0, 4.0):
            facts = charge.update(BatteryInfo(90.0, 12.0, 10.0, time), (3,), time, is_airborne=False)
        assert facts.volts == pytest.approx(4.0), "the median of three readings"

    def test_a_voltage_that_is_gone_is_not_known(self) -> None:
        charge = ChargeReading(LIPO)
        assert charge.update(BatteryInfo(90.0, 12.0, 10.0, 1.0), (3,), 1.0, is_airborne=False).volts == 4.0
        assert charge.update(BatteryInfo(90.0, None, 10.0, 2.0), (3,), 2.0, is_airborne=False).volts is None
        assert charge.update(BatteryInfo(90.0, 12.0, 10.0, 3.0), (), 3.0, is_airborne=False).volts is None

    @pytest.mark.parametrize(("rise", "doubted"), [(1.0, False), (2.0, True)])
    def test_a_rise_by_more_than_its_rounding(self, rise: float, doubted: bool) -> None:
        pack = Pack()
        pack.each, pack.counter = 4.0, 95.0
        pack.fly(15.0, drain=0.0)
        pack.counter = 95.0 + rise
        words = f"the counter rose from 95 to {95.0 + rise:.0f} % in flight"
        assert pack.fly(12.0, drain=0.0).doubt == (words if doubted else "")

    def test_one_that_stands_still_at_its_last_percent(self) -> None:
        pack = Pack()
        pack.each, pack.counter = 4.0, 1.0
        assert pack.fly(71.0, drain=0.0).doubt == ""
        assert pack.fly(2.0, drain=0.0).doubt == "the counter stands still at 1 % for 72 s"

    @pytest.mark.parametrize("percentage", [-0.5, math.nan, math.inf])
    def test_one_that_is_no_number_says_nothing(self, percentage: float) -> None:
        facts = ChargeReading(LIPO).update(BatteryInfo(percentage, 12.0, 10.0, 1.0), (3,), 1.0, is_airborne=True)
        assert (facts.counter, facts.believed) == (None, None)

    @pytest.mark.parametrize(("drained", "doubted"), [(4.7, False), (4.6, True)])
    def test_the_slowest_that_is_believed_empties_a_battery_in_an_hour(self, drained: float, doubted: bool) -> None:
        """In 240 s such a drone uses 6.7 %; two of them are the counter's rounding."""
        charge = ChargeReading(LIPO)
        facts = ChargeFacts()
        for second in range(241):
            info = BatteryInfo(90.0 - drained * second / 240, 3 * 4.0, 10.0, float(second))
            facts = charge.update(info, (3,), float(second), is_airborne=True)
        assert bool(facts.doubt) is doubted

    @pytest.mark.fault(
        "the counter stands still in flight, creeps, begins again, or says more than the voltage under load allows"
    )
    @pytest.mark.parametrize("rise", [5.0, 25.0])
    def test_one_that_begins_again_is_not_believed(self, rise: float) -> None:
        pack = Pack()
        pack.each = 4.0
        pack.fly(300.0)
        before = round(pack.counter or 0.0)
        pack.counter = before + rise
        facts = pack.fly(10.0)
        assert facts.doubt == f"the counter rose from {before + 1} to {before + rise:.0f} % in flight"
        assert facts.believed == pytest.approx(before + 1 - 10.0 * ASSUMED_DRAIN, abs=0.2)
        assert (facts.believed or 0.0) < (facts.counter or 0.0)

    def test_one_that_was_low_for_a_moment_and_is_full_again_began_again(self) -> None:
        pack = Pack()
        pack.each = 4.0
        pack.fly(12.0)
        pack.counter = 55.0
        assert pack.fly(2.6).doubt == ""
        pack.counter = 100.0
        facts = pack.fly(1.0)
        assert facts.doubt == "the counter rose from 55 to 100 % in flight"
        assert facts.believed == pytest.approx(55.0, abs=0.5)

    @pytest.mark.parametrize(("low", "seconds", "back"), [(0.0, 1.0, 100.0), (55.0, 3.0, 98.0), (91.0, 5.0, 100.0)])
    def test_a_counter_that_dips_is_believed(self, low: float, seconds: float, back: float) -> None:
        pack = Pack()
        pack.each = 4.0
        pack.fly(12.0)
        pack.counter = low
        pack.fly(seconds)
        pack.counter = back
        assert pack.fly(1.0).doubt == ""

    def test_a_wavering_one_is_believed(self) -> None:
        pack = Pack()
        pack.each = 4.0
        pack.fly(100.0)
        pack.counter = (pack.counter or 0.0) + 1.0
        assert pack.fly(1.0).doubt == ""

    def test_one_that_falls_to_nothing_is_believed(self) -> None:
        pack = Pack()
        pack.each = 4.0
        pack.fly(50.0)
        pack.counter = 0.0
        facts = pack.fly(300.0)
        assert (facts.doubt, facts.believed) == ("", 0.0)

    def test_the_lower_word_counts_while_it_is_doubted(self) -> None:
        pack = Pack()
        pack.each = 4.0
        pack.fly(200.0, drain=0.0)
        pack.counter = 10.0
        assert pack.fly(1.0).believed == 10.0
        pack.counter = None
        facts = pack.fly(10.0)
        assert facts.counter is None
        assert facts.believed == pytest.approx(100.0 - 211.0 * ASSUMED_DRAIN, abs=1.0)

    @pytest.mark.slow
    def test_the_time_flown_never_says_less_than_nothing(self) -> None:
        pack = Pack()
        pack.each = 4.0
        assert pack.fly(1200.0, drain=0.0).believed == 0.0

    @pytest.mark.fault(
        "the counter stands still in flight, creeps, begins again, or says more than the voltage under load allows"
    )
    def test_a_voltage_under_load_contradicts_it(self) -> None:
        pack = Pack()
        pack.each = 4.0
        pack.fly(60.0)
        pack.each = 3.4  # 3.75 V at rest: a quarter
        facts = pack.fly(6.0)
        assert facts.doubt.endswith("% , 3.40 V a cell in flight is 25 % at most".replace("% ,", "%,"))
        assert facts.believed is not None
        assert facts.believed <= 25.0
        pack.each = 3.7
        later = pack.fly(10.0)
        assert later.doubt == facts.doubt
        assert later.believed is not None
        assert later.believed < facts.believed

    def test_the_next_flight_begins_again(self) -> None:
        pack = Pack()
        pack.each = 4.0
        assert pack.fly(120.0, drain=0.0).doubt
        pack.airborne = False
        facts = pack.run(3.0)
        assert (facts.doubt, facts.flown_s) == ("", 0.0)
        facts = pack.fly(60.0)
        assert facts.doubt == ""
        assert facts.flown_s == pytest.approx(60.0, abs=0.2)


class TestChemistry:
    @pytest.mark.parametrize("chemistry", CHEMISTRIES.values())
    def test_the_table_rises_from_empty_to_full(self, chemistry: Chemistry) -> None:
        volts, charges = zip(*chemistry.at_rest, strict=True)
        assert list(volts) == sorted(set(volts))
        assert list(charges) == sorted(set(charges))
        assert (charges[0], charges[-1]) == (0.0, 100.0)
        assert chemistry.land_v < chemistry.return_v <= chemistry.low[0] + 0.1 < chemistry.low_usual < chemistry.low[1]
        assert chemistry.resting[0] < chemistry.resting[1]

    def test_the_rows_are_evenly_spaced(self) -> None:
        assert [charge for _, charge in LIPO.at_rest] == [5.0 * row for row in range(21)]
        for chemistry in (LIHV, LIION):
            assert [charge for _, charge in chemistry.at_rest] == [0.0, 5.0, *(10.0 * row for row in range(1, 11))]

    @pytest.mark.parametrize(("volts", "cells"), [(10.5, (3,)), (12.75, (3,)), (12.76, ()), (10.49, ()), (8.5, (2,))])
    def test_the_limits_of_a_count(self, volts: float, cells: tuple[int, ...]) -> None:
        assert LIPO.possible_cells(volts, None, in_flight=False) == cells

    def test_the_counts_that_drones_use(self) -> None:
        possible = {count: LIPO.possible_cells(count * 3.8, None, in_flight=False) for count in range(1, 16)}
        assert [count for count, found in possible.items() if count in found] == [2, 3, 4, 5, 6, 8, 10, 12, 14]
        assert {count for found in possible.values() for count in found} == {2, 3, 4, 5, 6, 8, 10, 12, 14}

    @pytest.mark.parametrize(("chemistry", "volts"), [(LIPO, 16.6), (LIHV, 17.1), (LIION, 16.0)])
    def test_in_flight_a_nearly_empty_larger_battery_is_possible_too(self, chemistry: Chemistry, volts: float) -> None:
        assert chemistry.possible_cells(volts, None, in_flight=True) == (4, 5)

    @given(st.floats(0.0, 6.0), st.floats(0.0, 6.0))
    def test_more_volts_are_never_less_charge(self, one: float, other: float) -> None:
        low, high = sorted((one, other))
        assert 0.0 <= LIPO.charge(low) <= LIPO.charge(high) <= 100.0

    def test_between_two_rows_it_is_linear(self) -> None:
        assert LIPO.charge(3.27) == 0.0
        assert LIPO.charge(3.0) == 0.0
        assert LIPO.charge(3.65) == pytest.approx(7.5)
        assert LIPO.charge(3.84) == 50.0
        assert LIPO.charge(4.2) == 100.0
        assert LIPO.charge(4.5) == 100.0
        assert LIION.charge(3.73) == 50.0
        assert LIHV.charge(4.35) == 100.0

    def test_cells_in_flight(self) -> None:
        def cells(volts: float | None, chemistry: Chemistry = LIPO) -> tuple[int, ...]:
            return chemistry.possible_cells(volts, None, in_flight=True)

        assert cells(12.0) == (3,)
        assert cells(9.3) == (3,)  # it sags to 3.1 V
        assert cells(1.0) == ()
        assert cells(None) == ()
        assert LIPO.possible_cells(12.0, 4, in_flight=True) == (4,)
