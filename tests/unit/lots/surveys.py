"""Surveys of a drawn lot, for the tests of the store."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import numpy as np

from hawk.lots.values import Detection, FinishedSurvey
from hawk.model.lot_map import StallState
from hawk.model.plans import Outline
from hawk.model.poses import GlobalPose
from hawk.results.survey_map import to_global

DATUM = GlobalPose(52.0, 5.0, 0.0)
PITCH, DEEP, A_ROW = 2.5, 5.0, 20
BEGAN = 1_770_000_000.0


def stall(number: int, seed: int = 0, north: float = 0.0) -> Detection:
    """Return a stall of rows of 20, 9 m apart, with drawn errors and a drawn state."""
    drawn = random.Random(f"{seed} {number}")
    row, along = divmod(number - 1, A_ROW)
    return Detection(
        id=number,
        north=north - row * 9.0 + drawn.gauss(0, 0.1),
        east=along * PITCH + drawn.gauss(0, 0.1),
        angle=math.radians(drawn.gauss(0, 0.5)) % math.pi,
        width=PITCH,
        length=DEEP,
        taken_probability=drawn.random(),
        state=drawn.choice([StallState.FREE, StallState.TAKEN]),
        score=drawn.random(),
        picture_count=drawn.randrange(1, 300),
        looked_at=BEGAN + drawn.random() * 600,
    )


def box(north: float, east: float, high: float, wide: float, datum: GlobalPose = DATUM) -> Outline:
    """Return a rectangle by its south-west corner and its sides, metres about a datum."""
    corners = [(north, east), (north + high, east), (north + high, east + wide), (north, east + wide)]
    return Outline((tuple((float(a), float(b)) for a, b in to_global(datum, np.array(corners, float))),))


def survey(name: str = "000001-20260504T103000Z", stalls: int = 40, seed: int = 0) -> FinishedSurvey:
    """Return a survey of the lot's first stalls."""
    rows = math.ceil(stalls / A_ROW)
    return FinishedSurvey(
        name=name,
        datum=DATUM,
        began=BEGAN,
        ended=BEGAN + 900,
        time_is_sure=True,
        outline=box(-9.0 * rows + 4, -3, 9.0 * rows, PITCH * A_ROW + 4) if stalls else Outline(),
        stalls=tuple(stall(number, seed) for number in range(1, stalls + 1)),
        program="0.3.0",
        seen_ground=box(-9.0 * rows - 4, -15, 9.0 * rows + 18, PITCH * A_ROW + 28) if stalls else Outline(),
    )


def later(given: FinishedSurvey, number: int, hours: float = 24.0) -> FinishedSurvey:
    """Return the survey as one that is flown that much later, its journal with another number."""
    name = f"{number:06d}-20260505T103000Z"
    return replace(given, name=name, began=given.began + hours * 3600, ended=given.ended + hours * 3600)
