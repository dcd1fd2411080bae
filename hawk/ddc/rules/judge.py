"""Decides on commands: who sends it, the state, what it needs, and what it says. Nothing is changed here.

The first three stand in the command's row (`hawk.comm.protocol.command_table`).
"""

from __future__ import annotations

from itertools import pairwise
from typing import Final

from hawk.comm.protocol import commands
from hawk.comm.protocol.authority import Sender, authority_refusal
from hawk.comm.protocol.command_table import COMMAND_TABLE, CommandRow, Confirm, sender_of
from hawk.comm.protocol.heartbeat import ClientId, CommandOption
from hawk.ddc.facts import Facts
from hawk.ddc.fence.geometry import FenceError, contains, path_is_inside, path_words, place_words
from hawk.ddc.fence.outline import OutlineError, check_rings, ground_of, outline_of
from hawk.ddc.fence.plan import fence_refusal
from hawk.ddc.parameters.heights import heights_problem
from hawk.ddc.rules.again import again_refusal
from hawk.ddc.rules.needs import NO_SUCH_PLAN, POSITION_UNKNOWN, Refusal, Situation, unmet
from hawk.ddc.settings import DdcSettings
from hawk.model.operation import StateName, UserError
from hawk.model.plans import Fence, HeightParameters, Route
from hawk.model.poses import GlobalPose, MapPoint
from hawk.model.sentences import say, words_of

REPLACES_KILL: Final = (commands.Hold, commands.Land, commands.ReturnToLaunch)
"""Commands that may replace a Kill while the motors may be on yet."""
_OUT_OF_BOUNDS = UserError.DESIRED_LOCATION_OUT_OF_BOUNDS


def options(situation: Situation) -> tuple[CommandOption, ...]:
    """Return for every command whether the one in control could give it now, and the reason if not."""
    found = []
    for kind, row in COMMAND_TABLE.items():
        if row.states:
            refused = _impossible(situation, row)
            reason = "" if refused is None else refused.reason
            found.append(CommandOption(command=kind, possible=refused is None, reason=reason))
    return tuple(found)


def refusal(situation: Situation, client: ClientId, command: commands.Command) -> Refusal | None:
    """Return the reason why a command of this client is refused; None when it is accepted."""
    operator, sender, locks = situation.facts.operator, sender_of(command.type), situation.interlocks
    if locks.kill_state == "sending" and isinstance(command, REPLACES_KILL):
        # A Kill is not everybody's to undo, also once who gave it is lost.
        sender = Sender.CONTROL_OR_FREE if client == locks.killer else Sender.CONTROL
    unauthorised = authority_refusal(
        sender,
        has_control=client in operator.clients,
        control=operator.tenure,
        homing=situation.state.is_homing,
    )
    if unauthorised:
        return Refusal(unauthorised)
    row = COMMAND_TABLE[command.type]
    return _impossible(situation, row) or _unconfirmed(situation, row, command) or _content(situation, command)


def is_sent_unheard(facts: Facts, row: CommandRow) -> bool:
    """Return True for a command that goes to an autopilot that is not heard."""
    return facts.is_unheard and row.sent_unheard


# -- steps of the decision --------------------------------------------------------------------------------------------


def _impossible(situation: Situation, row: CommandRow) -> Refusal | None:
    if situation.interlocks.kill_state == "sending":
        is_off = not situation.facts.ground.armed_said and isinstance(row.example, REPLACES_KILL)
        if is_off or not row.taken_while_cutting:
            return Refusal(say("The motors are being cut."))
    if is_sent_unheard(situation.facts, row):
        return None
    reason = row.states[situation.state.identity]
    if reason:
        return Refusal(reason)
    return next((refused for need in row.needs if (refused := unmet(need, situation)) is not None), None)


def _unconfirmed(situation: Situation, row: CommandRow, command: commands.Command) -> Refusal | None:
    if row.confirm is not Confirm.OVERRULING or situation.state.identity is not StateName.MANUAL:
        return None
    is_confirmed = isinstance(command, commands.Confirmable) and command.confirmed
    return None if is_confirmed else Refusal(say("Confirmed: someone else flies; send it confirmed."))


def _content(situation: Situation, command: commands.Command) -> Refusal | None:
    facts, settings = situation.facts, situation.settings
    reason = ""
    match command:
        case commands.Configure():
            wanted = HeightParameters(command.min, command.des, command.max)
            reason = heights_problem(wanted, facts.ceiling(situation.state.on_ground), settings.floor)
        case commands.SetFence():
            reason = fence_refusal(command, settings, facts.limits.heights)
        case commands.SetOutline():
            reason = _outline_refusal(command, facts, settings)
        case commands.SurveyAgain():
            reason = again_refusal(command, facts, fence_ahead(facts, settings))
        case commands.FlyPlan():
            is_newest = facts.lots.offer is not None and facts.lots.offer.id == command.plan
            reason = "" if is_newest else NO_SUCH_PLAN
        case commands.AutonomousMove():
            return _placed(facts, command)
        case commands.CompulsiveMove():
            return _travel_height(command, facts.limits.heights) or _placed(facts, command)
    return Refusal(reason) if reason else None


def _outline_refusal(command: commands.SetOutline, facts: Facts, settings: DdcSettings) -> str:
    """While no fence is known an outline is judged by the fence when Explore is asked for."""
    outline, ahead = outline_of(command), fence_ahead(facts, settings)
    try:
        check_rings(outline)
    except OutlineError as error:
        return words_of(error)
    if ahead is not None and ground_of(outline, *ahead).area <= 0.0:
        return say("Polygons: nothing of the outline lies inside the fence: draw it inside, or set another fence.")
    return ""


def _travel_height(command: commands.CompulsiveMove, heights: HeightParameters) -> Refusal | None:
    low, high = heights.minimum, heights.maximum
    if command.height is None or low <= command.height <= high:
        return None
    return Refusal(say("Height: must lie between Min {low:g} m and Max {high:g} m.", low=low, high=high))


def _placed(facts: Facts, command: commands.AutonomousMove | commands.CompulsiveMove) -> Refusal | None:
    place = place_of(command, facts)
    reachable = place_refusal if isinstance(command, commands.AutonomousMove) else move_refusal
    return POSITION_UNKNOWN if place is None else reachable(facts, place)


# -- places, routes and the fence -------------------------------------------------------------------------------------


def place_of(
    command: commands.AutonomousMove | commands.CompulsiveMove | commands.RouteRequest, facts: Facts
) -> MapPoint | None:
    """Return the place (map frame) of a Move or Route Request; None while the position is unknown."""
    if command.frame == "Map":
        return MapPoint(command.x, command.y)
    here = facts.place
    return None if here is None else MapPoint(here.north + command.x, here.east + command.y)


def place_refusal(facts: Facts, place: MapPoint) -> Refusal | None:
    """Return the reason why the drone may not be at this place of the map."""
    fence = facts.limits.fence
    if facts.pose is None or fence is None:
        return POSITION_UNKNOWN
    if not contains(fence, place):
        where = place_words(fence, place)
        return Refusal(say("X, Y: the place is {where}: choose one inside.", where=where), _OUT_OF_BOUNDS)
    return None


def move_refusal(facts: Facts, place: MapPoint) -> Refusal | None:
    """Return the reason why the drone may not go straight to this place of the map."""
    refused, fence = place_refusal(facts, place), facts.limits.fence
    if refused is None and fence is not None and not _is_path_inside(facts, place):
        what = path_words(fence)
        words = say("X, Y: the straight path there {what}: go around it in two moves.", what=what)
        return Refusal(words, _OUT_OF_BOUNDS)
    return refused


def route_refusal(facts: Facts, route: Route) -> Refusal | None:
    """Return the reason why the drone may not fly this route: a leg, or the path to it, leaves the fence."""
    fence = facts.limits.fence
    if fence is None:
        return POSITION_UNKNOWN
    legs_inside = all(path_is_inside(fence, a, b) for a, b in pairwise(route.points))
    if len(route.points) < 2 or not legs_inside or not _is_path_inside(facts, route.points[1]):
        return Refusal(
            say("X, Y: the path there {what}: choose another place.", what=path_words(fence)), _OUT_OF_BOUNDS
        )
    return None


def _is_path_inside(facts: Facts, place: MapPoint) -> bool:
    here, fence = facts.place, facts.limits.fence
    return here is not None and fence is not None and path_is_inside(fence, here.point, place)


def fence_ahead(facts: Facts, settings: DdcSettings) -> tuple[GlobalPose, Fence] | None:
    """Return datum and fence of the flight: those in force while armed, else those that Arm here would put in force.

    None while they cannot be known.
    """
    place, datum = facts.global_place, facts.position.datum
    if facts.vehicle.armed:
        fence = facts.limits.fence
        return None if datum is None or fence is None else (datum, fence)
    if place is None or facts.limits.plan_problem:
        return None
    datum = datum or place
    try:
        return datum, facts.limits.plan.around(datum, place, settings.fence)
    except FenceError:
        return None
