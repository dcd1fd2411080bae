"""Values of a plan that a file holds: the drawing as its reader finds it, its stalls and sections."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from hawk.formats.text import decoded
from hawk.lots.plan.values import SectionKind
from hawk.lots.values import LotInputError
from hawk.model.poses import Ring

Floats = NDArray[np.float64]

LARGEST_BYTES: Final = 32_000_000
"""A file of 20,000 stalls that QGIS writes has 7 to 16 MB."""
LARGEST_UNPACKED_BYTES: Final = 64_000_000
"""The same for the file within an archive, however small that is."""
MOST_FEATURES: Final = 200_000
"""Features of one file, with those that are no stalls."""
MOST_STALLS: Final = 50_000
MOST_SECTIONS: Final = 2_000
"""Sections of one file: each survey of the lot counts vehicles in all of them."""
MOST_LEFT_OUT: Final = 200
"""Features that are named as left out; the others are counted."""


@dataclass(frozen=True, slots=True)
class Asked:
    """The choices of a person about a file; "" leaves one to the file.

    ``layer``: the only one to read. ``units``: of a drawing, a key of `dxf.UNITS`. ``label``: the name of the property
    with the labels. ``crs``: the system of coordinates, as EPSG:25832.
    """

    layer: str = ""
    units: str = ""
    label: str = ""
    crs: str = ""


@dataclass(frozen=True, slots=True)
class Drawn:
    """A closed outline of a drawing. ``name``: where it stands in the file; ``ring``: corners (N, 2) of x and y.

    ``kind``: of `hawk.lots.plan.kinds`; None where the file says none.
    """

    name: str
    ring: Floats = field(repr=False)
    label: str = ""
    kind: str | None = None


@dataclass(frozen=True, slots=True)
class Strip:
    """A strip on a side of a line, as one goes along it: ``width`` metres wide, its near edge ``near`` metres off."""

    side: Literal["left", "right"]
    width: float
    near: float = 0.0


@dataclass(frozen=True, slots=True)
class SectionFacts:
    """Properties of a section as a file says them; None, and "" of ``title`` and ``id``: it does not.

    ``title``: its name. ``metres``: length along the kerb; ``place_m``: metres of it for one vehicle. ``strip``: where
    it lies beside a line; None for an area. ``is_lot``: the file calls it a car park, which may have stalls too.
    """

    title: str = ""
    id: str = ""
    kind: SectionKind | None = None
    capacity: int | None = None
    is_capacity_given: bool = True
    metres: float | None = None
    place_m: float | None = None
    note: str | None = None
    strip: Strip | None = None
    is_lot: bool = False


@dataclass(frozen=True, slots=True)
class DrawnSection:
    """A section of a drawing. ``name``: where it stands in the file; ``places``: x and y (N, 2) of its ring or line."""

    name: str
    places: Floats = field(repr=False)
    facts: SectionFacts


@dataclass(frozen=True, slots=True)
class LeftOut:
    """A feature that is not read, or something of it: ``name`` as in `Drawn`, and ``reason`` with the remedy."""

    name: str
    reason: str


@dataclass(slots=True)
class Notes:
    """Collects what is left out, the first `MOST_LEFT_OUT` by name, ``count`` of all, and what is ``assumed``."""

    left_out: list[LeftOut] = field(default_factory=list)
    count: int = 0
    assumed: list[str] = field(default_factory=list)

    def add(self, name: str, reason: str) -> None:
        """Note a feature, or something of it, that is left out."""
        self.count += 1
        if len(self.left_out) < MOST_LEFT_OUT:
            self.left_out.append(LeftOut(name[:120], reason[:400]))


@dataclass(frozen=True, slots=True)
class Drawing:
    """All outlines and sections of a file. x is east or the longitude, y north or the latitude.

    ``crs``: the system that the file names; "" for none. ``metres``: in a unit of x and y, of a drawing of its own.
    ``layers``: the layers with outlines, each with the number of them.
    """

    format: str
    drawn: tuple[Drawn, ...]
    crs: str = ""
    metres: float = 1.0
    layers: tuple[tuple[str, int], ...] = ()
    sections: tuple[DrawnSection, ...] = ()


@dataclass(frozen=True, slots=True)
class FileFeature:
    """A stall of a file: ``name``, ``label`` and ``kind`` as in `Drawn`; the shape as in `hawk.lots.plan.values`."""

    name: str
    label: str
    kind: str | None
    north: float
    east: float
    angle: float
    width: float
    length: float


@dataclass(frozen=True, slots=True)
class FileSection:
    """A section of a file: ``name`` as in `DrawnSection`, its ring in the file's frame, metres north and east.

    ``length_m``: along the kerb, as drawn or as the file says. ``facts``: without the strip, which made the ring.
    """

    name: str
    ring: Ring = field(repr=False)
    length_m: float
    facts: SectionFacts


@dataclass(frozen=True, slots=True)
class PlanFile:
    """The stalls and sections of a file in one frame, metres north and east.

    With ``datum`` (latitude, longitude) the frame is about that place, north up; without it the frame is that of the
    drawing, about ``origin`` (x, y), a unit of which has ``metres``. ``left_out_count``: of all that ``left_out``
    names some of. ``accuracy``: metres by which the conversion to WGS-84 may err; None where that is not known.
    ``assumed``: sentences on what the file does not say.
    """

    format: str
    stalls: tuple[FileFeature, ...] = field(repr=False)
    crs: str = ""
    datum: tuple[float, float] | None = None
    origin: tuple[float, float] = (0.0, 0.0)
    metres: float = 1.0
    layers: tuple[tuple[str, int], ...] = ()
    left_out: tuple[LeftOut, ...] = ()
    left_out_count: int = 0
    accuracy: float | None = None
    sections: tuple[FileSection, ...] = field(default=(), repr=False)
    assumed: tuple[str, ...] = ()

    def places(self) -> Floats:
        """Return the middles of all stalls and the corners of all sections, (N, 2): north, east."""
        corners = [corner for section in self.sections for corner in section.ring]
        return np.concatenate([self.shapes()[:, :2], np.array(corners, np.float64).reshape(-1, 2)])

    def shapes(self) -> Floats:
        """Return the shapes of all stalls, (N, 5): north, east, angle, width, length."""
        rows = [(each.north, each.east, each.angle, each.width, each.length) for each in self.stalls]
        return np.array(rows, np.float64).reshape(-1, 5)


Facts = dict[str, Any]
"""Properties of a feature by their names, as the file writes them."""


def text_of(data: bytes) -> str:
    """Return the text of a file. Raises LotInputError."""
    try:
        return decoded(data)
    except UnicodeDecodeError as error:
        raise LotInputError("file", f"is no text in UTF-8 ({error.reason}): save it again in UTF-8") from None
