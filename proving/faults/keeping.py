"""Possessions that a fault must not lose: parameters, stalls, the journalled map, and the recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from hawk.comm.protocol.heartbeat import Heartbeat
from hawk.model.lot_map import Stall
from hawk.store.journal_state import read_survey, surveys_of
from hawk.store.replay import RecordingError, read_recording

SAME_M: Final = 1.0
"""A stall within this distance of a former one is the same."""
KEPT_SHARE: Final = 0.95
"""Stalls that are there afterwards: some of those at the border of a picture are found or dropped by the next frame."""
SURE_SEEN: Final = 5
"""Frames in which a stall must have been seen to count: the next frame may drop one that was found just now."""
RECORDED_S: Final = 1.5
"""A recording that was cut off ends at most this number of seconds before the daemon did."""


@dataclass(frozen=True, slots=True)
class Kept:
    """The daemon's possessions at a moment. ``tiles``: names of the journalled map's parts."""

    heights: tuple[float, float, float]
    stalls: tuple[Stall, ...]
    tiles: frozenset[str]
    survey: str
    time: float
    recording: Path | None = None
    """The file that is being written."""

    @classmethod
    def now(cls, beat: Heartbeat, stalls: Mapping[int, Stall], store: Path) -> Kept:
        """Read them from the daemon's last heartbeat, its client's map and its journal."""
        survey, tiles = journalled(store)
        return cls(beat.heights, tuple(stalls.values()), tiles, survey, beat.time, newest_recording(store))


def journalled(store: Path) -> tuple[str, frozenset[str]]:
    """Return the name of the last survey and the parts of its map in the journal, without the stalls."""
    surveys = surveys_of(store / "journal")
    if not surveys:
        return "", frozenset()
    parts = read_survey(surveys[-1])[1].map_parts
    return surveys[-1].name, frozenset(name for name in parts if not name.startswith("stall"))


def lost(before: Kept, after: Kept) -> list[str]:
    """Return what was lost, in words."""
    problems = []
    if after.heights != before.heights:
        problems.append(f"heights {before.heights} became {after.heights}")
    if before.survey == after.survey and (gone := before.tiles - after.tiles):
        problems.append(f"{len(gone)} of {len(before.tiles)} parts of the journalled map are gone")
    if before.survey != after.survey and before.tiles:
        problems.append(f"survey {before.survey} became {after.survey}")
    sure = [stall for stall in before.stalls if stall.seen >= SURE_SEEN]
    found = _found_again(sure, after.stalls)
    if round((1 - found) * len(sure)) > max(1, (1 - KEPT_SHARE) * len(sure)):  # vision takes one back now and then
        problems.append(f"{len(before.stalls)} stalls became {len(after.stalls)}, {found:.0%} of them are there")
    return problems


def newest_recording(store: Path) -> Path | None:
    """Return the recording that was written last; None where there is none."""
    files = (store / "recordings").glob("*.mcap")
    return max(files, key=lambda path: path.stat().st_mtime, default=None)


def recording_ends(path: Path) -> float:
    """Return the time of a recording's last message, seconds of that run. Raises RecordingError when it has none."""
    last = max((recorded.time for recorded in read_recording(path)), default=None)
    if last is None:
        raise RecordingError(f"{path} is empty")
    return last


def _found_again(before: Sequence[Stall], after: Sequence[Stall]) -> float:
    if not before:
        return 1.0
    if not after:
        return 0.0
    old = np.array([(stall.north, stall.east) for stall in before])
    new = np.array([(stall.north, stall.east) for stall in after])
    nearest = np.min(np.hypot(*(old[:, None] - new[None]).transpose(2, 0, 1)), axis=1)
    return float(np.mean(nearest <= SAME_M))
