"""No lot in sight after take-off: climb to Max, then a square spiral, then give up."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from hawk.comm.messages import CompulsiveMove, Hold
from hawk.model import StateName
from hawk.survey.handset import Handset, SurveyError, SurveyStatus

SPIRAL_STEP_M: Final = 10.0
SPIRAL_WAY_M: Final = 60.0
"""Longest way of the spiral: legs of 10, 10, 20 and 20 m, seen from Max."""
NO_LOT: Final = "No lot in sight, not even from the greatest height and 60 m around."


class LotSearch:
    """Looks for a lot from where the drone hovers, then from Max along the spiral; each place is looked at once.

    ``look_s``: seconds to look from each place; ``move_s``: seconds that one move may take.
    """

    def __init__(self, hand: Handset, look_s: float, move_s: float) -> None:
        self._hand = hand
        self._look_s = look_s
        self._move_s = move_s
        self._places: Iterator[tuple[float, float]] | None = None

    async def find(self) -> None:
        """Return when the drone hovers with a lot in sight; another call goes on to the next place.

        Raises SurveyError with status NO_LOT when every place was looked at.
        """
        self._hand.phase = "Looking for the lot"
        if self._places is None:
            beat = await self._hand.beat()
            if beat.north is None or beat.east is None:
                raise SurveyError("The place of the drone is not known.", SurveyStatus.NO_LOT)
            self._places = spiral(beat.north, beat.east)
            if await _in_sight(self._hand, self._look_s):
                return
        for north, east in self._places:
            if await self._go(north, east) and await _in_sight(self._hand, self._look_s):
                return
        raise SurveyError(NO_LOT, SurveyStatus.NO_LOT)

    async def _go(self, north: float, east: float) -> bool:
        """Fly there at Max, stopping at once when a lot comes in sight; False when the place was refused."""
        beat = await self._hand.beat()
        refusal = await self._hand.offer(CompulsiveMove(x=north, y=east, frame="Map", height=beat.heights[2]))
        if refusal is not None:
            return False  # outside the fence, for one: the next place may be inside
        beat = await self._hand.until(
            lambda b: b.state == StateName.HOVER or b.park_lot_detected is True,
            self._move_s,
            "The drone did not get to where it looks for the lot",
        )
        if beat.state != StateName.HOVER:
            await self._hand.tell(Hold())
            await self._hand.until(lambda b: b.state == StateName.HOVER, self._move_s, "The drone did not stop")
        return True


def spiral(north: float, east: float) -> Iterator[tuple[float, float]]:
    """Yield the corners of a square spiral (metres, map frame), the middle first, within `SPIRAL_WAY_M` of way."""
    yield north, east
    way, leg, sign = 0.0, SPIRAL_STEP_M, 1.0
    while True:
        for step_north, step_east in ((leg * sign, 0.0), (0.0, leg * sign)):
            if way + leg > SPIRAL_WAY_M:
                return
            way += leg
            north, east = north + step_north, east + step_east
            yield north, east
        leg, sign = leg + SPIRAL_STEP_M, -sign


async def _in_sight(hand: Handset, look_s: float) -> bool:
    """Whether the lot is seen within a few seconds of looking."""
    began = (await hand.beat()).time
    beat = await hand.until(
        lambda b: b.park_lot_detected is True or b.time - began > look_s,
        4 * look_s,
        "The lot was looked for too long",
    )
    return beat.park_lot_detected is True
