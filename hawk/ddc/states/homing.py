"""Return To Launch and Land: the autopilot's own RTL and LAND."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from hawk.comm.messages import Disarm
from hawk.ddc.mapping import is_on_ground
from hawk.ddc.ranks import Rank
from hawk.ddc.requests import Request
from hawk.ddc.states.airborne import AirborneState
from hawk.ddc.states.base import Cause, Order, State
from hawk.ddc.states.mode_keeper import ModeKeeper
from hawk.model import CopterMode, StateName

if TYPE_CHECKING:
    from hawk.ddc.operations_manager import OperationsManager


class Homing(AirborneState):
    """A state that one autopilot mode flies. ``taken_up``: the autopilot began it itself; nothing is sent then."""

    mode: ClassVar[CopterMode]
    own_rank: ClassVar[Rank]
    doing: ClassVar[str]

    def __init__(self, context: OperationsManager, cause: Cause | None = None, taken_up: bool = False) -> None:
        super().__init__(context)
        self.cause = cause
        self.taken_up = taken_up
        self._keeper = ModeKeeper(context, self.mode)
        self._told = 0

    @property
    def rank(self) -> Rank:
        """The autopilot's own, or ours."""
        return Rank.AUTOPILOT if self.taken_up else self.own_rank

    @property
    def detail(self) -> str:
        """What it does and why."""
        if self._keeper.reason:
            return f"{self.doing} was refused, trying again: {self._keeper.reason}"
        if self.taken_up:
            return f"{self.doing}: begun by the autopilot.{self._words()}"
        return f"{self.doing}. {self.cause.text}" if self.cause else f"{self.doing}."

    def hold_refusal(self) -> str:
        """Return why Hold is refused now; empty when it is not."""
        if self.taken_up:
            return f"The autopilot does this by itself.{self._words()}"
        if self.cause is not None and self.cause.lasts():
            return f"Not while this lasts: {self.cause.text}"
        return ""

    def restart(self) -> None:
        """The autopilot was not heard for a while and flies another mode now: ask again."""
        self._keeper, self._told = ModeKeeper(self.context, self.mode), 0

    def process(self) -> None:
        """Ask for the mode until it is seen."""
        if self.taken_up:
            return
        self._keeper.reach()
        if self._keeper.reason and self._keeper.attempts != self._told:
            self._told = self._keeper.attempts
            self.context.log.add("error", f"{self.doing} was refused. Trying again.", self._keeper.reason)

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

    def __init__(self, context: OperationsManager, cause: Cause | None = None, taken_up: bool = False) -> None:
        super().__init__(context, cause, taken_up)
        self._disarming: Request | None = None

    def process(self) -> None:
        """Ask for LAND; tell when a disarm was refused."""
        super().process()
        if self._disarming is not None and self._disarming.has_failed:
            self.context.log.add("error", "Disarm was refused.", self._disarming.reason)
            self._disarming = None

    def _follow(self, order: Order) -> State:
        if isinstance(order, Disarm) and is_on_ground(self.context.topics.get_state().landed):
            self._disarming = self.context.ask("disarm", self.context.service.set_arm(False))
            return self
        return super()._follow(order)
