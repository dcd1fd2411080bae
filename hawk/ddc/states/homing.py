"""Return To Launch and Land: the autopilot's own RTL and LAND."""

from __future__ import annotations

from typing import ClassVar

from hawk.comm.messages import Disarm
from hawk.ddc.acts import STAY, Acts, Log, SetArmed, Step
from hawk.ddc.facts import Facts
from hawk.ddc.home import HOME_WAIT_S, astray, home_words
from hawk.ddc.orders import Cause, CauseKind, Order, Rank, ToHover, ToLand
from hawk.ddc.states.base import AirborneState, Inquiry, ModeKeeper
from hawk.model import CopterMode, StateName


class Homing(AirborneState):
    """A state that one autopilot mode flies. ``by_autopilot``: the autopilot began it itself and nothing is sent."""

    is_left_alone = is_homing = True
    mode: ClassVar[CopterMode]
    own_rank: ClassVar[Rank]
    doing: ClassVar[str]

    def __init__(self, now: float, cause: Cause | None = None, by_autopilot: bool = False) -> None:
        super().__init__(now)
        self.cause = cause
        self.by_autopilot = by_autopilot
        self._keeper = ModeKeeper(self.mode)
        self._reported = 0

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
            sent = "the autopilot did it by itself" if self.by_autopilot else "sent without an answer"
            return f"{self.doing}: {sent}, no word from the autopilot."
        if self._keeper.reason:
            return f"{self.doing} was refused, trying again: {self._keeper.reason}"
        if self.by_autopilot:
            return f"{self.doing}: begun by the autopilot.{self._words()}"
        return f"{self.doing}. {self.cause.text}" if self.cause else f"{self.doing}."

    def hold_refusal(self, facts: Facts) -> str:
        """Return the reason why Hold is refused now; empty when it is not."""
        if self.by_autopilot:
            return f"The autopilot does this by itself.{self._words()}"
        if self.cause is not None and self.cause.lasts(facts):
            return f"Not while this lasts: {self.cause.text}"
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
            acts += (Log("error", f"{self.doing} was refused. Trying again.", self._keeper.reason),)
        return acts

    def _words(self) -> str:
        return f" {self.cause.details}" if self.cause is not None and self.cause.details else ""


class ReturnToLaunch(Homing):
    """Flies home and lands, by the autopilot.

    A home that was moved is set back first (`hawk.ddc.home`). RTL that began with a moved home flies there, even
    when home is set back later, so that it is begun again. Where home stays outside the fence, the drone lands instead;
    when the operator asked for the return, it holds.
    """

    identity = StateName.RETURN_TO_LAUNCH
    mode = CopterMode.RTL
    own_rank = Rank.RETURN_TO_LAUNCH
    doing = "Returning home"

    def __init__(self, now: float, cause: Cause | None = None, by_autopilot: bool = False) -> None:
        super().__init__(now, cause, by_autopilot)
        self._is_flying = False
        self._is_misled = False
        self._stopping: ModeKeeper | None = None
        self._begins_again = False

    def detail(self, facts: Facts) -> str:
        """Return the present activity and its cause."""
        if self._stopping is not None or self._waits(facts):
            return "Returning home: home was moved, it is set back first."
        return super().detail(facts)

    def restart(self) -> None:
        """Ask for the mode again: the autopilot was not heard for a while and flies another one."""
        super().restart()
        self._is_flying = self._is_misled = False
        self._stopping = None

    def process(self, facts: Facts) -> Acts:
        """Ask for RTL once home is right; begin it again when it began with a home that was moved."""
        if self._stopping is not None:
            return self._begin_again(facts, self._stopping)
        self._look(facts)
        home = facts.position.autopilot_home
        if self._is_misled and not home.is_moved:
            self._stopping = ModeKeeper(CopterMode.BRAKE)
            log = Log("warning", "Home is back: the return begins again.")
            return (log, *self._begin_again(facts, self._stopping))
        if self._waits(facts) or self._leads_out(facts):
            return ()
        if self._begins_again:
            return self._ask(facts)
        return super().process(facts)

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
            unsure = self.by_autopilot and not self._begins_again and home.moved_s is not None
            self._is_misled = home.is_moved or unsure
        self._is_flying = flies

    def _waits(self, facts: Facts) -> bool:
        """Return True before RTL while home is moved, as long as it may be set back in time."""
        home = facts.position.autopilot_home
        return not self._is_flying and home.is_moved and not self._is_given_up(facts)

    def _leads_out(self, facts: Facts) -> bool:
        """Return True when RTL flies, or would fly, to a home that stays outside the fence."""
        would = self._is_misled or not self._is_flying
        return would and facts.position.autopilot_home.misleads and self._is_given_up(facts)

    def _is_given_up(self, facts: Facts) -> bool:
        moved_s = facts.position.autopilot_home.moved_s
        return moved_s is not None and min(moved_s, self.age(facts)) >= HOME_WAIT_S

    def _decide(self, facts: Facts) -> Step:
        if not self._leads_out(facts):
            return STAY
        home = facts.position.autopilot_home
        if self.cause is None and not self.by_autopilot:
            return Step(ToHover(f"{home_words(home)} Land, or move the drone.", level="error"))
        return Step(ToLand(astray(home, self.cause or Cause("", CauseKind.NEVER))))


class Land(Homing):
    """Straight down, by the autopilot; Disarm is followed once it is on the ground."""

    identity = StateName.LAND
    mode = CopterMode.LAND
    own_rank = Rank.LAND
    doing = "Landing"

    def __init__(self, now: float, cause: Cause | None = None, by_autopilot: bool = False) -> None:
        super().__init__(now, cause, by_autopilot)
        self._disarming = Inquiry()

    def process(self, facts: Facts) -> Acts:
        """Ask for LAND; report a disarm that was refused."""
        acts = super().process(facts)
        if failed := self._disarming.failure(facts):
            self._disarming.clear()
            acts += (Log("error", "Disarm was refused.", failed.reason),)
        return acts

    def _follow(self, facts: Facts, order: Order) -> Step:
        if isinstance(order, Disarm) and facts.is_on_ground:
            return Step(acts=(self._disarming.ask(SetArmed(False), facts),))
        return super()._follow(facts, order)
