"""The one keeper by facts alone: efforts that end, what is written and what is not, the fence that is read again."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from hawk.comm.autopilot.vehicle import OTHER_FENCE
from hawk.comm.mavlink.foreign_writes import FENCE as FENCE_SUBJECT
from hawk.ddc.acts import (
    Acts,
    Ask,
    CompareFence,
    EnableFence,
    Log,
    PutBack,
    Request,
    SetHome,
    UploadFence,
)
from hawk.ddc.facts import Answer, Facts
from hawk.ddc.keeper.effort import PAUSE_S, TRIES, UNKNOWN, WINDOW_S, Effort, changed_by
from hawk.ddc.keeper.fence import COMPARE_S, RETRY_S, STALE_S, SWITCH_CONFIRM_S, KeptFence, is_inside
from hawk.ddc.keeper.keeper import LOST_S, Keeper, KeptHome
from hawk.ddc.keeper.parameters import PATIENCE_S, KeptParameters
from hawk.ddc.orders import ToHover, ToManual
from hawk.ddc.parameters.failsafes import check_failsafes
from hawk.ddc.parameters.values import FailsafeCheck
from hawk.ddc.readings.home import HomeFacts
from hawk.ddc.rules.preflight import autopilot_view
from hawk.ddc.states.base import State
from hawk.ddc.states.hover import HoverState, ManualState
from hawk.model.vehicle import ForeignWrite
from tests.unit.ddc.by_facts import made, read_all
from tests.unit.ddc.fakes import SAFE_PARAMETERS
from tests.unit.ddc.written_facts import FENCE, SETTINGS, flying, on_ground, pose, without_link

HOVER = HoverState(0.0, SETTINGS)
SET = PutBack("BATT_FS_LOW_ACT", 2.0)
VALUES: dict[str, float | None] = dict(SAFE_PARAMETERS)


def answered(facts: Facts, ask: Ask, status: str, reason: str = "") -> Facts:
    return replace(facts, answers=(Answer(ask.name, ask.at, status, reason),))  # type: ignore[arg-type]


def asks(acts: Acts, *kinds: type[Request]) -> list[Ask]:
    return [act for act in acts if isinstance(act, Ask) and isinstance(act.request, kinds or object)]


def texts(acts: Acts) -> list[str]:
    return [act.text for act in acts if isinstance(act, Log)]


class TestEffort:
    def test_one_request_is_under_way_at_a_time(self) -> None:
        effort = Effort(30.0)
        (ask,) = asks(effort.put_back(SET, flying(1.0)))
        assert (effort.is_wrong, effort.is_given_up) == (True, False)
        assert effort.put_back(SET, answered(flying(1.1), ask, "pending")) == ()
        effort.rest(answered(flying(1.2), ask, "done"))
        assert (effort.is_wrong, effort.is_given_up) == (False, False)

    def test_a_refusal_is_followed_by_a_pause_and_keeps_its_words(self) -> None:
        effort = Effort(30.0)
        (ask,) = asks(effort.put_back(SET, flying(1.0)))
        assert effort.put_back(SET, answered(flying(2.0), ask, "failed", "busy")) == ()
        assert effort.reason == "busy"
        assert effort.put_back(SET, flying(2.0 + PAUSE_S - 0.01)) == ()
        assert len(effort.put_back(SET, flying(2.0 + PAUSE_S))) == 1

    def test_who_changes_it_again_and_again_wins_after_three_times(self) -> None:
        effort, now = Effort(30.0), 0.0
        for _ in range(TRIES):
            now += 2.0
            (ask,) = asks(effort.put_back(SET, flying(now)))
            effort.rest(answered(flying(now + 1.0), ask, "done"))
        assert effort.put_back(SET, flying(now + 2.0)) == ()
        assert effort.is_given_up
        assert effort.put_back(SET, flying(now + 10 * WINDOW_S)) == (), "never again in this flight"

    def test_changes_that_are_minutes_apart_are_put_back_each_time(self) -> None:
        effort = Effort(30.0)
        for number in range(2 * TRIES):
            now = number * (WINDOW_S / TRIES + 0.1)
            (ask,) = asks(effort.put_back(SET, flying(now)))
            effort.rest(answered(flying(now + 1.0), ask, "done"))
        assert not effort.is_given_up

    @pytest.mark.parametrize(("fourth", "given_up"), [(59.9, True), (60.0, False)])
    def test_the_fourth_change_counts_for_a_minute_after_the_first(self, fourth: float, given_up: bool) -> None:
        effort = Effort(30.0)
        for now in (0.0, 20.0, 40.0):
            (ask,) = asks(effort.put_back(SET, flying(now)))
            effort.rest(answered(flying(now + 1.0), ask, "done"))
        effort.put_back(SET, flying(fourth))
        assert effort.is_given_up is given_up

    def test_after_a_refusal_it_waits_two_seconds_and_gives_up_after_its_patience_not_at_it(self) -> None:
        effort = Effort(5.0)
        (ask,) = asks(effort.put_back(SET, flying(0.0)))
        effort.put_back(SET, answered(flying(3.0), ask, "failed"))
        assert asks(effort.put_back(SET, flying(4.99))) == []
        assert len(asks(effort.put_back(SET, flying(5.0)))) == 1
        assert not effort.is_given_up

    def test_a_thing_that_stays_wrong_is_given_up(self) -> None:
        effort = Effort(5.0)
        (ask,) = asks(effort.put_back(SET, flying(0.0)))
        assert effort.put_back(SET, answered(flying(5.0), ask, "pending")) == ()
        assert not effort.is_given_up, "a request is under way"
        assert effort.put_back(SET, answered(flying(5.1), ask, "done")) == ()
        assert effort.is_given_up

    def test_one_without_a_limit_goes_on(self) -> None:
        effort = Effort(float("inf"), tries=None)
        for number in range(20):
            (ask,) = asks(effort.put_back(SET, flying(10.0 * number)))
            effort.put_back(SET, answered(flying(10.0 * number + 1.0), ask, "failed"))
        assert not effort.is_given_up


def checks(facts: Facts, **changed: float | None) -> tuple[FailsafeCheck, ...]:
    return check_failsafes({**VALUES, **changed}, autopilot_view(facts, SETTINGS))


def keep(kept: KeptParameters, facts: Facts, *, may_write: bool = True, **changed: float | None) -> Acts:
    return kept.tick(facts, {**VALUES, **changed}, autopilot_view(facts, SETTINGS), may_write=may_write)


class TestParameters:
    def test_what_was_right_in_this_flight_is_put_back_to_what_it_was(self) -> None:
        kept = KeptParameters()
        assert keep(kept, flying(1.0), BATT_FS_LOW_ACT=3) == ()
        acts = keep(kept, flying(1.1), BATT_FS_LOW_ACT=5)
        assert [ask.request for ask in asks(acts)] == [PutBack("BATT_FS_LOW_ACT", 3)]
        assert texts(acts) == ["Battery failsafe: cuts the motors (BATT_FS_LOW_ACT 5). No new task until it is right."]
        assert kept.restored == {"Battery failsafe"}
        again = keep(kept, flying(1.3), BATT_FS_LOW_ACT=3)
        assert texts(again) == ["Battery failsafe is right again: returns home."]
        assert kept.restored == frozenset()

    def test_a_ceiling_of_before_the_fence_was_known_is_not_put_back(self) -> None:
        kept, limits = KeptParameters(), flying(1.0).limits
        keep(kept, replace(flying(1.0), limits=replace(limits, fence=None, held=None)), FENCE_ALT_MAX=20)
        keep(kept, flying(1.1), FENCE_ALT_MAX=20)
        assert kept.known == frozenset(), "it was right before there was a fence, and no more"
        keep(kept, flying(1.2))
        acts = keep(kept, flying(1.3), FENCE_ACTION=0)
        assert [ask.request for ask in asks(acts)] == [PutBack("FENCE_ACTION", 1)]

    def test_the_last_values_that_were_right_are_put_back_also_those_of_an_earlier_run(self) -> None:
        kept = KeptParameters({"FENCE_ALT_MAX": 60.0, "BATT_FS_LOW_ACT": 1.0})
        keep(kept, flying(1.0), BATT_FS_LOW_ACT=3)
        acts = keep(kept, flying(1.1), BATT_FS_LOW_ACT=5, FENCE_ACTION=0)
        assert {ask.request for ask in asks(acts)} == {PutBack("FENCE_ACTION", 1), PutBack("BATT_FS_LOW_ACT", 3)}

    def test_what_was_never_right_is_reported_and_not_written(self) -> None:
        kept = KeptParameters()
        (messages,) = keep(kept, flying(1.0), BATT_FS_LOW_ACT=5)
        assert isinstance(messages, Log)
        assert messages.details == "With an empty battery the drone falls. Return or land, then Set failsafes."
        assert keep(kept, flying(1.1), BATT_FS_LOW_ACT=5) == ()
        assert kept.restored == frozenset()
        assert kept.lost == ()

    def test_what_an_earlier_run_found_right_in_this_flight_is_put_back(self) -> None:
        kept = KeptParameters({"BATT_FS_LOW_ACT": 3.0})
        assert keep(kept, without_link(on_ground(flying(0.5)))) == (), "the autopilot is not heard yet"
        acts = keep(kept, flying(1.0), BATT_FS_LOW_ACT=5)
        assert [ask.request for ask in asks(acts)] == [PutBack("BATT_FS_LOW_ACT", 3)]
        assert kept.right["BATT_FS_LOW_ACT"] == 3.0

    def test_an_autopilot_that_is_found_disarmed_ends_that_flight(self) -> None:
        kept = KeptParameters({"BATT_FS_LOW_ACT": 3.0})
        keep(kept, on_ground(flying(0.5)))
        assert asks(keep(kept, flying(1.0), BATT_FS_LOW_ACT=5)) == []

    def test_another_remedy_than_set_failsafes_is_named(self) -> None:
        (messages,) = keep(KeptParameters(), flying(1.0), BATT_LOW_VOLT=0.0)
        assert isinstance(messages, Log)
        assert "Set failsafes" not in messages.details
        assert "Set BATT_LOW_VOLT" in messages.details

    @pytest.mark.parametrize(
        ("may_write", "words"),
        [(True, "It is being put back."), (False, "It is put back when the drone is taken from the pilot.")],
    )
    def test_a_fence_that_is_switched_off_is_put_back_by_hawk_and_not_by_the_operator(
        self, may_write: bool, words: str
    ) -> None:
        facts = flying(1.0)
        off = replace(facts, diagnostics=replace(facts.diagnostics, fence_on=False))
        (messages,) = keep(KeptParameters(), off, may_write=may_write)
        assert isinstance(messages, Log)
        assert words in messages.details
        assert "remote control" not in messages.details

    def test_one_that_is_not_read_is_neither_right_nor_wrong(self) -> None:
        kept = KeptParameters()
        keep(kept, flying(1.0))
        assert keep(kept, flying(1.1), BATT_FS_LOW_ACT=None) == ()
        unread = {name: value for name, value in VALUES.items() if name != "BATT_FS_LOW_ACT"}
        assert kept.tick(flying(1.2), unread, autopilot_view(flying(1.2), SETTINGS), may_write=True) == ()

    def test_what_is_wrong_for_another_reason_is_put_back_all_the_same(self) -> None:
        """Six cells or five: a low voltage of 21 V that was right does not fit five cells. Off is worse."""
        facts = flying(1.0)
        facts = replace(facts, battery=replace(facts.battery, cells=(5, 6)))
        kept = KeptParameters({"BATT_LOW_VOLT": 21.0})
        acts = keep(kept, facts, BATT_LOW_VOLT=0.0)
        assert [ask.request for ask in asks(acts)] == [PutBack("BATT_LOW_VOLT", 21.0)]

    @pytest.mark.fault(
        "what was right in an earlier run is wrong by the limits of this flight",
        "it is not written; reported, no new task, Set failsafes is the remedy",
    )
    def test_what_would_be_wrong_by_the_limits_of_now_is_not_put_back(self) -> None:
        """Heights of an earlier run that were right below its ceiling of 200 m; this flight's is 100 m."""
        kept = KeptParameters({"RTL_ALT": 15_000.0, "FENCE_ALT_MAX": 200.0, "FENCE_ACTION": 1.0})
        acts = keep(kept, flying(1.0), RTL_ALT=30_000.0, FENCE_ACTION=0.0, FENCE_ALT_MAX=20.0)
        assert asks(acts) == []
        assert kept.known == frozenset()
        assert any("Return or land, then Set failsafes." in log.details for log in acts if isinstance(log, Log))
        kept = KeptParameters({"RTL_ALT": 15_000.0, "FENCE_ACTION": 1.0})
        acts = keep(kept, flying(1.1), RTL_ALT=30_000.0, FENCE_ACTION=0.0)
        assert [ask.request for ask in asks(acts)] == [PutBack("FENCE_ACTION", 1.0)]

    def test_a_missing_parameter_is_not_written(self) -> None:
        kept = KeptParameters()
        keep(kept, flying(1.0))
        acts = keep(kept, flying(1.1), RTL_LOIT_TIME=None, RTL_ALT_FINAL=500)
        assert [ask.request for ask in asks(acts)] == [PutBack("RTL_ALT_FINAL", 0)]

    def test_every_value_that_is_written_passes_its_check(self) -> None:
        for name in sorted(set(SAFE_PARAMETERS) - {"FENCE_TOTAL"}):
            for wrong in (-1.0, 5.0, 300.0, 1e6):
                kept = KeptParameters()
                keep(kept, flying(1.0))
                values = {**VALUES, name: wrong}
                acts = kept.tick(flying(1.1), values, autopilot_view(flying(1.1), SETTINGS), may_write=True)
                written = [ask.request for ask in asks(acts)]
                values |= {each.parameter: each.value for each in written if isinstance(each, PutBack)}
                assert all(check.passed for check in check_failsafes(values, autopilot_view(flying(1.0), SETTINGS)))

    def test_while_a_pilot_flies_nothing_is_written_and_nothing_given_up(self) -> None:
        kept = KeptParameters()
        keep(kept, flying(0.0))
        for second in range(int(PATIENCE_S) + 5):
            facts = flying(1.0 + second)
            assert asks(keep(kept, facts, may_write=False, BATT_FS_LOW_ACT=5)) == []
        assert (kept.lost, kept.restored) == ((), frozenset())
        assert len(asks(keep(kept, flying(60.0), BATT_FS_LOW_ACT=5))) == 1

    def test_outside_the_fence_only_the_fences_parameters_wait(self) -> None:
        kept = KeptParameters()
        keep(kept, flying(1.0))
        outside = flying(1.1)
        outside = replace(outside, position=replace(outside.position, pose=pose(1.1, 160.0)))
        acts = keep(kept, outside, FENCE_ACTION=0, FS_GCS_ENABLE=0)
        assert [ask.request for ask in asks(acts)] == [PutBack("FS_GCS_ENABLE", 1)]
        inside = keep(kept, flying(1.2), FENCE_ACTION=0, FS_GCS_ENABLE=0)
        assert PutBack("FENCE_ACTION", 1) in [ask.request for ask in asks(inside)]

    @pytest.mark.parametrize(
        ("north", "height", "inside"), [(0.0, 30.0, True), (160.0, 30.0, False), (0.0, 97.0, True), (0.0, 97.1, False)]
    )
    def test_inside_is_under_the_ceiling_as_well(self, north: float, height: float, inside: bool) -> None:
        facts = flying(1.0)
        assert is_inside(replace(facts, position=replace(facts.position, pose=pose(1.0, north, 0.0, height)))) is inside

    def test_without_a_position_or_a_fence_nobody_is_inside(self) -> None:
        facts = flying(1.0)
        assert not is_inside(replace(facts, position=replace(facts.position, age=5.0)))
        assert not is_inside(replace(facts, limits=replace(facts.limits, fence=None)))

    def test_what_cannot_be_put_back_is_lost_once_and_named_with_its_value(self) -> None:
        kept, now = KeptParameters(), 1.0
        keep(kept, flying(now))
        messages: list[str] = []
        while now < 20.0:
            now += 0.5
            acts = keep(kept, flying(now), BATT_FS_LOW_ACT=5)  # each answer is "no answer"
            messages += texts(acts)
        assert list(kept.lost) == ["BATT_FS_LOW_ACT 5"]
        assert messages.count("BATT_FS_LOW_ACT cannot be put back to 2.") == 1
        keep(kept, flying(now + 1))
        assert list(kept.lost) == []
        keep(kept, on_ground(flying(now + 2)))
        keep(kept, flying(now + 3))
        assert len(asks(keep(kept, flying(now + 4), BATT_FS_LOW_ACT=5))) == 1, "another flight"

    def test_fighting_is_named_where_no_words_were_given(self) -> None:
        kept, now = KeptParameters(), 0.0
        messages: Acts = ()
        for _ in range(TRIES + 1):
            now += 2.0
            keep(kept, flying(now))
            messages = keep(kept, flying(now + 0.1), BATT_FS_LOW_ACT=5)
            for ask in asks(messages):
                keep(kept, answered(flying(now + 0.2), ask, "done"))
        (lost,) = [act for act in messages if isinstance(act, Log) and "cannot be put back" in act.text]
        assert lost.details == "Somebody changes it again and again."

    def test_limits_of_the_flight_are_kept(self) -> None:
        kept = KeptParameters()
        keep(kept, flying(1.0))
        acts = keep(kept, flying(1.1), RTL_ALT=30_000, FENCE_ALT_MAX=400)
        assert [ask.request for ask in asks(acts)] == [PutBack("FENCE_ALT_MAX", 100), PutBack("RTL_ALT", 1500)]
        assert "Return height: 300 m, must be at most 97 m." in " ".join(texts(acts))
        assert "its ceiling is 400 m, must be 100 m (FENCE_ALT_MAX)" in " ".join(texts(acts))
        for ceiling, passes in ((97.0, False), (97.5, True), (100.1, True), (100.2, False)):
            found = {check.name: check.passed for check in checks(flying(1.0), FENCE_ALT_MAX=ceiling)}
            assert found["Fence in the autopilot"] is passes
        for height, passes in ((-1, False), (0, True), (9700, True), (9701, False)):
            found = {check.name: check.passed for check in checks(flying(1.0), RTL_ALT=height)}
            assert found["Return height"] is passes
        unread = {check.name: check for check in checks(flying(1.0), RTL_ALT=None, FENCE_ALT_MAX=None)}
        assert not unread["Return height"].is_read
        assert not unread["Fence in the autopilot"].is_read
        assert "Return height" not in {check.name for check in checks(on_ground(flying(1.0)))}


class TestChanges:
    def test_the_last_station_that_wrote_it_is_named(self) -> None:
        facts = flying(50.0)
        writes = (
            ForeignWrite(10.0, 9, 1, "A"),
            ForeignWrite(45.0, 254, 190, "A"),
            ForeignWrite(46.0, 255, 190, "B"),
        )
        facts = replace(facts, link=replace(facts.link, foreign_writes=writes))
        assert changed_by(facts, ("A",)).message == "Station 254 (component 190) changed it."
        assert changed_by(facts, ("C",)).details == UNKNOWN
        assert changed_by(replace(facts, now=75.0), ("A",)).message == "Station 254 (component 190) changed it."
        assert changed_by(replace(facts, now=75.1), ("A",)).message == ""


class Fences:
    """A kept fence in a flight, with its time."""

    def __init__(self) -> None:
        self.kept = KeptFence(SETTINGS)
        self.now = 1.0
        self.held = True
        self.on: bool | None = True
        self.north = 0.0
        self.corners: float | None = 48
        self.enable: float = 1

    def facts(self, *answers: Answer) -> Facts:
        facts = flying(self.now)
        return replace(
            facts,
            limits=replace(facts.limits, held=FENCE if self.held else None),
            diagnostics=replace(facts.diagnostics, fence_on=self.on),
            position=replace(facts.position, pose=pose(self.now, self.north)),
            answers=answers,
        )

    def tick(self, *answers: Answer, state: HoverState | ManualState = HOVER, after: float = 0.05) -> Acts:
        self.now += after
        values = {"FENCE_TOTAL": self.corners, "FENCE_ENABLE": self.enable}
        return self.kept.tick(self.facts(*answers), state, values)


def end(ask: Ask, status: str, reason: str = "") -> Answer:
    return Answer(ask.name, ask.at, status, reason)  # type: ignore[arg-type]


ANOTHER = f"{OTHER_FENCE}: its polygon is another one"


class TestFence:
    def compared(self, fences: Fences) -> Ask:
        fences.tick()
        (ask,) = asks(fences.tick(after=COMPARE_S), CompareFence)
        return ask

    def test_a_held_fence_is_read_again_within_ten_seconds(self) -> None:
        fences = Fences()
        assert fences.tick() == ()
        assert fences.tick(after=COMPARE_S - 0.1) == ()
        (ask,) = asks(fences.tick(after=0.1), CompareFence)
        assert fences.tick(end(ask, "pending")) == ()
        assert fences.kept.problem == ""
        assert fences.tick(end(ask, "done")) == ()
        assert fences.tick(after=COMPARE_S - 0.1) == ()
        assert len(fences.tick(after=0.1)) == 1

    def test_a_change_of_its_number_of_corners_asks_at_once(self) -> None:
        fences = Fences()
        fences.tick()
        fences.corners = None
        assert fences.tick() == ()
        fences.corners = 0
        (ask,) = asks(fences.tick(), CompareFence)
        fences.tick(end(ask, "done"))
        assert fences.tick() == (), "these corners were compared"

    @pytest.mark.fault("the fence cannot be read for a while", "the one that was read last counts as held for 45 s")
    def test_one_that_cannot_be_read_stays_held_for_a_while(self) -> None:
        fences = Fences()
        ask = self.compared(fences)
        assert fences.tick(end(ask, "failed", "timeout")) == ()
        assert fences.tick(after=RETRY_S - 0.1) == ()
        assert len(fences.tick(after=0.1)) == 1
        assert fences.kept.problem == ""
        fences.tick(after=STALE_S)
        assert fences.kept.problem == "The fence in the autopilot was not read for 45 s."

    def test_without_a_link_it_is_not_read(self) -> None:
        fences = Fences()
        fences.tick()
        fences.now += COMPARE_S
        assert fences.kept.tick(without_link(fences.facts()), HOVER, {}) == ()

    @pytest.mark.fault(
        "another station clears or replaces the fence in flight, by as many corners",
        "read as another one within 10 s, reported, uploaded again; no new task until it holds",
    )
    def test_one_that_was_replaced_is_reported_and_put_back(self) -> None:
        fences = Fences()
        ask = self.compared(fences)
        fences.held = False
        messages, upload = fences.tick(end(ask, "failed", ANOTHER))
        assert isinstance(messages, Log)
        assert messages.text == "The fence in the autopilot was changed. Putting it back."
        assert messages.details == f"{ANOTHER}. {UNKNOWN}"
        assert isinstance(upload, Ask)
        assert upload.request == UploadFence(FENCE)
        assert fences.kept.problem == "The fence of this flight is being set: wait a moment."
        assert fences.tick(end(upload, "pending")) == ()
        fences.held = True
        assert texts(fences.tick(end(upload, "done"))) == ["The fence of this flight is in the autopilot again."]
        assert fences.kept.problem == ""
        assert fences.tick() == ()

    def test_the_station_that_is_heard_is_named(self) -> None:
        fences = Fences()
        ask = self.compared(fences)
        fences.held = False
        facts = fences.facts(end(ask, "failed", ANOTHER))
        write = ForeignWrite(facts.now, 254, 190, FENCE_SUBJECT)
        messages = fences.kept.tick(replace(facts, link=replace(facts.link, foreign_writes=(write,))), HOVER, {})
        assert "Station 254 (component 190) changed it." in texts(messages)[0]

    def test_under_a_pilot_it_is_reported_and_put_back_afterwards(self) -> None:
        fences = Fences()
        ask = self.compared(fences)
        fences.held = False
        pilot = ManualState(0.0)
        (messages,) = fences.tick(end(ask, "failed", ANOTHER), state=pilot)
        assert isinstance(messages, Log)
        assert messages.text.endswith("It is put back when the drone is taken from the pilot.")
        assert fences.tick(state=pilot) == ()
        assert len(asks(fences.tick(), UploadFence)) == 1

    def test_after_a_lost_link_it_is_compared_before_it_is_uploaded(self) -> None:
        fences = Fences()
        fences.tick()
        fences.held = False  # forgotten
        (ask,) = asks(fences.tick(), CompareFence)
        messages, upload = fences.tick(end(ask, "failed", ANOTHER))
        assert isinstance(messages, Log)
        assert "was changed" in messages.text
        assert isinstance(upload, Ask)

    def test_a_comparison_that_ends_well_and_is_forgotten_is_made_again(self) -> None:
        fences = Fences()
        ask = self.compared(fences)
        fences.held = False
        (again,) = fences.tick(end(ask, "done"))
        assert isinstance(again, Ask)
        assert again.request == CompareFence(FENCE)

    @pytest.mark.fault(
        "the fence is cleared while the drone is outside ours",
        "uploaded once it is inside: the autopilot would act on the breach at once",
    )
    def test_outside_it_waits_and_is_not_given_up(self) -> None:
        fences = Fences()
        ask = self.compared(fences)
        fences.held, fences.north = False, 160.0
        fences.tick(end(ask, "failed", ANOTHER))
        for _ in range(30):
            assert fences.tick(after=10.0) == ()
        assert fences.kept.lost == ()
        assert fences.kept.problem.startswith("Outside the fence of this flight")
        fences.north = 0.0
        assert len(asks(fences.tick(), UploadFence)) == 1

    def test_one_that_is_cleared_again_and_again_is_lost(self) -> None:
        fences = Fences()
        acts: Acts = ()
        for _ in range(TRIES + 1):
            fences.held = True
            ask = self.compared(fences)
            fences.held = False
            acts = fences.tick(end(ask, "failed", ANOTHER))
            for upload in asks(acts, UploadFence):
                fences.held = True
                fences.tick(end(upload, "done"))
        assert fences.kept.lost == ("the fence",)
        assert texts(acts)[-1] == "The fence in the autopilot cannot be put back."
        assert fences.tick() == ()

    def test_one_that_was_never_held_is_tried_for_ever_and_never_lost(self) -> None:
        fences = Fences()
        fences.held = False
        (compare,) = fences.tick()
        assert isinstance(compare, Ask)
        acts = fences.tick(end(compare, "failed", "timeout"))
        for _ in range(10):
            (upload,) = asks(acts, UploadFence)
            fences.tick(end(upload, "failed", "no space"))
            acts = fences.tick(after=RETRY_S)
        assert fences.kept.lost == ()
        assert fences.kept.problem == "The fence of this flight was not taken by the autopilot. no space."


class TestSwitch:
    @pytest.mark.fault("a command or a switch turns the fence off", "switched on again after 1.5 s")
    def test_a_fence_that_a_command_switched_off_is_switched_on_again(self) -> None:
        fences = Fences()
        fences.tick()
        fences.on = False
        assert fences.tick() == ()
        assert fences.tick(after=SWITCH_CONFIRM_S - 0.1) == ()
        (ask,) = fences.tick(after=0.1)
        assert isinstance(ask, Ask)
        assert ask.request == EnableFence()
        fences.on = True
        assert fences.tick(end(ask, "done")) == ()
        assert fences.kept.lost == ()

    @pytest.mark.parametrize("hindrance", ["pilot", "outside", "FENCE_ENABLE", "not held", "not heard"])
    def test_it_is_not_switched_on(self, hindrance: str) -> None:
        fences = Fences()
        fences.tick()
        fences.on = None if hindrance == "not heard" else False
        fences.north = 160.0 if hindrance == "outside" else 0.0
        fences.enable = 0 if hindrance == "FENCE_ENABLE" else 1
        fences.held = hindrance != "not held"
        state = ManualState(0.0) if hindrance == "pilot" else HOVER
        for _ in range(10):
            assert asks(fences.tick(state=state, after=0.5), EnableFence) == []
        assert fences.kept.lost == ()

    def test_sys_status_is_given_time_to_show_that_it_is_on(self) -> None:
        """It comes twice a second: the autopilot's answer is there ten ticks before it."""
        fences = Fences()
        fences.tick()
        fences.on = False
        fences.tick()
        (ask,) = fences.tick(after=SWITCH_CONFIRM_S)
        assert isinstance(ask, Ask)
        assert asks(fences.tick(end(ask, "done"), after=0.05), EnableFence) == []
        for _ in range(20):
            assert asks(fences.tick(after=0.05), EnableFence) == []
        assert fences.kept.lost == ()
        assert len(asks(fences.tick(after=SWITCH_CONFIRM_S), EnableFence)) == 1, "it is off still"

    def test_one_that_is_switched_off_again_and_again_is_lost_once(self) -> None:
        fences = Fences()
        fences.tick()
        messages: list[str] = []
        fences.on = False
        for _ in range(60):
            messages += texts(fences.tick(after=0.5))
        assert fences.kept.lost == ("the fence's switch",)
        assert messages.count("The fence in the autopilot cannot be switched on again.") == 1

    def test_one_that_was_never_on_is_tried_and_not_lost(self) -> None:
        fences = Fences()
        fences.on = False
        tried = [ask for _ in range(60) for ask in asks(fences.tick(after=0.5), EnableFence)]
        assert len(tried) == TRIES
        assert fences.kept.lost == ()


def moves(kept: KeptHome, facts: Facts, state: State) -> None:
    """Move home, and let it be set back: a tick each."""
    kept.tick(home_at(facts, 60.0, 0.1), state)
    kept.tick(home_at(replace(facts, now=facts.now + 1.0), 0.0, 1.1), state)


@pytest.mark.fault(
    "another station moves home for the fourth time within a minute",
    "it is set back each time; the flight ends at home",
)
def test_who_moves_home_for_the_fourth_time_within_a_minute_wins() -> None:
    kept, state = KeptHome(), made(ToHover())
    for number in range(3):
        moves(kept, flying(10.0 * number), state)
        assert kept.lost(flying(10.0 * number)) == ()
    acts = kept.tick(home_at(flying(59.9), 60.0, 0.1), state)
    assert kept.lost(home_at(flying(59.9), 60.0, 0.1)) == ("its home",)
    assert [type(ask.request) for ask in asks(acts)] == [SetHome], "it is set back all the same"
    kept.tick(home_at(flying(90.0), 0.0, None), state)
    assert kept.lost(flying(90.0)) == ("its home",), "until the motors are off"
    kept.tick(on_ground(flying(91.0)), state)
    assert kept.lost(flying(92.0)) == ()
    moves(kept, flying(93.0), state)
    assert kept.lost(flying(93.0)) == ()


def test_moves_that_are_minutes_apart_or_under_a_pilot_are_not_counted() -> None:
    kept, state = KeptHome(), made(ToHover())
    for number in range(8):
        moves(kept, flying(20.0 * number), state)
        assert kept.lost(flying(20.0 * number)) == ()
    for number in range(8):
        moves(kept, flying(200.0 + number), made(ToManual()))
        assert kept.lost(flying(200.0 + number)) == ()


def test_one_move_of_home_is_one_however_often_the_link_is_lost_meanwhile() -> None:
    kept, state = KeptHome(), made(ToHover())
    for number in range(8):
        moved = home_at(flying(0.5 * number), 60.0, 0.5 * number)
        kept.tick(moved if number % 2 else without_link(moved), state)
        assert kept.lost(moved) == ()


def home_at(facts: Facts, away: float, moved_s: float | None) -> Facts:
    home = HomeFacts(facts.position.datum, 0.1, away, moved_s, is_inside=True)
    return replace(facts, position=replace(facts.position, autopilot_home=home))


@pytest.mark.parametrize(
    ("away", "moved_s", "lost"), [(60.0, LOST_S - 0.1, ()), (60.0, LOST_S, ("its home",)), (0.0, 20.0, ())]
)
def test_home_that_stays_moved_for_ten_seconds_is_lost(away: float, moved_s: float, lost: tuple[str, ...]) -> None:
    assert KeptHome().lost(home_at(flying(1.0), away, moved_s)) == lost
    assert KeptHome().lost(home_at(flying(1.0), away, None)) == ()


# -- all of it ---------------------------------------------------------------------------------------------------------


def keeper_that_read(facts: Facts, **changed: float | None) -> Keeper:
    """Return a keeper whose reader has read the autopilot's parameters at these facts."""
    keeper = Keeper(SETTINGS)
    read_all(keeper.reader, facts, {**VALUES, **changed})
    return keeper


def test_the_keeper_says_why_a_return_would_go_astray_and_for_how_long_it_has_not() -> None:
    keeper = keeper_that_read(flying(10.0), RTL_ALT=30_000.0)
    found = keeper.kept(flying(10.0))
    assert found.astray == "Return height: 300 m, must be at most 97 m."
    assert found.astray_ago == 0.0
    after = keeper.kept(on_ground(flying(10.5)))
    assert (after.astray, after.astray_ago, after.known) == ("", 0.5, ())
    right = keeper_that_read(flying(10.0)).kept(flying(10.0))
    assert (right.astray, right.astray_ago) == ("", math.inf)
    moved = keeper_that_read(flying(10.0)).kept(home_at(flying(10.0), 60.0, 0.5))
    assert (moved.astray, moved.astray_ago) == ("Home is 60 m from the arm place.", 0.0)


def test_a_fence_that_is_switched_off_is_known_to_come_back() -> None:
    facts = flying(10.0)
    off = replace(facts, diagnostics=replace(facts.diagnostics, fence_on=False))
    assert keeper_that_read(facts).kept(off).known == ("Fence in the autopilot",)
    assert keeper_that_read(facts).kept(facts).known == ()
