"""Names are made of the glossary's nouns and of a closed list of general words, which grows on purpose alone.

Read: modules of `hawk`, tables of the store, keys of messages and of the API, public classes of the rooms of lots.
"""

from __future__ import annotations

import ast
import re
import tomllib
from collections.abc import Iterator
from typing import Any

import pytest

from hawk.comm.protocol.commands import schema as messages
from hawk.lots.storage import schema as store
from hawk.web.v1.openapi import document
from hawk.web.v1.table import OPERATIONS
from tests.unit.docs.names import ROOT

ROOMS = ("lots", "stats", "exports", "picture", "results", "web/v1")
WORDS_FILE = ROOT / "tests/unit/docs/data/general_words.toml"
LIST = {group: set(text.split()) for group, text in tomllib.loads(WORDS_FILE.read_text(encoding="utf-8")).items()}
MOST_TERMS = 130
"""Terms of the glossary: more are no longer a language that a reader learns."""


def words(name: str) -> list[str]:
    """Return the words of a name, in small letters and without the plural's s."""
    found = re.findall(r"[A-Z]+(?=[A-Z][a-z])|[A-Z]?[a-z]+|[A-Z]+", name)
    return [singular(each.lower()) for each in found]


def singular(word: str) -> str:
    """Return a noun without its plural; other words that end in s keep it."""
    if word in {"always", "canvas", "lens", "alias"}:
        return word
    if word.endswith("ies") and len(word) > 4:
        return word[:-3] + "y"
    if word.endswith(("sses", "ches", "shes", "xes", "nses")):
        return word[:-2]
    return word[:-1] if word.endswith("s") and not word.endswith(("ss", "us", "is")) and len(word) > 3 else word


def terms() -> list[str]:
    """Return the terms that the glossary explains."""
    found = re.findall(r"^- \*\*(.+?)\*\*:", (ROOT / "docs/glossary.md").read_text(encoding="utf-8"), re.MULTILINE)
    return [term for each in found for term in each.split(", ")]


def modules() -> Iterator[str]:
    for path in (ROOT / "hawk").rglob("*.py"):
        if "page" not in path.relative_to(ROOT / "hawk").parts[:2]:
            yield path.parent.name if path.stem == "__init__" else path.stem


def classes() -> Iterator[str]:
    for room in ROOMS:
        for path in (ROOT / "hawk" / room).rglob("*.py"):
            body = ast.parse(path.read_text(encoding="utf-8")).body
            yield from (each.name for each in body if isinstance(each, ast.ClassDef) and not each.name.startswith("_"))


def tables() -> Iterator[str]:
    text = (ROOT / store.__file__).read_text(encoding="utf-8")
    calls = (each for each in ast.walk(ast.parse(text)) if isinstance(each, ast.Call))
    for call in calls:
        first = call.args[0] if call.args else None
        if ast.unparse(call.func).split(".")[-1] == "Table" and isinstance(first, ast.Constant):
            yield str(first.value)


def keys(given: Any) -> Iterator[str]:
    match given:
        case dict():
            yield from given.get("properties", {})
            for each in given.values():
                yield from keys(each)
        case list():
            for each in given:
                yield from keys(each)


KINDS = ("module", "class", "table", "key")
GLOSSARY = {word for term in terms() for word in words(term)}
KNOWN = GLOSSARY.union(*LIST.values())


@pytest.fixture(scope="module")
def names() -> dict[str, set[str]]:
    """The names by `KINDS`: all sources of the rooms are read."""
    api = document(OPERATIONS, "http://DRONE:3000/api/v1", "1")
    every = (modules(), classes(), tables(), [*keys(messages()), *keys(api)])
    return {kind: set(found) for kind, found in zip(KINDS, every, strict=True)}


def test_each_kind_of_name_is_read(names: dict[str, set[str]]) -> None:
    assert all(len(found) > 5 for found in names.values()), {kind: len(found) for kind, found in names.items()}


def test_the_glossary_is_a_short_list_and_explains_each_term_once() -> None:
    found = terms()
    assert len(found) <= MOST_TERMS, len(found)
    assert len(found) == len(set(found)), sorted({each for each in found if found.count(each) > 1})


@pytest.mark.parametrize("kind", KINDS)
def test_names_are_made_of_known_words(names: dict[str, set[str]], kind: str) -> None:
    unknown = {name: left for name in sorted(names[kind]) if (left := sorted(set(words(name)) - KNOWN))}
    assert not unknown, "use a term of docs/glossary.md, or add the word to general_words.toml on purpose"


@pytest.mark.parametrize("kind", ["module", "class", "table"])
def test_a_name_ends_in_a_noun(names: dict[str, set[str]], kind: str) -> None:
    nouns = KNOWN - LIST["qualifiers"]
    wrong = sorted(name for name in names[kind] if (found := words(name)) and found[-1] not in nouns)
    assert not wrong, "its last word is no noun: name the thing"


def test_every_general_word_is_used_and_stands_once(names: dict[str, set[str]]) -> None:
    used = {word for found in names.values() for name in found for word in words(name)}
    listed = [word for group in LIST.values() for word in group]
    assert not sorted(set(listed) - used), "no name has these words any more: remove them from general_words.toml"
    ends = {found[-1] for kind in ("module", "class", "table") for name in names[kind] if (found := words(name))}
    assert not sorted(LIST["endings"] - ends), "no name ends in these any more: make them qualifiers, or remove them"
    assert not sorted({word for word in listed if listed.count(word) > 1}), "these stand in two groups"
    assert not sorted(set(listed) & GLOSSARY), "the glossary explains these"
