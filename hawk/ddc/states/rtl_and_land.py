"""Return To Launch and Land: the autopilot's own RTL and LAND."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

from hawk.comm.protocol.commands import Disarm
from hawk.ddc.acts import STAY, Acts, Log, SetArmed, Step
from hawk.ddc.facts import Facts
from hawk.ddc.fence.path import length
from hawk.ddc.orders import Cause, CauseKind, Order, Rank, ToHover, ToLand
from hawk.ddc.readings.home import HOLDS_S, HOME_WAIT_S
from hawk.ddc.settings import DdcSettings
from hawk.ddc.states.base import AirborneState, ModeKeeper, PendingRequest, astray, astray_words, cause_here, leaves
from hawk.ddc.states.path_home import PathHome, Straight, begin, is_beyond_sight
from hawk.ddc.words import metres, sentence
from hawk.model.operation import StateName
from hawk.model.poses import MapPoint
from hawk.model.sentences import joined, say
from hawk.model.vehicle import CopterMode

SEEN_AFTER_S = 1.0
"""A doubt is as old as its picture; an operator sees it up to this much later, seconds."""


@dataclass(frozen=True, slots=True)
class Doing:
    """Sentences on what one mode does, each in whole for translators."""

    plain: str
    unheard: str
    """Sent to an autopilot that is not heard."""
    unheard_by_itself: str
    begun: str
    """Begun by the autopilot."""
    refused: str
    trying: Callable[[str], str]
    """Refused, with the reason."""
    asked: Callable[[str], str]
    """Asked for, with the name."""


RETURNING = Doing(
    plain=say("Returning home."),
    unheard=say("Returning home: sent without an answer, no word from the autopilot."),
    unheard_by_itself=say("Returning home: the autopilot did it by itself, no word from the autopilot."),
    begun=say("Returning home: begun by the autopilot."),
    refused=say("Returning home was refused. Trying again."),
    trying=lambda reason: say("Returning home was refused, trying again: {reason}", reason=reason),
    asked=lambda by: say("Returning home, asked by {by}.", by=by),
)
LANDING = Doing(
    plain=say("Landing."),
    unheard=say("Landing: sent without an answer, no word from the autopilot."),
    unheard_by_itself=say("Landing: the autopilot did it by itself, no word from the autopilot."),
    begun=say("Landing: begun by the autopilot."),
    refused=say("Landing was refused. Trying again."),
    trying=lambda reason: say("Landing was refused, trying again: {reason}", reason=reason),
    asked=lambda by: say("Landing, asked by {by}.", by=by),
)


class HomingState(AirborneState):
    """A state that one autopilot mode flies. ``by_autopilot``: the autopilot began it itself and nothing is sent."""

    is_homing = True
    mode: ClassVar[CopterMode]
    own_rank: ClassVar[Rank]
    doing: ClassVar[Doing]

    def __init__(self, now: float, cause: Cause | None, by_autopilot: bool) -> None:
        super().__init__(now)
        self.cause = cause
        self.by_autopilot = by_autopilot
        self._keeper = ModeKeeper(self.mode)
        self._reported = 0

    @property
    def is_left_alone(self) -> bool:
        """The autopilot flies by itself."""
        return True

    @property
    def rank(self) -> Rank:
        """The autopilot's own, or ours."""
        return Rank.AUTOPILOT if self.by_autopilot else self.own_rank

    @property
    def autopilot_mode(self) -> CopterMode | None:
        """The mode that was asked for; None when the autopilot began it itself."""
        return None if self.by_autopilot else self.mode

    def detail(self, facts: Facts) -> str:
        """Return the present activity and its cause."""
        if facts.is_unheard:
            return self.doing.unheard_by_itself if self.by_autopilot else self.doing.unheard
        if self._keeper.reason:
            return self.doing.trying(self._keeper.reason)
        if self.by_autopilot:
            begun = self.doing.begun if not self._begun_by else joined(self.doing.plain, self._begun_by)
            return joined(begun, self._words())
        if self.cause:
            return joined(self.doing.plain, self.cause.text)
        return self.doing.asked(self.asked_by) if self.asked_by else self.doing.plain

    def hold_refusal(self, facts: Facts) -> str:
        """Return the reason why Hold is refused now; empty when it is not."""
        if self.by_autopilot:
            if self._begun_by:
                return say("Not while this lasts: {cause}", cause=joined(self._begun_by, self._words()))
            return joined(say("The autopilot does this by itself."), self._words())
        if self.cause is not None and self.cause.lasts(facts):
            return say("Not while this lasts: {cause}", cause=self.cause.text)
        return ""

    def restart(self) -> None:
        """Ask for the mode again: the autopilot was not heard for a while and flies another one."""
        self._keeper, self._reported = ModeKeeper(self.mode), 0

    def process(self, facts: Facts) -> Acts:
        """Ask for the mode until it is seen."""
        return () if self.by_autopilot else self._ask(facts)

    def _ask(self, facts: Facts) -> Acts:
        acts = self._keeper.reach(facts)
        if self._keeper.refusals != self._reported:
            self._reported = self._keeper.refusals
            acts += (Log("error", self.doing.refused, self._keeper.reason),)
        return acts

    @property
    def _begun_by(self) -> str:
        """One sentence on who began it, where the autopilot does not say so itself."""
        return "" if self.cause is None else self.cause.text

    def _words(self) -> str:
        return "" if self.cause is None else self.cause.details


class ReturnToLaunchState(HomingState):
    """Flies home and lands, by the autopilot: inside a bent fence by targets until home is in straight sight.

    Whether a path inside is flown is decided once, at the first tick (`hawk.ddc.states.path_home`).
    Where RTL would not end at home (home was moved, rally points, `RTL_*`), that is put right first
    (`hawk.ddc.keeper`). RTL that began before that flies elsewhere for ever, so that it is begun again. What stays
    wrong: the drone is led home by targets and lands there. Where it cannot be led, it lands where it is, or holds when
    the operator asked. So does one whose place or height is doubted, unless the operator asked in spite of the doubt.
    """

    identity = StateName.RETURN_TO_LAUNCH
    mode = CopterMode.RTL
    own_rank = Rank.RETURN_TO_LAUNCH
    doing = RETURNING

    def __init__(
        self,
        now: float,
        settings: DdcSettings,
        cause: Cause | None,
        by_autopilot: bool,
        straight: str,
    ) -> None:
        """``straight``: why no path inside the fence is flown (`ToReturn`); empty: it may be."""
        super().__init__(now, cause, by_autopilot)
        self._settings = settings
        self._straight = straight
        self._is_decided = by_autopilot
        self._inside: PathHome | None = None
        self._is_flying = False
        self._is_misled = False
        self._stopping: ModeKeeper | None = None
        self._begins_again = False
        self._may_be_led = not straight
        self._is_above_home = False

    @property
    def may_send_targets(self) -> bool:
        """True until RTL takes over."""
        return self._inside is not None

    @property
    def is_left_alone(self) -> bool:
        """Only the autopilot's own flight goes on without the program."""
        return self._inside is None

    @property
    def autopilot_mode(self) -> CopterMode | None:
        """RTL; None while targets lead the drone."""
        return None if self._inside is not None else super().autopilot_mode

    def route(self, facts: Facts) -> tuple[MapPoint, ...]:
        """Return the rest of the path inside the fence; empty while the autopilot flies."""
        return () if self._inside is None else self._inside.route(facts)

    def detail(self, facts: Facts) -> str:
        """Return the present activity and its cause."""
        if self._inside is not None:
            return joined(self._inside.detail(facts), "" if self.cause is None else self.cause.text)
        if self._stopping is not None or self._waits(facts):
            moved = facts.position.autopilot_home.is_moved or not facts.kept.astray
            home = say("Returning home: home was moved, it is set back first.")
            return home if moved else say("Returning home: the autopilot's return is put right first.")
        if not self._straight or not is_beyond_sight(facts):
            return super().detail(facts)
        return joined(super().detail(facts), say("Straight: {reason}", reason=sentence(self._straight)))

    def restart(self) -> None:
        """Ask for the mode again: the autopilot was not heard for a while and flies another one."""
        if self._inside is not None:
            self._inside.restart()
        super().restart()
        self._is_flying = self._is_misled = False
        self._stopping = None

    def process(self, facts: Facts) -> Acts:
        """Lead the drone along the path inside the fence, where one is flown; then have the autopilot return."""
        acts = self._lead(facts)
        return acts if self._inside is not None else acts + self._return(facts)

    def _lead(self, facts: Facts) -> Acts:
        """Return the acts of the path, and the message when it ends. A fault in it ends it: RTL follows."""
        acts: Acts = ()
        if not self._is_decided:
            self._is_decided = True
            acts += self._begin(facts)
        inside, self._inside = self._inside, None
        if inside is None:
            return acts
        acts += inside.process(facts)
        if inside.end is None:
            self._inside = inside
            return acts
        self._straight = inside.end.reason
        self._is_above_home = inside.end.is_above_home
        return acts + inside.end.words

    def _begin(self, facts: Facts) -> Acts:
        beyond = is_beyond_sight(facts)
        begun = Straight(self._straight if beyond else "") if self._straight else begin(facts, self._settings)
        if isinstance(begun, Straight):
            self._straight = begun.reason
            return begun.words
        self._inside = begun
        distance = metres(length(begun.route(facts)))
        words = say("The straight path home leaves the fence: returning inside it, {distance}.", distance=distance)
        return (Log("info", words),)

    def _return(self, facts: Facts) -> Acts:
        """Ask for RTL once it would end at home; begin it again when it began before that."""
        if self._is_above_home:
            return ()
        if self._stopping is not None:
            return self._begin_again(facts, self._stopping)
        self._look(facts)
        if self._is_misled and not facts.is_astray:
            self._stopping = ModeKeeper(CopterMode.BRAKE)
            log = Log("warning", say("The autopilot's return is right again: it begins again."))
            return (log, *self._begin_again(facts, self._stopping))
        if self._waits(facts):
            return ()
        if self._must_be_led(facts):
            return self._begin_leading(facts)
        if self._leads_out(facts):
            return ()
        if self._begins_again:
            return self._ask(facts)
        return super().process(facts)

    def _must_be_led(self, facts: Facts) -> bool:
        """Return True when RTL flies, or would fly, elsewhere, and the program may lead the drone instead; once."""
        would = self._is_misled or not self._is_flying
        return would and facts.is_astray and self._is_given_up(facts) and self._may_be_led

    def _begin_leading(self, facts: Facts) -> Acts:
        """Lead the drone home by targets; where that cannot be, `_decide` ends the return."""
        self._may_be_led = False
        begun = begin(facts, self._settings, lands=True)
        if isinstance(begun, Straight):
            unled = say("It cannot be led home: {reason}", reason=sentence(begun.reason))
            return (Log("warning", unled, astray_words(facts)),)
        self._inside = begun
        self._keeper, self._reported = ModeKeeper(self.mode), 0
        self._is_flying = self._is_misled = False
        words = Log(
            "warning", say("The autopilot's return would not end at home: leading it there."), astray_words(facts)
        )
        return (words, *self._lead(facts))

    def _begin_again(self, facts: Facts, stopping: ModeKeeper) -> Acts:
        acts = stopping.reach(facts)
        if stopping.is_reached:
            self._stopping = None
            self._begins_again = True
            self._is_flying = self._is_misled = False
            self._keeper, self._reported = ModeKeeper(self.mode), 0
        return acts

    def _look(self, facts: Facts) -> None:
        """Note whether RTL began with a home that was moved; the autopilot's own may have begun a moment earlier."""
        home = facts.position.autopilot_home
        flies = facts.vehicle.custom_mode in (CopterMode.RTL, CopterMode.SMART_RTL)
        if flies and not self._is_flying:
            lately = home.moved_s is not None or facts.kept.astray_ago <= HOLDS_S
            unsure = self.by_autopilot and not self._begins_again and lately
            self._is_misled = facts.is_astray or unsure
        self._is_flying = flies

    def _waits(self, facts: Facts) -> bool:
        """Return True before RTL while it would end elsewhere, as long as that may be put right in time."""
        return not self._is_flying and facts.is_astray and not self._is_given_up(facts)

    def _leads_out(self, facts: Facts) -> bool:
        """Return True when RTL flies, or would fly, to a place that is not home."""
        would = self._is_misled or not self._is_flying
        return would and leaves(facts) and self._is_given_up(facts)

    def _is_given_up(self, facts: Facts) -> bool:
        home = facts.position.autopilot_home
        since = self.age(facts) if home.moved_s is None else min(home.moved_s, self.age(facts))
        return since >= HOME_WAIT_S

    def _decide(self, facts: Facts) -> Step:
        if self._is_above_home:
            return Step(ToLand(Cause(joined(say("Above home."), astray_words(facts)), CauseKind.NEVER)))
        if self._is_in_doubt(facts):
            return self._end_in_doubt(facts)
        if self._inside is not None or self._may_be_led or not self._leads_out(facts):
            return STAY
        if self.cause is None and not self.by_autopilot:
            return Step(ToHover(joined(astray_words(facts), say("Land, or move the drone.")), level="error"))
        return Step(ToLand(astray(facts, self.cause or Cause("", CauseKind.NEVER))))

    def _is_in_doubt(self, facts: Facts) -> bool:
        """Return True when the place, or the height, is doubted, and the operator did not know it."""
        misled_s = facts.witness.misled_s
        is_ours = not self.by_autopilot or self._inside is not None or self._begins_again
        if misled_s is None or not is_ours:
            return False
        return self.cause is not None or misled_s < self.age(facts) + SEEN_AFTER_S

    def _end_in_doubt(self, facts: Facts) -> Step:
        """Land a drone that must come down, and one that is below Min; else hold it for the operator."""
        height = facts.height
        is_low = height is None or height - facts.witness.height.off < facts.limits.heights.minimum
        if self.cause is None and not is_low:
            return Step(ToHover(joined(facts.witness.doubt, say("Land, or fly by hand.")), level="warning"))
        return Step(ToLand(cause_here(facts, self.cause or Cause("", CauseKind.NEVER))))


class LandState(HomingState):
    """Straight down, by the autopilot; Disarm is followed once it is on the ground."""

    identity = StateName.LAND
    mode = CopterMode.LAND
    own_rank = Rank.LAND
    doing = LANDING

    def __init__(self, now: float, cause: Cause | None, by_autopilot: bool) -> None:
        super().__init__(now, cause, by_autopilot)
        self._disarming = PendingRequest()

    def process(self, facts: Facts) -> Acts:
        """Ask for LAND; report a disarm that was refused."""
        acts = super().process(facts)
        if failed := self._disarming.failure(facts):
            self._disarming.clear()
            acts += (Log("error", say("Disarm was refused."), failed.reason),)
        return acts

    def _follow(self, facts: Facts, order: Order) -> Step:
        if isinstance(order, Disarm) and facts.is_on_ground:
            return Step(acts=(self._disarming.ask(SetArmed(False), facts),))
        return super()._follow(facts, order)
