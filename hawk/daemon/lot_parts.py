"""The parts that keep lots: their store, the saving of surveys, and the plan that a flight knows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Self

from hawk.config.sections import StoreSettings
from hawk.daemon.known_lot import KnownLotFollower
from hawk.daemon.lot_keeper import LotKeeper, find_stalls
from hawk.lots.finished import LandedSurvey
from hawk.lots.store import LotStore, lots_file
from hawk.model.operation import Level
from hawk.model.poses import GlobalPose


@dataclass(frozen=True, slots=True)
class LotParts:
    """They share the store; none calls another."""

    store: LotStore
    keeper: LotKeeper
    known: KnownLotFollower

    @classmethod
    def create(
        cls,
        config: StoreSettings,
        landed: Callable[[], LandedSurvey | None],
        datum: Callable[[], GlobalPose | None],
        survey: Callable[[], str],
        add_message: Callable[[Level, str, str], object],
        *,
        is_restored: bool,
    ) -> Self:
        """Make them; arguments as those of `LotKeeper` and `KnownLotFollower`."""
        store = LotStore(lots_file(config.directory, config.lots), find_stalls)
        keeper = LotKeeper(store, landed, add_message, is_restored=is_restored)
        return cls(store, keeper, KnownLotFollower(store, datum, survey, add_message))
