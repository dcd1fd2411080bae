"""Photographs that show no light that people see: thermal, near infrared, single bands of multispectral cameras.

Their greys and colours are temperatures or one band, in which lines of paint and cars look other than the network knows
them. What names such a picture is one of: DJI's ``ImageSource``; Pix4D's ``Camera:BandName``; the maker; a name as DJI
gives it (``DJI_0001_T.JPG``) beside the size of a thermal sensor.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final

from hawk.picture.photographs.exif import Exif

_SOURCES: Final = ("drone-dji:ImageSource", "drone:ImageSource")
_BANDS: Final = re.compile(r"LWIR|thermal|nir|infrared|red ?edge|monochrom", re.IGNORECASE)
_COLOURS: Final = frozenset(("red", "green", "blue"))
_THERMAL_MAKERS: Final = re.compile(r"flir|workswell|infratec", re.IGNORECASE)
_THERMAL_MODELS: Final = re.compile(r"\b(xt2|xtr?|zenmuse ?xt|vue|tau ?2|boson|altum-pt)\b", re.IGNORECASE)
_NAMES: Final = re.compile(r".*_(t|ir|thrm)\.jpe?g", re.IGNORECASE)
_MOST_THERMAL: Final = 1280 * 1024
"""Pixels of the largest thermal sensor on a drone; cameras for light have more."""


def other_light(name: str, tags: Mapping[str, str], exif: Exif, size: tuple[int, int]) -> str:
    """Return what a photograph shows in place of light that people see, "" where nothing says so."""
    source = next((tags[tag] for tag in _SOURCES if tag in tags), "")
    if "infrared" in source.casefold() or "thermal" in source.casefold():
        return "is thermal (infrared)"
    band = [part.strip() for part in tags.get("Camera:BandName", "").split(",") if part.strip()]
    if any(_BANDS.search(part) for part in band) or (len(band) == 1 and band[0].casefold() in _COLOURS):
        return f"is the band {', '.join(band)} alone, no picture in colours"
    is_small = size[0] * size[1] <= _MOST_THERMAL
    if is_small and (_THERMAL_MAKERS.search(exif.make) or _THERMAL_MODELS.search(exif.model)):
        return f"is thermal (infrared), by a {exif.make} {exif.model}".rstrip()
    if is_small and not source and exif.make and _NAMES.fullmatch(name):
        return "is thermal (infrared), by its name and size"
    return ""
