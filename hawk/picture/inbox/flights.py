"""Flights among the files of a drop: photographs by their tags, each film and each orthophoto by itself.

Photographs of one drop are one flight by the rule of `hawk-drone map` (`photographs.folder.flights_of`). Drops are
joined by a narrower one (`continues`): two flights of a dock that starts every half hour are not one.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path, PurePath
from typing import Final

import numpy as np

from hawk.model.pictures import CameraModel
from hawk.picture.film.app import FILMS
from hawk.picture.inbox.folder import LOOSE, Drop, FileFacts
from hawk.picture.photographs.folder import SUFFIXES, flights_of
from hawk.picture.photographs.lenses import Lenses
from hawk.picture.photographs.photograph import Photograph, read_photograph
from hawk.picture.photographs.places import apart_m, unwrap_longitudes, wrap_longitudes
from hawk.picture.values import PictureError
from hawk.picture.work_folder import ORTHOPHOTOS

JOIN_S: Final = 120.0
"""Seconds between photographs of two drops that are one flight: to land, and to swap a battery, takes longer."""
JOIN_M: Final = 300.0
"""Metres between them."""
LONGEST_NAME: Final = 100
"""Characters of a name that is kept; file systems allow 255 bytes, and letters take up to 4."""
_ID: Final = 16
_DIGEST: Final = 32
_WORLD_FILES: Final = (".jgw", ".jpgw", ".jpegw", ".wld")
_VRT: Final = ".vrt"


@dataclass(frozen=True, slots=True)
class Moment:
    """Place and time of a photograph: degrees, Unix seconds by the camera's clock. ``kind``: camera, lens and drone."""

    kind: str
    time: float
    latitude: float
    longitude: float


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture by the digest of its bytes; without a ``moment`` where its file does not say it."""

    file: FileFacts
    digest: str
    moment: Moment | None = None


@dataclass(frozen=True, slots=True)
class Part:
    """Files of a drop that are of one flight.

    ``title``: name for the flight. ``source``: name of the film or orthophoto, "" for photographs. ``pictures`` decide
    which flight it is; ``others`` go along. ``datum``: latitude and longitude of the middle; None: no file says it.
    ``is_known``: a photograph, film or orthophoto is among them.
    """

    title: str
    source: str
    pictures: tuple[Picture, ...] = field(repr=False)
    others: tuple[FileFacts, ...] = field(default=(), repr=False)
    datum: tuple[float, float] | None = None
    is_known: bool = True

    @property
    def id(self) -> str:
        """Return the id of a flight of these pictures: the same in whatever folder and order they lie."""
        return hashlib.sha256(" ".join(sorted(one.digest for one in self.pictures)).encode()).hexdigest()[:_ID]

    @property
    def moments(self) -> list[Moment]:
        """Return the moments of its photographs by time."""
        return sorted((one.moment for one in self.pictures if one.moment is not None), key=lambda one: one.time)


@dataclass(frozen=True, slots=True)
class _File:
    """A file of a drop with its photograph, where it is one that can be used."""

    facts: FileFacts
    path: Path
    photograph: Photograph | None = None

    @property
    def suffix(self) -> str:
        return self.path.suffix.lower()


@dataclass(slots=True)
class _Group:
    """Files of one flight, as of `Part`."""

    pictures: list[_File]
    others: list[_File] = field(default_factory=list)
    source: str = ""
    is_known: bool = True


class FlightReader:
    """Reads the drops of a folder."""

    def __init__(self, root: Path, lenses: Path | None = None, calibration: CameraModel | None = None) -> None:
        """``lenses``, ``calibration``: as of `hawk.picture.photographs.folder.read_folder`. Raises PictureError."""
        self._root = root
        self._lenses = Lenses(lenses)
        self._calibration = calibration

    def parts(self, drop: Drop) -> list[Part]:
        """Return the flights of a drop, each file in one of them; one that vanished meanwhile is in none."""
        files = [self._file(facts) for facts in drop.files]
        photographs = [one for one in files if one.suffix in SUFFIXES and not _has_world(one, files)]
        sources = _sources(files, has_photographs=bool(photographs))
        groups = [_Group(flight) for flight in _flights(photographs)]
        taken = {one.path for one in photographs}
        for source in sources:
            along = [one for one in files if one.path not in taken and _goes_with(one, source, sources)]
            taken |= {source.path, *(one.path for one in along)}
            groups.append(_Group([source], along, source.path.name))
        if rest := [one for one in files if one.path not in taken]:
            if groups:
                groups[0].others += rest
            else:
                groups.append(_Group(rest, is_known=False))
        parts = [_part(_title(drop, group.pictures, is_one_of_many=len(groups) > 1), group) for group in groups]
        return [part for part in parts if part.pictures]

    def _file(self, facts: FileFacts) -> _File:
        path = self._root / facts.path
        if path.suffix.lower() not in SUFFIXES:
            return _File(facts, path)
        try:
            return _File(facts, path, read_photograph(path, self._lenses, self._calibration))
        except PictureError:  # no reader of tags is installed
            raise
        except Exception:  # a stranger's file: mapping it, in a process of its own, says why
            return _File(facts, path)


def continues(one: Sequence[Moment], other: Sequence[Moment]) -> bool:
    """Return whether photographs of two drops are of one flight: the same camera took two of them shortly one after the
    other, and close to each other.
    """
    return any(
        here.kind == there.kind
        and abs(here.time - there.time) <= JOIN_S
        and apart_m((here.latitude, here.longitude), (there.latitude, there.longitude)) <= JOIN_M
        for here in one
        for there in other
    )


def plain_name(name: str, is_taken: Callable[[str], bool]) -> str:
    """Return a name for a file or folder that no program can mistake: printable, without a leading dot, not taken."""
    shown = "".join(each if each.isprintable() and each not in '/\\:*?"<>|' else "_" for each in name)
    suffix = PurePath(shown).suffix if len(PurePath(shown).suffix) <= 10 else ""
    stem = (shown.removesuffix(suffix).strip(". ") or "_")[: LONGEST_NAME - len(suffix)]
    suffix = suffix.rstrip(". ")
    number, found = 1, stem + suffix
    while is_taken(found):
        number += 1
        found = f"{stem}-{number}{suffix}"
    return found


def _part(title: str, group: _Group) -> Part:
    found = tuple(_pictures(group.pictures))
    moments = [one.moment for one in found if one.moment is not None]
    return Part(title, group.source, found, tuple(one.facts for one in group.others), _middle(moments), group.is_known)


def _sources(files: Sequence[_File], *, has_photographs: bool) -> list[_File]:
    """Return the films and orthophotos: beside photographs a TIFF is none, but a picture of another camera."""
    films = [one for one in files if one.suffix in FILMS]
    virtual = [one for one in files if one.suffix == _VRT]  # the other ones are its tiles
    pictures = [one for one in files if one.suffix in ORTHOPHOTOS and one.suffix not in SUFFIXES]
    with_world = [one for one in files if one.suffix in SUFFIXES and _has_world(one, files)]
    return films + with_world + ([] if has_photographs else virtual or pictures)


def _has_world(one: _File, files: Sequence[_File]) -> bool:
    """Return whether a world file, which places an orthophoto, lies with a picture."""
    return any(each.suffix in _WORLD_FILES and each.path.with_suffix("") == one.path.with_suffix("") for each in files)


def _goes_with(one: _File, source: _File, sources: Sequence[_File]) -> bool:
    """Return whether a file belongs to a film or orthophoto: by its name, or because there is but one."""
    if one in sources:
        return False
    is_alone = len(sources) == 1 and source.suffix == _VRT
    return is_alone or (one.path.parent == source.path.parent and one.path.name.startswith(f"{source.path.stem}."))


def _flights(files: Sequence[_File]) -> list[list[_File]]:
    """Return the photographs of each flight; those that cannot be used are with the flight that has most."""
    by_path = {one.photograph.shot.path: one for one in files if one.photograph is not None}
    groups = flights_of([one.photograph for one in files if one.photograph is not None])
    flights = [[by_path[each.shot.path] for each in group] for group in groups]
    unusable = [one for one in files if one.photograph is None]
    if not flights:
        return [unusable] if unusable else []
    max(flights, key=len).extend(unusable)
    return flights


def _pictures(files: Iterable[_File]) -> Iterator[Picture]:
    for one in files:
        try:
            with one.path.open("rb") as file:
                digest = hashlib.file_digest(file, "sha256").hexdigest()[:_DIGEST]
        except FileNotFoundError:
            continue
        except OSError:  # it is moved with the others, and mapping it says why it cannot be read
            named = f"{one.facts.path} {one.facts.size} {one.facts.changed}".encode("utf-8", "surrogateescape")
            digest = hashlib.sha256(named).hexdigest()[:_DIGEST]
        yield Picture(one.facts, digest, _moment(one.photograph))


def _moment(photograph: Photograph | None) -> Moment | None:
    if photograph is None:
        return None
    shot = photograph.shot
    if shot.time is None:
        return None
    kind = " ".join(str(each) for each in (*photograph.kind, photograph.serial)).encode("utf-8", "replace").decode()
    return Moment(kind, shot.time, shot.latitude, shot.longitude)


def _middle(moments: Sequence[Moment]) -> tuple[float, float] | None:
    if not moments:
        return None
    latitude = float(np.mean([one.latitude for one in moments]))
    longitude = wrap_longitudes(unwrap_longitudes(np.array([one.longitude for one in moments])).mean())
    return round(latitude, 7), round(float(longitude), 7)


def _title(drop: Drop, files: Sequence[_File], *, is_one_of_many: bool) -> str:
    """Return a name for a flight: that of its folder, else the time of its first photograph, else its file's."""
    first = min((one.photograph.shot.time or 0.0 for one in files if one.photograph is not None), default=0.0)
    own = f"{datetime.fromtimestamp(first, UTC):%Y-%m-%d-%H%M%S}" if first else files[0].path.stem
    if drop.name == LOOSE:
        return own
    return f"{drop.name}-{own}" if is_one_of_many else drop.name
