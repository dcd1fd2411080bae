"""Stopwatch, jumps and the events of the link, moment by moment."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import cast

import pytest

from hawk.ddc.readings.link import KEPT_WRITES, WRITES_S, ForeignWrites, Jumps, LinkWatch, VehicleEvent
from hawk.ddc.readings.topic_interface import DdcTopicInterface
from hawk.ddc.requests.service_interface import DdcServiceInterface
from hawk.ddc.stopwatch import Stopwatch
from hawk.model.operation import Health
from hawk.model.vehicle import CopterMode, ForeignWrite, LandedState, VehicleState


@dataclass
class Ends:
    """Health of the link, and the modes that were asked for."""

    healthy: bool = True
    asked: set[int | None] = field(default_factory=set)
    settled: list[int | None] = field(default_factory=list)

    def get_link_health(self) -> Health:
        return Health() if self.healthy else Health.bad("silent")

    def asked_for(self, mode: int | None) -> bool:
        return mode in self.asked

    def settle_mode(self, mode: int | None) -> None:
        self.settled.append(mode)

    def watch(self) -> LinkWatch:
        return LinkWatch(cast(DdcTopicInterface, self), cast(DdcServiceInterface, self))


def state(mode: int = CopterMode.GUIDED, landed: LandedState = LandedState.IN_AIR, armed: bool = True) -> VehicleState:
    return VehicleState(True, armed, mode, landed, 0.0, 0.0)


def test_a_stopwatch_times_a_condition_and_begins_again() -> None:
    watch = Stopwatch()
    assert watch.update(False, 1.0) is None
    assert watch.update(True, 2.0) == 0.0
    assert watch.update(True, 5.0) == 3.0
    assert watch.read(6.0) == 4.0
    assert watch.update(False, 7.0) is None
    assert watch.update(True, 9.0) == 0.0


def test_of_two_jumps_the_larger_counts_once_whatever_its_sign() -> None:
    jumps = Jumps()
    for metres in (1.0, -4.0, 2.0):
        jumps.note(metres)
    assert jumps.take() == 4.0
    assert jumps.take() == 0.0


@pytest.mark.parametrize("metres", [0.3, -0.3])
def test_the_first_jump_counts_however_small_it_is(metres: float) -> None:
    jumps = Jumps()
    jumps.note(metres)
    assert jumps.take() == 0.3
    assert Jumps().take() == 0.0


def test_an_armed_drone_without_a_landed_state_is_found_after_a_while_only() -> None:
    watch = Ends().watch()
    unknown = state(landed=LandedState.UNDEFINED)
    assert watch.observe(unknown, 10.0) == ()
    assert watch.observe(unknown, 11.49) == ()
    assert [watch.is_up] == [False]
    assert watch.observe(unknown, 11.5) == (VehicleEvent.FOUND,)
    assert watch.is_up


@pytest.mark.parametrize("known", [state(), state(landed=LandedState.UNDEFINED, armed=False)])
def test_a_drone_whose_place_is_known_or_that_is_disarmed_is_found_at_once(known: VehicleState) -> None:
    assert Ends().watch().observe(known, 10.0) == (VehicleEvent.FOUND,)


def test_nothing_is_found_on_a_silent_link() -> None:
    ends = Ends(healthy=False)
    watch = ends.watch()
    assert watch.observe(state(), 10.0) == ()
    assert watch.observe(state(), 99.0) == ()
    assert not watch.is_up


def test_the_link_is_lost_and_back_once_and_a_mode_of_the_silence_is_no_second_event() -> None:
    ends = Ends()
    watch = ends.watch()
    watch.observe(state(), 0.0)
    ends.healthy = False
    assert watch.observe(state(CopterMode.RTL), 1.0) == (VehicleEvent.LINK_LOST,)
    assert [watch.is_up] == [False]
    assert watch.observe(state(CopterMode.RTL), 2.0) == ()
    ends.healthy = True
    assert watch.observe(state(CopterMode.RTL), 3.0) == (VehicleEvent.LINK_BACK,)
    assert watch.is_up
    assert watch.mode_changed_at == 3.0
    assert watch.observe(state(CopterMode.RTL), 4.0) == ()


def test_a_mode_that_was_asked_for_is_ours_and_any_other_is_foreign_once() -> None:
    ends = Ends(asked={CopterMode.RTL})
    watch = ends.watch()
    watch.observe(state(), 0.0)
    assert watch.mode_changed_at == float("-inf")
    assert watch.observe(state(CopterMode.RTL), 1.0) == ()
    assert ends.settled == [CopterMode.RTL]
    assert watch.observe(state(CopterMode.LOITER), 2.0) == (VehicleEvent.FOREIGN_MODE,)
    assert watch.mode_changed_at == 2.0
    assert watch.observe(state(CopterMode.LOITER), 3.0) == ()


def test_what_others_write_is_kept_for_a_while_and_not_without_end() -> None:
    writes = ForeignWrites()
    for number in range(KEPT_WRITES + 2):
        writes.note(ForeignWrite(100.0, 254, 190, str(number)))
    assert [write.subject for write in writes.recent(100.0 + WRITES_S)] == [str(k) for k in range(2, KEPT_WRITES + 2)]
    assert writes.recent(100.1 + WRITES_S) == ()
