"""Sentences of the program: English text that still knows its code and its values.

A program that shows them in another language (the operator's page) has its own words for each code and puts the values
in. Logs, journals and other clients read the text as it is.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from string import Formatter
from typing import LiteralString

Value = str | int | float
"""A value in a sentence: a name or quoted words, a `Sentence`, or a number. Numbers are formatted by the template."""

CODE = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*")
_DECIMALS = re.compile(r"z?\.(\d)f|g|d|")
_DOUBLE_STOP = re.compile(r"([.!?])\.")


class Sentence(str):
    """English text with the code and the values that it was made of. It compares as its text."""

    __slots__ = ("code", "values")
    code: str
    """Name of the sentence, the same in every language."""
    values: Mapping[str, Value]
    """Values by name; numbers are rounded as the text shows them."""


def say(code: LiteralString, template: LiteralString, /, **values: Value) -> Sentence:
    """Return the sentence of a code.

    ``template`` is its English text with the values in braces, as for `str.format`: ``{name}``, ``{away:.1f}``,
    ``{height:g}``. A full stop after a value that ends a sentence itself is left out. Raises KeyError for a value that
    is not given, ValueError for one that the template does not use.
    """
    used = dict(_fields(template))
    if used.keys() != values.keys():
        raise ValueError(f"{code}: the template uses {sorted(used)}, given are {sorted(values)}")
    said = Sentence(_DOUBLE_STOP.sub(r"\1", template.format_map(values)).strip())
    said.code = code
    said.values = {name: _rounded(value, used[name]) for name, value in values.items()}
    return said


def joined(*sentences: str) -> str:
    """Return sentences one after the other; empty ones are left out. Alone, a sentence stays what it is."""
    first, *rest = [each for each in sentences if each] or [""]
    for second in rest:
        first = say("two-sentences", "{first} {second}", first=first, second=second)
    return first


def sentence(text: str) -> str:
    """Return the text as a sentence: one full stop at its end."""
    stripped = text.strip()
    if not stripped or stripped[-1] in ".!?":
        return text if isinstance(text, Sentence) else stripped
    return say("full-stop", "{text}.", text=text if isinstance(text, Sentence) else stripped)


def parts_of(text: str) -> Iterator[Sentence]:
    """Yield the sentence and those among its values, the outer one first."""
    if isinstance(text, Sentence):
        yield text
        for value in text.values.values():
            if isinstance(value, str):
                yield from parts_of(value)


def _fields(template: str) -> Iterator[tuple[str, str]]:
    for _text, name, spec, _conversion in Formatter().parse(template):
        if name is not None:
            if _DECIMALS.fullmatch(spec or "") is None:
                raise ValueError(f"{{{name}:{spec}}}: use .Nf, g or d")
            yield name, spec or ""


def _rounded(value: Value, spec: str) -> Value:
    if isinstance(value, str) or not math.isfinite(value):
        return value if isinstance(value, str) else str(value)
    found = _DECIMALS.fullmatch(spec)
    if found is not None and found[1] is not None:
        rounded = round(float(value), int(found[1]))
        return int(rounded) if rounded.is_integer() else rounded
    return float(f"{value:g}") if spec == "g" and isinstance(value, float) else value
