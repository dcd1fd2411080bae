"""Keep private words out of docstrings, comments and documents: ``python packaging/check_wording.py [--room PATH]``.

Checked are Python docstrings and comments, comments of TOML, TypeScript and Fluent, and Markdown. Code between
backticks and quotations between double quotes are left alone. The exit status is 1 when something was found.
"""

from __future__ import annotations

import argparse
import ast
import io
import re
import subprocess
import sys
import tokenize
from collections.abc import Iterator
from pathlib import Path
from typing import Final, NamedTuple

ROOT: Final = Path(__file__).resolve().parent.parent

NOT_YET_CLEAN: Final[tuple[str, ...]] = ()
"""Rooms that the check skips unless ``--room`` names them. It shrinks, never grows."""

SUFFIXES: Final = {".py", ".md", ".toml", ".ts", ".ftl"}

REPLACEMENTS: Final = {
    r"lays?|laid": "project, place, store",
    r"tells?|told": "report, show, distinguish, state",
    r"ways?": "path, route, direction, distance, manner",
    r"whoever": "the one who, anyone who",
    r"so many": "N, the number",
    r"be let": "may",
    r"heeded": "ignored, followed",
    r"puts? aside": "set aside, rename",
    r"anew": "again",
}
"""Private words (regular expressions) and what to write in their place."""

ALLOWED: Final = {
    "under way": "plain English for a request or flight in progress",
}
"""Phrases with a private word that are the field's own, each with its reason."""

OPENINGS: Final = ("What", "Whoever", "How", "Where", "Whether", "Who")
"""No docstring begins with one of these: a clause is not a noun."""

_PRIVATE: Final = re.compile(rf"\b(?:{'|'.join(f'(?:{words})' for words in REPLACEMENTS)})\b", re.IGNORECASE)
_ALLOWED: Final = re.compile(rf"\b(?:{'|'.join(sorted(ALLOWED, key=len, reverse=True))})\b", re.IGNORECASE)
_QUOTED: Final = re.compile(r"``[^`]*``|`[^`]*`|\"[^\"]{1,200}\"|“[^”]{1,200}”|https?://\S+|\]\([^)]*\)")
_OPENING: Final = re.compile(rf"\s*(?:{'|'.join(OPENINGS)})\b")
_TYPESCRIPT_COMMENT: Final = re.compile(r"/\*.*?\*/|(?<![:\"'`])//[^\n]*", re.DOTALL)


class Text(NamedTuple):
    """A piece of prose: its first line in the file, and whether it is a docstring."""

    line: int
    text: str
    is_docstring: bool = False


class Finding(NamedTuple):
    """One place to reword."""

    path: Path
    line: int
    message: str

    def __str__(self) -> str:
        return f"{self.path}:{self.line}: {self.message}"


def findings(path: Path, source: str) -> Iterator[Finding]:
    """Yield each private word and each docstring that opens with a clause.

    Args:
        path: The file's path, as it is shown; its suffix says how prose is found in it.
        source: The file's content.
    """
    for piece in prose(path, source):
        if piece.is_docstring and (opening := _OPENING.match(piece.text)):
            message = f"a docstring begins with a verb or a noun, not with '{opening.group().strip()}'"
            yield Finding(path, piece.line, message)
        bare = _ALLOWED.sub(_blank, _QUOTED.sub(_blank, piece.text))
        for found in _PRIVATE.finditer(bare):
            line = piece.line + bare.count("\n", 0, found.start())
            yield Finding(path, line, f"'{found.group()}': say {_replacement(found.group())}")


def prose(path: Path, source: str) -> Iterator[Text]:
    """Yield the texts of a file that are written for people."""
    match path.suffix:
        case ".py":
            yield from _docstrings(source)
            yield from _python_comments(source)
        case ".md":
            yield Text(1, source)
        case ".toml":
            yield from _toml_comments(source)
        case ".ts":
            for found in _TYPESCRIPT_COMMENT.finditer(source):
                yield Text(source.count("\n", 0, found.start()) + 1, found.group())
        case ".ftl":
            for number, line in enumerate(source.splitlines(), 1):
                if line.startswith("#"):
                    yield Text(number, line)


def checked_files(root: Path, rooms: list[str]) -> list[Path]:
    """Return the files to check, relative to ``root``: those of the rooms, or all outside NOT_YET_CLEAN."""
    listed = subprocess.run(
        ["git", "ls-files", "--", *(rooms or ["."])], cwd=root, capture_output=True, text=True, check=True
    )
    skipped = () if rooms else NOT_YET_CLEAN
    paths = (Path(line) for line in listed.stdout.splitlines())
    return [
        path
        for path in paths
        if path.suffix in SUFFIXES
        and (root / path).is_file()
        and not any(path.is_relative_to(room) for room in skipped)
    ]


def _docstrings(source: str) -> Iterator[Text]:
    """Yield every string that stands as a statement: docstrings of modules, classes, functions and attributes."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            yield Text(node.lineno, node.value.value, is_docstring=True)


def _python_comments(source: str) -> Iterator[Text]:
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            yield Text(token.start[0], token.string)


def _toml_comments(source: str) -> Iterator[Text]:
    for number, line in enumerate(source.splitlines(), 1):
        _, mark, comment = re.sub(r"\"[^\"]*\"", "", line).partition("#")
        if mark:
            yield Text(number, comment)


def _blank(found: re.Match[str]) -> str:
    """Return the match with everything but its line breaks blanked, so that line numbers hold."""
    return re.sub(r"[^\n]", " ", found.group())


def _replacement(word: str) -> str:
    return next(say for words, say in REPLACEMENTS.items() if re.fullmatch(words, word, re.IGNORECASE))


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
