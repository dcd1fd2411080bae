"""Scale of a map by photographs: what says it, whether these agree, and how far it may be off.

Ties between photographs leave the scale of the whole map free. Three witnesses say it: the height that the files or a
person give, which is above the take-off place or the ground; the distances between the places of the photographs by
their receiver; the width of the stalls. One that is far off the others is asked about, never averaged.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from statistics import NormalDist, median
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from hawk.algo.vision.network import USUAL_WIDTH_M
from hawk.model.lot_map import HELD_SHARE
from hawk.picture.reconstruction.alignment import HEIGHT_SHARE, PosePrior, Reconstruction
from hawk.picture.reconstruction.camera_pose import FloatArray
from hawk.picture.values import PictureError, Shot

STALL_SHARE: Final = 0.08
"""Standard deviation of the width of a lot's stalls: lots of 2.1 to 3 m are common."""
LEAST_STALLS: Final = 6
"""Stalls whose median is a usual width."""
LENS_SHARE: Final = (0.01, 0.05)
"""Standard deviation of a focal length that is known, and of one that is guessed: a height by pictures errs with it."""
AGREE: Final = 2.0
"""Standard deviations of their difference within which two witnesses agree."""
POOR_SHARE: Final = 0.1
"""Standard deviation of a witness that decides nothing against another one."""
WANDER: Final = 0.7
"""Share of a receiver's error that lasts, and so is alike in photographs one after the other."""
WANDER_S: Final = 600.0
"""Time constant of that; single frequency receivers wander for minutes to an hour."""
_BETWEEN_S: Final = 5.0
"""Time between two photographs whose files give none."""
_SAID: Final = 4.0
"""Residuals for which what the files say of their errors counts, beside those that are seen."""
_MOST_AT_ONCE: Final = 1000
"""Photographs by which the error is computed: its matrix has as many rows."""
_WITHIN: Final = NormalDist().inv_cdf((1 + HELD_SHARE) / 2)


@dataclass(frozen=True, slots=True)
class ScaleEstimate:
    """A witness of the scale. ``factor``: by which the adjusted map must grow to fit it; ``share``: its standard
    deviation, as a share of it. ``turn``: standard deviation of the map's turn, radians, where it says one.
    """

    factor: float
    share: float
    turn: float = math.inf

    def differs(self, other: ScaleEstimate) -> bool:
        """Return whether another witness says another scale, beyond the errors of both."""
        return abs(math.log(self.factor / other.factor)) > AGREE * math.hypot(self.share, other.share)

    def metres(self, height: float) -> tuple[float, float, float]:
        """Return the height, metres, and the least and the greatest in `HELD_SHARE` of all surveys."""
        within = math.exp(_WITHIN * self.share)
        return height * self.factor, height * self.factor / within, height * self.factor * within


@dataclass(frozen=True, slots=True)
class Scale:
    """The scale of a map: ``factor`` by which the adjusted poses grow. ``off``, a share, and ``turn``, radians: errors
    below which scale and turn stay in `HELD_SHARE` of all surveys. ``height``: of the middle photograph, metres.
    ``is_by_places``: the distances of places decide it, not the height alone.
    """

    factor: float
    off: float
    turn: float
    height: float
    is_by_places: bool


@dataclass(frozen=True, slots=True)
class HeightPrior:
    """Words on the height. ``given``: by a person, metres; ``doubt``: why the files' heights say nothing, or
    nothing alone, "" where they do; ``is_none``: nothing says one.
    """

    given: float | None = None
    doubt: str = ""
    is_none: bool = False


def by_places(shots: Sequence[Shot], known: Sequence[PosePrior], adjusted: Reconstruction) -> ScaleEstimate | None:
    """Return the scale by the distances between the places that the files say; None where fewer than two are adjusted.

    It is that of the least squares similarity between both (Umeyama 1991). Its error follows from the residuals, as
    Student's t has it for few of them, and from what lasts of a receiver's error, by the times of the photographs.
    """
    chosen = np.flatnonzero(adjusted.is_adjusted).tolist()
    if len(chosen) < 2:
        return None
    own = np.array([complex(adjusted.posed[k].north, adjusted.posed[k].east) for k in chosen])
    said = np.array([complex(known[k].posed.north, known[k].posed.east) for k in chosen])
    sigma = np.array([known[k].place_m for k in chosen])
    weight = sigma**-2 / (sigma**-2).sum()
    own, said = own - (weight * own).sum(), said - (weight * said).sum()
    spread = float((weight * np.abs(own) ** 2).sum())
    if not spread > 0.0:
        return None
    fitted = complex((weight * own.conj() * said).sum() / spread)
    left = float((np.abs(said - fitted * own) ** 2 / sigma**2).sum())
    free = _SAID + 2 * len(chosen) - 4
    tail = float(stdtrit(free, (1 + HELD_SHARE) / 2)) / _WITHIN
    white = (_SAID + left) / free * tail**2 * float((np.abs(weight * own / spread) ** 2 * sigma**2).sum())
    times = [shots[k].time for k in chosen]
    share = math.sqrt(white + _wander(weight * own / spread, sigma, times)) / max(abs(fitted), 1e-9)
    return ScaleEstimate(max(abs(fitted), 1e-9), share, share)


def _wander(pull: NDArray[np.complex128], sigma: FloatArray, times: Sequence[float | None]) -> float:
    """Return the variance of turn and scale by errors that last. ``pull`` (N,): how each place's error moves them."""
    seconds = np.array([k * _BETWEEN_S if time is None else time for k, time in enumerate(times)])
    step = -(-len(pull) // _MOST_AT_ONCE)
    total = np.add.reduceat(pull * sigma, np.arange(0, len(pull), step))  # neighbours in time err alike
    at = seconds[::step]
    alike = np.exp(-np.abs(at[:, None] - at[None]) / WANDER_S)
    return WANDER**2 * float(np.real(total.conj() @ alike @ total))


def by_height(known: Sequence[PosePrior], adjusted: Reconstruction, *, lens_is_known: bool) -> ScaleEstimate:
    """Return the scale by the heights that are said, of the photographs that were adjusted, else of all."""
    chosen = np.flatnonzero(adjusted.is_adjusted).tolist() or range(len(known))
    factor = median(known[k].posed.height for k in chosen) / middle_height(adjusted)
    return ScaleEstimate(factor, math.hypot(HEIGHT_SHARE, LENS_SHARE[not lens_is_known]))


def by_stalls(widths: Sequence[float]) -> ScaleEstimate | None:
    """Return the scale by the widths of stalls, metres by the present one; None where they are too few."""
    if len(widths) < LEAST_STALLS:
        return None
    return ScaleEstimate(USUAL_WIDTH_M / median(widths), STALL_SHARE)


def middle_height(adjusted: Reconstruction) -> float:
    """Return the median height of the photographs that were adjusted, else of all, metres."""
    every = zip(adjusted.posed, adjusted.is_adjusted, strict=True)
    has_any = bool(adjusted.is_adjusted.any())
    return median(one.height for one, good in every if good or not has_any)


def choose_scale(
    name: str, places: ScaleEstimate | None, height: ScaleEstimate, said: HeightPrior, middle_m: float,
    look: Callable[[float], ScaleEstimate | None],
) -> Scale:  # fmt: skip
    """Return the scale on which the witnesses agree.

    Args:
        name: The lot's, which begins an error.
        places: As `by_places`.
        height: As `by_height`.
        said: What is said of the height.
        middle_m: Height of the middle photograph as adjusted, metres.
        look: Returns the scale by stalls, for a map that grows by this factor.

    Raises:
        PictureError: They differ, or no height is said; the text has the one that would fit.
    """
    sure = places if places is not None and places.share < POOR_SHARE else None
    both = [height] if places is None else [height, places]
    if sure is not None and not said.is_none and not height.differs(sure):
        return _scale(both, middle_m, places)
    begin = sure or (places if said.is_none and places is not None else height)
    stalls = look(begin.factor)
    is_alone = stalls is None or stalls.differs(height)
    if said.given is not None and (sure is None or not is_alone):
        return _scale([height] if sure is not None else both, middle_m, places)
    if sure is None and not said.is_none and not said.doubt and (stalls is None or not is_alone):
        return _scale(both, middle_m, places)
    raise PictureError(question(name, said, height, places, stalls, middle_m))


def _scale(readings: Sequence[ScaleEstimate], middle_m: float, places: ScaleEstimate | None) -> Scale:
    """Return the mean of readings; its error grows where they differ by more than they say (Birge 1932)."""
    weights = np.array([reading.share**-2 for reading in readings])
    logs = np.array([math.log(reading.factor) for reading in readings])
    mean = float((weights * logs).sum() / weights.sum())
    beyond = float((weights * (logs - mean) ** 2).sum()) / max(1, len(readings) - 1)
    share = math.sqrt(max(1.0, beyond) / weights.sum())
    factor = math.exp(mean)
    turn = math.inf if places is None else _WITHIN * places.turn
    return Scale(factor, _WITHIN * share, turn, middle_m * factor, len(readings) > 1)


def question(
    name: str,
    said: HeightPrior,
    height: ScaleEstimate,
    places: ScaleEstimate | None,
    stalls: ScaleEstimate | None,
    middle_m: float,
) -> str:
    """Return the question for the height, with what each witness says and the value that would fit."""
    if said.given is not None:
        words = f"--height {said.given:g}"
    else:
        words = f"{name}: {said.doubt or f'the files give {height.factor * middle_m:.0f} m above the take-off place'}"
    seen = []
    if places is not None:
        metres, least, most = places.metres(middle_m)
        seen.append(f"the distances between the photographs' places say {metres:.0f} m ({least:.0f} to {most:.0f})")
    if stalls is not None:
        seen.append(f"stalls {USUAL_WIDTH_M:g} m wide say {stalls.factor * middle_m:.0f} m")
    if not seen:
        return f"{words}; give the flight's height above the ground by --height METRES"
    fits = fitting_height(places, stalls, middle_m)
    return (
        f"{words}, but {' and '.join(seen)}; give the height above the ground of the lot: --height {fits:g} would fit. "
        "Where that is not so, the lens is another one: --lenses or --calibration describes it"
    )


def fitting_height(places: ScaleEstimate | None, stalls: ScaleEstimate | None, middle_m: float) -> float:
    """Return the height that fits what places and stalls say, metres, as a person would give it."""
    readings = [reading for reading in (places, stalls) if reading is not None]
    if places is not None and stalls is not None and places.differs(stalls):
        readings = [min(readings, key=lambda reading: reading.share)]
    metres = _scale(readings, middle_m, None).height
    return round(metres, 1 if metres < 20.0 else 0)


def scale_poses(adjusted: Reconstruction, factor: float) -> Reconstruction:
    """Return adjusted poses whose distances and heights are larger by a factor, about their middle."""
    good = adjusted.is_adjusted
    places = np.array([(one.north, one.east) for one in adjusted.posed])
    middle = places[good].mean(axis=0) if good.any() else np.zeros(2)
    moved = np.where(good[:, None], middle + factor * (places - middle), places)
    posed = tuple(
        replace(one, north=north, east=east, height=one.height * factor, level=one.level * factor)
        for one, (north, east) in zip(adjusted.posed, moved.tolist(), strict=True)
    )
    return replace(adjusted, posed=posed)
