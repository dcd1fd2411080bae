"""A folder of photographs as one flight's shots: what is left out is named, and what is mixed is refused."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

from hawk.model.pictures import CameraModel
from hawk.picture.photographs.heights import assign_heights
from hawk.picture.photographs.lenses import Lenses
from hawk.picture.photographs.photograph import Photograph, UnusableError, read_photograph
from hawk.picture.photographs.places import Choice, apart_m, resolve_places
from hawk.picture.values import LeftOut, PictureError, Shot, ShotSet, list_names

SUFFIXES: Final = (".jpg", ".jpeg")
LONGEST_PAUSE_S: Final = 45 * 60.0
"""Between two photographs of one flight: no common battery lasts longer, and the cars are others then."""
FARTHEST_M: Final = 1000.0
"""Between two photographs of one flight, one after the other."""
_LEAST_MANY: Final = 5
"""Photographs of a flight beside which a lone other one is left out, not asked about."""
_FEW_SHARE: Final = 0.1
"""The same as a share of them."""
_FEW: Final = 4
"""Names that a sentence lists."""


def read_folder(
    folder: Path,
    *,
    lenses: Path | None = None,
    calibration: CameraModel | None = None,
    height_m: float | None = None,
    group: int | None = None,
    place: Choice | None = None,
) -> ShotSet:
    """Read the photographs of a folder; of each only its head, so that thousands take seconds and little memory.

    Args:
        folder: It holds the JPEGs itself.
        lenses: Table of lenses that adds to hawk's own (docs/photographs.md).
        calibration: Lens of all photographs, at any size of the same shape.
        height_m: Height above the ground of the middle photograph, metres, where the files give none or another one.
        group: Which flight or camera of a mixed folder, from 1, as the refusal numbers them.
        place: Which tags have the right place, where those of EXIF and XMP differ and nothing else says it.

    Returns:
        The shots by time and then by name; ``left_out`` is in the order of the names.

    Raises:
        PictureError: Nothing can be mapped, or several flights or cameras are mixed.
    """
    table = Lenses(lenses)
    paths, notes = _photographs(folder)
    left: list[LeftOut] = []
    photographs = list(_read(paths, table, calibration, left))
    if not photographs:
        raise PictureError(f"{folder}: no photograph can be used: {_reasons(left)}")
    photographs, differ = resolve_places(photographs, place)
    groups = _groups(_by_time(photographs))
    if group is None:
        groups, few = _without_few(groups)
        left += few
    chosen = _by_time(_chosen(groups, group, folder))  # others may lack GNSS's time
    shots, doubles = _once(chosen)
    shots, low = assign_heights(shots, height_m)
    left += [*doubles, *low]
    if not shots:
        raise PictureError(f"{folder}: no photograph can be used: {_reasons(left)}")
    named_left = tuple(sorted(left, key=lambda each: each.name))
    is_sure = any(
        all(facts) for facts in zip(*((one.gnss_time is not None, one.has_zone) for one in chosen), strict=True)
    )
    return ShotSet(tuple(shots), named_left, (*notes, *differ, *_notes(chosen)), is_sure)


def flights_of(photographs: list[Photograph]) -> list[list[Photograph]]:
    """Return the photographs of each flight and drone by time. Few of another camera stay among many: `read_folder`
    leaves them out.
    """
    flights = []
    for serial in dict.fromkeys(one.serial for one in photographs):
        own = _by_time([one for one in photographs if one.serial == serial])
        groups = _groups(own)
        flights += [own] if _without_few(groups)[1] else groups
    return flights


def _photographs(folder: Path) -> tuple[list[Path], list[str]]:
    """Return the paths of a folder's JPEGs by name, and a note on what else it holds."""
    try:
        entries = sorted(entry for entry in folder.iterdir() if not entry.name.startswith("."))
    except OSError as error:
        raise PictureError(
            f"{folder} cannot be read ({error.strerror or error}); name a folder of photographs"
        ) from None
    paths = [entry for entry in entries if entry.suffix.lower() in SUFFIXES and entry.is_file()]
    inner = [entry.name for entry in entries if entry.is_dir()]
    others = [entry.name for entry in entries if entry.is_file() and entry not in set(paths)]
    if not paths:
        hint = f"name one of its folders: {list_names(inner)}" if inner else "name the folder that holds them"
        raise PictureError(f"{folder}: no JPEG photograph is in it; {hint}")
    notes = [f"No JPEG, passed over: {list_names(others)}"] if others else []
    return paths, notes + ([f"Folders, passed over: {list_names(inner)}"] if inner else [])


def _read(
    paths: Iterable[Path], table: Lenses, calibration: CameraModel | None, left: list[LeftOut]
) -> Iterator[Photograph]:
    for path in paths:
        try:
            yield read_photograph(path, table, calibration)
        except UnusableError as error:
            left.append(LeftOut(path.name, str(error)))


def _by_time(photographs: list[Photograph]) -> list[Photograph]:
    """Return the photographs in order, by GNSS's time where all have it, else by the camera's clock, else by name."""
    if all(each.gnss_time is not None for each in photographs):
        photographs = [replace(each, shot=replace(each.shot, time=each.gnss_time)) for each in photographs]
    if any(each.shot.time is None for each in photographs):
        return sorted(photographs, key=lambda each: each.shot.name)
    return sorted(photographs, key=lambda each: (each.shot.time or 0.0, each.shot.name))


def _groups(photographs: list[Photograph]) -> list[list[Photograph]]:
    """Return the photographs of each camera, cut where a pause or a distance is too long for one flight."""
    groups: list[list[Photograph]] = []
    for kind in dict.fromkeys(each.kind for each in photographs):
        flights: list[list[Photograph]] = []
        for each in (one for one in photographs if one.kind == kind):
            fits = (one for one in reversed(flights) if not _is_another_flight(one[-1].shot, each.shot))
            flight = next(fits, None)
            if flight is None:
                flights.append(flight := [])
            flight.append(each)
        groups += flights
    return groups


def _without_few(groups: list[list[Photograph]]) -> tuple[list[list[Photograph]], list[LeftOut]]:
    """Return the one group that has nearly all photographs, and the others left out; all groups where none has."""
    largest = max(groups, key=len)
    rest = sum(map(len, groups)) - len(largest)
    if not rest or len(largest) < _LEAST_MANY or rest > max(1, _FEW_SHARE * len(largest)):
        return groups, []
    left = [
        LeftOut(
            each.shot.name,
            f"is of another camera, size, lens or flight than the others ({_described(largest)}): {_described(group)}; "
            f"--group {number} maps it",
        )
        for number, group in enumerate(groups, 1)
        if group is not largest
        for each in group
    ]
    return [largest], left


def _is_another_flight(before: Shot, after: Shot) -> bool:
    pause = 0.0 if before.time is None or after.time is None else after.time - before.time
    return pause > LONGEST_PAUSE_S or apart_m(before.latitude_longitude, after.latitude_longitude) > FARTHEST_M


def _chosen(groups: list[list[Photograph]], group: int | None, folder: Path) -> list[Photograph]:
    if group is not None and not 1 <= group <= len(groups):
        raise PictureError(f"--group {group}: must be 1 to {len(groups)}, as many flights and cameras {folder} holds")
    if group is None and len(groups) > 1:
        listed = "; ".join(f"{number}: {_described(each)}" for number, each in enumerate(groups, 1))
        raise PictureError(
            f"{folder} mixes {len(groups)} flights or cameras ({listed}); name one by --group NUMBER, or give each a "
            "folder of its own"
        )
    return groups[(group or 1) - 1]


def _described(group: list[Photograph]) -> str:
    shots = [each.shot for each in group]
    first, last, camera = shots[0], shots[-1], shots[0].camera
    when = "" if first.time is None else f", from {datetime.fromtimestamp(first.time, UTC):%Y-%m-%d %H:%M}"
    span = first.name if len(shots) == 1 else f"{first.name} to {last.name}"
    model = first.model or "camera not named"
    return f"{len(shots)} of {model}, {camera.width} x {camera.height}{when}, {span}"


def _once(photographs: list[Photograph]) -> tuple[list[Shot], list[LeftOut]]:
    """Return each shot once: a second one of the same moment and place shows nothing new."""
    seen: dict[tuple[float, float, float], str] = {}
    shots, doubles = [], []
    for shot in (each.shot for each in photographs):
        key = (round(shot.latitude, 7), round(shot.longitude, 7), round(shot.time or 0.0, 3))
        former = seen.setdefault(key, shot.name) if shot.time is not None else shot.name
        if former == shot.name:
            shots.append(shot)
        else:
            doubles.append(LeftOut(shot.name, f"has the place and the time of {former}; take one of them away"))
    return shots, doubles


def _notes(photographs: list[Photograph]) -> list[str]:
    notes = []
    if not all(each.shot.lens_is_known for each in photographs):
        model = photographs[0].shot.model or "the camera"
        notes.append(
            f"The lens of {model} is guessed from its focal length on 35 mm film, or from a sensor of another shape "
            "than the picture's; --lenses or --calibration knows it better"
        )
    if all(each.shot.attitude is None for each in photographs):
        notes.append("The files do not say where the camera looked: straight down is assumed, its yaw is not known")
    later = [each for each in photographs if each.saved_by]
    if later:
        notes.append(
            f"Saved by {later[0].saved_by}, which may have turned them: "
            f"{list_names([each.shot.name for each in later])}; their yaw is believed to quarter turns only, and the "
            "camera's own files are better"
        )
    if any(each.orientation != 1 for each in photographs):
        notes.append("EXIF's orientation is not applied: pictures are mapped as the sensor gave them")
    return notes


def _reasons(left: list[LeftOut]) -> str:
    """Return each reason once, the most frequent first, with a name and how many more there are."""
    counts = Counter(each.reason for each in left)
    firsts = {each.reason: each.name for each in reversed(left)}
    words = [
        f"{firsts[reason]}{f' (and {count - 1} more)' if count > 1 else ''} {reason}"
        for reason, count in counts.most_common(_FEW)
    ]
    return "; ".join(words)
