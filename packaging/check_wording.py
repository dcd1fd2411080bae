"""Keep private words out of docs, messages and names: ``python packaging/check_wording.py [--room PATH]``.

Checked are prose (docstrings, comments, Markdown), strings (of Python, of the page, English messages in Fluent) and
names: those that Python code defines, all of TypeScript and style sheets, keys of TOML and JSON, and paths of files.
Code between backticks, quotations in prose and addresses are left alone. The exit status is 1 when something was found.
"""

from __future__ import annotations

import argparse
import ast
import io
import re
import subprocess
import sys
import tokenize
from collections.abc import Iterable, Iterator, Mapping
from enum import Enum
from functools import cache
from pathlib import Path
from typing import Final, NamedTuple

ROOT: Final = Path(__file__).resolve().parent.parent

SUFFIXES: Final = {".css", ".ftl", ".html", ".json", ".md", ".py", ".svg", ".toml", ".ts"}

FOREIGN: Final = ("fr.ftl", "package-lock.json", "package.json", "tsconfig.json")
"""Ends of the names of files in another language, or with names that other programs give."""

EXAMPLES: Final = ("packaging/check_wording.py", "tests/unit/packaging/test_check_wording.py")
"""Files that hold private words as examples: only their prose is read."""

EXCEPTIONS: Final = {
    ("hawk/model/operation.py", "way"): "the key in journals of versions before 0.3, which must be read",
    ("tests/unit/model/test_operation.py", "way"): "the same key",
    ("hawk/lots/plan_files/osm.py", "way"): "OpenStreetMap's element",
    ("hawk/lots/plan_files/section_facts.py", "lay"): "a value of OpenStreetMap",
    ("tests/unit/docs/data/general_words.toml", "way"): 'part of the field term "under way"',
    ("tests/unit/lots/plan_files/files.py", "way"): "the same element",
    ("tests/unit/lots/plan_files/test_osm.py", "way"): "the same element",
    ("tests/unit/lots/plan_files/test_section_shapes.py", "way"): "the same element",
    ("tests/unit/picture/orthophoto/test_outline.py", "way"): "the same element",
    ("tests/unit/formats/test_field_inputs.py", "way"): "the same element",
    ("tests/unit/store/test_recording.py", "tell"): "the method of Python's files",
}
"""File and private word -> the reason for it."""

REPLACEMENTS: Final = {
    ("is none of",): "is not one of, does not belong to",
    ("sees to it that", "see to it that"): "makes sure that",
    ("what lies beside",): "the noun that is beside",
    ("lay", "lays", "laid"): "project, place, store",
    ("tell", "tells", "told"): "report, show, distinguish, state",
    ("way", "ways"): "path, route, direction, distance, manner",
    ("whoever",): "the one who, anyone who",
    ("so many",): "N, the number",
    ("be let",): "may",
    ("heeded",): "ignored, followed",
    ("put aside", "puts aside"): "set aside, rename",
    ("anew",): "again",
}
"""Private words and what to write in their place, everywhere."""

NAME_REPLACEMENTS: Final = {
    ("chore", "chores"): "step, task",
    ("dearer", "dearest"): "costlier, costliest",
    ("inquiry", "inquiries"): "pending request, question",
    ("manner", "manners"): "mode, kind",
    ("untold",): "unreported, unknown",
    ("wish", "wishes"): "request, order",
}
"""Words that are private in names alone, and what to write in their place."""

ALLOWED: Final = {
    "under way": "plain English for a request or flight in progress",
}
"""Phrases with a private word that are the field's own, each with its reason."""

OPENINGS: Final = ("What", "Whoever", "How", "Where", "Whether", "Who")
"""No docstring begins with one of these: a clause is not a noun."""


class Kind(Enum):
    """A kind of text, which says what is looked for in it."""

    DOCSTRING = "docstring"
    PROSE = "prose"
    STRING = "string"
    NAME = "name"
    CLASS = "class"


class Text(NamedTuple):
    """A piece of a file: its first line and its kind."""

    line: int
    text: str
    kind: Kind = Kind.PROSE


class Finding(NamedTuple):
    """One place to reword."""

    path: Path
    line: int
    message: str

    def __str__(self) -> str:
        return f"{self.path}:{self.line}: {self.message}"


def _pattern(phrases: Iterable[str]) -> str:
    """Return the pattern that finds phrases in sentences and as parts of names, small, capitalised and all capitals."""
    patterns = []
    for phrase in phrases:
        first, *others = phrase.split()
        later = "".join(rf"(?:[\s_-]+{word}|{word.capitalize()})" for word in others)
        patterns.append(rf"(?:(?<![A-Za-z]){first}|(?<![A-Z]){first.capitalize()}){later}(?![a-z])")
        capitals = r"[\s_-]+".join(phrase.upper().split())
        patterns.append(rf"(?<![A-Z]){capitals}(?![A-Z])")
    return "|".join(patterns)


def _words(replacements: Mapping[tuple[str, ...], str]) -> list[str]:
    return [word for words in replacements for word in words]


_PRIVATE: Final = re.compile(_pattern(_words(REPLACEMENTS)))
_PRIVATE_NAME: Final = re.compile(_pattern(_words(REPLACEMENTS | NAME_REPLACEMENTS)))
_ALLOWED: Final = re.compile(_pattern(sorted(ALLOWED, key=len, reverse=True)))
_CODE: Final = re.compile(r"``[^`]*``|`[^`]*`|https?://\S+|\]\([^)]*\)")
_QUOTED: Final = re.compile(rf"{_CODE.pattern}|\"[^\"]{{1,200}}\"|“[^”]{{1,200}}”")
_OPENING: Final = re.compile(rf"\s*(?:{'|'.join(OPENINGS)})\b")
_OBSERVER: Final = re.compile(r"\w+Watch")
_LETTERS: Final = re.compile(r"[A-Za-z]+")
_PART: Final = re.compile(r"[A-Z]+(?=[A-Z][a-z])|[A-Z]?[a-z]+|[A-Z]+")
_SINGLE_WORDS: Final = {word for word in _words(REPLACEMENTS | NAME_REPLACEMENTS) if " " not in word}
_PHRASES: Final = [
    re.compile(r"[\s_-]*".join(word.split())) for word in _words(REPLACEMENTS | NAME_REPLACEMENTS) if " " in word
]
"""Each begins with letters, which are found quickly; they are for small letters."""
_SUSPECT: Final = re.compile(rf"[\"']\s*{_OPENING.pattern}|class \w+Watch\b")
_TYPESCRIPT_COMMENT: Final = re.compile(r"/\*.*?\*/|(?<![:\"'`])//[^\n]*", re.DOTALL)
_MARKUP_COMMENT: Final = re.compile(r"/\*.*?\*/|<!--.*?-->", re.DOTALL)
_TOML_STRING: Final = re.compile(r"\"[^\"\n]*\"")
_JSON_KEY: Final = re.compile(r"\"([^\"\n]+)\"\s*:")
_ONE_WORD: Final = re.compile(r"\S*")


def findings(path: Path, source: str) -> Iterator[Finding]:
    """Yield each private word once a line, and each docstring that opens with a clause.

    Args:
        path: The file's path, as it is shown; its suffix says how texts are found in it.
        source: The file's content.
    """
    name = path.as_posix()
    pieces = [Text(1, name, Kind.NAME)]
    if _is_suspect(source):
        pieces += texts(path.suffix, source)
    if name in EXAMPLES:
        pieces = [piece for piece in pieces if piece.kind in (Kind.DOCSTRING, Kind.PROSE)]
    found = dict.fromkeys(place for piece in pieces for place in _in_text(piece))
    for line, word, message in found:
        if (name, word) not in EXCEPTIONS:
            yield Finding(path, line, message)


def texts(suffix: str, source: str) -> Iterator[Text]:
    """Yield the texts of a file with that suffix: everything that is written for people, and names."""
    match suffix:
        case ".py":
            yield from _python_texts(ast.parse(source))
            yield from _python_comments(source)
        case ".md":
            yield Text(1, source)
        case ".toml":
            yield from _toml_texts(source)
        case ".ts":
            yield from _split(source, _TYPESCRIPT_COMMENT)
        case ".css" | ".html" | ".svg":
            yield from _split(source, _MARKUP_COMMENT)
        case ".json":
            for found in _JSON_KEY.finditer(source):
                yield Text(source.count("\n", 0, found.start()) + 1, found.group(1), Kind.NAME)
        case ".ftl":
            for number, line in enumerate(source.splitlines(), 1):
                yield Text(number, line, Kind.PROSE if line.startswith("#") else Kind.NAME)


def checked_files(root: Path, rooms: list[str]) -> list[Path]:
    """Return the files to check, relative to ``root``: those of the rooms, or all."""
    listed = subprocess.run(
        ["git", "ls-files", "--", *(rooms or ["."])], cwd=root, capture_output=True, text=True, check=True
    )
    paths = (Path(line) for line in listed.stdout.splitlines())
    return [
        path
        for path in paths
        if path.suffix in SUFFIXES and not path.name.endswith(FOREIGN) and (root / path).is_file()
    ]


def _is_suspect(source: str) -> bool:
    """Return whether a file may hold something to reword: parsing the others would take most of the time."""
    small = source.lower()
    return (
        any(map(_is_private, set(_LETTERS.findall(source))))
        or _SUSPECT.search(source) is not None
        or any(phrase.search(small) for phrase in _PHRASES)
    )


@cache
def _is_private(letters: str) -> bool:
    return not _SINGLE_WORDS.isdisjoint(part.lower() for part in _PART.findall(letters))


def _in_text(piece: Text) -> Iterator[tuple[int, str, str]]:
    """Yield line, word and message of each finding in one text."""
    text, kind = piece.text, piece.kind
    if kind is Kind.DOCSTRING and (opening := _OPENING.match(text)):
        word = opening.group().strip()
        yield piece.line, word, f"a docstring begins with a verb or a noun, not with '{word}'"
    if kind is Kind.CLASS and _OBSERVER.fullmatch(text):
        yield piece.line, "watch", f"'{text}': a reading observes, a rule decides, a keeper stores; say which it is"
    is_name = kind in (Kind.NAME, Kind.CLASS)
    quoted = _QUOTED if kind in (Kind.DOCSTRING, Kind.PROSE) else _CODE
    bare = _ALLOWED.sub(_blank, quoted.sub(_blank, text))
    for found in (_PRIVATE_NAME if is_name else _PRIVATE).finditer(bare):
        line = piece.line + bare.count("\n", 0, found.start())
        where = f" in '{text}'" if is_name and _ONE_WORD.fullmatch(text) and text != found.group() else ""
        word = found.group().lower()
        yield line, word, f"'{found.group()}'{where}: say {_replacement(word)}"


def _python_texts(tree: ast.Module) -> Iterator[Text]:
    """Yield docstrings of modules, classes, functions and attributes, all other strings, and the names defined."""
    docstrings = set()
    for node in ast.walk(tree):  # breadth first: a statement comes before its value
        match node:
            case ast.Expr(value=ast.Constant(value=str(text)) as constant):
                docstrings.add(constant)
                yield Text(node.lineno, text, Kind.DOCSTRING)
            case ast.Constant(value=str(text)) if node not in docstrings:
                yield Text(node.lineno, text, Kind.NAME if _ONE_WORD.fullmatch(text) else Kind.STRING)
            case ast.ClassDef(name=name):
                yield Text(node.lineno, name, Kind.CLASS)
            case (
                ast.FunctionDef(name=name)
                | ast.AsyncFunctionDef(name=name)
                | ast.arg(arg=name)
                | ast.keyword(arg=str(name))
                | ast.Name(id=name, ctx=ast.Store())
                | ast.Attribute(attr=name, ctx=ast.Store())
                | ast.alias(asname=str(name))
                | ast.ExceptHandler(name=str(name))
                | ast.MatchAs(name=str(name))
                | ast.MatchStar(name=str(name))
            ):
                yield Text(node.lineno, name, Kind.NAME)


def _python_comments(source: str) -> Iterator[Text]:
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            yield Text(token.start[0], token.string)


def _toml_texts(source: str) -> Iterator[Text]:
    """Yield keys as names, comments as prose."""
    for number, line in enumerate(source.splitlines(), 1):
        keys, _, comment = _TOML_STRING.sub("", line).partition("#")
        yield Text(number, keys, Kind.NAME)
        yield Text(number, comment)


def _split(source: str, comment: re.Pattern[str]) -> Iterator[Text]:
    """Yield each comment as prose, and the rest as names."""
    for found in comment.finditer(source):
        yield Text(source.count("\n", 0, found.start()) + 1, found.group())
    yield Text(1, comment.sub(_blank, source), Kind.NAME)


def _blank(found: re.Match[str]) -> str:
    """Return the match with everything but its line breaks blanked, so that line numbers hold."""
    return re.sub(r"[^\n]", " ", found.group())


def _replacement(word: str) -> str:
    """Return what to write in place of a word that was found, in any form."""
    plain = re.sub(r"[^a-z]", "", word)
    both = REPLACEMENTS | NAME_REPLACEMENTS
    return next(say for words, say in both.items() if plain in (each.replace(" ", "") for each in words))


def main(arguments: list[str] | None = None) -> int:
    """Print every finding; return the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("--room", action="append", default=[], metavar="PATH", help="check only this folder or file")
    rooms = parser.parse_args(arguments).room
    count = 0
    for path in checked_files(ROOT, rooms):
        for finding in findings(path, (ROOT / path).read_text(encoding="utf-8")):
            print(finding)
            count += 1
    if count:
        print(f"{count} places to reword; docs/glossary.md has the project's terms", file=sys.stderr)
    return 1 if count else 0


if __name__ == "__main__":
    sys.exit(main())
