"""What every operation state is (specification section 17)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

from hawk.comm.messages import Command
from hawk.ddc.fence_plan import FencePlan
from hawk.ddc.ranks import Rank
from hawk.model import HeightParameters, MapPoint, Route, StateName

if TYPE_CHECKING:
    from hawk.ddc.operations_manager import OperationsManager


@dataclass(frozen=True, slots=True)
class Cause:
    """Why the drone returns or lands by itself: while it lasts, Hold is refused with it."""

    text: str
    lasts: Callable[[], bool]
    details: str = ""


@dataclass(frozen=True, slots=True)
class MoveOrder:
    """An accepted Move in map coordinates (metres, yaw in radians); ``number`` is its desired pose's.

    ``route`` is the way there of an autonomous one.
    """

    place: MapPoint
    height: float
    yaw: float
    autonomous: bool
    number: int
    route: Route = field(default_factory=Route)


@dataclass(frozen=True, slots=True)
class ConfigureOrder:
    """Accepted travel heights."""

    heights: HeightParameters


@dataclass(frozen=True, slots=True)
class FenceOrder:
    """An accepted fence; None: the drawn one is put aside."""

    plan: FencePlan | None


Order = Command | MoveOrder | ConfigureOrder | FenceOrder


class State(ABC):
    """One operation state. ``process`` acts, ``transition_next_state`` decides; both run once a tick and never wait.

    A state is made without side effects and acts from `enter` on. ``context`` is the operations manager.
    """

    identity: ClassVar[StateName]

    def __init__(self, context: OperationsManager) -> None:
        self.context = context
        self.entered = context.now
        self._order: Order | None = None

    def get_identity(self) -> str:
        """Return the identity string."""
        return self.identity.value

    @property
    def rank(self) -> Rank:
        """Rank of what the state is doing: automatic reactions of this rank and below leave it alone."""
        return Rank.TASK

    @property
    def detail(self) -> str:
        """One sentence on what the state is doing, or why it was entered."""
        return ""

    @property
    def age(self) -> float:
        """Seconds since the state was entered."""
        return self.context.now - self.entered

    def give(self, order: Order) -> None:
        """Hand over an accepted command: the next `transition_next_state` follows it."""
        self._order = order

    def enter(self) -> None:
        """Begin: called once, when the state becomes the active one."""
        self.entered = self.context.now

    def leave(self) -> None:  # noqa: B027 - most states leave nothing behind
        """End: called once, when another state becomes the active one."""

    def process(self) -> None:  # noqa: B027 - a state that waits does nothing
        """Act, once a tick."""

    @abstractmethod
    def transition_next_state(self) -> State:
        """Return the next state, itself when nothing changes."""

    def _take_order(self) -> Order | None:
        order, self._order = self._order, None
        return order
