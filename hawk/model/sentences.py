"""Sentences of the program: English text that still knows its code and its values.

A program that shows them in another language (the operator's page) has its own words for each code and puts the values
in. Logs, journals and other clients read the text as it is.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, reduce
from string import Formatter
from typing import LiteralString

Value = str | int | float
"""A value in a sentence: a name or quoted words, a `Sentence`, or a number. Numbers are formatted by the template."""

LONGEST_CODE = 60
_FORMAT = re.compile(r"z?\.(\d)f|g|d|")


class Sentence(str):
    """English text with the code and the values that it was made of. It compares as its text."""

    __slots__ = ("code", "values")
    code: str
    """Name of the sentence, the same in every language: `code_of` its English template."""
    values: Mapping[str, Value]
    """Values by name; numbers are rounded as the text shows them."""


def say(template: LiteralString, /, **values: Value) -> Sentence:
    """Return the sentence of a template.

    ``template`` is its English text with the values in braces, as for `str.format`: ``{name}``, ``{away:.1f}``,
    ``{height:g}``. A full stop after a value that ends a sentence itself is left out. Raises ValueError for a value
    that is missing or that the template does not use.
    """
    known = _read(template)
    if known.formats.keys() != values.keys():
        raise ValueError(f"{template}: takes {sorted(known.formats)}, given are {sorted(values)}")
    return _said(known, values) if values else _constant(template)


def _said(known: _Template, values: Mapping[str, Value]) -> Sentence:
    said = Sentence(_filled(known, values))
    said.code = known.code
    said.values = {name: _rounded(value, known.formats[name]) for name, value in values.items()}
    return said


@cache
def _constant(template: str) -> Sentence:
    """Return the sentence of a template without values: it is always the same one."""
    return _said(_read(template), {})


def code_of(template: str) -> str:
    """Return a template's code: its words and the names of its values, in small letters, with hyphens between them.

    A code has `LONGEST_CODE` characters at most, whole words.
    """
    words = re.findall(r"[a-z][a-z0-9]*|[0-9]+", re.sub(r":[^{}]*}", "}", template).lower().replace("_", " "))
    code = "-".join(words)
    return code if len(code) <= LONGEST_CODE else code[: LONGEST_CODE + 1].rpartition("-")[0]


def joined(*sentences: str) -> str:
    """Return sentences one after the other; empty ones are left out. Alone, a sentence stays what it is."""
    return _chain(sentences, lambda first, second: say("{first} {second}", first=first, second=second))


def series(*parts: str) -> str:
    """Return parts with commas between them; empty ones are left out. Alone, a part stays what it is."""
    return _chain(parts, lambda one, other: say("{one}, {other}", one=one, other=other))


def semicolons(*parts: str) -> str:
    """Return parts with semicolons between them; empty ones are left out. Alone, a part stays what it is."""
    return _chain(parts, lambda former, latter: say("{former}; {latter}", former=former, latter=latter))


def _chain(parts: Sequence[str], two: Callable[[str, str], str]) -> str:
    return reduce(two, filter(None, parts)) if any(parts) else ""


def sentence(text: str) -> str:
    """Return the text as a sentence: one full stop at its end."""
    stripped = text.strip()
    if not stripped or stripped[-1] in ".!?":
        return text if isinstance(text, Sentence) else stripped
    return say("{text}.", text=text if isinstance(text, Sentence) else stripped)


def words_of(error: BaseException) -> str:
    """Return the words that an error was raised with; a `Sentence` keeps its code, which `str` of the error loses."""
    return error.args[0] if error.args and isinstance(error.args[0], str) else str(error)


def parts_of(text: str) -> Iterator[Sentence]:
    """Yield the sentence and those among its values, the outer one first."""
    if isinstance(text, Sentence):
        yield text
        for value in text.values.values():
            if isinstance(value, str):
                yield from parts_of(value)


@dataclass(frozen=True)
class _Template:
    code: str
    formats: Mapping[str, str]
    pieces: tuple[tuple[str, str | None], ...]
    """Text, and the name of the value behind it; None at the end."""


@cache
def _read(template: str) -> _Template:
    parsed = tuple(Formatter().parse(template))
    formats = {name: spec or "" for _text, name, spec, _conversion in parsed if name is not None}
    for name, spec in formats.items():
        if _FORMAT.fullmatch(spec) is None:
            raise ValueError(f"{{{name}:{spec}}}: use .Nf, g or d")
    return _Template(code_of(template), formats, tuple((text, name) for text, name, _spec, _conversion in parsed))


def _filled(template: _Template, values: Mapping[str, Value]) -> str:
    text = ""
    for words, name in template.pieces:
        is_stopped = text.endswith((".", "!", "?"))
        text += words.removeprefix(".") if is_stopped else words
        text += "" if name is None else format(values[name], template.formats[name])
    return text.strip()


def _rounded(value: Value, spec: str) -> Value:
    if isinstance(value, str) or not math.isfinite(value):
        return value if isinstance(value, str) else str(value)
    digits = _digits(spec)
    if digits is not None:
        rounded = round(float(value), digits)
        return int(rounded) if rounded.is_integer() else rounded
    return float(f"{value:g}") if spec == "g" and isinstance(value, float) else value


@cache
def _digits(spec: str) -> int | None:
    found = _FORMAT.fullmatch(spec)
    return int(found[1]) if found is not None and found[1] is not None else None
