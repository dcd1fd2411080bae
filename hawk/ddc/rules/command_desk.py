"""The outcome of a command: refused with its reason, or accepted; answered now, or later when it must be computed.

`hawk.ddc.rules.judge` decides whether a command is accepted; the states decide what it means in flight.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from hawk.comm.protocol import commands
from hawk.comm.protocol.command_table import COMMAND_TABLE
from hawk.comm.protocol.heartbeat import ClientId, Point
from hawk.ddc import orders
from hawk.ddc.acts import (
    Acts,
    AskPlace,
    BeginSurvey,
    Desire,
    JudgeFence,
    Log,
    Record,
    Reply,
    ShowUserError,
    TakePlan,
    UseOutline,
)
from hawk.ddc.facts import Facts
from hawk.ddc.fence.outline import check_rings, ground_of, outline_of, size_words
from hawk.ddc.fence.plan import Standpoint, plan_of
from hawk.ddc.parameters.failsafes import return_altitude
from hawk.ddc.parameters.reader import ParameterReader
from hawk.ddc.readings.operator import SOME_OPERATOR
from hawk.ddc.readings.topic_interface import VERDICT_AGE_S
from hawk.ddc.rules.again import again_outline, lots_of
from hawk.ddc.rules.judge import fence_ahead, is_sent_unheard, place_of, place_refusal, refusal, route_refusal
from hawk.ddc.rules.kill import TOKEN_VALID_S, KillSwitch, KillTokens
from hawk.ddc.rules.needs import Refusal, Situation
from hawk.ddc.settings import DdcSettings
from hawk.model.known_lot import LotAhead
from hawk.model.operation import UserError
from hawk.model.plans import DesiredPose, HeightParameters, Inbound, Outline, Verdict
from hawk.model.poses import MapPoint
from hawk.model.sentences import say

WAITING_LIMIT = 8
"""Clients whose questions wait at a time."""
NOT_JUDGED = say("X, Y: whether the place is inside the lot could not be found within a second.")
_REASONS = {
    Inbound.OUTSIDE: say("X, Y: the place is outside the lot: choose one inside, or Compulsive Move."),
    Inbound.UNKNOWN: say("X, Y: nobody has seen that place yet: explore first, or Compulsive Move."),
}


def verdict_refusal(verdict: Verdict) -> str:
    """Return the reason why an Autonomous Move to the place of a verdict is refused; empty when it has a route."""
    if verdict.inbound is not Inbound.INSIDE:
        return _REASONS[verdict.inbound]
    if len(verdict.route.points) >= 2:
        return ""
    return say(
        "X, Y: {refused}: choose another place, or Compulsive Move.",
        refused=verdict.route.refused or say("no route there is known"),
    )


@dataclass(frozen=True, slots=True)
class _Question:
    client: ClientId
    request: commands.RouteRequest
    number: int = 0
    asked: float = 0.0


class RouteRequests:
    """Asks the planner about one place after another, in the order in which clients asked.

    A client's newer question replaces its older one, whose answer says so.
    """

    def __init__(self) -> None:
        self._waiting: dict[ClientId, _Question] = {}
        self._open: _Question | None = None
        self._number = 0

    def ask(self, client: ClientId, request: commands.RouteRequest) -> Acts:
        """Accept a question; the answer goes to the client within a second of its turn."""
        acts: Acts = ()
        older = self._waiting.pop(client, None)
        if older is not None:
            acts = _refuse(older, say("You asked for another route since."))
        question = _Question(client, request)
        if len(self._waiting) >= WAITING_LIMIT:
            return acts + _refuse(question, say("Too many ask for routes: ask again in a moment."))
        self._waiting[client] = question
        return acts

    def tick(self, facts: Facts) -> Acts:
        """Look for the answer, and ask the next question."""
        acts = () if self._open is None else self._look(self._open, facts)
        while self._open is None and self._waiting:
            client = next(iter(self._waiting))
            acts += self._put(self._waiting.pop(client), facts)
        return acts

    def _put(self, question: _Question, facts: Facts) -> Acts:
        place = place_of(question.request, facts)
        if place is None:
            return _refuse(question, say("The position is not known well enough: wait for it."))
        refused = place_refusal(facts, place)
        if refused is not None:
            return _refuse(question, refused.reason)
        self._number += 1
        self._open = _Question(question.client, question.request, self._number, facts.now)
        return (AskPlace(DesiredPose(self._number, place.north, place.east)),)

    def _look(self, question: _Question, facts: Facts) -> Acts:
        verdict = facts.sight.asked
        if verdict is None or verdict.number != question.number:
            if facts.now - question.asked <= VERDICT_AGE_S:
                return ()
            self._open = None
            return AskPlace(None), *_refuse(question, NOT_JUDGED)
        self._open = None
        refused = verdict_refusal(verdict)
        return AskPlace(None), *(_refuse(question, refused) if refused else _answer(question, verdict))


def _answer(question: _Question, verdict: Verdict) -> Acts:
    points = [_point(place) for place in verdict.route.points]
    length = round(verdict.route.length_m, 1)
    answer = commands.RouteAnswer(id=question.request.id, points=points, length=length, refused=None)
    return (Reply(question.client, answer),)


def _refuse(question: _Question, reason: str) -> Acts:
    answer = commands.RouteAnswer(id=question.request.id, points=[], length=None, refused=reason)
    return (Reply(question.client, answer),)


def _point(place: MapPoint) -> Point:
    return Point(north=round(place.north, 2), east=round(place.east, 2))


NO_USER_ERROR = ShowUserError(UserError.NONE)
UNHEARD = say("Sent without an answer: no word from the autopilot.")
"""Added to the answer to a command that went to an autopilot that is not heard."""


@dataclass(frozen=True, slots=True)
class Ruling:
    """Outcome of a command: the answer (None: it follows as a `Reply`), acts, and the order for the state.

    ``transition``: the state changes whatever the active one makes of the order.
    """

    answer: commands.Outgoing | None = None
    acts: Acts = ()
    order: orders.Order | None = None
    transition: orders.Transition | None = None


@dataclass(frozen=True, slots=True)
class _AskedMove:
    client: ClientId
    command: commands.AutonomousMove
    order: orders.MoveOrder
    since: float


class LotCheck:
    """Asks the planner whether a place lies inside the lot before an Autonomous Move is accepted.

    At most one Move is asked about; its answer goes to the client within a second.
    """

    def __init__(self) -> None:
        self._open: _AskedMove | None = None

    @property
    def is_open(self) -> bool:
        """True while the planner's answer is awaited."""
        return self._open is not None

    def open(self, client: ClientId, command: commands.AutonomousMove, order: orders.MoveOrder, facts: Facts) -> Acts:
        """Ask about the order's place; an older Move ends refused."""
        acts = self.supersede()
        number = facts.sight.desired_count + 1
        self._open = _AskedMove(client, command, replace(order, number=number), facts.now)
        return (*acts, Desire(DesiredPose(number, order.place.north, order.place.east)))

    def supersede(self) -> Acts:
        """Refuse the Move that is asked about: another command, or another state, came first."""
        return self._refuse(self._open, Refusal(say("Something else came first."))) if self._open is not None else ()

    def tick(self, situation: Situation) -> Ruling:
        """Look for the verdict."""
        asked = self._open
        if asked is None:
            return Ruling()
        verdict = situation.facts.verdict(asked.order.number)
        error = UserError.DESIRED_LOCATION_OUT_OF_BOUNDS
        if verdict is None:
            if situation.facts.now - asked.since <= VERDICT_AGE_S:
                return Ruling()
            return Ruling(acts=self._refuse(asked, Refusal(NOT_JUDGED, error)))
        reason = verdict_refusal(verdict)
        if reason:
            return Ruling(acts=self._refuse(asked, Refusal(reason, error)))
        refused = refusal(situation, asked.client, asked.command) or route_refusal(situation.facts, verdict.route)
        if refused is not None:
            return Ruling(acts=self._refuse(asked, refused))
        self._open = None
        answer = commands.Ack(id=asked.command.id, accepted=True)
        acts = (NO_USER_ERROR, *_reply(asked.client, asked.command, answer))
        return Ruling(acts=acts, order=replace(asked.order, route=verdict.route))

    def _refuse(self, asked: _AskedMove, refused: Refusal) -> Acts:
        self._open = None
        ruling = refuse(asked.command, refused)
        assert isinstance(ruling.answer, commands.Ack)  # noqa: S101 - a refusal is an Ack
        return (Desire(None), *ruling.acts, *_reply(asked.client, asked.command, ruling.answer))


def refuse(command: commands.Command, refused: Refusal) -> Ruling:
    """Return the refusing answer, and the User Error that the command caused."""
    answer = commands.Ack(id=command.id, accepted=False, reason=refused.reason)
    shown = refused.error is not UserError.NONE
    return Ruling(answer, (ShowUserError(refused.error, refused.reason),) if shown else ())


def answer_record(client: ClientId, command: commands.Command, answer: commands.Ack) -> Record:
    """Return the record of an answer."""
    entries = (("client", client), ("command", command.type), ("accepted", answer.accepted))
    return Record("answer to operator", (*entries, ("reason", answer.reason)))


def _reply(client: ClientId, command: commands.Command, answer: commands.Ack) -> Acts:
    return answer_record(client, command, answer), Reply(client, answer)


class CommandDesk:
    """Rules on commands, one after the other."""

    def __init__(self, tokens: KillTokens, kill: KillSwitch, reader: ParameterReader) -> None:
        self._tokens = tokens
        self._kill_switch = kill
        self._reader = reader
        self.lot_check = LotCheck()
        self.routes = RouteRequests()

    def rule(self, client: ClientId, command: commands.Command, situation: Situation) -> Ruling:
        """Return the outcome of a command."""
        match command:
            case commands.OperatorHeartbeat():
                return Ruling(commands.Ack(id=command.id, accepted=True))
            case commands.CheckFence():
                return Ruling(acts=(_judge_fence(client, command, situation),))
            case commands.RouteRequest():
                return Ruling(acts=self.routes.ask(client, command))
        if COMMAND_TABLE[command.type].answered_by_web_server:
            return refuse(command, Refusal(say("{type}: is answered by the web server.", type=command.type)))
        refused = refusal(situation, client, command)
        return self._accept(client, command, situation) if refused is None else refuse(command, refused)

    def _accept(self, client: ClientId, command: commands.Command, situation: Situation) -> Ruling:
        facts, accepted = situation.facts, commands.Ack(id=command.id, accepted=True)
        match command:
            case commands.KillRequest():
                token = self._tokens.issue(client, facts.now)
                return Ruling(commands.KillToken(id=command.id, token=token, valid_for=TOKEN_VALID_S))
            case commands.Kill():
                return self._kill(client, command, facts)
            case commands.ClearKill():
                forgotten = self._kill_switch.clear()
                cleared = Log("info", say("The cut of the motors was cleared."))
                return Ruling(accepted, (NO_USER_ERROR, *forgotten, cleared))
            case commands.NewSurvey():
                words = Log("info", say("A new survey begins."), say("The earlier one stays stored."))
                return Ruling(accepted, (*self._begin(), BeginSurvey(), words))
            case commands.SetFailsafes():
                self._reader.set_failsafes()
                return Ruling(accepted, (NO_USER_ERROR,))
            case commands.SetOutline():
                outline = outline_of(command)
                taken = Log("ok", _taken_words(outline, facts, situation.settings))
                return Ruling(accepted, (NO_USER_ERROR, UseOutline(outline), taken))
            case commands.SurveyAgain():
                lots = lots_of(command, facts, fence_ahead(facts, situation.settings))
                words = Log("ok", _round_words(lots))
                return Ruling(accepted, (NO_USER_ERROR, UseOutline(again_outline(lots, facts)), words))
            case commands.FlyPlan() if (offer := facts.lots.offer) is not None:
                flown = say(
                    "The changed plan of {name} is flown: {stalls} stalls.", name=offer.lot, stalls=offer.stalls
                )
                return Ruling(accepted, (NO_USER_ERROR, TakePlan(offer.id), Log("ok", flown)))
            case commands.ClearOutline():
                gone = Log("ok", say("The outline was removed; Explore finds the lot by looking."))
                return Ruling(accepted, (NO_USER_ERROR, UseOutline(None), gone))
            case commands.AutonomousMove():
                return Ruling(acts=self.lot_check.open(client, command, _move_order(command, facts), facts))
        if is_sent_unheard(facts, COMMAND_TABLE[command.type]):
            return self._send_unheard(client, command, facts)
        return Ruling(accepted, self._begin(), _order(client, command, situation))

    def _send_unheard(self, client: ClientId, command: commands.Command, facts: Facts) -> Ruling:
        """Return To Launch or Land for an autopilot that is not heard: `hawk.ddc.rules.silence` sends its mode."""
        words = say("{command} is sent without an answer: no word from the autopilot.", command=command.type)
        answer = commands.Ack(id=command.id, accepted=True, reason=UNHEARD)
        by = facts.operator.name(client)
        straight = say("the autopilot is not heard")
        following = (
            orders.ToLand(by=by) if isinstance(command, commands.Land) else orders.ToReturn(straight=straight, by=by)
        )
        return Ruling(answer, (*self._begin(), Log("warning", words)), transition=following)

    def _begin(self) -> Acts:
        """An accepted command clears the User Error of an earlier one, and replaces a Move that is still judged."""
        return (NO_USER_ERROR, *self.lot_check.supersede())

    def _kill(self, client: ClientId, command: commands.Kill, facts: Facts) -> Ruling:
        problem = self._tokens.redeem(client, command.token, facts.now)
        record = Record("kill token", (("problem", problem),))
        if problem:
            return Ruling(commands.Ack(id=command.id, accepted=False, reason=problem), (record,))
        cut, by = self._kill_switch.begin(facts, client), facts.operator.name(client) or SOME_OPERATOR
        acts = (record, *cut, *self._begin(), Log("error", say("Motors are being cut by {by}.", by=by)))
        return Ruling(commands.Ack(id=command.id, accepted=True, reason=UNHEARD if facts.is_unheard else ""), acts)


def _order(client: ClientId, command: commands.Command, situation: Situation) -> orders.Order:
    match command:
        case commands.Hold() | commands.Land() | commands.ReturnToLaunch():
            return orders.SafetyOrder(command, situation.facts.operator.name(client))
        case commands.Arm():
            return orders.ArmOrder(len(situation.checks), situation.facts.operator.name(client))
        case commands.CompulsiveMove():
            return _move_order(command, situation.facts)
        case commands.Configure():
            return orders.ConfigureOrder(HeightParameters(command.min, command.des, command.max))
        case commands.SetFence():
            return orders.FenceOrder(plan_of(command))
        case commands.ClearFence():
            return orders.FenceOrder(None)
    return command


def _move_order(command: commands.AutonomousMove | commands.CompulsiveMove, facts: Facts) -> orders.MoveOrder:
    place, here = place_of(command, facts), facts.place
    assert place is not None  # noqa: S101 - no move is accepted without a position
    assert here is not None  # noqa: S101
    wanted = command.height if isinstance(command, commands.CompulsiveMove) else None
    height = facts.limits.heights.bounded(wanted or here.height)
    return orders.MoveOrder(place, height, here.yaw, isinstance(command, commands.AutonomousMove), number=0)


def _judge_fence(client: ClientId, command: commands.CheckFence, situation: Situation) -> JudgeFence:
    facts = situation.facts
    place = facts.global_place
    standpoint = Standpoint(place, facts.position.datum or place, return_altitude(situation.values))
    return JudgeFence(client, command, facts.limits.heights, standpoint)


def _round_words(lots: Sequence[LotAhead]) -> str:
    """Return the message about lots that are surveyed again."""
    stalls = sum(lot.stalls for lot in lots)
    if len(lots) == 1:
        return say("{name} is surveyed again: {stalls} stalls.", name=lots[0].name, stalls=stalls)
    return say(
        "{count} lots are surveyed again in one flight: {stalls} stalls. {names}",
        count=len(lots),
        stalls=stalls,
        names=", ".join(lot.name for lot in lots),
    )


def _taken_words(outline: Outline, facts: Facts, settings: DdcSettings) -> str:
    """Return the message about an outline that was taken: its size inside the fence, and what the fence leaves out."""
    ahead = fence_ahead(facts, settings)
    if ahead is None:
        return say("The outline is taken: {size}.", size=size_words(check_rings(outline)))
    ground = ground_of(outline, *ahead)
    return say("The outline is taken: {size}.", size=size_words(ground.area, ground.outside))
