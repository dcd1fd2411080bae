"""XMP packets as one table of tags (ISO 16684-1).

A maker may write a tag as an attribute or as an element, a structure as a nested description, a list as ``rdf:Seq``.
"""

from __future__ import annotations

import io
import math
from collections.abc import Mapping
from typing import Any, Final

from defusedxml import DefusedXmlException
from defusedxml.ElementTree import ParseError, iterparse

_START, _END = b"<x:xmpmeta", b"</x:xmpmeta>"
_SYNTAX: Final = ("rdf:", "x:", "xml:")
_MOST: Final = 1 << 20
"""Bytes: a packet is one segment, which has 65,533 at most."""


def read_xmp(packet: bytes) -> dict[str, str]:
    """Return the tags of a packet by their names with the prefix that the file uses, ``drone-dji:GimbalYawDegree``.

    A part of a structure is named behind it, ``drone-skydio:CameraOrientationNED/drone-skydio:Yaw``; items of a list
    have commas between. Raises ValueError when the packet is no XML.
    """
    start, end = packet.find(_START), packet.rfind(_END)
    if start < 0 or end < start or len(packet) > _MOST:
        return {}
    try:
        return _tags(packet[start : end + len(_END)])
    except (ParseError, DefusedXmlException) as error:
        raise ValueError(f"its XMP cannot be read ({error})") from None


def _tags(packet: bytes) -> dict[str, str]:
    prefixes = {"http://www.w3.org/XML/1998/namespace": "xml"}
    found: dict[str, str] = {}
    path: list[str] = [""]
    for event, item in iterparse(io.BytesIO(packet), events=("start-ns", "start", "end"), forbid_dtd=True):
        if event == "start-ns":
            prefixes.setdefault(item[1], item[0])
        elif event == "start":
            path.append(_below(path[-1], _named(item.tag, prefixes)))
            for name, value in item.attrib.items():
                at = _below(path[-1], _named(name, prefixes))
                if at != path[-1]:
                    found.setdefault(at, value.strip())
        else:
            at, text = path.pop(), (item.text or "").strip()
            if at and text:
                is_item = _named(item.tag, prefixes) == "rdf:li" and at in found
                found[at] = f"{found[at]},{text}" if is_item else text
    return found


def _named(tag: str, prefixes: Mapping[str, str]) -> str:
    """Return ``prefix:name`` of ``{namespace}name``."""
    space, _, name = tag[1:].partition("}") if tag.startswith("{") else ("", "", tag)
    prefix = prefixes.get(space, "")
    return f"{prefix}:{name}" if prefix else name


def _below(path: str, name: str) -> str:
    if name.startswith(_SYNTAX):
        return path
    return f"{path}/{name}" if path else name


def number(tags: Mapping[str, Any], *names: str) -> float | None:
    """Return the first of these tags that holds a finite number, which may be a fraction (``11485529/262144``)."""
    for name in names:
        text = str(tags.get(name, ""))
        above, _, below = text.partition("/")
        try:
            value = float(above) / float(below or 1.0)
        except (ValueError, ZeroDivisionError):
            continue
        if math.isfinite(value):
            return value
    return None


def numbers(tags: Mapping[str, str], name: str) -> tuple[float, ...]:
    """Return the numbers of a tag with commas or spaces between, () where one of them is none."""
    parts = tags.get(name, "").replace(",", " ").split()
    values = [number({"": part}, "") for part in parts]
    return () if None in values else tuple(value for value in values if value is not None)
