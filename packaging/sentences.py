"""Write the sentences of the program for translators, from the calls of `hawk.model.sentences.say`.

``python packaging/sentences.py`` writes ``hawk/web/page/src/messages/drone-en.ftl``; ``--check`` fails when that is out
of date, when a code stands for two texts, or when a language lacks one.
"""

from __future__ import annotations

import argparse
import ast
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from string import Formatter

from hawk.model.sentences import code_of

ROOT = Path(__file__).resolve().parent.parent
MESSAGES = ROOT / "hawk" / "web" / "page" / "src" / "messages"
TARGET = MESSAGES / "drone-en.ftl"
_HEADER = """\
### Sentences of the drone's program in English, in Fluent's syntax. Written by packaging/sentences.py from the program:
### change its sentence and run this again. drone-fr.ftl and its like translate them.

"""
_MESSAGE = re.compile(r"^([a-z][a-z0-9-]*) =(.*(?:\n[ ].*)*)", re.MULTILINE)
_VALUE = re.compile(r"\$([a-z_][a-z0-9_]*)")


@dataclass(frozen=True)
class Said:
    """One call: its code, its English template, and where it stands."""

    code: str
    template: str
    place: str


def calls(root: Path = ROOT) -> Iterator[Said]:
    """Yield each call of `say` below ``hawk``. Raises ValueError for one whose template is not written out."""
    for path in sorted((root / "hawk").rglob("*.py")):
        text = "" if "node_modules" in path.parts else path.read_text("utf-8")
        if "from hawk.model.sentences import" not in text and path != root / "hawk" / "model" / "sentences.py":
            continue
        for node in ast.walk(ast.parse(text)):
            if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Name) or node.func.id != "say":
                continue
            place = f"{path.relative_to(root)}:{node.lineno}"
            if len(node.args) != 1 or not isinstance(node.args[0], ast.Constant):
                raise ValueError(f"{place}: write the template out as one string")
            template = str(node.args[0].value)
            yield Said(code_of(template), template, place)


def english(found: Iterator[Said]) -> dict[str, str]:
    """Return code -> English in Fluent's syntax. Raises ValueError for a code with two texts."""
    texts: dict[str, str] = {}
    for said in found:
        text = fluent(said.template)
        if texts.setdefault(said.code, text) != text:
            raise ValueError(f"{said.place}: {said.code} is another text elsewhere: begin it with other words")
    return dict(sorted(texts.items()))


def fluent(template: str) -> str:
    """Return a template in Fluent's syntax: ``{away:.1f}`` becomes ``{ $away }``."""
    pieces = Formatter().parse(template)
    return "".join(text + ("" if name is None else f"{{ ${name} }}") for text, name, _spec, _conversion in pieces)


def source(texts: dict[str, str]) -> str:
    """Return the file for translators."""
    return _HEADER + "".join(f"{code} = {text}\n" for code, text in texts.items())


def problems(texts: dict[str, str], translation: str) -> list[str]:
    """Return what a language lacks, has too much, or takes other values for."""
    there = {code: set(_VALUE.findall(text)) for code, text in _MESSAGE.findall(translation)}
    wanted = {code: set(_VALUE.findall(text)) for code, text in texts.items()}
    found = [f"{code}: has no words" for code in wanted.keys() - there.keys()]
    found += [f"{code}: no such sentence" for code in there.keys() - wanted.keys()]
    both = wanted.keys() & there.keys()
    found += [f"{code}: takes {sorted(wanted[code])}" for code in both if wanted[code] != there[code]]
    return sorted(found)


def translations() -> dict[str, str]:
    """Return language -> text of its file."""
    return {path.stem[6:]: path.read_text("utf-8") for path in MESSAGES.glob("drone-*.ftl") if path != TARGET}


def main(arguments: list[str] | None = None) -> int:
    """Write or check; return the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("--check", action="store_true", help="change nothing; say what is out of date")
    texts = english(calls())
    if not parser.parse_args(arguments).check:
        TARGET.write_text(source(texts), "utf-8")
    lacks = [f"drone-{name}.ftl: {each}" for name, text in translations().items() for each in problems(texts, text)]
    if TARGET.read_text("utf-8") != source(texts):
        lacks.append(f"{TARGET.name} is out of date: run python packaging/sentences.py")
    print("".join(f"{each}\n" for each in lacks), end="", file=sys.stderr)
    return 1 if lacks else 0


if __name__ == "__main__":
    sys.exit(main())
