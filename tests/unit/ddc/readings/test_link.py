"""The events of the link, moment by moment."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import cast

import pytest

from hawk.comm.autopilot.vehicle import VehicleTopics
from hawk.ddc.readings.belief import DOUBT_CONFIRM_S, Belief, GroundFacts
from hawk.ddc.readings.link import KEPT_WRITES, WRITES_S, ForeignWrites, LinkFacts, LinkReading, VehicleEvent
from hawk.ddc.readings.topic_interface import DdcTopicInterface
from hawk.model.operation import Health
from hawk.model.vehicle import CopterMode, ForeignWrite, LandedState, VehicleState


@dataclass
class Ends:
    """A link of a health, the modes that were asked for, and the reading of both."""

    healthy: bool = True
    asked: set[int | None] = field(default_factory=set)

    def __post_init__(self) -> None:
        self.vehicle = VehicleTopics.create(lambda: 0.0)
        self.link = LinkReading(cast(DdcTopicInterface, self), lambda mode: mode in self.asked)
        self.mode: int | None = None
        """The mode that was first seen in the last observation."""

    def get_link_health(self) -> Health:
        return Health() if self.healthy else Health.bad("silent")

    def observe(self, vehicle: VehicleState, now: float, doubt: str = "") -> tuple[VehicleEvent, ...]:
        self.link.observe(Belief(vehicle, GroundFacts(doubt=doubt, doubted_s=DOUBT_CONFIRM_S)), now)
        facts = self.link.take_events(LinkFacts())
        self.mode = facts.new_mode
        return facts.events


def state(mode: int = CopterMode.GUIDED, landed: LandedState = LandedState.IN_AIR, armed: bool = True) -> VehicleState:
    return VehicleState(True, armed, mode, landed, 0.0, 0.0)


def test_an_armed_drone_without_a_landed_state_is_found_after_a_while_only() -> None:
    ends = Ends()
    unknown = state(landed=LandedState.UNDEFINED)
    assert ends.observe(unknown, 10.0) == ()
    assert ends.observe(unknown, 11.49) == ()
    assert [ends.link.is_up] == [False]
    assert ends.observe(unknown, 11.5) == (VehicleEvent.FOUND,)
    assert ends.link.is_up


@pytest.mark.parametrize("known", [state(), state(landed=LandedState.UNDEFINED, armed=False)])
def test_a_drone_whose_place_is_known_or_that_is_disarmed_is_found_at_once(known: VehicleState) -> None:
    assert Ends().observe(known, 10.0) == (VehicleEvent.FOUND,)


def test_nothing_is_found_on_a_silent_link() -> None:
    ends = Ends(healthy=False)
    assert ends.observe(state(), 10.0) == ()
    assert ends.observe(state(), 99.0) == ()
    assert not ends.link.is_up


def test_the_link_is_lost_and_back_once_and_a_mode_of_the_silence_is_no_second_event() -> None:
    ends = Ends()
    ends.observe(state(), 0.0)
    ends.healthy = False
    assert ends.observe(state(CopterMode.RTL), 1.0) == (VehicleEvent.LINK_LOST,)
    assert (ends.link.is_up, ends.mode) == (False, None), "what is not heard is not seen"
    assert ends.observe(state(CopterMode.RTL), 2.0) == ()
    ends.healthy = True
    assert ends.observe(state(CopterMode.RTL), 3.0) == (VehicleEvent.LINK_BACK,)
    assert (ends.link.is_up, ends.mode, ends.link.mode_changed_at) == (True, CopterMode.RTL, 3.0)
    assert ends.observe(state(CopterMode.RTL), 4.0) == ()


def test_a_mode_that_was_asked_for_is_ours_and_any_other_is_foreign_once() -> None:
    ends = Ends(asked={CopterMode.RTL})
    ends.observe(state(), 0.0)
    assert (ends.mode, ends.link.mode_changed_at) == (None, float("-inf"))
    assert ends.observe(state(CopterMode.RTL), 1.0) == ()
    assert ends.mode == CopterMode.RTL
    assert ends.observe(state(CopterMode.LOITER), 2.0) == (VehicleEvent.FOREIGN_MODE,)
    assert (ends.mode, ends.link.mode_changed_at) == (CopterMode.LOITER, 2.0)
    assert ends.observe(state(CopterMode.LOITER), 3.0) == ()
    assert ends.mode is None, "it was seen first a tick ago"


def test_events_wait_in_their_order_until_a_tick_takes_them() -> None:
    ends = Ends()
    for healthy, mode in ((True, CopterMode.GUIDED), (False, CopterMode.GUIDED), (True, CopterMode.LOITER)):
        ends.healthy = healthy
        ends.link.observe(Belief(state(mode), GroundFacts()), 1.0)
    facts = ends.link.take_events(LinkFacts(age=0.3))
    assert facts.events == (VehicleEvent.FOUND, VehicleEvent.LINK_LOST, VehicleEvent.LINK_BACK)
    assert (facts.new_mode, facts.age) == (CopterMode.LOITER, 0.3)
    assert ends.link.take_events(LinkFacts()) == LinkFacts()


def test_a_link_that_was_lost_and_is_back_is_unbroken_again_once_a_tick_took_it() -> None:
    ends = Ends()
    seen = [ends.link.is_unbroken]
    for healthy in (True, False, True):
        ends.healthy = healthy
        ends.link.observe(Belief(state(), GroundFacts()), 1.0)
        seen.append(ends.link.is_unbroken)
    ends.link.take_events(LinkFacts())
    assert [*seen, ends.link.is_unbroken] == [False, True, False, False, True]


def test_a_doubt_is_one_event_after_those_of_the_link_and_none_without_it() -> None:
    ends = Ends()
    assert ends.observe(state(), 0.0, doubt="It says both.") == (VehicleEvent.FOUND, VehicleEvent.DOUBTED)
    assert ends.observe(state(), 1.0, doubt="It says both.") == ()
    ends.healthy = False
    assert ends.observe(state(), 2.0, doubt="It says both.") == (VehicleEvent.LINK_LOST,)
    assert ends.observe(state(), 3.0, doubt="It says both.") == ()
    ends.healthy = True
    assert ends.observe(state(), 4.0, doubt="It says both.") == (VehicleEvent.LINK_BACK, VehicleEvent.DOUBTED)


def test_a_doubt_that_is_younger_than_half_a_second_is_no_event() -> None:
    ends = Ends()
    ends.link.observe(Belief(state(), GroundFacts(doubt="It says both.", doubted_s=0.49)), 0.0)
    assert ends.link.take_events(LinkFacts()).events == (VehicleEvent.FOUND,)


def test_what_others_write_is_kept_for_a_while_and_not_without_end() -> None:
    writes = ForeignWrites()
    for number in range(KEPT_WRITES + 2):
        writes.note(ForeignWrite(100.0, 254, 190, str(number)))
    assert [write.subject for write in writes.recent(100.0 + WRITES_S)] == [str(k) for k in range(2, KEPT_WRITES + 2)]
    assert writes.recent(100.1 + WRITES_S) == ()
