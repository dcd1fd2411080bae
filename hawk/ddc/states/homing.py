"""Return To Launch and Land: the autopilot's own RTL and LAND."""

from __future__ import annotations

from typing import ClassVar

from hawk.comm.messages import Disarm
from hawk.ddc.acts import Acts, Log, SetArmed, Step
from hawk.ddc.facts import Facts
from hawk.ddc.orders import Cause, Order, Rank
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
        if self.by_autopilot:
            return ()
        acts = self._keeper.reach(facts)
        if self._keeper.refusals != self._reported:
            self._reported = self._keeper.refusals
            acts += (Log("error", f"{self.doing} was refused. Trying again.", self._keeper.reason),)
        return acts

    def _words(self) -> str:
        return f" {self.cause.details}" if self.cause is not None and self.cause.details else ""


class ReturnToLaunch(Homing):
    """Flies home and lands, by the autopilot."""

    identity = StateName.RETURN_TO_LAUNCH
    mode = CopterMode.RTL
    own_rank = Rank.RETURN_TO_LAUNCH
    doing = "Returning home"


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
