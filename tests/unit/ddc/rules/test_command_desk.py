"""Rulings on commands by facts alone: the answer, the acts, and the order for the state."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hawk.comm.protocol.commands import (
    Ack,
    Arm,
    AutonomousExplore,
    AutonomousMove,
    CheckFence,
    ClearFence,
    ClearKill,
    ClearOutline,
    Command,
    CompulsiveMove,
    Configure,
    Control,
    Hold,
    Kill,
    KillRequest,
    KillToken,
    Land,
    NewSurvey,
    OperatorHeartbeat,
    ReturnToLaunch,
    RouteRequest,
    SetFailsafes,
    SetFence,
    SetOutline,
    Takeoff,
)
from hawk.comm.protocol.heartbeat import FenceCorner
from hawk.ddc.acts import (
    Acts,
    Ask,
    BeginSurvey,
    CutMotors,
    Desire,
    JudgeFence,
    Log,
    Record,
    Reply,
    ShowUserError,
    UseOutline,
)
from hawk.ddc.facts import Facts
from hawk.ddc.fence.geometry import ring_from_map
from hawk.ddc.fence.outline import OutlineFacts
from hawk.ddc.fence.plan import FencePlan, Standpoint
from hawk.ddc.orders import (
    ArmOrder,
    ConfigureOrder,
    FenceOrder,
    MoveOrder,
    SafetyOrder,
    ToHover,
    ToIdle,
    ToLand,
    ToReturn,
    Transition,
)
from hawk.ddc.parameters.reader import ParameterReader
from hawk.ddc.rules.command_desk import NO_USER_ERROR, UNHEARD, CommandDesk, Ruling
from hawk.ddc.rules.kill import TOKEN_VALID_S, KillSwitch, KillTokens
from hawk.ddc.rules.needs import Interlocks, Situation
from hawk.ddc.states.factory import make_state
from hawk.model.lot_map import Counts
from hawk.model.operation import UserError
from hawk.model.plans import DesiredPose, HeightParameters, Inbound, Route, Verdict
from hawk.model.poses import MapPoint
from tests.unit.ddc.fakes import SAFE_PARAMETERS
from tests.unit.ddc.written_facts import DATUM, SETTINGS, flying, of_kind, on_ground, without_link

NOW = 50.0
ANA = "ana"
TOKEN = "k" * 20
CORNERS = [
    FenceCorner(latitude=latitude, longitude=longitude)
    for latitude, longitude in ring_from_map(DATUM, ((-80.0, -80.0), (80.0, -80.0), (80.0, 80.0), (-80.0, 80.0)))
]
WIDE = ((-200.0, -200.0), (200.0, -200.0), (200.0, 200.0), (-200.0, 200.0))
OUT_OF_BOUNDS = UserError.DESIRED_LOCATION_OUT_OF_BOUNDS


class Desk:
    """A desk, with the parts that it hands commands to."""

    def __init__(self) -> None:
        self.kill = KillSwitch()
        self.reader = ParameterReader(245)
        self.desk = CommandDesk(KillTokens(lambda: TOKEN), self.kill, self.reader)

    def rule(self, command: Command, facts: Facts, state: Transition, locks: Interlocks | None = None) -> Ruling:
        named = replace(facts, operator=replace(facts.operator, names=((ANA, "Ana"),)))
        return self.desk.rule(ANA, command, situation(named, state, locks))


def situation(facts: Facts, transition: Transition, locks: Interlocks | None = None) -> Situation:
    state = make_state(transition, flying(0.0), SETTINGS)[0]
    return Situation(facts, state, SETTINGS, dict(SAFE_PARAMETERS), locks or Interlocks())


def standing() -> Facts:
    facts = on_ground(flying(NOW))
    home = replace(facts.position.autopilot_home, place=DATUM, age=1.0)
    return replace(facts, position=replace(facts.position, autopilot_home=home))


def judged(facts: Facts, verdict: Verdict | None) -> Facts:
    return replace(facts, sight=replace(facts.sight, verdict=verdict))


def accepted(ruling: Ruling) -> bool:
    assert isinstance(ruling.answer, Ack)
    return ruling.answer.accepted


def answers(acts: Acts) -> list[Ack]:
    return [act.message for act in acts if isinstance(act, Reply) and isinstance(act.message, Ack)]


def test_a_heartbeat_is_taken_and_what_the_web_server_answers_is_refused() -> None:
    desk = Desk()
    assert desk.rule(OperatorHeartbeat(id=3), flying(NOW), ToHover()) == Ruling(Ack(id=3, accepted=True))
    ruling = desk.rule(Control(id=4, action="Request"), flying(NOW), ToHover())
    assert isinstance(ruling.answer, Ack)
    assert not ruling.answer.accepted
    assert ruling.answer.reason == "Control: is answered by the web server."


def test_a_refusal_has_its_reason_and_a_user_error_where_it_is_one() -> None:
    ruling = Desk().rule(Arm(id=9), flying(NOW), ToHover())
    assert ruling == Ruling(Ack(id=9, accepted=False, reason="Already flying."))
    ruling = Desk().rule(CompulsiveMove(id=9, x=500, y=0, frame="Map"), flying(NOW), ToHover())
    assert isinstance(ruling.answer, Ack)
    assert ruling.acts == (ShowUserError(OUT_OF_BOUNDS, ruling.answer.reason),)


@pytest.mark.parametrize("command", [Hold(), Land(confirmed=True), ReturnToLaunch(confirmed=True)])
def test_hold_land_and_return_carry_the_name_of_the_one_who_asked(command: Hold | Land | ReturnToLaunch) -> None:
    ruling = Desk().rule(command, flying(NOW), ToHover())
    assert accepted(ruling)
    assert (ruling.order, ruling.acts, ruling.transition) == (SafetyOrder(command, "Ana"), (NO_USER_ERROR,), None)


def test_orders_of_a_drone_that_stands() -> None:
    desk, facts = Desk(), standing()
    arm = desk.rule(Arm(), facts, ToIdle())
    checks = len(situation(facts, ToIdle()).checks)
    assert (accepted(arm), arm.order) == (True, ArmOrder(checks, "Ana"))
    heights = desk.rule(Configure(min=16, des=21, max=41), facts, ToIdle())
    assert heights.order == ConfigureOrder(HeightParameters(16, 21, 41))
    fence = desk.rule(SetFence(corners=CORNERS, ceiling=90), facts, ToIdle())
    assert isinstance(fence.order, FenceOrder)
    assert fence.order.plan is not None
    assert (fence.order.plan.source, fence.order.plan.ceiling) == ("drawn", 90)
    drawn = replace(facts, limits=replace(facts.limits, plan=FencePlan("drawn", (), 100.0)))
    assert desk.rule(ClearFence(), drawn, ToIdle()).order == FenceOrder(None)
    took_off = desk.rule(Takeoff(), facts, ToIdle())
    assert not accepted(took_off)


def test_what_needs_nothing_but_the_command_is_the_order() -> None:
    explore = AutonomousExplore()
    assert Desk().rule(explore, flying(NOW), ToHover()).order is explore


class TestMoves:
    def test_a_compulsive_one_is_an_order_at_once(self) -> None:
        ruling = Desk().rule(CompulsiveMove(x=10, y=-5, frame="Map", height=25), flying(NOW), ToHover())
        assert ruling.order == MoveOrder(MapPoint(10, -5), 25, 0.0, autonomous=False, number=0)

    def test_without_a_height_the_drone_keeps_its_own_within_the_limits(self) -> None:
        ruling = Desk().rule(CompulsiveMove(x=10, y=-5), flying(NOW), ToHover())
        assert isinstance(ruling.order, MoveOrder)
        assert ruling.order.height == 30.0
        facts = flying(NOW)
        low = replace(facts, limits=replace(facts.limits, heights=HeightParameters(35.0, 40.0, 60.0)))
        ruling = Desk().rule(CompulsiveMove(x=10, y=-5), low, ToHover())
        assert isinstance(ruling.order, MoveOrder)
        assert ruling.order.height == 35.0


class TestLotCheck:
    """An Autonomous Move waits for the planner's verdict."""

    command = AutonomousMove(id=5, x=10, y=20, frame="Map")
    route = Route((MapPoint(0, 0), MapPoint(10, 20)), (0.0, 0.0))

    def asked(self, count: int = 3) -> Desk:
        desk, facts = Desk(), flying(NOW)
        facts = replace(facts, sight=replace(facts.sight, desired_count=count))
        ruling = desk.rule(self.command, facts, ToHover())
        assert ruling == Ruling(acts=(Desire(DesiredPose(count + 1, 10, 20)),))
        assert desk.desk.lot_check.is_open
        return desk

    def tick(self, desk: Desk, verdict: Verdict | None, now: float = NOW + 0.2) -> Ruling:
        return desk.desk.lot_check.tick(situation(judged(flying(now), verdict), ToHover()))

    def refused(self, ruling: Ruling) -> str:
        (answer,) = answers(ruling.acts)
        assert (answer.id, answer.accepted) == (5, False)
        assert of_kind(ruling.acts, Desire) == [Desire(None)]
        (record,) = of_kind(ruling.acts, Record)
        assert isinstance(record, Record)
        payload = {"client": ANA, "command": "Autonomous Move", "accepted": False, "reason": answer.reason}
        assert dict(record.payload) == payload
        assert ruling.order is None
        return answer.reason

    def test_nothing_is_open_at_first(self) -> None:
        desk = Desk()
        assert not desk.desk.lot_check.is_open
        assert desk.desk.lot_check.tick(situation(flying(NOW), ToHover())) == Ruling()
        assert desk.desk.lot_check.supersede() == ()

    def test_a_place_inside_with_a_route_becomes_the_order(self) -> None:
        desk = self.asked()
        ruling = self.tick(desk, Verdict(4, Inbound.INSIDE, self.route))
        assert ruling.order == MoveOrder(MapPoint(10, 20), 30.0, 0.0, autonomous=True, number=4, route=self.route)
        assert answers(ruling.acts) == [Ack(id=5, accepted=True)]
        assert ruling.acts[0] == NO_USER_ERROR
        assert not desk.desk.lot_check.is_open

    def test_it_waits_a_second_for_the_verdict_on_its_number(self) -> None:
        desk = self.asked()
        other = Verdict(3, Inbound.INSIDE, self.route)
        assert self.tick(desk, other, NOW + 1.0) == Ruling()
        assert desk.desk.lot_check.is_open
        ruling = self.tick(desk, other, NOW + 1.01)
        reason = self.refused(ruling)
        assert ShowUserError(OUT_OF_BOUNDS, reason) in ruling.acts
        assert not desk.desk.lot_check.is_open

    def test_a_place_outside_the_lot_is_refused(self) -> None:
        ruling = self.tick(self.asked(), Verdict(4, Inbound.OUTSIDE))
        assert ShowUserError(OUT_OF_BOUNDS, self.refused(ruling)) in ruling.acts

    def test_a_route_that_leaves_the_fence_is_refused(self) -> None:
        beyond = Route((MapPoint(0, 0), MapPoint(400, 0), MapPoint(10, 20)), (0.0, 0.0, 0.0))
        ruling = self.tick(self.asked(), Verdict(4, Inbound.INSIDE, beyond))
        assert "leaves the fence" in self.refused(ruling)

    def test_what_is_impossible_by_now_is_refused(self) -> None:
        desk = self.asked()
        facts = judged(without_link(flying(NOW + 0.2)), Verdict(4, Inbound.INSIDE, self.route))
        ruling = desk.desk.lot_check.tick(situation(facts, ToHover()))
        assert self.refused(ruling) == "No link to the autopilot: wait until it is found."

    @pytest.mark.parametrize("later", [Hold(id=6), CompulsiveMove(id=6, x=1, y=1), AutonomousMove(id=6, x=1, y=1)])
    def test_a_later_order_replaces_it(self, later: Command) -> None:
        desk = self.asked()
        ruling = desk.rule(later, flying(NOW), ToHover())
        assert [answer.reason for answer in answers(ruling.acts)] == ["Something else came first."]
        assert desk.desk.lot_check.is_open is isinstance(later, AutonomousMove)


class TestKill:
    def test_it_needs_the_token_of_a_request(self) -> None:
        desk, facts = Desk(), flying(NOW)
        given = desk.rule(KillRequest(id=7), facts, ToHover())
        assert given == Ruling(KillToken(id=7, token=TOKEN, valid_for=TOKEN_VALID_S))
        wrong = desk.rule(Kill(id=8, token="a" * 20), facts, ToHover())
        assert not accepted(wrong)
        assert [type(act) for act in wrong.acts] == [Record]
        assert not desk.kill.is_sending
        assert isinstance(wrong.answer, Ack)
        assert wrong.acts[0] == Record("kill token", (("problem", wrong.answer.reason),))

    @pytest.mark.parametrize("heard", [True, False])
    def test_it_cuts_the_motors_at_once_also_unheard(self, heard: bool) -> None:
        desk = Desk()
        facts = flying(NOW) if heard else without_link(flying(NOW))
        desk.rule(KillRequest(id=7), facts, ToHover())
        ruling = desk.rule(Kill(id=8, token=TOKEN), facts, ToHover())
        assert ruling.answer == Ack(id=8, accepted=True, reason="" if heard else UNHEARD)
        assert Ask(CutMotors(), NOW) in ruling.acts
        assert NO_USER_ERROR in ruling.acts
        (reported,) = of_kind(ruling.acts, Log)
        assert isinstance(reported, Log)
        assert (reported.level, reported.text) == ("error", "Motors are being cut by Ana.")
        assert desk.kill.is_sending

    def test_one_whose_name_is_not_known_is_an_operator(self) -> None:
        desk, facts = Desk(), flying(NOW)
        desk.desk.rule(ANA, KillRequest(), situation(facts, ToHover()))
        ruling = desk.desk.rule(ANA, Kill(token=TOKEN), situation(facts, ToHover()))
        (reported,) = of_kind(ruling.acts, Log)
        assert isinstance(reported, Log)
        assert reported.text == "Motors are being cut by the operator."

    def test_the_cut_is_cleared(self) -> None:
        desk = Desk()
        desk.kill.begin(standing(), "ana")
        ruling = desk.rule(ClearKill(), standing(), ToIdle(), Interlocks(is_killed=True))
        assert accepted(ruling)
        assert not desk.kill.is_killed
        assert ruling.acts[0] == NO_USER_ERROR


class TestUnheard:
    def test_return_and_land_are_sent_without_an_answer(self) -> None:
        facts = without_link(flying(NOW))
        home = Desk().rule(ReturnToLaunch(confirmed=True), facts, ToHover())
        assert home.transition == ToReturn(straight="the autopilot is not heard", by="Ana")
        assert isinstance(home.answer, Ack)
        assert (home.answer.accepted, home.answer.reason) == (True, UNHEARD)
        (reported,) = of_kind(home.acts, Log)
        assert isinstance(reported, Log)
        assert reported.level == "warning"
        assert reported.text == "Return To Launch is sent without an answer: no word from the autopilot."
        assert home.order is None
        assert Desk().rule(Land(confirmed=True), facts, ToHover()).transition == ToLand(by="Ana")
        assert not accepted(Desk().rule(Hold(), facts, ToHover()))


def test_a_new_survey_ends_what_waits_and_is_reported() -> None:
    facts = standing()
    mapped = replace(facts, sight=replace(facts.sight, counts=Counts(1, 0, 0), lot_area=10.0))
    ruling = Desk().rule(NewSurvey(), mapped, ToIdle())
    assert accepted(ruling)
    assert ruling.acts[:2] == (NO_USER_ERROR, BeginSurvey())


def test_failsafes_are_set_by_the_reader() -> None:
    desk = Desk()
    ruling = desk.rule(SetFailsafes(), standing(), ToIdle())
    assert (accepted(ruling), ruling.acts) == (True, (NO_USER_ERROR,))
    assert desk.reader.is_setting


def test_an_outline_is_used_and_removed() -> None:
    desk, facts = Desk(), flying(NOW)
    ruling = desk.rule(SetOutline(polygons=[CORNERS]), facts, ToHover())
    assert accepted(ruling)
    (used,) = of_kind(ruling.acts, UseOutline)
    assert isinstance(used, UseOutline)
    assert used.outline is not None
    (said,) = of_kind(ruling.acts, Log)
    assert said == Log("ok", "The outline is taken: 2.6 ha.")
    unfenced = replace(facts, limits=replace(facts.limits, fence=None))
    wider = [FenceCorner(latitude=lat, longitude=lon) for lat, lon in ring_from_map(DATUM, WIDE)]
    (within,) = of_kind(desk.rule(SetOutline(polygons=[wider]), facts, ToHover()).acts, Log)
    (whole,) = of_kind(desk.rule(SetOutline(polygons=[wider]), unfenced, ToHover()).acts, Log)
    assert isinstance(within, Log)
    assert within.text.endswith("outside the fence are left out.")
    assert whole == Log("ok", "The outline is taken: 16.0 ha.")
    outlined = replace(facts, limits=replace(facts.limits, outline=OutlineFacts(100.0, 0.0)))
    gone = desk.rule(ClearOutline(), outlined, ToHover())
    assert of_kind(gone.acts, UseOutline) == [UseOutline(None)]


def test_questions_are_answered_later() -> None:
    desk, facts = Desk(), standing()
    check = CheckFence(corners=CORNERS, ceiling=90)
    asked = desk.rule(check, facts, ToIdle())
    assert asked == Ruling(acts=(JudgeFence(ANA, check, facts.limits.heights, Standpoint(DATUM, DATUM, 15.0)),))
    young = replace(facts, position=replace(facts.position, datum=None))
    (act,) = desk.rule(check, young, ToIdle()).acts
    assert isinstance(act, JudgeFence)
    assert act.standpoint.datum == DATUM
    assert desk.rule(RouteRequest(x=1, y=2), facts, ToIdle()) == Ruling()
